//! Compiled maps: BSP29 and BSP2 of Quake, IBSP46 of Quake 3; and the lump in which engines look up what is visible.
//!
//! Quake has a row of bits for each leaf but the first, which is solid: bit k is leaf k + 1, and runs of zero bytes are a
//! zero and their number. Leafs of one cluster share a row; so do rows that are equal. Quake 3 has a row for each cluster,
//! written out. A new lump takes the place of the old one; all other lumps, and what follows them, stay byte for byte.
//! Source: the sources of both engines, as published by id Software, and the files themselves.
//! Cost: O(bytes + clusters²).

mod error;

pub use error::BspError;

use super::PortalFile;
use enfilade_bake::VisiblePairs;
use std::collections::HashMap;
use std::ops::Range;

/// Where things stand in the files of a game.
struct Format {
    /// Where the table of lumps begins, in bytes.
    table: usize,
    lumps: usize,
    visibility: usize,
    leafs: usize,
    leaf_bytes: usize,
    is_quake3: bool,
}

const BSP29: Format = Format {
    table: 4,
    lumps: 15,
    visibility: 4,
    leafs: 10,
    leaf_bytes: 28,
    is_quake3: false,
};
const BSP2: Format = Format {
    leaf_bytes: 44,
    ..BSP29
};
const IBSP46: Format = Format {
    table: 8,
    lumps: 17,
    visibility: 16,
    leafs: 4,
    leaf_bytes: 48,
    is_quake3: true,
};

/// Quake's lump of models, the bytes of one, and where in it is the number of leafs that the world has.
const MODELS: usize = 14;
const MODEL_BYTES: usize = 64;
const WORLD_LEAFS: usize = 52;

/// The bytes of a map with what is visible written into it, in place of what was there.
///
/// # Errors
/// Where the map is of no such kind, damaged, or not the one that the portals and pairs are of.
pub fn with_visibility(map: &[u8], portals: &PortalFile, pairs: &VisiblePairs) -> Result<Vec<u8>, BspError> {
    let clusters = portals.cells.count();
    if pairs.cell_count() != clusters {
        return Err(BspError::OtherPairs {
            pairs: pairs.cell_count(),
            clusters,
        });
    }
    let mut map = Map::read(map)?;
    let lump = if map.format.is_quake3 {
        quake3_lump(&map, pairs)?
    } else {
        quake_lump(&mut map, portals, pairs)?
    };
    Ok(map.with_lump(map.format.visibility, &lump))
}

struct Map {
    format: &'static Format,
    bytes: Vec<u8>,
    lumps: Vec<Range<usize>>,
}

