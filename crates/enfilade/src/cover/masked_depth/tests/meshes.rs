//! Compares meshes rasterized by the kernels with the rasterizer of the exact covers.

use super::*;
use crate::chance::levels;
use crate::cover::masked_depth::mesh::merged;
use crate::raster::{Band, Raster, Sink, Triangle};

/// The nearest reversed depth of each sample according to the rasterizer, from the top left corner of the screen; 0 if
/// there is none.
struct ExactDepths {
    width: usize,
    rev_depth: Vec<f64>,
}

impl Sink for ExactDepths {
    fn hides(&mut self, _rect: &Rect, _nearest: f32) -> bool {
        false
    }

    fn band(&mut self, band: &Band, triangle: &Triangle) {
        for (y, [x0, x1]) in band.rows() {
            let row = triangle.row(y);
            for x in x0..x1 {
                let rev_depth = &mut self.rev_depth[usize::from(y) * self.width + usize::from(x)];
                *rev_depth = rev_depth.max(row.at(x));
            }
        }
    }
}

fn exact(positions: &[[f32; 3]], corners: &[u32], passage: &Passage) -> ExactDepths {
    let [width, height] = passage.size.map(|side| side as usize);
    let mut nearest = ExactDepths {
        width,
        rev_depth: vec![0.0; width * height],
    };
    let faces = Faces::of_triangles(positions, corners, &passage.screen_from_sector);
    Raster::default().run(&faces, passage, &mut nearest, &mut Stats::default());
    nearest
}

/// Triangles of all sizes around the eye: some cross the near plane, some are needles, some share vertices.
fn soup(dice: &mut Dice, passage: &Passage, count: usize) -> (Vec<[f32; 3]>, Vec<u32>) {
    let eye = DVec3::from(passage.eye());
    let mut positions: Vec<[f32; 3]> = Vec::new();
    let mut corners = Vec::new();
    for _ in 0..count {
        let at = eye + dice.direction() * dice.by_ratio(0.05, 40.0);
        let size = dice.by_ratio(1e-3, 30.0);
        for _ in 0..3 {
            let known = positions.len();
            if known > 3 && dice.roll() < 0.2 {
                corners.push((dice.roll() * known as f64) as u32);
                continue;
            }
            let squash = if dice.roll() < 0.1 { 1e-4 } else { 1.0 };
            let corner = at + size * dice.direction() * DVec3::new(1.0, squash, 1.0);
            corners.push(known as u32);
            positions.push(corner.to_array().map(|value| value as f32));
        }
    }
    (positions, corners)
}

/// A screen on which triangles may be wide, or a passage of another test.
fn passage_of(seed: u64, dice: &mut Dice) -> Passage {
    if seed.is_multiple_of(2) {
        return passages(seed, dice);
    }
    let camera = Camera {
        z_near: Some(dice.by_ratio(1e-3, 0.5) as f32),
        ..Camera::new([0.5, 1.0, 2.0], dice.direction().to_array().map(|v| v as f32))
    };
    let view = camera.view([701, 333]).expect("a valid view");
    Passage::at_the_eye(&view, SectorId(0), false)
}

fn hidden_by(level: Level, mesh: &OccluderMesh, passage: &Passage) -> OcclusionBuffer {
    let mut buffer = OcclusionBuffer::at(level);
    buffer.begin_passage(passage.clone());
    buffer.draw(mesh, &Transform::IDENTITY);
    buffer
}

/// Compares a buffer with the rasterizer. Returns the number of covered samples, and of those whose stored reversed
/// depth is less than half the true one.
fn compare(cover: &OcclusionBuffer, exact: &ExactDepths, scene: u64) -> [u64; 2] {
    for (farthest, tile) in cover.grid.farthest.iter().zip(&cover.grid.tiles) {
        assert!(*farthest <= tile.farthest(), "{farthest} of scene {scene}");
    }
    let [mut covered, mut apart] = [0_u64, 0_u64];
    for (x, y) in samples(cover.grid.rect) {
        let known = cover.known(x, y);
        if known == f32::INFINITY {
            continue;
        }
        let truth = exact.rev_depth[usize::from(y) * exact.width + usize::from(x)];
        assert_eq!(
            known > 0.0,
            truth > 0.0,
            "{x}, {y} of scene {scene}: {known} for {truth}"
        );
        assert!(
            f64::from(known) <= truth,
            "{x}, {y} of scene {scene}: {known} for {truth}"
        );
        covered += u64::from(known > 0.0);
        apart += u64::from(f64::from(known) < 0.5 * truth);
    }
    [covered, apart]
}

