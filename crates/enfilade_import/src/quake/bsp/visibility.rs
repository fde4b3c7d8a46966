//! What is visible, as engines look it up.
//!
//! Quake has a row of bits for each leaf but the first, which is solid: bit k is leaf k + 1, and runs of zero bytes are a
//! zero and their number. Leafs of one cluster share a row; so do rows that are equal. Quake 3 has a row for each cluster,
//! written out. A new lump takes the place of the old one; all other lumps, and what follows them, stay byte for byte.
//! Source: the sources of both engines, as published by id Software, and the files themselves.
//! Cost: O(bytes + clusters²).

use super::BspError;
use super::belongs::clusters_of_leafs;
use super::lumps::Map;
use crate::quake::PortalFile;
use enfilade_bake::VisiblePairs;
use std::collections::HashMap;

/// The bytes of a map with what is visible written into it, in place of what was there.
///
/// # Errors
/// Where the map is of no such kind, damaged, or not the one that the portals and pairs are of.
pub fn with_visibility(map: &[u8], portals: &PortalFile, pairs: &VisiblePairs) -> Result<Vec<u8>, BspError> {
    check_pairs(portals, pairs)?;
    let mut map = Map::read(map)?;
    let lump = if map.format.is_quake3 {
        quake3_lump(&map, portals, pairs)?
    } else {
        quake_lump(&mut map, portals, pairs)?
    };
    Ok(map.with_lump(map.format.visibility, &lump))
}

/// Checks that the pairs are of as many cells as the portals.
pub(in crate::quake) fn check_pairs(portals: &PortalFile, pairs: &VisiblePairs) -> Result<(), BspError> {
    let [pairs, clusters] = [pairs.cell_count(), portals.cells.count()];
    if pairs == clusters {
        Ok(())
    } else {
        Err(BspError::OtherPairs { pairs, clusters })
    }
}

/// How many bytes of a map say what is visible; 0 where nobody has found it out yet.
///
/// # Errors
/// Where the map is of no such kind, or damaged.
pub fn visibility_bytes(map: &[u8]) -> Result<usize, BspError> {
    let map = Map::read(map)?;
    Ok(map.lump(map.format.visibility).len())
}

/// Rows of leafs, zero bytes counted; and in each leaf where its row begins.
fn quake_lump(map: &mut Map, portals: &PortalFile, pairs: &VisiblePairs) -> Result<Vec<u8>, BspError> {
    let clusters = clusters_of_leafs(map, portals)?;
    let places: Vec<usize> = map.places(map.format.leafs, map.format.leaf_bytes)?.collect();
    let leafs: Vec<(usize, u32)> = std::iter::zip(places, clusters)
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
                row[other / 8] |= u8::from(pairs.sees(cluster, at)) << (other % 8);
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
fn quake3_lump(map: &Map, portals: &PortalFile, pairs: &VisiblePairs) -> Result<Vec<u8>, BspError> {
    clusters_of_leafs(map, portals)?;
    let count = pairs.cell_count();
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
