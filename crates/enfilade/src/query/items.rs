//! Items in an AABB, in a sphere or in a frustum.
//!
//! Idea: traverses the item tree. Nodes that are outside are skipped, and the contents of nodes that are inside are
//!     accepted untested.
//! Source: Greene, Detecting Intersection of a Rectangular Solid and a Convex Polyhedron, Graphics Gems IV, 1994, for a
//!     box between planes.
//! Cost: O(log items + items found) box tests; no allocation.
//! Conservative with respect to faces: an item is found if its bounding box intersects the query, even if none of its
//! faces does.

use crate::geom::{Aabb, Enter};
use crate::geometry::Geometry;
use crate::ids::{ItemIndex, SectorId};
use crate::view::View;
use crate::view::passage::Passage;
use glam::{DVec3, DVec4};

impl Geometry {
    /// Visits the items whose bounding boxes intersect a box, each once, in no order. Boxes that only touch do
    /// intersect; an empty box, or one with NaN, intersects nothing.
    #[doc(alias = "range query")]
    #[doc(alias = "box query")]
    pub fn items_in_box(&self, bounds: &Aabb, visit: impl FnMut(ItemIndex)) {
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
        let item = |item: ItemIndex| self.item(item).bounds.meets(bounds);
        self.items_by(meets, item, visit);
    }

    /// Visits the items whose bounding boxes are at most `radius` from `center`, in scene units, each once, in no
    /// order. Visits none if the radius is negative or NaN or the centre is not finite.
    #[doc(alias = "range query")]
    #[doc(alias = "sphere query")]
    pub fn items_in_sphere(&self, center: [f32; 3], radius: f32, visit: impl FnMut(ItemIndex)) {
        self.items_within(DVec3::from(center.map(f64::from)), f64::from(radius), visit);
    }

    /// Visits items as [`Geometry::items_in_sphere`] does, in f64.
    pub(super) fn items_within(&self, center: DVec3, radius: f64, visit: impl FnMut(ItemIndex)) {
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
        let item = |item: ItemIndex| nearest_squared(&self.item(item).bounds, center) <= square;
        self.items_by(meets, item, visit);
    }

    /// Visits the items that are potentially in the frustum of a view inside this geometry: beyond [`View::z_near`] and
    /// between the four side planes of the viewport. Each once, in no order.
    ///
    /// Conservative: may visit an item near a corner of the frustum, but never misses one. An item is culled if its
    /// bounding box, or the transformed box of its mesh, is fully behind one plane.
    /// [`VisibleSet::in_frustum`](crate::VisibleSet::in_frustum) counts by the same rule. Ignores
    /// [`View::sector`].
    #[doc(alias = "frustum culling")]
    pub fn items_in_frustum(&self, view: &View, visit: impl FnMut(ItemIndex)) {
        let mut passage = Passage::at_the_eye(view, SectorId(0), false);
        passage.fit(&self.bounds());
        self.items_in_passage(&passage, visit);
    }

    /// Visits the items that are potentially in the frustum of a passage's view and beyond its last portal.
    pub(crate) fn items_in_passage(&self, passage: &Passage, visit: impl FnMut(ItemIndex)) {
        let planes = planes_of(passage);
        let meets = |held: &Aabb| match side_of(&planes, held) {
            Enter::All if passage.entry.is_some() => Enter::Ask,
            side => side,
        };
        let item = |item: ItemIndex| {
            let placed = self.item(item);
            let screen_from_item = passage.screen_from(&placed.transform());
            passage.frustum_meets(&passage.screen_from_sector, &placed.bounds)
                && passage.frustum_meets(&screen_from_item, &self.mesh_of(item).bounds())
        };
        self.items_by(meets, item, visit);
    }

    /// Visits the items that pass `is_in`, in nodes that pass `node`.
    fn items_by(
        &self,
        node: impl Fn(&Aabb) -> Enter,
        is_in: impl Fn(ItemIndex) -> bool,
        mut visit: impl FnMut(ItemIndex),
    ) {
        self.item_tree().search(node, |item, all| {
            let item = ItemIndex(item);
            if all || is_in(item) {
                visit(item);
            }
        });
    }
}

/// Returns the squared distance from a point to a box. Monotonic also when rounded: a box inside another is never
/// nearer.
pub(super) fn nearest_squared(bounds: &Aabb, point: DVec3) -> f64 {
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    (min - point).max(point - max).max(DVec3::ZERO).length_squared()
}

/// Returns the squared distance from a point to the farthest corner of a box.
fn farthest_squared(bounds: &Aabb, point: DVec3) -> f64 {
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    (min - point).abs().max((max - point).abs()).length_squared()
}

/// Returns the planes of the frustum in the space of the sector: points inside have n · x + d ≥ 0 for all.
fn planes_of(passage: &Passage) -> [DVec4; 5] {
    let map = &passage.screen_from_sector;
    let row = |axis: usize| map.linear.matrix3.row(axis).extend(map.linear.translation[axis]);
    let [x, y, w] = [0, 1, 2].map(row);
    let [width, height] = passage.size.map(f64::from);
    let near = DVec4::new(0.0, 0.0, 0.0, f64::from(passage.z_near));
    if map.is_parallel {
        return [x, DVec4::W * width - x, y, DVec4::W * height - y, DVec4::W - w];
    }
    [x, w * width - x, y, w * height - y, w - near]
}

/// Classifies a box as outside or inside if it is so by more than rounding errors; otherwise its contents must be
/// tested.
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