fn same_bits(one: &OcclusionBuffer, other: &OcclusionBuffer, scene: u64) {
    for (number, (a, b)) in one.grid.tiles.iter().zip(&other.grid.tiles).enumerate() {
        assert_eq!(
            (a.mask, a.reference, a.working),
            (b.mask, b.reference, b.working),
            "tile {number} of scene {scene}"
        );
    }
    assert_eq!(one.grid.farthest, other.grid.farthest, "scene {scene}");
}

fn hidden_by_triangles(positions: &[[f32; 3]], corners: &[u32], passage: &Passage) -> OcclusionBuffer {
    hidden_by(
        Level::new(),
        &OccluderMesh::unchecked(positions, corners),
        passage,
    )
}

#[test]
fn a_mesh_hides_the_very_samples_that_it_owns_and_is_nowhere_nearer() {
    let [mut covered, mut apart] = [0_u64, 0_u64];
    for seed in 0..160 {
        let mut dice = Dice::new(seed + 3000);
        let passage = passage_of(seed, &mut dice);
        let count = 1 + (300.0 * dice.roll() * dice.roll()) as usize;
        let (positions, corners) = soup(&mut dice, &passage, count);
        let exact = exact(&positions, &corners, &passage);
        let cover = hidden_by_triangles(&positions, &corners, &passage);
        let [some, of_these] = compare(&cover, &exact, seed);
        covered += some;
        apart += of_these;
    }
    assert!(covered > 1_000_000, "{covered}");
    // Two layers cannot store everything, but most samples must have a depth near the true one.
    assert!(apart * 2 < covered, "{apart} of {covered}");
}

#[test]
fn a_floor_under_the_eye_and_a_wall_that_goes_on_for_miles_need_no_f64() {
    let passage = passage([640, 360]);
    let positions = [
        [-300.0, -1.0, 200.0],
        [300.0, -1.0, 200.0],
        [0.0, -1.0, -400.0],
        [1.5, -50.0, 5.0],
        [1.5, -50.0, -900.0],
        [1.5, 70.0, 0.5],
    ];
    // Both sides of each triangle, of which one faces the eye.
    let corners = [0, 1, 2, 0, 2, 1, 3, 4, 5, 3, 5, 4];
    let mesh = OccluderMesh::unchecked(&positions, &corners);
    let mut cover = OcclusionBuffer::new();
    cover.begin_passage(passage.clone());
    let stats = cover.rasterize([(&mesh, Transform::IDENTITY)]);
    // Only the rasterizer of the exact covers counts samples; the kernels do not.
    assert_eq!(stats.samples, 0);
    let exact = exact(&positions, &corners, &passage);
    let mut covered = 0;
    for (x, y) in samples(cover.grid.rect) {
        let truth = exact.rev_depth[usize::from(y) * exact.width + usize::from(x)];
        assert_eq!(cover.known(x, y) > 0.0, truth > 0.0, "{x}, {y}");
        covered += u32::from(truth > 0.0);
    }
    assert!(covered > 100_000, "{covered}");
}

