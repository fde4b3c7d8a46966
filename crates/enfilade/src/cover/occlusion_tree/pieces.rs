//! Splits convex polygons by planes.
//!
//! Corners that count as on the plane belong to both halves, so together the halves are never less than the whole.
//! Source: Sutherland, Hodgman. Reentrant Polygon Clipping. 1974; done for both sides at once.
//! Cost: O(corners).

use glam::DVec3;

/// A convex polygon: a run of corners in [`Pieces`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Piece {
    first: u32,
    count: u32,
}

/// The sides of a plane on which a piece has corners, apart from corners that count as on the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Reach {
    pub(super) inside: bool,
    pub(super) outside: bool,
}

/// Storage for the corners of all pieces.
#[derive(Default)]
pub(super) struct Pieces {
    corners: Vec<DVec3>,
    /// Height of each corner of the piece measured last; 0 if it counts as on the plane.
    heights: Vec<f64>,
    /// Index of the corner at which the edge begins that the last split added to the half.
    cut: Option<u32>,
}

impl Pieces {
    /// Removes all pieces.
    pub(super) fn clear(&mut self) {
        self.corners.clear();
    }

    /// Adds a polygon.
    pub(super) fn add(&mut self, corners: impl IntoIterator<Item = DVec3>) -> Piece {
        let first = self.corners.len() as u32;
        self.corners.extend(corners);
        self.since(first)
    }

    /// Returns the corners of a piece.
    pub(super) fn corners(&self, of: Piece) -> &[DVec3] {
        &self.corners[of.first as usize..(of.first + of.count) as usize]
    }

    /// Classifies a piece against a plane. `height` is the height of a point above the plane; corners within `slit` · W
    /// of it count as on it.
    pub(super) fn measure(&mut self, piece: Piece, slit: f64, height: impl Fn(DVec3) -> f64) -> Reach {
        let Pieces { corners, heights, .. } = self;
        heights.clear();
        let mut reach = Reach {
            inside: false,
            outside: false,
        };
        let corners = &corners[piece.first as usize..(piece.first + piece.count) as usize];
        heights.extend(corners.iter().map(|&corner| {
            let [height, slit] = [height(corner), slit * corner.z];
            let off = if height > slit || height < -slit {
                height
            } else {
                0.0
            };
            reach.inside |= off > 0.0;
            reach.outside |= off < 0.0;
            off
        }));
        reach
    }

    /// Returns the parts inside and outside the plane by which `piece` was measured last.
    pub(super) fn split(&mut self, piece: Piece) -> [Piece; 2] {
        [1.0, -1.0].map(|sign| self.half(piece, sign))
    }

    /// Returns the part inside the plane by which `piece` was measured last; with `sign` −1, the part outside.
    pub(super) fn half(&mut self, piece: Piece, sign: f64) -> Piece {
        let Pieces {
            corners,
            heights,
            cut,
        } = self;
        let first = corners.len() as u32;
        *cut = None;
        let Some(&height) = heights.first() else {
            return self.since(first);
        };
        // At most one additional corner for each crossing of the outline.
        corners.reserve(2 * piece.count as usize);
        let mut next_above = sign * height;
        for here in 0..piece.count as usize {
            let next = if here + 1 == piece.count as usize {
                0
            } else {
                here + 1
            };
            let [at, to] = [here, next].map(|index| corners[piece.first as usize + index]);
            let above = next_above;
            next_above = sign * heights[next];
            if above >= 0.0 {
                corners.push(at);
            }
            if (above > 0.0 && next_above < 0.0) || (above < 0.0 && next_above > 0.0) {
                corners.push(crossing([at, to], [above, next_above]));
            }
            if above >= 0.0 && next_above < 0.0 {
                *cut = Some(corners.len() as u32 - 1 - first);
            }
        }
        self.since(first)
    }

    /// Returns the ends of the edge that the last split added to `half`.
    pub(super) fn cut_edge(&self, half: Piece) -> Option<[DVec3; 2]> {
        let corners = self.corners(half);
        let from = self.cut? as usize;
        Some([corners[from], corners[(from + 1) % corners.len()]])
    }

    /// Returns the piece of all corners from index `first` on.
    fn since(&self, first: u32) -> Piece {
        Piece {
            first,
            count: self.corners.len() as u32 - first,
        }
    }
}

/// Returns the intersection of a plane with an edge whose ends are on both sides of it.
///
/// It is a sum of both ends with positive weights, so a near end loses no precision if the other is far away; and it
/// has the same bits in either direction of the edge.
fn crossing([a, b]: [DVec3; 2], [a_above, b_above]: [f64; 2]) -> DVec3 {
    let [to_a, to_b] = [a_above.abs(), b_above.abs()];
    (a * to_b + b * to_a) / (to_a + to_b)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [4.0, 4.0, 1.0], [0.0, 4.0, 1.0]];

    #[test]
    fn a_square_is_cut_into_two_that_meet() {
        let mut pieces = Pieces::default();
        let whole = pieces.add(SQUARE.map(DVec3::from));
        let reach = pieces.measure(whole, 1e-6, |corner| corner.x - corner.z);
        assert!(reach.inside && reach.outside);
        let [right, left] = pieces.split(whole);
        let [from, to] = pieces.cut_edge(left).expect("the half was split off");
        assert!(from.x == 1.0 && to.x == 1.0 && from.y < to.y);
        let least = |piece: Piece| pieces.corners(piece).iter().map(|c| c.x).fold(9.0, f64::min);
        let greatest = |piece: Piece| pieces.corners(piece).iter().map(|c| c.x).fold(-9.0, f64::max);
        assert_eq!(
            [least(right), greatest(right), least(left), greatest(left)],
            [1.0, 4.0, 0.0, 1.0]
        );
    }

    #[test]
    fn a_corner_on_the_plane_belongs_to_both_halves() {
        let mut pieces = Pieces::default();
        let whole = pieces.add(SQUARE.map(DVec3::from));
        pieces.measure(whole, 1e-6, |corner| corner.x - corner.y + 1e-7);
        for half in pieces.split(whole) {
            assert_eq!(pieces.corners(half).len(), 3);
        }
    }

    #[test]
    fn what_only_touches_a_plane_is_on_one_side() {
        let mut pieces = Pieces::default();
        let whole = pieces.add(SQUARE.map(DVec3::from));
        let reach = pieces.measure(whole, 1e-6, |corner| corner.x + 1e-7);
        assert!(reach.inside && !reach.outside);
    }

    #[test]
    fn an_edge_from_the_feet_to_the_horizon_is_cut_where_it_is() {
        let [near, far] = [DVec3::new(0.1, -3.0, 0.01), DVec3::new(1e9, 2e9, 1e7)];
        let height = |p: DVec3| p.y + 200.0 * p.z;
        let at = crossing([near, far], [height(near), height(far)]);
        assert!((height(at) / at.z).abs() < 1e-10, "{at}");
    }
}
