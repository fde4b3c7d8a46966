//! The command lines of `vis` and `portals`, for maps of Quake and Quake 3.

use super::shards::SEVERAL_MACHINES;
use super::{JsonArg, LimitArgs, MEMORY_TO_READ, MemoryArg, ShardArgs};
use crate::values;
use clap::ArgGroup;
use enfilade_import::AmbientSounds;
use std::path::PathBuf;

/// Headings of groups of options of `vis`.
const LONG: &str = "Long runs";
const TESTS: &str = "Verification";
const SOUNDS: &str = "Ambient sounds (Quake)";

/// Help of `--memory` of `vis`.
const MEMORY_OF_VIS: &str = "Limit the memory of the computation, estimated before it starts, and twice the size of \
                             the map; 1GB is 10^9 bytes, 1GiB is 2^30";

/// Options of `vis`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Input: a map in BSP29 or BSP2 (Quake) or IBSP46 (Quake 3), and its portals in PRT1, PRT2 or the format of Quake 3 \
compilers. For a .prt in place of the map, prints a report only; clusters are counted from 0.

Output: a conservative and symmetric PVS, the same for any number of threads, whether or not the run was interrupted. Leafs \
of Quake maps also get the ambient sound levels of water, sky and lava, by texture names, else by contents. Nothing else in the \
map moves, so absolute offsets into it, such as those of BSPX blocks, stay right.

Interrupted runs: the work so far is saved at intervals, at Ctrl-C and when --seconds are over, in MAP.bsp.vis-unfinished \
and MAP.bsp.vis-passages, beside the map that is written. --resume continues from there; a run that completes removes both.

Several machines: `--shard I/N` computes share I of N of the portal flow, the longest part of large maps, and keeps what it \
finds in --parts. `--merge` takes the parts of all N shards, computes the rest, and writes the same map as a run on one \
machine. All of them need what is computed before the flow: `--prepare` computes it once, and keeps it in --parts, too; \
without it, the first that gets there does. A killed run goes on with --resume. The shards do not share what they find, so \
for maps that take less than minutes one machine is faster.

Options of other compilers work with one hyphen (-fast, -threads 2, -noambient) or are ignored with a note.

Examples:
  enfilade vis map.bsp
  enfilade vis map.bsp -o copy.bsp --json -
  enfilade vis map.bsp --prt other-name.prt --fast
  enfilade vis map.bsp --seconds 600
  enfilade vis map.bsp --resume
  enfilade vis map.bsp --parts . --prepare
  enfilade vis map.bsp --parts . --shard 0/2
  enfilade vis map.bsp --parts . --shard 1/2
  enfilade vis map.bsp --parts . --merge
  enfilade vis map.bsp -o copy.bsp --compare shipped.bsp --check=20000000")]
