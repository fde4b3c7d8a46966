//! Which occluders a look takes: the best few of all, by a measure of what they hide.
//!
//! What waits (nodes over the items, items, nodes over their polygons, polygons) stands in one queue by the most that
//! anything in its box can measure; what is measured itself, by that. So polygons come out best first, and what is far,
//! small or out of view is never entered. Who lets each occluder hide before the next is chosen says what is hidden by
//! then: that is not entered either. Else most of the best stand behind others, and the more so the larger the scene.
//! Source: Coorg, Teller, Real-Time Occlusion Culling for Models with Large Occluders, I3D 1997, section 3.3; the queue is
//!     that of Hart, Nilsson, Raphael, A Formal Basis for the Heuristic Determination of Minimum Cost Paths, 1968.
//! Cost: O(boxes met · log waiting), about a few for each occluder chosen; no memory is asked for once warm.
//! Where nothing is called hidden, the answer is that of measuring every polygon of every item, to the last of them.

use super::measure::{Chooser, Entered, OccluderMeasure};
use super::{OccluderSet, Polygon};
use crate::geom::Aabb;
use crate::geometry::{Geometry, ItemId};
use crate::passage::Passage;
use glam::{DAffine3, DVec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// An occluder that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectedOccluder {
    /// The item whose faces it stands for.
    pub item: ItemId,
    /// Which polygon of the item's mesh, counted from 0.
    pub polygon: u32,
    /// By the measure that was asked for; all that waited measured no more.
    pub value: f64,
    /// The place among all polygons of the set.
    place: u32,
}

#[cfg(test)]
impl SelectedOccluder {
    /// A polygon of the first item, which is a copy of the first mesh.
    pub(super) fn for_tests(place: u32) -> SelectedOccluder {
        SelectedOccluder {
            item: ItemId(0),
            polygon: place,
            value: 1.0,
            place,
        }
    }
}

/// What choosing needs, kept from one look to the next, and what was chosen.
#[derive(Debug, Default)]
pub struct OccluderSelection {
    waiting: BinaryHeap<Waiting>,
    entered: Vec<Entered>,
    corners: Vec<DVec3>,
    chosen: Vec<SelectedOccluder>,
    /// How many boxes and polygons were held against the passage.
    met: u64,
}

impl OccluderSelection {
    /// What was chosen last, the best first.
    pub fn chosen(&self) -> &[SelectedOccluder] {
        &self.chosen
    }

    /// How many boxes and polygons were looked at for it.
    pub fn met(&self) -> u64 {
        self.met
    }
}

#[derive(Debug)]
struct Waiting {
    most: f64,
    what: What,
}

/// Of what may measure the same, boxes come first, so that all that measures the same is known when one of it is taken;
/// then lower numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    Node(u32),
    Item(u32),
    /// A node over a mesh's polygons; the item by its place in [`OccluderSelection::entered`].
    MeshNode {
        entered: u32,
        node: u32,
    },
    /// A polygon that was not measured yet.
    Polygon {
        entered: u32,
        place: u32,
    },
    Measured {
        item: u32,
        place: u32,
    },
}

impl Ord for Waiting {
    fn cmp(&self, other: &Waiting) -> Ordering {
        self.most.total_cmp(&other.most).then(other.what.cmp(&self.what))
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

impl OccluderSet {
    /// The best `budget` occluders that `passage` sees, the best first.
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

    /// Begins to choose, one occluder after the other.
    pub(crate) fn choosing<'a>(
        &'a self,
        geometry: &'a Geometry,
        passage: &'a Passage,
        measure: OccluderMeasure,
        choice: &'a mut OccluderSelection,
    ) -> Choosing<'a> {
        choice.waiting.clear();
        choice.entered.clear();
        choice.chosen.clear();
        choice.met = 0;
        let chooser = Chooser::new(self, geometry, passage, measure);
        if let Some(root) = self.tree.root() {
            let most = chooser.most(
                &passage.screen_from_sector,
                self.tree.bounds(root),
                self.largest[0],
                chooser.eye,
                1.0,
            );
            choice.push(most, What::Node(root));
        }
        Choosing { chooser, choice }
    }

    /// What [`OccluderSet::choose`] must answer, by measuring everything.
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
            .filter(|(_, item)| item.is_occluder)
        {
            let item_id = ItemId(number as u32);
            let placed = Entered::of(item_id, geometry, passage);
            let [first, end] = self.meshes[item.mesh.0 as usize].polygons;
            for place in first..end {
                let polygon = &self.polygons[place as usize];
                let value = self
                    .seen_from(polygon, placed.eye)
                    .filter(|_| item.transform().inverse().is_some())
                    .and_then(|_| chooser.value(&placed, polygon, &mut corners));
                all.extend(value.map(|value| SelectedOccluder {
                    item: item_id,
                    polygon: place - first,
                    value,
                    place,
                }));
            }
        }
        all.sort_by(|a, b| {
            b.value
                .total_cmp(&a.value)
                .then((a.item, a.place).cmp(&(b.item, b.place)))
        });
        all.truncate(budget);
        all
    }

    pub(super) fn polygon(&self, chosen: &SelectedOccluder) -> &Polygon {
        &self.polygons[chosen.place as usize]
    }
}

