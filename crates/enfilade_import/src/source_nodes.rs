//! Maps the items of a room to the nodes of its file.

use enfilade::ItemIndex;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// The nodes that the items of a room come from: their indices in the file, and ids that other programs assigned to
/// them.
///
/// Empty for formats without nodes: OBJ, compiled maps and terrain descriptions. Takes 8 bytes per node, however many
/// items the node makes, and nothing for the id of a node without one.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SourceNodes {
    /// First item of each node, with the node's index, in item order.
    firsts: Vec<(ItemIndex, u32)>,
    /// Ids by node index.
    ids: BTreeMap<u32, Box<str>>,
    /// Nodes that can move.
    movable: BTreeSet<u32>,
}

impl SourceNodes {
    /// Records that `item` comes from `node`. Items must be added in increasing order and grouped by node; only the
    /// first item of each node is required.
    pub(crate) fn add(&mut self, item: ItemIndex, node: u32, id: Option<&str>) {
        if self.firsts.last().is_some_and(|&(_, last)| last == node) {
            return;
        }
        self.firsts.push((item, node));
        if let Some(id) = id {
            self.ids.insert(node, id.into());
        }
    }

    /// Records that `copy` comes from the node of an item of `others`.
    pub(crate) fn add_copy(&mut self, copy: ItemIndex, others: &SourceNodes, item: ItemIndex) {
        let Some(node) = others.node(item) else { return };
        self.add(copy, node, others.ids.get(&node).map(|id| &**id));
        if others.movable.contains(&node) {
            self.movable.insert(node);
        }
    }

    /// Records that a node can move.
    pub(crate) fn add_movable(&mut self, node: u32) {
        self.movable.insert(node);
    }

    /// Returns `true` if an item's node, or one above it, is the target of an animation, a joint of a skin, or marked as a door by
    /// `extras.enfilade.kind`.
    pub fn is_movable(&self, item: ItemIndex) -> bool {
        self.node(item).is_some_and(|node| self.movable.contains(&node))
    }

    /// Returns the index of an item's node in the `nodes` of its glTF file; `None` if the file has no nodes.
    ///
    /// All instances of a node, and all blocks of a terrain, return the same node.
    pub fn node(&self, item: ItemIndex) -> Option<u32> {
        let after = self.firsts.partition_point(|&(first, _)| first <= item);
        Some(self.firsts[..after].last()?.1)
    }

    /// Returns the id in the `extras` of an item's node, such as the `globalId` of an IFC element; `None` if there is
    /// none.
    ///
    /// The id is the value of `globalId`, `ifcGuid`, `guid`, `uuid` or `id`; if a node has several of these keys, the
    /// first in this order. Case and underscores of the key are ignored: `GlobalId` and `global_id` match `globalId`.
    /// The value is a non-empty string or an integer, of at most 256 bytes.
    pub fn id(&self, item: ItemIndex) -> Option<&str> {
        self.ids.get(&self.node(item)?).map(|id| &**id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_items_of_a_node_have_its_index_and_its_id() {
        let mut nodes = SourceNodes::default();
        nodes.add(ItemIndex(0), 4, None);
        (1..4).for_each(|item| nodes.add(ItemIndex(item), 7, Some("trees")));
        nodes.add(ItemIndex(4), 9, None);
        let of = |item| (nodes.node(ItemIndex(item)), nodes.id(ItemIndex(item)));
        assert_eq!(of(0), (Some(4), None));
        assert_eq!([of(1), of(3)], [(Some(7), Some("trees")); 2]);
        assert_eq!(of(4), (Some(9), None));
    }

    #[test]
    fn items_of_a_file_without_nodes_have_none() {
        let nodes = SourceNodes::default();
        assert_eq!((nodes.node(ItemIndex(0)), nodes.id(ItemIndex(0))), (None, None));
    }
}
