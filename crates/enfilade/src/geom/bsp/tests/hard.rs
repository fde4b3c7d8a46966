//! Hard input: many coplanar polygons, long rows, slivers, a low memory limit, no polygons at all.

use super::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

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
    let polygons = jumble(&mut Dice::new(3), 200);
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
    let polygons = jumble(&mut Dice::new(4), 300);
    let [a, b] = [(); 2].map(|()| BspTree::build(&polygons, &BspOptions::default()));
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
}

/// Triangles and parallelograms on a tiny grid; many have no area, are duplicates, cross, touch or are coplanar.
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
            // A tiny offset turns polygons without area into needles, and cut ones into slivers.
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
