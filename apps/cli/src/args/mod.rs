//! The command line: verbs, options and their help.

mod bench;
mod choose;
mod hints;
mod maps;
mod rooms;
mod shards;

pub(crate) use bench::BenchArgs;
pub(crate) use choose::ChooseArgs;
pub(crate) use hints::HintsArgs;
pub(crate) use maps::{PortalsArgs, VisArgs};
pub(crate) use rooms::RoomsArgs;
pub(crate) use shards::ShardArgs;

use crate::values::{self, Choice};
use clap::{ArgGroup, Parser, Subcommand};
use enfilade::Tightness;
use enfilade_draw::Show;
use enfilade_import::ReadOptions;
use std::ffi::OsString;
use std::path::PathBuf;

/// Computes what is visible in a 3D scene, verifies it and draws it.
///
/// Without a verb, draws the built-in scene @enfilade to enfilade.png and compares all methods on it.
#[derive(Debug, Parser)]
#[command(
    name = "enfilade",
    version,
    after_help = "\
Exits with 0 on success, 1 if a check fails, and 2 on an error.

Examples:
  enfilade
  enfilade look @enfilade --survey 2 --size 320x180
  enfilade draw scene.glb -o picture.png --size 320x180
  enfilade compare @two-rooms -o rooms.html --size 160x90
  enfilade info scene.glb"
)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) verb: Option<Verb>,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Draw views as PNG
    Draw(DrawArgs),
    /// Print the visible items of each view, and what computing them costs
    Look(LookArgs),
    /// Compare all methods side by side, on an HTML page of pictures, differences and times
    Compare(CompareArgs),
    /// Time all methods over a list of views, and check their visible sets
    Bench(BenchArgs),
    /// Measure which method is fastest in each sector
    Choose(ChooseArgs),
    /// Join separately exported glTF files by portals
    Link(LinkArgs),
    /// Compute the PVS of a Quake or Quake 3 map, and write it into the map
    Vis(VisArgs),
    /// Rebuild the lost .prt of a compiled Quake map
    Portals(PortalsArgs),
    /// Find the rooms, doors and windows of a building, and draw its floor plans
    Rooms(RoomsArgs),
    /// Walk through a scene in a window, freeze what is visible, and see why things are hidden
    #[command(disable_help_flag = true)]
    View(ViewArgs),
    /// Bake a scene into a file that opens at once
    Bake(BakeArgs),
    /// Sample what is seen from the rooms of a baked scene, so that it can be loaded before it is visible
    Hints(HintsArgs),
    /// Print the contents of a scene file
    Info(InfoArgs),
}

/// Options of `bake`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A baked scene (.enf) holds what importing computes: meshes with their clusters and trees, rooms, portals, baked cells, \
materials, images, cameras and lights. Every verb that reads scenes reads it too, maps it into memory and uses the meshes \
in place. Do not write to it while a program has it open; bake replaces it as a whole. The same scene gives the same \
bytes.

Several files are tiles of one world, read one after another: those of one room join in one room, and names get the name \
of their tile, as in TILE/NAME. With --parts each tile is baked into FOLDER/TILE.enf first, unless that was baked from the \
same files before; so an interrupted run goes on, after an edit only the edited tiles are baked again, and several \
machines can bake a share each. --merge bakes no tile. The world has the same bytes whichever way it is baked.

Examples:
  enfilade bake scene.glb -o scene.enf
  enfilade bake map.bsp -o map.enf
  enfilade bake scene.glb map.bsp -o world.enf
  enfilade bake scene.glb map.bsp --parts . --shard 0/2
  enfilade bake scene.glb map.bsp --parts . -o world.enf
  enfilade info world.enf")]
