//! The command line of `choose`.

use super::{BadPortalArgs, JsonArg, LimitArgs, SceneArg, UprightArgs};
use crate::values;
use enfilade::ChoiceGoal;
use std::path::PathBuf;

/// Options of `choose`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
How a method is chosen:
  views    32 survey positions per sector, and every view that shows it through openings
  methods  exact ones, or with --conservative all but approximate ones, that suit the sector
           and fit --memory
  cost     time of a look (or of drawing, --aim draw), plus 1/10,000 of the build time
  choice   the lowest cost; of methods at most 12 % slower, the current one, else the one that
           uses the least memory; `unsure` (two halves of the views disagree) keeps the current

`--method auto` of other verbs measures the same way first, but writes nothing.

Examples:
  enfilade choose @enfilade --size 160x90
  enfilade choose scene.glb --aim draw --size 160x90 --check
  enfilade choose scene.glb -o pinned.glb --size 160x90 --json choices.json")]
pub(crate) struct ChooseArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    /// Write a copy of the glTF or heightmap file with the chosen methods in it, which other verbs then use
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Minimize the time to `look` (visible set only) or to `draw` (without shading)
    #[arg(long, value_name = "WHAT", default_value = "look", value_parser = values::aim)]
    pub(crate) aim: ChoiceGoal,
    /// Also consider conservative and strict methods, whose sets may contain hidden items
    #[arg(long)]
    pub(crate) conservative: bool,
    /// Add the cost of moving one item before every look in these sectors
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub(crate) moving: Vec<String>,
    /// Measure again on views that the choice did not use, and compare each choice with the fastest method there
    #[arg(long)]
    pub(crate) check: bool,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    /// Set the screen size, in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = values::size)]
    pub(crate) size: [u32; 2],
    #[command(flatten)]
    pub(crate) upright: UprightArgs,
    #[arg(long, value_name = "LEVEL", help = values::simd_help(), value_parser = values::simd)]
    pub(crate) simd: Option<String>,
    #[command(flatten)]
    pub(crate) bad_portals: BadPortalArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}
