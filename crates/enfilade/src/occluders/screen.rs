//! Projects an occluder to the screen: its corners and plane in the space of (X, Y, W).
//!
//! The eye is at the origin, and no coordinate is divided by W. From some eye positions an outline of f32 corners may
//! turn inwards by a rounding error; it is then clipped to the region inside all of its edges, because covers may rely
//! on convex polygons.
//! Source: clipping as in Sutherland, Hodgman, Reentrant Polygon Clipping, CACM 1974.
//! Cost: O(corners) for most, O(corners²) for one that turns inwards.
//! See the header of [`super`] for the proof that everything it hides is hidden.

use super::outline::EXACT;
use super::{OccluderSet, Polygon, SelectedOccluder};
use crate::geom::Aabb;
use crate::geometry::Geometry;
use crate::view::passage::{BEYOND, Passage};
use crate::view::screen_map::ScreenMap;
use glam::DVec3;

/// A selected occluder projected to the screen: a convex polygon in (X, Y, W), with the eye at the origin.
///
/// It hides the points inside the pyramid from the eye over the polygon (on the inner side of the planes through the
/// eye and each edge) that are strictly behind its plane. The polygon is already clipped by the near plane and by the
/// entry plane of the last portal.
#[derive(Clone, Copy, Debug)]
pub struct Occluder<'a> {
    /// At least three, counter-clockwise from the eye: a point q is on the inner side of an edge if `to × from · q` is
    /// positive.
    pub(crate) corners: &'a [DVec3],
    /// Unit normal n and distance d > 0: points with n · p > d are behind the occluder.
    pub(crate) plane: (DVec3, f64),
}

impl Occluder<'_> {
    /// Returns the corners, at least three, each as (X, Y, W): the pixel is (X / W, Y / W), with y pointing down, and W
    /// is the distance along the view direction in scene units.
    ///
    /// They are counter-clockwise from the eye.
    pub fn corners(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.corners.iter().map(DVec3::to_array)
    }

    /// Returns the plane as a unit normal n and a distance d > 0: points with n · (X, Y, W) > d are behind the
    /// occluder.
    pub fn plane(&self) -> ([f64; 3], f64) {
        (self.plane.0.to_array(), self.plane.1)
    }
}

/// Buffers for projecting an occluder with [`OccluderSet::on_screen`]; reuse them to avoid allocations.
#[derive(Debug, Default)]
pub struct OccluderRoom {
    corners: Vec<DVec3>,
    /// The unclipped corners.
    whole: Vec<DVec3>,
}

impl OccluderSet {
    /// Projects a selected occluder to the screen of `passage`; `None` if it hides nothing from there.
    ///
    /// The result borrows its corners from `room`.
    pub fn on_screen<'a>(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        chosen: &SelectedOccluder,
        room: &'a mut OccluderRoom,
    ) -> Option<Occluder<'a>> {
        let OccluderRoom { corners, whole } = room;
        let polygon = self.polygon(chosen);
        let item = geometry.item(chosen.item).transform();
        let screen_from_item = passage.screen_from(&item);
        let seen = self.eye_height(polygon, screen_from_item.eye(), screen_from_item.parallel_back())?;
        let plane = seen.plane(polygon, &screen_from_item)?;
        corners.clear();
        corners.extend(
            self.corners_of(polygon)
                .iter()
                .map(|&corner| screen_from_item.point(corner)),
        );
        // Viewed from the eye, their area vector is clockwise if it points away from the eye.
        let first = corners[0];
        let sum: DVec3 = corners
            .windows(2)
            .map(|pair| (pair[0] - first).cross(pair[1] - first))
            .sum();
        if sum.dot(first) > 0.0 {
            corners.reverse();
        }
        make_convex(corners, whole);
        // By the rounding of corners, a ray may hit the faces nearer than it hits the polygon.
        let nearer = 1.0 / (1.0 - 3.0 * seen.slack / seen.height.abs());
        clip(corners, DVec3::Z, f64::from(passage.z_near) * nearer);
        if let Some((normal, distance)) = passage.entry {
            clip(corners, normal, distance * BEYOND * nearer);
        }
        (corners.len() >= 3).then_some(Occluder { corners, plane })
    }

    /// Returns the height of an eye, in the object space of the mesh, over a polygon; `None` if the polygon hides
    /// nothing from there. `back`: direction towards the viewer of a parallel view.
    pub(super) fn eye_height(&self, polygon: &Polygon, eye: DVec3, back: Option<DVec3>) -> Option<EyeHeight> {
        if let Some(back) = back {
            return EyeHeight::parallel(polygon, back);
        }
        let height = polygon.normal.dot(eye) - polygon.distance;
        // Plus the rounding of the eye position, which comes from an inverted transform.
        let slack = polygon.slack + 16.0 * EXACT * eye.abs().max_element().max(polygon.distance.abs());
        if height.abs() <= 4.0 * slack || (height < 0.0 && !polygon.double_sided) {
            return None;
        }
        if polygon.inset > 0.0 {
            // From this eye, the projection must not displace any corner of the outline by more than the inset.
            let reach = self
                .corners_of(polygon)
                .iter()
                .map(|corner| corner.distance(eye))
                .fold(0.0, f64::max);
            if reach * slack >= polygon.inset * (height.abs() - 2.0 * slack) {
                return None;
            }
        }
        Some(EyeHeight { height, slack })
    }
}

