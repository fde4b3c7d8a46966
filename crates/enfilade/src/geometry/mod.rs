//! What a sector is made of: items, materials, openings. Methods share it, whatever they build over it.

mod baked_cells;
mod builder;
mod edit;
mod material;
mod names;
mod owners;
mod slots;
mod texture;

pub use baked_cells::{BakedCells, BakedCellsError, CellId, CellNode, CellSide, CellTree};
pub(crate) use baked_cells::{Leaf, Room};
pub(crate) use builder::MAX_OPENINGS;
pub use builder::{GeometryBuilder, GeometryError};
pub use edit::MovedItem;
pub(crate) use edit::{Changes, Exchanged, Placing, Unfit};
pub use material::{Alpha, Material, MaterialId};
pub use owners::Owners;
pub use texture::{Filter, Minify, Texture, TextureError, TextureId, Wrap};

use crate::geom::{Aabb, ConvexPolygon, Octree, Transform};
use crate::mesh::{Cluster, Mesh};
use crate::terrain::Terrain;
use names::Names;
use slots::Slots;
use std::any::Any;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

/// An item of a sector, by its place in [`Geometry::items`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ItemId(pub u32);

/// A mesh of a geometry, by its place in [`Geometry::meshes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MeshId(pub u32);

/// An opening of a sector, by its place in [`Geometry::openings`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OpeningId(pub u16);

/// A mesh at a place: what an engine draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    /// What is placed.
    pub mesh: MeshId,
    /// Three columns of the linear part, then the translation.
    pub sector_from_item: [[f32; 3]; 4],
    /// The smallest box around it that follows from the mesh's box, in the space of the sector.
    pub bounds: Aabb,
    /// Does it hide what is behind it? If not, its opaque faces are as those of a cut-out: seen, and seen past.
    pub is_occluder: bool,
}

impl Item {
    /// The item's place as a transform.
    pub fn transform(&self) -> Transform {
        Transform::from_columns(self.sector_from_item)
    }
}

/// A hole to look through: a face like any other to a method, entered from its front.
///
/// It has no near limit: it is looked through however near it is. An eye exactly in its plane counts as in front: inside
/// the outline it looks through the opening in every direction that leads to the back, outside it sees the opening
/// edge-on. So a camera that crosses a doorway, or touches a mirror, loses nothing in any frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// How people call it.
    pub name: String,
    /// Its outline, in the space of the sector; the front is where one stands before going in.
    pub outline: ConvexPolygon,
}

/// Items, materials and openings of a sector. Immutable; built by [`GeometryBuilder`].
#[derive(Debug)]
pub struct Geometry {
    meshes: Vec<Arc<Mesh>>,
    materials: Arc<[Material]>,
    textures: Arc<[Arc<Texture>]>,
    items: Vec<Item>,
    names: Names,
    /// What is free and what is used, once items were edited.
    slots: Option<Slots>,
    openings: Vec<Opening>,
    cells: Option<Arc<BakedCells>>,
    /// Height fields, of which some items are the blocks, unless those were changed since.
    terrains: Vec<Terrain>,
    /// Over the boxes of items, once it was asked for.
    item_tree: OnceLock<Octree>,
    /// Over the boxes of openings.
    opening_tree: Octree,
    /// 0, 1, 2 … up to the most corners of an opening, and where each ends: an opening as an indexed face.
    outline_corners: Vec<u32>,
    outline_ends: Vec<[u32; 2]>,
    /// The number of each item's first face among all faces of the geometry, then the number of all.
    first_faces: Vec<u32>,
    bounds: Aabb,
    shared: Mutex<Weak<dyn Any + Send + Sync>>,
}

impl Geometry {
    /// The meshes that items are copies of.
    pub fn meshes(&self) -> &[Arc<Mesh>] {
        &self.meshes
    }

    /// What faces are made of.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The images that materials name.
    pub fn textures(&self) -> &[Arc<Texture>] {
        &self.textures
    }

    /// The items, by [`ItemId`]. Those that an edit removed are there still, of an empty mesh, until an item that is added
    /// takes their number.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// Is there an item of this number, and was it not removed?
    pub fn holds(&self, item: ItemId) -> bool {
        let is_free = |slots: &Slots| slots.free_items.contains(&item.0);
        (item.0 as usize) < self.items.len() && !self.slots.as_ref().is_some_and(is_free)
    }

    /// How many items there are, without those that were removed.
    pub fn item_count(&self) -> usize {
        self.items.len() - self.slots.as_ref().map_or(0, |slots| slots.free_items.len())
    }

    /// One item.
    pub fn item(&self, item: ItemId) -> &Item {
        &self.items[item.0 as usize]
    }

    /// The mesh that an item is a copy of.
    pub fn mesh_of(&self, item: ItemId) -> &Mesh {
        &self.meshes[self.item(item).mesh.0 as usize]
    }

    /// An item's name; not always unique, and empty where it has none.
    pub fn name(&self, item: ItemId) -> &str {
        self.names.get(item.0 as usize)
    }

    /// The openings, by [`OpeningId`].
    pub fn openings(&self) -> &[Opening] {
        &self.openings
    }

    /// The cells that were computed ahead, if there are any.
    pub fn cells(&self) -> Option<&Arc<BakedCells>> {
        self.cells.as_ref()
    }

    /// The tree over the boxes of items, each in one node; built when it is first asked for.
    pub(crate) fn item_tree(&self) -> &Octree {
        self.item_tree.get_or_init(|| {
            let bounds: Vec<Aabb> = self.items.iter().map(|item| item.bounds).collect();
            Octree::build(&bounds, FEW_ITEMS)
        })
    }

    /// The tree over the boxes of openings.
    pub(crate) fn opening_tree(&self) -> &Octree {
        &self.opening_tree
    }

