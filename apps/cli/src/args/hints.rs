//! The command line of `hints`.

use super::shards::ShardArgs;
use super::{JsonArg, LimitArgs, MEMORY_TO_LOAD};
use std::path::PathBuf;

/// Options of `hints`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Programs that load a baked scene page by page (enfilade_stream) load first what the hints of the eye's room name, and then \
what may become visible there. Hints never hide anything: what is visible is visible without them too.

In each room, looks in all directions from positions where people could stand find the visible items, until further \
positions find nothing new. A room whose meshes take more than 32 MB is divided into regions, each with hints of its own. \
Pages are read within --memory, and again if it does not hold what is seen from a region: for a town, allow 4GB.

With --parts the hints of each region are written to a file of FOLDER first, unless it is up to date; so an interrupted run \
goes on, and several machines can sample a share each.

Examples:
  enfilade hints town.enf
  enfilade hints town.enf --check 8
  enfilade hints town.enf --parts . --shard 0/2
  enfilade hints town.enf --parts . --shard 1/2
  enfilade hints town.enf --parts . --merge")]
#[command(mut_arg("memory", |arg| arg.help(MEMORY_TO_LOAD)))]
pub(crate) struct HintsArgs {
    /// A baked scene
    #[arg(value_name = "SCENE.enf")]
    pub(crate) scene: PathBuf,
    /// Write the scene with hints to this file (atomically) instead of SCENE.enf
    #[arg(short, long, value_name = "FILE.enf", conflicts_with = "shard")]
    pub(crate) output: Option<PathBuf>,
    /// Look from at most N positions in each region
    #[arg(long, value_name = "N", default_value = "128", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) positions: u32,
    /// Compare the hints with N views from further positions in each region
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000), conflicts_with = "shard")]
    pub(crate) check: Option<u32>,
    #[command(flatten)]
    pub(crate) shards: ShardArgs,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}
