//! The convex region of a node: the part of the world that it splits.
//!
//! A region stores its bounding planes, each with its face polygon. Planes without a remaining face are dropped, so a
//! node costs as much as its region has faces, however deep it is in the tree.

use super::polygon::{Corner, Side, sides_of};
use glam::DVec3;

/// A convex part of the world.
#[derive(Clone, Debug)]
pub(super) struct Region {
    faces: Vec<Face>,
}

#[derive(Clone, Debug)]
struct Face {
    /// Its front points into the region.
    side: Side,
    corners: Vec<Corner>,
}

impl Region {
    /// Creates a box from its minimum and maximum corner.
    pub(super) fn of_box(corners: [DVec3; 2]) -> Region {
        let sides = sides_of(corners);
        let faces = sides.iter().map(|&side| Face {
            side,
            corners: sides
                .iter()
                .fold(side.sheet(), |corners, other| cut(other, corners)),
        });
        Region {
            faces: faces.collect(),
        }
    }

    /// Returns the cross-section of the region with a plane; empty if the region is on one side of it.
    pub(super) fn across(&self, side: &Side) -> Vec<Corner> {
        let sheet = side.sheet();
        self.faces
            .iter()
            .fold(sheet, |corners, face| cut(&face.side, corners))
    }

    /// Returns the part of the region on one side of a plane, whose cross-section is `across`.
    pub(super) fn part(&self, side: &Side, across: &[Corner]) -> Region {
        let kept = self.faces.iter().filter_map(|face| {
            let corners = cut(side, face.corners.clone());
            (!corners.is_empty()).then_some(Face {
                side: face.side,
                corners,
            })
        });
        let mut faces: Vec<Face> = kept.collect();
        if !across.is_empty() {
            faces.push(Face {
                side: *side,
                corners: across.to_vec(),
            });
        }
        Region { faces }
    }

    /// Returns `true` if the region has no faces.
    pub(super) fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Returns its size in memory, in bytes.
    pub(super) fn bytes(&self) -> u64 {
        let faces = self.faces.iter().map(|face| {
            let corners = face.corners.len() * size_of::<Corner>();
            (corners + size_of::<Face>()) as u64
        });
        faces.sum()
    }
}

fn cut(side: &Side, corners: Vec<Corner>) -> Vec<Corner> {
    if corners.is_empty() {
        return corners;
    }
    side.cut(corners)
}