    /// The smallest box around all items and openings, in the space of the sector.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Triangles of all items, each copy counted.
    pub fn triangle_count(&self) -> u64 {
        self.items
            .iter()
            .map(|item| self.meshes[item.mesh.0 as usize].triangle_count())
            .sum()
    }

    /// Faces of all items, each copy counted.
    pub fn face_count(&self) -> u64 {
        u64::from(self.first_faces[self.items.len()])
    }

    /// What a cluster of an item is made of, which is no longer opaque where the item does not hide.
    pub fn material_of(&self, item: ItemId, cluster: &Cluster) -> Material {
        let mut material = self.materials[cluster.material.0 as usize];
        if material.alpha == Alpha::Opaque && !self.item(item).is_occluder {
            material.alpha = Alpha::Mask;
        }
        material
    }

    /// What a cluster of a mesh is made of.
    pub fn material(&self, cluster: &Cluster) -> &Material {
        &self.materials[cluster.material.0 as usize]
    }

    pub(crate) fn terrains(&self) -> &[Terrain] {
        &self.terrains
    }

    /// Memory in bytes, without textures; meshes and cells that other geometries share are counted in each.
    pub fn bytes(&self) -> u64 {
        self.meshes.iter().map(|mesh| mesh.bytes()).sum::<u64>()
            + self.item_tree.get().map_or(0, Octree::bytes)
            + self.opening_tree.bytes()
            + self.cells.as_ref().map_or(0, |cells| cells.bytes())
            + (size_of_val(&*self.items) + size_of_val(&*self.first_faces) + self.names.bytes()) as u64
    }

    /// What was built over it, by one who needs the same, and still is in use; else builds it.
    pub(crate) fn share<T: Any + Send + Sync>(&self, build: impl FnOnce() -> T) -> Arc<T> {
        let shared = || self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        let found =
            |shared: &Weak<dyn Any + Send + Sync>| shared.upgrade().and_then(|any| any.downcast().ok());
        if let Some(found) = found(&shared()) {
            return found;
        }
        // Not under the lock: a thread that waits for others to build may be given work meanwhile that asks for the same.
        let built = Arc::new(build());
        let mut shared = shared();
        found(&shared).unwrap_or_else(|| {
            let any: Arc<dyn Any + Send + Sync> = built.clone();
            *shared = Arc::downgrade(&any);
            built
        })
    }

    /// The number of an item's first face among all faces of the geometry.
    pub(crate) fn first_face(&self, item: ItemId) -> u32 {
        self.first_faces[item.0 as usize]
    }

    /// An opening as an indexed face: its corners, and where they begin and end.
    pub(crate) fn outline_face(&self, opening: OpeningId) -> (&[u32], &[u32]) {
        let ends = &self.outline_ends[usize::from(opening.0)];
        (&self.outline_corners[..ends[1] as usize], ends)
    }

    /// The number that stands for an opening where faces are numbered through.
    pub(crate) fn opening_number(&self, opening: OpeningId) -> u32 {
        self.first_faces[self.items.len()] + u32::from(opening.0)
    }
}

/// Items in a leaf of the tree over them, at most. To hold a box against a cover costs about as much as a small item's
/// faces.
const FEW_ITEMS: usize = 6;

/// What is seen at a sample of a sector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Owner {
    /// A face of an item.
    Face(ItemId, u32),
    /// An opening, whatever is behind it.
    Opening(OpeningId),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leaf() -> Mesh {
        Mesh::triangles(
            &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            &[0, 1, 2],
            MaterialId(0),
        )
        .expect("a triangle")
    }

    #[test]
    fn every_face_number_leads_back_to_its_item_past_items_without_faces() {
        let mut builder = GeometryBuilder::new([Material::opaque([1.0; 3])]);
        let [nothing, leaf] = [
            builder.mesh(Mesh::new(&[]).expect("nothing")),
            builder.mesh(leaf()),
        ];
        for (name, mesh) in [("a", nothing), ("b", leaf), ("c", nothing), ("d", leaf)] {
            builder.item(name, mesh, Transform::IDENTITY);
        }
        let door = ConvexPolygon::rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).expect("a square");
        builder.opening("door", door);
        let geometry = builder.build().expect("a sound geometry");
        let owners: Vec<_> = (0..3).map(|number| geometry.owner(number, None)).collect();
        let expected = [
            Owner::Face(ItemId(1), 0),
            Owner::Face(ItemId(3), 0),
            Owner::Opening(OpeningId(0)),
        ];
        assert_eq!(owners, expected);
        assert_eq!(geometry.owner(1, Some(owners[0])), owners[1]);
        assert_eq!((geometry.name(ItemId(0)), geometry.name(ItemId(3))), ("a", "d"));
    }

    #[test]
    fn an_item_is_small() {
        assert!(size_of::<Item>() + 2 * size_of::<u32>() <= 100);
    }

    #[test]
    fn each_broken_rule_has_its_own_error() {
        let mut builder = GeometryBuilder::new([]);
        builder.mesh(leaf());
        assert!(matches!(
            builder.clone().build(),
            Err(GeometryError::NoSuchMaterial { .. })
        ));
        let mut builder = GeometryBuilder::new([Material::opaque([1.0; 3])]);
        builder.item("ghost", MeshId(3), Transform::IDENTITY);
        assert!(matches!(
            builder.build(),
            Err(GeometryError::NoSuchMesh { mesh: 3, .. })
        ));
        let mut builder = GeometryBuilder::new([Material::opaque([1.0; 3])]);
        let mesh = builder.mesh(leaf());
        builder.item("far", mesh, Transform::translation([f32::INFINITY, 0.0, 0.0]));
        assert!(matches!(builder.build(), Err(GeometryError::NotFinite(name)) if name == "far"));
    }
}
