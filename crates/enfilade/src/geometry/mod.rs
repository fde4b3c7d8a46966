//! The geometry of a sector: meshes, items, materials, textures and openings. All methods share it.

mod baked_cells;
mod builder;
mod edit;
mod item_options;
mod material;
mod names;
mod openings;
mod owners;
mod slots;
#[cfg(feature = "terrain")]
mod terrain;
mod texture;

pub use baked_cells::{BakedCells, BakedCellsError, CellNode, CellSide, CellTree};
pub(crate) use baked_cells::{Leaf, Room};
pub use builder::{GeometryBuilder, GeometryError, ItemLabel};
pub use edit::MovedItem;
pub(crate) use edit::{Changes, Exchanged, Unfit};
pub use item_options::ItemOptions;
pub use material::{Alpha, Material};
#[cfg(feature = "terrain")]
pub(crate) use openings::MAX_OPENINGS;
pub use owners::Owners;
pub use texture::{Filter, Minify, Texture, TextureError, Wrap};

use crate::geom::{Aabb, ConvexPolygon, Octree, Transform};
use crate::ids::{ItemId, ItemIndex, MeshId, OpeningId};
use crate::mesh::{Cluster, Mesh};
use names::Names;
use openings::Openings;
use slots::Slots;
use std::any::Any;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};
#[cfg(feature = "terrain")]
pub use terrain::Terrain;

/// A mesh with a transform: the unit that an engine draws and that [`VisibleSet`](crate::VisibleSet) lists.
#[doc(alias = "instance")]
#[doc(alias = "object")]
#[doc(alias = "renderer")]
#[doc(alias = "entity")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    /// The mesh, shared by all items with the same id.
    pub mesh: MeshId,
    /// Object-to-sector transform: three columns of the linear part, then the translation.
    pub sector_from_item: [[f32; 3]; 4],
    /// AABB in the space of the sector, computed from the mesh's positions or its AABB.
    pub bounds: Aabb,
    /// How the item takes part in looks.
    pub options: ItemOptions,
}

impl Item {
    /// Returns the object-to-sector transform.
    pub fn transform(&self) -> Transform {
        Transform::from_columns(self.sector_from_item)
    }
}

/// A portal polygon: a one-sided convex hole that leads to another sector through a [`Portal`](crate::Portal).
///
/// It is visible from its front only, and is not clipped at the near plane. An eye exactly in its plane counts as in
/// front: inside the outline, the opening covers every direction that leads to the back; outside the outline, it is
/// edge-on. So a camera that crosses a doorway or touches a mirror loses nothing in any frame.
#[doc(alias = "portal polygon")]
#[doc(alias = "window")]
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Opening {
    /// Name for display and lookup.
    pub name: String,
    /// Outline, in the space of the sector. Its front faces the eye that looks through it: counter-clockwise when seen
    /// from this sector.
    pub outline: ConvexPolygon,
}

/// Meshes, items, materials, textures and openings of a sector. Immutable; built by [`GeometryBuilder`].
///
/// A scene edits its own copy: see [`Scene::edit`](crate::Scene::edit).
#[derive(Debug)]
pub struct Geometry {
    meshes: Vec<Arc<Mesh>>,
    materials: Arc<[Material]>,
    textures: Arc<[Arc<Texture>]>,
    items: Vec<Item>,
    /// The key of each item.
    keys: Vec<u64>,
    names: Names,
    /// Items that are never culled, and items that are not drawn; sorted.
    never_culled: Vec<ItemIndex>,
    not_drawn: Vec<ItemIndex>,
    /// Free and used slots, once items were edited.
    slots: Option<Slots>,
    openings: Openings,
    cells: Option<Arc<BakedCells>>,
    /// Height fields whose blocks are some of the items, unless these were changed since.
    #[cfg(feature = "terrain")]
    terrains: Vec<Terrain>,
    /// Octree over the boxes of items; built on first use.
    item_tree: OnceLock<Octree>,
    /// For each item the number of faces before it, and finally the number of all faces.
    first_faces: Vec<u32>,
    bounds: Aabb,
    shared: Mutex<Weak<dyn Any + Send + Sync>>,
}

impl Geometry {
    /// Returns the meshes, by [`MeshId`].
    pub fn meshes(&self) -> &[Arc<Mesh>] {
        &self.meshes
    }

    /// Returns the materials, by [`MaterialId`](crate::MaterialId).
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Returns the textures, by [`TextureId`](crate::TextureId).
    pub fn textures(&self) -> &[Arc<Texture>] {
        &self.textures
    }

