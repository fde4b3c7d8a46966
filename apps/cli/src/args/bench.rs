//! The command line of `bench`.

use super::{CameraArgs, HowArgs, JsonArg};
use crate::values::{self, Choice};
use std::ffi::OsString;

/// Options that conflict with `--micro`, because its views are fixed.
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
Times are the median of three passes over all views, after one warm-up pass. The visible sets of every method are compared \
with those of a z-buffer, and where they differ with the reference, because contested items may count as visible or hidden; \
a final pass must return the same sets again. Exits with 1 if a method that is not approximate has a false cull, if an exact \
method returns a hidden item, or if two passes of a method differ.

--micro measures the masked depth buffer alone, with the rows of the table that other cullers are compared by: millions of \
faces rasterized, or of boxes tested, per second, at 1920x1080 on one thread, as the median of rounds in which all rows take \
turns; with a SCENE also milliseconds per view for all its opaque triangles in view, from 16 positions. `peer` is the best \
figure of another culler, from another run on a machine with AVX-512. The ceilings are the gigabytes per second that this \
machine reads, changes and writes in a buffer that fits L1 or L2, each byte counted once. `of ceiling` is the share of it \
that the row's minimum of bytes comes to: 16 for each tile of 8x4 samples in which a face has a sample, 4 for each tile that \
a hidden box touches, 4 for a visible box, and 48 for the vertices and indices of a back face. `wrong` counts samples at \
which the buffer is nearer than any face, and boxes culled that may be visible; exits with 1 if there are any. `loose` \
counts samples that are certainly covered but empty in the buffer, and hidden boxes that are kept; these cost time only.

Examples:
  enfilade bench @two-rooms --survey 2 --size 64x36
  enfilade bench scene.glb --method masked --path views.jsonl --size 160x90 --json bench.json
  enfilade bench --micro --rows tri-1000,rect-hidden-16,rect-visible --rounds 3")]
pub(crate) struct BenchArgs {
    /// A .glb, .gltf, .obj or .bsp file, a .json that describes a heightmap, or @NAME for a built-in scene [default: @enfilade; with --micro: none]
    #[arg(value_name = "SCENE")]
    pub(crate) scene: Option<OsString>,
    /// Measure the masked depth buffer alone: faces and boxes per second, as a share of the machine's memory throughput
    #[arg(long, conflicts_with_all = OF_PATHS)]
    pub(crate) micro: bool,
    /// Time N rounds (with --micro)
    #[arg(long, value_name = "N", default_value_t = 15, requires = "micro", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) rounds: u32,
    /// Measure these rows only (with --micro)
    #[arg(long, value_name = "NAME,..", requires = "micro", value_delimiter = ',', value_parser = values::row)]
    pub(crate) rows: Vec<String>,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten, next_help_heading = "Cameras (default: 16 survey views)")]
    pub(crate) cameras: CameraArgs,
    #[arg(long, value_name = "NAME", help = values::methods(), default_value = "all", help_heading = "Methods", value_parser = values::method)]
    pub(crate) method: Choice,
    #[command(flatten)]
    pub(crate) how: HowArgs,
}
