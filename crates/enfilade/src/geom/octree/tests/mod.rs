//! Checks whole trees: their content and traversal order.

mod moving;

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
    let tree = Octree::build(&bounds, 4);
    let things = met(&tree, [-1.0, -1.0, -1.0]);
    let distinct: std::collections::BTreeSet<u32> = things.iter().copied().collect();
    assert_eq!([distinct.len(), things.len()], [bounds.len(); 2]);
    let place = |thing: u32| things.iter().position(|&t| t == thing).expect("visited above");
    assert!(place(0) < place(500) && place(500) < place(999));
}
