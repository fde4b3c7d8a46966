//! Items in a box, in a sphere, in a frustum.
//!
//! The tree over the items is walked: what is outside is skipped with all below it, what is inside is taken unasked.
//! Source: Greene, Detecting Intersection of a Rectangular Solid and a Convex Polyhedron, Graphics Gems IV, 1994, for a
//!     box between planes.
//! Cost: O(log items + items found) boxes; nothing is allocated.
//! Told by boxes: an item is found where its box meets what is asked about, though none of its faces may.

use crate::geom::{Aabb, Enter, Step};
use crate::geometry::{Geometry, ItemId};
use crate::passage::Passage;
use crate::scene::SectorId;
use crate::view::View;
use glam::{DVec3, DVec4};

impl Geometry {
    /// Visits the items whose boxes meet a box, each once, in no order. Boxes that only touch do meet; a box that is empty
    /// or holds NaN meets nothing.
    pub fn items_in_box(&self, bounds: &Aabb, visit: impl FnMut(ItemId)) {
        if bounds.is_empty() {
            return;
        }
        let meets = |held: &Aabb| {
            if !held.meets(bounds) {
                Enter::Skip
            } else if bounds.contains(held.min) && bounds.contains(held.max) {
                Enter::All
            } else {
                Enter::Ask
            }
        };
        let item = |item: ItemId| self.item(item).bounds.meets(bounds);
        self.items_by(bounds.center().map(f64::from), meets, item, visit);
    }

    /// Visits the items whose boxes are no farther from `center` than `radius`, in scene units, each once, in no order. None
    /// are within a radius that is negative or NaN, or of a centre that is not finite.
    pub fn items_in_sphere(&self, center: [f32; 3], radius: f32, visit: impl FnMut(ItemId)) {
        self.items_within(DVec3::from(center.map(f64::from)), f64::from(radius), visit);
    }

    /// As [`Geometry::items_in_sphere`], in f64.
    pub(super) fn items_within(&self, center: DVec3, radius: f64, visit: impl FnMut(ItemId)) {
        if !(center.is_finite() && radius >= 0.0) {
            return;
        }
        let square = radius * radius;
        let meets = |held: &Aabb| {
            if nearest_squared(held, center) > square {
                Enter::Skip
            } else if farthest_squared(held, center) <= square {
                Enter::All
            } else {
                Enter::Ask
            }
        };
        let item = |item: ItemId| nearest_squared(&self.item(item).bounds, center) <= square;
        self.items_by(center.into(), meets, item, visit);
    }

    /// Visits the items that may be in the frustum of a view from within this geometry: before the eye, no nearer than
    /// [`View::near`], and between the four sides of the screen. Each once, in no order.
    ///
    /// It may find one too many, near a corner of the frustum, and never one too few: an item is left out where its box, or
    /// that of its mesh at its place, lies wholly behind one plane. [`VisibleSet::in_frustum`](crate::VisibleSet::in_frustum)
    /// counts by the same rule. A view that sees nothing ([`View::check`]) finds nothing; which sector it names is not
    /// asked.
    pub fn items_in_frustum(&self, view: &View, visit: impl FnMut(ItemId)) {
        if view.check().is_ok() {
            self.items_in_passage(&Passage::at_the_eye(view, SectorId(0), false), visit);
        }
    }

    /// The items that may be in the frustum of a passage's view, and beyond its last portal.
    pub(crate) fn items_in_passage(&self, passage: &Passage, visit: impl FnMut(ItemId)) {
        let planes = planes_of(passage);
        let meets = |held: &Aabb| match side_of(&planes, held) {
            Enter::All if passage.entry.is_some() => Enter::Ask,
            side => side,
        };
        let item = |item: ItemId| {
            let placed = self.item(item);
            let screen_from_item = passage.screen_from(&placed.transform());
            passage.frustum_meets(&passage.screen_from_sector, &placed.bounds)
                && passage.frustum_meets(&screen_from_item, &self.mesh_of(item).bounds())
        };
        self.items_by(passage.eye(), meets, item, visit);
    }

    /// The items that are in, of nodes that are.
    fn items_by(
        &self,
        near: [f64; 3],
        node: impl Fn(&Aabb) -> Enter,
        is_in: impl Fn(ItemId) -> bool,
        mut visit: impl FnMut(ItemId),
    ) {
        self.item_tree().walk_by(near, |step, all| match step {
            Step::Node(bounds) => node(bounds),
            Step::Thing(item) => {
                if all || is_in(ItemId(item)) {
                    visit(ItemId(item));
                }
                Enter::Skip
            }
        });
    }
}

/// The square of the distance from a point to a box. A box within another is never nearer, to the last bit.
pub(super) fn nearest_squared(bounds: &Aabb, point: DVec3) -> f64 {
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    (min - point).max(point - max).max(DVec3::ZERO).length_squared()
}

/// The square of the distance from a point to a box's farthest corner.
fn farthest_squared(bounds: &Aabb, point: DVec3) -> f64 {
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    (min - point).abs().max((max - point).abs()).length_squared()
}

/// The planes of the frustum in the space of the sector: it holds points with n · x + d ≥ 0 for all.
fn planes_of(passage: &Passage) -> [DVec4; 5] {
    let map = &passage.screen_from_sector;
    let row = |axis: usize| map.matrix3.row(axis).extend(map.translation[axis]);
    let [x, y, w] = [0, 1, 2].map(row);
    let [width, height] = passage.size.map(f64::from);
    let near = DVec4::new(0.0, 0.0, 0.0, f64::from(passage.near));
    [x, w * width - x, y, w * height - y, w - near]
}

/// Is a box outside, or inside, by more than what rounding may change? Else it is asked what is in it.
fn side_of(planes: &[DVec4; 5], bounds: &Aabb) -> Enter {
    const SLACK: f64 = 1e-9;
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    let [middle, half] = [0.5 * (min + max), 0.5 * (max - min)];
    let mut side = Enter::All;
    for plane in planes {
        let normal = plane.truncate();
        let [at, reach] = [normal.dot(middle) + plane.w, normal.abs().dot(half)];
        let slack = SLACK * (normal.abs().dot(middle.abs() + half) + plane.w.abs());
        if at + reach < -slack {
            return Enter::Skip;
        }
        if at - reach < slack {
            side = Enter::Ask;
        }
    }
    side
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_and_the_farthest_of_a_box_are_sides_and_corners() {
        let unit = Aabb {
            min: [0.0; 3],
            max: [1.0; 3],
        };
        assert_eq!(nearest_squared(&unit, DVec3::new(0.5, -2.0, 0.2)), 4.0);
        assert_eq!(nearest_squared(&unit, DVec3::splat(0.5)), 0.0);
        assert_eq!(farthest_squared(&unit, DVec3::new(-1.0, 0.0, 1.0)), 6.0);
    }
}
