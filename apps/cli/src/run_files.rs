//! Tracks the files of a run, so that no output replaces an input or another output.

use crate::save::{Destination, folder_of};
use anyhow::{Result, bail};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File, Metadata};
use std::path::{Path, PathBuf};

/// The inputs and outputs of a run, identified by device and inode rather than by name.
#[derive(Debug, Default)]
pub(crate) struct RunFiles(HashMap<Identity, (Role, PathBuf)>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Input,
    Output,
    /// An input that the run modifies.
    InPlace,
}

impl RunFiles {
    /// Returns the inputs of a run that reads a scene, and a file of views if `path` is given.
    pub(crate) fn of(scene: &OsStr, path: Option<&Path>) -> Result<RunFiles> {
        let mut files = RunFiles::default();
        let scene = Path::new(scene);
        files.reads(scene)?;
        // Only `vis` reads the portals of a map, but no verb may overwrite them.
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
    /// Fails if it is already an output.
    pub(crate) fn reads(&mut self, path: &Path) -> Result<()> {
        if path.exists() {
            self.claim(Role::Input, path)?;
        }
        Ok(())
    }

    /// Adds an output.
    ///
    /// # Errors
    /// Fails if it is already an input or an output, or cannot be written.
    pub(crate) fn writes(&mut self, path: &Path) -> Result<Destination> {
        let destination = self.writes_too(path)?;
        destination.prepare()?;
        Ok(destination)
    }

    /// As [`RunFiles::writes`], for a further output in the same folder, which needs no second test.
    pub(crate) fn writes_too(&mut self, path: &Path) -> Result<Destination> {
        let destination = Destination::new(path)?;
        self.claim(Role::Output, path)?;
        Ok(destination)
    }

    /// Adds a file that is both input and output. Must be added before all other files.
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
        let mut entry = match self.0.entry(identity) {
            Entry::Vacant(free) => {
                free.insert((role, path.to_owned()));
                return Ok(());
            }
            Entry::Occupied(entry) => entry,
        };
        let (_, other) = entry.get();
        // Another run may have replaced the other file meanwhile, and the file system may have given its node to this one.
        if Identity::of(other).as_ref() != Some(entry.key()) {
            entry.insert((role, path.to_owned()));
            return Ok(());
        }
        let (other_role, other) = entry.get();
        let [path, other] = [path, other].map(Path::display);
        match (other_role, role) {
            (Role::Output, Role::Output) => {
                bail!("cannot write {path}: it and the output {other} are one file; use two names")
            }
            (_, Role::Output) => bail!("cannot write {path}: it is the input {other}; name another file"),
            (Role::Output, _) => bail!("cannot write {other}: it is the input {path}; name another file"),
            _ => Ok(()),
        }
    }
}

/// Returns the possible paths of a map's portals: `NAME.prt` beside `NAME.bsp` and `NAME.novis.bsp`.
pub(crate) fn portals_beside(map: &Path) -> [PathBuf; 2] {
    [
        map.with_extension("prt"),
        map.with_extension("").with_extension("prt"),
    ]
}

/// Returns `true` if both paths name the same regular file.
pub(crate) fn is_same(one: &Path, other: &Path) -> bool {
    Identity::of(one).is_some_and(|identity| Some(identity) == Identity::of(other))
}

/// Returns `true` if the open file is the one at the path.
pub(crate) fn is_open_file(path: &Path, file: &File) -> bool {
    let [named, open] =
        [fs::metadata(path), file.metadata()].map(|metadata| disk_node(path, &metadata.ok()?));
    named.is_some() && named == open
}

/// Identity of a file, independent of its name.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Identity {
    /// The file, or its folder if it does not exist yet.
    node: DiskNode,
    /// Name of a file that does not exist yet.
    new_name: Option<OsString>,
}

impl Identity {
    /// Returns `None` for folders, devices and pipes, which saving does not replace.
    fn of(path: &Path) -> Option<Identity> {
        if let Ok(file) = fs::metadata(path) {
            let node = disk_node(path, &file);
            return node
                .filter(|_| file.is_file())
                .map(|node| Identity { node, new_name: None });
        }
        let folder = folder_of(path);
        Some(Identity {
            node: disk_node(folder, &fs::metadata(folder).ok()?)?,
            new_name: Some(path.file_name()?.to_owned()),
        })
    }
}

/// Device and inode.
#[cfg(unix)]
type DiskNode = (u64, u64);

#[cfg(unix)]
fn disk_node(_path: &Path, metadata: &Metadata) -> Option<DiskNode> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

/// The canonical path. Does not detect hard links.
#[cfg(not(unix))]
type DiskNode = PathBuf;

#[cfg(not(unix))]
fn disk_node(path: &Path, _metadata: &Metadata) -> Option<DiskNode> {
    fs::canonicalize(path).ok()
}
