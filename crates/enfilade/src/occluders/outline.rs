//! What a sheet covers, flattened: its outline as edges in a plane, and whether that is one convex polygon.
//!
//! Why an outline of true edges hides only what the faces hide, from every eye, though corners are off the plane by
//! their roundings: take an eye before the plane, by more than the slack, and a point behind it, by more than the slack,
//! that is on the inner side of every plane through the eye and an edge. Seen from there the outline turns around the
//! point at every edge, so it winds around it, once or more; it is the sum of the outlines of the faces, each taken
//! around; so one of them winds around it the right way: a face that looks at the eye lies before the point. It need not
//! be convex for that: where it turns inwards by a rounding, less is hidden.
//! An edge may replace two only where they lie outside it from every eye: in one line exactly, or, where all corners are
//! in one plane exactly, bulging outwards.
//! Source: winding numbers; the kernel of a polygon (Lee, Preparata, J. ACM 1979) is what all edges hold.
//! Cost: O(n log n) for n edges.
//! *Exactly* is up to the rounding of f64, as in all that is done on the screen.

use super::sheets::Sheet;
use super::soup::Soup;
use glam::{DVec2, DVec3};

/// Corners of an occluder, at most: each is a plane for an occlusion tree, and rounder ones hide little more.
pub(super) const MAX_CORNERS: usize = 16;

/// What f64 rounds, relatively, with a margin of a hundred.
pub(super) const EXACT: f64 = 1.0 / (1_u64 << 46) as f64;

/// By how many f32 spacings an outline may waver and be called straight.
const WAVERING: f64 = 16.0;

/// The outline of a sheet in its plane.
pub(super) struct Outline<'a> {
    soup: &'a Soup,
    origin: DVec3,
    /// Unit vectors in the plane; a quarter turn leads from one to the other, seen from the front.
    axes: [DVec3; 2],
    /// From and to, as places in the soup's points; inside is on the left.
    pub(super) edges: Vec<[u32; 2]>,
    /// Do all corners lie in the plane, exactly?
    pub(super) exact: bool,
    /// By how much an outline may waver and be called straight.
    pub(super) wavering: f64,
    /// Around all corners.
    pub(super) min: DVec2,
    pub(super) max: DVec2,
}

impl<'a> Outline<'a> {
    /// The outline of some faces of a sheet; `None` where they bound nothing.
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
            // The other two coordinates serve as they are, so that nothing is rounded.
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

    /// Where a corner is in the plane.
    pub(super) fn flat(&self, point: u32) -> DVec2 {
        self.flattened(self.soup.points[point as usize])
    }

    pub(super) fn flattened(&self, point: DVec3) -> DVec2 {
        let from_origin = point - self.origin;
        DVec2::new(self.axes[0].dot(from_origin), self.axes[1].dot(from_origin))
    }

    /// Where a point of the plane is in space.
    pub(super) fn raised(&self, point: DVec2) -> DVec3 {
        self.origin + self.axes[0] * point.x + self.axes[1] * point.y
    }

    /// A true corner, in space.
    pub(super) fn corner(&self, point: u32) -> DVec3 {
        self.soup.points[point as usize]
    }

    /// The corners of the whole outline, if it is one convex polygon of few corners: but for roundings, at which it may
    /// turn inwards.
    pub(super) fn as_one(&self) -> Option<Vec<DVec3>> {
        let mut corners = self.loop_of_edges()?;
        // Twice: what is dropped at the end may bring the start into line.
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

    /// All edges, end to end; `None` where they are not one loop.
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

    /// Drops corners that add nothing or next to nothing.
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

    /// May the edges to and from a corner be one?
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

    /// Is a loop convex, but for roundings?
    fn is_convex(&self, corners: &[u32]) -> bool {
        let flat: Vec<DVec2> = corners.iter().map(|&corner| self.flat(corner)).collect();
        let middle = flat.iter().sum::<DVec2>() / flat.len() as f64;
        // Once around the middle, and no notch deeper than a rounding.
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

/// Which corners of a convex polygon to keep, so that few are left: the ones cut off are those that lose least. What is
/// left lies inside it.
pub(super) fn fewer_corners(flat: Vec<DVec2>) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..flat.len()).collect();
    let lost = |kept: &[usize], place: usize| {
        let [a, b, c] =
            [place + kept.len() - 1, place, place + 1].map(|place| flat[kept[place % kept.len()]]);
        (b - a).perp_dot(c - b)
    };
    // The many that hardly count first, so that what is left to be chosen from is little.
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
