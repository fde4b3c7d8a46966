//! Compiled maps and portal files of Quake and Quake 3.

mod ambient;
mod bsp;
mod error;
mod portals;
mod prt;
mod prt_text;
mod scene;

pub use ambient::{AmbientLeafs, AmbientSounds, with_ambient_sounds};
pub use bsp::{BspError, PlacedPortals, place_portals, visibility_bytes, with_visibility};
pub use error::PrtError;
pub use portals::{ClustersFrom, Leak, RebuiltPortals, find_leak, rebuild_portals, rebuild_portals_bytes};
pub use prt::{PortalFile, PrtKind};
pub use scene::MapSummary;
pub(crate) use scene::{begins_like_map, import};

use crate::{BrokenRule, ImportError, ReadOptions, read_file};
use std::path::Path;

impl From<PrtError> for BrokenRule {
    fn from(why: PrtError) -> BrokenRule {
        BrokenRule::Prt(Box::new(why))
    }
}

impl From<BspError> for BrokenRule {
    fn from(why: BspError) -> BrokenRule {
        BrokenRule::Bsp(Box::new(why))
    }
}

/// Reads a `.prt` file: the portals of a map, which a map compiler writes for its `vis` stage.
///
/// # Errors
/// Returns an [`ImportError`] that names the file, the line and the rule, deterministically.
pub fn read_portals(path: &Path, options: &ReadOptions) -> Result<PortalFile, ImportError> {
    read_file(path, options, |bytes, _, mut budget| {
        // A corner takes three times the size of its shortest text, `(0 0 0)`, and each portal one list of corners.
        budget.take(bytes.len() as u64 * 8, || "its portals".to_owned())?;
        Ok(PortalFile::parse(bytes)?)
    })
}