#[command(mut_arg("memory", |arg| arg.help(MEMORY_TO_READ)))]
#[command(mut_arg("shard", |arg| arg.conflicts_with("output")))]
#[command(mut_arg("merge", |arg| arg.requires("output")))]
pub(crate) struct BakeArgs {
    /// Scenes: .glb, .gltf, .obj, .b3dm, .i3dm, .bsp or .enf files, .json that describe heightmaps, or @NAME for a built-in scene
    #[arg(value_name = "SCENE", required = true)]
    pub(crate) scenes: Vec<OsString>,
    /// Write the baked scene to this file (atomically)
    #[arg(short, long, value_name = "FILE.enf", required_unless_present = "shard")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) shards: ShardArgs,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    /// Read the file as one room with plain holes for openings
    #[arg(long)]
    pub(crate) flat: bool,
    #[command(flatten)]
    pub(crate) bad: BadPortalArgs,
    #[command(flatten)]
    pub(crate) read: FileArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

/// Options of `view`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  enfilade view
  enfilade view scene.glb
  enfilade view scene.glb --screenshot picture.png --freeze --above
  enfilade view scene.glb --web
  enfilade view --help")]
pub(crate) struct ViewArgs {
    /// A scene, and options of the viewer; `enfilade view --help` lists them
    #[arg(value_name = "ARGUMENTS", trailing_var_arg = true, allow_hyphen_values = true)]
    pub(crate) arguments: Vec<OsString>,
}

/// Options of `draw`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Pictures of several views are numbered: a-000.png, a-001.png and so on.

Examples:
  enfilade draw -o palace.png --size 320x180
  enfilade draw scene.glb -o picture.png --eye 2,1.5,4 --toward 0,0.5,0 --size 320x180
  enfilade draw @enfilade -o order.png --show order --method hierarchical-z --size 320x180
  enfilade draw @enfilade -o cover.png --show cover --method svbsp --size 320x180
  enfilade draw scene.glb -o walk.png --path views.jsonl --size 320x180 --json walk.json")]
pub(crate) struct DrawArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    /// Write the picture to this file (atomically)
    #[arg(short, long, value_name = "FILE.png")]
    pub(crate) output: PathBuf,
    /// Show the image, overdraw (faces tested per sample), items or sectors (one colour each), order (of traversal: blue
    /// first, red last) or cover (the occlusion buffer)
    #[arg(long, value_name = "WHAT", default_value = "image", value_parser = values::show)]
    pub(crate) show: Show,
    /// Omit the legend below pictures other than the image
    #[arg(long)]
    pub(crate) no_legend: bool,
    /// Take N samples per pixel: 1, or 4 for smooth edges
    #[arg(long, value_name = "N", default_value = "1", value_parser = values::samples)]
    pub(crate) samples: u32,
    /// Let lights cast hard shadows. A scene without lights gets a sun
    #[arg(long)]
    pub(crate) shadows: bool,
    /// Darken corners (ambient occlusion) by N rays per pixel, up to 1024; 32 show them, 128 are smooth. Takes long
    #[arg(long, value_name = "N", default_value = "0", value_parser = values::rays)]
    pub(crate) ambient_occlusion: u32,
    /// Brighten lit surfaces by this many stops of exposure; below 0 darkens them
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = values::stops, allow_negative_numbers = true)]
    pub(crate) exposure: f32,
    /// Render with LODs, built on demand, whose geometric error stays below this many pixels; not with --json, whose
    /// times are those of the scene at full detail
    #[cfg_attr(
        not(feature = "levels"),
        doc = "(not in this build: it needs `--features levels` and a C++ compiler)"
    )]
    #[arg(long, value_name = "PIXELS", value_parser = values::pixels, conflicts_with = "file")]
    pub(crate) levels: Option<f32>,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten, next_help_heading = CAMERAS)]
    pub(crate) cameras: CameraArgs,
    #[command(flatten)]
    pub(crate) methods: MethodArgs,
}

/// Options of `look`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Times are the median of three passes over all views, after one warm-up pass.

--check compares every view with the reference: an independent ray caster in double precision that knows nothing of the \
methods. A false cull is a visible item that is missing from the set; a wrong pixel shows a face that is not the nearest \
there. Samples at which coplanar faces or rounding leave several answers are contested, and any of these is accepted.

