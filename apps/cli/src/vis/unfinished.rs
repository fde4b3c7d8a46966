//! Saves unfinished work in two files beside the map, so that a stopped or killed run can be resumed.
//!
//! Passages have a separate file, because they are many and do not change once computed. A run holds a lock on the
//! other file; while another run holds it, this run does not use, replace or remove either.

use crate::out;
use crate::read::read_file;
use crate::run_files::{RunFiles, is_open_file};
use crate::save::{Destination, is_locked_by_another};
use anyhow::{Context, Result};
use enfilade_bake::{PairsWork, Stage};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The files `MAP.bsp.vis-unfinished` and `MAP.bsp.vis-passages`.
pub(super) struct UnfinishedWork {
    path: PathBuf,
    destination: Destination,
    path_of_passages: PathBuf,
    passages: Destination,
    /// The stage at which the passages were last saved; stages after [`Stage::Passages`] do not change them.
    passages_saved_in: Option<Stage>,
    /// The file this run resumed from or has saved, locked.
    held: Option<File>,
}

/// Saved work.
pub(super) struct SavedWork {
    pub(super) work: Vec<u8>,
    /// Empty if there are none; they are then computed again.
    pub(super) passages: Vec<u8>,
}

impl UnfinishedWork {
    /// Returns the files beside a map, and adds them to the outputs.
    pub(super) fn beside(map: &Path, files: &mut RunFiles) -> Result<UnfinishedWork> {
        let [path, path_of_passages] =
            [".vis-unfinished", ".vis-passages"].map(|ending| map.with_file_name(name_for(map, ending)));
        Ok(UnfinishedWork {
            destination: files.writes_too(&path)?,
            path,
            passages: files.writes_too(&path_of_passages)?,
            path_of_passages,
            passages_saved_in: None,
            held: None,
        })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether this run has saved work, or resumed from some, and holds the lock.
    pub(super) fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// Returns the saved work if `is_wanted`. Warns if there is some that is not, or cannot be, used.
    pub(super) fn begin(&mut self, is_wanted: bool, limit: u64) -> Result<Option<SavedWork>> {
        if !self.path.exists() {
            return Ok(None);
        }
        let name = self.path.display();
        if !self.is_free() {
            out::warn(format_args!(
                "{name} belongs to a run in progress; this one starts from the beginning, and saves no work until that one ends"
            ));
        } else if is_wanted {
            const REMEDY: &str = "raise --memory, or leave out --resume";
            let work = read_file(&self.path, limit, REMEDY)?;
            let passages = if self.path_of_passages.exists() {
                read_file(&self.path_of_passages, limit, REMEDY)?
            } else {
                Vec::new()
            };
            let file = File::open(&self.path).with_context(|| format!("cannot read {name}"))?;
            // Another run may have locked it meanwhile: both may read it, but only one saves from now on.
            self.held = (!is_locked_by_another(&file)).then_some(file);
            return Ok(Some(SavedWork { work, passages }));
        } else {
            out::warn(format_args!(
                "{name} is the saved work of an unfinished run; this one starts from the beginning and will replace it \
                 (--resume continues it)"
            ));
        }
        Ok(None)
    }

    /// Records that saved work was resumed. Past [`Stage::Passages`] its passages are complete.
    pub(super) fn set_resumed(&mut self, work: &PairsWork) {
        self.passages_saved_in = Some(work.stage());
    }

    /// Saves the work. Returns the expected time of the next save.
    pub(super) fn save(&mut self, work: &PairsWork) -> Result<Duration> {
        let start = Instant::now();
        if !self.is_free() {
            return Ok(start.elapsed());
        }
        self.held = Some(self.destination.write(&work.save())?);
        let mut cost = start.elapsed();
        let is_known = self
            .passages_saved_in
            .is_some_and(|stage| stage > Stage::Passages);
        if work.stage() >= Stage::Passages && !is_known {
            self.passages.write(&work.save_passages())?;
            self.passages_saved_in = Some(work.stage());
            if work.stage() == Stage::Passages {
                cost = start.elapsed();
            }
        }
        Ok(cost)
    }

    /// Removes the saved work, unless it belongs to another run.
    pub(super) fn remove(&self) -> Result<()> {
        if !self.is_free() {
            return Ok(());
        }
        for path in [&self.path_of_passages, &self.path] {
            match fs::remove_file(path) {
                Err(error) if error.kind() != ErrorKind::NotFound => {
                    return Err(error).with_context(|| format!("cannot remove {}", path.display()));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Whether no other run in progress holds the saved work.
    fn is_free(&self) -> bool {
        let is_held = |held| is_open_file(&self.path, held);
        self.held.as_ref().is_some_and(is_held)
            || !self.path.is_file()
            || !File::open(&self.path).is_ok_and(|file| is_locked_by_another(&file))
    }
}

/// Appends an ending to the name of the map. If that is too long, replaces the end of the name by a hash.
pub(super) fn name_for(map: &Path, ending: &str) -> OsString {
    /// The limit of most file systems, in bytes.
    const MAX_BYTES: usize = 255;
    let mut name = map.file_name().unwrap_or_default().to_owned();
    if name.len() + ending.len() > MAX_BYTES {
        // FNV-1a, because the hash must be the same in every run.
        let hash = name
            .as_encoded_bytes()
            .iter()
            .fold(0xcbf2_9ce4_8422_2325, |hash: u64, &byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            });
        let beginning: String = name.to_string_lossy().chars().take(50).collect();
        name = format!("{beginning}-{hash:016x}").into();
    }
    name.push(ending);
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_saved_work_fit_and_tell_maps_apart() {
        let name = |map: &str| {
            let name = name_for(Path::new(map), ".vis-unfinished");
            name.into_string().expect("text")
        };
        assert_eq!(name("maps/dm1.bsp"), "dm1.bsp.vis-unfinished");
        let [a, b] = ["a", "b"].map(|end| name(&format!("{}{end}.bsp", "é".repeat(120))));
        assert!(a != b && a.len() <= 255, "{a} {b}");
    }
}
