//! Reads the lump table of a compiled map.
//!
//! Fields are read by their offsets, not as records through a crate such as `zerocopy`: the three formats differ in the
//! offsets and widths of fields, and each value is validated as it is read.

use super::BspError;
use crate::gltf;
use std::ops::Range;

/// Layout of a map format: lump indices, and record sizes in bytes.
#[derive(Debug)]
pub(crate) struct Format {
    /// Offset of the lump table, in bytes.
    table: usize,
    pub(super) lumps: usize,
    pub(crate) entities: usize,
    pub(crate) planes: usize,
    pub(crate) plane_bytes: usize,
    pub(crate) nodes: usize,
    pub(crate) node_bytes: usize,
    pub(crate) leafs: usize,
    pub(crate) leaf_bytes: usize,
    pub(crate) models: usize,
    pub(crate) model_bytes: usize,
    pub(crate) visibility: usize,
    /// Whether most indices are 16-bit (BSP29).
    pub(crate) is_short: bool,
    pub(crate) is_quake3: bool,
}

const BSP29: Format = Format {
    table: 4,
    lumps: 15,
    entities: 0,
    planes: 1,
    plane_bytes: 20,
    nodes: 5,
    node_bytes: 24,
    leafs: 10,
    leaf_bytes: 28,
    models: 14,
    model_bytes: 64,
    visibility: 4,
    is_short: true,
    is_quake3: false,
};
const BSP2: Format = Format {
    node_bytes: 44,
    leaf_bytes: 44,
    is_short: false,
    ..BSP29
};
const IBSP46: Format = Format {
    table: 8,
    lumps: 17,
    entities: 0,
    planes: 2,
    plane_bytes: 16,
    nodes: 3,
    node_bytes: 36,
    leafs: 4,
    leaf_bytes: 48,
    models: 7,
    model_bytes: 40,
    visibility: 16,
    is_short: false,
    is_quake3: true,
};

impl Format {
    /// Returns the name of the format, such as `BSP29`.
    pub(crate) fn name(&self) -> &'static str {
        match (self.is_quake3, self.is_short) {
            (true, _) => "IBSP46",
            (_, true) => "BSP29",
            (_, false) => "BSP2",
        }
    }

    /// Returns the offset of the entry of a lump in the lump table: the offset and the length of the lump.
    pub(super) fn lump_entry(&self, lump: usize) -> usize {
        self.table + lump * 8
    }

    /// Returns the end of the furthest lump of a file that has a valid lump table, as readers of BSPX compute it: an empty
    /// lump counts by its offset.
    pub(super) fn furthest_end(&self, bytes: &[u8]) -> usize {
        let end = |lump| {
            let entry = self.lump_entry(lump);
            let [start, length] = [entry, entry + 4].map(|at| word(bytes, at).unwrap_or(0).max(0));
            start as usize + length as usize
        };
        (0..self.lumps).map(end).max().unwrap_or(0)
    }
}

/// Offset of the number of world leafs in a Quake model record, in bytes.
const WORLD_LEAFS: usize = 52;

/// The bytes of a map and the ranges of its lumps.
#[derive(Debug)]
pub(crate) struct Map {
    pub(crate) format: &'static Format,
    pub(crate) bytes: Vec<u8>,
    lumps: Vec<Range<usize>>,
}

impl Map {
    /// Detects the format and reads the lump table.
    pub(crate) fn read(bytes: &[u8]) -> Result<Map, BspError> {
        let format = if bytes.starts_with(&29u32.to_le_bytes()) {
            &BSP29
        } else if bytes.starts_with(b"BSP2") {
            &BSP2
        } else if bytes.starts_with(b"IBSP\x2e\0\0\0") {
            &IBSP46
        } else {
            let begins = gltf::beginning(bytes);
            return Err(BspError::NotMap { begins });
        };
        let mut lumps = Vec::new();
        for lump in 0..format.lumps {
            let at = format.lump_entry(lump);
            let [start, length] = [at, at + 4].map(|at| word(bytes, at).map(i64::from));
            let (Some(start), Some(length)) = (start, length) else {
                return Err(BspError::CutShort {
                    part: "its lump table".to_owned(),
                    has: bytes.len(),
                });
            };
            // An empty lump may have any offset.
            let start = if length == 0 { 0 } else { start };
            if start < 0 || length < 0 || start + length > bytes.len() as i64 {
                return Err(BspError::CutShort {
                    part: format!("its lump {lump}"),
                    has: bytes.len(),
                });
            }
            lumps.push(start as usize..(start + length) as usize);
        }
        Ok(Map {
            format,
            bytes: bytes.to_vec(),
            lumps,
        })
    }

    /// Returns the range of a lump in the file.
    pub(super) fn lump_range(&self, number: usize) -> Range<usize> {
        self.lumps[number].clone()
    }

    /// Returns the bytes of a lump.
    pub(crate) fn lump(&self, number: usize) -> &[u8] {
        &self.bytes[self.lump_range(number)]
    }

    /// Returns the file offsets of the records of a lump, each `of` bytes long.
    pub(crate) fn record_offsets(
        &self,
        lump: usize,
        of: usize,
    ) -> Result<impl ExactSizeIterator<Item = usize>, BspError> {
        let start = self.lumps[lump].start;
        let count = self.records(lump, of)?.len();
        Ok((0..count).map(move |at| start + at * of))
    }

    /// Returns the records of a lump, each `of` bytes long.
    pub(crate) fn records(
        &self,
        lump: usize,
        of: usize,
    ) -> Result<std::slice::ChunksExact<'_, u8>, BspError> {
        let bytes = self.lump(lump);
        if !bytes.len().is_multiple_of(of) {
            let bytes = bytes.len();
            return Err(BspError::OddLump { lump, bytes, of });
        }
        Ok(bytes.chunks_exact(of))
    }

    /// Returns the number of world leafs of a Quake map, without the first, solid one.
    pub(crate) fn world_leafs(&self) -> Result<i32, BspError> {
        let lump = self.format.models;
        let of = self.format.model_bytes;
        let world = self.records(lump, of)?.next();
        let leafs = world.and_then(|world| word(world, WORLD_LEAFS));
        leafs.ok_or(BspError::OddLump { lump, bytes: 0, of })
    }
}

/// Reads a little-endian `i32`; `None` past the end.
pub(crate) fn word(bytes: &[u8], at: usize) -> Option<i32> {
    let four = bytes.get(at..at + 4)?;
    Some(i32::from_le_bytes([four[0], four[1], four[2], four[3]]))
}
