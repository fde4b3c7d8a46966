//! The command lines of `vis` and `portals`, for maps of Quake and Quake 3.

use super::{JsonArg, LimitArgs};
use crate::values;
use enfilade_import::AmbientSounds;
use std::path::PathBuf;

/// Options of `vis`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Reads maps in BSP29, BSP2 and IBSP46, and portals in PRT1, PRT2 and the format of Quake 3 compilers. The PVS never hides \
anything visible, is symmetric, and is the same for any number of threads, whether or not the run was interrupted. Clusters \
are counted from 0. For a .prt alone, only a report is printed. In Quake maps each leaf also gets the ambient sound levels \
of water, sky and lava, from texture names or, if the map has none, from the contents of leafs.

Examples:
  enfilade vis map.bsp
  enfilade vis map.bsp -o copy.bsp --json -
  enfilade vis map.bsp --prt other-name.prt --fast
  enfilade vis map.bsp --seconds 600
  enfilade vis map.bsp --resume
  enfilade vis map.bsp -o copy.bsp --compare shipped.bsp --check=20000000")]
pub(crate) struct VisArgs {
    /// Compiled map; the PVS is written into it, as a whole or not at all
    #[arg(value_name = "MAP.bsp")]
    pub(crate) map: PathBuf,
    /// Write a copy of the map, and leave the map unchanged
    #[arg(short, long, value_name = "OTHER.bsp")]
    pub(crate) output: Option<PathBuf>,
    /// Read the portals from this file [default: NAME.prt beside NAME.bsp or NAME.novis.bsp]
    #[arg(long, value_name = "FILE.prt")]
    pub(crate) prt: Option<PathBuf>,
    /// Stop at the fast upper bound: two to eight times as fast, up to twice as many pairs
    #[arg(long)]
    pub(crate) fast: bool,
    #[command(flatten)]
    pub(crate) ambient: AmbientArgs,
    /// Stop after N seconds and write an upper bound, which hides nothing visible; --resume continues
    #[arg(long, value_name = "N", value_parser = values::seconds)]
    pub(crate) seconds: Option<f64>,
    /// Print no progress: neither a bar nor a line every ten seconds
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Continue a run that was stopped or killed
    #[arg(long)]
    pub(crate) resume: bool,
    /// Save unfinished work beside the map every so many seconds [default: grows with the run and the time of a save]
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    pub(crate) save_every: Option<f64>,
    /// Test the PVS with random lines through the portals; if one proves that a pair is missing, print it, write
    /// nothing and exit with 1
    #[arg(long, value_name = "LINES", num_args = 0..=1, require_equals = true, default_missing_value = "1000000")]
    pub(crate) check: Option<u64>,
    /// Compare with another PVS of the same map: list the pairs it misses, with a line of sight where one is found, and
    /// its extra pairs
    #[arg(long, value_name = "OTHER.bsp")]
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
    #[arg(long = "no-ambient")]
    pub(crate) none: bool,
    /// Write no ambient sound for water (also -noambientwater, and so on)
    #[arg(long = "no-ambient-water")]
    pub(crate) no_water: bool,
    /// Write no ambient sound for the sky
    #[arg(long = "no-ambient-sky")]
    pub(crate) no_sky: bool,
    /// Write no ambient sound for slime, which sounds like water
    #[arg(long = "no-ambient-slime")]
    pub(crate) no_slime: bool,
    /// Write no ambient sound for lava
    #[arg(long = "no-ambient-lava")]
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
Reads BSP29 and BSP2 maps of Quake, and IBSP46 maps of Quake 3. A Quake map shows which leafs form a cluster only through \
its PVS; without one, each leaf becomes a cluster. Hint portals cannot be restored, because maps do not store them.

Examples:
  enfilade portals map.bsp
  enfilade portals map.bsp -o other.prt --json portals.json
  enfilade portals map.bsp --force")]
pub(crate) struct PortalsArgs {
    /// Compiled map
    #[arg(value_name = "MAP.bsp")]
    pub(crate) map: PathBuf,
    /// Write the portals to this file, as a whole or not at all [default: NAME.prt beside NAME.bsp or NAME.novis.bsp]
    #[arg(short, long, value_name = "FILE.prt")]
    pub(crate) output: Option<PathBuf>,
    /// Replace an existing .prt
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    /// Limit the memory for reading the map: 2GB, 500MB or plain bytes [default: about 1 GB]
    #[arg(long, value_name = "BYTES", value_parser = values::bytes)]
    pub(crate) memory: Option<u64>,
}
