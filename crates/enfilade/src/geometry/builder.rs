//! Puts a geometry together, and refuses one that cannot be.

use super::names::Names;
use super::{BakedCells, Geometry, Item, ItemId, Material, MeshId, Opening, OpeningId, Texture};
use crate::geom::{Aabb, ConvexPolygon, MAX_COORDINATE, Octree, Transform, is_in_range};
use crate::mesh::Mesh;
use crate::terrain::Terrain;
use std::sync::{Arc, Mutex, OnceLock, Weak};
use thiserror::Error;

/// Gathers the things of a sector; [`GeometryBuilder::build`] checks them.
#[derive(Clone, Debug, Default)]
pub struct GeometryBuilder {
    meshes: Vec<Arc<Mesh>>,
    materials: Arc<[Material]>,
    textures: Arc<[Arc<Texture>]>,
    items: Vec<(MeshId, Transform, bool)>,
    names: Names,
    openings: Vec<Opening>,
    cells: Option<Arc<BakedCells>>,
    pub(crate) terrains: Vec<Terrain>,
}

impl GeometryBuilder {
    /// Starts with a table of materials, which sectors may share.
    pub fn new(materials: impl Into<Arc<[Material]>>) -> GeometryBuilder {
        GeometryBuilder {
            materials: materials.into(),
            ..GeometryBuilder::default()
        }
    }

    /// The images that its materials name, which sectors may share; none unless told.
    pub fn textures(&mut self, textures: impl Into<Arc<[Arc<Texture>]>>) {
        self.textures = textures.into();
    }

    /// Adds a mesh that items can be copies of.
    pub fn mesh(&mut self, mesh: impl Into<Arc<Mesh>>) -> MeshId {
        self.meshes.push(mesh.into());
        MeshId(self.meshes.len() as u32 - 1)
    }

    /// Places a mesh.
    pub fn item(&mut self, name: &str, mesh: MeshId, sector_from_item: Transform) -> ItemId {
        self.items.push((mesh, sector_from_item, true));
        self.names.push(name);
        ItemId(self.items.len() as u32 - 1)
    }

    /// Sets whether an item may hide others; default `true`. An item that is no occluder is visible like any other, but
    /// nothing behind it is culled: for items that move fast, or whose mesh only approximates what is drawn. Ignores an
    /// item that does not exist.
    pub fn set_occluder(&mut self, item: ItemId, is_occluder: bool) {
        if let Some((_, _, flag)) = self.items.get_mut(item.0 as usize) {
            *flag = is_occluder;
        }
    }

    /// Adds a hole to look through. Where it leads, the scene says.
    pub fn opening(&mut self, name: &str, outline: ConvexPolygon) -> OpeningId {
        self.openings.push(Opening {
            name: name.to_owned(),
            outline,
        });
        OpeningId(self.openings.len().min(usize::from(u16::MAX)) as u16 - 1)
    }

    /// Gives it cells that were computed ahead, for [`Method::Pvs`](crate::Method::Pvs). Items need not be told which cells
    /// they stand in: that is found out from their faces. An item is seen whole or not at all, so that walls are best cut
    /// into items of a cell or a few.
    pub fn cells(&mut self, cells: impl Into<Arc<BakedCells>>) {
        self.cells = Some(cells.into());
    }