Several machines: `--shard I/N` checks every N-th view, from view I on, with new viewers for each, so a view does not depend \
on the one before. Its part is a report of what is the same on every machine: false culls, wrong pixels, counts; no times. \
`--merge` makes one report of the parts of all N shards, with the same bytes as the report of --shard 0/1.

Examples:
  enfilade look scene.glb --json -
  enfilade look @enfilade --survey 2 --method all --size 320x180
  enfilade look scene.glb --survey 2 --method all --check --size 160x90
  enfilade look scene.glb --path views.jsonl --threads 1 --json looks.json
  enfilade look scene.glb --survey 4 --check --size 160x90 --parts . --shard 0/2
  enfilade look scene.glb --survey 4 --check --size 160x90 --parts . --shard 1/2
  enfilade look scene.glb --parts . --merge --json all.json")]
#[command(group = ArgGroup::new("share").args(["shard", "merge"]))]
#[command(mut_arg("parts", |arg| arg.requires("share")))]
#[command(mut_arg("shard", |arg| arg.requires("check")))]
#[command(mut_arg("merge", |arg| arg.conflicts_with_all(
    ["check", "eye", "camera", "path", "survey", "survey_hard", "method"]
)))]
pub(crate) struct LookArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    /// Compare with the reference (an independent ray caster), and exit with 1 on any false cull or wrong pixel; strict
    /// methods also at SAMPLES random positions per pixel, if that is 2 to 64
    #[arg(long, value_name = "SAMPLES", num_args = 0..=1, require_equals = true, default_missing_value = "1",
          value_parser = values::check)]
    pub(crate) check: Option<u32>,
    /// List the items that hide nothing, or not with all faces, and why
    #[arg(long, conflicts_with_all = ["shard", "merge"])]
    pub(crate) non_occluders: bool,
    #[command(flatten)]
    pub(crate) shards: ShardArgs,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten, next_help_heading = CAMERAS)]
    pub(crate) cameras: CameraArgs,
    #[command(flatten)]
    pub(crate) methods: MethodArgs,
}

/// Options of `compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The page is one self-contained file. Every method is compared with the reference, an independent ray caster. Exits with 1 \
if a method that is not approximate has a false cull (a visible item missing from the set) or a wrong pixel. Times are the \
median of three passes over all views, after one warm-up pass.

Examples:
  enfilade compare @two-rooms -o rooms.html --size 160x90
  enfilade compare scene.glb -o yard.html --path views.jsonl --size 160x90 --json yard.json
  enfilade compare scene.glb -o both.html --survey 2 --pictures 1 --size 64x36 --no-coherence")]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    /// Write the page to this file (atomically)
    #[arg(short, long, value_name = "FILE.html")]
    pub(crate) output: PathBuf,
    /// Show pictures of the first N views, and numbers only of the others
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub(crate) pictures: usize,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten, next_help_heading = CAMERAS)]
    pub(crate) cameras: CameraArgs,
    #[arg(long, value_name = "NAME", help = values::methods(), default_value = "all", help_heading = "Methods", value_parser = values::method)]
    pub(crate) method: Choice,
    #[command(flatten)]
    pub(crate) how: HowArgs,
}

