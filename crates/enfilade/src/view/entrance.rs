//! The entrance of a passage: the outline of its last opening, in the space of its sector.

use crate::geom::{Aabb, ConvexPolygon, Transform};
use glam::DVec3;

/// Maximum number of corners stored, because passages are many; a larger outline is replaced by its AABB.
const MAX_CORNERS: usize = 8;

/// The outline of the last opening of a passage, or its AABB.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entrance {
    corners: [DVec3; MAX_CORNERS],
    count: usize,
    is_outline: bool,
}

impl Entrance {
    /// Returns the outline of an opening, transformed to the sector behind it.
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

    /// Returns the corners; their convex hull contains the whole outline.
    pub(crate) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// Returns the outline as a triangle fan, as it is rasterized; `None` if it has more than 8 corners.
    pub(crate) fn triangles(&self) -> Option<impl Iterator<Item = [DVec3; 3]>> {
        let corners = self.corners();
        let pairs = corners[1..].windows(2);
        self.is_outline
            .then(|| pairs.map(move |pair| [corners[0], pair[0], pair[1]]))
    }
}
