//! Clipping of polygons during BSP construction.
//!
//! Each edge records the node whose plane made it. A cut that no longer forms an edge is dropped from the piece, which
//! can only make the piece larger, so that no gap opens between the halves.
//! Source: Sutherland, Hodgman. Reentrant Polygon Clipping. 1974; for both sides at once.
//! Cost: O(corners).
//! No half is lost: each has a corner farther from the plane than the band that counts as on it.

use super::side::Plane;
use glam::DVec3;
use std::num::NonZeroU32;

/// A polygon or what clipping has left of it: a run of corners in the arena.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClipPolygon {
    pub(super) polygon: u32,
    first: u32,
    count: u32,
}

/// One side of the plane of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Cut(NonZeroU32);

impl Cut {
    pub(super) fn new(node: u32, back: bool) -> Cut {
        Cut(NonZeroU32::MIN.saturating_add(2 * node + u32::from(back)))
    }

    pub(super) fn node(self) -> u32 {
        (self.0.get() - 1) / 2
    }

    pub(super) fn back(self) -> bool {
        self.0.get().is_multiple_of(2)
    }
}

/// Corners of all pending polygons.
#[derive(Default)]
pub(super) struct Arena {
    corners: Vec<DVec3>,
    /// The cut that made the edge beginning at each corner; `None` for an edge of the input polygon.
    made_by: Vec<Option<Cut>>,
    heights: Vec<f64>,
}

impl Arena {
    /// Adds an input polygon.
    pub(super) fn add(&mut self, polygon: u32, corners: impl IntoIterator<Item = DVec3>) -> ClipPolygon {
        let first = self.corners.len() as u32;
        self.corners.extend(corners);
        self.made_by.resize(self.corners.len(), None);
        self.since(polygon, first)
    }

    /// Copies a polygon from another arena.
    pub(super) fn copy(&mut self, from: &Arena, of: &ClipPolygon) -> ClipPolygon {
        let first = self.corners.len() as u32;
        self.corners.extend_from_slice(from.corners(of));
        let run = of.first as usize..(of.first + of.count) as usize;
        self.made_by.extend_from_slice(&from.made_by[run]);
        self.since(of.polygon, first)
    }

    pub(super) fn corners(&self, of: &ClipPolygon) -> &[DVec3] {
        &self.corners[of.first as usize..(of.first + of.count) as usize]
    }

    /// Returns the cuts that form edges of the polygon.
    pub(super) fn cuts(&self, of: &ClipPolygon) -> impl Iterator<Item = Cut> {
        self.made_by[of.first as usize..(of.first + of.count) as usize]
            .iter()
            .copied()
            .flatten()
    }

    /// Returns the number of corners; see [`Arena::forget`].
    pub(super) fn len(&self) -> usize {
        self.corners.len()
    }

    /// Drops all corners added since there were `len`.
    pub(super) fn forget(&mut self, len: usize) {
        self.corners.truncate(len);
        self.made_by.truncate(len);
    }

    /// Splits a polygon that straddles the plane of `node`; returns the front and the back half. Corners within `band`
    /// belong to both.
    pub(super) fn split(
        &mut self,
        whole: ClipPolygon,
        plane: &Plane,
        band: f64,
        node: u32,
    ) -> [ClipPolygon; 2] {
        let mut heights = std::mem::take(&mut self.heights);
        heights.clear();
        heights.extend(self.corners(&whole).iter().map(|&corner| {
            let height = plane.height(corner);
            if height.abs() <= band { 0.0 } else { height }
        }));
        let halves = [false, true].map(|back| {
            let first = self.corners.len() as u32;
            let sign = if back { -1.0 } else { 1.0 };
            let cut = Some(Cut::new(node, back));
            for here in 0..whole.count as usize {
                let next = (here + 1) % whole.count as usize;
                let [at, to] = [here, next].map(|place| self.corners[whole.first as usize + place]);
                let [above, next_above] = [here, next].map(|place| sign * heights[place]);
                let edge = self.made_by[whole.first as usize + here];
                if above >= 0.0 {
                    let leaves = above == 0.0 && next_above < 0.0;
                    self.push(at, if leaves { cut } else { edge });
                }
                if above > 0.0 && next_above < 0.0 {
                    self.push(crossing([at, to], [above, next_above]), cut);
                } else if above < 0.0 && next_above > 0.0 {
                    self.push(crossing([to, at], [next_above, above]), edge);
                }
            }
            self.since(whole.polygon, first)
        });
        self.heights = heights;
        halves
    }

    fn push(&mut self, corner: DVec3, made_by: Option<Cut>) {
        self.corners.push(corner);
        self.made_by.push(made_by);
    }

    fn since(&self, polygon: u32, first: u32) -> ClipPolygon {
        let count = self.corners.len() as u32 - first;
        ClipPolygon {
            polygon,
            first,
            count,
        }
    }
}

/// Returns the intersection of an edge with a plane. It is interpolated from the nearer end whichever way the edge
/// runs, so that both halves, and neighbours that share the edge, get the same bits.
fn crossing([a, b]: [DVec3; 2], [a_above, b_above]: [f64; 2]) -> DVec3 {
    let all = a_above - b_above;
    if a_above < -b_above {
        a + (b - a) * (a_above / all)
    } else if a_above > -b_above {
        b + (a - b) * (-b_above / all)
    } else {
        0.5 * (a + b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn halves(corners: &[[f64; 3]], at: f64) -> (Arena, [ClipPolygon; 2]) {
        let mut arena = Arena::default();
        let whole = arena.add(7, corners.iter().map(|&c| DVec3::from(c)));
        let halves = arena.split(whole, &Plane::across(0, at), 1e-12, 3);
        (arena, halves)
    }

    const SQUARE: [[f64; 3]; 4] = [[0.0; 3], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]];

    #[test]
    fn both_halves_have_the_same_corners_on_the_cut_and_one_new_edge() {
        let (arena, [front, back]) = halves(&SQUARE, 1.0);
        let on_cut = |half: &ClipPolygon| {
            let mut on: Vec<_> = arena
                .corners(half)
                .iter()
                .filter(|c| c.x == 1.0)
                .map(|c| c.y)
                .collect();
            on.sort_by(f64::total_cmp);
            on
        };
        assert_eq!((on_cut(&front), on_cut(&back)), (vec![0.0, 4.0], vec![0.0, 4.0]));
        assert_eq!(arena.cuts(&front).collect::<Vec<_>>(), [Cut::new(3, false)]);
        assert_eq!(arena.cuts(&back).collect::<Vec<_>>(), [Cut::new(3, true)]);
        assert_eq!((Cut::new(3, true).node(), Cut::new(3, true).back()), (3, true));
    }

    #[test]
    fn a_corner_on_the_plane_belongs_to_both_halves() {
        let kite = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [3.0, 1.0, 0.0], [1.0, 2.0, 0.0]];
        let (arena, [front, back]) = halves(&kite, 1.0);
        for half in [front, back] {
            assert_eq!(arena.corners(&half).len(), 3);
            assert_eq!(arena.cuts(&half).count(), 1);
        }
    }

    #[test]
    fn a_cut_that_is_no_edge_any_more_is_forgotten() {
        let (mut arena, [front, _]) = halves(&SQUARE, 1.0);
        let [right, left] = arena.split(front, &Plane::across(0, 2.0), 1e-12, 4);
        assert_eq!(arena.cuts(&right).collect::<Vec<_>>(), [Cut::new(4, false)]);
        assert_eq!(arena.cuts(&left).count(), 2);
    }
}
