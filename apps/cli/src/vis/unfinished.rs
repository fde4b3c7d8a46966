//! Work that is not finished, in a file beside the map: a run that was stopped or killed goes on from there.

use crate::save::Destination;
use anyhow::{Context, Result};
use enfilade_bake::PairsWork;
use std::ffi::OsString;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The file `MAP.bsp.vis-unfinished`.
pub(super) struct Unfinished {
    path: PathBuf,
}

impl Unfinished {
    pub(super) fn beside(map: &Path) -> Unfinished {
        let mut name = OsString::from(map);
        name.push(".vis-unfinished");
        Unfinished { path: name.into() }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes how far the work is; up to the fast bound there is nothing to keep.
    pub(super) fn save(&self, work: &PairsWork) -> Result<()> {
        let Some(bytes) = work.save() else {
            return Ok(());
        };
        Destination::new(&self.path)?.write_bytes(&bytes)
    }

    /// What was saved, if anything was.
    pub(super) fn read(&self) -> Result<Option<Vec<u8>>> {
        match fs::read(&self.path) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            read => read
                .with_context(|| format!("cannot read {}", self.path.display()))
                .map(Some),
        }
    }

    /// The work is done.
    pub(super) fn remove(&self) -> Result<()> {
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                Err(error).with_context(|| format!("cannot remove {}", self.path.display()))
            }
            _ => Ok(()),
        }
    }
}
