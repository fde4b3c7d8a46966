//! Options of `rooms`.

use super::{FileArgs, JsonArg, LimitArgs, SceneArg};
use crate::values;
use clap::ValueEnum;
use enfilade_bake::Up;
use std::path::PathBuf;

/// Help of `--memory`.
const MEMORY_OF_ROOMS: &str =
    "Limit the memory for reading the file, and for voxels: with less, they are larger";

/// Options of `rooms`.
#[derive(Debug, clap::Args)]
#[command(mut_arg("memory", |arg| arg.help(MEMORY_OF_ROOMS)))]
#[command(after_help = "\
Rooms are found in the triangles: walls, slabs, panes and closed doors separate them. Where the file marks rooms and portals, \
these are the rooms, and the outlines of the doors.

A door can be opened if the file animates it, if its extras say {\"enfilade\": {\"kind\": \"door\"}}, or if its name says so. Without names, items that look like closed doors are suggested; name them with \
--doors, and they become doors.

The JSON file is the graph of rooms and doors that RoomGraph of the crate enfilade_bake reads, with the names of items \
added. Coordinates in it are those of the scene.

Examples:
  enfilade rooms scene.glb
  enfilade rooms scene.glb -o rooms.json --html plan.html
  enfilade rooms scene.glb --up y --scale 1 --doors gate,shutter
  enfilade rooms @house --flat --html house.html --json -")]
pub(crate) struct RoomsArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    /// Write the graph of rooms and doors to this file (atomically)
    #[arg(short, long, value_name = "FILE.json")]
    pub(crate) output: Option<PathBuf>,
    /// Write a page with the floor plan of each storey to this file (atomically)
    #[arg(long, value_name = "FILE.html")]
    pub(crate) html: Option<PathBuf>,
    /// Take this axis as up [default: y in glTF files and maps, otherwise the one that floors face]
    #[arg(long, value_name = "AXIS")]
    pub(crate) up: Option<UpArg>,
    /// Take a scene unit as this many metres [default: 0.0254 in Quake maps, otherwise 1, or what makes rooms as high as rooms
    /// are]
    #[arg(long, alias = "unit", value_name = "METRES", value_parser = values::unit)]
    pub(crate) scale: Option<f64>,
    /// Let items be doors whose names contain one of these words [default: door, gate and so on, in five languages]
    #[arg(long, value_name = "WORD,..", value_delimiter = ',')]
    pub(crate) doors: Vec<String>,
    /// Use no names: doors are then only suggested
    #[arg(long, conflicts_with = "doors")]
    pub(crate) no_names: bool,
    /// Find all rooms, also where the scene marks some
    #[arg(long)]
    pub(crate) flat: bool,
    /// Set the side of a voxel; walls and gaps smaller than this may be missed
    #[arg(long, value_name = "METRES", default_value = "0.1", value_parser = values::metres)]
    pub(crate) voxel: f64,
    #[command(flatten)]
    pub(crate) read: FileArgs,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub(crate) enum UpArg {
    X,
    Y,
    Z,
}

impl From<UpArg> for Up {
    fn from(arg: UpArg) -> Up {
        match arg {
            UpArg::X => Up::X,
            UpArg::Y => Up::Y,
            UpArg::Z => Up::Z,
        }
    }
}
