//! Work that is not finished, in a file beside the map: a run that was stopped or killed goes on from there.
//!
//! A run holds a lock on what it has saved. What is locked by another run is not used, replaced or removed.

use crate::out;
use crate::read::read_file;
use crate::run_files::{RunFiles, is_open_file};
use crate::save::{Destination, is_locked_by_another};
use anyhow::{Context, Result};
use enfilade_bake::PairsWork;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The file `MAP.bsp.vis-unfinished`.
pub(super) struct Unfinished {
    path: PathBuf,
    destination: Destination,
    /// What this run goes on from or has saved, and its lock.
    held: Option<File>,
}

impl Unfinished {
    /// The file beside a map.
    pub(super) fn beside(map: &Path, files: &mut RunFiles) -> Result<Unfinished> {
        let path = map.with_file_name(name_for(map));
        Ok(Unfinished {
            destination: files.writes_too(&path)?,
            path,
            held: None,
        })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether this run has saved work, or goes on from some.
    pub(super) fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// Returns what was saved if it is to be used. Warns where it is not, or cannot be.
    pub(super) fn begin(&mut self, is_wanted: bool, limit: u64) -> Result<Option<Vec<u8>>> {
        if !self.path.exists() {
            return Ok(None);
        }
        let name = self.path.display();
        if !self.is_free() {
            out::warn(format_args!(
                "{name} belongs to a run that is still at work; this one starts anew, and saves no progress until that one ends"
            ));
        } else if is_wanted {
            let bytes = read_file(&self.path, limit, "raise --memory, or leave out --resume")?;
            let file = File::open(&self.path).with_context(|| format!("cannot read {name}"))?;
            // Another run can have been faster: both may use it, but one alone saves from now on.
            self.held = (!is_locked_by_another(&file)).then_some(file);
            return Ok(Some(bytes));
        } else {
            out::warn(format_args!(
                "{name} is the saved work of a run that was not finished; this one starts anew and will replace it \
                 (--resume continues it)"
            ));
        }
        Ok(None)
    }

    /// Writes how far the work is; up to the fast bound there is nothing to keep.
    pub(super) fn save(&mut self, work: &PairsWork) -> Result<()> {
        if let Some(bytes) = work.save()
            && self.is_free()
        {
            self.held = Some(self.destination.write(&bytes)?);
        }
        Ok(())
    }

    /// The work is done.
    pub(super) fn remove(&self) -> Result<()> {
        if !self.is_free() {
            return Ok(());
        }
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                Err(error).with_context(|| format!("cannot remove {}", self.path.display()))
            }
            _ => Ok(()),
        }
    }

    /// Whether what is there is not of another run that is still at work.
    fn is_free(&self) -> bool {
        let is_held = |held| is_open_file(&self.path, held);
        self.held.as_ref().is_some_and(is_held)
            || !self.path.is_file()
            || !File::open(&self.path).is_ok_and(|file| is_locked_by_another(&file))
    }
}

/// The name of the map with `.vis-unfinished`; where that would be too long, with a number instead of its end.
fn name_for(map: &Path) -> OsString {
    /// What most file systems allow.
    const LONGEST: usize = 255;
    const ENDING: &str = ".vis-unfinished";
    let mut name = map.file_name().unwrap_or_default().to_owned();
    if name.len() + ENDING.len() > LONGEST {
        // FNV-1a, the same in every run.
        let hash = name
            .as_encoded_bytes()
            .iter()
            .fold(0xcbf2_9ce4_8422_2325, |hash: u64, &byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            });
        let beginning: String = name.to_string_lossy().chars().take(50).collect();
        name = format!("{beginning}-{hash:016x}").into();
    }
    name.push(ENDING);
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_saved_work_fit_and_tell_maps_apart() {
        let name = |map: &str| name_for(Path::new(map)).into_string().expect("text");
        assert_eq!(name("maps/dm1.bsp"), "dm1.bsp.vis-unfinished");
        let [a, b] = ["a", "b"].map(|end| name(&format!("{}{end}.bsp", "é".repeat(120))));
        assert!(a != b && a.len() <= 255, "{a} {b}");
    }
}
