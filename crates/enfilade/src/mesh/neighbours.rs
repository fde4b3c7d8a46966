//! Edge adjacency of the faces of a cluster.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// A hash map for a few hundred keys that no attacker chooses.
pub(super) type SmallMap<K, V> = HashMap<K, V, BuildHasherDefault<Mix>>;

/// A fast hasher. Not resistant to chosen keys, which could at worst slow down a cluster of 128 faces.
#[derive(Default)]
pub(super) struct Mix(u64);

impl Hasher for Mix {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u32(u32::from(byte));
        }
    }

    fn write_u32(&mut self, value: u32) {
        self.0 = (self.0.rotate_left(26) ^ u64::from(value)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }

    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 32
    }
}

/// No face of the cluster is across the edge.
pub(crate) const NONE: u8 = u8::MAX;

/// Returns, for each corner of each face, the face across the edge that starts there, as a number in the cluster.
///
/// `faces` has each face's corners, as numbers that are equal for corners at the same position. Of an edge with three
/// or more faces the first two are neighbours.
pub(super) fn neighbours(faces: &[Vec<u32>]) -> Vec<Vec<u8>> {
    let mut across: Vec<Vec<u8>> = faces.iter().map(|corners| vec![NONE; corners.len()]).collect();
    let mut open: SmallMap<(u32, u32), (usize, usize)> = SmallMap::default();
    open.reserve(2 * faces.len());
    for (face, corners) in faces.iter().enumerate() {
        for (edge, &from) in corners.iter().enumerate() {
            let to = corners[(edge + 1) % corners.len()];
            let key = (from.min(to), from.max(to));
            match open.get(&key) {
                Some(&(other, edge_there)) if other != face && across[other][edge_there] == NONE => {
                    across[other][edge_there] = face as u8;
                    across[face][edge] = other as u8;
                }
                Some(_) => {}
                None => {
                    open.insert(key, (face, edge));
                }
            }
        }
    }
    across
}

/// Returns an order of the faces in which neighbours follow each other where possible.
pub(super) fn neighbours_together(across: &[Vec<u8>]) -> Vec<usize> {
    let mut order = Vec::with_capacity(across.len());
    let mut met = vec![false; across.len()];
    let mut waiting = Vec::new();
    for start in 0..across.len() {
        waiting.push(start);
        while let Some(face) = waiting.pop() {
            if std::mem::replace(&mut met[face], true) {
                continue;
            }
            order.push(face);
            let beside = across[face].iter().rev().filter(|&&other| other != NONE);
            waiting.extend(
                beside
                    .map(|&other| usize::from(other))
                    .filter(|&other| !met[other]),
            );
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_is_walked_from_one_end_to_the_other_however_its_faces_come() {
        // Triangles i, i + 1, i + 2, shuffled.
        let faces: Vec<Vec<u32>> = [3, 0, 4, 1, 2].map(|i| vec![i, i + 1, i + 2]).into();
        let across = neighbours(&faces);
        let order = neighbours_together(&across);
        let mut apart = 0;
        for pair in order.windows(2) {
            apart += usize::from(!across[pair[0]].contains(&(pair[1] as u8)));
        }
        assert!(apart <= 1, "{order:?}");
        let mut all = order.clone();
        all.sort_unstable();
        assert_eq!(all, [0, 1, 2, 3, 4]);
    }

    #[test]
    fn an_edge_joins_two_faces_and_no_third() {
        let across = neighbours(&[vec![0, 1, 2], vec![1, 0, 3], vec![0, 1, 4], vec![5, 6, 7]]);
        assert_eq!(across, [[1, NONE, NONE], [0, NONE, NONE], [NONE; 3], [NONE; 3]]);
    }
}