/// Options of `link`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
WORLD.toml lists parts, each a .glb or .gltf file with a transform, and the portals between them:

  [[part]]
  name = \"house\"                   # its nodes are called house/NAME in the world
  file = \"house.glb\"               # relative to the folder of WORLD.toml
  [[part]]
  name = \"barn\"
  file = \"barn.glb\"
  translation = [40, 0, 0]         # optional, as are rotation and scale; applied last
  rotation = { axis = [0, 1, 0], degrees = 90 }
  scale = 1

  [[portal]]                       # a teleport: `to` is the exit, and its direction
  name = \"gate\"
  from = { part = \"house\", center = [0, 1, 2], ahead = [0, 0, -1], size = [1, 2] }
  to = { part = \"barn\", center = [3, 1, 0], ahead = [1, 0, 0], size = [1, 2] }
  two_way = true                   # the exit is an opening too
  [[portal]]                       # a door between parts that touch, two-way by default
  name = \"door\"
  from = { part = \"house\", node = \"Door-portal\" }
  to = { part = \"barn\" }           # add room = \"NAME\" if it has several
  [[portal]]
  name = \"pier-glass\"
  from = { part = \"house\", outline = [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]] }
  mirror = true

Coordinates are in the space of the part. A part without marked rooms becomes one room, PART-room.
Parts should not overlap unless a door joins them.

Directions:
  teleport       one-way, unless two_way = true
  door           two-way, unless two_way = false; without `to` it leads to the room behind it

An opening (`from`) is one of:
  a rectangle    center, ahead, size, and up if that is not +Y; entered along ahead
  an outline     a flat convex polygon, counter-clockwise seen from the side of entry
  a node         its flat mesh; the node of a teleport is entered along its -Z

An exit (`to`) is one of:
  a rectangle    left along ahead
  a node         left along its -Z
  an outline, or a node with two_way: left against its direction of entry

Examples:
  enfilade link world.toml -o world.glb
  enfilade link world.toml -o world.glb --json world.json")]
#[command(mut_arg("memory", |arg| arg.help(MEMORY_TO_READ)))]
pub(crate) struct LinkArgs {
    /// World description: the parts and their portals
    #[arg(value_name = "WORLD.toml")]
    pub(crate) world: PathBuf,
    /// Write the world to this file (atomically)
    #[arg(short, long, value_name = "FILE.glb")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten)]
    pub(crate) read: FileArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

/// Options of `info`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  enfilade info scene.glb
  enfilade info scene.obj
  enfilade info map.bsp
  enfilade info scene.glb --flat
  enfilade info @enfilade --json -")]
#[command(mut_arg("memory", |arg| arg.help(MEMORY_TO_READ)))]
pub(crate) struct InfoArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten)]
    pub(crate) upright: UprightArgs,
    #[command(flatten)]
    pub(crate) portals: PortalArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

/// Selects the scene.
#[derive(Debug, clap::Args)]
pub(crate) struct SceneArg {
    /// A .glb, .gltf, .obj, .b3dm, .i3dm, .bsp or .enf file, a .json that describes a heightmap, or @NAME for a built-in scene
    #[arg(value_name = "SCENE", default_value = "@enfilade")]
    pub(crate) scene: OsString,
}

/// Selects the destination of the report.
#[derive(Debug, clap::Args)]
pub(crate) struct JsonArg {
    /// Write the report as JSON; `-` writes to standard output instead of the text
    #[arg(long = "json", value_name = "FILE")]
    pub(crate) file: Option<PathBuf>,
}

impl JsonArg {
    /// Whether the report goes to standard output, so that nothing else may be printed there.
    pub(crate) fn takes_stdout(&self) -> bool {
        self.file.as_ref().is_some_and(|file| file.as_os_str() == "-")
    }
}

/// Heading of [`CameraArgs`] in the help of most verbs.
const CAMERAS: &str = "Cameras (default: the file's first camera, else the most telling survey view)";

/// Selects the views.
#[derive(Debug, clap::Args)]
pub(crate) struct CameraArgs {
    /// Place the camera here, in scene units
    #[arg(long, value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true, requires = "toward",
          conflicts_with_all = ["camera", "path", "survey", "survey_hard"])]
    pub(crate) eye: Option<[f32; 3]>,
    /// Point the camera at this position
    #[arg(long, value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true, requires = "eye")]
    pub(crate) toward: Option<[f32; 3]>,
    /// Use this camera of the scene; `info` lists them
    #[arg(long, value_name = "NAME", conflicts_with_all = ["path", "survey", "survey_hard"])]
    pub(crate) camera: Option<String>,
    /// Read views from JSON lines of {"eye":[..],"toward":[..],"up":[..],"fov":60}; up and fov are optional
    #[arg(long, value_name = "FILE", conflicts_with_all = ["survey", "survey_hard"])]
    pub(crate) path: Option<PathBuf>,
    /// Generate N views where people can stand, spread over rooms and open areas; always the same ones
    #[arg(long, value_name = "N", conflicts_with = "survey_hard", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) survey: Option<u32>,
    /// Generate N views that are hard to decide: in doorways, at corners and edges, in planes of faces
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) survey_hard: Option<u32>,
    /// Set the screen size, in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = values::size)]
    pub(crate) size: [u32; 2],
    /// Set the vertical field of view, in degrees [default: the camera's, else 60]
    #[arg(long, value_name = "DEGREES", value_parser = values::degrees)]
    pub(crate) fov: Option<f32>,
    /// Use a parallel (orthographic) projection that shows HEIGHT scene units from bottom to top; its near plane contains the eye
    #[arg(long, value_name = "HEIGHT", value_parser = values::height, conflicts_with = "fov")]
    pub(crate) parallel: Option<f64>,
    #[command(flatten)]
    pub(crate) upright: UprightArgs,
}

/// Says which way is up, and how long a unit is.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(crate) struct UprightArgs {
    /// Take this direction as up, for cameras and the survey: x, y, z, -x, -y, -z or X,Y,Z [default: the camera's, else the
    /// axis that the floors of an OBJ file face, else y]
    #[arg(long, value_name = "AXIS", value_parser = values::up, allow_hyphen_values = true)]
    pub(crate) up: Option<[f32; 3]>,
    /// Take a scene unit as m, cm, mm, ft, in or a number of metres, for the survey [default: 1 m, or what makes rooms as high
    /// as rooms are]
    #[arg(long, value_name = "UNIT", value_parser = values::unit)]
    pub(crate) unit: Option<f64>,
}

