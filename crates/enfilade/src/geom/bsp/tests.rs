//! Whole trees: held against rays, and fed with what is hard to sort.

use super::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::collections::BTreeSet;

/// Numbers that look random, the same ones each time.
struct Random(u64);

impl Random {
    fn below(&mut self, end: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        ((self.0 >> 33) % u64::from(end)) as u32
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.below(1 << 24)) / f64::from(1 << 24)
    }

    fn point(&mut self, reach: f64) -> DVec3 {
        DVec3::from([0; 3].map(|_| self.between(-reach, reach)))
    }
}

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

/// Triangles every which way through each other, and squares on a coarse grid, many of them in one plane.
fn jumble(random: &mut Random, size: u32) -> Polygons {
    let mut all = Polygons {
        starts: vec![0],
        ..Polygons::default()
    };
    for i in 0..size {
        let corners = if i % 2 == 0 {
            vec![random.point(4.0), random.point(4.0), random.point(4.0)]
        } else {
            let axis = random.below(3) as usize;
            let [u, v] =
                [1, 2].map(|turn| DVec3::AXES[(axis + turn) % 3] * (1.0 + f64::from(random.below(4))));
            let at = DVec3::from([0; 3].map(|_| f64::from(random.below(6)) - 3.0));
            vec![at, at + u, at + u + v, at + v]
        };
        all.corners
            .extend(corners.into_iter().map(Into::<[f64; 3]>::into));
        all.starts.push(all.corners.len() as u32);
    }
    all
}

/// Pieces in the order in which they are met, each with the number of its run.
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

/// Where a ray meets a polygon; `None` also where it is too near an edge, or too level, to be sure.
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

/// Along many rays, each hit belongs to exactly one piece, and these come in the order of the walk. Gives the number
/// of hits looked at.
fn rays_agree(polygons: &Polygons, tree: &BspTree, random: &mut Random, tolerance: f64) -> usize {
    let mut looked_at = 0;
    for view in 0..12 {
        // Some eyes stand in the planes of the grid.
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
                assert_eq!(held, 1, "pieces of polygon {polygon} hold one hit");
                let (run, piece) = mine
                    .find(|(_, piece)| holds(tree, piece, point))
                    .expect("one does");
                way_of_run.push((*run, way));
                let same =
                    |(_, p): &&(usize, Piece)| (p.polygon, p.first_cut) == (piece.polygon, piece.first_cut);
                assert!(far.iter().find(same).is_some());
                let bounds_hold = |bounds: &Aabb| bounds.contains(point.as_vec3().into());
                let met = met_if(tree, eye, true, bounds_hold);
                assert!(
                    met.iter().find(same).is_some(),
                    "a box above the piece does not hold it"
                );
                looked_at += 1;
            }
            way_of_run.sort_by_key(|&(run, _)| run);
            for pair in way_of_run.windows(2) {
                let [(first_run, first), (second_run, second)] = [pair[0], pair[1]];
                assert!(second > first - tolerance, "{first} was met before {second}");
                if first_run == second_run {
                    assert!((first - second).abs() < tolerance, "not in one plane");
                }
            }
        }
    }
    looked_at
}