    /// Checks everything.
    ///
    /// # Errors
    /// One [`GeometryError`] for the first broken rule.
    pub fn build(self) -> Result<Geometry, GeometryError> {
        let GeometryBuilder {
            meshes,
            materials,
            textures,
            items: placed,
            names,
            openings,
            cells,
            terrains,
        } = self;
        for (mesh, built) in meshes.iter().enumerate() {
            if let Some(cluster) = built
                .clusters()
                .iter()
                .find(|c| c.material.0 as usize >= materials.len())
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
        let mut first_faces = Vec::with_capacity(placed.len() + 1);
        let mut faces = 0_u64;
        let holes: Vec<Aabb> = openings.iter().map(|o| o.outline.bounds()).collect();
        let mut bounds = holes.iter().fold(Aabb::EMPTY, |sum, hole| sum.union(hole));
        for (number, (mesh, transform, is_occluder)) in placed.into_iter().enumerate() {
            let name = || names.get(number).to_owned();
            let built = meshes
                .get(mesh.0 as usize)
                .ok_or_else(|| GeometryError::NoSuchMesh {
                    item: name(),
                    mesh: mesh.0,
                    meshes: meshes.len(),
                })?;
            let sector_from_item = transform.columns();
            let held = placed_bounds(&Transform::from_columns(sector_from_item), built);
            if sector_from_item.iter().flatten().any(|v| !v.is_finite())
                || !(held.is_empty() || (held.min.iter().chain(&held.max)).all(|v| v.is_finite()))
            {
                return Err(GeometryError::NotFinite(name()));
            }
            if !(sector_from_item.iter().flatten().all(|&v| is_in_range(v)) && held.is_in_range()) {
                return Err(GeometryError::TooFar(name()));
            }
            bounds = bounds.union(&held);
            items.push(Item {
                mesh,
                sector_from_item,
                bounds: held,
                is_occluder,
            });
            first_faces.push(faces as u32);
            faces += u64::from(built.face_count());
        }
        if faces > u64::from(u32::MAX) - MAX_OPENINGS as u64 {
            return Err(GeometryError::TooManyFaces(faces));
        }
        first_faces.push(faces as u32);
        let outline_ends: Vec<[u32; 2]> = openings
            .iter()
            .map(|o| [0, o.outline.corners().len() as u32])
            .collect();
        let outline_corners = (0..outline_ends.iter().map(|ends| ends[1]).max().unwrap_or(0)).collect();
        Ok(Geometry {
            meshes,
            materials,
            textures,
            items,
            names,
            slots: None,
            openings,
            cells,
            terrains,
            item_tree: OnceLock::new(),
            opening_tree: Octree::build(&holes, FEW_OPENINGS),
            outline_corners,
            outline_ends,
            first_faces,
            bounds,
            shared: Mutex::new(Weak::<()>::new()),
        })
    }
}

pub(crate) const MAX_OPENINGS: usize = 60_000;

/// Openings in a node of the tree over them, at most: as many are handed out by number, however they lie.
const FEW_OPENINGS: usize = 16;

/// The box around a placed mesh: a large mesh by its corners, a small one by its positions, which is tighter.
pub(super) fn placed_bounds(transform: &Transform, mesh: &Mesh) -> Aabb {
    const FEW: usize = 64;
    let around = |points: &[[f32; 3]]| {
        points
            .iter()
            .fold(Aabb::EMPTY, |sum, &p| sum.union(&transform.point_box(p)))
    };
    if mesh.bounds().is_empty() {
        Aabb::EMPTY
    } else if mesh.positions().len() <= FEW {
        around(mesh.positions())
    } else {
        around(&mesh.bounds().corners())
    }
}

/// Why things do not make a geometry.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// An item names a mesh that is not there.
    #[error("item {item} is a copy of mesh {mesh}, but there are only {meshes}")]
    NoSuchMesh {
        /// The item's name.
        item: String,
        /// The mesh it names.
        mesh: u32,
        /// How many there are.
        meshes: usize,
    },
    /// A cluster names a material that is not there.
    #[error("mesh {mesh} is made of material {material}, but there are only {materials}")]
    NoSuchMaterial {
        /// Which mesh.
        mesh: usize,
        /// The material it names.
        material: u32,
        /// How many there are.
        materials: usize,
    },
    /// A material names a texture that is not there.
    #[error("material {material} has texture {texture}, but there are only {textures}")]
    NoSuchTexture {
        /// Which material.
        material: usize,
        /// The texture it names.
        texture: u32,
        /// How many there are.
        textures: usize,
    },
    /// A place is NaN or infinite.
    #[error("the transform of item {0} is not finite")]
    NotFinite(String),
    /// An item, or its transform, reaches beyond [`MAX_COORDINATE`].
    #[error(
        "item {0} reaches farther out than {MAX_COORDINATE:e} units; scale the scene down or move it to the origin"
    )]
    TooFar(String),
    /// Faces are numbered with 32 bits.
    #[error("{0} faces in one sector; cut it into sectors of fewer than 4 billion")]
    TooManyFaces(u64),
    /// Openings are numbered with 16 bits.
    #[error("{0} openings in one sector; cut it into sectors of fewer than 60,000")]
    TooManyOpenings(usize),
}
