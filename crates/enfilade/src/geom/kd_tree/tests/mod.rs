//! Checks whole trees: their content and traversal order.

mod moving;

use super::*;
use crate::geom::tree_laws::hard_boxes;
use fastrand::Rng;
use std::collections::BTreeSet;

fn cube(at: [f32; 3], side: f32) -> Aabb {
    Aabb {
        min: at,
        max: at.map(|value| value + side),
    }
}

fn pebbles(count: usize, side: f32) -> Vec<Aabb> {
    let mut random = Rng::with_seed(7);
    (0..count)
        .map(|_| cube([0; 3].map(|_| 100.0 * random.f32()), side * random.f32()))
        .collect()
}

/// Calls `each` with every node, front to back, and whether it is a leaf.
fn walk(tree: &KdTree, eye: [f64; 3], mut each: impl FnMut(u32, bool)) {
    let mut pending: Vec<u32> = tree.root().into_iter().collect();
    while let Some(node) = pending.pop() {
        let halves = tree.near_and_far(node, eye);
        each(node, halves.is_none());
        if let Some([near, far]) = halves {
            pending.extend([far, near]);
        }
    }
}

/// Checks the invariants of a tree; returns the total number of references in its leaves.
fn check(bounds: &[Aabb], few: usize) -> usize {
    let tree = KdTree::build(bounds, few);
    assert!(tree.bytes() <= KdTree::max_bytes(bounds.len()));
    let mut volume = vec![0.0; bounds.len()];
    let mut met = BTreeSet::new();
    let mut held = 0;
    walk(&tree, [0.0; 3], |node, is_leaf| {
        let outer = *tree.bounds(node);
        if let Some(halves) = tree.near_and_far(node, [0.0; 3]) {
            for half in halves {
                assert_eq!(
                    outer.union(tree.bounds(half)),
                    outer,
                    "a child extends beyond its parent"
                );
            }
        }
        held += tree.things(node).len();
        assert!(is_leaf || tree.things(node).is_empty());
        for &thing in tree.things(node) {
            met.insert(thing);
            let shared = outer.intersection(&bounds[thing as usize]);
            assert!(!shared.is_empty(), "primitive {thing} is outside its leaf");
            volume[thing as usize] += shared.volume();
        }
    });
    for (thing, whole) in bounds.iter().enumerate() {
        assert_eq!(met.contains(&(thing as u32)), !whole.is_empty());
        let lost = whole.volume() - volume[thing];
        assert!(
            lost <= 1e-3 * whole.volume(),
            "the leaves of primitive {thing} do not contain all of it"
        );
    }
    assert!(held <= COPIES * bounds.len());
    held
}

#[test]
fn every_thing_is_held_whole_and_few_are_copied() {
    let held = check(&pebbles(3000, 3.0), 6);
    assert!((3000..6000).contains(&held), "{held}");
    let large = check(&pebbles(3000, 60.0), 6);
    assert!(large <= COPIES * 3000, "{large}");
}

#[test]
fn no_leaf_comes_after_one_that_it_hides() {
    let tree = KdTree::build(&pebbles(1000, 0.1), 2);
    let mut random = Rng::with_seed(3);
    let mut crossed = 0;
    for eye in [[-10.0; 3], [100.0, -5.0, 50.0], [50.0; 3]] {
        let mut leaves = Vec::new();
        walk(&tree, eye, |node, is_leaf| {
            if is_leaf {
                leaves.push(*tree.bounds(node));
            }
        });
        for (place, leaf) in leaves.iter().enumerate() {
            let inside = |axis: usize, t: f32| leaf.min[axis] + t * (leaf.max[axis] - leaf.min[axis]);
            let target = [0, 1, 2].map(|axis| f64::from(inside(axis, random.f32())));
            for step in 1..10 {
                let t = 0.1 * f64::from(step);
                let at = [0, 1, 2].map(|axis| eye[axis] + t * (target[axis] - eye[axis]));
                let holds = |other: &Aabb| {
                    (0..3).all(|a| f64::from(other.min[a]) < at[a] && at[a] < f64::from(other.max[a]))
                };
                if let Some(before) = leaves.iter().position(holds) {
                    assert!(before <= place, "from {eye:?}");
                    crossed += usize::from(before < place);
                }
            }
        }
    }
    assert!(crossed > 100, "{crossed}");
}

#[test]
fn a_plane_runs_along_the_aisle_and_cuts_nothing() {
    let shelves: Vec<Aabb> = (0..64)
        .map(|i| cube([if i < 32 { 0.0 } else { 4.5 }, i as f32 % 32.0, 0.0], 4.0))
        .map(|b| Aabb {
            max: [b.max[0], b.min[1] + 0.5, b.max[2]],
            ..b
        })
        .collect();
    assert_eq!(check(&shelves, 4), 64);
}

#[test]
fn walls_in_one_plane_are_not_copied() {
    let mut walls = pebbles(500, 2.0);
    for wall in &mut walls {
        wall.min[1] = 7.0;
        wall.max[1] = 7.0;
    }
    assert!(check(&walls, 4) < 1000);
}

#[test]
fn what_cannot_be_parted_is_one_leaf() {
    assert_eq!(KdTree::build(&[], 4).root(), None);
    assert_eq!(KdTree::build(&[Aabb::EMPTY; 9], 4).root(), None);
    assert_eq!(check(&vec![cube([1.0; 3], 0.0); 1000], 4), 1000);
    assert_eq!(check(&vec![cube([1.0; 3], 2.0); 1000], 4), 1000);
    // Nested boxes (Russian dolls): every plane cuts all but a few.
    let dolls: Vec<Aabb> = (0..100).map(|i| cube([-(i as f32); 3], 2.0 * i as f32)).collect();
    check(&dolls, 4);
    let huge = [
        cube([-3e38; 3], 1.0),
        cube([3e38; 3], 1.0),
        Aabb::EMPTY,
        cube([0.0; 3], 1.0),
    ];
    check(&huge, 1);
}

#[test]
fn a_hundred_thousand_things_are_parted_in_no_time() {
    let bounds = pebbles(100_000, 0.5);
    let tree = KdTree::build(&bounds, 6);
    let mut largest = 0;
    walk(&tree, [0.0; 3], |node, _| {
        largest = largest.max(tree.things(node).len())
    });
    assert!(largest <= 6);
}

#[test]
fn kd_trees_over_boxes_that_are_hard_to_separate_are_small() {
    for (what, boxes) in hard_boxes(100_000) {
        let tree = KdTree::build(&boxes, 6);
        assert!(tree.held <= COPIES * boxes.len(), "{what}: {}", tree.held);
        assert!(tree.bytes() <= KdTree::max_bytes(boxes.len()), "{what}");
    }
}
