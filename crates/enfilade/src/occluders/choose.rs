//! Selects the best occluders for a view, by a measure of how much they hide.
//!
//! A best-first search with one priority queue: it holds octree nodes over the items, items, nodes over their polygons,
//! and polygons, each by an upper bound of the measure of anything inside it; measured polygons are queued by their
//! value. So polygons come out best first, and subtrees that are distant, small or outside the view are never entered.
//! A caller that inserts each occluder into a cover before the next one is selected can report boxes that are hidden by
//! now, and these are not entered either. Otherwise most of the best occluders would be behind others, the more so the
//! larger the scene.
//! Source: Coorg, Teller, Real-Time Occlusion Culling for Models with Large Occluders, I3D 1997, section 3.3; the
//!     search is that of Hart, Nilsson, Raphael, A Formal Basis for the Heuristic Determination of Minimum Cost Paths,
//!     1968.
//! Cost: O(boxes tested · log queue length), a few boxes for each selected occluder; no allocation once warm.
//! If nothing is reported as hidden, the selection equals that of measuring every polygon of every item.

use super::measure::{Chooser, EnteredItem, OccluderMeasure};
use super::{OccluderSet, Polygon};
use crate::geom::Aabb;
use crate::geometry::Geometry;
use crate::ids::ItemIndex;
use crate::ranked::Ranked;
use crate::view::passage::Passage;
use crate::view::screen_map::ScreenMap;
use glam::DVec3;
use std::collections::BinaryHeap;

/// An occluder selected for a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectedOccluder {
    /// The item that the occluder belongs to.
    pub item: ItemIndex,
    /// Index of the polygon among the occluders of the item's mesh, from 0.
    pub polygon: u32,
    /// Value by the requested [`OccluderMeasure`]; no occluder selected later has a larger one.
    pub value: f64,
    /// Index among all polygons of the set.
    index: u32,
}

#[cfg(test)]
impl SelectedOccluder {
    /// Selects a polygon of the first item, which is a copy of the first mesh.
    pub(super) fn for_tests(index: u32) -> SelectedOccluder {
        SelectedOccluder {
            item: ItemIndex(0),
            polygon: index,
            value: 1.0,
            index,
        }
    }
}

/// The selected occluders, and buffers reused from one selection to the next.
///
/// Pass the same value to [`OccluderSet::choose`] every frame to avoid allocations.
#[derive(Debug, Default)]
pub struct OccluderSelection {
    /// By an upper bound of the measure; for a measured polygon by the measure itself.
    queue: BinaryHeap<Ranked<f64, QueueTarget>>,
    entered: Vec<EnteredItem>,
    corners: Vec<DVec3>,
    chosen: Vec<SelectedOccluder>,
    /// Number of boxes and polygons tested against the passage.
    met: u64,
}

impl OccluderSelection {
    /// Returns the occluders of the last selection, best first.
    pub fn chosen(&self) -> &[SelectedOccluder] {
        &self.chosen
    }

    /// Returns the number of boxes and polygons tested for the last selection.
    pub fn met(&self) -> u64 {
        self.met
    }
}

/// Target of a queue entry.
///
/// Among equal bounds boxes come first, so that all polygons of that value are known when one of them is taken; then
/// lower numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum QueueTarget {
    /// A node over the items.
    Node(u32),
    /// An item, by its index.
    Item(u32),
    /// A node over a mesh's polygons; `entered` is the index of the item in [`OccluderSelection::entered`].
    MeshNode { entered: u32, node: u32 },
    /// A polygon that is not measured yet, by its index in the set.
    Polygon { entered: u32, index: u32 },
    /// A measured polygon.
    Measured { item: u32, index: u32 },
}

