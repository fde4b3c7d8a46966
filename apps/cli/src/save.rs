//! Saves outputs atomically: each replaces the old file as a whole, or leaves it unchanged.
//!
//! A save writes a temporary file in the folder of the output, syncs it, checks it and renames it. Every temporary file
//! is locked while its run lives, so later runs can recognize those of dead runs and remove them.

use crate::out;
use anyhow::{Context, Result, bail};
use std::fs::{self, File, Metadata, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Destination of an output, checked before the work that produces it.
#[derive(Debug)]
pub(crate) struct Destination {
    /// The path the user gave.
    name: PathBuf,
    /// The same with symbolic links resolved: the target of a link is replaced, not the link.
    path: PathBuf,
    /// Whether it is a device or a pipe. Those are written to directly, because a rename would replace them.
    is_special: bool,
}

impl Destination {
    /// Checks that the path can name a file, and that the file may be replaced.
    pub(crate) fn new(name: &Path) -> Result<Destination> {
        let fails = || format!("cannot write {}", name.display());
        let destination = |path, is_special| Destination {
            name: name.to_owned(),
            path,
            is_special,
        };
        let why = match fs::metadata(name) {
            Ok(there) if there.is_dir() => bail!("{}: it is a folder; name a file in it", fails()),
            Ok(there) if !there.is_file() => return Ok(destination(name.to_owned(), true)),
            Ok(there) if there.permissions().readonly() => bail!(
                "{}: it is read-only; make it writable, or name another file with -o or --json",
                fails()
            ),
            Ok(_) => return Ok(destination(fs::canonicalize(name).with_context(fails)?, false)),
            Err(why) => why,
        };
        let folder = folder_of(name);
        let Some(file_name) = name.file_name() else {
            bail!("{}: it does not end in a file name; name a file", fails());
        };
        if !folder.is_dir() {
            bail!(
                "{}: there is no folder {}; create it first, or name another",
                fails(),
                folder.display()
            );
        }
        if let Ok(target) = fs::read_link(name) {
            bail!(
                "{}: it is a symbolic link to {}, which does not exist; remove the link, or name another file",
                fails(),
                target.display()
            );
        }
        if why.kind() != ErrorKind::NotFound {
            return Err(why).with_context(fails);
        }
        Ok(destination(folder.join(file_name), false))
    }

    /// Checks that a file can be created beside it, and removes the temporary files of dead runs there. Warns of hard
    /// links.
    pub(crate) fn prepare(&self) -> Result<()> {
        if self.is_special {
            return Ok(());
        }
        let folder = folder_of(&self.path);
        remove_dead(folder);
        temporary_in(folder, true).with_context(|| format!("cannot write {}", self.name.display()))?;
        let links = hard_links(&self.path);
        if links > 1 {
            out::warn(format_args!(
                "{0} has {links} hard links; only {0} gets the new content, the other names keep the old one",
                self.name.display()
            ));
        }
        Ok(())
    }

    /// Returns the path the user gave.
    pub(crate) fn name(&self) -> &Path {
        &self.name
    }

    /// Writes all bytes, or leaves the old file unchanged. The returned file keeps its lock until it is closed.
    pub(crate) fn write(&self, bytes: &[u8]) -> Result<File> {
        let written = if self.is_special {
            let device = File::options().write(true).open(&self.path);
            device.and_then(|mut device| device.write_all(bytes).map(|()| device))
        } else {
            self.replace(|mut file| fill(&mut file, bytes))
        };
        written.with_context(|| format!("cannot write {}", self.name.display()))
    }

    /// As [`Destination::write`], for a file that `fill` writes in parts, and may read and write again.
    ///
    /// # Errors
    /// Those of `fill`; and if the destination is a device or a pipe, which cannot be written in parts.
    pub(crate) fn write_with<T>(&self, fill: impl FnOnce(&mut File) -> Result<T>) -> Result<T> {
        let context = || format!("cannot write {}", self.name.display());
        if self.is_special {
            bail!("{}: it is a device or a pipe; name a file", context());
        }
        let mut filled = None;
        let replaced = self.replace(|mut file| {
            let mut writable = file.try_clone()?;
            let result = fill(&mut writable);
            let failed = result.is_err();
            filled = Some(result);
            if failed {
                return Err(ErrorKind::Other.into());
            }
            file.flush()?;
            file.sync_all()
        });
        match (filled, replaced) {
            (Some(Err(why)), _) => Err(why).with_context(context),
            (_, Err(why)) => Err(why).with_context(context),
            (Some(Ok(value)), Ok(_)) => Ok(value),
            (None, Ok(_)) => unreachable!("a file is only replaced by a filled one"),
        }
    }

    /// Copies a file to here, unless a file is here: then that stays, also if another run puts it here meanwhile.
    pub(crate) fn copy_once(&self, from: &Path) -> Result<()> {
        let copy = || -> io::Result<()> {
            let temporary = temporary_in(folder_of(&self.path), false)?;
            let mut source = File::open(from)?;
            keep_owner_and_mode(temporary.as_file(), &source.metadata()?)?;
            io::copy(&mut source, &mut temporary.as_file())?;
            temporary.as_file().sync_all()?;
            match temporary.persist_noclobber(&self.path) {
                Err(why) if why.error.kind() != ErrorKind::AlreadyExists => Err(why.error),
                _ => Ok(()),
            }
        };
        copy().with_context(|| {
            format!(
                "cannot write {}, a copy of {}",
                self.name.display(),
                from.display()
            )
        })
    }

    /// Writes a temporary file with `fill`, and renames it on success.
    fn replace(&self, fill: impl FnOnce(&File) -> io::Result<()>) -> io::Result<File> {
        let replaced = fs::metadata(&self.path).ok();
        let temporary = temporary_in(folder_of(&self.path), replaced.is_some())?;
        if let Some(replaced) = replaced {
            keep_owner_and_mode(temporary.as_file(), &replaced)?;
        }
        fill(temporary.as_file())?;
        temporary.persist(&self.path).map_err(|why| why.error)
    }
}

/// The file operations of a save. Tests implement it with failing steps.
trait Storage: Write {
    /// Waits until all data is on the disk.
    fn sync(&mut self) -> io::Result<()>;
    /// Returns the length of the file, in bytes.
    fn length(&mut self) -> io::Result<u64>;
}

impl Storage for &File {
    fn sync(&mut self) -> io::Result<()> {
        self.sync_all()
    }

    fn length(&mut self) -> io::Result<u64> {
        Ok(self.metadata()?.len())
    }
}

fn fill(file: &mut impl Storage, bytes: &[u8]) -> io::Result<()> {
    file.write_all(bytes)?;
    file.flush()?;
    file.sync()?;
    match file.length()? {
        length if length == bytes.len() as u64 => Ok(()),
        length => Err(io::Error::other(format!(
            "only {length} of {} bytes arrived on the disk",
            bytes.len()
        ))),
    }
}

/// Temporary files are named `.enfilade-`, random letters, `.tmp`: short, whatever the name of the output.
const PREFIX: &str = ".enfilade-";
const SUFFIX: &str = ".tmp";

/// Creates a temporary file and locks it.
///
/// If `private`, only its owner can read it; else it gets the default mode of new files.
fn temporary_in(folder: &Path, private: bool) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX).rand_bytes(12);
    #[cfg(unix)]
    if !private {
        use std::os::unix::fs::PermissionsExt;
        // The umask still applies.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    #[cfg(not(unix))]
    let _ = private;
    loop {
        let temporary = builder.tempfile_in(folder)?;
        // Before it is locked, another run may mistake it for a dead run's and remove it; then retry. On file systems
        // without locks no run removes anything.
        let is_taken = is_locked_by_another(temporary.as_file());
        if !is_taken && temporary.path().exists() {
            return Ok(temporary);
        }
    }
}

