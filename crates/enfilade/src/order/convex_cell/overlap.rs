//! Detects coplanar overlapping faces within a cluster, such as a picture on its wall.

use super::Plane;
use super::walls::Face;
use glam::DVec3;

/// Returns `true` if any two faces are coplanar and overlap by more than `slack`. Sorts the faces.
///
/// Cost: O(n log n), plus a test for each pair that overlaps along the longest side.
pub(super) fn any_overlap(faces: &mut [Face], corners: &[DVec3], slack: f64) -> bool {
    if faces.len() < 2 {
        return false;
    }
    let (mut min, mut max) = (corners[0], corners[0]);
    for &corner in corners {
        (min, max) = (min.min(corner), max.max(corner));
    }
    let axis = (max - min).max_position();
    for face in &mut *faces {
        let along = corners[face.corners[0]..face.corners[1]].iter();
        face.span = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, greatest], corner| {
            [least.min(corner[axis]), greatest.max(corner[axis])]
        });
    }
    faces.sort_unstable_by(|a, b| a.span[0].total_cmp(&b.span[0]));
    faces.iter().enumerate().any(|(at, face)| {
        let beside = faces[at + 1..]
            .iter()
            .take_while(|other| other.span[0] < face.span[1]);
        beside
            .into_iter()
            .any(|other| overlap(face, other, corners, slack))
    })
}

fn overlap(a: &Face, b: &Face, corners: &[DVec3], slack: f64) -> bool {
    let [of_a, of_b] = [a, b].map(|face| &corners[face.corners[0]..face.corners[1]]);
    let in_one_plane = of_b
        .iter()
        .all(|&corner| a.plane.height(corner).abs() <= 2.0 * slack);
    in_one_plane
        && !is_apart(of_a, a.area, &a.plane, of_b, slack)
        && !is_apart(of_b, b.area, &a.plane, of_a, slack)
}

/// Returns `true` if `other` is entirely beyond one edge of `polygon`; both are in `plane`.
fn is_apart(polygon: &[DVec3], area: DVec3, plane: &Plane, other: &[DVec3], slack: f64) -> bool {
    let turn = plane.normal * area.dot(plane.normal).signum();
    let mut from = polygon[polygon.len() - 1];
    polygon.iter().any(|&to| {
        let inwards = turn.cross(to - from);
        let most = slack * inwards.length();
        let beyond = other.iter().all(|&corner| inwards.dot(corner - from) <= most);
        from = to;
        beyond
    })
}
