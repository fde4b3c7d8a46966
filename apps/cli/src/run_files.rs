//! The files of a run: no output replaces an input, or another output.

use crate::save::Destination;
use anyhow::{Result, bail};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File, Metadata};
use std::path::{Path, PathBuf};

/// The inputs and outputs of a run, told apart by what they are on the disk, not by their names.
#[derive(Debug, Default)]
pub(crate) struct RunFiles(HashMap<Identity, (Role, PathBuf)>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Input,
    Output,
    /// An input that the run is asked to change.
    InPlace,
}

impl RunFiles {
    /// Those of a run that reads a scene, and views where `path` says so.
    pub(crate) fn of(scene: &OsStr, path: Option<&Path>) -> Result<RunFiles> {
        let mut files = RunFiles::default();
        let scene = Path::new(scene);
        files.reads(scene)?;
        // Of all verbs `vis` alone reads the portals of a map, but they belong to it.
        if scene
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("bsp"))
        {
            for prt in portals_beside(scene) {
                files.reads(&prt)?;
            }
        }
        path.map_or(Ok(()), |path| files.reads(path))?;
        Ok(files)
    }

    /// Adds an input.
    ///
    /// # Errors
    /// If it is an output already.
    pub(crate) fn reads(&mut self, path: &Path) -> Result<()> {
        if path.exists() {
            self.claim(Role::Input, path)?;
        }
        Ok(())
    }

    /// Adds an output.
    ///
    /// # Errors
    /// If it is an input or an output already, or cannot be written.
    pub(crate) fn writes(&mut self, path: &Path) -> Result<Destination> {
        let destination = self.writes_too(path)?;
        destination.prepare()?;
        Ok(destination)
    }

    /// The same of one more output in a folder that another one of the run is in.
    pub(crate) fn writes_too(&mut self, path: &Path) -> Result<Destination> {
        let destination = Destination::new(path)?;
        self.claim(Role::Output, path)?;
        Ok(destination)
    }

    /// Adds an output that is an input as well. It must come before all others.
    pub(crate) fn changes(&mut self, path: &Path) -> Result<Destination> {
        let destination = Destination::new(path)?;
        self.claim(Role::InPlace, path)?;
        destination.prepare()?;
        Ok(destination)
    }

    fn claim(&mut self, role: Role, path: &Path) -> Result<()> {
        let Some(identity) = Identity::of(path) else {
            return Ok(());
        };
        let entry = match self.0.entry(identity) {
            Entry::Vacant(free) => {
                free.insert((role, path.to_owned()));
                return Ok(());
            }
            Entry::Occupied(entry) => entry,
        };
        let (other_role, other) = entry.get();
        let [path, other] = [path, other].map(Path::display);
        match (other_role, role) {
            (Role::Output, Role::Output) => {
                bail!("cannot write {path}: it and the output {other} are one file; name two")
            }
            (_, Role::Output) => bail!("cannot write {path}: it is the input {other}; name another file"),
            (Role::Output, _) => bail!("cannot write {other}: it is the input {path}; name another file"),
            _ => Ok(()),
        }
    }
}

/// Returns the names that the portals of a map may have: `NAME.prt` beside `NAME.bsp` and `NAME.novis.bsp`.
pub(crate) fn portals_beside(map: &Path) -> [PathBuf; 2] {
    [
        map.with_extension("prt"),
        map.with_extension("").with_extension("prt"),
    ]
}

/// Returns the folder that a file is in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Returns `true` if both names lead to one regular file.
pub(crate) fn is_same(one: &Path, other: &Path) -> bool {
    Identity::of(one).is_some_and(|identity| Some(identity) == Identity::of(other))
}

/// Returns `true` if the file that is open is the one at a path.
pub(crate) fn is_open_file(path: &Path, file: &File) -> bool {
    let [named, open] = [fs::metadata(path), file.metadata()].map(|metadata| there(path, &metadata.ok()?));
    named.is_some() && named == open
}

/// What a file is, by whatever name it is called.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Identity {
    /// The file, or the folder where there is no file yet.
    there: There,
    new_name: Option<OsString>,
}

impl Identity {
    /// `None` for folders, devices and pipes, which no save replaces.
    fn of(path: &Path) -> Option<Identity> {
        if let Ok(file) = fs::metadata(path) {
            let there = there(path, &file);
            return there.filter(|_| file.is_file()).map(|there| Identity {
                there,
                new_name: None,
            });
        }
        let folder = folder_of(path);
        Some(Identity {
            there: there(folder, &fs::metadata(folder).ok()?)?,
            new_name: Some(path.file_name()?.to_owned()),
        })
    }
}

/// Device and inode.
#[cfg(unix)]
type There = (u64, u64);

#[cfg(unix)]
fn there(_path: &Path, metadata: &Metadata) -> Option<There> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

/// The path without links. Hard links are not found out here.
#[cfg(not(unix))]
type There = PathBuf;

#[cfg(not(unix))]
fn there(path: &Path, _metadata: &Metadata) -> Option<There> {
    fs::canonicalize(path).ok()
}
