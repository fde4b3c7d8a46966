//! Memory-mapped files.
//!
//! Source: memmap2.
//! Cost: opening a file; the operating system reads pages on access and evicts them as needed.

use memmap2::{Mmap, MmapOptions};
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// The bytes of a mapped file.
#[derive(Clone, Debug)]
pub(crate) struct Map(Arc<Mmap>);

impl AsRef<[u8]> for Map {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

/// Maps the first `bytes` bytes of a file.
#[allow(unsafe_code)]
pub(crate) fn map(path: &Path, bytes: usize) -> std::io::Result<Map> {
    let file = File::open(path)?;
    // SAFETY: the bytes are only read. `read` and `ReadOptions::limit_bytes` require that nobody truncates or writes the
    // file while it is mapped; the caller checked its length, and no more is mapped.
    let map = unsafe { MmapOptions::new().len(bytes).map(&file)? };
    Ok(Map(Arc::new(map)))
}
