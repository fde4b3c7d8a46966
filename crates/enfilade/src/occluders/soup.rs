//! Triangle soup with adjacency: the opaque faces of a mesh with welded vertices, and the faces along every edge.
//!
//! Vertices at one position are merged, whatever their indices, and faces are connected if they share both ends of an
//! edge; so there is nothing between them, not even a crack.
//! Cost: O(n log n) for sorting vertices and edges.

use crate::geometry::Material;
use crate::mesh::{Cluster, Mesh};
use glam::DVec3;

/// Opaque faces of a mesh that may occlude, with their adjacency.
pub(super) struct Soup {
    /// Welded vertex positions.
    pub(super) points: Vec<DVec3>,
    /// Start of each face's corners, and the end of the last.
    starts: Vec<u32>,
    /// Corners of the faces, as indices into `points`.
    corners: Vec<u32>,
    /// Area vector of each face: twice the area times the unit normal.
    normals: Vec<DVec3>,
    /// Whether each face is double-sided.
    pub(super) double_sided: Vec<bool>,
    /// For each corner, the index of the edge that begins there.
    pub(super) edges: Vec<u32>,
    /// For each edge, the start of its run in `sharers`, and the end of the last.
    pub(super) runs: Vec<u32>,
    /// Faces along each edge.
    pub(super) sharers: Vec<u32>,
}

impl Soup {
    /// Collects the opaque faces of a mesh that are not marked as detail; `None` if it has none.
    pub(super) fn of(mesh: &Mesh, materials: &[Material]) -> Option<Soup> {
        let material = |cluster: &Cluster| &materials[cluster.material.0 as usize];
        let chosen = |cluster: &&Cluster| !cluster.faces.is_empty() && material(cluster).can_occlude();
        let (mut starts, mut corners, mut double_sided) = (vec![0], Vec::new(), Vec::new());
        for cluster in mesh.clusters().iter().filter(chosen) {
            let both = material(cluster).double_sided;
            for face in cluster.faces.clone() {
                corners.extend_from_slice(mesh.face(face));
                starts.push(corners.len() as u32);
                double_sided.push(both);
            }
        }
        Soup::new(mesh.positions(), starts, corners, double_sided)
    }

    /// Connects faces, given by the start of each in `corners`; `None` if there are none.
    pub(super) fn new(
        positions: &[[f32; 3]],
        starts: Vec<u32>,
        mut corners: Vec<u32>,
        double_sided: Vec<bool>,
    ) -> Option<Soup> {
        if double_sided.is_empty() {
            return None;
        }
        let points = weld(positions, &mut corners);
        let normals = starts
            .windows(2)
            .map(|ends| {
                twice_area(
                    corners[ends[0] as usize..ends[1] as usize]
                        .iter()
                        .map(|&c| points[c as usize]),
                )
            })
            .collect();
        let (edges, runs, sharers) = share_edges(&starts, &corners);
        Some(Soup {
            points,
            starts,
            corners,
            normals,
            double_sided,
            edges,
            runs,
            sharers,
        })
    }

    /// Returns the number of faces.
    pub(super) fn face_count(&self) -> usize {
        self.double_sided.len()
    }

    /// Returns the range of a face's corners among all corners.
    pub(super) fn range(&self, face: u32) -> std::ops::Range<usize> {
        self.starts[face as usize] as usize..self.starts[face as usize + 1] as usize
    }

    /// Returns the corners of a face, as indices into `points`.
    pub(super) fn face(&self, face: u32) -> &[u32] {
        &self.corners[self.range(face)]
    }

    /// Returns the area vector of a face: twice the area times the unit normal.
    pub(super) fn normal(&self, face: u32) -> DVec3 {
        self.normals[face as usize]
    }

    /// Returns the first three corners of a face, sorted.
    fn least_corners(&self, face: u32) -> [u32; 3] {
        let corners = self.face(face);
        let mut least = [corners[0], corners[1], corners[2]];
        least.sort_unstable();
        least
    }

    /// Returns the area of a face.
    pub(super) fn area(&self, face: u32) -> f64 {
        0.5 * self.normals[face as usize].length()
    }

    /// Returns the number of triangles of a face.
    pub(super) fn triangles(&self, face: u32) -> u64 {
        self.range(face).len() as u64 - 2
    }

