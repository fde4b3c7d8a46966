//! Octrees as lists of nodes, for files.

use super::{Node, Octree};
use crate::geom::Aabb;
use bytemuck::{Pod, Zeroable};

/// A node without its box, which follows from its primitives.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct StoredNode {
    center: [f32; 3],
    first_child: u32,
    /// Bit mask of the octants that have a child.
    children: u32,
    /// Number of primitives.
    things: u32,
}

impl Octree {
    /// Returns the nodes of a tree that was never changed, and whose primitives are numbered node by node.
    pub(crate) fn stored(&self) -> Vec<StoredNode> {
        let nodes = self.nodes.iter().map(|node| StoredNode {
            center: node.center,
            first_child: node.first_child,
            children: u32::from(node.children),
            things: node.things.len() as u32,
        });
        nodes.collect()
    }

    /// Returns the tree of these nodes over the boxes of primitives, which are numbered node by node. `None` if it is none:
    /// each node but the first must be the child of one before it, and each primitive in one node.
    pub(crate) fn restored(nodes: &[StoredNode], boxes: &[Aabb]) -> Option<Octree> {
        let mut tree = Octree {
            few: boxes.len(),
            count: boxes.len(),
            ..Octree::default()
        };
        let mut is_child = vec![false; nodes.len()];
        let mut numbers: Vec<u32> = Vec::new();
        let mut thing = 0;
        for (number, stored) in nodes.iter().enumerate() {
            let children = u8::try_from(stored.children).ok()?;
            let first = stored.first_child as usize;
            let end = first.checked_add(children.count_ones() as usize)?;
            for child in is_child
                .get_mut(first.min(end)..end)
                .filter(|_| children != 0 && first > number)
                .into_iter()
                .flatten()
            {
                if std::mem::replace(child, true) {
                    return None;
                }
            }
            let is_sound = children == 0 || (first > number && end <= nodes.len());
            let after =
                u32::checked_add(thing, stored.things).filter(|&after| after as usize <= boxes.len())?;
            if !is_sound || !stored.center.iter().all(|value| value.is_finite()) {
                return None;
            }
            numbers.clear();
            numbers.extend(thing..after);
            thing = after;
            tree.nodes.push(Node {
                bounds: Aabb::EMPTY,
                center: stored.center,
                first_child: stored.first_child,
                children,
                room: children.count_ones() as u8,
                things: tree.things.put(&numbers),
            });
        }
        if thing as usize != boxes.len() || is_child.iter().skip(1).any(|is_child| !is_child) {
            return None;
        }
        if nodes.is_empty() != boxes.is_empty() {
            return None;
        }
        for node in (0..nodes.len() as u32).rev() {
            tree.fit(node, &|thing| boxes[thing as usize]);
        }
        tree.space = tree.root().map_or(Aabb::EMPTY, |root| *tree.bounds(root));
        Some(tree)
    }
}
