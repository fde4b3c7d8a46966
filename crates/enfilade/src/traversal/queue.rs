//! Priority queue of boxes by reversed depth, over any tree of items.
//!
//! Pending nodes of the scene, items, nodes of their meshes and clusters share one queue, sorted by the nearest point
//! of their boxes. So a near wall is visited before a far one even if their nodes overlap or were entered together. On
//! a city, this set up an order of magnitude fewer triangles than a fixed order of octree children
//! ([`crate::geom::Octree::walk`]), which needs no queue.
//! Source: Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.1; the queue is ours.
//! Cost: a traversal O(boxes tested · log(queue length)). Culling a hidden box ends its subtree.
//! Guarantees nodes front to back; single faces may come in any order.

use super::Visit;
use super::items::emit_openings;
use crate::faces::Faces;
use crate::geom::Aabb;
use crate::geometry::Geometry;
use crate::ids::ItemIndex;
use crate::ranked::Ranked;
use crate::view::passage::Passage;
use crate::view::region::{BOXES, EightBoxes, Region, Visibility};
use crate::view::screen_map::ScreenMap;
use std::collections::BinaryHeap;
use std::ops::Range;

/// A tree over the items of a geometry, with numbered nodes and AABBs in sector space.
pub(crate) trait Tree {
    /// Returns the root node; `None` if the tree is empty.
    fn root(&self) -> Option<u32>;

    /// Returns the AABB of a node. The AABBs of all nodes that list an item together contain the whole item.
    fn bounds(&self, node: u32) -> &Aabb;

    /// Returns the children of a node.
    fn children(&self, node: u32) -> Range<u32>;

    /// Returns the items of a node itself, without those of its children.
    fn items(&self, node: u32) -> &[u32];
}

/// Pending boxes, and the items entered so far.
#[derive(Default)]
pub struct Queue {
    /// By the nearest reversed depth; each target with the index of its region in [`Queue::regions`].
    pending: BinaryHeap<Ranked<f32, (Target, u32)>>,
    /// Regions of the pending boxes. The heap moves its entries often, and a region is large, so entries refer to it by
    /// index.
    regions: Vec<Region>,
    /// Free slots of `regions`.
    free: Vec<u32>,
    entered: Vec<(ItemIndex, ScreenMap)>,
}

/// Object of a pending box. Boxes of equal depth come in this order, so that every traversal is deterministic.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Target {
    Node(u32),
    Item(u32),
    /// A node of a mesh's octree; `entered` is an index into [`Queue::entered`].
    MeshNode {
        entered: u32,
        node: u32,
    },
    Cluster {
        entered: u32,
        cluster: u32,
    },
}

/// Emits the openings, and all faces of the items of `tree` that may be visible through `passage`.
pub(crate) fn walk(
    tree: &impl Tree,
    geometry: &Geometry,
    passage: &Passage,
    queue: &mut Queue,
    visit: &mut impl Visit,
) {
    begin(tree, geometry, passage, queue, visit);
    go_on(tree, geometry, passage, queue, visit, f32::NEG_INFINITY, |_| true);
}

/// Emits the openings and pushes the root of `tree`.
pub(crate) fn begin(
    tree: &impl Tree,
    geometry: &Geometry,
    passage: &Passage,
    queue: &mut Queue,
    visit: &mut impl Visit,
) {
    emit_openings(geometry, passage, visit);
    queue.pending.clear();
    queue.regions.clear();
    queue.free.clear();
    queue.entered.clear();
    if let Some(root) = tree.root() {
        queue.push_node(tree, root, passage);
    }
}