impl OccluderSet {
    /// Selects up to `budget` occluders visible in `passage`, best first.
    ///
    /// Occluders are not tested against each other, so some of them may be hidden behind better ones. `choice` keeps
    /// the result and is reused between calls.
    pub fn choose<'a>(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        measure: OccluderMeasure,
        budget: usize,
        choice: &'a mut OccluderSelection,
    ) -> &'a [SelectedOccluder] {
        let mut choosing = self.choosing(geometry, passage, measure, choice);
        while choosing.choice.chosen.len() < budget && choosing.next(|_, _| true).is_some() {}
        &choice.chosen
    }

    /// Begins a selection that yields one occluder at a time.
    pub(crate) fn choosing<'a>(
        &'a self,
        geometry: &'a Geometry,
        passage: &'a Passage,
        measure: OccluderMeasure,
        choice: &'a mut OccluderSelection,
    ) -> SelectionRun<'a> {
        choice.queue.clear();
        choice.entered.clear();
        choice.chosen.clear();
        choice.met = 0;
        let chooser = Chooser::new(self, geometry, passage, measure);
        if let Some(root) = self.tree.root() {
            let bound = chooser.bound(
                &passage.screen_from_sector,
                self.tree.bounds(root),
                self.largest[0],
                chooser.eye,
                1.0,
            );
            choice.push(bound, QueueTarget::Node(root));
        }
        SelectionRun { chooser, choice }
    }

    /// Reference for [`OccluderSet::choose`]: measures every polygon.
    #[cfg(test)]
    pub(super) fn choose_from_all(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        measure: OccluderMeasure,
        budget: usize,
    ) -> Vec<SelectedOccluder> {
        let chooser = Chooser::new(self, geometry, passage, measure);
        let mut corners = Vec::new();
        let mut all = Vec::new();
        for (number, item) in geometry
            .items()
            .iter()
            .enumerate()
            .filter(|(_, item)| item.options.is_occluder)
        {
            let item_id = ItemIndex(number as u32);
            let placed = EnteredItem::of(item_id, geometry, passage);
            let [first, end] = self.meshes[item.mesh.0 as usize].polygons;
            for index in first..end {
                let polygon = &self.polygons[index as usize];
                let value = self
                    .eye_height(polygon, placed.eye, placed.back)
                    .filter(|_| item.transform().inverse().is_some())
                    .and_then(|_| chooser.value(&placed, polygon, &mut corners));
                all.extend(value.map(|value| SelectedOccluder {
                    item: item_id,
                    polygon: index - first,
                    value,
                    index,
                }));
            }
        }
        all.sort_by(|a, b| {
            b.value
                .total_cmp(&a.value)
                .then((a.item, a.index).cmp(&(b.item, b.index)))
        });
        all.truncate(budget);
        all
    }

    /// Returns the corners of a selected occluder, in the space of the sector.
    #[cfg(feature = "steps")]
    pub(crate) fn in_sector(&self, geometry: &Geometry, chosen: &SelectedOccluder) -> Vec<[f32; 3]> {
        let sector_from_item = geometry.item(chosen.item).transform();
        let corners = self.corners_of(self.polygon(chosen)).iter();
        corners
            .map(|corner| sector_from_item.point(corner.as_vec3().into()))
            .collect()
    }

    /// Returns the polygon of a selected occluder.
    pub(super) fn polygon(&self, chosen: &SelectedOccluder) -> &Polygon {
        &self.polygons[chosen.index as usize]
    }
}

/// A selection in progress.
pub(crate) struct SelectionRun<'a> {
    chooser: Chooser<'a>,
    choice: &'a mut OccluderSelection,
}

