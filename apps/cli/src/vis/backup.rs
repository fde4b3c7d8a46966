//! Keeps the map that `vis` replaces, once: as `NAME.bsp.bak` beside it.

use super::unfinished::name_for;
use crate::out;
use crate::run_files::RunFiles;
use crate::save::Destination;
use anyhow::Result;
use std::path::{Path, PathBuf};

/// A map that will be replaced.
pub(super) struct Backup {
    map: PathBuf,
    /// Where the old map is kept; `None` without a backup.
    path: Option<PathBuf>,
    /// `None` if there is a backup from an earlier run, which stays.
    destination: Option<Destination>,
}

impl Backup {
    /// Plans the backup of the map at `target`; `None` if no map is there.
    pub(super) fn of(target: &Path, is_wanted: bool, files: &mut RunFiles) -> Result<Option<Backup>> {
        if !target.is_file() {
            return Ok(None);
        }
        let path = is_wanted.then(|| target.with_file_name(name_for(target, ".bak")));
        let is_new = |path: &&PathBuf| path.symlink_metadata().is_err();
        let new = path.as_ref().filter(is_new);
        let destination = new.map(|path| files.writes_too(path)).transpose()?;
        let map = target.to_owned();
        Ok(Some(Backup {
            map,
            path,
            destination,
        }))
    }

    /// Says that the map will be overwritten, and where the old one is kept.
    pub(super) fn announce(&self) {
        let map = self.map.display();
        match (&self.path, &self.destination) {
            (None, _) => out::note(format_args!("{map} will be overwritten, without a backup")),
            (Some(path), None) => out::note(format_args!(
                "{map} will be overwritten; {}, from an earlier run, stays as it is",
                path.display()
            )),
            (Some(path), Some(_)) => out::note(format_args!(
                "{map} will be overwritten; the old map is kept as {}",
                path.display()
            )),
        }
    }

    /// Copies the map, unless an earlier run has.
    pub(super) fn write(&self) -> Result<()> {
        match &self.destination {
            Some(destination) => destination.copy_once(&self.map),
            None => Ok(()),
        }
    }

    /// Returns where this run keeps the old map.
    pub(super) fn path(&self) -> Option<&Path> {
        self.path.as_deref().filter(|_| self.destination.is_some())
    }
}
