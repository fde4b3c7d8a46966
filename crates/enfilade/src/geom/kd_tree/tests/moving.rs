//! Insertion, removal and movement of primitives in a kd-tree.

use super::*;
use crate::geom::tree_laws::{DynamicTree, World, placed};

const FEW: usize = 6;

impl DynamicTree for KdTree {
    const COPIES: bool = true;
    const MAX_LEVELS: u32 = super::super::MAX_DEPTH;

    fn over(bounds: &[Aabb]) -> KdTree {
        KdTree::build(bounds, FEW)
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
        self.near_and_far(node, [0.0; 3]).map_or(Vec::new(), Vec::from)
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

    fn check(&self, bounds: &[Aabb]) {
        let everything = (0..bounds.len() as u32).filter(|&thing| !bounds[thing as usize].is_empty());
        let everything: Vec<u32> = everything.collect();
        assert_eq!(self.count, everything.len());
        let everywhere = Aabb {
            min: [f32::NEG_INFINITY; 3],
            max: [f32::INFINITY; 3],
        };
        let mut held = 0;
        let mut nodes = 0;
        // Nodes, their cells, and the primitives that the planes lead there.
        let mut pending: Vec<(u32, Aabb, Vec<u32>)> = self
            .root()
            .map(|root| (root, everywhere, everything))
            .into_iter()
            .collect();
        while let Some((node, cell, reach)) = pending.pop() {
            nodes += 1;
            let inside = reach
                .iter()
                .map(|&thing| bounds[thing as usize].intersection(&cell));
            let inside = inside.fold(Aabb::EMPTY, |sum, held| sum.union(&held));
            assert_eq!(
                inside,
                *self.bounds(node),
                "the AABB of node {node} does not fit its content tightly"
            );
            match self.nodes[node as usize].contents {
                Contents::Halves { axis, at, low, .. } => {
                    for (half, cell) in cut(&cell, axis.into(), at).into_iter().enumerate() {
                        let side = |&thing: &u32| sides(&bounds[thing as usize], axis.into(), at)[half];
                        pending.push((
                            low + half as u32,
                            cell,
                            reach.iter().copied().filter(side).collect(),
                        ));
                    }
                }
                Contents::Things(run) => {
                    held += run.len();
                    let mut things = self.things.get(run).to_vec();
                    things.sort();
                    assert_eq!(things, reach);
                }
            }
        }
        assert_eq!(held, self.held);
        if nodes > 0 {
            assert_eq!(nodes + 2 * self.free_pairs.len(), self.nodes.len());
        }
    }
}

#[test]
fn giants_that_come_take_no_more_memory_than_they_would_have_from_the_start() {
    let mut world = World::<KdTree>::town(3000);
    let giants: Vec<(u32, Aabb)> = (0..200)
        .map(|thing| (thing, placed([-1.0 - thing as f32; 3], [300.0; 3])))
        .collect();
    world.change(&giants);
    assert!(world.tree.held > COPIES * 3000);
    assert!(world.tidy());
    assert!(world.tree.held <= COPIES * 3000);
    world.check();
}