#[test]
fn of_a_thousand_wide_triangles_few_need_f64() {
    let passage = passage([640, 360]);
    let eye = DVec3::from(passage.eye());
    let mut dice = Dice::new(77);
    let [mut in_f64, mut covered] = [0, 0];
    for scene in 0..1000 {
        let positions: [[f32; 3]; 3] = std::array::from_fn(|_| {
            let [x, y] = [0, 1].map(|_| dice.roll() - 0.5);
            (eye + DVec3::new(4.0 * x, 2.0 * y, -2.0 - dice.roll()))
                .to_array()
                .map(|value| value as f32)
        });
        let corners = [0, 1, 2, 0, 2, 1];
        let mut cover = OcclusionBuffer::new();
        cover.begin_passage(passage.clone());
        let mesh = OccluderMesh::unchecked(&positions, &corners);
        // Only the rasterizer of the exact covers counts samples; the kernels do not.
        in_f64 += cover.rasterize([(&mesh, Transform::IDENTITY)]).samples;
        covered += compare(&cover, &exact(&positions, &corners, &passage), scene)[0];
    }
    assert!(covered > 1_000_000, "{covered}");
    // A fifth have a row that is uncertain in f32.
    assert!(in_f64 < covered / 50, "{in_f64} of {covered}");
}

#[test]
fn a_wall_among_more_corners_than_there_is_room_for_hides_as_alone() {
    let passage = passage([160, 90]);
    let wall = [[-40.0, -40.0, -5.0], [40.0, -40.0, -5.0], [0.0, 80.0, -5.0]];
    let alone = hidden_by_triangles(&wall, &[0, 1, 2], &passage);
    let mut positions = vec![[0.0, 0.0, -9.0]; 1500];
    positions.extend(wall);
    let mut cover = MaskedDepth::default();
    cover.clear(&passage);
    let corners = [1500, 1501, 1502];
    let faces = Faces::of_triangles(&positions, &corners, &passage.screen_from_sector);
    cover.hide_batch(&faces, &passage, &mut Stats::default());
    assert!(cover.known(80, 45) > 0.19);
    for (x, y) in samples(cover.grid.rect) {
        let [known, expected] = [cover.known(x, y), alone.known(x, y)];
        assert!(
            (known - expected).abs() < 1e-5,
            "{known}, not {expected} at {x}, {y}"
        );
    }
}

#[test]
fn a_mesh_leaves_the_same_bits_at_every_simd_level() {
    for seed in 0..60 {
        let mut dice = Dice::new(seed + 4000);
        let passage = passage_of(seed, &mut dice);
        let of_quads = seed % 3 == 0;
        let (mut positions, corners) = if of_quads {
            quads(&mut dice, &passage, 100)
        } else {
            soup(&mut dice, &passage, 200)
        };
        for _ in 0..20 {
            let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e-40, 0.0];
            let place = (dice.roll() * positions.len() as f64) as usize;
            positions[place][(dice.roll() * 3.0) as usize] = odd[(dice.roll() * 6.0) as usize];
        }
        let mesh = if of_quads {
            OccluderMesh::quads(&positions, &corners)
        } else {
            OccluderMesh::unchecked(&positions, &corners)
        };
        let expected = hidden_by(Level::new(), &mesh, &passage);
        for level in levels() {
            let cover = hidden_by(level, &mesh, &passage);
            same_bits(&expected, &cover, seed);
        }
    }
}

#[test]
fn any_number_of_threads_leaves_the_same_bits() {
    let mut covered = 0_u64;
    for seed in 0..80 {
        let mut dice = Dice::new(seed + 8000);
        let passage = passage_of(seed, &mut dice);
        let (positions, corners) = soup(&mut dice, &passage, 200);
        let exact = exact(&positions, &corners, &passage);
        let mesh = OccluderMesh::unchecked(&positions, &corners);
        let cover = hidden_by(Level::new(), &mesh, &passage);
        covered += compare(&cover, &exact, seed)[0];
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let other = pool
                .build()
                .expect("threads")
                .install(|| hidden_by(Level::new(), &mesh, &passage));
            same_bits(&cover, &other, seed);
        }
    }
    assert!(covered > 500_000, "{covered}");
}