    /// Returns the items, by [`ItemIndex`]. Removed items stay in the list with an empty mesh until a new item reuses
    /// their index; test with [`Geometry::holds`].
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// Returns `true` if there is an item with this index that was not removed.
    pub fn holds(&self, item: ItemIndex) -> bool {
        let placed = self.items.get(item.0 as usize);
        placed.is_some_and(|placed| {
            self.slots
                .as_ref()
                .is_none_or(|slots| placed.mesh != slots.nothing)
        })
    }

    /// Returns the index of an item; `None` if it was removed or never existed.
    pub fn index_of(&self, id: ItemId) -> Option<ItemIndex> {
        (self.holds(id.index) && self.id_of(id.index) == id).then_some(id.index)
    }

    /// Returns the id of the item with this index, or of the last one if it was removed.
    pub fn id_of(&self, index: ItemIndex) -> ItemId {
        let generations = self.slots.as_ref().map_or(&[][..], |slots| &slots.generations);
        ItemId {
            index,
            generation: generations.get(index.0 as usize).copied().unwrap_or(0),
        }
    }

    /// Returns the key of an item; see [`GeometryBuilder::set_key`].
    ///
    /// # Panics
    /// If `item` is out of range.
    pub fn key(&self, item: ItemIndex) -> u64 {
        self.keys[item.0 as usize]
    }

    /// Returns the number of items, without removed ones.
    pub fn item_count(&self) -> usize {
        self.items.len() - self.slots.as_ref().map_or(0, |slots| slots.free_items.len())
    }

    /// Returns an item.
    ///
    /// # Panics
    /// If `item` is out of range.
    pub fn item(&self, item: ItemIndex) -> &Item {
        &self.items[item.0 as usize]
    }

    /// Returns the mesh of an item.
    ///
    /// # Panics
    /// If `item` is out of range.
    pub fn mesh_of(&self, item: ItemIndex) -> &Mesh {
        &self.meshes[self.item(item).mesh.0 as usize]
    }

    /// Returns the name of an item: empty if it has none; not necessarily unique.
    ///
    /// # Panics
    /// If `item` is out of range.
    pub fn name(&self, item: ItemIndex) -> &str {
        self.names.get(item.0 as usize)
    }

    /// Returns the openings, by [`OpeningId`].
    pub fn openings(&self) -> &[Opening] {
        &self.openings.list
    }

    /// Returns the baked PVS cells, if any.
    pub fn cells(&self) -> Option<&Arc<BakedCells>> {
        self.cells.as_ref()
    }

    /// Returns the octree over the boxes of items, each in one node; built on first use.
    pub(crate) fn item_tree(&self) -> &Octree {
        self.item_tree.get_or_init(|| {
            let bounds: Vec<Aabb> = self.items.iter().map(|item| item.bounds).collect();
            Octree::build(&bounds, FEW_ITEMS)
        })
    }

    /// Returns the octree over the boxes of openings.
    pub(crate) fn opening_tree(&self) -> &Octree {
        &self.openings.tree
    }

    /// Returns the AABB of all items and openings, in the space of the sector.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns the number of triangles of all items; instances of the same mesh each count.
    pub fn triangle_count(&self) -> u64 {
        self.items
            .iter()
            .map(|item| self.meshes[item.mesh.0 as usize].triangle_count())
            .sum()
    }

    /// Returns the number of faces of all items; instances of the same mesh each count.
    pub fn face_count(&self) -> u64 {
        u64::from(self.first_faces[self.items.len()])
    }

    /// Returns the material of a cluster of an item. If the item is not an occluder, [`Alpha::Opaque`] becomes
    /// [`Alpha::Mask`].
    pub fn material_of(&self, item: ItemIndex, cluster: &Cluster) -> Material {
        let mut material = *self.material(cluster);
        if material.alpha == Alpha::Opaque && !self.item(item).options.is_occluder {
            material.alpha = Alpha::Mask;
        }
        material
    }

    /// Returns the material of a cluster of a mesh.
    pub fn material(&self, cluster: &Cluster) -> &Material {
        if cluster.faces.is_empty() {
            return &Material::OF_BOUNDS;
        }
        &self.materials[cluster.material.0 as usize]
    }

    /// Returns the items that are never culled, sorted.
    pub(crate) fn never_culled(&self) -> &[ItemIndex] {
        &self.never_culled
    }

    /// Returns the items that are not drawn, sorted.
    pub(crate) fn not_drawn(&self) -> &[ItemIndex] {
        &self.not_drawn
    }

