//! Files that are looked at where they are, as if all their bytes were in memory.
//!
//! Source: memmap2.
//! Cost: that of opening a file; bytes are read when they are looked at, and forgotten by the system as it likes.

use memmap2::{Mmap, MmapOptions};
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// The bytes of a file.
#[derive(Clone, Debug)]
pub(super) struct Map(Arc<Mmap>);

impl AsRef<[u8]> for Map {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// Maps a file that has so many bytes.
#[allow(unsafe_code)]
pub(super) fn map(path: &Path, bytes: usize) -> std::io::Result<Map> {
    let file = File::open(path)?;
    // SAFETY: the bytes are only read. That nobody cuts the file off or writes into it as long as it is looked at is what
    // `ReadOptions::limit_bytes` asks of whoever allows it; its length was checked, and no more is mapped.
    let map = unsafe { MmapOptions::new().len(bytes).map(&file)? };
    Ok(Map(Arc::new(map)))
}
