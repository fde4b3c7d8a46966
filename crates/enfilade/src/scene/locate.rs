//! Point location: finds the sector that contains a point.
//!
//! Idea: the boxes of all sectors are in an octree, so that only those near the point are tested.
//! Cost: O(log sectors + boxes that contain the point) per query; O(log sectors) per changed box.
//! Exact: the result equals that of testing every box.

use crate::geom::{Aabb, Octree, Step};
use crate::ids::SectorId;
use glam::DVec3;
use std::cmp::Ordering;

/// The bounding boxes of a scene's sectors.
#[derive(Clone)]
pub(super) struct Boxes {
    tree: Octree,
    /// The current box of each sector.
    boxes: Vec<Aabb>,
    /// Sectors with unbounded boxes, which are not in the tree; sorted.
    unbounded: Vec<u32>,
    /// Nodes of the tree that a change touched; scratch memory.
    touched: Vec<u32>,
}

/// Returns the box to insert into the tree: the box itself, or an empty one if it is unbounded.
fn tree_box(held: &Aabb) -> Aabb {
    if held.min.iter().chain(&held.max).all(|value| value.is_finite()) {
        *held
    } else {
        Aabb::EMPTY
    }
}

/// Returns the size of a box as [volume, footprint]; the footprint decides between infinite volumes.
fn size(bounds: &Aabb) -> [f64; 2] {
    let side = |axis: usize| f64::from(bounds.max[axis]) - f64::from(bounds.min[axis]);
    [bounds.volume(), side(0) * side(2)]
}

fn compare(a: [f64; 2], b: [f64; 2]) -> Ordering {
    a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
}

/// Maximum number of boxes in a leaf of the tree.
const MAX_PER_LEAF: usize = 8;

impl Boxes {
    pub(super) fn new(boxes: Vec<Aabb>) -> Boxes {
        let sorted: Vec<Aabb> = boxes.iter().map(tree_box).collect();
        let numbered = (0..).zip(boxes.iter().zip(&sorted));
        let unbounded = numbered.filter(|(_, (held, sorted))| held != sorted);
        Boxes {
            unbounded: unbounded.map(|(number, _)| number).collect(),
            tree: Octree::build(&sorted, MAX_PER_LEAF),
            boxes,
            touched: Vec::new(),
        }
    }

    /// Adds the box of a new sector.
    pub(super) fn push(&mut self, bounds: Aabb) {
        self.boxes.push(Aabb::EMPTY);
        self.change(SectorId(self.boxes.len() as u32 - 1), bounds);
    }

    /// Replaces the box of a sector.
    pub(super) fn change(&mut self, sector: SectorId, bounds: Aabb) {
        let was = std::mem::replace(&mut self.boxes[sector.0 as usize], bounds);
        if was == bounds {
            return;
        }
        let boxes = |number: u32| tree_box(&self.boxes[number as usize]);
        let is_unbounded = boxes(sector.0) != bounds;
        match self.unbounded.binary_search(&sector.0) {
            Ok(place) if !is_unbounded => {
                self.unbounded.remove(place);
            }
            Err(place) if is_unbounded => self.unbounded.insert(place, sector.0),
            _ => {}
        }
        self.touched.clear();
        self.tree
            .shift(sector.0, &tree_box(&was), &boxes, &mut self.touched);
        self.tree.tidy(self.boxes.len(), &boxes);
    }

    /// See [`Scene::locate`](super::Scene::locate); `None` if all boxes are empty.
    pub(super) fn locate(&self, point: [f64; 3], toward: [f64; 3]) -> Option<SectorId> {
        let found = self.around(point, toward).or_else(|| self.nearest(point));
        found.map(SectorId)
    }

    /// Returns the smallest box that contains a point in its interior; otherwise, of those with the point on their
    /// boundary, the one farthest ahead.
    fn around(&self, point: [f64; 3], toward: [f64; 3]) -> Option<u32> {
        let [eye, toward] = [point, toward].map(DVec3::from);
        let ahead = |bounds: &Aabb| -> f64 {
            let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
            let middle = 0.5 * (min + max);
            // An axis along which the box is unbounded has no centre and does not count.
            let to_middle = DVec3::select(middle.is_finite_mask(), middle - eye, DVec3::ZERO);
            to_middle.dot(toward - eye)
        };
        let compare_all = |bounds: &Aabb, is_in: fn(f64, f64) -> bool| {
            let axis = |a: usize| {
                is_in(f64::from(bounds.min[a]), point[a]) && is_in(point[a], f64::from(bounds.max[a]))
            };
            (0..3).all(axis)
        };
        let inside = |bounds: &Aabb| compare_all(bounds, |low, high| low < high);
        let contains = |bounds: &Aabb| compare_all(bounds, |low, high| low <= high);
        let mut smallest: Option<([f64; 2], u32)> = None;
        let mut farthest_ahead: Option<(f64, u32)> = None;
        self.each(point, contains, |number, bounds| {
            if inside(bounds) {
                let this = (size(bounds), number);
                let less =
                    smallest.is_none_or(|best| compare(this.0, best.0).then(number.cmp(&best.1)).is_lt());
                smallest = if less { Some(this) } else { smallest };
            } else if smallest.is_none() {
                let this = (ahead(bounds), number);
                let more = farthest_ahead
                    .is_none_or(|best| this.0.total_cmp(&best.0).then(number.cmp(&best.1)).is_gt());
                farthest_ahead = if more { Some(this) } else { farthest_ahead };
            }
        });
        let smallest = smallest.map(|(_, number)| number);
        smallest.or(farthest_ahead.map(|(_, number)| number))
    }

