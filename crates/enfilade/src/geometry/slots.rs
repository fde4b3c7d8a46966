//! Free ids of items and meshes, and use counts of meshes.
//!
//! Ids of removed items and unused meshes are reused, lowest first, so lists that are indexed by them stay short, and
//! the next id does not depend on the order of removals.

use super::Item;
use crate::ids::MeshId;
use crate::mesh::Mesh;
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Free ids of items and meshes, and use counts of meshes.
#[derive(Clone, Debug)]
pub(super) struct Slots {
    /// Indices of removed items.
    pub(super) free_items: BTreeSet<u32>,
    /// For each item its generation; 0 beyond the end.
    pub(super) generations: Vec<u32>,
    /// The highest generation so far.
    pub(super) last_generation: u32,
    free_meshes: BTreeSet<u32>,
    /// For each mesh the number of items that use it.
    uses: Vec<u32>,
    /// Mesh ids by address. An address stays unique as long as the mesh is in its slot.
    places: HashMap<usize, MeshId>,
    /// The empty mesh, used by removed items and in the slots of unused meshes.
    pub(super) nothing: MeshId,
}

impl Slots {
    pub(super) fn new(meshes: &mut Vec<Arc<Mesh>>, items: &[Item]) -> Slots {
        let nothing = MeshId(meshes.len() as u32);
        meshes.push(Arc::new(Mesh::nothing()));
        let mut uses = vec![0; meshes.len()];
        for item in items {
            uses[item.mesh.0 as usize] += 1;
        }
        // If a mesh is in two slots, the first counts.
        let mut places = HashMap::new();
        for (place, mesh) in (0..).zip(&*meshes) {
            places.entry(address(mesh)).or_insert(MeshId(place));
        }
        Slots {
            free_items: BTreeSet::new(),
            generations: vec![0; items.len()],
            last_generation: 0,
            free_meshes: BTreeSet::new(),
            uses,
            places,
            nothing,
        }
    }

    /// Adds a use of a mesh; returns its id, and whether it was added to the list.
    pub(super) fn take(&mut self, mesh: &Arc<Mesh>, meshes: &mut Vec<Arc<Mesh>>) -> (MeshId, bool) {
        let known = self.places.get(&address(mesh)).copied();
        let place = known.unwrap_or_else(|| {
            let place = self.free_meshes.pop_first().map(MeshId);
            if let Some(place) = place {
                meshes[place.0 as usize] = Arc::clone(mesh);
                return place;
            }
            meshes.push(Arc::clone(mesh));
            self.uses.push(0);
            MeshId(meshes.len() as u32 - 1)
        });
        self.places.insert(address(mesh), place);
        self.uses[place.0 as usize] += 1;
        (place, known.is_none())
    }

    /// Removes a use of a mesh.
    pub(super) fn give_back(&mut self, mesh: MeshId) {
        self.uses[mesh.0 as usize] -= 1;
    }

    /// Frees the slot of a mesh if no item uses it; returns `true` if it did.
    pub(super) fn drop_unused(&mut self, mesh: MeshId, meshes: &mut [Arc<Mesh>]) -> bool {
        let place = mesh.0 as usize;
        if self.uses[place] > 0 || mesh == self.nothing || !self.free_meshes.insert(mesh.0) {
            return false;
        }
        let address = address(&meshes[place]);
        if self.places.get(&address) == Some(&mesh) {
            self.places.remove(&address);
        }
        meshes[place] = Arc::clone(&meshes[self.nothing.0 as usize]);
        true
    }
}

fn address(mesh: &Arc<Mesh>) -> usize {
    Arc::as_ptr(mesh).addr()
}
