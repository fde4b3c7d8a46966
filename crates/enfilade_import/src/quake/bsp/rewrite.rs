//! Replaces the visibility lump of a map without moving any other byte.
//!
//! Blocks behind or between the lumps may be named by absolute offsets, such as those of a BSPX directory, or by rules that are
//! not known here. So a new lump takes the bytes of the old one if it fits, and else follows the last byte of the file. Only the
//! BSPX header and its directory move, because readers look for them behind the furthest lump, at the next multiple of 4.
//! Source: BSPX as read by FTEQW, QSS and ericw-tools.
//! Cost: O(bytes + lumps + blocks).

use super::BspError;
use super::lumps::{Map, word};
use std::ops::Range;

/// Size of the BSPX header: magic and number of blocks.
const HEADER: usize = 8;
/// Size of an entry of the BSPX directory: the name, the offset and the length of a block.
const ENTRY: usize = 32;
/// Size of the name.
const NAME: usize = 24;

impl Map {
    /// Returns the file with another visibility lump.
    pub(super) fn with_visibility_lump(&self, lump: &[u8]) -> Result<Vec<u8>, BspError> {
        let number = self.format.visibility;
        let old = self.lump_range(number);
        let directory = self.bspx_directory();
        // The old lump, and the directory if it follows: it moves, whatever happens.
        let behind = old.end.next_multiple_of(4);
        let end = match &directory {
            Some(directory) if directory.start == behind => directory.end,
            _ => old.end,
        };
        let is_free = !old.is_empty() && self.block_within(old.start..end, number).is_none();
        let mut bytes = self.bytes.clone();
        let start = if is_free && end == bytes.len() {
            bytes.truncate(old.start);
            bytes.extend_from_slice(lump);
            old.start
        } else if is_free && lump.len() <= old.len() {
            bytes[old.clone()].fill(0);
            bytes[old.start..][..lump.len()].copy_from_slice(lump);
            old.start
        } else {
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            let start = bytes.len();
            bytes.extend_from_slice(lump);
            start
        };
        let entry = [start, lump.len()].map(|number| (number as u32).to_le_bytes());
        let entry_at = self.format.lump_entry(number);
        bytes[entry_at..entry_at + 8].copy_from_slice(&entry.concat());
        if let Some(directory) = directory {
            let to = self.format.furthest_end(&bytes).next_multiple_of(4);
            bytes.resize(bytes.len().max(to + directory.len()), 0);
            bytes[to..to + directory.len()].copy_from_slice(&self.bytes[directory]);
        }
        // Offsets are signed.
        if i32::try_from(bytes.len()).is_err() {
            return Err(BspError::TooLong { bytes: bytes.len() });
        }
        Ok(bytes)
    }

    /// Checks that no other block shares bytes with a lump, which is about to be changed in place.
    pub(in crate::quake) fn check_disjoint(&self, lump: usize) -> Result<(), BspError> {
        match self.block_within(self.lump_range(lump), lump) {
            Some(other) => Err(BspError::Overlap { lump, other }),
            None => Ok(()),
        }
    }

    /// Returns the name of a block that has bytes in a range, other than this lump and the BSPX directory.
    fn block_within(&self, range: Range<usize>, lump: usize) -> Option<String> {
        let is_within = |block: &Range<usize>| range.start.max(block.start) < range.end.min(block.end);
        if is_within(&(0..self.format.lump_entry(self.format.lumps))) {
            return Some("its lump table".to_owned());
        }
        let mut others = (0..self.format.lumps).filter(|&other| other != lump);
        if let Some(other) = others.find(|&other| is_within(&self.lump_range(other))) {
            return Some(format!("its lump {other}"));
        }
        let directory = self.bspx_directory()?;
        let mut entries = self.bytes[directory].get(HEADER..)?.chunks_exact(ENTRY);
        let entry = entries.find(|entry| {
            let number = |at| word(entry, at).map_or(0, |number| number as u32 as usize);
            let offset = number(NAME);
            is_within(&(offset..offset.saturating_add(number(NAME + 4))))
        })?;
        let name = String::from_utf8_lossy(&entry[..NAME]);
        Some(format!("its BSPX block {}", name.trim_end_matches('\0')))
    }

    /// Returns the range of the BSPX header and its directory; `None` if there is none.
    fn bspx_directory(&self) -> Option<Range<usize>> {
        let start = self.format.furthest_end(&self.bytes).next_multiple_of(4);
        let header = self.bytes.get(start..start.checked_add(HEADER)?)?;
        let blocks = header.strip_prefix(b"BSPX").and_then(|count| word(count, 0))?;
        let length = usize::try_from(blocks).ok()?.checked_mul(ENTRY)?;
        let end = (start + HEADER).checked_add(length)?;
        (end <= self.bytes.len()).then_some(start..end)
    }
}
