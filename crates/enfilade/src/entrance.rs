//! Where sight enters a sector: the outline of the last opening, in the sector's own space.

use crate::geom::{Aabb, ConvexPolygon, Transform};
use glam::DVec3;

/// Corners that are kept. Passages are many; of an outline of more, the box around it is.
const MAX_CORNERS: usize = 8;

/// The outline of the last opening on the way, or a box around it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entrance {
    corners: [DVec3; MAX_CORNERS],
    count: usize,
    is_outline: bool,
}

impl Entrance {
    /// That of an opening, seen from where it leads.
    pub(crate) fn new(outline: &ConvexPolygon, there_from_here: &Transform) -> Entrance {
        let there = |&corner: &[f32; 3]| DVec3::from(there_from_here.point_f64(corner));
        let mut corners = [DVec3::ZERO; MAX_CORNERS];
        let known = outline.corners();
        if known.len() <= MAX_CORNERS {
            for (corner, known) in corners.iter_mut().zip(known) {
                *corner = there(known);
            }
            return Entrance {
                corners,
                count: known.len(),
                is_outline: true,
            };
        }
        let around: [[f32; 3]; 8] = Aabb::of(known.iter().copied()).corners();
        Entrance {
            corners: around.map(|corner| there(&corner)),
            count: MAX_CORNERS,
            is_outline: false,
        }
    }

    /// Points that hold all of it between them.
    pub(crate) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// The triangles that the outline is made of, as it is drawn; `None` where it had too many corners.
    pub(crate) fn triangles(&self) -> Option<impl Iterator<Item = [DVec3; 3]>> {
        let corners = self.corners();
        let pairs = corners[1..].windows(2);
        self.is_outline
            .then(|| pairs.map(move |pair| [corners[0], pair[0], pair[1]]))
    }
}
