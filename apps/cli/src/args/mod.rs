//! The command line: verbs, options and their help.

mod bench;
mod choose;
mod maps;

pub(crate) use bench::BenchArgs;
pub(crate) use choose::ChooseArgs;
pub(crate) use maps::{PortalsArgs, VisArgs};

use crate::values::{self, Choice};
use clap::{Parser, Subcommand};
use enfilade::Method;
use enfilade_draw::Show;
use std::ffi::OsString;
use std::path::PathBuf;

/// Says what can be seen in a scene, and draws it.
///
/// Without a verb: draws the built-in scene @enfilade to enfilade.png and compares the methods on it.
#[derive(Debug, Parser)]
#[command(
    name = "enfilade",
    version,
    after_help = "\
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

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Draws what is seen, as PNG
    Draw(DrawArgs),
    /// Says what is visible, and what it costs to know
    Look(LookArgs),
    /// Shows all methods side by side, on a page of pictures, differences and times
    Compare(CompareArgs),
    /// Times all methods over a path of views, and holds what they see against what is expected
    Bench(BenchArgs),
    /// Finds the method that suits each fragment, and says what each costs there
    Choose(ChooseArgs),
    /// Joins separately exported files by portals
    Link(LinkArgs),
    /// Finds out what is visible in a map of Quake or Quake 3, and writes it into the map
    Vis(VisArgs),
    /// Rebuilds the lost .prt of a compiled Quake map
    Portals(PortalsArgs),
    /// Says what is in a file
    Info(InfoArgs),
}

/// Options of `draw`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Several views are numbered: a-000.png, a-001.png and so on.

Examples:
  enfilade draw -o palace.png --size 320x180
  enfilade draw scene.glb -o picture.png --eye 2,1.5,4 --toward 0,0.5,0 --size 320x180
  enfilade draw @enfilade -o order.png --show order --method hierarchical-z --size 320x180
  enfilade draw @enfilade -o cover.png --show cover --method svbsp --size 320x180
  enfilade draw scene.glb -o walk.png --path views.jsonl --size 320x180 --json walk.json")]
pub(crate) struct DrawArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    /// Where the picture goes; it is written whole or not at all
    #[arg(short, long, value_name = "FILE.png")]
    pub(crate) output: PathBuf,
    /// What the picture shows: image, overdraw, items, order, fragments or cover
    #[arg(long, value_name = "WHAT", default_value = "image", value_parser = values::show)]
    pub(crate) show: Show,
    /// Samples of each pixel: 1, or 4 for smooth edges
    #[arg(long, value_name = "N", default_value = "1", value_parser = values::samples)]
    pub(crate) samples: u32,
    /// Show what lights shine on brighter by so many stops, or darker where it is below 0
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = values::stops, allow_negative_numbers = true)]
    pub(crate) exposure: f32,
    /// Draw large items by coarser levels, made on demand, that are off by no more than so many pixels
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
Times are the median of three passes over all views, after one to warm up.

Examples:
  enfilade look scene.glb --json -
  enfilade look @enfilade --survey 2 --method all --size 320x180
  enfilade look scene.glb --survey 2 --method all --check --size 160x90
  enfilade look scene.glb --path views.jsonl --threads 1 --json looks.json")]
pub(crate) struct LookArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    /// Hold the answers against the reference; exit 1 if anything is missed or painted that no owner allows. With a
    /// number above 1 strict methods are also held to what is seen at that many places by chance in each pixel
    #[arg(long, value_name = "PLACES", num_args = 0..=1, require_equals = true, default_missing_value = "1",
          value_parser = values::check)]
    pub(crate) check: Option<u32>,
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
The page is one file that refers to nothing outside itself. Every method is held against the reference; exit 1 if one \
that is not approximate misses anything or paints what no possible owner allows. Times are the median of three passes \
over all views, after one to warm up.

