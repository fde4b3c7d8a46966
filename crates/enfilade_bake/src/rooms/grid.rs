//! A grid of voxels over a building, and sets of voxels.
//!
//! Voxels are numbered in rows along x, rows along z, then slices along y: a horizontal slice is one range.
//! Source: conservative voxelization by edge functions in the dominant plane, as in Schwarz, Seidel, Fast Parallel
//!     Surface and Solid Voxelization on GPUs, SIGGRAPH Asia 2010, section 4.
//! Cost: O(voxels a triangle touches), and O(voxels of its projected box).
//! Conservative: a voxel that a triangle touches is visited; a few that it barely misses are, too.

use super::input::Bounds;
use std::sync::atomic::{AtomicU64, Ordering};

/// Position of a grid of cubic voxels, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    /// Number of voxels along x, y and z.
    pub(super) size: [usize; 3],
    /// Lower corner of the first voxel.
    pub(super) origin: [f64; 3],
    /// Side of a voxel.
    pub(super) step: f64,
}

/// Shift of the origin, in voxels: planes at round coordinates then do not coincide with faces of voxels.
const OFF_ROUND: f64 = 0.317;

/// Distance by which triangles are enlarged, in voxels; more than the rounding error.
const SLACK: f64 = 1e-7;

impl Grid {
    /// Creates a grid around a box, with a margin in metres. Voxels have the side `step`, or more if there would be
    /// more than `max_voxels`.
    pub(super) fn around(bounds: &Bounds, margin: f64, step: f64, max_voxels: usize) -> Grid {
        let mut step = step;
        loop {
            let pad = (margin / step).ceil().max(2.0);
            let origin = bounds.min.map(|low| low - (pad + OFF_ROUND) * step);
            let size = [0, 1, 2].map(|axis| ((bounds.max[axis] - origin[axis]) / step).ceil() + pad + 1.0);
            if size.iter().product::<f64>() <= max_voxels as f64 {
                return Grid {
                    size: size.map(|count| count as usize),
                    origin,
                    step,
                };
            }
            step *= 1.02;
        }
    }

    /// Returns the number of voxels.
    pub(super) fn len(&self) -> usize {
        self.size.iter().product()
    }

    /// Returns the number of voxels in a horizontal slice.
    pub(super) fn slice_len(&self) -> usize {
        self.size[0] * self.size[2]
    }

    /// Returns the distance in voxel numbers to the next voxel along x, y and z.
    pub(super) fn strides(&self) -> [usize; 3] {
        [1, self.slice_len(), self.size[0]]
    }

    /// Returns the number of a voxel.
    pub(super) fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (y * self.size[2] + z) * self.size[0] + x
    }

    /// Returns the column, height and row of a voxel.
    pub(super) fn place(&self, index: usize) -> [usize; 3] {
        let [nx, _, nz] = self.size;
        [index % nx, index / (nx * nz), index / nx % nz]
    }

    /// Returns the centre of a voxel.
    pub(super) fn center(&self, index: usize) -> [f64; 3] {
        let place = self.place(index);
        [0, 1, 2].map(|axis| self.origin[axis] + (place[axis] as f64 + 0.5) * self.step)
    }

    /// Returns the column, height and row of the voxel that contains a point; `None` outside the grid or for NaN.
    pub(super) fn cell_at(&self, point: [f64; 3]) -> Option<[usize; 3]> {
        let mut place = [0; 3];
        for (axis, place) in place.iter_mut().enumerate() {
            let at = ((point[axis] - self.origin[axis]) / self.step).floor();
            // Written so that NaN fails too.
            if !(at >= 0.0 && at < self.size[axis] as f64) {
                return None;
            }
            *place = at as usize;
        }
        Some(place)
    }

    /// Calls `visit` with each neighbour of a voxel: up to six.
    #[inline(always)]
    pub(super) fn for_each_neighbour(&self, index: usize, mut visit: impl FnMut(usize)) {
        let place = self.place(index);
        for (axis, stride) in self.strides().into_iter().enumerate() {
            if place[axis] > 0 {
                visit(index - stride);
            }
            if place[axis] + 1 < self.size[axis] {
                visit(index + stride);
            }
        }
    }

    /// Calls `visit` with each voxel inside the grid that a triangle touches.
    pub(super) fn for_each_voxel_of(&self, triangle: &[[f64; 3]; 3], mut visit: impl FnMut(usize)) {
        let corners = triangle.map(|at| [0, 1, 2].map(|axis| (at[axis] - self.origin[axis]) / self.step));
        let [least, most] = [f64::min, f64::max].map(|pick| {
            [0, 1, 2].map(|axis| pick(pick(corners[0][axis], corners[1][axis]), corners[2][axis]))
        });
        // Cells `first..end` of the grid between two coordinates.
        let cells = |low: f64, high: f64, axis: usize| {
            let size = self.size[axis] as f64;
            let first = (low - SLACK).floor().clamp(0.0, size) as usize;
            let end = ((high + SLACK).floor() + 1.0).clamp(0.0, size) as usize;
            first..end
        };
        let [one, other] =
            [1, 2].map(|corner| [0, 1, 2].map(|axis| corners[corner][axis] - corners[0][axis]));
        let normal = [
            one[1] * other[2] - one[2] * other[1],
            one[2] * other[0] - one[0] * other[2],
            one[0] * other[1] - one[1] * other[0],
        ];
        // Projected along the axis of the longest component, depth changes by at most one voxel per voxel.
        let w = (0..3)
            .max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()))
            .unwrap_or(0);
        let [a, b] = [(w + 1) % 3, (w + 2) % 3];
        if normal[w] == 0.0 {
            return;
        }
        // Lines with the triangle on their negative side.
        let outward = normal[w].signum();
        let lines = [0, 1, 2].map(|corner| {
            let [from, to] = [corners[corner], corners[(corner + 1) % 3]];
            let line = [(to[b] - from[b]) * outward, (from[a] - to[a]) * outward];
            let at = line[0] * from[a] + line[1] * from[b];
            (line, at + SLACK * (line[0].abs() + line[1].abs()))
        });
        let level: f64 = (0..3).map(|axis| normal[axis] * corners[0][axis]).sum();
        for at_b in cells(least[b], most[b], b) {
            for at_a in cells(least[a], most[a], a) {
                let low = [at_a as f64, at_b as f64];
                // The corner of the cell that is farthest inside each line.
                let is_outside = lines.iter().any(|&([across, along], limit)| {
                    let inner_a = low[0] + if across > 0.0 { 0.0 } else { 1.0 };
                    let inner_b = low[1] + if along > 0.0 { 0.0 } else { 1.0 };
                    across * inner_a + along * inner_b > limit
                });
                if is_outside {
                    continue;
                }
                let depth = |da: f64, db: f64| {
                    (level - normal[a] * (low[0] + da) - normal[b] * (low[1] + db)) / normal[w]
                };
                let depths = [depth(0.0, 0.0), depth(1.0, 0.0), depth(0.0, 1.0), depth(1.0, 1.0)];
                let lowest = depths.into_iter().fold(f64::INFINITY, f64::min).max(least[w]);
                let highest = depths.into_iter().fold(f64::NEG_INFINITY, f64::max).min(most[w]);
                for at_w in cells(lowest, highest, w) {
                    let mut place = [0; 3];
                    [place[a], place[b], place[w]] = [at_a, at_b, at_w];
                    visit(self.index(place));
                }
            }
        }
    }
}

