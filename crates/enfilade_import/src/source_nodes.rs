//! Which nodes of a file the items of a room come from.

use enfilade::ItemId;
use std::collections::BTreeMap;

/// The nodes that the items of a room come from: their indices in the file, and the ids that other programs know them by.
///
/// Empty where a file has no nodes: OBJ, compiled maps and described terrain. Takes 8 bytes for each node, however many items
/// the node makes, and nothing for a node without an id.
#[derive(Clone, Debug, Default)]
pub struct SourceNodes {
    /// The first item of each node, in the order of the items.
    firsts: Vec<(ItemId, u32)>,
    /// By node.
    ids: BTreeMap<u32, Box<str>>,
}

impl SourceNodes {
    /// Says which node an item comes from. Items come in order, those of one node one after the other; only the first of them
    /// must be added.
    pub(crate) fn add(&mut self, item: ItemId, node: u32, id: Option<&str>) {
        if self.firsts.last().is_some_and(|&(_, last)| last == node) {
            return;
        }
        self.firsts.push((item, node));
        if let Some(id) = id {
            self.ids.insert(node, id.into());
        }
    }

    /// Returns the index of an item's node in the `nodes` of its glTF file; `None` where the file has no nodes.
    ///
    /// Instances of one node, and the blocks of one terrain, are items of the same node.
    pub fn node(&self, item: ItemId) -> Option<u32> {
        let after = self.firsts.partition_point(|&(first, _)| first <= item);
        Some(self.firsts[..after].last()?.1)
    }

    /// Returns the id that the `extras` of an item's node give it, such as the `globalId` of an IFC element; `None` where they
    /// give none.
    ///
    /// An id is the value of `globalId`, `ifcGuid`, `guid`, `uuid` or `id`; where a node has several of these keys, of the first
    /// in this order. Case and underscores of the key do not count: `GlobalId` and `global_id` are `globalId`. The value is a
    /// text that is not empty, or a whole number, of at most 256 bytes.
    pub fn id(&self, item: ItemId) -> Option<&str> {
        self.ids.get(&self.node(item)?).map(|id| &**id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_items_of_a_node_have_its_index_and_its_id() {
        let mut nodes = SourceNodes::default();
        nodes.add(ItemId(0), 4, None);
        (1..4).for_each(|item| nodes.add(ItemId(item), 7, Some("trees")));
        nodes.add(ItemId(4), 9, None);
        let of = |item| (nodes.node(ItemId(item)), nodes.id(ItemId(item)));
        assert_eq!(of(0), (Some(4), None));
        assert_eq!([of(1), of(3)], [(Some(7), Some("trees")); 2]);
        assert_eq!(of(4), (Some(9), None));
    }

    #[test]
    fn items_of_a_file_without_nodes_have_none() {
        let nodes = SourceNodes::default();
        assert_eq!((nodes.node(ItemId(0)), nodes.id(ItemId(0))), (None, None));
    }
}
