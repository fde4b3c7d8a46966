//! Splitting planes, and classification of polygons by their side.
//!
//! Building, cutting and traversal evaluate the same stored (rounded) plane, so that they cannot disagree far away,
//! where the plane of a sliver has departed from the sliver's neighbours. Points within `ROUNDING` of the plane count
//! as on it. Beyond that the sign of a height in f64 is certain: its error is at most 8 · 2⁻⁵³ of the maximum
//! coordinate (three products, three sums, a normal of length 1), and corners made by a cut, like the splitter's own
//! corners, are as near to their plane. So no exact arithmetic is needed. Exact predicates (crate `robust`) would not
//! fit either: they take points, not stored planes.
//! Cost: O(corners).

use crate::geom::cross::{cross, edge};
use glam::DVec3;

/// Thickness of a plane relative to the maximum coordinate: 32 units in the last place, about four times the maximum
/// rounding error.
pub(super) const ROUNDING: f64 = 32.0 / (1_u64 << 53) as f64;

/// The points p with normal · p = offset. The normal has length 1, up to rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) normal: DVec3,
    pub(super) offset: f64,
}

/// A candidate for the splitting plane of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Splitter {
    pub(super) plane: Plane,
    /// Points within this distance count as on the plane: the rounding error, or the deviation of the polygon's own
    /// corners.
    pub(super) band: f64,
    /// The polygon whose plane this is; `None` for a free plane.
    pub(super) polygon: Option<u32>,
}

/// Side of a plane that a polygon is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Front,
    Back,
    On,
    /// The polygon has corners on both sides.
    Both,
}

impl Plane {
    /// Returns the axis-aligned plane where coordinate `axis` (0 x, 1 y, 2 z) equals `at`.
    pub(super) fn across(axis: usize, at: f64) -> Plane {
        Plane {
            normal: DVec3::AXES[axis],
            offset: at,
        }
    }

    /// Returns the signed distance of a point; positive in front.
    #[inline(always)]
    pub(super) fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

impl Splitter {
    /// Returns the plane of a polygon; `None` if the polygon is so thin that rounding (`band`) may have tilted the
    /// plane arbitrarily.
    pub(super) fn of(polygon: u32, corners: &[DVec3], band: f64) -> Option<Splitter> {
        let first = corners[0];
        let [mut area, mut sum] = [DVec3::ZERO; 2];
        let mut longest = 0.0_f64;
        for pair in corners[1..].windows(2) {
            let edges = [edge(first, pair[0]), edge(first, pair[1])];
            area += cross(edges[0], edges[1]);
            longest = longest.max(edges[0].0.length()).max(edges[1].0.length());
        }
        for &corner in corners {
            sum += corner - first;
        }
        let length = area.length();
        let thick = length > 4.0 * band * longest && length.is_finite();
        thick.then(|| {
            let normal = area / length;
            let plane = Plane {
                normal,
                offset: normal.dot(first + sum / corners.len() as f64),
            };
            // Four f32 corners are never exactly coplanar. Whatever is as near to the plane as they are counts as on
            // it.
            let off = corners.iter().map(|&corner| plane.height(corner).abs());
            Splitter {
                plane,
                band: off.fold(band, f64::max),
                polygon: Some(polygon),
            }
        })
    }

    /// Classifies a polygon. Corners within `band` count as on the plane, as they do when the polygon is cut.
    #[inline(always)]
    pub(super) fn side(&self, corners: &[DVec3], band: f64) -> Side {
        let [mut low, mut high] = [0.0_f64; 2];
        for &corner in corners {
            let height = self.plane.height(corner);
            low = low.min(height);
            high = high.max(height);
        }
        match (low < -band, high > band) {
            (false, false) => Side::On,
            (false, true) => Side::Front,
            (true, false) => Side::Back,
            (true, true) => Side::Both,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(corners: [[f64; 3]; 3]) -> Option<Splitter> {
        let corners = corners.map(DVec3::from);
        let largest = corners.iter().fold(0.0, |m: f64, c| m.max(c.abs().max_element()));
        Splitter::of(0, &corners, ROUNDING * largest)
    }

    #[test]
    fn what_has_no_area_has_no_plane() {
        assert_eq!(of([[1.0; 3]; 3]), None);
        assert_eq!(of([[0.0; 3], [1.0; 3], [3.0; 3]]), None);
        assert_eq!(of([[0.0; 3]; 3]), None);
        // A needle of 1 : 10¹⁵ may have any normal.
        assert_eq!(of([[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-15, 0.0]]), None);
        assert!(of([[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-9, 0.0]]).is_some());
    }

    #[test]
    fn the_corners_of_a_needle_are_on_its_plane() {
        for scale in [1e-5, 1.0, 1e7] {
            let corners = [[0.3, 0.7, 0.1], [1.3, -0.2, 0.4], [0.8, 0.25 + 1e-9, 0.25]];
            let corners = corners.map(|c| c.map(|v| v * scale));
            let splitter = of(corners).expect("wide enough");
            assert_eq!(
                splitter.band,
                ROUNDING * 1.3 * scale,
                "no corner deviates by more than rounding"
            );
        }
    }

    #[test]
    fn a_polygon_is_before_behind_in_or_across_a_plane() {
        let floor = of([[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]).expect("a floor");
        let cases = [
            ([0.0, 1e-300, 0.0], Side::On),
            ([0.0, 1.0, 2.0], Side::Front),
            ([0.0, 0.0, -2.0], Side::Back),
            ([-1.0, 0.0, 2.0], Side::Both),
        ];
        for (heights, side) in cases {
            let corners = heights.map(|y| DVec3::new(y, y, 3.0));
            assert_eq!(floor.side(&corners, floor.band), side, "{heights:?}");
        }
    }
}
