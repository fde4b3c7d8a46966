//! An occluder as the eye sees it: corners and plane in the space of the screen.
//!
//! Corners are (X, Y, W), the eye at the origin, never divided. Seen from one eye or another an outline of f32 corners
//! may turn inwards by a rounding; then what all its edges hold is cut out, for covers may rely on convex corners.
//! Source: clipping as in Sutherland, Hodgman, Reentrant Polygon Clipping, CACM 1974.
//! Cost: O(corners) for most, O(corners²) for one that turns inwards.
//! See the header of [`super`] for why what it hides is hidden.

use super::outline::EXACT;
use super::{OccluderSet, Polygon, SelectedOccluder};
use crate::geometry::Geometry;
use crate::passage::{BEYOND, Passage, eye_in};
use glam::{DAffine3, DVec3};

/// A convex polygon that hides, as the eye sees it: in (X, Y, W), the eye at the origin.
///
/// Hidden is what lies inside the pyramid from the eye over the polygon (on the inner side of the planes through the eye
/// and each edge), strictly behind its plane. Of faces that come nearer than the near distance or before the last
/// portal it is what is left beyond.
#[derive(Clone, Copy, Debug)]
pub struct Occluder<'a> {
    /// At least three, counter-clockwise as the eye sees them: a point q is on the inner side of an edge where
    /// `to × from · q` is above zero.
    pub(crate) corners: &'a [DVec3],
    /// Unit normal n and distance d > 0: points with n · p > d are behind it.
    pub(crate) plane: (DVec3, f64),
}

impl Occluder<'_> {
    /// At least three, each (X, Y, W): the pixel is (X / W, Y / W), W the distance along the line of sight. They run
    /// counter-clockwise as the eye sees them.
    pub fn corners(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.corners.iter().map(DVec3::to_array)
    }

    /// Unit normal n and distance d > 0: points with n · (X, Y, W) > d are behind it.
    pub fn plane(&self) -> ([f64; 3], f64) {
        (self.plane.0.to_array(), self.plane.1)
    }
}

/// Room for an occluder's corners on the screen, used again and again.
#[derive(Debug, Default)]
pub struct OccluderRoom {
    corners: Vec<DVec3>,
    /// To cut from.
    whole: Vec<DVec3>,
}

impl OccluderSet {
    /// What `passage` sees of a chosen occluder, made in `room`. `None` where it hides nothing from there.
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
        let seen = self.seen_from(polygon, eye_in(&screen_from_item))?;
        let plane = seen.plane(polygon, &screen_from_item)?;
        corners.clear();
        corners.extend(
            self.corners_of(polygon)
                .iter()
                .map(|&corner| screen_from_item.transform_point3(corner)),
        );
        // Their sum, seen from the eye, turns clockwise where it points away from the eye.
        let first = corners[0];
        let sum: DVec3 = corners
            .windows(2)
            .map(|pair| (pair[0] - first).cross(pair[1] - first))
            .sum();
        if sum.dot(first) > 0.0 {
            corners.reverse();
        }
        make_convex(corners, whole);
        // Where a ray meets the faces it may be nearer than where it meets the polygon, by their roundings.
        let nearer = 1.0 / (1.0 - 3.0 * seen.slack / seen.height.abs());
        clip(corners, DVec3::Z, f64::from(passage.near) * nearer);
        if let Some((normal, distance)) = passage.entry {
            clip(corners, normal, distance * BEYOND * nearer);
        }
        (corners.len() >= 3).then_some(Occluder { corners, plane })
    }

    /// How an eye, in the space of the mesh, sees a polygon; `None` where it hides nothing from there.
    pub(super) fn seen_from(&self, polygon: &Polygon, eye: DVec3) -> Option<SeenFrom> {
        let height = polygon.normal.dot(eye) - polygon.distance;
        // The eye's own rounding on top: its place comes through the inverse of a map.
        let slack = polygon.slack + 16.0 * EXACT * eye.abs().max_element().max(polygon.distance.abs());
        if height.abs() <= 4.0 * slack || (height < 0.0 && !polygon.double_sided) {
            return None;
        }
        if polygon.inset > 0.0 {
            // As seen from there, no corner of the outline may be off by more than the inset.
            let reach = self
                .corners_of(polygon)
                .iter()
                .map(|corner| corner.distance(eye))
                .fold(0.0, f64::max);
            if reach * slack >= polygon.inset * (height.abs() - 2.0 * slack) {
                return None;
            }
        }
        Some(SeenFrom { height, slack })
    }
}

/// How an eye sees a polygon.
#[derive(Clone, Copy)]
pub(super) struct SeenFrom {
    /// Over the plane; below zero behind it.
    height: f64,
    /// How far the plane is to be pushed back.
    slack: f64,
}

impl SeenFrom {
    /// The plane, pushed back, on the screen.
    fn plane(&self, polygon: &Polygon, screen_from_item: &DAffine3) -> Option<(DVec3, f64)> {
        // A normal is mapped by the inverse, transposed; the eye is at the origin.
        let away = -polygon.normal * self.height.signum();
        let normal = screen_from_item.matrix3.inverse().transpose() * away;
        let length = normal.length();
        let distance = (self.height.abs() + self.slack) / length;
        ((normal / length).is_finite() && distance.is_finite() && distance > 0.0)
            .then_some((normal / length, distance))
    }
}

/// What f64 rounds of a corner, relatively.
const ROUNDING: f64 = EXACT / 16.0;

/// Does the outline turn inwards at a corner, by more than `rounding` of the corners can explain?
fn turns_inwards(corners: &[DVec3], place: usize, rounding: f64) -> bool {
    let [a, b, c] = around(corners, place);
    let (to, on) = (b - a, c - b);
    to.cross(on).dot(b) > rounding * b.length_squared() * (to.length() + on.length())
}

/// A corner between those before and after it.
fn around(corners: &[DVec3], place: usize) -> [DVec3; 3] {
    let count = corners.len();
    [place + count - 1, place, place + 1].map(|place| corners[place % count])
}

/// Cuts a polygon, counter-clockwise seen from the origin, until it is convex from there.
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
        // What is inside both edges at that corner.
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

/// Keeps the part of a polygon with normal · p ≥ distance.
pub(super) fn clip(corners: &mut Vec<DVec3>, normal: DVec3, distance: f64) {
    let count = corners.len();
    let Some(&last) = corners.last() else { return };
    let (mut before, mut height_before) = (last, normal.dot(last) - distance);
    // What is kept is written behind the corners still to be read, then moved to the front: no second buffer.
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