#[command(mut_arg("memory", |arg| arg.help(MEMORY_OF_VIS)))]
#[command(group = ArgGroup::new("share").args(["shard", "merge", "prepare"]))]
#[command(mut_arg("parts", |arg| arg.requires("share")))]
#[command(mut_arg("shard", |arg| arg.conflicts_with_all(["output", "no_backup", "fast", "seconds", "check", "compare"])))]
#[command(mut_arg("merge", |arg| arg.conflicts_with("fast")))]
pub(crate) struct VisArgs {
    /// Compiled map; the PVS is written into it (atomically), and the old map is kept once as MAP.bsp.bak
    #[arg(value_name = "MAP.bsp")]
    pub(crate) map: PathBuf,
    /// Write a copy of the map, and leave the map unchanged
    #[arg(short, long, value_name = "OTHER.bsp")]
    pub(crate) output: Option<PathBuf>,
    /// Keep no copy of a map that is overwritten
    #[arg(long)]
    pub(crate) no_backup: bool,
    /// Read the portals from this file [default: NAME.prt beside NAME.bsp or NAME.novis.bsp]
    #[arg(long, value_name = "FILE.prt")]
    pub(crate) prt: Option<PathBuf>,
    /// Stop at a quick upper bound: two to eight times as fast, up to twice as many visible pairs
    #[arg(long)]
    pub(crate) fast: bool,
    #[command(flatten)]
    pub(crate) ambient: AmbientArgs,
    /// Stop after N seconds and write the upper bound reached, which hides nothing visible; --resume continues
    #[arg(long, help_heading = LONG, value_name = "N", value_parser = values::seconds)]
    pub(crate) seconds: Option<f64>,
    /// Print no progress: neither a bar nor a line every ten seconds
    #[arg(long, help_heading = LONG)]
    pub(crate) quiet: bool,
    /// Continue a run that was stopped or killed, from its last save
    #[arg(long, help_heading = LONG)]
    pub(crate) resume: bool,
    /// Save unfinished work at this interval [default: 2 % of the run so far, at least ten times the time of a save]
    #[arg(long, help_heading = LONG, value_name = "SECONDS", value_parser = values::seconds)]
    pub(crate) save_every: Option<f64>,
    #[command(flatten)]
    pub(crate) shards: ShardArgs,
    /// Only compute what all shards begin with, and keep it in --parts
    #[arg(long, help_heading = SEVERAL_MACHINES, requires = "parts",
          conflicts_with_all = ["output", "no_backup", "fast", "seconds", "check", "compare"])]
    pub(crate) prepare: bool,
    /// Test the PVS with random lines of sight through the portals [LINES: 1000000]. A line from cluster to cluster
    /// proves that the pair is visible; if the PVS lacks it, print the line, write nothing and exit with 1
    #[arg(long, help_heading = TESTS, value_name = "LINES", num_args = 0..=1, require_equals = true, default_missing_value = "1000000")]
    pub(crate) check: Option<u64>,
    /// Compare with another PVS of the same map: list the pairs it misses, with a line of sight where one is found, and
    /// its extra pairs
    #[arg(long, help_heading = TESTS, value_name = "OTHER.bsp")]
    pub(crate) compare: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

/// Selects the ambient sounds to write.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct AmbientArgs {
    /// Leave the ambient sound levels of leafs unchanged (also -noambient)
    #[arg(long = "no-ambient", help_heading = SOUNDS)]
    pub(crate) none: bool,
    /// Write no ambient sound for water (also -noambientwater, and so on)
    #[arg(long = "no-ambient-water", help_heading = SOUNDS)]
    pub(crate) no_water: bool,
    /// Write no ambient sound for the sky
    #[arg(long = "no-ambient-sky", help_heading = SOUNDS)]
    pub(crate) no_sky: bool,
    /// Write no ambient sound for slime, which uses that of water
    #[arg(long = "no-ambient-slime", help_heading = SOUNDS)]
    pub(crate) no_slime: bool,
    /// Write no ambient sound for lava
    #[arg(long = "no-ambient-lava", help_heading = SOUNDS)]
    pub(crate) no_lava: bool,
}

impl AmbientArgs {
    /// Returns the sounds to write; `None` to leave all levels unchanged.
    pub(crate) fn sounds(&self) -> Option<AmbientSounds> {
        let mut sounds = AmbientSounds::default();
        sounds.water = !self.no_water;
        sounds.sky = !self.no_sky;
        sounds.slime = !self.no_slime;
        sounds.lava = !self.no_lava;
        (!self.none).then_some(sounds)
    }
}

/// Options of `portals`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Reads BSP29 and BSP2 maps of Quake, and IBSP46 maps of Quake 3. `vis` reads the result.

What a map does not store cannot be restored: hint portals, and in a Quake map without a PVS the clusters, so each leaf \
becomes one.

Examples:
  enfilade portals map.bsp
  enfilade portals map.bsp -o other.prt --json portals.json
  enfilade portals map.bsp --force")]
#[command(mut_arg("memory", |arg| arg.help(MEMORY_TO_READ)))]
pub(crate) struct PortalsArgs {
    /// Compiled map
    #[arg(value_name = "MAP.bsp")]
    pub(crate) map: PathBuf,
    /// Write the portals to this file (atomically) [default: NAME.prt beside NAME.bsp or NAME.novis.bsp]
    #[arg(short, long, value_name = "FILE.prt")]
    pub(crate) output: Option<PathBuf>,
    /// Replace an existing .prt
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten)]
    pub(crate) memory: MemoryArg,
}
