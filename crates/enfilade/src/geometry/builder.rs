//! Builds a geometry and checks it.

use super::names::Names;
use super::openings::{MAX_OPENINGS, Openings};
#[cfg(feature = "terrain")]
use super::terrain::Terrain;
use super::{BakedCells, Geometry, Item, ItemOptions, Material, Opening, Texture};
use crate::geom::{Aabb, ConvexPolygon, MAX_COORDINATE, Transform, is_in_range};
use crate::ids::{ItemId, ItemIndex, MeshId, OpeningId};
use crate::mesh::Mesh;
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, Weak};
use thiserror::Error;

/// Collects the meshes, items, materials and openings of a sector; [`GeometryBuilder::build`] checks them.
#[derive(Clone, Debug, Default)]
pub struct GeometryBuilder {
    meshes: Vec<Arc<Mesh>>,
    materials: Arc<[Material]>,
    textures: Arc<[Arc<Texture>]>,
    items: Vec<NewItem>,
    names: Names,
    openings: Vec<Opening>,
    cells: Option<Arc<BakedCells>>,
    #[cfg(feature = "terrain")]
    pub(crate) terrains: Vec<Terrain>,
}

/// An item that is not checked yet.
#[derive(Clone, Debug)]
struct NewItem {
    mesh: MeshId,
    sector_from_item: Transform,
    key: u64,
    options: ItemOptions,
}

impl GeometryBuilder {
    /// Creates a builder with a table of materials; several sectors may share the table.
    pub fn new(materials: impl Into<Arc<[Material]>>) -> GeometryBuilder {
        GeometryBuilder {
            materials: materials.into(),
            ..GeometryBuilder::default()
        }
    }

    /// Sets the textures that the materials refer to; several sectors may share them. Default: none.
    pub fn textures(&mut self, textures: impl Into<Arc<[Arc<Texture>]>>) {
        self.textures = textures.into();
    }

    /// Adds a mesh, to be used by any number of items.
    pub fn mesh(&mut self, mesh: impl Into<Arc<Mesh>>) -> MeshId {
        self.meshes.push(mesh.into());
        MeshId(self.meshes.len() as u32 - 1)
    }

    /// Adds an item: a mesh with an object-to-sector transform. Names need not be unique.
    #[doc(alias = "instance")]
    pub fn item(&mut self, name: &str, mesh: MeshId, sector_from_item: Transform) -> ItemId {
        let index = ItemIndex(self.items.len() as u32);
        self.items.push(NewItem {
            mesh,
            sector_from_item,
            key: u64::from(index.0),
            options: ItemOptions::default(),
        });
        self.names.push(name);
        index.into()
    }

    /// Sets the key of an item: any number by which the caller knows it, such as an entity id. Keys need not be unique.
    /// Default: the item's index. Ignores an item that does not exist.
    ///
    /// Visible sets, hits and errors report it; see [`VisibleItem::key`](crate::VisibleItem::key).
    #[doc(alias = "user data")]
    pub fn set_key(&mut self, item: ItemId, key: u64) {
        if let Some(item) = self.items.get_mut(item.index.0 as usize) {
            item.key = key;
        }
    }

    /// Sets how an item takes part in looks. Ignores an item that does not exist.
    pub fn set_options(&mut self, item: ItemId, options: ItemOptions) {
        if let Some(item) = self.items.get_mut(item.index.0 as usize) {
            item.options = options;
        }
    }

    /// Returns the mesh of an item; `None` if there is no such item or mesh.
    #[cfg(feature = "terrain")]
    pub(super) fn mesh_of_item(&self, item: u32) -> Option<(MeshId, &Mesh)> {
        let mesh = self.items.get(item as usize)?.mesh;
        Some((mesh, self.meshes.get(mesh.0 as usize)?))
    }

    /// Adds an opening, visible from its front, the side from which its corners are counter-clockwise. Leave a hole in the
    /// wall there. Without an open portal it is an opaque face. [`SceneBuilder`](crate::SceneBuilder) connects it to another sector by a door or a portal.
    pub fn opening(&mut self, name: &str, outline: ConvexPolygon) -> OpeningId {
        self.openings.push(Opening {
            name: name.to_owned(),
            outline,
        });
        OpeningId(self.openings.len().min(usize::from(u16::MAX)) as u16 - 1)
    }

    /// Sets baked PVS cells, required by [`Method::Pvs`](crate::Method::Pvs).
    ///
    /// The cells that an item is in are computed from its faces. An item is visible as a whole or not at all, so split
    /// walls into items that cover one or a few cells.
    #[doc(alias = "PVS")]
    pub fn cells(&mut self, cells: impl Into<Arc<BakedCells>>) {
        self.cells = Some(cells.into());
    }

