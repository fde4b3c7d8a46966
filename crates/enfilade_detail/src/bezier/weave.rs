//! Builds one mesh from all patches: a grid in each patch, vertices along its edges, and a ring of triangles between
//! the two.
//!
//! Both patches of an edge share its vertices; their number follows from the patch that needs more. The grid ends one
//! step before the edge. Each triangle of the ring spans at most one step of its patch, so the error bound of `steps`
//! holds for it too.
//! Source: the rings are those of hardware tessellators; Moreton, Watertight tessellation using forward differencing,
//!     2001.
//! Cost: O(triangles).
//! No cracks: neighbours share the vertices of an edge by index.

use super::BezierPatch;
use super::steps::Bend;
use glam::DVec3;
use std::collections::HashMap;

/// Positions, and three indices per triangle.
pub(super) type TriangleList = (Vec<[f32; 3]>, Vec<u32>);

/// An edge, identified by the bits of its control points, in the direction that sorts first.
type EdgeKey = [[u32; 3]; 4];

/// The inner vertices of an edge: index of the first, and number of steps.
#[derive(Default)]
struct Edge {
    first: u32,
    steps: u32,
}

/// Maximum number of triangles of a level; more indicates a mistake in the size of the patches.
const MAX_TRIANGLES: u64 = 1 << 27;

/// Tessellates the patches within `tolerance`, before rounding, or as closely as the maximum step count allows.
pub(super) fn weave(patches: &[BezierPatch], tolerance: f64) -> Result<TriangleList, String> {
    let wanted: Vec<[u32; 2]> = patches
        .iter()
        .map(|patch| Bend::of(patch).steps(tolerance))
        .collect();
    let cells: u64 = wanted.iter().map(|&[u, v]| u64::from(u) * u64::from(v)).sum();
    if 2 * cells > MAX_TRIANGLES {
        return Err(format!(
            "it would have {} triangles, more than {MAX_TRIANGLES}",
            2 * cells
        ));
    }
    let mut mesh = PatchMesh::default();
    for (patch, &[u, v]) in patches.iter().zip(&wanted) {
        for (edge, steps) in edges(patch).into_iter().zip([u, v, u, v]) {
            let known = mesh.edges.entry(edge_key(&edge).0).or_default();
            known.steps = known.steps.max(steps);
        }
    }
    for (patch, &steps) in patches.iter().zip(&wanted) {
        mesh.add(patch, steps);
    }
    Ok((mesh.positions, mesh.corners))
}

#[derive(Default)]
struct PatchMesh {
    edges: HashMap<EdgeKey, Edge>,
    /// Vertices at the ends of edges, by their bits.
    ends: HashMap<[u32; 3], u32>,
    positions: Vec<[f32; 3]>,
    corners: Vec<u32>,
}

