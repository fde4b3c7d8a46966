//! Options of the verbs for maps of Quake and Quake 3.

use super::{JsonArg, LimitArgs};
use crate::values;
use enfilade_import::AmbientSounds;
use std::path::PathBuf;

/// Options of `vis`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Maps are BSP29, BSP2 and IBSP46; portals PRT1, PRT2 and what compilers for Quake 3 write. What is written hides nothing \
that can be seen, is symmetric, and is the same for any number of threads, stopped in between or not. Clusters are \
counted from 0. Of a .prt alone there is a report. In maps of Quake each leaf also gets the levels of the ambient sounds of \
water, sky and lava, from the names of textures, or, where a map has none, from the contents of leafs.

Examples:
  enfilade vis map.bsp
  enfilade vis map.bsp -o copy.bsp --json -
  enfilade vis map.bsp --prt other-name.prt --fast
  enfilade vis map.bsp --seconds 600
  enfilade vis map.bsp --resume
  enfilade vis map.bsp -o copy.bsp --compare shipped.bsp --check=20000000")]
pub(crate) struct VisArgs {
    /// The compiled map; what is visible is written into it, whole or not at all
    #[arg(value_name = "MAP.bsp")]
    pub(crate) map: PathBuf,
    /// Write a copy of the map, and leave the map as it is
    #[arg(short, long, value_name = "OTHER.bsp")]
    pub(crate) output: Option<PathBuf>,
    /// The portals of the map [default: NAME.prt beside NAME.bsp, also beside NAME.novis.bsp]
    #[arg(long, value_name = "FILE.prt")]
    pub(crate) prt: Option<PathBuf>,
    /// Stop at the first bound: two to eight times as fast, and up to twice as many pairs
    #[arg(long)]
    pub(crate) fast: bool,
    #[command(flatten)]
    pub(crate) ambient: AmbientArgs,
    /// Stop after so many seconds; what is known by then hides nothing that can be seen, and --resume goes on
    #[arg(long, value_name = "N", value_parser = values::seconds)]
    pub(crate) seconds: Option<f64>,
    /// No progress on standard error: neither a bar nor a line every ten seconds
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Go on where a run was that was stopped or killed
    #[arg(long)]
    pub(crate) resume: bool,
    /// Time between two saves of the work, beside the map [default: the more, the longer a run and a save take]
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    pub(crate) save_every: Option<f64>,
    /// Shoot so many random lines through the portals; exit 1, with the line, and write nothing if one shows a pair that
    /// is missing
    #[arg(long, value_name = "LINES", num_args = 0..=1, require_equals = true, default_missing_value = "1000000")]
    pub(crate) check: Option<u64>,
    /// List the pairs in which another vis of the same map differs: those that it misses, each with a line of sight
    /// where one is found, and those that it has too many
    #[arg(long, value_name = "OTHER.bsp")]
    pub(crate) compare: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
}

/// Which ambient sounds are written.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct AmbientArgs {
    /// Leave the levels of ambient sounds in the leafs as they are (also -noambient)
    #[arg(long = "no-ambient")]
    pub(crate) none: bool,
    /// No ambient sound for water (also -noambientwater, and so on)
    #[arg(long = "no-ambient-water")]
    pub(crate) no_water: bool,
    /// No ambient sound for the sky
    #[arg(long = "no-ambient-sky")]
    pub(crate) no_sky: bool,
    /// No ambient sound for slime, which sounds like water
    #[arg(long = "no-ambient-slime")]
    pub(crate) no_slime: bool,
    /// No ambient sound for lava
    #[arg(long = "no-ambient-lava")]
    pub(crate) no_lava: bool,
}

impl AmbientArgs {
    /// `None` if no levels are written.
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
Maps are BSP29 and BSP2 of Quake, and IBSP46 of Quake 3. A map of Quake says which leafs are one cluster only by what is \
visible, once that has been computed; of one that has nothing yet, each leaf is a cluster. What compilers mark as hints is \
not in a map.

Examples:
  enfilade portals map.bsp
  enfilade portals map.bsp -o other.prt --json portals.json
  enfilade portals map.bsp --force")]
pub(crate) struct PortalsArgs {
    /// A compiled map
    #[arg(value_name = "MAP.bsp")]
    pub(crate) map: PathBuf,
    /// Where the portals go; they are written whole or not at all [default: NAME.prt beside NAME.bsp or NAME.novis.bsp]
    #[arg(short, long, value_name = "FILE.prt")]
    pub(crate) output: Option<PathBuf>,
    /// Replace a .prt that is there
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) json: JsonArg,
    /// What reading the map may take: 2GB, 500MB or plain bytes [default: about 1 GB]
    #[arg(long, value_name = "BYTES", value_parser = values::bytes)]
    pub(crate) memory: Option<u64>,
}