    /// Returns the boundary edges of some faces of one sheet, from and to, as indices into `points`; the inside is on
    /// the left, viewed from the side that `normal` points to. Edges between two of the faces cancel.
    pub(super) fn boundary(&self, faces: &[u32], normal: DVec3) -> Vec<[u32; 2]> {
        // Duplicate triangles count once.
        let mut once: Vec<([u32; 3], u32)> = faces
            .iter()
            .map(|&face| (self.least_corners(face), face))
            .collect();
        once.sort_unstable();
        once.dedup_by(|b, a| a.0 == b.0 && self.range(a.1).len() == 3 && self.range(b.1).len() == 3);
        // For each edge: traversals from its lower vertex minus traversals from its higher one.
        let mut walked: Vec<(u32, i32, [u32; 2])> = Vec::new();
        for (_, face) in once {
            let corners = self.face(face);
            let flipped = self.double_sided[face as usize] && self.normal(face).dot(normal) < 0.0;
            for (place, corner) in self.range(face).enumerate() {
                let ends = [corners[place], corners[(place + 1) % corners.len()]];
                let up = (ends[0] < ends[1]) != flipped;
                let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
                walked.push((self.edges[corner], if up { 1 } else { -1 }, ends));
            }
        }
        walked.sort_unstable();
        walked
            .chunk_by(|a, b| a.0 == b.0)
            .filter_map(|run| {
                let [least, greatest] = run[0].2;
                match run.iter().map(|walk| walk.1).sum::<i32>() {
                    _ if least == greatest => None,
                    0 => None,
                    1.. => Some([least, greatest]),
                    _ => Some([greatest, least]),
                }
            })
            .collect()
    }
}

/// Merges vertices at the same position: renumbers `corners` and returns the positions.
fn weld(positions: &[[f32; 3]], corners: &mut [u32]) -> Vec<DVec3> {
    let mut used = vec![false; positions.len()];
    corners.iter().for_each(|&corner| used[corner as usize] = true);
    // −0 equals 0.
    let bits = |index: u32| positions[index as usize].map(|value| (value + 0.0).to_bits());
    let mut sorted: Vec<([u32; 3], u32)> = (0..positions.len() as u32)
        .filter(|&index| used[index as usize])
        .map(|index| (bits(index), index))
        .collect();
    sorted.sort_unstable();
    let mut number = vec![0; positions.len()];
    let mut points = Vec::new();
    for run in sorted.chunk_by(|a, b| a.0 == b.0) {
        run.iter()
            .for_each(|&(_, index)| number[index as usize] = points.len() as u32);
        points.push(DVec3::from(run[0].0.map(|bits| f64::from(f32::from_bits(bits)))));
    }
    corners
        .iter_mut()
        .for_each(|corner| *corner = number[*corner as usize]);
    points
}

/// Returns, for each corner, the edge that begins there; for each edge, the start of its run of faces; and the faces of
/// all runs.
fn share_edges(starts: &[u32], corners: &[u32]) -> (Vec<u32>, Vec<u32>, Vec<u32>) {
    let mut sorted: Vec<(u64, u32, u32)> = Vec::with_capacity(corners.len());
    for (face, ends) in starts.windows(2).enumerate() {
        for corner in ends[0]..ends[1] {
            let next = if corner + 1 == ends[1] {
                ends[0]
            } else {
                corner + 1
            };
            let [from, to] = [corner, next].map(|corner| u64::from(corners[corner as usize]));
            sorted.push((from.min(to) << 32 | from.max(to), face as u32, corner));
        }
    }
    sorted.sort_unstable();
    let mut edges = vec![0; corners.len()];
    let mut runs = vec![0];
    for run in sorted.chunk_by(|a, b| a.0 == b.0) {
        let edge = runs.len() as u32 - 1;
        run.iter()
            .for_each(|&(_, _, corner)| edges[corner as usize] = edge);
        runs.push(runs[runs.len() - 1] + run.len() as u32);
    }
    let sharers = sorted.into_iter().map(|(_, face, _)| face).collect();
    (edges, runs, sharers)
}

/// Returns the area vector by Newell's sum: twice the area times the unit normal. Relative to the first corner, so that
/// faces far from the origin lose no precision.
pub(super) fn twice_area(mut corners: impl Iterator<Item = DVec3>) -> DVec3 {
    let (Some(first), Some(second)) = (corners.next(), corners.next()) else {
        return DVec3::ZERO;
    };
    let mut before = second - first;
    let mut sum = DVec3::ZERO;
    for corner in corners {
        let after = corner - first;
        sum += before.cross(after);
        before = after;
    }
    sum
}