/// A choice at work.
pub(crate) struct Choosing<'a> {
    chooser: Chooser<'a>,
    choice: &'a mut OccluderSelection,
}

impl Choosing<'_> {
    /// The best occluder of those that are left, but for what is in a box, given in another space, that `may_be_seen` says
    /// no of: what hides all of it hides all that it would hide.
    pub(crate) fn next(
        &mut self,
        mut may_be_seen: impl FnMut(&DAffine3, &Aabb) -> bool,
    ) -> Option<SelectedOccluder> {
        let Choosing { chooser, choice } = self;
        let Chooser {
            set,
            geometry,
            passage,
            ..
        } = *chooser;
        while let Some(Waiting { most, what }) = choice.waiting.pop() {
            match what {
                What::Node(node) => {
                    if may_be_seen(&passage.screen_from_sector, set.tree.bounds(node)) {
                        chooser.enter_node(node, choice);
                    }
                }
                What::Item(item) => {
                    if may_be_seen(&passage.screen_from_sector, &geometry.item(ItemId(item)).bounds) {
                        chooser.enter_item(ItemId(item), choice);
                    }
                }
                What::MeshNode { entered, node } => {
                    let Entered {
                        item,
                        screen_from_item,
                        ..
                    } = &choice.entered[entered as usize];
                    let bounds = set.meshes[geometry.item(*item).mesh.0 as usize].tree.bounds(node);
                    if !chooser.bounds_ignore_the_frame() || may_be_seen(screen_from_item, bounds) {
                        chooser.enter_mesh_node(entered, node, choice);
                    }
                }
                What::Polygon { entered, place } => {
                    let screen_from_item = &choice.entered[entered as usize].screen_from_item;
                    let bounds = &set.polygons[place as usize].bounds;
                    if !chooser.bounds_ignore_the_frame() || may_be_seen(screen_from_item, bounds) {
                        chooser.measure(entered, place, choice);
                    }
                }
                What::Measured { item, place } => {
                    let item = ItemId(item);
                    let screen_from_item = passage.screen_from(&geometry.item(item).transform());
                    if !may_be_seen(&screen_from_item, &set.polygons[place as usize].bounds) {
                        continue;
                    }
                    let first = set.meshes[geometry.item(item).mesh.0 as usize].polygons[0];
                    let chosen = SelectedOccluder {
                        item,
                        polygon: place - first,
                        value: most,
                        place,
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
    fn push(&mut self, most: Option<f64>, what: What) {
        self.met += 1;
        if let Some(most) = most {
            self.waiting.push(Waiting { most, what });
        }
    }
}

impl Chooser<'_> {
    fn enter_node(&self, node: u32, choice: &mut OccluderSelection) {
        let (set, screen) = (self.set, &self.passage.screen_from_sector);
        for child in set.tree.children(node) {
            let most = self.most(
                screen,
                set.tree.bounds(child),
                set.largest[child as usize],
                self.eye,
                1.0,
            );
            choice.push(most, What::Node(child));
        }
        for &item in set.tree.things(node) {
            let placed = self.geometry.item(ItemId(item));
            let area = set.areas[item as usize];
            let most = self.most(screen, &placed.bounds, area, self.eye, 1.0);
            choice.push(most, What::Item(item));
        }
    }

    fn enter_item(&self, item: ItemId, choice: &mut OccluderSelection) {
        choice
            .entered
            .push(Entered::of(item, self.geometry, self.passage));
        self.enter_mesh_node(choice.entered.len() as u32 - 1, 0, choice);
    }

    fn enter_mesh_node(&self, entered: u32, node: u32, choice: &mut OccluderSelection) {
        let placed = choice.entered[entered as usize];
        let mesh = &self.set.meshes[self.geometry.item(placed.item).mesh.0 as usize];
        let most = |bounds: &Aabb, area: f64| {
            self.most(
                &placed.screen_from_item,
                bounds,
                area * placed.stretch,
                placed.eye,
                placed.shrink,
            )
        };
        for child in mesh.tree.children(node) {
            let most = most(mesh.tree.bounds(child), mesh.largest[child as usize]);
            choice.push(most, What::MeshNode { entered, node: child });
        }
        for &polygon in mesh.tree.things(node) {
            let place = mesh.polygons[0] + polygon;
            let polygon = &self.set.polygons[place as usize];
            if self.set.seen_from(polygon, placed.eye).is_some() {
                let most = most(&polygon.bounds, polygon.area);
                choice.push(most, What::Polygon { entered, place });
            }
        }
    }

    fn measure(&self, entered: u32, place: u32, choice: &mut OccluderSelection) {
        let placed = &choice.entered[entered as usize];
        let item = placed.item.0;
        let value = self.value(placed, &self.set.polygons[place as usize], &mut choice.corners);
        choice.push(value, What::Measured { item, place });
    }
}
