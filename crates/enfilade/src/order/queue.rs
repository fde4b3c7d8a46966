//! A queue of boxes by reversed depth, over any tree of items.
//!
//! What waits to be entered (nodes of the scene, items, nodes of their meshes, clusters) stands in one queue by how
//! near its box comes, so that a near wall is met before a far one also where their nodes are entered at once.
//! Source: Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.1; the queue is ours.
//! Cost: a walk O(boxes met · log waiting), and what nothing of can be seen ends its subtree.
//! Gives nodes near to far; single faces may come in any order.

use super::Visit;
use super::items::hand_out_openings;
use crate::faces::Faces;
use crate::geom::Aabb;
use crate::geometry::{Geometry, ItemId};
use crate::passage::Passage;
use crate::region::{BOXES, EightBoxes, Region, Visibility};
use glam::DAffine3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::Range;

/// A tree over the items of a geometry, numbered by node; its boxes are in the space of the sector.
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
    /// What waits is moved about often, and a region is large: it stays in its place here.
    regions: Vec<Region>,
    /// Places in `regions` to be filled anew.
    free: Vec<u32>,
    entered: Vec<(ItemId, DAffine3)>,
}

/// A box that waits; the greatest is the nearest.
struct Waiting {
    nearest: f32,
    what: What,
    /// The place of its box in [`Queue::regions`].
    region: u32,
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
        self.nearest
            .total_cmp(&other.nearest)
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
    geometry: &Geometry,
    passage: &Passage,
    queue: &mut Queue,
    visit: &mut impl Visit,
) {
    begin(tree, geometry, passage, queue, visit);
    go_on(tree, geometry, passage, queue, visit, f32::NEG_INFINITY, |_| true);
}

/// Hands out the openings, and lets the root of `tree` wait.
pub(super) fn begin(
    tree: &impl Tree,
    geometry: &Geometry,
    passage: &Passage,
    queue: &mut Queue,
    visit: &mut impl Visit,
) {
    hand_out_openings(geometry, passage, visit);
    queue.waiting.clear();
    queue.regions.clear();
    queue.free.clear();
    queue.entered.clear();
    if let Some(root) = tree.root() {
        queue.push_node(tree, root, passage);
    }
}

/// Hands out what waits and is at least so near, of the items that are wanted.
pub(super) fn go_on(
    tree: &impl Tree,
    geometry: &Geometry,
    passage: &Passage,
    queue: &mut Queue,
    visit: &mut impl Visit,
    rev_depth: f32,
    wanted: impl Fn(u32) -> bool,
) {
    while let Some(&Waiting {
        nearest,
        region,
        what,
    }) = queue.waiting.peek()
    {
        if nearest < rev_depth {
            break;
        }
        queue.waiting.pop();
        queue.free.push(region);
        if visit.enter(&queue.regions[region as usize]) == Visibility::Hidden {
            continue;
        }
        match what {
            What::Node(node) => enter_node(tree, node, geometry, passage, queue, &wanted),
            What::Item(item) => {
                let region = queue.regions[region as usize];
                enter_item(ItemId(item), &region, geometry, passage, queue, visit);
            }
            What::MeshNode { entered, node } => {
                let (item, _) = queue.entered[entered as usize];
                if !visit.are_enough(item, node, &queue.regions[region as usize]) {
                    enter_mesh_node(entered, node, geometry, passage, queue);
                }
            }
            What::Cluster { entered, cluster } => {
                let (item, screen_from_item) = &queue.entered[entered as usize];
                visit.faces(&Faces::of_cluster(geometry, *item, cluster, screen_from_item));
            }
        }
    }
}

