//! Octree over items: near to far, box by box, and whole nodes dropped.
//!
//! What waits to be entered (nodes of the scene, items, nodes of their meshes, clusters) stands in one queue by how
//! near its box comes, so that a near wall is met before a far one also where their nodes are entered at once.
//! Source: Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.1; the tree is that of
//!     Boreskov, Hierarchical s-buffer for scenes of high complexity, its order of children made finer.
//! Cost: building O(n log n); a walk O(boxes met · log waiting), and what nothing of can be seen ends its subtree.
//! Gives nodes near to far; single faces may come in any order.

use super::items::hand_out_openings;
use super::{NodesNearToFar, Order, Visit};
use crate::content::{Content, ItemId};
use crate::faces::Faces;
use crate::geom::{Aabb, Copies, Octree};
use crate::passage::Passage;
use crate::region::{Region, Sight};
use glam::DAffine3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Items in nested eighths of space.
pub struct OctreeOrder {
    tree: Octree,
}

/// Items in a leaf, at most. A test costs about as much as a small item's faces.
const FEW_ITEMS: usize = 6;

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

impl Order for OctreeOrder {
    type Gives = NodesNearToFar;
    type Scratch = Queue;

    fn build(content: &Content, _limit_bytes: u64) -> Option<OctreeOrder> {
        let bounds: Vec<Aabb> = content.items().iter().map(|item| item.bounds).collect();
        Some(OctreeOrder {
            tree: Octree::build(&bounds, FEW_ITEMS, Copies::OnePerCell),
        })
    }

    fn needs_bytes(content: &Content) -> u64 {
        // At the depth where it stays, an item is no smaller than half a cell: it stands in at most 3 of them along
        // each axis, in practice in one or two; eight copies with a node each are an ample guess.
        content.items().len() as u64 * 8 * 64
    }

    fn bytes(&self) -> u64 {
        self.tree.bytes()
    }

    fn visit(&self, content: &Content, passage: &Passage, queue: &mut Queue, visit: &mut impl Visit) {
        hand_out_openings(content, passage, visit);
        queue.waiting.clear();
        queue.entered.clear();
        if let Some(root) = self.tree.root() {
            queue.push(
                passage,
                &passage.screen_from_fragment,
                self.tree.bounds(root),
                What::Node(root),
            );
        }
        while let Some(Waiting { region, what }) = queue.waiting.pop() {
            if visit.enter(&region) == Sight::Hidden {
                continue;
            }
            match what {
                What::Node(node) => self.enter_node(node, content, passage, queue),
                What::Item(item) => enter_item(ItemId(item), content, passage, queue, visit),
                What::MeshNode { entered, node } => enter_mesh_node(entered, node, content, passage, queue),
                What::Cluster { entered, cluster } => {
                    let (item, screen_from_item) = &queue.entered[entered as usize];
                    visit.faces(&Faces::of_cluster(content, *item, cluster, screen_from_item));
                }
            }
        }
    }
}

impl OctreeOrder {
    fn enter_node(&self, node: u32, content: &Content, passage: &Passage, queue: &mut Queue) {
        for child in self.tree.children(node) {
            queue.push(
                passage,
                &passage.screen_from_fragment,
                self.tree.bounds(child),
                What::Node(child),
            );
        }
        for &item in self.tree.things(node) {
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
    fn push(&mut self, passage: &Passage, screen_from_local: &DAffine3, bounds: &Aabb, what: What) {
        self.waiting
            .extend(Region::of(passage, screen_from_local, bounds).map(|region| Waiting { region, what }));
    }
}