Examples:
  enfilade compare @two-rooms -o rooms.html --size 160x90
  enfilade compare scene.glb -o yard.html --path views.jsonl --size 160x90 --json yard.json
  enfilade compare scene.glb -o both.html --survey 2 --pictures 1 --size 64x36 --no-coherence")]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    /// Where the page goes; it is written whole or not at all
    #[arg(short, long, value_name = "FILE.html")]
    pub(crate) output: PathBuf,
    /// Views that are shown as pictures; the others are in the numbers
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
WORLD.toml names parts, each a .glb or .gltf file with its place, and portals between them:

  [[part]]
  name = \"house\"                   # its nodes are called house/NAME in the world
  file = \"house.glb\"               # from the folder of WORLD.toml
  [[part]]
  name = \"barn\"
  file = \"barn.glb\"
  translation = [40, 0, 0]         # optional, as are the next two; this comes last
  rotation = { axis = [0, 1, 0], degrees = 90 }
  scale = 1

  [[portal]]                       # a teleport: `to` says where one comes out, and which way
  name = \"gate\"
  from = { part = \"house\", center = [0, 1, 2], ahead = [0, 0, -1], size = [1, 2] }
  to = { part = \"barn\", center = [3, 1, 0], ahead = [1, 0, 0], size = [1, 2] }
  two_way = true                   # then `to` is an opening too
  [[portal]]                       # a door between parts that touch, both ways unless told
  name = \"door\"
  from = { part = \"house\", node = \"Door-portal\" }
  to = { part = \"barn\" }           # and room = \"NAME\" where it has several
  [[portal]]
  name = \"pier-glass\"
  from = { part = \"house\", outline = [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]] }
  mirror = true

Numbers are in the space of the part. Teleports lead one way, doors both, unless two_way says otherwise; a door without \
`to` leads to what stands behind it. An opening is a rectangle that one goes into along `ahead` (with `up` if need be), \
an outline, counter-clockwise seen by one who is about to go in, or a node with a flat mesh: into a teleport one goes \
along its -Z. An exit is a rectangle or a node that one comes out of along its -Z; out of an outline, or of a node with \
two_way, one comes as out of an opening. A part in which no room is marked is one room, PART-room. Parts should not \
stand in each other, unless a door joins them.

Examples:
  enfilade link world.toml -o world.glb
  enfilade link world.toml -o world.glb --json world.json")]
pub(crate) struct LinkArgs {
    /// What is to be joined, and where
    #[arg(value_name = "WORLD.toml")]
    pub(crate) world: PathBuf,
    /// Where the world goes; it is written whole or not at all
    #[arg(short, long, value_name = "FILE.glb")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) json: JsonArg,
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
pub(crate) struct InfoArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten)]
    pub(crate) portals: PortalArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

/// Which scene.
#[derive(Debug, clap::Args)]
pub(crate) struct SceneArg {
    /// A .glb, .gltf, .obj or .bsp file, a .json that describes terrain, or a built-in scene by its @NAME
    #[arg(value_name = "SCENE", default_value = "@enfilade")]
    pub(crate) scene: OsString,
}

/// Where the report goes.
#[derive(Debug, clap::Args)]
pub(crate) struct JsonArg {
    /// Write the report as JSON; `-` is standard output, on which nothing else is printed then
    #[arg(long = "json", value_name = "FILE")]
    pub(crate) file: Option<PathBuf>,
}

impl JsonArg {
    /// Is standard output taken by the report?
    pub(crate) fn takes_stdout(&self) -> bool {
        self.file.as_ref().is_some_and(|file| file.as_os_str() == "-")
    }
}

/// What most verbs say of [`CameraArgs`].
const CAMERAS: &str =
    "Cameras (left out: the file's first camera, else the view of the survey that shows most)";

/// Which views.
#[derive(Debug, clap::Args)]
pub(crate) struct CameraArgs {
    /// Where the eye stands
    #[arg(long, value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true, requires = "toward",
          conflicts_with_all = ["camera", "path", "survey", "survey_hard"])]
    pub(crate) eye: Option<[f32; 3]>,
    /// A point in the middle of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true, requires = "eye")]
    pub(crate) toward: Option<[f32; 3]>,
    /// A camera of the scene
    #[arg(long, value_name = "NAME", conflicts_with_all = ["path", "survey", "survey_hard"])]
    pub(crate) camera: Option<String>,
    /// JSON lines of {"eye":[..],"toward":[..],"up":[..],"fov":60}, the last two optional
    #[arg(long, value_name = "FILE", conflicts_with_all = ["survey", "survey_hard"])]
    pub(crate) path: Option<PathBuf>,
    /// N views from where people may stand, spread over rooms and streets, always the same ones
    #[arg(long, value_name = "N", conflicts_with = "survey_hard", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) survey: Option<u32>,
    /// N views that are hard to decide: in doorways, at corners and edges, in planes of faces
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) survey_hard: Option<u32>,
    /// Columns and rows of the screen
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = values::size)]
    pub(crate) size: [u32; 2],
    /// Vertical angle of the lens [default: the camera's own, else 60]
    #[arg(long, value_name = "DEGREES", value_parser = values::degrees)]
    pub(crate) fov: Option<f32>,
    /// The direction that is upright [default: the camera's own, else 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true)]
    pub(crate) up: Option<[f32; 3]>,
}

