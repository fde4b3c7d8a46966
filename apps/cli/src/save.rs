//! Files that are written whole or not at all.

use anyhow::{Context, Result, bail};
use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A place for a file, found to be writable before the work that fills it.
pub(crate) struct Destination {
    path: PathBuf,
    /// A device or a pipe: written to as it is, for a rename would replace it.
    special: bool,
}

impl Destination {
    /// Checks that a file can be made there, and leaves nothing behind.
    pub(crate) fn new(path: &Path) -> Result<Destination> {
        let fails = || format!("cannot write {}", path.display());
        // What a link points at is replaced, not the link.
        let path_there = fs::canonicalize(path);
        let there = path_there.as_ref().ok().and_then(|path| fs::metadata(path).ok());
        if there.as_ref().is_some_and(fs::Metadata::is_dir) {
            bail!("{}: it is a folder; name a file in it", fails());
        }
        let special = there.is_some_and(|there| !there.is_file());
        let destination = Destination {
            path: path_there.unwrap_or_else(|_| path.to_owned()),
            special,
        };
        if path.file_name().is_none() {
            bail!("{}: it does not end in a file's name", fails());
        }
        if !special {
            let folder = destination.folder();
            if !folder.is_dir() {
                bail!(
                    "{}: there is no folder {}; make it first, or name another",
                    fails(),
                    folder.display()
                );
            }
            let probe = destination.beside();
            OpenOptions::new()
                .write(true)
                .create(true)
                .truncate(true)
                .open(&probe)
                .with_context(fails)?;
            fs::remove_file(&probe).with_context(fails)?;
        }
        Ok(destination)
    }

    /// Lets `fill` write the file under a passing name, then puts it in its place.
    pub(crate) fn write<E>(&self, fill: impl FnOnce(&Path) -> Result<(), E>) -> Result<()>
    where
        Result<(), E>: Context<(), E>,
    {
        let fails = || format!("cannot write {}", self.path.display());
        if self.special {
            return fill(&self.path).with_context(fails);
        }
        let passing = self.beside();
        let written = fill(&passing)
            .with_context(fails)
            .and_then(|()| fs::rename(&passing, &self.path).with_context(fails));
        if written.is_err() {
            // The first error says more than one about the leftover.
            let _ = fs::remove_file(&passing);
        }
        written
    }

    /// Writes bytes there, which are on the disk before they get the file's name.
    pub(crate) fn write_bytes(&self, bytes: &[u8]) -> Result<()> {
        self.write(|path| {
            let mut file = File::create(path)?;
            file.write_all(bytes)?;
            file.sync_all()
        })
    }

    fn folder(&self) -> &Path {
        self.path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty())
            .unwrap_or(Path::new("."))
    }

    /// A hidden name in the same folder, with the same ending.
    fn beside(&self) -> PathBuf {
        let mut name = OsString::from(".");
        name.push(self.path.file_stem().unwrap_or_default());
        name.push(format!("-{}-unfinished", std::process::id()));
        if let Some(ending) = self.path.extension() {
            name.push(".");
            name.push(ending);
        }
        self.folder().join(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_there_whole_or_not_at_all() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        let destination = Destination::new(&path).expect("it can be written");
        assert!(!path.exists());
        assert!(
            destination
                .write(|_| -> std::io::Result<()> { Err(std::io::Error::other("full")) })
                .is_err()
        );
        destination
            .write(|path| fs::write(path, "whole"))
            .expect("written");
        assert_eq!(fs::read_to_string(&path).expect("there"), "whole");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }

    #[test]
    fn what_cannot_be_written_is_said_before() {
        let folder = tempfile::tempdir().expect("a folder");
        let error = |path: &Path| {
            Destination::new(path)
                .err()
                .map(|error| format!("{error:#}"))
                .unwrap_or_default()
        };
        assert!(error(&folder.path().join("no/a.txt")).contains("there is no folder"));
        assert!(error(folder.path()).contains("it is a folder"));
    }
}
