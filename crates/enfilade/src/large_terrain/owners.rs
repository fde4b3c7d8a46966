//! Face ids of large terrain: each block has the same number of ids; openings follow after all blocks.

use super::{BLOCK_FACES, LargeTerrain, SQUARE_FACES};
use crate::geometry::{Owner, Owners};
use crate::ids::{ItemIndex, OpeningId};

impl LargeTerrain {
    /// Returns the id of the first opening, after all face ids.
    pub(crate) fn first_opening(&self) -> u32 {
        let [columns, rows] = self.blocks();
        columns * rows * BLOCK_FACES
    }

    /// Returns the index of a cluster's first face in its block.
    pub(crate) fn first_face_in(&self, cluster: u32) -> u32 {
        cluster * SQUARE_FACES
    }
}

impl Owners for LargeTerrain {
    fn owner(&self, number: u32, _near: Option<Owner>) -> Owner {
        match number.checked_sub(self.first_opening()) {
            Some(opening) => Owner::Opening(OpeningId(opening as u16)),
            None => Owner::Face(ItemIndex(number / BLOCK_FACES), number % BLOCK_FACES),
        }
    }

    fn cluster_of(&self, _item: ItemIndex, face: u32) -> u32 {
        face / SQUARE_FACES
    }

    fn cluster_count(&self, item: ItemIndex) -> u32 {
        self.squares(self.block_at(item)).iter().product()
    }

    fn has_openings(&self) -> bool {
        self.holes.has_openings()
    }
}