fn enter_node(
    tree: &impl Tree,
    node: u32,
    geometry: &Geometry,
    passage: &Passage,
    queue: &mut Queue,
    wanted: impl Fn(u32) -> bool,
) {
    let children = tree
        .children(node)
        .map(|child| (*tree.bounds(child), What::Node(child)));
    queue.push_all(passage, &passage.screen_from_sector, children);
    for &item in tree.items(node).iter().filter(|&&item| wanted(item)) {
        let placed = geometry.item(ItemId(item));
        let screen_from_item = passage.screen_from(&placed.transform());
        queue.push(
            passage,
            &screen_from_item,
            &geometry.mesh_of(ItemId(item)).bounds(),
            What::Item(item),
        );
    }
}

fn enter_item(
    item: ItemId,
    region: &Region,
    geometry: &Geometry,
    passage: &Passage,
    queue: &mut Queue,
    visit: &mut impl Visit,
) {
    let mesh = geometry.mesh_of(item);
    if !visit.first_time(item) {
        return;
    }
    let screen_from_item = passage.screen_from(&geometry.item(item).transform());
    if mesh.clusters().len() == 1 {
        visit.faces(&Faces::of_cluster(geometry, item, 0, &screen_from_item));
    } else if let Some(root) = mesh
        .tree()
        .root()
        .filter(|&root| !visit.are_enough(item, root, region))
    {
        queue.entered.push((item, screen_from_item));
        enter_mesh_node(queue.entered.len() as u32 - 1, root, geometry, passage, queue);
    }
}

fn enter_mesh_node(entered: u32, node: u32, geometry: &Geometry, passage: &Passage, queue: &mut Queue) {
    let (item, screen_from_item) = queue.entered[entered as usize];
    let mesh = geometry.mesh_of(item);
    let nodes = mesh
        .tree()
        .children(node)
        .map(|node| (*mesh.tree().bounds(node), What::MeshNode { entered, node }));
    let clusters = mesh.tree().things(node).iter().map(|&cluster| {
        let bounds = mesh.clusters()[cluster as usize].bounds;
        (bounds, What::Cluster { entered, cluster })
    });
    queue.push_all(passage, &screen_from_item, nodes.chain(clusters));
}

impl Queue {
    fn push_node(&mut self, tree: &impl Tree, node: u32, passage: &Passage) {
        self.push(
            passage,
            &passage.screen_from_sector,
            tree.bounds(node),
            What::Node(node),
        );
    }

    fn push(&mut self, passage: &Passage, screen_from_local: &DAffine3, bounds: &Aabb, what: What) {
        if let Some(region) = Region::of(passage, screen_from_local, bounds) {
            self.push_region(region, what);
        }
    }

    /// Lets all wait that are in view.
    fn push_all(
        &mut self,
        passage: &Passage,
        screen_from_local: &DAffine3,
        mut all: impl Iterator<Item = (Aabb, What)>,
    ) {
        let mut boxes = [Aabb::EMPTY; BOXES];
        let mut whats = [What::Node(0); BOXES];
        loop {
            let mut count = 0;
            for (bounds, what) in all.by_ref().take(BOXES) {
                (boxes[count], whats[count]) = (bounds, what);
                count += 1;
            }
            match count {
                0 => return,
                1 => self.push(passage, screen_from_local, &boxes[0], whats[0]),
                _ => {
                    let eight = EightBoxes::of(passage, screen_from_local, &boxes[..count]);
                    for (lane, what) in whats[..count].iter().enumerate() {
                        if let Some(region) = eight.region(lane) {
                            self.push_region(region, *what);
                        }
                    }
                }
            }
        }
    }

