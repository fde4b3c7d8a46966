//! Checks whole trees: their content and depth.

mod moving;

use super::*;

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
