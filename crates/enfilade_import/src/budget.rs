//! The memory budget of a reader: peak memory stays below twice the limit, whatever a file holds.
//!
//! Readers charge what they *build*, before they build it; the bytes that they read say little about it. `tests/memory.rs` has a
//! bomb for each format: small files that become large.
//!
//! | reader | charged beside the bytes of the file |
//! |---|---|
//! | glTF | by brackets, commas and texts of the JSON; each node, room, mesh, triangle and vertex attribute, for each pose of a mesh; joints, and morph targets with a weight; corners of openings; compressed views; instances; the paths of other files |
//! | tiles | their feature table; a transform, the items and lights of each instance, beside what their glTF takes |
//! | images | texels, and what decodes them at the same time |
//! | OBJ | tables by the counts of a first pass; each group, material file and its materials; triangles, corners of long polygons |
//! | Quake maps | planes, nodes and leafs by the length of the map; textures; faces, corners, items and entities; lightmaps; rows of the PVS |
//! | portal files | eight times their length |
//! | heightmaps | samples, and the blocks that they become |
//! | baked scenes | each value of the scene's tables; rooms, items, meshes with their clusters and nodes; hints; texels |
//! | pages of baked scenes | when opened: the tables as above, and a box for each mesh; when loaded: [`Pages::bytes`](crate::Pages::bytes), which the streamer reserves |

use crate::BrokenRule;

/// Memory of a mesh beside its vertices, faces and clusters, in bytes: its lists, trees, and its share of a sector.
pub(crate) const BYTES_PER_MESH: u64 = 1600;

/// Bytes of memory that a reader may still use. Estimates are subtracted before anything is allocated.
#[derive(Clone, Debug)]
pub(crate) struct Budget {
    limit: u64,
    taken: u64,
}

impl Budget {
    pub(crate) fn new(limit: u64) -> Budget {
        Budget { limit, taken: 0 }
    }

    /// Returns `true` if at least `bytes` bytes are left.
    pub(crate) fn has(&self, bytes: u64) -> bool {
        self.taken.saturating_add(bytes) <= self.limit
    }

    /// Reserves `bytes` bytes for the element `place`, which an error names.
    pub(crate) fn take(&mut self, bytes: u64, place: impl FnOnce() -> String) -> Result<(), BrokenRule> {
        let taken = self.taken.saturating_add(bytes);
        if taken > self.limit {
            return Err(BrokenRule::TooLarge {
                place: place(),
                needs_bytes: taken,
                limit_bytes: self.limit,
            });
        }
        self.taken = taken;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_and_takes_nothing() {
        let mut budget = Budget::new(100);
        let mut take = |bytes| budget.take(bytes, String::new).is_ok();
        assert_eq!(
            [60, 41, u64::MAX, 40, 1].map(&mut take),
            [true, false, false, true, false]
        );
    }
}
