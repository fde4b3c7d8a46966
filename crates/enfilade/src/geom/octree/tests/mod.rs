//! Checks whole trees: their content and traversal order.

mod moving;

use super::*;
use crate::geom::changes::hard_boxes;

fn pebbles() -> Vec<Aabb> {
    (0..1000_u32)
        .map(|i| {
            let at = [(i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32];
            Aabb {
                min: at,
                max: at.map(|value| value + 0.3),
            }
        })
        .collect()
}

fn met(tree: &Octree, eye: [f64; 3]) -> Vec<u32> {
    let mut things = Vec::new();
    tree.walk(eye, |step| {
        if let Step::Thing(thing) = step {
            things.push(thing);
        }
        true
    });
    things
}

#[test]
fn a_walk_meets_every_thing_and_the_near_ones_first() {
    let bounds = pebbles();
    let tree = Octree::build(&bounds, 4);
    let things = met(&tree, [-1.0, -1.0, -1.0]);
    let distinct: std::collections::BTreeSet<u32> = things.iter().copied().collect();
    assert_eq!([distinct.len(), things.len()], [bounds.len(); 2]);
    let place = |thing: u32| things.iter().position(|&t| t == thing).expect("visited above");
    assert!(place(0) < place(500) && place(500) < place(999));
}

#[test]
fn a_thing_is_met_once_and_held_whole() {
    let bounds = pebbles();
    let tree = Octree::build(&bounds, 4);
    assert_eq!(met(&tree, [0.0; 3]).len(), bounds.len());
    let mut node = Aabb::EMPTY;
    tree.walk([0.0; 3], |step| {
        match step {
            Step::Node(b) => node = *b,
            Step::Thing(thing) => assert_eq!(node.union(&bounds[thing as usize]), node),
        }
        true
    });
}

#[test]
fn coincident_things_end_in_one_deep_node() {
    let bounds = vec![
        Aabb {
            min: [1.0; 3],
            max: [1.0; 3]
        };
        100
    ];
    assert_eq!(met(&Octree::build(&bounds, 4), [0.0; 3]).len(), 100);
    assert!(met(&Octree::build(&[Aabb::EMPTY], 4), [0.0; 3]).is_empty());
}

/// Each level of a tree costs O(n) to build, so the depth bounds the cost of building.
#[test]
fn octrees_over_a_hundred_thousand_boxes_that_are_hard_to_separate_are_shallow_and_small() {
    for (what, boxes) in hard_boxes(100_000) {
        let tree = Octree::build(&boxes, 4);
        let mut held = 0;
        let mut pending: Vec<(u32, u32)> = tree.root().map(|root| (root, 0)).into_iter().collect();
        while let Some((node, depth)) = pending.pop() {
            assert!(depth <= MAX_DEPTH, "{what}");
            held += tree.things(node).len();
            pending.extend(tree.children(node).map(|child| (child, depth + 1)));
        }
        assert_eq!(held, boxes.len(), "{what}");
        assert!(
            tree.node_count() <= 2 * boxes.len(),
            "{what}: {} nodes",
            tree.node_count()
        );
    }
}
