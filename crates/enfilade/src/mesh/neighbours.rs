//! Edge adjacency of the faces of a cluster, and an order of the faces in which neighbours follow each other.
//!
//! Corners at the same position share a number, even if the input has the position twice; faces that share an edge share
//! two numbers. Two hash tables, kept from cluster to cluster, find equal positions and equal edges.
//! Cost: O(corners), unless someone chooses positions with equal hashes; a cluster has at most 128 faces.

/// No face of the cluster is across the edge.
pub(crate) const NONE: u8 = u8::MAX;

/// The adjacency of the faces of a cluster.
#[derive(Default)]
pub(super) struct Adjacency {
    /// The distinct positions, as bits.
    positions: Vec<[u32; 3]>,
    /// For each vertex the number of its position.
    numbers: Vec<u32>,
    /// For each corner its face, the edge that starts there, and the face across it, or [`NONE`].
    faces: Vec<u8>,
    edges: Vec<[u32; 2]>,
    across: Vec<u8>,
    /// The faces, neighbours together, and the rank of each face in that order.
    order: Vec<u8>,
    ranks: Vec<u8>,
    waiting: Vec<u8>,
    table: PositionTable,
}

impl Adjacency {
    /// Replaces the faces, at most 128. `starts` has the start of each face in `corners`, which are numbers of vertices,
    /// and the end of the last.
    pub(super) fn find(&mut self, vertices: &[[f32; 3]], corners: &[u32], starts: &[u32]) {
        self.positions.clear();
        self.numbers.clear();
        self.table.clear(vertices.len());
        for vertex in vertices {
            // -0 is equal to 0.
            let bits = vertex.map(|value| (value + 0.0).to_bits());
            let known = self
                .table
                .slot(bits, |number| self.positions[number as usize] == bits);
            if *known == VACANT {
                *known = self.positions.len() as u32;
                self.positions.push(bits);
            }
            self.numbers.push(*known);
        }
        self.faces.clear();
        self.edges.clear();
        for (face, ends) in starts.windows(2).enumerate() {
            let corners = &corners[ends[0] as usize..ends[1] as usize];
            let next = corners.iter().skip(1).chain(corners.first());
            for (from, to) in corners.iter().zip(next) {
                let [from, to] = [from, to].map(|&corner| self.numbers[corner as usize]);
                self.edges.push([from.min(to), from.max(to)]);
                self.faces.push(face as u8);
            }
        }
        self.find_across();
        self.put_together(starts);
    }

    /// Of an edge with three or more faces the first two are neighbours.
    fn find_across(&mut self) {
        self.across.clear();
        self.across.resize(self.edges.len(), NONE);
        self.table.clear(self.edges.len());
        for (edge, &ends) in self.edges.iter().enumerate() {
            let known = self
                .table
                .slot([ends[0], ends[1], 0], |other| self.edges[other as usize] == ends);
            if *known == VACANT {
                *known = edge as u32;
                continue;
            }
            let other = *known as usize;
            if self.faces[other] != self.faces[edge] && self.across[other] == NONE {
                self.across[other] = self.faces[edge];
                self.across[edge] = self.faces[other];
            }
        }
    }

    /// Orders the faces by a depth-first search over their edges.
    fn put_together(&mut self, starts: &[u32]) {
        const UNRANKED: u8 = u8::MAX;
        let count = starts.len() - 1;
        self.order.clear();
        self.ranks.clear();
        self.ranks.resize(count, UNRANKED);
        for start in 0..count as u8 {
            self.waiting.push(start);
            while let Some(face) = self.waiting.pop() {
                let rank = &mut self.ranks[usize::from(face)];
                if *rank != UNRANKED {
                    continue;
                }
                *rank = self.order.len() as u8;
                self.order.push(face);
                let [start, end] = [0, 1].map(|end| starts[usize::from(face) + end] as usize);
                let beside = self.across[start..end].iter().rev();
                let waits = |&&other: &&u8| other != NONE && self.ranks[usize::from(other)] == UNRANKED;
                self.waiting.extend(beside.filter(waits));
            }
        }
    }

    /// Returns the faces, neighbours together where possible.
    pub(super) fn order(&self) -> &[u8] {
        &self.order
    }

    /// Returns the face across the edge that starts at a corner, by its rank in [`Adjacency::order`], or [`NONE`].
    pub(super) fn across(&self, corner: u32) -> u8 {
        let other = usize::from(self.across[corner as usize]);
        self.ranks.get(other).copied().unwrap_or(NONE)
    }
}

/// A free slot of a table.
pub(crate) const VACANT: u32 = u32::MAX;

/// A hash table of numbers with linear probing, at most half full. The keys are stored elsewhere.
#[derive(Default)]
pub(crate) struct PositionTable {
    slots: Vec<u32>,
}

impl PositionTable {
    /// Removes everything and makes room for a number of keys.
    pub(crate) fn clear(&mut self, keys: usize) {
        self.slots.clear();
        self.slots.resize((2 * keys).next_power_of_two(), VACANT);
    }

    /// Returns the slot of a key: the number for which `is_key` returns `true`, or [`VACANT`].
    pub(crate) fn slot(&mut self, key: [u32; 3], is_key: impl Fn(u32) -> bool) -> &mut u32 {
        let mut hash = 0_u64;
        for part in key {
            hash = (hash.rotate_left(26) ^ u64::from(part)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        }
        let mask = self.slots.len() - 1;
        let mut slot = (hash >> 32) as usize & mask;
        while self.slots[slot] != VACANT && !is_key(self.slots[slot]) {
            slot = (slot + 1) & mask;
        }
        &mut self.slots[slot]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Finds the adjacency of triangles. Vertices 10 to 19 are at the positions of vertices 0 to 9.
    fn adjacency(faces: &[[u32; 3]]) -> Adjacency {
        let mut found = Adjacency::default();
        let vertices: Vec<[f32; 3]> = (0..20).map(|vertex| [(vertex % 10) as f32, 0.0, 1.0]).collect();
        let starts: Vec<u32> = (0..=faces.len() as u32).map(|face| 3 * face).collect();
        found.find(&vertices, faces.as_flattened(), &starts);
        found
    }

    #[test]
    fn a_strip_is_walked_from_one_end_to_the_other_however_its_faces_come() {
        // Triangles i, i + 1, i + 2, shuffled; one of them with vertices of its own.
        let found = adjacency(&[[3, 4, 5], [0, 1, 2], [14, 15, 16], [1, 2, 3], [2, 3, 4]]);
        let is_next = |&pair: &usize| {
            let [before, after] = [0, 1].map(|end| u32::from(found.order()[pair + end]));
            (3 * before..3 * before + 3).any(|corner| found.across[corner as usize] == after as u8)
        };
        assert!((0..4).filter(is_next).count() >= 3, "{:?}", found.order());
        let mut all = found.order().to_vec();
        all.sort_unstable();
        assert_eq!(all, [0, 1, 2, 3, 4]);
    }

    #[test]
    fn an_edge_joins_two_faces_and_no_third() {
        let found = adjacency(&[[0, 1, 2], [11, 10, 3], [0, 1, 4], [5, 6, 7]]);
        assert_eq!(found.order(), [0, 1, 2, 3]);
        let across: Vec<u8> = (0..12).map(|corner| found.across(corner)).collect();
        assert_eq!(across[..6], [1, NONE, NONE, 0, NONE, NONE]);
        assert_eq!(across[6..], [NONE; 6]);
    }
}
