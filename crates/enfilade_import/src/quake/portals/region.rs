//! The convex part of the world that a node of the tree divides.
//!
//! Kept are the planes that bound it and what of each does so: a plane of which nothing is left is dropped, so that a node
//! costs as much as its part of the world has sides, however deep it stands.

use super::polygon::{Corner, Side, sides_of};
use glam::DVec3;

/// A convex part of the world.
#[derive(Clone, Debug)]
pub(super) struct Region {
    faces: Vec<Face>,
}

#[derive(Clone, Debug)]
struct Face {
    /// It looks into the region.
    side: Side,
    corners: Vec<Corner>,
}

impl Region {
    /// A box, from its least to its greatest corner.
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

    /// What of a plane is in the region; empty where it is all on one side.
    pub(super) fn across(&self, side: &Side) -> Vec<Corner> {
        let sheet = side.sheet();
        self.faces
            .iter()
            .fold(sheet, |corners, face| cut(&face.side, corners))
    }

    /// The part on one side of a plane, of which `across` is in the region.
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

    /// Nothing is in it.
    pub(super) fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Bytes of memory that it takes.
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
