//! The silhouette of a sheet: its boundary edges projected to its plane, and whether they form one convex polygon.
//!
//! Why an outline of mesh edges hides only what the faces hide, from every eye position, although the corners are off
//! the plane by their rounding: take an eye in front of the plane by more than the slack, and a point behind it by more
//! than the slack that is on the inner side of every plane through the eye and an edge. Seen from the eye, the outline
//! turns around the point at every edge, so its winding number around the point is one or more. The outline is the sum
//! of the outlines of the faces, so one of the faces winds around the point in the positive direction: a front face
//! that is in front of the point. The outline need not be convex for this: where it turns inwards by a rounding error,
//! less is hidden.
//! One edge may replace two only where they are outside it from every eye position: if they are exactly collinear, or,
//! if all corners are exactly coplanar, where they bulge outwards.
//! Source: winding numbers; the kernel of a polygon (Lee, Preparata, J. ACM 1979) is the region inside all edges.
//! Cost: O(n log n) for n edges.
//! *Exactly* means up to the rounding of f64, as in all screen-space computations.

use super::sheets::Sheet;
use super::soup::Soup;
use glam::{DVec2, DVec3};

/// Maximum number of corners of an occluder: each is a plane of an occlusion tree, and rounder polygons hide little
/// more.
pub(super) const MAX_CORNERS: usize = 16;

/// Relative rounding error of f64, with a safety factor of a hundred.
pub(super) const EXACT: f64 = 1.0 / (1_u64 << 46) as f64;

/// Number of f32 spacings by which an outline may deviate and still count as straight.
const WAVERING: f64 = 16.0;

/// The outline of a sheet in its plane.
pub(super) struct Outline<'a> {
    soup: &'a Soup,
    /// Origin of the plane's coordinates, in space.
    origin: DVec3,
    /// Unit vectors in the plane; the second is the first rotated by 90° counter-clockwise, viewed from the front.
    axes: [DVec3; 2],
    /// Boundary edges, from and to, as indices into the soup's points; the inside is on the left.
    pub(super) edges: Vec<[u32; 2]>,
    /// Whether all corners are exactly in the plane.
    pub(super) exact: bool,
    /// Distance by which an outline may deviate and still count as straight.
    pub(super) wavering: f64,
    /// Bounding rectangle of all corners: minimum, and maximum in `max`.
    pub(super) min: DVec2,
    pub(super) max: DVec2,
}