/// A set of voxels, one bit each. Threads may insert at the same time.
pub(super) struct VoxelSet {
    words: Vec<AtomicU64>,
}

impl VoxelSet {
    pub(super) fn new(grid: &Grid) -> VoxelSet {
        let mut words = Vec::new();
        words.resize_with(grid.len().div_ceil(64), AtomicU64::default);
        VoxelSet { words }
    }

    pub(super) fn insert(&self, voxel: usize) {
        let (word, bit) = (&self.words[voxel / 64], 1 << (voxel % 64));
        // Reading first is cheaper: most voxels are visited several times.
        if word.load(Ordering::Relaxed) & bit == 0 {
            word.fetch_or(bit, Ordering::Relaxed);
        }
    }

    #[inline(always)]
    pub(super) fn has(&self, voxel: usize) -> bool {
        self.words[voxel / 64].load(Ordering::Relaxed) >> (voxel % 64) & 1 != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        Grid {
            size: [20, 20, 20],
            origin: [0.0; 3],
            step: 0.5,
        }
    }

    #[test]
    fn points_of_a_triangle_are_in_voxels_that_it_touches() {
        let mut random = fastrand::Rng::with_seed(7);
        for _ in 0..2000 {
            let mut number = || 10.0 * random.f64();
            let triangle = [(); 3].map(|()| [number(), number(), number()]);
            let mut touched = std::collections::HashSet::new();
            grid().for_each_voxel_of(&triangle, |voxel| {
                touched.insert(voxel);
            });
            for _ in 0..200 {
                let [mut s, mut t] = [random.f64(), random.f64()];
                if s + t > 1.0 {
                    [s, t] = [1.0 - s, 1.0 - t];
                }
                let at = [0, 1, 2].map(|axis| {
                    let [a, b, c] = triangle.map(|corner| corner[axis]);
                    a + s * (b - a) + t * (c - a)
                });
                assert!(
                    touched.contains(&grid().index(grid().cell_at(at).expect("inside"))),
                    "{triangle:?} {at:?}"
                );
            }
        }
    }

    #[test]
    fn a_triangle_touches_no_voxel_far_from_it() {
        let flat = [[1.2, 3.3, 1.2], [4.2, 3.3, 1.2], [1.2, 3.3, 4.2]];
        let mut count = 0;
        grid().for_each_voxel_of(&flat, |voxel| {
            let [x, y, z] = grid().place(voxel);
            assert_eq!(y, 6);
            assert!(
                (2..=8).contains(&x) && (2..=8).contains(&z) && x + z <= 11,
                "{x} {z}"
            );
            count += 1;
        });
        assert!((25..=40).contains(&count), "{count}");
    }

    #[test]
    fn a_grid_has_at_most_the_maximum_number_of_voxels() {
        let bounds = Bounds {
            min: [-1e5, 0.0, -3e5],
            max: [4e5, 90.0, 1e5],
        };
        let grid = Grid::around(&bounds, 1.0, 0.1, 1_000_000);
        assert!(grid.len() <= 1_000_000 && grid.len() > 300_000, "{grid:?}");
        for corner in [bounds.min, bounds.max] {
            assert!(grid.cell_at(corner).is_some());
        }
        assert_eq!(grid.cell_at([f64::NAN, 0.0, 0.0]), None);
    }
}
