//! Tessellates Bézier patch faces: grids of quadratic patches with 3×3 control points, in which neighbours share a row.
//!
//! Each patch is divided into the same power-of-two number of steps per side. So the vertices of a border depend
//! exactly on its three control points, in either direction, and there are no cracks between patches or between faces
//! that share a border.
//! Source: Quake 3; biquadratic Bézier surfaces as in any book on splines.

use super::faces3::Corner;

/// Steps per side of a patch.
pub(super) const STEPS: usize = 8;

/// Vertices and triangles of a tessellated face, counter-clockwise when seen from the front.
pub(super) struct Grid {
    pub(super) corners: Vec<Corner>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Tessellates a face of `columns` × `rows` control points, both odd and at least 3.
pub(super) fn tessellate(corners: &[Corner], [columns, rows]: [usize; 2]) -> Grid {
    let [across, down] = [columns, rows].map(|size| (size - 1) / 2 * STEPS + 1);
    let mut grid = Grid {
        corners: Vec::with_capacity(across * down),
        triangles: Vec::with_capacity(2 * (across - 1) * (down - 1)),
    };
    for row in 0..down {
        let (first_row, v) = piece(row, rows);
        for column in 0..across {
            let (first, u) = piece(column, columns);
            let along_rows = [0, 1, 2].map(|row| {
                let three = (first_row + row) * columns + first;
                between([0, 1, 2].map(|at| ExactVertex::of(&corners[three + at])), u)
            });
            grid.corners.push(between(along_rows, v).rounded());
        }
    }
    let at = |column: usize, row: usize| (row * across + column) as u32;
    for row in 1..down {
        for column in 1..across {
            let [a, b] = [column - 1, column].map(|column| at(column, row - 1));
            let [c, d] = [column - 1, column].map(|column| at(column, row));
            grid.triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    grid
}

/// Returns the first control point of the patch that contains a step, and the curve parameter within it.
fn piece(step: usize, size: usize) -> (usize, f64) {
    let patch = (step / STEPS).min((size - 1) / 2 - 1);
    (2 * patch, (step - patch * STEPS) as f64 / STEPS as f64)
}

/// All components of a vertex in f64, where the evaluation of f32 input is exact.
#[derive(Clone, Copy)]
struct ExactVertex([f64; 14]);

impl ExactVertex {
    fn of(corner: &Corner) -> ExactVertex {
        let mut all = [0.0; 14];
        let parts = corner.position.iter().chain(&corner.texture).chain(&corner.light);
        let parts = parts.chain(&corner.normal).chain(&corner.color);
        all.iter_mut()
            .zip(parts)
            .for_each(|(to, &from)| *to = from.into());
        ExactVertex(all)
    }

    fn rounded(&self) -> Corner {
        let [x, y, z, u, v, across, down, a, b, c, red, green, blue, alpha] =
            self.0.map(|value| value as f32);
        Corner {
            position: [x, y, z],
            texture: [u, v],
            light: [across, down],
            normal: [a, b, c],
            color: [red, green, blue, alpha],
        }
    }
}

/// Evaluates a quadratic Bézier curve. Symmetric: the reversed curve gives the same bits.
fn between([a, b, c]: [ExactVertex; 3], along: f64) -> ExactVertex {
    let back = 1.0 - along;
    let [from_a, from_b, from_c] = [back * back, 2.0 * along * back, along * along];
    let mut all = [0.0; 14];
    for (at, sum) in all.iter_mut().enumerate() {
        *sum = (from_a * a.0[at] + from_c * c.0[at]) + from_b * b.0[at];
    }
    ExactVertex(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f32, y: f32, z: f32) -> Corner {
        Corner {
            position: [x, y, z],
            ..Corner::default()
        }
    }

    /// A quarter of a pipe along the y axis, seen from inside.
    fn arch() -> Vec<Corner> {
        let rows = [0.1, 3.7, 9.3].map(|y| [at(0.0, y, 0.7), at(0.0, y, 10.1), at(9.9, y, 10.1)]);
        rows.as_flattened().to_vec()
    }

    #[test]
    fn a_patch_begins_and_ends_in_its_corners_and_bends_in_between() {
        let grid = tessellate(&arch(), [3, 3]);
        assert_eq!(grid.corners.len(), 81);
        assert_eq!(grid.triangles.len(), 128);
        assert_eq!(grid.corners[0].position, [0.0, 0.1, 0.7]);
        assert_eq!(grid.corners[80].position, [9.9, 9.3, 10.1]);
        let [x, _, z] = grid.corners[4].position;
        assert!((x - 2.475).abs() < 1e-5 && (z - 7.75).abs() < 1e-5, "{x} {z}");
    }

    #[test]
    fn two_patches_of_a_face_meet_without_a_crack() {
        let mut wave = Vec::new();
        for y in [0.3, 1.1, 2.9] {
            wave.extend([0.0, 1.3, 2.1, 3.7, 4.9].map(|x: f32| at(x, y, (x * y).sin())));
        }
        let grid = tessellate(&wave, [5, 3]);
        assert_eq!(grid.corners.len(), 17 * 9);
        // The row of vertices shared by both patches equals that of the left patch alone.
        let left: Vec<Corner> = wave.chunks(5).flat_map(|row| row[..3].to_vec()).collect();
        let alone = tessellate(&left, [3, 3]);
        for row in 0..9 {
            assert_eq!(grid.corners[row * 17 + 8], alone.corners[row * 9 + 8]);
        }
    }

    #[test]
    fn a_border_is_the_same_from_either_side() {
        let there = arch();
        let back: Vec<Corner> = there.iter().rev().copied().collect();
        let [there, back] = [there, back].map(|corners| tessellate(&corners, [3, 3]).corners);
        assert!(there.iter().eq(back.iter().rev()));
    }
}