/// Height of an eye over a polygon's plane, and the slack of the plane.
#[derive(Clone, Copy)]
pub(super) struct EyeHeight {
    /// Height over the plane; negative behind it.
    height: f64,
    /// Distance by which the plane is pushed back.
    slack: f64,
}

impl EyeHeight {
    /// Returns the height in a parallel view, in a unit in which the slack is the part by which 1 / W falls, at least, when the
    /// plane is pushed back: reversed depth is at least 0.5 where anything is visible.
    fn parallel(polygon: &Polygon, back: DVec3) -> Option<EyeHeight> {
        let height = 0.5 * polygon.normal.dot(back);
        let Aabb { min, max } = polygon.bounds;
        let reach = min
            .iter()
            .chain(&max)
            .fold(0.0_f32, |reach, at| reach.max(at.abs()));
        let slack = polygon.slack + 16.0 * EXACT * f64::from(reach);
        let shift = slack * back.length();
        let is_facing = height > 0.0 || polygon.double_sided;
        // An outline seen at a slant moves by the slack, times the tangent.
        let is_kept = polygon.inset == 0.0 || shift < polygon.inset * (2.0 * height.abs());
        (is_facing && is_kept && height.abs() > 4.0 * slack).then_some(EyeHeight { height, slack })
    }

    /// Returns the plane, pushed back, in the space of (X, Y, W).
    fn plane(&self, polygon: &Polygon, screen_from_item: &ScreenMap) -> Option<(DVec3, f64)> {
        // Normals are transformed by the inverse transpose; the eye is at the origin.
        let away = -polygon.normal * self.height.signum();
        let (normal, distance) = if screen_from_item.is_parallel {
            screen_from_item.half_space(away, self.slack - polygon.distance * self.height.signum())
        } else {
            let normal = screen_from_item.linear.matrix3.inverse().transpose() * away;
            (normal, self.height.abs() + self.slack)
        };
        let length = normal.length();
        let distance = distance / length;
        ((normal / length).is_finite() && distance.is_finite() && distance > 0.0)
            .then_some((normal / length, distance))
    }
}

/// Relative rounding error of a corner in f64.
const ROUNDING: f64 = EXACT / 16.0;

/// Returns `true` if the outline turns inwards at a corner by more than `rounding` of the corners can explain.
fn turns_inwards(corners: &[DVec3], place: usize, rounding: f64) -> bool {
    let [a, b, c] = around(corners, place);
    let (to, on) = (b - a, c - b);
    to.cross(on).dot(b) > rounding * b.length_squared() * (to.length() + on.length())
}

/// Returns a corner between its neighbours: previous, this, next.
fn around(corners: &[DVec3], place: usize) -> [DVec3; 3] {
    let count = corners.len();
    [place + count - 1, place, place + 1].map(|place| corners[place % count])
}

/// Clips a polygon, counter-clockwise from the origin, until it is convex from there. Clears it if that fails.
fn make_convex(corners: &mut Vec<DVec3>, whole: &mut Vec<DVec3>) {
    let turns =
        |corners: &[DVec3], rounding| (0..corners.len()).any(|place| turns_inwards(corners, place, rounding));
    if !turns(corners, ROUNDING) {
        return;
    }
    whole.clear();
    whole.extend_from_slice(corners);
    for place in (0..whole.len()).filter(|&place| turns_inwards(whole, place, ROUNDING)) {
        let [a, b, c] = around(whole, place);
        // Keep the region inside both edges at that corner.
        for (from, to) in [(a, b), (b, c)] {
            clip(corners, to.cross(from), 0.0);
        }
    }
    let near = |a: DVec3, b: DVec3| a.distance(b) <= EXACT * b.length();
    corners.dedup_by(|a, b| near(*a, *b));
    if corners.len() > 1 && near(corners[0], corners[corners.len() - 1]) {
        corners.pop();
    }
    if corners.len() < 3 || turns(corners, 16.0 * ROUNDING) {
        corners.clear();
    }
}

/// Clips a polygon to normal · p ≥ distance.
pub(super) fn clip(corners: &mut Vec<DVec3>, normal: DVec3, distance: f64) {
    let count = corners.len();
    let Some(&last) = corners.last() else { return };
    let (mut before, mut height_before) = (last, normal.dot(last) - distance);
    // The output is appended behind the corners still to be read, then moved to the front, so no second buffer is
    // needed.
    for place in 0..count {
        let corner = corners[place];
        let height = normal.dot(corner) - distance;
        if (height > 0.0 && height_before < 0.0) || (height < 0.0 && height_before > 0.0) {
            corners.push(before + (corner - before) * (height_before / (height_before - height)));
        }
        if height >= 0.0 {
            corners.push(corner);
        }
        (before, height_before) = (corner, height);
    }
    corners.drain(..count);
}