impl Map {
    fn read(bytes: &[u8]) -> Result<Map, BspError> {
        let format = if bytes.starts_with(&29u32.to_le_bytes()) {
            &BSP29
        } else if bytes.starts_with(b"BSP2") {
            &BSP2
        } else if bytes.starts_with(b"IBSP\x2e\0\0\0") {
            &IBSP46
        } else {
            let begins = String::from_utf8_lossy(&bytes[..bytes.len().min(8)])
                .escape_debug()
                .to_string();
            return Err(BspError::NotMap { begins });
        };
        let mut lumps = Vec::new();
        for lump in 0..format.lumps {
            let at = format.table + lump * 8;
            let [start, length] = [at, at + 4].map(|at| word(bytes, at).map(i64::from));
            let (Some(start), Some(length)) = (start, length) else {
                return Err(BspError::CutShort {
                    part: "its table of lumps".to_owned(),
                    has: bytes.len(),
                });
            };
            // What is empty may be said to stand anywhere.
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

    /// Where leafs begin, one after another.
    fn leafs(&self) -> Result<Vec<usize>, BspError> {
        let Range { start, end } = self.lumps[self.format.leafs].clone();
        if (end - start) % self.format.leaf_bytes != 0 {
            return Err(BspError::OddLump {
                lump: self.format.leafs,
                bytes: end - start,
                of: self.format.leaf_bytes,
            });
        }
        Ok((start..end).step_by(self.format.leaf_bytes).collect())
    }

    /// All lumps in the order in which they stand, one of them another than before, and what follows them.
    fn with_lump(&self, changed: usize, lump: &[u8]) -> Vec<u8> {
        let mut order: Vec<usize> = (0..self.lumps.len())
            .filter(|&at| !self.lumps[at].is_empty() || at == changed)
            .collect();
        let last = self.lumps.iter().map(|lump| lump.end).max().unwrap_or(0);
        // An empty lump may be said to stand anywhere; a new one goes last.
        let place = |at: usize| {
            if self.lumps[at].is_empty() {
                last
            } else {
                self.lumps[at].start
            }
        };
        order.sort_by_key(|&at| place(at));
        let table_end = self.format.table + self.format.lumps * 8;
        // Some compilers leave words of their own between the table and the first lump.
        let first = order
            .iter()
            .map(|&at| place(at))
            .min()
            .unwrap_or(table_end)
            .max(table_end);
        let mut bytes = self.bytes[..first.min(self.bytes.len())].to_vec();
        for at in order {
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            let entry = self.format.table + at * 8;
            let content = if at == changed {
                lump
            } else {
                &self.bytes[self.lumps[at].clone()]
            };
            let stands = [bytes.len() as u32, content.len() as u32]
                .map(u32::to_le_bytes)
                .concat();
            bytes[entry..entry + 8].copy_from_slice(&stands);
            bytes.extend_from_slice(content);
        }
        if let Some(rest) = self
            .bytes
            .get(last.next_multiple_of(4)..)
            .filter(|rest| !rest.is_empty())
        {
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            bytes.extend_from_slice(rest);
        }
        bytes
    }
}

/// Rows of leafs, zero bytes counted; and in each leaf where its row begins.
fn quake_lump(map: &mut Map, portals: &PortalFile, pairs: &VisiblePairs) -> Result<Vec<u8>, BspError> {
    let leafs = map.leafs()?;
    let models = map.lumps[MODELS].clone();
    let world_leafs = word(&map.bytes[models.clone()], WORLD_LEAFS).filter(|_| models.len() >= MODEL_BYTES);
    let Some(world_leafs) = world_leafs else {
        return Err(BspError::OddLump {
            lump: MODELS,
            bytes: models.len(),
            of: MODEL_BYTES,
        });
    };
    let clusters: Vec<u32> = match &portals.cluster_of_leaf {
        Some(clusters) => clusters.clone(),
        None => (0..pairs.cell_count()).collect(),
    };
    if i64::from(world_leafs) != clusters.len() as i64 || leafs.len() <= clusters.len() {
        return Err(BspError::OtherMap {
            map: world_leafs.into(),
            portals: clusters.len(),
            what: "leafs",
        });
    }
    let mut lump = Vec::new();
    let mut starts = HashMap::new();
    let mut row = vec![0; clusters.len().div_ceil(8)];
    let mut start_of = vec![None; pairs.cell_count() as usize];
    for (leaf, &cluster) in clusters.iter().enumerate() {
        let start = *start_of[cluster as usize].get_or_insert_with(|| {
            row.fill(0);
            for (other, &at) in clusters.iter().enumerate() {
                row[other / 8] |= u8::from(pairs.sees(cluster, at)) << (other % 8);
            }
            let start = lump.len() as u32;
            let packed = packed(&row);
            *starts.entry(packed).or_insert_with_key(|packed| {
                lump.extend_from_slice(packed);
                start
            })
        });
        let at = leafs[leaf + 1] + 4;
        map.bytes[at..at + 4].copy_from_slice(&start.to_le_bytes());
    }
    Ok(lump)
}

/// Runs of zero bytes as a zero and how many.
fn packed(row: &[u8]) -> Vec<u8> {
    let mut packed = Vec::new();
    for run in row.chunk_by(|a, b| *a == 0 && *b == 0) {
        if run[0] != 0 {
            packed.push(run[0]);
            continue;
        }
        for part in run.chunks(255) {
            packed.extend([0, part.len() as u8]);
        }
    }
    packed
}

/// How many clusters, the bytes of a row, and the rows.
fn quake3_lump(map: &Map, pairs: &VisiblePairs) -> Result<Vec<u8>, BspError> {
    let count = pairs.cell_count();
    let leafs = map.leafs()?;
    // Solid leafs say −1.
    let clusters = leafs
        .iter()
        .filter_map(|&leaf| word(&map.bytes, leaf))
        .max()
        .map_or(0, |most| i64::from(most) + 1);
    if clusters != i64::from(count) {
        return Err(BspError::OtherMap {
            map: clusters,
            portals: count as usize,
            what: "clusters",
        });
    }
    // Engines read rows by words of eight bytes.
    let row_bytes = count.div_ceil(64) * 8;
    let mut lump = [count.to_le_bytes(), row_bytes.to_le_bytes()].concat();
    for cluster in 0..count {
        let start = lump.len();
        lump.resize(start + row_bytes as usize, 0);
        for other in pairs.seen_from(cluster) {
            lump[start + other as usize / 8] |= 1 << (other % 8);
        }
    }
    Ok(lump)
}

fn word(bytes: &[u8], at: usize) -> Option<i32> {
    let four = bytes.get(at..at + 4)?;
    Some(i32::from_le_bytes([four[0], four[1], four[2], four[3]]))
}