impl SelectionRun<'_> {
    /// Returns the best remaining occluder. Skips everything inside a box, given in another space, for which
    /// `may_be_seen` returns `false`: whatever hides the whole box also hides everything that an occluder in it would
    /// hide.
    pub(crate) fn next(
        &mut self,
        mut may_be_seen: impl FnMut(&ScreenMap, &Aabb) -> bool,
    ) -> Option<SelectedOccluder> {
        let SelectionRun { chooser, choice } = self;
        let Chooser {
            set,
            geometry,
            passage,
            ..
        } = *chooser;
        while let Some(Ranked(bound, target)) = choice.queue.pop() {
            match target {
                QueueTarget::Node(node) => {
                    if may_be_seen(&passage.screen_from_sector, set.tree.bounds(node)) {
                        chooser.enter_node(node, choice);
                    }
                }
                QueueTarget::Item(item) => {
                    if may_be_seen(
                        &passage.screen_from_sector,
                        &geometry.item(ItemIndex(item)).bounds,
                    ) {
                        chooser.enter_item(ItemIndex(item), choice);
                    }
                }
                QueueTarget::MeshNode { entered, node } => {
                    let EnteredItem {
                        item,
                        screen_from_item,
                        ..
                    } = &choice.entered[entered as usize];
                    let bounds = set.meshes[geometry.item(*item).mesh.0 as usize].tree.bounds(node);
                    if !chooser.bounds_ignore_frustum() || may_be_seen(screen_from_item, bounds) {
                        chooser.enter_mesh_node(entered, node, choice);
                    }
                }
                QueueTarget::Polygon { entered, index } => {
                    let screen_from_item = &choice.entered[entered as usize].screen_from_item;
                    let bounds = &set.polygons[index as usize].bounds;
                    if !chooser.bounds_ignore_frustum() || may_be_seen(screen_from_item, bounds) {
                        chooser.measure(entered, index, choice);
                    }
                }
                QueueTarget::Measured { item, index } => {
                    let item = ItemIndex(item);
                    let screen_from_item = passage.screen_from(&geometry.item(item).transform());
                    if !may_be_seen(&screen_from_item, &set.polygons[index as usize].bounds) {
                        continue;
                    }
                    let first = set.meshes[geometry.item(item).mesh.0 as usize].polygons[0];
                    let chosen = SelectedOccluder {
                        item,
                        polygon: index - first,
                        value: bound,
                        index,
                    };
                    choice.chosen.push(chosen);
                    return Some(chosen);
                }
            }
        }
        None
    }
}

impl OccluderSelection {
    /// Counts a tested box or polygon and queues it, unless its bound is `None`.
    fn push(&mut self, bound: Option<f64>, target: QueueTarget) {
        self.met += 1;
        if let Some(bound) = bound {
            self.queue.push(Ranked(bound, target));
        }
    }
}

impl Chooser<'_> {
    /// Queues the children and items of a node.
    fn enter_node(&self, node: u32, choice: &mut OccluderSelection) {
        let (set, screen) = (self.set, &self.passage.screen_from_sector);
        for child in set.tree.children(node) {
            let bound = self.bound(
                screen,
                set.tree.bounds(child),
                set.largest[child as usize],
                self.eye,
                1.0,
            );
            choice.push(bound, QueueTarget::Node(child));
        }
        for &item in set.tree.things(node) {
            let placed = self.geometry.item(ItemIndex(item));
            if !self.passage.takes(placed) {
                continue;
            }
            let area = set.areas[item as usize];
            let bound = self.bound(screen, &placed.bounds, area, self.eye, 1.0);
            choice.push(bound, QueueTarget::Item(item));
        }
    }

    /// Queues the contents of an item.
    fn enter_item(&self, item: ItemIndex, choice: &mut OccluderSelection) {
        choice
            .entered
            .push(EnteredItem::of(item, self.geometry, self.passage));
        self.enter_mesh_node(choice.entered.len() as u32 - 1, 0, choice);
    }

    /// Queues the children and polygons of a node over a mesh's polygons.
    fn enter_mesh_node(&self, entered: u32, node: u32, choice: &mut OccluderSelection) {
        let placed = choice.entered[entered as usize];
        let mesh = &self.set.meshes[self.geometry.item(placed.item).mesh.0 as usize];
        let bound = |bounds: &Aabb, area: f64| {
            self.bound(
                &placed.screen_from_item,
                bounds,
                area * placed.stretch,
                placed.eye,
                placed.shrink,
            )
        };
        for child in mesh.tree.children(node) {
            let bound = bound(mesh.tree.bounds(child), mesh.largest[child as usize]);
            choice.push(bound, QueueTarget::MeshNode { entered, node: child });
        }
        for &polygon in mesh.tree.things(node) {
            let index = mesh.polygons[0] + polygon;
            let polygon = &self.set.polygons[index as usize];
            if self.set.eye_height(polygon, placed.eye, placed.back).is_some() {
                let bound = bound(&polygon.bounds, polygon.area);
                choice.push(bound, QueueTarget::Polygon { entered, index });
            }
        }
    }

    /// Measures a polygon and queues it by its value.
    fn measure(&self, entered: u32, index: u32, choice: &mut OccluderSelection) {
        let placed = &choice.entered[entered as usize];
        let item = placed.item.0;
        let value = self.value(placed, &self.set.polygons[index as usize], &mut choice.corners);
        choice.push(value, QueueTarget::Measured { item, index });
    }
}