#[test]
fn along_any_ray_pieces_come_in_the_order_of_the_walk() {
    let mut random = Random(1);
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
    let mut random = Random(2);
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

#[test]
fn slack_saves_the_cuts_that_part_nothing() {
    // A tiled wall, oblique, its corners rounded to f32.
    let [u, v] = [DVec3::new(0.31, 0.05, 0.17), DVec3::new(-0.11, 0.37, 0.07)];
    let at = |i: u32, j: u32| {
        (DVec3::splat(1.7) + u * f64::from(i) + v * f64::from(j))
            .as_vec3()
            .as_dvec3()
    };
    let tiles = (0..400_u32).flat_map(|tile| {
        let [i, j] = [tile % 20, tile / 20];
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    let mut wall = polygons(tiles);
    let exact = BspTree::build(&wall, &BspOptions::default());
    assert!(exact.splits() > 0, "rounding bent the wall");
    wall.slack = vec![2_f32.powi(-20); count(&wall)];
    let tree = BspTree::build(&wall, &BspOptions::default());
    assert_eq!((tree.splits(), tree.depth()), (0, 1));
    // A poster that hangs nearer than the wall's slack, but is exact itself, is still before it.
    let hung = DVec3::new(0.0, 0.0, 1e-9);
    let [a, b, c] = [at(3, 3), at(9, 3), at(3, 9)].map(|corner| (corner + hung).to_array());
    wall.corners.extend([a, b, c]);
    wall.starts.push(wall.corners.len() as u32);
    let tree = BspTree::build(&wall, &BspOptions::default());
    assert!(tree.splits() > 0 || tree.depth() > 1);
}

#[test]
fn a_hundred_thousand_polygons_in_one_plane_are_one_leaf() {
    let [u, v] = [DVec3::new(0.31, 0.05, 0.17), DVec3::new(-0.11, 0.37, 0.07)];
    let floor = polygons((0..100_000_u32).map(|tile| {
        let at = DVec3::splat(-50.0) + u * f64::from(tile % 300) + v * f64::from(tile / 300);
        [at, at + u, at + u + v, at + v]
    }));
    let same = polygons((0..100_000).map(|_| [DVec3::ZERO, u, v]));
    let none = polygons((0..100_000).map(|i| [u * f64::from(i); 3]));
    for polygons in [floor, same, none] {
        let tree = BspTree::build(&polygons, &BspOptions::default());
        assert_eq!((tree.pieces(), tree.splits(), tree.depth()), (100_000, 0, 1));
    }
}

#[test]
fn a_long_row_is_sorted_into_a_shallow_tree() {
    let row = polygons((0..100_000).map(|i| {
        let at = DVec3::Z * f64::from(i);
        [at, at + DVec3::X, at + DVec3::Y]
    }));
    let tree = BspTree::build(&row, &BspOptions::default());
    assert!(tree.splits() == 0 && tree.depth() < 60, "{}", tree.depth());
    let order = met(&tree, DVec3::Z * -1.0, true);
    assert!(
        order
            .iter()
            .enumerate()
            .all(|(place, (_, piece))| piece.polygon == place as u32)
    );
}

#[test]
fn a_tree_may_be_as_deep_as_it_has_polygons() {
    let side = |i: u32| DVec3::new((f64::from(i) * 1e-3).cos(), 0.0, (f64::from(i) * 1e-3).sin());
    let drum =
        polygons((0..6000).map(|i| [side(i), side(i + 1), side(i + 1) + DVec3::Y, side(i) + DVec3::Y]));
    let options = BspOptions {
        free_splits: f32::INFINITY,
        ..BspOptions::default()
    };
    let tree = BspTree::build(&drum, &options);
    assert_eq!((tree.pieces(), tree.depth()), (6000, 6000));
    assert_eq!(met(&tree, DVec3::ZERO, true).len(), 6000);
}

#[test]
fn what_is_as_thin_as_rounding_is_kept_but_neither_cuts_nor_is_cut() {
    let wall = [
        DVec3::new(0.0, -9.0, -9.0),
        DVec3::new(0.0, 9.0, -9.0),
        DVec3::new(0.0, 0.0, 9.0),
    ];
    let needle = |i: i32| {
        let at = f64::from(i);
        [
            DVec3::new(-1.0, at, 0.0),
            DVec3::new(1.0, 0.1, at),
            DVec3::new(0.0, 0.5 * (at + 0.1), 0.5 * at),
        ]
    };
    let tree = BspTree::build(
        &polygons([wall].into_iter().chain((0..50).map(needle))),
        &BspOptions::default(),
    );
    assert_eq!((tree.pieces(), tree.splits()), (51, 0));
}

#[test]
fn where_memory_ends_the_rest_stays_together() {
    let polygons = jumble(&mut Random(3), 200);
    let whole = BspTree::build(&polygons, &BspOptions::default());
    let limit_bytes = whole.bytes() / 3;
    let options = BspOptions {
        limit_bytes,
        ..BspOptions::default()
    };
    let tree = BspTree::build(&polygons, &options);
    assert!(whole.is_complete() && !tree.is_complete());
    assert!(
        tree.bytes() < limit_bytes * 3 / 2,
        "{} of {limit_bytes}",
        tree.bytes()
    );
    let there: BTreeSet<u32> = met(&tree, DVec3::ZERO, true)
        .iter()
        .map(|(_, p)| p.polygon)
        .collect();
    assert_eq!(there.len(), 200);
}

#[test]
fn nothing_makes_an_empty_tree() {
    for polygons in [Polygons::default(), polygons::<3>([])] {
        let tree = BspTree::build(&polygons, &BspOptions::default());
        assert_eq!((tree.pieces(), tree.depth(), tree.bytes()), (0, 0, 0));
        assert!(met(&tree, DVec3::ZERO, false).is_empty());
    }
}

#[test]
fn the_same_polygons_give_the_same_tree() {
    let polygons = jumble(&mut Random(4), 300);
    let [a, b] = [(); 2].map(|()| BspTree::build(&polygons, &BspOptions::default()));
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
}

/// Triangles and parallelograms on a tiny grid: many have no area, are there twice, cross, touch or share planes.
fn hard_ones() -> impl Strategy<Value = Polygons> {
    let corner = || prop::array::uniform3(0..4_i32).prop_map(|c| DVec3::from(c.map(f64::from)));
    let one = (prop::array::uniform3(corner()), any::<bool>(), 0..3_i32);
    let scale = prop::sample::select(vec![1.0, 1e7, 1e-5]);
    (prop::collection::vec(one, 1..60), scale, any::<bool>()).prop_map(|(list, scale, moved)| {
        let mut all = Polygons {
            starts: vec![0],
            ..Polygons::default()
        };
        for ([a, b, c], four, bend) in list {
            let mut corners = vec![a, b, c];
            if four {
                corners.push(a + c - b);
            }
            // A hair's breadth makes needles of what has no area, and slivers of what is cut.
            corners[0].x += f64::from(bend) * 1e-13;
            let away = if moved {
                DVec3::new(0.1, 0.2, 0.3)
            } else {
                DVec3::ZERO
            };
            all.corners
                .extend(corners.iter().map(|&c| ((c + away) * scale).to_array()));
            all.starts.push(all.corners.len() as u32);
        }
        all
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn nothing_is_lost_and_nothing_explodes(polygons in hard_ones()) {
        let tree = BspTree::build(&polygons, &BspOptions::default());
        let n = count(&polygons) as u64;
        prop_assert!(tree.is_complete());
        prop_assert_eq!(tree.pieces(), n + tree.splits());
        prop_assert!(tree.pieces() <= n * (n + 8), "{} pieces of {}", tree.pieces(), n);
        let there: BTreeSet<u32> = met(&tree, DVec3::ONE, true).iter().map(|(_, p)| p.polygon).collect();
        prop_assert_eq!(there.len() as u64, n);
    }
}
