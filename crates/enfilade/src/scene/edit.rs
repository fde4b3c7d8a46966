//! Item edits between looks: add, remove, move and change items.
//!
//! An [`Edit`] validates each change when it is requested and applies all of them in [`Edit::finish`], all or none.
//! Orders that support it are updated in place; others are rebuilt. A viewer's temporal coherence stays valid: it skips
//! remembered clusters that no longer exist.

use super::{Body, Scene, SceneError};
use crate::geom::{MAX_COORDINATE, Transform};
use crate::geometry::{Changes, Placing, Unfit};
use crate::ids::{ItemIndex, SectorId};
use crate::mesh::Mesh;
use crate::method::{EditStats, UnsuitedMethod};
use std::collections::BTreeMap;
use std::sync::Arc;
use thiserror::Error;

/// A batch of pending item changes. [`Edit::finish`] applies them; dropping the edit discards them.
///
/// An item that is in several sectors is a separate item in each.
#[doc(alias = "dynamic objects")]
#[must_use = "nothing changes before `finish`"]
pub struct Edit<'a> {
    scene: &'a mut Scene,
    changes: BTreeMap<SectorId, Changes>,
}

/// An error of an item change. The item stays unchanged, and the rest of the edit can continue.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EditError {
    /// The sector does not exist.
    #[error("sector {sector} does not exist; the scene has only {sectors}")]
    NoSuchSector {
        /// The requested sector.
        sector: u32,
        /// The number of sectors.
        sectors: usize,
    },
    /// The sector is custom, so the scene does not hold its items.
    #[error("sector `{0}` is custom; its items cannot be edited through the scene")]
    CustomSector(String),
    /// The item does not exist, or was removed.
    #[error("sector `{sector}` has no item {item}; it was removed or never existed")]
    NoSuchItem {
        /// The sector's name.
        sector: String,
        /// The requested item.
        item: u32,
    },
    /// The transform of an item has a NaN.
    #[error("the transform of item `{0}` contains NaN")]
    NotFinite(String),
    /// The bounds or the transform of an item reach beyond [`MAX_COORDINATE`].
    #[error("item `{0}` would reach beyond {MAX_COORDINATE:e} units; move it closer to the origin")]
    TooFar(String),
    /// The mesh of an item has no faces.
    #[error("the mesh of item `{0}` has no faces; remove the item instead")]
    NoFaces(String),
    /// The mesh of an item uses a material that the geometry of the sector does not have.
    #[error("the mesh of item `{item}` uses material {material}, but its sector has only {materials}")]
    NoSuchMaterial {
        /// The item's name.
        item: String,
        /// The material that its mesh uses.
        material: u32,
        /// The number of materials.
        materials: usize,
    },
    /// The sector would have more faces than 32-bit face numbers can address.
    #[error("item `{0}` would bring its sector to 4 billion faces; use more sectors")]
    TooManyFaces(String),
}

impl Scene {
    /// Begins a batch of item changes.
    ///
    /// ```
    /// # use enfilade::*;
    /// # let mut scene = enfilade_scenes::built_in("two-rooms").expect("a scene").scene;
    /// # let hall = SectorId(0);
    /// let mut edit = scene.edit();
    /// edit.set_transform(hall, ItemIndex(0), Transform::translation([0.0, 1.0, 0.0]))?;
    /// let edited = edit.finish()?;
    /// assert_eq!((edited.items, edited.rebuilt), (1, 0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// Cost: O(log items) per change if the order of the sector can be updated in place.
    /// [`Method::Bsp`](crate::Method::Bsp), [`Method::BspFront`](crate::Method::BspFront) and, where an occluder
    /// changes, [`Method::Cell`](crate::Method::Cell) rebuild their order in [`Edit::finish`] instead. The first edit
    /// of a sector whose data is shared, with a clone of the scene or another owner of the geometry, copies that data.
    #[doc(alias = "dynamic objects")]
    pub fn edit(&mut self) -> Edit<'_> {
        Edit {
            scene: self,
            changes: BTreeMap::new(),
        }
    }
}