impl<'a> Outline<'a> {
    /// Computes the outline of the faces of a sheet; `None` if they bound no area.
    pub(super) fn of(soup: &'a Soup, sheet: &Sheet) -> Option<Outline<'a>> {
        let edges = soup.boundary(&sheet.faces, sheet.normal);
        let ends = || edges.iter().flatten().map(|&end| soup.points[end as usize]);
        let far = ends().map(|point| point.abs().max_element()).fold(0.0, f64::max);
        let normal = sheet.normal;
        let longest = edges
            .iter()
            .map(|&[from, to]| soup.points[to as usize] - soup.points[from as usize])
            .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
        let (origin, axes) = match (0..3).find(|&axis| normal[axis].abs() == 1.0) {
            // Axis-aligned: the other two coordinates are used unchanged, so that nothing is rounded.
            Some(axis) => {
                let next = DVec3::AXES[(axis + 1) % 3];
                (normal * sheet.distance, [next, normal.cross(next)])
            }
            None => {
                let along = (longest - normal * normal.dot(longest)).try_normalize()?;
                let start = soup.points[edges[0][0] as usize];
                let origin = start + normal * (sheet.distance - normal.dot(start));
                (origin, [along, normal.cross(along)])
            }
        };
        let mut outline = Outline {
            soup,
            origin,
            axes,
            exact: sheet.slack <= EXACT * far,
            wavering: WAVERING * f64::from(f32::EPSILON) * far,
            min: DVec2::INFINITY,
            max: DVec2::NEG_INFINITY,
            edges,
        };
        for place in 0..outline.edges.len() {
            let at = outline.flat(outline.edges[place][0]);
            outline.min = outline.min.min(at);
            outline.max = outline.max.max(at);
        }
        Some(outline)
    }

    /// Returns the position of a corner in the plane.
    pub(super) fn flat(&self, point: u32) -> DVec2 {
        self.flattened(self.soup.points[point as usize])
    }

    /// Projects a point of space to the plane.
    pub(super) fn flattened(&self, point: DVec3) -> DVec2 {
        let from_origin = point - self.origin;
        DVec2::new(self.axes[0].dot(from_origin), self.axes[1].dot(from_origin))
    }

    /// Returns the position in space of a point of the plane.
    pub(super) fn raised(&self, point: DVec2) -> DVec3 {
        self.origin + self.axes[0] * point.x + self.axes[1] * point.y
    }

    /// Returns the position in space of a corner of the mesh.
    pub(super) fn corner(&self, point: u32) -> DVec3 {
        self.soup.points[point as usize]
    }

    /// Returns the corners of the outline if it is one convex polygon of at most [`MAX_CORNERS`] corners; it may turn
    /// inwards by rounding errors.
    pub(super) fn as_one(&self) -> Option<Vec<DVec3>> {
        let mut corners = self.loop_of_edges()?;
        // Twice: dropping corners at the end may make the start collinear.
        for _ in 0..2 {
            self.straighten(&mut corners);
        }
        if !self.is_convex(&corners) {
            return None;
        }
        if self.exact {
            let flat = corners.iter().map(|&corner| self.flat(corner)).collect();
            let kept = fewer_corners(flat);
            corners = kept.into_iter().map(|place| corners[place]).collect();
        }
        (corners.len() <= MAX_CORNERS).then(|| corners.iter().map(|&corner| self.corner(corner)).collect())
    }

    /// Chains all edges end to end; `None` if they do not form one loop.
    fn loop_of_edges(&self) -> Option<Vec<u32>> {
        let mut sorted = self.edges.clone();
        sorted.sort_unstable();
        if sorted.windows(2).any(|pair| pair[0][0] == pair[1][0]) {
            return None;
        }
        let mut corners = Vec::with_capacity(sorted.len());
        let mut at = sorted.first()?[0];
        for _ in 0..sorted.len() {
            corners.push(at);
            let place = sorted.binary_search_by_key(&at, |edge| edge[0]).ok()?;
            at = sorted[place][1];
            if at == corners[0] {
                break;
            }
        }
        (corners.len() == sorted.len() && corners.len() >= 3).then_some(corners)
    }

    /// Removes corners that add no or almost no area.
    fn straighten(&self, corners: &mut Vec<u32>) {
        let mut kept: Vec<u32> = Vec::with_capacity(corners.len());
        for (place, &corner) in corners.iter().enumerate() {
            let after = corners[(place + 1) % corners.len()];
            let straight = kept
                .last()
                .is_some_and(|&before| self.is_straight(before, corner, after));
            if !straight {
                kept.push(corner);
            }
        }
        if kept.len() >= 3 && self.is_straight(kept[kept.len() - 1], kept[0], kept[1]) {
            kept.remove(0);
        }
        *corners = kept;
    }

    /// Returns `true` if the edges to and from a corner may be replaced by one edge.
    fn is_straight(&self, before: u32, corner: u32, after: u32) -> bool {
        let [a, b, c] = [before, corner, after].map(|point| self.corner(point));
        let (to, on) = (b - a, c - b);
        if to.dot(on) <= 0.0 {
            return false;
        }
        if to.cross(on).length_squared() <= EXACT * EXACT * to.length_squared() * on.length_squared() {
            return true;
        }
        let [a, b, c] = [before, corner, after].map(|point| self.flat(point));
        let bulge = (b - a).perp_dot(c - b);
        self.exact && bulge >= 0.0 && bulge <= self.wavering * a.distance(c)
    }

    /// Returns `true` if a loop is convex up to rounding errors.
    fn is_convex(&self, corners: &[u32]) -> bool {
        let flat: Vec<DVec2> = corners.iter().map(|&corner| self.flat(corner)).collect();
        let middle = flat.iter().sum::<DVec2>() / flat.len() as f64;
        // Winds once around the centre, with no notch deeper than a rounding error.
        let mut turns = 0;
        for (place, &b) in flat.iter().enumerate() {
            let a = flat[(place + flat.len() - 1) % flat.len()];
            let c = flat[(place + 1) % flat.len()];
            if (b - a).perp_dot(c - b) < -self.wavering * a.distance(c)
                || (b - middle).perp_dot(c - middle) <= 0.0
            {
                return false;
            }
            turns += u32::from(b.y < middle.y && c.y >= middle.y);
        }
        turns == 1 && flat.len() >= 3
    }
}

/// Selects the corners of a convex polygon to keep, so that at most [`MAX_CORNERS`] are left, if possible. Repeatedly
/// cuts off the corner that loses the least area; the result is inside the polygon.
pub(super) fn fewer_corners(flat: Vec<DVec2>) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..flat.len()).collect();
    let lost = |kept: &[usize], place: usize| {
        let [a, b, c] =
            [place + kept.len() - 1, place, place + 1].map(|place| flat[kept[place % kept.len()]]);
        (b - a).perp_dot(c - b)
    };
    // Halves long outlines first, so that the quadratic loop below is short.
    while kept.len() > 8 * MAX_CORNERS {
        let half: Vec<usize> = (0..kept.len())
            .filter(|&place| place % 2 == 0 || lost(&kept, place) < 0.0)
            .map(|place| kept[place])
            .collect();
        if half.len() == kept.len() {
            break;
        }
        kept = half;
    }
    while kept.len() > MAX_CORNERS {
        let least = (0..kept.len())
            .map(|place| (lost(&kept, place), place))
            .filter(|&(lost, _)| lost >= 0.0)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, place)) = least else { break };
        kept.remove(place);
    }
    kept
}
