//! The command line of `choose`.

use super::{BadPortalArgs, JsonArg, LimitArgs, SceneArg};
use crate::values;
use enfilade::ChoiceGoal;
use std::path::PathBuf;

/// Options of `choose`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Every method that may be taken is tried in each sector, alone, from eight places in each and through the openings by which \
it is seen from there. What counts is the time of a look, or of drawing, and a ten-thousandth of the time to build; of \
methods that are as fast, the one that takes least memory is taken. `--method auto` of other verbs does the same first.

Examples:
  enfilade choose @enfilade --size 160x90
  enfilade choose scene.glb --aim draw --size 160x90 --check
  enfilade choose scene.glb -o pinned.glb --size 160x90 --json choices.json")]
pub(crate) struct ChooseArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArg,
    /// Write a copy of the scene's file, of glTF or of terrain, that names the chosen methods, and so pins them
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// What is to be cheap: look or draw
    #[arg(long, value_name = "WHAT", default_value = "look", value_parser = values::aim)]
    pub(crate) aim: ChoiceGoal,
    /// Take also methods that may call more visible than is; without it, what is seen does not hang on the choice
    #[arg(long)]
    pub(crate) conservative: bool,
    /// Sectors in which an item moves between any two looks
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    pub(crate) moving: Vec<String>,
    /// Measure again on other views, and say how far from the best the choice is there
    #[arg(long)]
    pub(crate) check: bool,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    /// Columns and rows of the screen
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = values::size)]
    pub(crate) size: [u32; 2],
    /// Use no better SIMD instructions than these, which changes the times and nothing else [default: the machine's best]
    #[arg(long, value_name = "LEVEL", value_parser = values::simd)]
    pub(crate) simd: Option<String>,
    #[command(flatten)]
    pub(crate) bad_portals: BadPortalArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}
