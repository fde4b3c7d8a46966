//! Reads whole files. Refuses directories, pipes, devices and files above a limit before reading anything.

use crate::text;
use anyhow::{Context, Result, bail};
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// Reads a file of at most `limit` bytes. `remedy` is appended to the error for a larger one.
pub(crate) fn read_file(path: &Path, limit: u64, remedy: &str) -> Result<Vec<u8>> {
    let fails = || format!("cannot read {}", path.display());
    // Checked before opening: opening a pipe blocks until someone writes.
    let there = fs::metadata(path).with_context(fails)?;
    if !there.is_file() {
        bail!(
            "{}: it is not a file, but a folder, a pipe or a device; name a file",
            fails()
        );
    }
    let mut bytes = Vec::new();
    let file = File::open(path).with_context(fails)?;
    let length = file.metadata().with_context(fails)?.len();
    if length <= limit {
        // One byte more, to notice a file that has grown meanwhile.
        file.take(limit.saturating_add(1))
            .read_to_end(&mut bytes)
            .with_context(fails)?;
    }
    let length = length.max(bytes.len() as u64);
    if length > limit {
        bail!(
            "{}: it has {}, above the limit of {}; {remedy}",
            fails(),
            text::bytes(length),
            text::bytes(limit)
        );
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_more_bytes_than_allowed_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        fs::write(&path, "four").expect("written");
        let read = |limit| read_file(&path, limit, "cut it").map_err(|why| format!("{why:#}"));
        assert_eq!(read(4).as_deref(), Ok(&b"four"[..]));
        let why = read(3).expect_err("it is too long");
        assert!(
            why.ends_with("it has 4 bytes, above the limit of 3 bytes; cut it"),
            "{why}"
        );
    }
}
