//! Planes that stand upright on the edges of polygons.
//!
//! Two polygons that nearly share a plane cut each other's, but such a plane parts them; so it does the two sides of a
//! fold or a window frame. Like planes across axes, these take no polygon away.
//! Source: ours; every tree that splits by more than the polygons' planes is a BSP tree in the sense of Fuchs et al.
//! Cost: O(1) for each.
//! Where an edge was made by a cut, the plane is as near to it as any splitter's to its corners.

use super::side::{Plane, Splitter};
use super::split::{Arena, Working};

/// The planes upright on the edges of a polygon whose own plane is `splitter`'s. None on an edge that is so short that
/// rounding (`band`) may have turned it.
pub(super) fn on_edges(
    of: &Working,
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
        // The second corner is there twice: no plane stands on an edge without length.
        let working = arena.add(0, [0, 1, 1, 2].map(|place| corners[place]));
        let splitter = Splitter::of(0, arena.corners(&working), band).expect("it has an area");
        let planes: Vec<Splitter> = on_edges(&working, &arena, &splitter, band).collect();
        assert_eq!(planes.len(), 3);
        for plane in planes {
            assert_eq!(plane.side(arena.corners(&working), band), Side::Front);
            assert!(plane.plane.normal.dot(splitter.plane.normal).abs() < 1e-12);
        }
    }
}
