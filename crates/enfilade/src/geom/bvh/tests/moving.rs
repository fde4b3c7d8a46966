//! Insertion, removal and movement of primitives in a BVH.

use super::*;
use crate::geom::tree_laws::DynamicTree;

impl DynamicTree for Bvh {
    const COPIES: bool = false;
    const MAX_LEVELS: u32 = super::super::build::MAX_LEVELS;

    fn over(bounds: &[Aabb]) -> Bvh {
        Bvh::build(bounds, FEW)
    }

    fn shift(&mut self, moved: &[(u32, Aabb)], bounds: &[Aabb], touched: &mut Vec<u32>) {
        self.shift(moved.iter().copied(), &|thing| bounds[thing as usize], touched);
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
        self.nodes.len()
    }

    fn bytes(&self) -> u64 {
        self.bytes()
    }

    fn check(&self, _bounds: &[Aabb]) {
        let mut nodes = 0;
        let mut leaves = 0;
        let mut pending: Vec<u32> = self.root().into_iter().collect();
        while let Some(node) = pending.pop() {
            nodes += 1;
            leaves += usize::from(!self.things(node).is_empty());
            for &thing in self.things(node) {
                assert_eq!(self.leaves[thing as usize], node);
            }
            for child in self.children(node) {
                assert_eq!(self.parents[pair_of(child)], node);
                pending.push(child);
            }
        }
        if nodes > 0 {
            assert_eq!(nodes + 2 * self.free_pairs.len(), self.nodes.len());
        }
        assert_eq!(
            (leaves + self.free_slots.len()) * self.few as usize,
            self.things.len()
        );
    }
}

#[test]
fn things_that_come_one_after_the_other_along_a_row_or_to_one_place_make_no_list() {
    for step in [0.0, 1.0] {
        let place = |thing: u32| Aabb {
            min: [step * thing as f32; 3],
            max: [step * thing as f32 + 0.5; 3],
        };
        let mut tree = Bvh::build(&[], FEW);
        for thing in 0..5000 {
            tree.insert(thing, &place, &mut Vec::new());
        }
        let mut deepest = 0;
        let mut pending = vec![(0, 1)];
        while let Some((node, depth)) = pending.pop() {
            deepest = deepest.max(depth);
            pending.extend(tree.children(node).map(|child| (child, depth + 1)));
        }
        assert!((10..60).contains(&deepest), "{deepest}");
    }
}
