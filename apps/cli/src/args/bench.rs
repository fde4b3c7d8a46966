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

/// Heading of the options of the microbenchmark.
const MICRO: &str = "Rasterizer benchmark";

/// Options of `bench`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Times are the median of three passes over all views, after one warm-up pass.

Columns:
  build ms         building the method's data, once
  look ms, 99 %    computing the visible set: median over the views, 99th percentile
  order ms         traversal alone, with nothing culled
  draw ms          visible set and picture, shading included
  memory           scene, the method's data, and buffers at this --size
  items, expected  items in the set, and in that of a z-buffer; mean over the views
  verdict          whether every set is as its contract says

Exits with 1 on a false cull of a method that is not approximate, on a hidden item in an exact set, or if a last pass \
returns another set than the first.

Columns of --micro:
  M/s, ns          millions of faces or boxes per second; nanoseconds each
  ms per view      all opaque triangles of SCENE in view, mean of 16 positions
  peer, of peer    best figure known of another culler (AVX-512, another machine), and the ratio
  of ceiling       minimum of bytes the row must touch, as a share of what L1 or L2 delivers
  wrong            samples or boxes that would cull something visible: must be 0, else exits with 1
  loose            samples or boxes kept though hidden: costs time, never correctness

It runs at 1920x1080 on one thread; rows take turns in each round, and the median round counts. The chapter Benchmarks of \
the book defines rows and ceilings.

Examples:
  enfilade bench @two-rooms --survey 2 --size 64x36
  enfilade bench scene.glb --method masked --path views.jsonl --size 160x90 --json bench.json
  enfilade bench --micro --rows tri-1000,rect-hidden-16,rect-visible --rounds 3")]
pub(crate) struct BenchArgs {
    /// A .glb, .gltf, .obj or .bsp file, a .json that describes a heightmap, or @NAME for a built-in scene [default: @enfilade; with --micro: none]
    #[arg(value_name = "SCENE")]
    pub(crate) scene: Option<OsString>,
    /// Measure the rasterizer of `masked` alone, on synthetic faces and boxes, and on the triangles of SCENE if given
    #[arg(long, help_heading = MICRO, conflicts_with_all = OF_PATHS)]
    pub(crate) micro: bool,
    /// Time N rounds
    #[arg(long, help_heading = MICRO, value_name = "N", default_value_t = 15, requires = "micro", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) rounds: u32,
    #[arg(long, help_heading = MICRO, help = values::rows_help(), value_name = "NAME,..", requires = "micro", value_delimiter = ',', value_parser = values::row)]
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
