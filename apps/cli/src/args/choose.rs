//! The command line of `choose`.

use super::{BadPortalArgs, JsonArg, LimitArgs, SceneArg};
use crate::values;
use enfilade::ChoiceGoal;
use std::path::PathBuf;

/// Options of `choose`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Measures every eligible method in each sector, from 32 survey positions per sector, also through the openings that show the \
sector from elsewhere. The cost is the time of a look, or of drawing, plus a ten-thousandth of the build time; among equally \
fast methods the one that uses the least memory is chosen. `--method auto` of other verbs runs the same measurement first.

Examples:
  enfilade choose @enfilade --size 160x90
  enfilade choose scene.glb --aim draw --size 160x90 --check
  enfilade choose scene.glb -o pinned.glb --size 160x90 --json choices.json")]
pub(crate) struct ChooseArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    /// Write a copy of the glTF or heightmap file that names the chosen methods, which pins them
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Minimize the time to look or to draw
    #[arg(long, value_name = "WHAT", default_value = "look", value_parser = values::aim)]
    pub(crate) aim: ChoiceGoal,
    /// Also consider conservative methods, whose sets may contain hidden items
    #[arg(long)]
    pub(crate) conservative: bool,
    /// Expect an item to move before every look in these sectors
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub(crate) moving: Vec<String>,
    /// Measure again on other views, and print how far each choice is from the fastest method there
    #[arg(long)]
    pub(crate) check: bool,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    /// Set the screen size, in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = values::size)]
    pub(crate) size: [u32; 2],
    /// Use this SIMD level; changes the times only [default: the machine's best]
    #[arg(long, value_name = "LEVEL", value_parser = values::simd)]
    pub(crate) simd: Option<String>,
    #[command(flatten)]
    pub(crate) bad_portals: BadPortalArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}