    /// Lists the items of special kinds again.
    fn list_kinds(&mut self) {
        self.never_culled.clear();
        self.not_drawn.clear();
        for (index, item) in (0..).map(ItemIndex).zip(&self.items) {
            if item.options.never_cull && !item.bounds.is_empty() {
                self.never_culled.push(index);
            }
            if !item.options.is_drawn {
                self.not_drawn.push(index);
            }
        }
    }

    /// Returns the height fields whose blocks are items.
    #[cfg(feature = "terrain")]
    pub fn terrains(&self) -> &[Terrain] {
        &self.terrains
    }

    /// Returns the memory used, in bytes, without textures. Meshes and cells that several geometries share count in
    /// each.
    pub fn bytes(&self) -> u64 {
        self.meshes.iter().map(|mesh| mesh.bytes()).sum::<u64>()
            + self.item_tree.get().map_or(0, Octree::bytes)
            + self.openings.tree.bytes()
            + self.cells.as_ref().map_or(0, |cells| cells.bytes())
            + (size_of_val(&*self.items)
                + size_of_val(&*self.keys)
                + size_of_val(&*self.first_faces)
                + self.names.bytes()) as u64
    }

    /// Returns the structure that another method built over this geometry and that is still in use; otherwise builds
    /// it.
    pub(crate) fn share<T: Any + Send + Sync>(&self, build: impl FnOnce() -> T) -> Arc<T> {
        let shared = || self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        let found =
            |shared: &Weak<dyn Any + Send + Sync>| shared.upgrade().and_then(|any| any.downcast().ok());
        if let Some(found) = found(&shared()) {
            return found;
        }
        // Built without the lock: a thread that waits for others may run other work of the pool that needs the same
        // lock.
        let built = Arc::new(build());
        let mut shared = shared();
        found(&shared).unwrap_or_else(|| {
            let any: Arc<dyn Any + Send + Sync> = built.clone();
            *shared = Arc::downgrade(&any);
            built
        })
    }

    /// Returns the number of faces of the item that has most.
    pub(crate) fn most_faces(&self) -> u32 {
        let faces = self.first_faces.windows(2).map(|pair| pair[1] - pair[0]);
        faces.max().unwrap_or(0)
    }

    /// Returns the number of an item's first face among all faces of the geometry.
    pub(crate) fn first_face(&self, item: ItemIndex) -> u32 {
        self.first_faces[item.0 as usize]
    }

    /// Returns an opening as an indexed face: its corners, and their start and end.
    pub(crate) fn outline_face(&self, opening: OpeningId) -> (&[u32], &[u32]) {
        self.openings.face(usize::from(opening.0))
    }

    /// Returns the face number of an opening; openings are numbered after all faces.
    pub(crate) fn opening_number(&self, opening: OpeningId) -> u32 {
        self.first_faces[self.items.len()] + u32::from(opening.0)
    }
}

/// Maximum number of items in a leaf of the octree. Testing a box against a cover costs about as much as rasterizing a
/// small item.
const FEW_ITEMS: usize = 6;

/// The owner of a sample: the face or opening that is visible there.
#[doc(alias = "visibility buffer")]
#[doc(alias = "id buffer")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Owner {
    /// A face of an item, by its index in the item's mesh.
    Face(ItemIndex, u32),
    /// An opening, whatever is behind it.
    Opening(OpeningId),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::MaterialId;

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
            builder.mesh(Mesh::new(&[]).expect("an empty mesh")),
            builder.mesh(leaf()),
        ];
        for (name, mesh) in [("a", nothing), ("b", leaf), ("c", nothing), ("d", leaf)] {
            builder.item(name, mesh, Transform::IDENTITY);
        }
        let door = ConvexPolygon::rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).expect("a square");
        builder.opening("door", door);
        let geometry = builder.build().expect("valid geometry");
        let owners: Vec<_> = (0..3).map(|number| geometry.owner(number, None)).collect();
        let expected = [
            Owner::Face(ItemIndex(1), 0),
            Owner::Face(ItemIndex(3), 0),
            Owner::Opening(OpeningId(0)),
        ];
        assert_eq!(owners, expected);
        assert_eq!(geometry.owner(1, Some(owners[0])), owners[1]);
        assert_eq!(
            (geometry.name(ItemIndex(0)), geometry.name(ItemIndex(3))),
            ("a", "d")
        );
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
        assert!(matches!(builder.build(), Err(GeometryError::NotFinite(item)) if item.name == "far"));
    }
}
