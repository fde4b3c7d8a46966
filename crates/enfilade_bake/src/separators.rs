//! Planes that part two convex polygons: what is seen from one through the other stays on the other's side.
//!
//! A line that is below a plane at the source and above it at the pass is above it ever after.
//! Source: Teller. Visibility Computations in Densely Occluded Polyhedral Environments. PhD thesis, Berkeley 1992, 3.3.
//! Cost: each edge of either gives one plane, found in O(corners) of the other.
//! Conservative: a plane counts only where it is checked to part all corners of both, exactly where rounding could
//! decide; each knows how far rounding can tilt it within the world. One left out shows more.

use crate::winding::{Plane, Sharp};
use glam::DVec3;

/// A corner farther in line with an edge than this, as a squared sine, says nothing sure about a plane through both.
const NEEDLE: f64 = 1e-12;

/// Of its length: what rounding can do to the height of a corner over a plane. A few 2⁻⁵³, and some to spare.
const ROUNDING: f64 = 1e-14;

/// Appends the planes between `source` and `pass`, with all of `pass` above.
///
/// `pass` lies on the side of `source` to which its counter-clockwise normal points, and `source` behind `pass`: lines go
/// along both normals, or, where `against` says so, against both. `size` is the farthest that two corners of the world
/// are apart.
pub(crate) fn separators(
    source: &[DVec3],
    pass: &[DVec3],
    against: bool,
    size: f64,
    planes: &mut Vec<Plane>,
) {
    around(source, against, pass, size, |plane| planes.push(plane));
    around(pass, !against, source, size, |plane| planes.push(plane.flipped()));
}

/// The planes through the edges of one winding, all turned round where `backwards`, with the other above.
fn around(edged: &[DVec3], backwards: bool, other: &[DVec3], size: f64, mut push: impl FnMut(Plane)) {
    let mut before = edged.len() - 1;
    let mut touched = 0;
    for at in 0..edged.len() {
        let edge = if backwards { [at, before] } else { [before, at] };
        if let Some(plane) = through(edge, edged, other, &mut touched, size) {
            push(plane);
        }
        before = at;
    }
}

/// The plane through an edge of `edged` that has all of `other` above it and touches it.
///
/// `guess` is where to look for the corner that it touches, and then where that was: neighbours touch neighbours.
fn through(
    ends: [usize; 2],
    edged: &[DVec3],
    other: &[DVec3],
    guess: &mut usize,
    size: f64,
) -> Option<Plane> {
    let [from, to] = ends.map(|end| edged[end]);
    let edge = to - from;
    let edge_squared = edge.length_squared();
    let mut found: Option<(usize, DVec3, f64)> = None;
    for at in (*guess..other.len()).chain(0..*guess) {
        let reach = other[at] - from;
        if found.is_some_and(|(_, cross, _)| cross.dot(reach) >= 0.0) {
            continue;
        }
        let cross = edge.cross(reach);
        let lengths_squared = edge_squared * reach.length_squared();
        if cross.length_squared() > NEEDLE * lengths_squared {
            found = Some((at, cross, lengths_squared));
        }
    }
    let (touching, cross, lengths_squared) = found?;
    *guess = touching;
    let touched = other[touching];
    let cross_squared = cross.length_squared();
    let normal = cross / cross_squared.sqrt();
    // Squared, the sine between the edge and the corner.
    let mut sine_squared = cross_squared / lengths_squared;
    // Four times what the careful check asks of the farthest corner: most are sure to pass it.
    let sure = lengths_squared * (4.0 * ROUNDING * size).powi(2);
    let parts = |winding: &[DVec3], but: [usize; 2], side: f64| {
        winding.iter().enumerate().all(|(at, &corner)| {
            let above = cross.dot(corner - from) * side;
            but.contains(&at) || above * above.abs() > sure
        })
    };
    if !(parts(edged, ends, -1.0) && parts(other, [touching; 2], 1.0)) {
        sine_squared = parts_closely([from, to, touched], normal, sine_squared, edged, other)?;
    }
    Some(Plane {
        normal,
        offset: normal.dot(from),
        slack: 8.0 * ROUNDING * size * (1.0 + 1.0 / sine_squared.sqrt()),
        sharp: Some(Sharp {
            through: [from, to, touched],
            turned: false,
        }),
    })
}

/// Whether a plane through three corners, found with an edge and a corner at a sine, has `edged` below and `other` above,
/// for all that rounding can do: if so, the least sine, squared, between the edge and a corner that it may rest on.
fn parts_closely(
    through: [DVec3; 3],
    normal: DVec3,
    mut sine_squared: f64,
    edged: &[DVec3],
    other: &[DVec3],
) -> Option<f64> {
    let from = through[0];
    let edge = through[1] - from;
    let edge_squared = edge.length_squared();
    let sides = edged.iter().map(|&corner| (corner, -1.0));
    for (corner, side) in sides.chain(other.iter().map(|&corner| (corner, 1.0))) {
        let reach = corner - from;
        let above = normal.dot(reach) * side;
        let reach_squared = reach.length_squared();
        if above * above * sine_squared > ROUNDING * ROUNDING * reach_squared {
            if above < 0.0 {
                return None;
            }
            continue;
        }
        if through.contains(&corner) {
            continue;
        }
        let off_edge = edge.cross(reach).length_squared();
        if off_edge == 0.0 {
            continue;
        }
        if off_edge <= NEEDLE * edge_squared * reach_squared {
            return None;
        }
        sine_squared = sine_squared.min(off_edge / (edge_squared * reach_squared));
    }
    Some(sine_squared)
}
