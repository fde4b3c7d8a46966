//! Checks whole trees against ray casts.

mod hard;

use super::*;
use crate::chance::Dice;
use std::collections::BTreeSet;

fn polygons<const N: usize>(list: impl IntoIterator<Item = [DVec3; N]>) -> Polygons {
    let mut polygons = Polygons {
        starts: vec![0],
        ..Polygons::default()
    };
    for corners in list {
        polygons.corners.extend(corners.map(Into::<[f64; 3]>::into));
        polygons.starts.push(polygons.corners.len() as u32);
    }
    polygons
}

fn count(polygons: &Polygons) -> usize {
    polygons.starts.len() - 1
}

fn corners(polygons: &Polygons, polygon: u32) -> Vec<DVec3> {
    let [first, end] = [0, 1].map(|next| polygons.starts[polygon as usize + next] as usize);
    polygons.corners[first..end].iter().map(|&c| c.into()).collect()
}

/// Returns randomly oriented, intersecting triangles, and squares on a coarse grid, many of them coplanar.
pub(super) fn jumble(random: &mut Dice, size: u32) -> Polygons {
    let mut all = Polygons {
        starts: vec![0],
        ..Polygons::default()
    };
    for i in 0..size {
        let corners = if i % 2 == 0 {
            vec![random.point(4.0), random.point(4.0), random.point(4.0)]
        } else {
            let axis = random.below(3);
            let [u, v] = [1, 2].map(|turn| DVec3::AXES[(axis + turn) % 3] * (1.0 + random.below(4) as f64));
            let at = DVec3::from([0; 3].map(|_| random.below(6) as f64 - 3.0));
            vec![at, at + u, at + u + v, at + v]
        };
        all.corners
            .extend(corners.into_iter().map(Into::<[f64; 3]>::into));
        all.starts.push(all.corners.len() as u32);
    }
    all
}

/// Returns the pieces in traversal order, each with the number of its run.
fn met(tree: &BspTree, eye: DVec3, near_first: bool) -> Vec<(usize, Piece)> {
    met_if(tree, eye, near_first, |_| true)
}

fn met_if(
    tree: &BspTree,
    eye: DVec3,
    near_first: bool,
    mut enters: impl FnMut(&Aabb) -> bool,
) -> Vec<(usize, Piece)> {
    let (mut all, mut runs) = (Vec::new(), 0);
    tree.walk(eye.into(), near_first, &mut Vec::new(), &mut |step| match step {
        BspStep::Node(bounds) => enters(bounds),
        BspStep::Coplanar(pieces) => {
            assert!(pieces.windows(2).all(|pair| pair[0].polygon < pair[1].polygon));
            all.extend(pieces.iter().map(|&piece| (runs, piece)));
            runs += 1;
            true
        }
    });
    all
}

fn holds(tree: &BspTree, piece: &Piece, point: DVec3) -> bool {
    tree.cuts(piece)
        .all(|[a, b, c, d]| DVec3::new(a, b, c).dot(point) >= d)
}

/// Returns the ray parameter of the hit with a polygon; `None` also if the ray is too near an edge or too parallel to
/// the plane to be certain.
fn hit(corners: &[DVec3], eye: DVec3, toward: DVec3) -> Option<f64> {
    let normal = (corners[1] - corners[0])
        .cross(corners[2] - corners[0])
        .normalize();
    let slope = normal.dot(toward);
    let way = normal.dot(corners[0] - eye) / slope;
    let point = eye + toward * way;
    let inside = (0..corners.len()).all(|i| {
        let [from, to] = [corners[i], corners[(i + 1) % corners.len()]];
        normal.cross((to - from).normalize()).dot(point - from) > 1e-7
    });
    (slope.abs() > 1e-4 && way > 1e-7 && inside).then_some(way)
}