/// Tries to lock a file. Returns `true` if another open file has its lock; `false` on file systems without locks.
pub(crate) fn is_locked_by_another(file: &File) -> bool {
    matches!(file.try_lock(), Err(TryLockError::WouldBlock))
}

/// Removes the temporary files of dead runs.
fn remove_dead(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_temporary = name.starts_with(PREFIX) && name.ends_with(SUFFIX);
        // Opening a pipe would block until someone writes.
        if !is_temporary || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        // Removed while locked, so that its own run cannot lock it in between. A failure to remove is harmless.
        if let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(unix)]
fn hard_links(path: &Path) -> u64 {
    use std::os::unix::fs::MetadataExt;
    fs::metadata(path).map_or(1, |there| there.nlink())
}

#[cfg(not(unix))]
fn hard_links(_path: &Path) -> u64 {
    1
}

/// Sets the mode of a file to that of the replaced one, and its owner and group as far as permitted.
fn keep_owner_and_mode(file: &File, replaced: &Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        let [user, group] = [Some(replaced.uid()), Some(replaced.gid())];
        // Only root may change the owner; others may select one of their groups.
        let _ = fchown(file, user, group).or_else(|_| fchown(file, None, group));
    }
    // Some file systems have one mode for all files, and refuse to set it.
    if file.metadata()?.permissions() == replaced.permissions() {
        return Ok(());
    }
    file.set_permissions(replaced.permissions())
}