/// Pops queued nodes with reversed depth ≥ `rev_depth` and emits their faces, filtered by `wanted` items.
pub(crate) fn go_on(
    tree: &impl Tree,
    geometry: &Geometry,
    passage: &Passage,
    queue: &mut Queue,
    visit: &mut impl Visit,
    rev_depth: f32,
    wanted: impl Fn(u32) -> bool,
) {
    while let Some(&Ranked(nearest, (target, region))) = queue.pending.peek() {
        if nearest < rev_depth {
            break;
        }
        queue.pending.pop();
        queue.free.push(region);
        if visit.enter(&queue.regions[region as usize]) == Visibility::Hidden {
            continue;
        }
        match target {
            Target::Node(node) => enter_node(tree, node, geometry, passage, queue, &wanted),
            Target::Item(item) => {
                let region = queue.regions[region as usize];
                enter_item(ItemIndex(item), &region, geometry, passage, queue, visit);
            }
            Target::MeshNode { entered, node } => {
                let (item, _) = queue.entered[entered as usize];
                if !visit.are_enough(item, node, &queue.regions[region as usize]) {
                    enter_mesh_node(entered, node, geometry, passage, queue);
                }
            }
            Target::Cluster { entered, cluster } => {
                let (item, screen_from_item) = &queue.entered[entered as usize];
                let faces = Faces::of_cluster(geometry, *item, cluster, screen_from_item);
                visit.faces_within(&faces, &queue.regions[region as usize]);
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
        .map(|child| (*tree.bounds(child), Target::Node(child)));
    queue.push_all(passage, &passage.screen_from_sector, children);
    for &item in tree.items(node).iter().filter(|&&item| wanted(item)) {
        let placed = geometry.item(ItemIndex(item));
        if placed.options.layers & passage.options.layers == 0 {
            continue;
        }
        let screen_from_item = passage.screen_from(&placed.transform());
        queue.push(
            passage,
            &screen_from_item,
            &geometry.mesh_of(ItemIndex(item)).bounds(),
            Target::Item(item),
        );
    }
}

fn enter_item(
    item: ItemIndex,
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
        visit.faces_within(&Faces::of_cluster(geometry, item, 0, &screen_from_item), region);
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
        .map(|node| (*mesh.tree().bounds(node), Target::MeshNode { entered, node }));
    let clusters = mesh.tree().things(node).iter().map(|&cluster| {
        let bounds = mesh.clusters()[cluster as usize].bounds;
        (bounds, Target::Cluster { entered, cluster })
    });
    queue.push_all(passage, &screen_from_item, nodes.chain(clusters));
}

impl Queue {
    fn push_node(&mut self, tree: &impl Tree, node: u32, passage: &Passage) {
        self.push(
            passage,
            &passage.screen_from_sector,
            tree.bounds(node),
            Target::Node(node),
        );
    }

    fn push(&mut self, passage: &Passage, screen_from_local: &ScreenMap, bounds: &Aabb, target: Target) {
        if let Some(region) = Region::of(passage, screen_from_local, bounds) {
            self.push_region(region, target);
        }
    }

    /// Pushes all boxes that are in view.
    fn push_all(
        &mut self,
        passage: &Passage,
        screen_from_local: &ScreenMap,
        mut all: impl Iterator<Item = (Aabb, Target)>,
    ) {
        let mut boxes = [Aabb::EMPTY; BOXES];
        let mut targets = [Target::Node(0); BOXES];
        loop {
            let mut count = 0;
            for (bounds, target) in all.by_ref().take(BOXES) {
                (boxes[count], targets[count]) = (bounds, target);
                count += 1;
            }
            match count {
                0 => return,
                1 => self.push(passage, screen_from_local, &boxes[0], targets[0]),
                _ => {
                    let eight = EightBoxes::of(passage, screen_from_local, &boxes[..count]);
                    for (lane, target) in targets[..count].iter().enumerate() {
                        if let Some(region) = eight.region(lane) {
                            self.push_region(region, *target);
                        }
                    }
                }
            }
        }
    }

    fn push_region(&mut self, region: Region, target: Target) {
        let slot = if let Some(slot) = self.free.pop() {
            self.regions[slot as usize] = region;
            slot
        } else {
            self.regions.push(region);
            self.regions.len() as u32 - 1
        };
        self.pending.push(Ranked(region.nearest, (target, slot)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faces::FaceSource;
    use crate::geom::Transform;
    use crate::geometry::{GeometryBuilder, Material};
    use crate::ids::MaterialId;
    use crate::ids::SectorId;
    use crate::mesh::Mesh;
    use crate::order::{BvhOrder, OctreeOrder, Order};
    use crate::view::View;
    use std::collections::BTreeSet;

    /// Builds a mesh of several clusters, and scattered instances of it and of single triangles.
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
        let ground = Mesh::triangles(&positions, &corners, MaterialId(0)).expect("a valid mesh");
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
        builder.build().expect("valid geometry")
    }

    /// Records what an order emits, apart from boxes with reversed depth below `farthest`, and counts the boxes tested.
    #[derive(Default)]
    struct VisitLog {
        items: BTreeSet<u32>,
        batches: BTreeSet<(u32, u32)>,
        boxes: usize,
        farthest: f32,
    }

    impl Visit for VisitLog {
        fn enter(&mut self, region: &Region) -> Visibility {
            self.boxes += 1;
            if region.nearest < self.farthest {
                Visibility::Hidden
            } else {
                Visibility::Partial
            }
        }

        fn first_time(&mut self, item: ItemIndex) -> bool {
            self.items.insert(item.0)
        }

        fn faces(&mut self, faces: &Faces) {
            if let FaceSource::Item(item, cluster) = faces.source {
                assert!(
                    self.batches.insert((item.0, cluster)),
                    "a cluster of {item:?} was emitted twice"
                );
            }
        }
    }

    fn met<O: Order>(geometry: &Geometry, passage: &Passage, farthest: f32) -> VisitLog {
        let order = O::build(geometry, u64::MAX).expect("no limit");
        assert!(order.bytes() <= O::needs_bytes(geometry));
        let mut met = VisitLog {
            farthest,
            ..VisitLog::default()
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
            let view = View::new([0.3 * i as f32, 1.0, 2.0], toward, [160, 90]).expect("a valid view");
            let passage = Passage::at_the_eye(&view, SectorId(0), false);
            for farthest in [0.0, 0.05] {
                let octree = met::<OctreeOrder>(&geometry, &passage, farthest);
                let bvh = met::<BvhOrder>(&geometry, &passage, farthest);
                // The transformed box of a mesh extends beyond the item's AABB, so an item whose AABB is beyond the
                // limit may still be emitted if a node contains other items too.
                let own = |item: u32| {
                    let bounds = geometry.item(ItemIndex(item)).bounds;
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