impl Edit<'_> {
    /// Returns the scene without the pending changes.
    pub fn scene(&self) -> &Scene {
        self.scene
    }

    /// Adds an item to a sector and returns its id: the lowest free number, such as that of an item removed in an
    /// earlier edit. Items share a mesh if they pass the same [`Arc`]; a mesh that no item uses any more is dropped.
    ///
    /// # Errors
    /// Returns an [`EditError`] and adds nothing.
    pub fn add(
        &mut self,
        sector: SectorId,
        name: &str,
        mesh: impl Into<Arc<Mesh>>,
        sector_from_item: Transform,
    ) -> Result<ItemIndex, EditError> {
        let placing = Placing {
            mesh: mesh.into(),
            place: sector_from_item.columns(),
            is_occluder: true,
        };
        let (scene, changes) = self.changes_of(sector)?;
        let geometry = scene
            .geometry(sector)
            .ok_or_else(|| not_editable(scene, sector))?;
        let added = changes.add(geometry, name, placing);
        added.map_err(|unfit| edit_error(unfit, name.to_owned(), geometry.materials().len()))
    }

    /// Removes an item from a sector.
    ///
    /// # Errors
    /// Returns [`EditError::NoSuchSector`], [`EditError::CustomSector`] or [`EditError::NoSuchItem`] and removes nothing.
    pub fn remove(&mut self, sector: SectorId, item: ItemIndex) -> Result<(), EditError> {
        self.change(sector, item, |_| None)
    }

    /// Replaces the transform of an item.
    ///
    /// # Errors
    /// Returns an [`EditError`] and leaves the item unchanged.
    pub fn set_transform(
        &mut self,
        sector: SectorId,
        item: ItemIndex,
        sector_from_item: Transform,
    ) -> Result<(), EditError> {
        self.change(sector, item, |was| {
            Some(Placing {
                place: sector_from_item.columns(),
                ..was
            })
        })
    }

    /// Replaces the mesh of an item and keeps its transform.
    ///
    /// # Errors
    /// Returns an [`EditError`] and leaves the item unchanged.
    pub fn set_mesh(
        &mut self,
        sector: SectorId,
        item: ItemIndex,
        mesh: impl Into<Arc<Mesh>>,
    ) -> Result<(), EditError> {
        let mesh = mesh.into();
        self.change(sector, item, |was| Some(Placing { mesh, ..was }))
    }

    /// Sets whether an item is an occluder. Default: `true`, also for items that move. With `false`, every method
    /// treats the faces of the item as alpha-tested ones: they can be hidden but hide nothing.
    ///
    /// # Errors
    /// Returns an [`EditError`] and leaves the item unchanged.
    pub fn set_occluder(
        &mut self,
        sector: SectorId,
        item: ItemIndex,
        is_occluder: bool,
    ) -> Result<(), EditError> {
        self.change(sector, item, |was| Some(Placing { is_occluder, ..was }))
    }

    /// Applies all pending changes.
    ///
    /// # Errors
    /// Returns [`SceneError::Unsuited`] if a sector would need too much memory, or its geometry would no longer meet the
    /// requirement of its method, and leaves
    /// the scene unchanged.
    pub fn finish(self) -> Result<EditStats, SceneError> {
        let Edit { scene, mut changes } = self;
        changes.retain(|_, changes| !changes.is_empty());
        let limit = scene.limit_bytes;
        let mut edited = EditStats::default();
        let mut refused = None;
        for (&sector, changes) in &mut changes {
            match scene.exchange(sector, changes, limit) {
                Ok(done) => edited.add(&done),
                Err(why) => {
                    refused = Some((sector, why));
                    break;
                }
            }
        }
        let Some((sector, why)) = refused else {
            return Ok(edited);
        };
        for (&done, changes) in changes.range_mut(..sector) {
            // The state before the edit was within the limit, so restoring it needs no limit.
            let _ = scene.exchange(done, changes, u64::MAX);
        }
        Err(SceneError::unsuited(scene.sector_name(sector), why))
    }

    fn change(
        &mut self,
        sector: SectorId,
        item: ItemIndex,
        change: impl FnOnce(Placing) -> Option<Placing>,
    ) -> Result<(), EditError> {
        let (scene, changes) = self.changes_of(sector)?;
        let geometry = scene
            .geometry(sector)
            .ok_or_else(|| not_editable(scene, sector))?;
        let changed = changes
            .change(geometry, item, change)
            .ok_or_else(|| EditError::NoSuchItem {
                sector: scene.sector_name(sector).to_owned(),
                item: item.0,
            })?;
        changed.map_err(|unfit| {
            edit_error(
                unfit,
                changes.name(geometry, item).to_owned(),
                geometry.materials().len(),
            )
        })
    }

    fn changes_of(&mut self, sector: SectorId) -> Result<(&Scene, &mut Changes), EditError> {
        let sectors = self.scene.sector_count();
        if sector.0 as usize >= sectors {
            return Err(EditError::NoSuchSector {
                sector: sector.0,
                sectors,
            });
        }
        Ok((self.scene, self.changes.entry(sector).or_default()))
    }
}

impl Scene {
    fn exchange(
        &mut self,
        id: SectorId,
        changes: &mut Changes,
        limit: u64,
    ) -> Result<EditStats, UnsuitedMethod> {
        let placed = &mut self.sectors[id.0 as usize];
        let Body::BuiltIn { method, sector } = &mut placed.body else {
            return Ok(EditStats::default());
        };
        if Arc::get_mut(sector).is_none() {
            // A clone of the scene keeps using the shared one.
            *sector = method.build_editable(Arc::clone(sector.geometry()), limit)?;
            placed.builds += 1;
        }
        let Some(own) = Arc::get_mut(sector) else {
            unreachable!("the sector was just built and is not shared");
        };
        let edited = own
            .edit(changes, limit)
            .map_err(|reason| method.unsuited(reason))?;
        placed.builds += edited.rebuilt;
        let space = placed.space();
        self.boxes.change(id, space);
        Ok(edited)
    }
}

fn not_editable(scene: &Scene, sector: SectorId) -> EditError {
    EditError::CustomSector(scene.sector_name(sector).to_owned())
}

fn edit_error(unfit: Unfit, item: String, materials: usize) -> EditError {
    match unfit {
        Unfit::NotFinite => EditError::NotFinite(item),
        Unfit::TooFar => EditError::TooFar(item),
        Unfit::NoFaces => EditError::NoFaces(item),
        Unfit::NoSuchMaterial(material) => EditError::NoSuchMaterial {
            item,
            material,
            materials,
        },
        Unfit::TooManyFaces => EditError::TooManyFaces(item),
    }
}
