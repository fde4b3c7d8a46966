//! Splitting planes through polygon edges, perpendicular to the polygon.
//!
//! The planes of two nearly coplanar polygons cut the other polygon, but a plane through an edge separates them;
//! likewise the two sides of a fold or of a window frame. Like axis-aligned planes, these remove no polygon from the
//! node.
//! Source: ours; every tree that also splits by other planes than the polygons' own is still a BSP tree in the sense of
//!     Fuchs et al.
//! Cost: O(1) for each plane.
//! For an edge made by a cut, the plane is as near to the edge as any splitter is to its corners.

use super::side::{Plane, Splitter};
use super::split::{Arena, ClipPolygon};

/// Returns the planes through the edges of a polygon, perpendicular to its own plane (`splitter`). Edges so short that
/// rounding (`band`) may have turned them are skipped.
pub(super) fn planes_through_edges(
    of: &ClipPolygon,
    arena: &Arena,
    splitter: &Splitter,
    band: f64,
) -> impl Iterator<Item = Splitter> {
    let corners = arena.corners(of);
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    ends.filter_map(move |(&from, &to)| {
        let normal = splitter.plane.normal.cross(to - from);
        let length = normal.length();
        (length > 64.0 * band).then(|| {
            let normal = normal / length;
            Splitter {
                plane: Plane {
                    normal,
                    offset: normal.dot(0.5 * (from + to)),
                },
                band,
                polygon: None,
            }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::side::Side;
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_polygon_is_on_the_same_side_of_all_its_upright_planes() {
        let corners = [[0.1, 0.2, 0.3], [2.0, 0.5, 0.1], [2.1, 1.5, 0.7], [0.2, 1.2, 0.9]].map(DVec3::from);
        let band = 1e-12;
        let mut arena = Arena::default();
        // The second corner occurs twice: an edge without length has no plane.
        let working = arena.add(0, [0, 1, 1, 2].map(|place| corners[place]));
        let splitter = Splitter::of(0, arena.corners(&working), band).expect("it has an area");
        let planes: Vec<Splitter> = planes_through_edges(&working, &arena, &splitter, band).collect();
        assert_eq!(planes.len(), 3);
        for plane in planes {
            assert_eq!(plane.side(arena.corners(&working), band), Side::Front);
            assert!(plane.plane.normal.dot(splitter.plane.normal).abs() < 1e-12);
        }
    }
}