impl PatchMesh {
    fn add(&mut self, patch: &BezierPatch, [nu, nv]: [u32; 2]) {
        let sides = edges(patch).map(|edge| self.edge(&edge));
        if sides.iter().all(|side| side.len() == 2) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|side| sides[side][0]);
            self.triangle([a, b, c]);
            self.triangle([a, c, d]);
            return;
        }
        // The ring needs at least one grid vertex inside.
        let (nu, nv) = (nu.max(2), nv.max(2));
        let first = self.positions.len() as u32;
        for v in 1..nv {
            for u in 1..nu {
                self.positions.push(point(patch, [u, v], [nu, nv]));
            }
        }
        let inner = |u: u32, v: u32| first + (v - 1) * (nu - 1) + u - 1;
        for v in 1..nv - 1 {
            for u in 1..nu - 1 {
                let [a, b, c, d] = [inner(u, v), inner(u + 1, v), inner(u + 1, v + 1), inner(u, v + 1)];
                self.triangle([a, b, c]);
                self.triangle([a, c, d]);
            }
        }
        let [bottom, right, top, left] = &sides;
        self.ring(bottom, (1..nu).map(|u| inner(u, 1)));
        self.ring(right, (1..nv).map(|v| inner(nu - 1, v)));
        self.ring(top, (1..nu).rev().map(|u| inner(u, nv - 1)));
        self.ring(left, (1..nv).rev().map(|v| inner(1, v)));
    }

    /// Returns the vertices of an edge, ends included, in this patch's direction.
    fn edge(&mut self, edge: &[[f32; 3]; 4]) -> Vec<u32> {
        let (name, reversed) = edge_key(edge);
        let Edge { mut first, steps } = self.edges[&name];
        if steps > 1 && first == 0 {
            // The ends are added first, so index 0 is never an inner vertex and can mean "not made yet".
            let _ = [edge[0], edge[3]].map(|end| self.end(end));
            first = self.positions.len() as u32;
            let within = (1..steps).map(|k| if reversed { steps - k } else { k });
            self.positions.extend(within.map(|k| on_curve(edge, k, steps)));
            self.edges.insert(name, Edge { first, steps });
        }
        let mut points = vec![self.end(edge[0])];
        let within = first..first + steps - 1;
        if reversed {
            points.extend(within.rev());
        } else {
            points.extend(within);
        }
        points.push(self.end(edge[3]));
        points
    }

    fn end(&mut self, end: [f32; 3]) -> u32 {
        let next = self.positions.len() as u32;
        let known = *self.ends.entry(end.map(f32::to_bits)).or_insert(next);
        if known == next {
            self.positions.push(end);
        }
        known
    }

    /// Fills the strip between an edge and the grid row along it. The patch is to the left of the edge.
    fn ring(&mut self, edge: &[u32], grid: impl ExactSizeIterator<Item = u32>) {
        let (steps, cells) = (edge.len() - 1, grid.len() + 1);
        let mut from = 0;
        let mut last = None;
        for (i, point) in grid.enumerate() {
            if let Some(last) = last {
                self.triangle([edge[from], point, last]);
            }
            // Advance to the edge vertex closest to the midpoint between this grid vertex and the next: its distance
            // from either is at most their distance from each other.
            let middle = (2 * i + 3) * steps;
            let to = if i + 2 == cells {
                steps
            } else {
                (middle + cells) / (2 * cells)
            };
            for k in from..to {
                self.triangle([edge[k], edge[k + 1], point]);
            }
            (from, last) = (to, Some(point));
        }
    }

    /// Adds a triangle unless it is degenerate, as along an edge that is a point; its neighbours close the gap.
    fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|corner| self.positions[corner as usize]);
        if a != b && b != c && c != a {
            self.corners.extend(corners);
        }
    }
}

/// Returns the four edges, counter-clockwise from the front.
fn edges(patch: &BezierPatch) -> [[[f32; 3]; 4]; 4] {
    [[0, 1, 2, 3], [3, 7, 11, 15], [15, 14, 13, 12], [12, 8, 4, 0]]
        .map(|numbers| numbers.map(|number: usize| patch[number]))
}

/// Returns the key of an edge, and whether the edge runs in the opposite direction.
fn edge_key(edge: &[[f32; 3]; 4]) -> (EdgeKey, bool) {
    let forward = edge.map(|point| point.map(f32::to_bits));
    let mut backward = forward;
    backward.reverse();
    (forward.min(backward), backward < forward)
}

fn weights(k: u32, steps: u32) -> [f64; 4] {
    let [t, s] = [k, steps - k].map(|k| f64::from(k) / f64::from(steps));
    [s * s * s, 3.0 * (s * s) * t, 3.0 * (t * t) * s, t * t * t]
}

fn on_curve(edge: &[[f32; 3]; 4], k: u32, steps: u32) -> [f32; 3] {
    let points = edge.map(|point| DVec3::from(point.map(f64::from)));
    let weights = weights(k, steps);
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| points[i] * weights[i]);
    // The same bits from either end: a closed edge that meets itself has no crack either.
    ((a + d) + (b + c)).as_vec3().into()
}

fn point(patch: &BezierPatch, [u, v]: [u32; 2], [nu, nv]: [u32; 2]) -> [f32; 3] {
    let along_u = weights(u, nu);
    let rows = weights(v, nv).into_iter().enumerate();
    let sum: DVec3 = rows
        .flat_map(|(row, wv)| {
            along_u
                .iter()
                .enumerate()
                .map(move |(i, wu)| (4 * row + i, wu * wv))
        })
        .map(|(number, weight)| DVec3::from(patch[number].map(f64::from)) * weight)
        .sum();
    sum.as_vec3().into()
}
