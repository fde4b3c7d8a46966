//! Writes the visibility lump (PVS rows) of a map.
//!
//! Quake stores one bit row for each leaf except the first, which is solid: bit k is leaf k + 1, and a run of zero
//! bytes is stored as a zero and its length. Leafs of one cluster share a row, as do all equal rows. Quake 3 stores one
//! uncompressed row per cluster. `rewrite` puts the new lump into the file; nothing else moves.
//! Source: the source code of both engines, published by id Software, and the files themselves.
//! Cost: O(bytes + clusters²).

use super::BspError;
use super::belongs::clusters_of_leafs;
use super::lumps::Map;
use crate::quake::PortalFile;
use enfilade_bake::VisiblePairs;
use std::collections::HashMap;

/// Returns a copy of a map with the visible pairs as its PVS, which replaces the old one.
///
/// Everything else stays where it is, byte for byte, so that absolute offsets stay right: the PVS takes the bytes of the old one
/// if it fits, else it follows the last byte. Only a BSPX header and its directory move behind the furthest lump, where readers
/// look for them.
///
/// # Errors
/// Returns a [`BspError`] if the format of the map is unknown, if the map is damaged or would exceed 2 GiB, or if the portals or
/// pairs belong to another map.
pub fn with_visibility(map: &[u8], portals: &PortalFile, pairs: &VisiblePairs) -> Result<Vec<u8>, BspError> {
    check_pairs(portals, pairs)?;
    let mut map = Map::read(map)?;
    let lump = if map.format.is_quake3 {
        quake3_lump(&map, portals, pairs)?
    } else {
        quake_lump(&mut map, portals, pairs)?
    };
    map.with_visibility_lump(&lump)
}

/// Checks that the pairs have as many cells as the portals have clusters.
pub(in crate::quake) fn check_pairs(portals: &PortalFile, pairs: &VisiblePairs) -> Result<(), BspError> {
    let [pairs, clusters] = [pairs.cell_count(), portals.cells.count()];
    if pairs == clusters {
        Ok(())
    } else {
        Err(BspError::OtherPairs { pairs, clusters })
    }
}

/// Returns the size of a map's visibility lump, in bytes; 0 if no PVS has been computed.
///
/// # Errors
/// Returns a [`BspError`] if the format of the map is unknown, or if the map is damaged.
pub fn visibility_bytes(map: &[u8]) -> Result<usize, BspError> {
    let map = Map::read(map)?;
    Ok(map.lump(map.format.visibility).len())
}

/// Returns the compressed rows, and writes the offset of its row into each leaf.
fn quake_lump(map: &mut Map, portals: &PortalFile, pairs: &VisiblePairs) -> Result<Vec<u8>, BspError> {
    let clusters = clusters_of_leafs(map, portals)?;
    map.check_disjoint(map.format.leafs)?;
    let record_offsets: Vec<usize> = map
        .record_offsets(map.format.leafs, map.format.leaf_bytes)?
        .collect();
    let leafs: Vec<(usize, u32)> = std::iter::zip(record_offsets, clusters)
        .filter_map(|(place, cluster)| Some((place, cluster?)))
        .collect();
    let mut lump = Vec::new();
    let mut starts = HashMap::new();
    let mut row = vec![0; leafs.len().div_ceil(8)];
    let mut start_of = vec![None; pairs.cell_count() as usize];
    for &(place, cluster) in &leafs {
        let start = *start_of[cluster as usize].get_or_insert_with(|| {
            row.fill(0);
            for (other, &(_, at)) in leafs.iter().enumerate() {
                row[other / 8] |= u8::from(pairs.may_see(cluster, at)) << (other % 8);
            }
            let start = lump.len() as u32;
            let packed = packed(&row);
            *starts.entry(packed).or_insert_with_key(|packed| {
                lump.extend_from_slice(packed);
                start
            })
        });
        map.bytes[place + 4..place + 8].copy_from_slice(&start.to_le_bytes());
    }
    Ok(lump)
}

/// Compresses a row: replaces each run of up to 255 zero bytes by a zero and its length.
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

/// Returns the number of clusters, the bytes per row, and the rows.
fn quake3_lump(map: &Map, portals: &PortalFile, pairs: &VisiblePairs) -> Result<Vec<u8>, BspError> {
    clusters_of_leafs(map, portals)?;
    let count = pairs.cell_count();
    // Engines read rows in words of eight bytes.
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