#[test]
fn a_triangle_with_a_corner_that_is_no_number_hides_nothing() {
    let view = View::new([0.0; 3], [0.0, 0.0, -1.0], [64, 48]).expect("a valid view");
    let passage = Passage::at_the_eye(&view, SectorId(0), false);
    let sound = [[-90.0, -90.0, -2.0], [90.0, -90.0, -2.0], [0.0, 90.0, -2.0]];
    let all_hidden = |positions: &[[f32; 3]], corners: &[u32]| {
        let cover = hidden_by_triangles(positions, corners, &passage);
        samples(cover.grid.rect).all(|(x, y)| cover.known(x, y) > 0.0)
    };
    let none_hidden = |positions: &[[f32; 3]], corners: &[u32]| {
        let cover = hidden_by_triangles(positions, corners, &passage);
        samples(cover.grid.rect).all(|(x, y)| cover.known(x, y) == 0.0)
    };
    assert!(all_hidden(&sound, &[0, 1, 2]));
    assert!(none_hidden(&sound, &[0, 1, 3]), "a corner that is not there");
    for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let mut positions = sound;
            positions[1][axis] = odd;
            assert!(none_hidden(&positions, &[0, 1, 2]), "{odd} at {axis}");
        }
    }
}

#[test]
fn worlds_as_small_as_atoms_and_as_large_as_the_sky_are_held_as_others() {
    for (number, scale) in [1e-25_f32, 1e-19, 1e-9, 1e9, 1e19, 1e25].into_iter().enumerate() {
        let mut covered = 0;
        for seed in 0..6 {
            let mut dice = Dice::new(seed + 10 * number as u64 + 5000);
            let camera = Camera {
                z_near: Some(0.05 * scale),
                ..Camera::new([0.0; 3], dice.direction().to_array().map(|v| v as f32))
            };
            let view = camera.view([160, 90]).expect("a valid view");
            let passage = Passage::at_the_eye(&view, SectorId(0), false);
            let (positions, corners) = soup(&mut dice, &passage, 60);
            let positions: Vec<[f32; 3]> = positions.iter().map(|at| at.map(|v| v * scale)).collect();
            let exact = exact(&positions, &corners, &passage);
            let cover = hidden_by_triangles(&positions, &corners, &passage);
            for (x, y) in samples(cover.grid.rect) {
                let known = f64::from(cover.known(x, y));
                let truth = exact.rev_depth[usize::from(y) * exact.width + usize::from(x)];
                assert!(
                    known <= truth,
                    "{x}, {y} of scene {seed} at {scale}: {known} for {truth}"
                );
                covered += u32::from(known > 0.0);
            }
        }
        assert!(covered > 1000, "{covered} at {scale}");
    }
}

/// Quads of all sizes around the eye: most are planar and convex, and share corners; some are neither, or cross the
/// near plane.
fn quads(dice: &mut Dice, passage: &Passage, count: usize) -> (Vec<[f32; 3]>, Vec<u32>) {
    let eye = DVec3::from(passage.eye());
    let mut positions: Vec<[f32; 3]> = Vec::new();
    let mut corners = Vec::new();
    for _ in 0..count {
        let at = eye + dice.direction() * dice.by_ratio(0.05, 40.0);
        let size = dice.by_ratio(1e-3, 10.0);
        let [across, down] = [size * dice.direction(), size * dice.direction()];
        let first = positions.len() as u32;
        // A strip of two quads, which share two corners.
        for corner in 0..6 {
            let column = f64::from(corner % 3);
            let mut place = at + across * column + down * f64::from(corner / 3) * (1.0 + 0.2 * column);
            if dice.roll() < 0.03 {
                place += size * dice.direction();
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
        let view = View::new([0.0; 3], [0.0, 0.0, -1.0], [640, 360]).expect("a valid view");
        let passage = Passage::at_the_eye(&view, SectorId(0), false);
        let at = DVec3::new(dice.roll() - 0.5, dice.roll() - 0.5, -2.0 - dice.roll());
        let [across, down] = [0.06 * dice.direction(), 0.06 * dice.direction()];
        let corners = [at, at + across, at + across + down, at + down].map(|at| at.as_vec3().to_array());
        let either = |face: [u32; 4]| {
            let quad = OccluderMesh::quads(&corners, &face);
            // A degenerate triangle between the halves prevents merging.
            let [a, b, c, d] = face;
            let halves = OccluderMesh::unchecked(&corners, &[a, b, c, a, a, a, a, c, d]);
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