    /// Returns the box nearest to a point that no box contains.
    fn nearest(&self, point: [f64; 3]) -> Option<u32> {
        // Monotonic in the box even with rounding: no box is nearer than the node that contains it.
        let away = |bounds: &Aabb| -> f64 {
            let off = |a: usize| {
                let [min, max] = [bounds.min[a], bounds.max[a]].map(f64::from);
                (min - point[a]).max(point[a] - max).max(0.0)
            };
            (0..3).map(|a| off(a).powi(2)).sum()
        };
        let nearest = std::cell::Cell::new(None::<(f64, u32)>);
        self.each(
            point,
            |bounds| nearest.get().is_none_or(|(best, _)| away(bounds) <= best),
            |number, bounds| {
                let this = (away(bounds), number);
                let less = |best: (f64, u32)| this.0.total_cmp(&best.0).then(number.cmp(&best.1)).is_lt();
                if nearest.get().is_none_or(less) {
                    nearest.set(Some(this));
                }
            },
        );
        nearest.get().map(|(_, number)| number)
    }

    /// Calls `take` with each box that passes `wanted`. Visits nodes near to far, and skips those that fail `wanted`.
    fn each(&self, point: [f64; 3], wanted: impl Fn(&Aabb) -> bool, mut take: impl FnMut(u32, &Aabb)) {
        let mut offer = |number: u32| {
            let bounds = &self.boxes[number as usize];
            if !bounds.is_empty() && wanted(bounds) {
                take(number, bounds);
            }
        };
        self.unbounded.iter().copied().for_each(&mut offer);
        self.tree.walk(point, |step| match step {
            Step::Node(bounds) => wanted(bounds),
            Step::Thing(number) => {
                offer(number);
                true
            }
        });
    }

    /// Returns the memory used, in bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.tree.bytes() + (size_of_val(&*self.boxes) + size_of_val(&*self.unbounded)) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Dice;

    /// [`Scene::locate`](super::super::Scene::locate) as documented, by brute force over all boxes.
    fn by_brute_force(boxes: &[Aabb], point: [f32; 3], toward: [f32; 3]) -> Option<SectorId> {
        let solid = || (0..).zip(boxes).filter(|(_, held)| !held.is_empty());
        let inside = |held: &Aabb| (0..3).all(|a| held.min[a] < point[a] && point[a] < held.max[a]);
        let ahead = |held: &Aabb| -> f64 {
            let step = |a: usize| f64::from(held.center()[a] - point[a]) * f64::from(toward[a] - point[a]);
            (0..3).filter(|&a| held.center()[a].is_finite()).map(step).sum()
        };
        let away = |held: &Aabb| -> f64 {
            let step = |a: usize| (held.min[a] - point[a]).max(point[a] - held.max[a]).max(0.0);
            (0..3).map(|a| f64::from(step(a)).powi(2)).sum()
        };
        let ground = |held: &Aabb| (held.max[0] - held.min[0]) * (held.max[2] - held.min[2]);
        let smallest = solid().filter(|(_, held)| inside(held)).min_by(|a, b| {
            a.1.volume()
                .total_cmp(&b.1.volume())
                .then(ground(a.1).total_cmp(&ground(b.1)))
        });
        smallest
            .or_else(|| {
                let ends = solid().filter(|(_, held)| held.contains(point));
                ends.max_by(|a, b| ahead(a.1).total_cmp(&ahead(b.1)))
            })
            .or_else(|| solid().min_by(|a, b| away(a.1).total_cmp(&away(b.1))))
            .map(|(number, _)| SectorId(number))
    }

    /// Returns whole numbers, so that boxes touch and coincide.
    fn whole(dice: &mut Dice, below: usize) -> f32 {
        dice.below(below) as f32
    }

    fn random_box(dice: &mut Dice) -> Aabb {
        let min = [0; 3].map(|_| whole(dice, 12));
        let size = [0; 3].map(|_| whole(dice, 4));
        if size == [3.0; 3] {
            return Aabb::EMPTY;
        }
        Aabb {
            min,
            max: [0, 1, 2].map(|a| min[a] + size[a]),
        }
    }

    #[test]
    fn a_point_stands_where_asking_every_box_says_also_after_boxes_have_changed() {
        let mut dice = Dice::new(1);
        for count in [0, 1, 7, 300] {
            let mut now: Vec<Aabb> = (0..count).map(|_| random_box(&mut dice)).collect();
            if count > 7 {
                let open_above = now.iter_mut().step_by(5).filter(|bounds| !bounds.is_empty());
                open_above.for_each(|bounds| bounds.max[1] = f32::INFINITY);
            }
            let mut boxes = Boxes::new(now.clone());
            for round in 0..300 {
                let mut point = [0; 3].map(|_| whole(&mut dice, 40) * 0.5 - 3.0);
                let toward = [0; 3].map(|_| whole(&mut dice, 9) - 4.0);
                if round % 50 == 0 {
                    point[round / 50 % 3] = [f32::NAN, f32::INFINITY][round / 50 % 2];
                }
                let expected = by_brute_force(&now, point, toward);
                assert_eq!(
                    boxes.locate(point.map(f64::from), toward.map(f64::from)),
                    expected,
                    "{count} boxes, {point:?}"
                );
                if round % 10 == 0 && count > 0 {
                    let changed = round / 10 % count;
                    now[changed] = random_box(&mut dice);
                    boxes.change(SectorId(changed as u32), now[changed]);
                }
            }
        }
    }
}
