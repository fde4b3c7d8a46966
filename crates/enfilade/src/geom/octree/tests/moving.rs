//! Insertion, removal and movement of primitives in an octree.

use super::*;
use crate::geom::tree_laws::{DynamicTree, World};
use fastrand::Rng;

const FEW: usize = 6;

impl DynamicTree for Octree {
    const COPIES: bool = false;
    const MAX_LEVELS: u32 = super::super::MAX_DEPTH;

    fn over(bounds: &[Aabb]) -> Octree {
        Octree::build(bounds, FEW)
    }

    fn shift(&mut self, moved: &[(u32, Aabb)], bounds: &[Aabb], touched: &mut Vec<u32>) {
        for (thing, was) in moved {
            self.shift(*thing, was, &|thing| bounds[thing as usize], touched);
        }
    }

    fn tidy(&mut self, bounds: &[Aabb]) -> bool {
        self.tidy(bounds.len(), &|thing| bounds[thing as usize])
    }

    fn root(&self) -> Option<u32> {
        self.root()
    }

    fn bounds(&self, node: u32) -> Aabb {
        *self.bounds(node)
    }

    fn children(&self, node: u32) -> Vec<u32> {
        self.children(node).collect()
    }

    fn things(&self, node: u32) -> &[u32] {
        self.things(node)
    }

    fn node_count(&self) -> usize {
        self.node_count()
    }

    fn bytes(&self) -> u64 {
        self.bytes()
    }

    fn check(&self, bounds: &[Aabb]) {
        let count = bounds.iter().filter(|bounds| !bounds.is_empty()).count();
        assert_eq!(self.count, count);
        // A traversal, which has a fixed-size stack, visits the same primitives.
        let mut met = super::met(self, [0.0; 3]);
        met.sort();
        met.dedup();
        assert_eq!(met.len(), count);
        // Each node is in use once, or free.
        let mut used: usize = usize::from(!self.nodes.is_empty());
        let mut pending: Vec<u32> = self.root().into_iter().collect();
        while let Some(node) = pending.pop() {
            used += usize::from(self.nodes[node as usize].room);
            assert!(self.children(node).len() <= usize::from(self.nodes[node as usize].room));
            pending.extend(self.children(node));
        }
        assert_eq!(used + self.spare.len(), self.nodes.len());
    }
}

#[test]
fn a_move_touches_at_most_64_nodes() {
    let mut world = World::<Octree>::town(10_000);
    let mut random = Rng::with_seed(2);
    let mut most = 0;
    for step in 0..20_000_u32 {
        let thing = random.u32(..10_000);
        let to = if step % 2 == 0 {
            thing
        } else {
            random.u32(..10_000)
        };
        // A small step, a jump to the position of another, or into a crowd.
        let by = 0.2 * random.f32();
        let corner = if step % 5 == 0 {
            [50.0; 3]
        } else {
            world.bounds[to as usize].min
        };
        let [low, high] = [corner, corner.map(|at| at + 0.5)].map(|at| at.map(|at| at + by));
        world.change(&[(thing, Aabb { min: low, max: high })]);
        most = most.max(world.touched.len());
        assert!(world.touched.len() <= 64, "{}", world.touched.len());
    }
    assert!(most > 10, "{most}");
    world.check();
}

#[test]
fn a_world_that_moves_away_or_grows_is_built_anew_and_one_that_mills_about_is_not() {
    let mut world = World::<Octree>::town(1000);
    let mut random = Rng::with_seed(9);
    for _ in 0..20 {
        let changes: Vec<(u32, Aabb)> = (0..1000)
            .map(|thing| (thing, world.bounds[random.usize(..1000)]))
            .collect();
        world.change(&changes);
        assert!(!world.tidy());
    }
    let away = |by: f32, bounds: &[Aabb]| -> Vec<(u32, Aabb)> {
        let moved = |at: [f32; 3]| at.map(|at| at + by);
        let moved = |held: &Aabb| Aabb {
            min: moved(held.min),
            max: moved(held.max),
        };
        (0..).zip(bounds.iter().map(moved)).collect()
    };
    world.change(&away(1000.0, &world.bounds.clone()));
    assert!(world.tidy() && !world.tidy());
    world.check();
    assert!(world.cost_ratio().into_iter().all(|by| by < 1.01));
}
