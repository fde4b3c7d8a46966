//! The verb that measures.

use super::{CameraArgs, HowArgs, JsonArg};
use crate::values::{self, Choice};
use std::ffi::OsString;

/// What says nothing to `--micro`.
const OF_PATHS: [&str; 13] = [
    "eye",
    "camera",
    "path",
    "survey",
    "survey_hard",
    "size",
    "fov",
    "up",
    "method",
    "no_coherence",
    "occluders",
    "cover_size",
    "flat",
];

/// Options of `bench`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Times are the median of three passes over all views, after one to warm up. What every method sees is held against what a \
z-buffer sees, and where the two differ against the reference, for what is contested may be told either way; a last pass \
must see the same again. Exit 1 if a method that is not approximate misses anything, if an exact one sees what cannot be \
seen, or if any is not the same twice.

With --micro the masked cover alone is measured, by the rows of the table that other cullers are compared by: millions of \
faces, or of boxes asked about, a second, at 1920x1080 on one thread, the median of rounds in which every row has its turn; \
and with a SCENE milliseconds a view for all its opaque triangles in view from 16 places. `peer` is what the best other \
culler reached on a machine with AVX-512, in another run. The ceilings are the gigabytes a second that this machine reads, \
changes and writes, each byte counted once, in a buffer that fits L1 or L2. `of ceiling` is the share of it that the least \
bytes come to: 16 for each 8x4 samples that a face has any of, 4 for each that a hidden box has any of, 4 for a visible box, \
and the 48 of the corners for a back. `wrong` counts samples at which something is said to be nearer than anything is, and \
boxes called hidden that may be seen; exit 1 if there are any. `loose` counts samples that are certainly covered and not \
known to be, and boxes that are hidden and called visible, which costs time alone.

Examples:
  enfilade bench @two-rooms --survey 2 --size 64x36
  enfilade bench scene.glb --method masked --path views.jsonl --size 160x90 --json bench.json
  enfilade bench --micro --rows tri-1000,rect-hidden-16,rect-visible --rounds 3")]
pub(crate) struct BenchArgs {
    /// A .glb, .gltf, .obj or .bsp file, a .json that describes terrain, or a built-in scene by its @NAME [default: @enfilade, none with --micro]
    #[arg(value_name = "SCENE")]
    pub(crate) scene: Option<OsString>,
    /// Measure the masked cover alone: faces and boxes a second, and how close that is to what the machine can do
    #[arg(long, conflicts_with_all = OF_PATHS)]
    pub(crate) micro: bool,
    /// Rounds that count, with --micro
    #[arg(long, value_name = "N", default_value_t = 15, requires = "micro", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) rounds: u32,
    /// Measure these rows alone, with --micro
    #[arg(long, value_name = "NAME,..", requires = "micro", value_delimiter = ',', value_parser = values::row)]
    pub(crate) rows: Vec<String>,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten, next_help_heading = "Cameras (left out: 16 views of the survey)")]
    pub(crate) cameras: CameraArgs,
    #[arg(long, value_name = "NAME", help = values::methods(), default_value = "all", help_heading = "Methods", value_parser = values::method)]
    pub(crate) method: Choice,
    #[command(flatten)]
    pub(crate) how: HowArgs,
}
