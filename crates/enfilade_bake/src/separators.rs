//! Planes that part two convex polygons: what is seen from one through the other stays on the other's side.
//!
//! A line that is below a plane at the source and above it at the pass is above it ever after.
//! Source: Teller. Visibility Computations in Densely Occluded Polyhedral Environments. PhD thesis, Berkeley 1992, 3.3.
//! Cost: each edge of either gives one plane, found in O(corners) of the other.
//! Conservative: a plane counts only where it is checked to part all corners of both, exactly where rounding could
//! decide; each knows how far rounding can tilt it within the world. One left out shows more.

use crate::ways::Ways;
use crate::winding::{Plane, Sharp};
use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use four_edges::FourEdges;
use glam::DVec3;

mod four_edges;

/// A corner farther in line with an edge than this, as a squared sine, says nothing sure about a plane through both.
const NEEDLE: f64 = 1e-12;

/// Of its length: what rounding can do to the height of a corner over a plane. A few 2⁻⁵³, and some to spare.
const ROUNDING: f64 = 1e-14;

/// Appends the planes between `source` and `pass`, with all of `pass` above.
///
/// `pass` lies on the side of `source` to which its counter-clockwise normal points, and `source` behind `pass`: lines go
/// along both normals, or, where `against` says so, against both.
pub(crate) fn separators(
    ways: &Ways,
    source: &[DVec3],
    pass: &[DVec3],
    against: bool,
    planes: &mut Vec<Plane>,
) {
    dispatch!(ways.level, simd => {
        around(simd, [source, pass], against, ways.size, |plane| planes.push(plane));
        around(simd, [pass, source], !against, ways.size, |plane| planes.push(plane.flipped()));
    });
}

/// The planes through the edges of the first winding, all turned round where `backwards`, with the second above.
#[inline(always)]
fn around<S: Simd>(
    simd: S,
    [edged, other]: [&[DVec3]; 2],
    backwards: bool,
    size: f64,
    mut push: impl FnMut(Plane),
) {
    let last = edged.len() - 1;
    for first in (0..edged.len()).step_by(4) {
        let mut ends = [[0; 2]; 4];
        for (lane, ends) in ends.iter_mut().enumerate() {
            let at = (first + lane).min(last);
            let before = if at == 0 { last } else { at - 1 };
            *ends = if backwards { [at, before] } else { [before, at] };
        }
        let four = FourEdges::rest(simd, ends, edged, other, size);
        for (lane, [from, to]) in ends.into_iter().enumerate().take(edged.len() - first) {
            let Some((plane, touched)) = four.lane(lane) else {
                continue;
            };
            push(Plane {
                sharp: Some(Sharp {
                    through: [edged[from], edged[to], other[touched]],
                    turned: false,
                }),
                ..plane
            });
        }
    }
}
