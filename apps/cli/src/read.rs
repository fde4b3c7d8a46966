//! Reads whole files. Refuses directories, pipes, devices and files above a limit before reading anything.

use crate::text;
use anyhow::{Context, Result, anyhow};
use enfilade_import::{BrokenRule, file_bytes};
use std::path::Path;

/// Reads a file of at most `limit` bytes. `remedy` is appended to the error for a larger one.
pub(crate) fn read_file(path: &Path, limit: u64, remedy: &str) -> Result<Vec<u8>> {
    let fails = || format!("cannot read {}", path.display());
    let read = file_bytes(path, limit).map_err(|why| match why.rule {
        BrokenRule::Unreadable(why) => why.into(),
        BrokenRule::TooLarge { needs_bytes, .. } => anyhow!(
            "it has {}, above the limit of {}; {remedy}",
            text::bytes(needs_bytes),
            text::bytes(limit)
        ),
        rule => anyhow!("it {rule}"),
    });
    read.with_context(fails)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

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
