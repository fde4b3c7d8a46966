//! The openings of a geometry, by id and by place, and as indexed faces.

use super::Opening;
use crate::geom::{Aabb, Octree};

pub(crate) const MAX_OPENINGS: usize = 60_000;

/// Maximum number of openings in a leaf of the octree; a leaf yields its openings in order of their ids.
const FEW_OPENINGS: usize = 16;

/// The openings of a geometry.
#[derive(Clone, Debug)]
pub(super) struct Openings {
    pub(super) list: Vec<Opening>,
    /// Octree over their boxes.
    pub(super) tree: Octree,
    /// 0, 1, 2 … up to the maximum number of corners, and the end of each opening: openings as indexed faces.
    corners: Vec<u32>,
    ends: Vec<[u32; 2]>,
}

impl Openings {
    pub(super) fn new(list: Vec<Opening>) -> Openings {
        let boxes: Vec<Aabb> = list.iter().map(|opening| opening.outline.bounds()).collect();
        let ends: Vec<[u32; 2]> = list
            .iter()
            .map(|opening| [0, opening.outline.corners().len() as u32])
            .collect();
        Openings {
            tree: Octree::build(&boxes, FEW_OPENINGS),
            corners: (0..ends.iter().map(|ends| ends[1]).max().unwrap_or(0)).collect(),
            ends,
            list,
        }
    }

    /// Returns an opening as an indexed face: its corners, and their start and end.
    pub(super) fn face(&self, opening: usize) -> (&[u32], &[u32]) {
        let ends = &self.ends[opening];
        (&self.corners[..ends[1] as usize], ends)
    }

    /// Returns the AABB of all of them.
    pub(super) fn bounds(&self) -> Aabb {
        self.tree
            .root()
            .map_or(Aabb::EMPTY, |root| *self.tree.bounds(root))
    }
}