impl CameraArgs {
    /// Takes so many views of the survey where no camera is told.
    pub(crate) fn survey_unless_told(&mut self, count: u32) {
        if self.eye.is_none() && self.camera.is_none() && self.path.is_none() && self.survey_hard.is_none() {
            self.survey.get_or_insert(count);
        }
    }
}

/// Which methods look, and how.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Methods")]
pub(crate) struct MethodArgs {
    #[arg(long, value_name = "NAME", help = values::methods_or_own(), value_parser = values::method)]
    method: Option<Choice>,
    #[command(flatten)]
    pub(crate) how: HowArgs,
}

/// What a method may remember, follow and use up.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Methods")]
pub(crate) struct HowArgs {
    /// Forget what the last view saw before each look
    #[arg(long)]
    pub(crate) no_coherence: bool,
    /// Occluders that masked, svbsp and mobsp choose for each passage; 0: none [default: what suits each]
    #[arg(long, value_name = "N")]
    pub(crate) occluders: Option<u32>,
    /// Columns and rows of the covers of hierarchical-z, hierarchical-s and masked, no more than the screen's; fewer
    /// cost less and hide less [default: as many as the screen has]
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    pub(crate) cover_size: Option<[u32; 2]>,
    #[command(flatten)]
    pub(crate) portals: PortalArgs,
    /// Let auto take also methods that may call more visible than is; without it, what is seen does not hang on its choice
    #[arg(long)]
    pub(crate) conservative: bool,
    /// Use no better SIMD instructions than these, which changes the times and nothing else [default: the machine's best]
    #[arg(long, value_name = "LEVEL", value_parser = values::simd)]
    pub(crate) simd: Option<String>,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

/// What becomes of portals.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(crate) struct PortalArgs {
    /// Openings are plain holes: no portal is followed
    #[arg(long)]
    pub(crate) flat: bool,
    #[command(flatten)]
    pub(crate) bad: BadPortalArgs,
}

/// What becomes of portals that make no sense.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(crate) struct BadPortalArgs {
    /// Open a file without the portals and mirrors that are wrong in it, which become plain holes, each with a warning
    #[arg(long = "skip-bad-portals")]
    pub(crate) skip: bool,
}

impl MethodArgs {
    /// Which methods look.
    pub(crate) fn choice(&self) -> Choice {
        self.method.unwrap_or(Choice::Own)
    }
}

/// What may be used up.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Limits")]
pub(crate) struct LimitArgs {
    /// Threads that may be used [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// What reading the file may take, and what each method may: 2GB, 500MB or plain bytes [default: about 1 GB]
    #[arg(long, value_name = "BYTES", value_parser = values::bytes)]
    pub(crate) memory: Option<u64>,
}

impl LimitArgs {
    /// What may be used up of memory by one thing.
    pub(crate) fn memory(&self) -> u64 {
        self.memory.unwrap_or(Method::DEFAULT_LIMIT)
    }
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
    fn every_help_ends_with_examples() {
        let mut root = Args::command();
        let mut helps = vec![root.render_help().to_string()];
        // clap's own `help` stands among the verbs.
        let verbs = root
            .get_subcommands_mut()
            .filter(|verb| verb.get_name() != "help");
        helps.extend(verbs.map(|verb| verb.render_help().to_string()));
        assert_eq!(helps.len(), 10);
        for help in helps {
            let (_, examples) = help.split_once("\nExamples:\n").expect("there are examples");
            assert!(
                examples.lines().all(|line| line.starts_with("  enfilade")),
                "{examples}"
            );
        }
    }
}
