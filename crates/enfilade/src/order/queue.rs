//! A queue of boxes by nearness, over any tree of items.
//!
//! What waits to be entered (nodes of the scene, items, nodes of their meshes, clusters) stands in one queue by how
//! near its box comes, so that a near wall is met before a far one also where their nodes are entered at once.
//! Source: Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.1; the queue is ours.
//! Cost: a walk O(boxes met · log waiting), and what nothing of can be seen ends its subtree.
//! Gives nodes near to far; single faces may come in any order.

use super::Visit;
use super::items::hand_out_openings;
use crate::content::{Content, ItemId};
use crate::faces::Faces;
use crate::geom::Aabb;
use crate::passage::Passage;
use crate::region::{Region, Sight};
use glam::DAffine3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

/// A tree over the items of a content, numbered by node; its boxes are in the space of the fragment.
pub(super) trait Tree {
    /// The number of the root; `None` where the tree holds nothing.
    fn root(&self) -> Option<u32>;

    /// The box of a node: the boxes of all nodes that hold an item cover all of it.
    fn bounds(&self, node: u32) -> &Aabb;

    /// The numbers of a node's children.
    fn children(&self, node: u32) -> Range<u32>;

    /// The items that stand in a node itself.
    fn items(&self, node: u32) -> &[u32];
}

/// What waits to be entered, and the items that were.
#[derive(Default)]
pub struct Queue {
    waiting: BinaryHeap<Waiting>,
    entered: Vec<(ItemId, DAffine3)>,
}

/// A box that waits; the greatest is the nearest.
struct Waiting {
    region: Region,
    what: What,
}

/// Boxes as near as each other come in this order, so that a walk is the same every time.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    Node(u32),
    Item(u32),
    /// A node of a mesh; the item by its place in [`Queue::entered`].
    MeshNode {
        entered: u32,
        node: u32,
    },
    Cluster {
        entered: u32,
        cluster: u32,
    },
}

impl Ord for Waiting {
    fn cmp(&self, other: &Waiting) -> Ordering {
        self.region
            .nearest
            .total_cmp(&other.region.nearest)
            .then(other.what.cmp(&self.what))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Waiting) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Waiting) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting {}

/// Hands out all faces of the items of `tree`, and the openings, that may be seen through `passage`.
pub(super) fn walk(
    tree: &impl Tree,
    content: &Content,
    passage: &Passage,
    queue: &mut Queue,
    visit: &mut impl Visit,
) {
    hand_out_openings(content, passage, visit);
    queue.waiting.clear();
    queue.entered.clear();
    if let Some(root) = tree.root() {
        queue.push_node(tree, root, passage);
    }
    while let Some(Waiting { region, what }) = queue.waiting.pop() {
        if visit.enter(&region) == Sight::Hidden {
            continue;
        }
        match what {
            What::Node(node) => enter_node(tree, node, content, passage, queue),
            What::Item(item) => enter_item(ItemId(item), content, passage, queue, visit),
            What::MeshNode { entered, node } => enter_mesh_node(entered, node, content, passage, queue),
            What::Cluster { entered, cluster } => {
                let (item, screen_from_item) = &queue.entered[entered as usize];
                visit.faces(&Faces::of_cluster(content, *item, cluster, screen_from_item));
            }
        }
    }
}

fn enter_node(tree: &impl Tree, node: u32, content: &Content, passage: &Passage, queue: &mut Queue) {
    for child in tree.children(node) {
        queue.push_node(tree, child, passage);
    }
    for &item in tree.items(node) {
        let placed = content.item(ItemId(item));
        let screen_from_item = passage.screen_from(&placed.transform());
        queue.push(
            passage,
            &screen_from_item,
            &content.mesh_of(ItemId(item)).bounds(),
            What::Item(item),
        );
    }
}

fn enter_item(item: ItemId, content: &Content, passage: &Passage, queue: &mut Queue, visit: &mut impl Visit) {
    let mesh = content.mesh_of(item);
    if !visit.first_time(item) {
        return;
    }
    let screen_from_item = passage.screen_from(&content.item(item).transform());
    if mesh.clusters().len() == 1 {
        visit.faces(&Faces::of_cluster(content, item, 0, &screen_from_item));
    } else if let Some(root) = mesh.tree().root() {
        queue.entered.push((item, screen_from_item));
        enter_mesh_node(queue.entered.len() as u32 - 1, root, content, passage, queue);
    }
}

fn enter_mesh_node(entered: u32, node: u32, content: &Content, passage: &Passage, queue: &mut Queue) {
    let (item, screen_from_item) = queue.entered[entered as usize];
    let mesh = content.mesh_of(item);
    for node in mesh.tree().children(node) {
        queue.push(
            passage,
            &screen_from_item,
            mesh.tree().bounds(node),
            What::MeshNode { entered, node },
        );
    }
    for &cluster in mesh.tree().things(node) {
        let bounds = &mesh.clusters()[cluster as usize].bounds;
        queue.push(
            passage,
            &screen_from_item,
            bounds,
            What::Cluster { entered, cluster },
        );
    }
}

impl Queue {
    fn push_node(&mut self, tree: &impl Tree, node: u32, passage: &Passage) {
        self.push(
            passage,
            &passage.screen_from_fragment,
            tree.bounds(node),
            What::Node(node),
        );
    }

    fn push(&mut self, passage: &Passage, screen_from_local: &DAffine3, bounds: &Aabb, what: What) {
        self.waiting
            .extend(Region::of(passage, screen_from_local, bounds).map(|region| Waiting { region, what }));
    }
}