/// Checks that along many rays each hit belongs to exactly one piece and that the hits come in traversal order. Returns
/// the number of hits tested.
fn rays_agree(polygons: &Polygons, tree: &BspTree, random: &mut Dice, tolerance: f64) -> usize {
    let mut looked_at = 0;
    for view in 0..12 {
        // Some eyes are in planes of the grid.
        let eye = random.point(6.0);
        let eye = if view % 3 == 0 { eye.round() } else { eye };
        let order = met(tree, eye, true);
        let mut from_far: Vec<_> = met(tree, eye, false)
            .iter()
            .map(|(_, p)| (p.polygon, p.first_cut))
            .collect();
        let from_near: Vec<_> = order.iter().map(|(_, p)| (p.polygon, p.first_cut)).collect();
        from_far.sort_unstable();
        let mut sorted = from_near.clone();
        sorted.sort_unstable();
        assert_eq!(from_far, sorted);
        let far = met(tree, eye, false);
        for _ in 0..40 {
            let toward = (random.point(4.0) - eye).normalize();
            let mut way_of_run = Vec::new();
            for polygon in 0..count(polygons) as u32 {
                let Some(way) = hit(&corners(polygons, polygon), eye, toward) else {
                    continue;
                };
                let point = eye + toward * way;
                let near_a_cut = |piece: &Piece| {
                    let mut cuts = tree.cuts(piece);
                    cuts.any(|[a, b, c, d]| (DVec3::new(a, b, c).dot(point) - d).abs() < 1e-7)
                };
                let mut mine = order.iter().filter(|(_, piece)| piece.polygon == polygon);
                if mine.clone().any(|(_, piece)| near_a_cut(piece)) {
                    continue;
                }
                let held = mine
                    .clone()
                    .filter(|(_, piece)| holds(tree, piece, point))
                    .count();
                assert_eq!(
                    held, 1,
                    "exactly one piece of polygon {polygon} must contain the hit"
                );
                let (run, piece) = mine
                    .find(|(_, piece)| holds(tree, piece, point))
                    .expect("one was counted above");
                way_of_run.push((*run, way));
                let same =
                    |(_, p): &&(usize, Piece)| (p.polygon, p.first_cut) == (piece.polygon, piece.first_cut);
                assert!(far.iter().find(same).is_some());
                let bounds_hold = |bounds: &Aabb| bounds.contains(point.as_vec3().into());
                let met = met_if(tree, eye, true, bounds_hold);
                assert!(
                    met.iter().find(same).is_some(),
                    "the AABB of an ancestor does not contain the hit"
                );
                looked_at += 1;
            }
            way_of_run.sort_by_key(|&(run, _)| run);
            for pair in way_of_run.windows(2) {
                let [(first_run, first), (second_run, second)] = [pair[0], pair[1]];
                assert!(
                    second > first - tolerance,
                    "the hit at {first} came before the hit at {second}"
                );
                if first_run == second_run {
                    assert!(
                        (first - second).abs() < tolerance,
                        "hits of one run are not coplanar"
                    );
                }
            }
        }
    }
    looked_at
}

#[test]
fn along_any_ray_pieces_come_in_the_order_of_the_walk() {
    let mut random = Dice::new(1);
    let mut looked_at = 0;
    for size in [1, 2, 3, 5, 8, 13, 21, 34, 55] {
        let polygons = jumble(&mut random, size);
        for options in [
            BspOptions::default(),
            BspOptions {
                candidates: 2,
                free_splits: f32::INFINITY,
                ..BspOptions::default()
            },
            BspOptions {
                free_splits: 0.0,
                ..BspOptions::default()
            },
        ] {
            let tree = BspTree::build(&polygons, &options);
            assert_eq!(tree.pieces(), u64::from(size) + tree.splits());
            looked_at += rays_agree(&polygons, &tree, &mut random, 1e-6);
        }
    }
    assert!(looked_at > 10_000, "{looked_at}");
}

#[test]
fn from_far_is_from_near_turned_round() {
    let mut random = Dice::new(2);
    let tree = BspTree::build(&jumble(&mut random, 40), &BspOptions::default());
    let runs = |near_first: bool| {
        let mut runs: Vec<Vec<u32>> = Vec::new();
        for (run, piece) in met(&tree, DVec3::new(0.3, 0.2, 5.0), near_first) {
            runs.resize(run + 1, Vec::new());
            runs[run].push(piece.first_cut);
        }
        runs
    };
    let mut far = runs(false);
    far.reverse();
    assert_eq!(runs(true), far);
}
