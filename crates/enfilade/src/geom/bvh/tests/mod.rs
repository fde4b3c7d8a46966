//! Checks whole trees: their content and depth.

mod moving;

use super::*;
use crate::geom::changes::hard_boxes;

const FEW: u32 = 6;

const MAX_LEVELS: usize = build::MAX_LEVELS as usize;

fn cubes(places: impl Iterator<Item = [f32; 3]>, side: f32) -> Vec<Aabb> {
    let cube = |at: [f32; 3]| Aabb {
        min: at,
        max: at.map(|value| value + side),
    };
    places.map(cube).collect()
}

/// Checks that every primitive is in one leaf and enclosed by all boxes above it. Returns the depth.
fn check(bounds: &[Aabb]) -> usize {
    let tree = Bvh::build(bounds, FEW);
    let mut met = vec![0; bounds.len()];
    let mut deepest = 0;
    let mut pending: Vec<(u32, usize)> = tree.root().map(|root| (root, 1)).into_iter().collect();
    while let Some((node, depth)) = pending.pop() {
        deepest = deepest.max(depth);
        let held = tree.bounds(node);
        for child in tree.children(node) {
            assert!(child > node);
            assert_eq!(held.union(tree.bounds(child)), *held);
            pending.push((child, depth + 1));
        }
        for &thing in tree.things(node) {
            assert_eq!(held.union(&bounds[thing as usize]), *held);
            met[thing as usize] += 1;
        }
    }
    for (thing, times) in met.into_iter().enumerate() {
        assert_eq!(times, usize::from(!bounds[thing].is_empty()), "thing {thing}");
    }
    deepest
}

#[test]
fn every_thing_stands_in_one_leaf_whose_boxes_hold_it() {
    let grid = (0..1000_u16).map(|i| [i % 10, i / 10 % 10, i / 100].map(f32::from));
    let mut bounds = cubes(grid, 0.3);
    bounds[17] = Aabb::EMPTY;
    let depth = check(&bounds);
    assert!((8..20).contains(&depth), "{depth}");
}

#[test]
fn few_things_or_none_make_a_tree() {
    for count in 0..10 {
        check(&cubes((0..count).map(|i| [f32::from(i as u8); 3]), 1.0));
    }
    check(&[Aabb::EMPTY; 3]);
}

#[test]
fn things_that_coincide_or_are_huge_or_tiny_make_a_tree() {
    check(&cubes((0..5000).map(|_| [1.0; 3]), 0.0));
    check(&cubes((0..300).map(|i| [1.2_f32.powi(i); 3]), 1.0));
    check(&cubes((0..300).map(|i| [1e-38 * i as f32; 3]), 1e-39));
    let [low, high] = [[-3e38; 3], [3e38; 3]];
    check(&cubes([low, high, [0.0; 3], low, [1e-20; 3]].into_iter(), 1e37));
}

/// Each level of a tree costs O(n) to build, so the depth bounds the cost of building.
#[test]
fn trees_over_a_hundred_thousand_boxes_that_are_hard_to_separate_are_shallow() {
    for (what, boxes) in hard_boxes(100_000) {
        let depth = check(&boxes);
        assert!(depth <= MAX_LEVELS, "{what}: {depth} levels");
    }
}

#[test]
fn boxes_that_are_infinite_or_no_numbers_stand_in_a_shallow_tree_too() {
    let mut boxes = cubes((0..10_000_u16).map(|i| [f32::from(i); 3]), 1.0);
    for (i, extreme) in boxes.iter_mut().enumerate().step_by(3) {
        let value = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][i % 9 / 3];
        extreme.max = [f32::INFINITY; 3];
        extreme.min[i % 2] = value;
    }
    let solid = boxes.iter().filter(|bounds| !bounds.is_empty()).count();
    let tree = Bvh::build(&boxes, FEW);
    let mut held = 0;
    let mut pending: Vec<(u32, usize)> = tree.root().map(|root| (root, 1)).into_iter().collect();
    while let Some((node, depth)) = pending.pop() {
        assert!(depth <= MAX_LEVELS);
        held += tree.things(node).len();
        pending.extend(tree.children(node).map(|child| (child, depth + 1)));
    }
    assert!(solid > 9000);
    assert_eq!(held, solid);
}