impl CameraArgs {
    /// Selects `count` survey views if no camera option is given.
    pub(crate) fn survey_by_default(&mut self, count: u32) {
        if self.eye.is_none() && self.camera.is_none() && self.path.is_none() && self.survey_hard.is_none() {
            self.survey.get_or_insert(count);
        }
    }
}

/// Selects the methods, and their options.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Methods")]
pub(crate) struct MethodArgs {
    #[arg(long, value_name = "NAME", help = values::methods_or_own(), value_parser = values::method)]
    method: Option<Choice>,
    #[command(flatten)]
    pub(crate) how: HowArgs,
}

/// Options of all methods.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Methods")]
pub(crate) struct HowArgs {
    /// Disable temporal coherence: forget the previous view before each look
    #[arg(long)]
    pub(crate) no_coherence: bool,
    #[arg(long, value_name = "N", help = values::occluders_help())]
    pub(crate) occluders: Option<u32>,
    #[arg(long, value_name = "WxH", help = values::cover_size_help(), value_parser = values::size)]
    pub(crate) cover_size: Option<[u32; 2]>,
    /// What `masked` tests at the end: boxes, also faces, or faces at exact depths (resolved). Each leaves fewer hidden items
    /// in the set than the one before, and takes longer
    #[arg(long, value_enum, default_value = "boxes")]
    pub(crate) tightness: TightnessArg,
    #[command(flatten)]
    pub(crate) portals: PortalArgs,
    /// Let --method auto also consider conservative and strict methods, whose sets may contain hidden items
    #[arg(long)]
    pub(crate) conservative: bool,
    #[arg(long, value_name = "LEVEL", help = values::simd_help(), value_parser = values::simd)]
    pub(crate) simd: Option<String>,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
pub(crate) enum TightnessArg {
    Boxes,
    Faces,
    Resolved,
}

impl From<TightnessArg> for Tightness {
    fn from(arg: TightnessArg) -> Tightness {
        match arg {
            TightnessArg::Boxes => Tightness::Boxes,
            TightnessArg::Faces => Tightness::Faces,
            TightnessArg::Resolved => Tightness::Resolved,
        }
    }
}

/// Controls how a file is read, and how portals are followed.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct PortalArgs {
    /// Follow no portals: read a file as one room with plain holes for openings; in a built-in or baked scene, stay in the
    /// camera's room
    #[arg(long)]
    pub(crate) flat: bool,
    #[command(flatten)]
    pub(crate) bad: BadPortalArgs,
    #[command(flatten)]
    pub(crate) file: FileArgs,
}