    fn push_region(&mut self, region: Region, what: What) {
        let place = if let Some(place) = self.free.pop() {
            self.regions[place as usize] = region;
            place
        } else {
            self.regions.push(region);
            self.regions.len() as u32 - 1
        };
        self.waiting.push(Waiting {
            nearest: region.nearest,
            what,
            region: place,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faces::FaceSource;
    use crate::geom::Transform;
    use crate::geometry::{GeometryBuilder, Material, MaterialId};
    use crate::mesh::Mesh;
    use crate::order::{BvhOrder, OctreeOrder, Order};
    use crate::scene::SectorId;
    use crate::view::View;
    use std::collections::BTreeSet;

    /// A mesh of several clusters, and copies of it and of single triangles all about.
    fn geometry() -> Geometry {
        let mut builder = GeometryBuilder::new([Material::opaque([1.0; 3])]);
        let side = 40_u32;
        let positions: Vec<[f32; 3]> = (0..side * side)
            .map(|i| [(i % side) as f32, (i % 7) as f32 * 0.1, (i / side) as f32])
            .collect();
        let corners: Vec<u32> = (0..side * (side - 1))
            .filter(|i| i % side != side - 1)
            .flat_map(|i| [i, i + 1, i + side])
            .collect();
        let ground = Mesh::triangles(&positions, &corners, MaterialId(0)).expect("a sound sheet");
        assert!(ground.clusters().len() > 4);
        let leaf = Mesh::triangles(
            &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]],
            &[0, 1, 2],
            MaterialId(0),
        );
        let meshes = [ground, leaf.expect("a triangle")].map(|mesh| builder.mesh(mesh));
        for i in 0..300_u32 {
            let at = [i % 9, i / 9 % 5, i / 45].map(|step| step as f32 * 7.3 - 20.0);
            let place = Transform::translation(at) * Transform::rotation([1.0, 2.0, 3.0], f64::from(i));
            builder.item("thing", meshes[usize::from(i % 10 != 0)], place);
        }
        builder.build().expect("sound things")
    }

    /// What an order hands out, but for what is farther than this, and how many boxes it asked about.
    #[derive(Default)]
    struct Met {
        items: BTreeSet<u32>,
        batches: BTreeSet<(u32, u32)>,
        boxes: usize,
        farthest: f32,
    }

    impl Visit for Met {
        fn enter(&mut self, region: &Region) -> Visibility {
            self.boxes += 1;
            if region.nearest < self.farthest {
                Visibility::Hidden
            } else {
                Visibility::Partial
            }
        }

        fn first_time(&mut self, item: ItemId) -> bool {
            self.items.insert(item.0)
        }

        fn faces(&mut self, faces: &Faces) {
            if let FaceSource::Item(item, cluster) = faces.source {
                assert!(self.batches.insert((item.0, cluster)), "{item:?} comes twice");
            }
        }
    }

    fn met<O: Order>(geometry: &Geometry, passage: &Passage, farthest: f32) -> Met {
        let order = O::build(geometry, u64::MAX).expect("no limit");
        assert!(order.bytes() <= O::needs_bytes(geometry));
        let mut met = Met {
            farthest,
            ..Met::default()
        };
        order.visit(geometry, passage, &mut O::Scratch::default(), &mut met);
        met
    }

    #[test]
    fn trees_of_all_kinds_hand_out_the_same() {
        let geometry = geometry();
        for (i, toward) in [[0.0, 0.0, -9.0], [5.0, 1.0, 3.0], [-3.0, -8.0, 1.0]]
            .into_iter()
            .enumerate()
        {
            let view = View::new([0.3 * i as f32, 1.0, 2.0], toward, [160, 90]);
            let passage = Passage::at_the_eye(&view, SectorId(0), false);
            for farthest in [0.0, 0.05] {
                let octree = met::<OctreeOrder>(&geometry, &passage, farthest);
                let bvh = met::<BvhOrder>(&geometry, &passage, farthest);
                // The box of a mesh at its place reaches beyond the item's box, so an item whose own box is out may still
                // be handed out where a node holds others too.
                let own = |item: u32| {
                    let bounds = geometry.item(ItemId(item)).bounds;
                    Region::of(&passage, &passage.screen_from_sector, &bounds)
                };
                let is_in = |(item, _): &&(u32, u32)| own(*item).is_some_and(|own| own.nearest >= farthest);
                let [a, b] = [&octree, &bvh].map(|met| met.batches.iter().filter(is_in).collect::<Vec<_>>());
                assert_eq!(a, b);
                assert!(octree.batches.len() > 20 && octree.boxes > 40 && bvh.boxes > 40);
            }
        }
    }
}
