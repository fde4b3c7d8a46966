//! Whole trees: what they hold, and the order of a walk.

use super::*;

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
    let tree = Octree::build(&bounds, 4, Copies::OnePerCell);
    let things = met(&tree, [-1.0, -1.0, -1.0]);
    let distinct: std::collections::BTreeSet<u32> = things.iter().copied().collect();
    assert_eq!(distinct.len(), bounds.len());
    assert!(
        things.len() < 2 * bounds.len(),
        "few things are cut by the grid: {}",
        things.len()
    );
    let place = |thing: u32| things.iter().position(|&t| t == thing).expect("met above");
    assert!(place(0) < place(500) && place(500) < place(999));
}

#[test]
fn the_nodes_that_hold_a_thing_cover_it() {
    let bounds = pebbles();
    let tree = Octree::build(&bounds, 4, Copies::OnePerCell);
    let mut node = Aabb::EMPTY;
    let mut held = vec![0.0; bounds.len()];
    tree.walk([0.0; 3], |step| {
        match step {
            Step::Node(b) => node = *b,
            Step::Thing(thing) => held[thing as usize] += node.intersection(&bounds[thing as usize]).volume(),
        }
        true
    });
    for (thing, volume) in held.iter().enumerate() {
        assert!(
            *volume > 0.999 * bounds[thing].volume(),
            "thing {thing} is not covered by its nodes"
        );
    }
}

#[test]
fn a_flat_scene_does_not_double_at_every_level() {
    let bounds: Vec<Aabb> = pebbles()
        .iter()
        .map(|b| Aabb {
            min: [b.min[0], 0.0, b.min[2]],
            max: [b.max[0], 0.0, b.max[2]],
        })
        .collect();
    assert!(met(&Octree::build(&bounds, 4, Copies::OnePerCell), [0.0; 3]).len() <= 4 * bounds.len());
}

#[test]
fn a_thing_with_one_place_is_met_once_and_held_whole() {
    let bounds = pebbles();
    let tree = Octree::build(&bounds, 4, Copies::One);
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
    assert_eq!(
        met(&Octree::build(&bounds, 4, Copies::OnePerCell), [0.0; 3]).len(),
        100
    );
    assert!(met(&Octree::build(&[Aabb::EMPTY], 4, Copies::One), [0.0; 3]).is_empty());
}