    /// Checks the geometry and builds it.
    ///
    /// # Errors
    /// Returns the [`GeometryError`] of the first invalid element.
    pub fn build(self) -> Result<Geometry, GeometryError> {
        let GeometryBuilder {
            meshes,
            materials,
            textures,
            items: placed,
            names,
            openings,
            cells,
            #[cfg(feature = "terrain")]
            terrains,
        } = self;
        for (mesh, built) in meshes.iter().enumerate() {
            if let Some(cluster) = built
                .clusters()
                .iter()
                .find(|c| !c.faces.is_empty() && c.material.0 as usize >= materials.len())
            {
                let material = cluster.material.0;
                return Err(GeometryError::NoSuchMaterial {
                    mesh,
                    material,
                    materials: materials.len(),
                });
            }
        }
        for (material, named) in materials.iter().enumerate() {
            if let Some(texture) = named.textures().find(|t| t.0 as usize >= textures.len()) {
                return Err(GeometryError::NoSuchTexture {
                    material,
                    texture: texture.0,
                    textures: textures.len(),
                });
            }
        }
        if openings.len() > MAX_OPENINGS {
            return Err(GeometryError::TooManyOpenings(openings.len()));
        }
        let mut items = Vec::with_capacity(placed.len());
        let mut keys = Vec::with_capacity(placed.len());
        let mut first_faces = Vec::with_capacity(placed.len() + 1);
        let mut faces = 0_u64;
        let openings = Openings::new(openings);
        let mut bounds = openings.bounds();
        for (number, item) in placed.into_iter().enumerate() {
            let NewItem {
                mesh,
                sector_from_item: transform,
                key,
                options,
            } = item;
            let label = || ItemLabel {
                name: names.get(number).to_owned(),
                key,
            };
            let built = meshes
                .get(mesh.0 as usize)
                .ok_or_else(|| GeometryError::NoSuchMesh {
                    item: label(),
                    mesh: mesh.0,
                    meshes: meshes.len(),
                })?;
            let sector_from_item = transform.columns();
            let held = placed_bounds(&Transform::from_columns(sector_from_item), built);
            if sector_from_item.iter().flatten().any(|v| !v.is_finite())
                || !(held.is_empty() || (held.min.iter().chain(&held.max)).all(|v| v.is_finite()))
            {
                return Err(GeometryError::NotFinite(label()));
            }
            if !(sector_from_item.iter().flatten().all(|&v| is_in_range(v)) && held.is_in_range()) {
                return Err(GeometryError::TooFar(label()));
            }
            bounds = bounds.union(&held);
            items.push(Item {
                mesh,
                sector_from_item,
                bounds: held,
                options,
            });
            keys.push(key);
            first_faces.push(faces as u32);
            faces += u64::from(built.face_count());
        }
        if faces > u64::from(u32::MAX) - MAX_OPENINGS as u64 {
            return Err(GeometryError::TooManyFaces(faces));
        }
        first_faces.push(faces as u32);
        let mut geometry = Geometry {
            meshes,
            materials,
            textures,
            items,
            keys,
            names,
            never_culled: Vec::new(),
            not_drawn: Vec::new(),
            slots: None,
            openings,
            cells,
            #[cfg(feature = "terrain")]
            terrains,
            item_tree: OnceLock::new(),
            first_faces,
            bounds,
            shared: Mutex::new(Weak::<()>::new()),
        };
        geometry.list_kinds();
        Ok(geometry)
    }
}

/// Returns the AABB of a transformed mesh: for up to 64 positions from the positions, which is tighter; otherwise from
/// the corners of the mesh's AABB.
pub(super) fn placed_bounds(transform: &Transform, mesh: &Mesh) -> Aabb {
    const FEW: usize = 64;
    if mesh.bounds().is_empty() {
        Aabb::EMPTY
    } else if (1..=FEW).contains(&mesh.positions().len()) {
        transform.box_of(mesh.positions())
    } else {
        transform.box_of(&mesh.bounds().corners())
    }
}

/// An item as errors name it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ItemLabel {
    /// Its name; may be empty.
    pub name: String,
    /// Its key; see [`GeometryBuilder::set_key`].
    pub key: u64,
}

impl fmt::Display for ItemLabel {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "`{}` (key {})", self.name, self.key)
    }
}

/// Why a geometry is invalid; returned by [`GeometryBuilder::build`].
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// An item refers to a mesh that does not exist.
    #[error("item {item} uses mesh {mesh}, but there are only {meshes}")]
    NoSuchMesh {
        /// The item.
        item: ItemLabel,
        /// Mesh id.
        mesh: u32,
        /// Number of meshes.
        meshes: usize,
    },
    /// A cluster refers to a material that does not exist.
    #[error("mesh {mesh} uses material {material}, but the number of materials is {materials}")]
    NoSuchMaterial {
        /// Mesh id.
        mesh: usize,
        /// Material id.
        material: u32,
        /// Number of materials.
        materials: usize,
    },
    /// A material refers to a texture that does not exist.
    #[error("material {material} uses texture {texture}, but there are only {textures}")]
    NoSuchTexture {
        /// Material id.
        material: usize,
        /// Texture id.
        texture: u32,
        /// Number of textures.
        textures: usize,
    },
    /// A transform is NaN or infinite.
    #[error("the transform of item {0} is not finite")]
    NotFinite(ItemLabel),
    /// An item, or its transform, extends beyond [`MAX_COORDINATE`].
    #[error(
        "item {0} reaches farther out than {MAX_COORDINATE:e} units; scale the scene down or move it to the origin"
    )]
    TooFar(ItemLabel),
    /// The sector has too many faces; faces have 32-bit numbers.
    #[error("{0} faces in one sector; split it into sectors of fewer than 4 billion")]
    TooManyFaces(u64),
    /// The sector has more than 60,000 openings; openings have 16-bit ids.
    #[error("{0} openings in one sector; split it into sectors of at most 60,000")]
    TooManyOpenings(usize),
    /// An item is not the block of the height field that it should be.
    #[error("item {} is not a block of the height field", .0.0)]
    NotABlock(ItemIndex),
}
