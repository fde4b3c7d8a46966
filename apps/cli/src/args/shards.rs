//! The options of work that several processes or machines share: `--parts`, `--shard` and `--merge`.

use crate::values::{self, Shard};
use std::path::PathBuf;

/// Heading of these options.
pub(super) const SEVERAL_MACHINES: &str = "Several machines";

/// Splits the work into shards, whose results are parts in a folder.
#[derive(Debug, clap::Args)]
pub(crate) struct ShardArgs {
    /// Keep the parts of the work in this folder
    #[arg(long, help_heading = SEVERAL_MACHINES, value_name = "FOLDER")]
    pub(crate) parts: Option<PathBuf>,
    /// Only compute share I of N of the work, and keep it in --parts: 0/4, 1/4, 2/4 or 3/4 for four machines
    #[arg(long, help_heading = SEVERAL_MACHINES, value_name = "I/N", value_parser = values::shard, requires = "parts",
          conflicts_with = "merge")]
    pub(crate) shard: Option<Shard>,
    /// Join the parts of all shards in --parts, and fail if one is missing or not up to date
    #[arg(long, help_heading = SEVERAL_MACHINES, requires = "parts")]
    pub(crate) merge: bool,
}
