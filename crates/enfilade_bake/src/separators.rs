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
    let on_source = edges(source, against).filter_map(|edge| through(edge, source, pass, size));
    planes.extend(on_source);
    let on_pass = edges(pass, !against).filter_map(|edge| through(edge, pass, source, size));
    planes.extend(on_pass.map(|plane| plane.flipped()));
}

/// Pairs of neighbours, all turned round where `backwards`.
fn edges(winding: &[DVec3], backwards: bool) -> impl Iterator<Item = [DVec3; 2]> + '_ {
    let mut from = winding[winding.len() - 1];
    winding.iter().map(move |&to| {
        let edge = if backwards { [to, from] } else { [from, to] };
        from = to;
        edge
    })
}

/// The plane through an edge of `edged` that has all of `other` above it and touches it.
fn through([from, to]: [DVec3; 2], edged: &[DVec3], other: &[DVec3], size: f64) -> Option<Plane> {
    let edge = to - from;
    let edge_squared = edge.length_squared();
    let mut cross = DVec3::ZERO;
    let mut touched = from;
    let mut found = false;
    for &corner in other {
        let reach = corner - from;
        if found && cross.dot(reach) >= 0.0 {
            continue;
        }
        let normal = edge.cross(reach);
        if normal.length_squared() > NEEDLE * edge_squared * reach.length_squared() {
            (cross, touched, found) = (normal, corner, true);
        }
    }
    if !found {
        return None;
    }
    let cross_squared = cross.length_squared();
    let normal = cross / cross_squared.sqrt();
    // Squared, the least sine between the edge and a corner that the plane may rest on.
    let mut sine_squared = cross_squared / (edge_squared * (touched - from).length_squared());
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
        if corner == from || corner == to || corner == touched {
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
