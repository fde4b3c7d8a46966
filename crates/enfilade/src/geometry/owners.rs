//! Resolves the face numbers that covers store at samples to items, faces and openings.
//!
//! A trait, because large terrain has faces that are in no [`Geometry`]: it computes the owner from the number.

use super::{Geometry, Owner};
use crate::ids::{ItemIndex, OpeningId};

/// Resolves face numbers to owners. Covers call it when they report, once per run of samples with the same owner.
pub trait Owners {
    /// Returns the item and face, or the opening, with this number. `near` is a guess: neighbouring samples often have
    /// the same item.
    fn owner(&self, number: u32, near: Option<Owner>) -> Owner;

    /// Returns the cluster of a face of an item.
    fn cluster_of(&self, item: ItemIndex, face: u32) -> u32;

    /// Returns the number of clusters of an item.
    fn cluster_count(&self, item: ItemIndex) -> u32;

    /// Returns `true` if an item is drawn: its samples are emitted to a canvas.
    fn is_drawn(&self, _item: ItemIndex) -> bool {
        true
    }

    /// Returns `true` if the sector has openings, whose samples must be reported one by one.
    fn has_openings(&self) -> bool;
}

impl Owners for Geometry {
    fn owner(&self, number: u32, near: Option<Owner>) -> Owner {
        let faces = self.first_faces[self.items.len()];
        if number >= faces {
            return Owner::Opening(OpeningId((number - faces) as u16));
        }
        if let Some(Owner::Face(item, _)) = near {
            let [first, end] = [
                self.first_faces[item.0 as usize],
                self.first_faces[item.0 as usize + 1],
            ];
            if (first..end).contains(&number) {
                return Owner::Face(item, number - first);
            }
        }
        // Items without faces have the same first number as the next item; the last of these is the one with faces.
        let item = self.first_faces.partition_point(|&first| first <= number) - 1;
        Owner::Face(ItemIndex(item as u32), number - self.first_faces[item])
    }

    fn cluster_of(&self, item: ItemIndex, face: u32) -> u32 {
        self.mesh_of(item).cluster_of(face) as u32
    }

    fn cluster_count(&self, item: ItemIndex) -> u32 {
        self.mesh_of(item).clusters().len() as u32
    }

    fn is_drawn(&self, item: ItemIndex) -> bool {
        self.item(item).options.is_drawn
    }

    fn has_openings(&self) -> bool {
        !self.openings.list.is_empty()
    }
}
