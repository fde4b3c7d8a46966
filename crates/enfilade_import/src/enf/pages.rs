//! Groups meshes into pages: octree subtrees of the places where items have them.

use crate::Import;
use enfilade::{Aabb, ItemIndex, Material, Mesh};
use std::collections::HashMap;
use std::sync::Arc;

/// Maximum size of a page of several meshes, in bytes; most have a third of it. Large enough to read at disk speed, small against any
/// memory budget. A quarter of it loads less beside what is visible, but more often late.
const PAGE_BYTES: u64 = 1 << 20;

/// The meshes of a scene, each once, with the meshes of each room by their index.
pub(super) struct Meshes<'a> {
    pub(super) list: Vec<PagedMesh<'a>>,
    pub(super) of_rooms: Vec<Vec<u32>>,
    /// The meshes of each page.
    pub(super) pages: Vec<Vec<u32>>,
}

/// A mesh, and the materials of the first room that has it.
#[derive(Clone, Copy)]
pub(super) struct PagedMesh<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) materials: &'a [Material],
}

/// A mesh that has no page yet.
#[derive(Clone, Copy)]
struct UnpagedMesh {
    mesh: u32,
    bytes: u64,
    centre: [f32; 3],
}

impl Meshes<'_> {
    /// Lists the meshes of all rooms. A mesh is where its first item is.
    pub(super) fn of(import: &Import) -> Meshes<'_> {
        let mut meshes = Meshes {
            list: Vec::new(),
            of_rooms: Vec::new(),
            pages: Vec::new(),
        };
        let mut known = HashMap::new();
        for room in &import.rooms {
            let geometry = &room.geometry;
            let mut new = Vec::new();
            let mut new_of = vec![None; geometry.meshes().len()];
            let mut of_room = Vec::with_capacity(geometry.meshes().len());
            for (id, mesh) in geometry.meshes().iter().enumerate() {
                let index = *known.entry(Arc::as_ptr(mesh)).or_insert_with(|| {
                    new_of[id] = Some(new.len());
                    let index = meshes.list.len() as u32;
                    let materials = geometry.materials();
                    meshes.list.push(PagedMesh { mesh, materials });
                    new.push(UnpagedMesh {
                        mesh: index,
                        bytes: estimated_bytes(mesh),
                        centre: mesh.bounds().center(),
                    });
                    index
                });
                of_room.push(index);
            }
            meshes.of_rooms.push(of_room);
            for item in (0..geometry.items().len() as u32).rev() {
                let item = geometry.item(ItemIndex(item));
                if let Some(new_mesh) = new_of[item.mesh.0 as usize] {
                    new[new_mesh].centre = item.bounds.center();
                }
            }
            split(&mut new, &mut meshes.pages);
        }
        meshes
    }
}

/// Estimates the bytes of a mesh in a file, from what cannot change.
fn estimated_bytes(mesh: &Mesh) -> u64 {
    24 * mesh.positions().len() as u64 + 15 * u64::from(mesh.face_count())
}

/// Splits meshes into pages by octants.
fn split(meshes: &mut [UnpagedMesh], pages: &mut Vec<Vec<u32>>) {
    let bytes: u64 = meshes.iter().map(|mesh| mesh.bytes).sum();
    if meshes.len() <= 1 || bytes <= PAGE_BYTES {
        if !meshes.is_empty() {
            pages.push(meshes.iter().map(|mesh| mesh.mesh).collect());
        }
        return;
    }
    let bounds = Aabb::of(meshes.iter().map(|mesh| mesh.centre));
    let middle = bounds.center();
    let octant = |mesh: &UnpagedMesh| {
        (0..3).fold(0, |octant, axis| {
            octant << 1 | u8::from(mesh.centre[axis] > middle[axis])
        })
    };
    meshes.sort_by_key(octant);
    let before = pages.len();
    let mut rest = meshes;
    while let Some(first) = rest.first().map(octant) {
        let count = rest.partition_point(|mesh| octant(mesh) <= first);
        let count = if count == rest.len() && pages.len() == before {
            // All are at one place.
            count / 2
        } else {
            count
        };
        let (now, later) = rest.split_at_mut(count);
        split(now, pages);
        rest = later;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_meshes_share_pages_of_limited_size_and_none_is_lost() {
        let mut random = fastrand::Rng::with_seed(4);
        let mut meshes: Vec<UnpagedMesh> = (0..3000)
            .map(|mesh| UnpagedMesh {
                mesh,
                bytes: random.u64(..PAGE_BYTES / 3),
                // A third of them are at one place.
                centre: if mesh % 3 == 0 {
                    [9.0; 3]
                } else {
                    [0; 3].map(|_: u8| random.f32())
                },
            })
            .collect();
        let sizes: Vec<u64> = meshes.iter().map(|mesh| mesh.bytes).collect();
        let mut pages = Vec::new();
        split(&mut meshes, &mut pages);
        let full = |page: &Vec<u32>| page.iter().map(|&mesh| sizes[mesh as usize]).sum::<u64>();
        assert!(pages.iter().all(|page| full(page) <= PAGE_BYTES));
        assert!(pages.len() < 3000 / 2, "{}", pages.len());
        let mut all = pages.concat();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..3000));
    }
}
