//! Quads, which the kernels set up as quads.

use super::meshes::{compare, exact, hidden_by, passage_of};
use super::*;
use crate::cover::masked_depth::mesh::merged;

/// Quads of all sizes around the eye: most are planar and convex, and share corners; some are neither, or cross the
/// near plane.
pub(super) fn quads(dice: &mut Dice, passage: &Passage, count: usize) -> (Vec<[f32; 3]>, Vec<u32>) {
    let eye = DVec3::from(passage.eye());
    let mut positions: Vec<[f32; 3]> = Vec::new();
    let mut corners = Vec::new();
    for _ in 0..count {
        let at = eye + dice.unit() * dice.by_ratio(0.05, 40.0);
        let size = dice.by_ratio(1e-3, 10.0);
        let [across, down] = [size * dice.unit(), size * dice.unit()];
        let first = positions.len() as u32;
        // A strip of two quads, which share two corners.
        for corner in 0..6 {
            let column = f64::from(corner % 3);
            let mut place = at + across * column + down * f64::from(corner / 3) * (1.0 + 0.2 * column);
            if dice.roll() < 0.03 {
                place += size * dice.unit();
            }
            positions.push(place.to_array().map(|value| value as f32));
        }
        for [a, b, c, d] in [[0, 1, 4, 3], [1, 2, 5, 4]] {
            corners.extend([a, b, c, d].map(|corner| first + corner));
        }
    }
    (positions, corners)
}

fn halves(corners: &[u32]) -> Vec<u32> {
    let quads = corners.as_chunks::<4>().0.iter();
    quads.flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect()
}

#[test]
fn quads_flat_and_bent_hide_the_very_samples_of_their_halves_and_are_nowhere_nearer() {
    let [mut covered, mut apart] = [0_u64, 0_u64];
    for seed in 0..160 {
        let mut dice = Dice::new(seed + 6000);
        let passage = passage_of(seed, &mut dice);
        let count = 1 + (200.0 * dice.roll() * dice.roll()) as usize;
        let (positions, corners) = quads(&mut dice, &passage, count);
        let exact = exact(&positions, &halves(&corners), &passage);
        let mesh = OccluderMesh::quads(&positions, &corners);
        let [some, of_these] = compare(&hidden_by(Level::new(), &mesh, &passage), &exact, seed);
        covered += some;
        apart += of_these;
    }
    assert!(covered > 1_000_000, "{covered}");
    assert!(apart * 2 < covered, "{apart} of {covered}");
}

#[test]
fn a_small_flat_quad_is_as_near_as_its_triangles_but_for_what_each_ends_at() {
    let mut covered = 0;
    for seed in 0..60 {
        let mut dice = Dice::new(seed + 7000);
        let view = View::new([0.0; 3], [0.0, 0.0, -1.0], [640, 360]);
        let passage = Passage::at_the_eye(&view, SectorId(0), false);
        let at = DVec3::new(dice.roll() - 0.5, dice.roll() - 0.5, -2.0 - dice.roll());
        let [across, down] = [0.06 * dice.unit(), 0.06 * dice.unit()];
        let corners = [at, at + across, at + across + down, at + down].map(|at| at.as_vec3().to_array());
        let either = |face: [u32; 4]| {
            let quad = OccluderMesh::quads(&corners, &face);
            // A degenerate triangle between the halves prevents merging.
            let [a, b, c, d] = face;
            let halves = OccluderMesh::triangles(&corners, &[a, b, c, a, a, a, a, c, d]);
            let quad = hidden_by(Level::new(), &quad, &passage);
            let half = hidden_by(Level::new(), &halves, &passage);
            let mut covered = 0;
            for (x, y) in samples(half.grid.rect) {
                let [known, expected] = [quad.known(x, y), half.known(x, y)];
                assert!(
                    known >= expected * 0.97,
                    "{known}, not {expected} at {x}, {y} of {seed}"
                );
                covered += u32::from(expected > 0.0);
            }
            covered
        };
        // One of its two sides is visible.
        covered += either([0, 1, 2, 3]) + either([0, 3, 2, 1]);
    }
    assert!(covered > 1000, "{covered}");
}

#[test]
fn of_triangles_two_that_make_a_flat_convex_quad_are_one() {
    let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(merged(&flat, [0, 1, 2], [0, 2, 3]), Some([0, 1, 2, 3]));
    assert_eq!(merged(&flat, [1, 2, 0], [3, 0, 2]), Some([0, 1, 2, 3]));
    assert_eq!(merged(&flat, [0, 1, 2], [0, 3, 2]), None, "one seen from behind");
    assert_eq!(merged(&flat, [0, 1, 2], [0, 1, 2]), None);
    assert_eq!(
        merged(&flat, [0, 1, 2], [0, 2, 9]),
        None,
        "a corner that is not there"
    );
    let mut bent = flat;
    bent[3][2] = 0.1;
    assert_eq!(merged(&bent, [0, 1, 2], [0, 2, 3]), None);
    let mut dart = flat;
    dart[3] = [0.9, 0.2, 0.0];
    assert_eq!(merged(&dart, [0, 1, 2], [0, 2, 3]), None);
}
