//! The command line of `bench`.

use super::{CameraArgs, HowArgs, JsonArg};
use crate::values::{self, Choice};
use std::ffi::OsString;

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

Examples:
  enfilade bench @two-rooms --survey 2 --size 64x36
  enfilade bench scene.glb --method masked --path views.jsonl --size 160x90 --json bench.json")]
pub(crate) struct BenchArgs {
    /// A .glb, .gltf, .obj, .b3dm, .i3dm, .bsp or .enf file, a .json that describes a heightmap, or @NAME for a built-in scene [default: @enfilade]
    #[arg(value_name = "SCENE")]
    pub(crate) scene: Option<OsString>,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten, next_help_heading = "Cameras (default: 16 survey views)")]
    pub(crate) cameras: CameraArgs,
    #[arg(long, value_name = "NAME", help = values::methods(), default_value = "all", help_heading = "Methods", value_parser = values::method)]
    pub(crate) method: Choice,
    #[command(flatten)]
    pub(crate) how: HowArgs,
}