/// Returns the folder that a file is in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file that fails after `calls_before` calls, and accepts at most 3 bytes per write.
    struct FailingFile<'f> {
        file: &'f File,
        calls_before: usize,
    }

    impl FailingFile<'_> {
        fn call(&mut self) -> io::Result<()> {
            if self.calls_before == 0 {
                return Err(io::Error::other("the disk is full"));
            }
            self.calls_before -= 1;
            Ok(())
        }
    }

    impl Write for FailingFile<'_> {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.call()?;
            self.file.write(&bytes[..bytes.len().min(3)])
        }

        fn flush(&mut self) -> io::Result<()> {
            self.call()?;
            self.file.flush()
        }
    }

    impl Storage for FailingFile<'_> {
        fn sync(&mut self) -> io::Result<()> {
            self.call()?;
            self.file.sync_all()
        }

        fn length(&mut self) -> io::Result<u64> {
            self.call()?;
            Ok(self.file.metadata()?.len())
        }
    }

    /// A file that reports a full write, but loses the last byte.
    struct LossyFile<'f>(&'f File);

    impl Write for LossyFile<'_> {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.write_all(&bytes[..bytes.len() - 1])?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Storage for LossyFile<'_> {
        fn sync(&mut self) -> io::Result<()> {
            Ok(())
        }

        fn length(&mut self) -> io::Result<u64> {
            self.0.length()
        }
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder");
        let name = |entry: io::Result<fs::DirEntry>| entry.expect("an entry").file_name();
        entries
            .map(|entry| name(entry).to_string_lossy().into_owned())
            .collect()
    }

    #[test]
    fn whatever_step_fails_the_old_file_is_whole_and_nothing_is_beside_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        let destination = Destination::new(&path).expect("it can be written");
        for old in [None, Some("old")] {
            let _ = fs::remove_file(&path);
            if let Some(old) = old {
                fs::write(&path, old).expect("written");
            }
            let mut failures = 0;
            let save = |calls_before| {
                destination.replace(|file| fill(&mut FailingFile { file, calls_before }, b"new and whole"))
            };
            while save(failures).is_err() {
                assert_eq!(
                    fs::read_to_string(&path).ok().as_deref(),
                    old,
                    "after {failures} calls"
                );
                assert_eq!(names(folder.path()).len(), usize::from(old.is_some()));
                failures += 1;
            }
            assert_eq!(
                failures,
                5 + 3,
                "writes of three bytes, a flush, a sync and a check"
            );
            assert_eq!(fs::read_to_string(&path).expect("there"), "new and whole");
            assert_eq!(names(folder.path()), ["a.txt"]);
        }
    }

    #[test]
    fn bytes_that_are_lost_without_an_error_are_noticed() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").expect("written");
        let destination = Destination::new(&path).expect("it can be written");
        let why = destination.replace(|file| fill(&mut LossyFile(file), b"new"));
        let why = why.expect_err("a byte is missing").to_string();
        assert!(why.contains("only 2 of 3 bytes"), "{why}");
        assert_eq!(fs::read_to_string(&path).expect("there"), "old");
    }

    #[test]
    fn a_folder_that_takes_the_name_meanwhile_is_an_error_that_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        let destination = Destination::new(&path).expect("it can be written");
        fs::create_dir(&path).expect("made");
        let why = destination.write(b"new").expect_err("a folder is there");
        assert!(format!("{why:#}").contains("cannot write "), "{why:#}");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn outputs_that_cannot_be_written_are_refused_before_the_work() {
        let folder = tempfile::tempdir().expect("a folder");
        let error = |path: &Path| {
            let why = Destination::new(path).expect_err("it cannot be written");
            format!("{why:#}")
        };
        assert!(error(&folder.path().join("no/a.txt")).contains("there is no folder"));
        assert!(error(folder.path()).contains("it is a folder"));
        assert!(error(Path::new("")).contains("a file name"));
    }
}
