//! Work that is not finished, in two files beside the map: a run that was stopped or killed goes on from there.
//!
//! The passages, which are many and do not change once they are computed, are in a file of their own. A run holds a lock on the
//! other. While another run has that, neither is used, replaced or removed.

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
pub(super) struct Unfinished {
    path: PathBuf,
    destination: Destination,
    path_of_passages: PathBuf,
    passages: Destination,
    /// The stage when the passages were saved last; later ones do not change them.
    passages_saved_in: Option<Stage>,
    /// What this run goes on from or has saved, and its lock.
    held: Option<File>,
}

/// Work that was saved.
pub(super) struct Saved {
    pub(super) work: Vec<u8>,
    /// Empty where there are none: they are computed again.
    pub(super) passages: Vec<u8>,
}

impl Unfinished {
    /// The file beside a map.
    pub(super) fn beside(map: &Path, files: &mut RunFiles) -> Result<Unfinished> {
        let [path, path_of_passages] =
            [".vis-unfinished", ".vis-passages"].map(|ending| map.with_file_name(name_for(map, ending)));
        Ok(Unfinished {
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

    /// Whether this run has saved work, or goes on from some.
    pub(super) fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// Returns what was saved if it is to be used. Warns where it is not, or cannot be.
    pub(super) fn begin(&mut self, is_wanted: bool, limit: u64) -> Result<Option<Saved>> {
        if !self.path.exists() {
            return Ok(None);
        }
        let name = self.path.display();
        if !self.is_free() {
            out::warn(format_args!(
                "{name} belongs to a run that is still at work; this one starts anew, and saves no progress until that one ends"
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
            // Another run can have been faster: both may use it, but one alone saves from now on.
            self.held = (!is_locked_by_another(&file)).then_some(file);
            return Ok(Some(Saved { work, passages }));
        } else {
            out::warn(format_args!(
                "{name} is the saved work of a run that was not finished; this one starts anew and will replace it \
                 (--resume continues it)"
            ));
        }
        Ok(None)
    }

    /// Notes that work goes on from what was saved. Past [`Stage::Passages`] that had all of them.
    pub(super) fn goes_on(&mut self, work: &PairsWork) {
        self.passages_saved_in = Some(work.stage());
    }

    /// Writes how far the work is; returns how long that takes if it is done again soon.
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

    /// The work is done.
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

    /// Whether what is there is not of another run that is still at work.
    fn is_free(&self) -> bool {
        let is_held = |held| is_open_file(&self.path, held);
        self.held.as_ref().is_some_and(is_held)
            || !self.path.is_file()
            || !File::open(&self.path).is_ok_and(|file| is_locked_by_another(&file))
    }
}

/// The name of the map with an ending; where that would be too long, with a number instead of its own end.
fn name_for(map: &Path, ending: &str) -> OsString {
    /// What most file systems allow.
    const LONGEST: usize = 255;
    let mut name = map.file_name().unwrap_or_default().to_owned();
    if name.len() + ending.len() > LONGEST {
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
