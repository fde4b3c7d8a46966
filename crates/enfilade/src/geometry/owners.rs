//! Whom the faces of a sector belong to, by the numbers that covers keep at samples.

use super::{Geometry, ItemId, OpeningId, Owner};

/// What covers ask when they report: rarely, once for a run of samples that one face owns.
pub trait Owners {
    /// The item and face, or the opening, that a number stands for. `near` is a guess: neighbours often agree.
    fn owner(&self, number: u32, near: Option<Owner>) -> Owner;

    /// The cluster of a face of an item.
    fn cluster_of(&self, item: ItemId, face: u32) -> u32;

    /// How many clusters an item has.
    fn cluster_count(&self, item: ItemId) -> u32;

    /// Are there openings, whose samples are wanted one by one?
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
        // Items without faces share their number with the next; the last of them is the one that has faces.
        let item = self.first_faces.partition_point(|&first| first <= number) - 1;
        Owner::Face(ItemId(item as u32), number - self.first_faces[item])
    }

    fn cluster_of(&self, item: ItemId, face: u32) -> u32 {
        self.mesh_of(item).cluster_of(face) as u32
    }

    fn cluster_count(&self, item: ItemId) -> u32 {
        self.mesh_of(item).clusters().len() as u32
    }

    fn has_openings(&self) -> bool {
        !self.openings.is_empty()
    }
}
