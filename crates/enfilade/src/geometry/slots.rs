//! Which numbers of items and meshes are free, and how often each mesh is used.

use super::{Item, MeshId};
use crate::mesh::Mesh;
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Which numbers of items and meshes are free, and how often each mesh is used.
#[derive(Clone, Debug)]
pub(super) struct Slots {
    /// Items that were removed.
    pub(super) free_items: BTreeSet<u32>,
    free_meshes: BTreeSet<u32>,
    /// How many items are copies of each mesh.
    uses: Vec<u32>,
    /// Where a mesh stands, by its address: as long as it stands there, no other can have it.
    places: HashMap<usize, MeshId>,
    /// The mesh of items that were removed; it stands in place of meshes that are gone, too.
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
        // Of a mesh that stands in two places, the first counts.
        let mut places = HashMap::new();
        for (place, mesh) in (0..).zip(&*meshes) {
            places.entry(address(mesh)).or_insert(MeshId(place));
        }
        Slots {
            free_items: BTreeSet::new(),
            free_meshes: BTreeSet::new(),
            uses,
            places,
            nothing,
        }
    }

    /// The place of a mesh that one more item is a copy of, and whether it was not there before.
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

    /// One item fewer is a copy of a mesh.
    pub(super) fn give_back(&mut self, mesh: MeshId) {
        self.uses[mesh.0 as usize] -= 1;
    }

    /// Lets go of a mesh that no item is a copy of any more; says whether it did.
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