/// Controls what of a glTF file is read.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct FileArgs {
    /// Read this scene of a glTF file, by name or index, instead of its default scene
    #[arg(long = "scene", value_name = "NAME|INDEX")]
    pub(crate) scene_of_file: Option<String>,
    /// Read a glTF file that requires unsupported extensions, as far as possible; what these may change hides nothing
    #[arg(long)]
    pub(crate) lenient: bool,
}

impl FileArgs {
    /// Returns the options to read a file with.
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            scene: self.scene_of_file.clone(),
            lenient: self.lenient,
            ..ReadOptions::default()
        }
    }
}

/// Controls how invalid portals are handled.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(crate) struct BadPortalArgs {
    /// Turn invalid portals and mirrors of a file into plain holes, with a warning each, instead of refusing the file
    #[arg(long = "skip-bad-portals")]
    pub(crate) skip: bool,
}

impl MethodArgs {
    /// Returns the selected methods.
    pub(crate) fn choice(&self) -> Choice {
        self.method.unwrap_or(Choice::Own)
    }
}

/// Limits of threads and memory.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Limits")]
pub(crate) struct LimitArgs {
    /// Use N threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    #[command(flatten)]
    pub(crate) memory: MemoryArg,
}

impl LimitArgs {
    /// Returns the memory limit for reading a file, and for each method, in bytes.
    pub(crate) fn memory(&self) -> u64 {
        self.memory.bytes
    }
}

/// Help of `--memory` in verbs that only read a scene.
const MEMORY_TO_READ: &str = "Limit the memory for reading a file; 1GB is 10^9 bytes, 1GiB is 2^30";

/// Help of `--memory` in `hints`.
const MEMORY_TO_LOAD: &str = "Limit the memory for meshes; 1GB is 10^9 bytes, 1GiB is 2^30";

/// Limits the memory.
#[derive(Debug, clap::Args)]
pub(crate) struct MemoryArg {
    /// Limit the memory for reading the file, and for what each method builds in a sector; 1GB is 10^9 bytes, 1GiB is
    /// 2^30
    #[arg(id = "memory", long, value_name = "BYTES", default_value = "1GB", value_parser = values::bytes)]
    pub(crate) bytes: u64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_makes_sense() {
        Args::command().debug_assert();
    }

    #[test]
    fn the_memory_limit_is_that_of_the_library() {
        let args = Args::parse_from(["enfilade", "look"]);
        let Some(Verb::Look(look)) = args.verb else {
            panic!("`look` is a verb")
        };
        assert_eq!(look.methods.how.limits.memory(), enfilade::Method::DEFAULT_LIMIT);
    }

    #[test]
    fn every_help_ends_with_examples() {
        let mut root = Args::command();
        let mut helps = vec![root.render_help().to_string()];
        // clap adds its `help` to the verbs.
        let verbs = root
            .get_subcommands_mut()
            .filter(|verb| verb.get_name() != "help");
        helps.extend(verbs.map(|verb| verb.render_help().to_string()));
        assert_eq!(helps.len(), 14);
        for help in helps {
            let (_, examples) = help.split_once("\nExamples:\n").expect("there are examples");
            assert!(
                examples.lines().all(|line| line.starts_with("  enfilade")),
                "{examples}"
            );
        }
    }
}
