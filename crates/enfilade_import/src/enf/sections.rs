//! How much of a baked scene is what.

use super::container::{Container, Kind, Section, Source};
use super::read::mapped;
use crate::ImportError;
use std::path::Path;

/// The sections of a baked scene, by kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BakedSections {
    /// The sections of each kind that there are.
    pub totals: Vec<SectionTotal>,
    /// What it was baked from: see [`Baker::note_source`](crate::Baker::note_source). Empty if that is not noted.
    pub source: Vec<u8>,
    /// Hash of all sections but prefetch hints.
    pub hash: u64,
}

/// The sections of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SectionTotal {
    /// Name of the kind.
    pub kind: &'static str,
    /// Number of sections.
    pub count: u32,
    /// Their size together.
    pub bytes: u64,
}

impl BakedSections {
    /// Reads the table of sections of a baked scene; `None` if the file is no baked scene.
    ///
    /// # Errors
    /// Returns an [`ImportError`] if the header or the table is damaged.
    pub fn read(path: &Path) -> Result<Option<BakedSections>, ImportError> {
        let failed = |rule| ImportError {
            file: path.display().to_string(),
            rule,
        };
        let Some(bytes) = mapped(path).map_err(failed)? else {
            return Ok(None);
        };
        let container = Container::open(Source::Memory(bytes)).map_err(failed)?;
        let totals = container.totals().filter(|total| total.count > 0);
        let source = match container.count(Kind::Source) {
            0 => Vec::new(),
            _ => container
                .section(Section(Kind::Source, 0))
                .map_err(failed)?
                .to_vec(),
        };
        Ok(Some(BakedSections {
            totals: totals.collect(),
            source,
            hash: container.hash_without(Kind::Hint),
        }))
    }
}
