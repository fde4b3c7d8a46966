//! Edits between looks: add, remove, move and change items; add and remove openings.
//!
//! An [`Edit`] validates each change when it is requested and applies all of them in [`Edit::finish`], all or none.
//! Orders that support it are updated in place; others are rebuilt. A viewer's temporal coherence stays valid: it skips
//! remembered clusters that no longer exist.

use super::{Body, Scene, SceneError};
use crate::geom::{ConvexPolygon, MAX_COORDINATE, Transform};
use crate::geometry::{Changes, Geometry, ItemLabel, ItemOptions, Opening, Unfit};
use crate::ids::{ItemId, OpeningId, SectorId};
use crate::mesh::Mesh;
use crate::method::{EditStats, UnsuitedMethod};
use std::sync::Arc;
use thiserror::Error;

/// A batch of pending changes of items and openings. [`Edit::finish`] applies them; dropping the edit discards them.
///
/// Sectors and portals are added and removed directly: see [`Scene::add_sector`] and [`Scene::add_portal`].
///
/// An item that is in several sectors is a separate item in each.
#[doc(alias = "dynamic objects")]
#[must_use = "nothing changes before `finish`"]
pub struct Edit<'a> {
    scene: &'a mut Scene,
}

/// An error of a change. What it concerns stays unchanged, and the rest of the edit can continue.
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
    /// The sector was removed.
    #[error("sector {0} was removed")]
    RemovedSector(u32),
    /// The sector is custom, so the scene does not hold its items.
    #[error("sector `{0}` is custom; its items cannot be edited through the scene")]
    CustomSector(String),
    /// The item does not exist, or was removed. Another item may have its index by now.
    #[error(
        "sector `{sector}` has no item {} of generation {}; it was removed or never existed",
        item.index.0, item.generation
    )]
    NoSuchItem {
        /// The sector's name.
        sector: String,
        /// The requested item.
        item: ItemId,
    },
    /// The transform of an item has a NaN.
    #[error("the transform of item {0} contains NaN")]
    NotFinite(ItemLabel),
    /// The bounds or the transform of an item reach beyond [`MAX_COORDINATE`].
    #[error("item {0} would reach beyond {MAX_COORDINATE:e} units; move it closer to the origin")]
    TooFar(ItemLabel),
    /// The mesh of an item has no faces.
    #[error("the mesh of item {0} has no faces; remove the item instead")]
    NoFaces(ItemLabel),
    /// The mesh of an item uses a material that the geometry of the sector does not have.
    #[error(
        "the mesh of item {item} uses material {material}, but the number of materials in its sector is {materials}"
    )]
    NoSuchMaterial {
        /// The item.
        item: ItemLabel,
        /// The material that its mesh uses.
        material: u32,
        /// The number of materials.
        materials: usize,
    },
    /// The sector would have more faces than 32-bit face numbers can address.
    #[error("item {0} would bring its sector to 4 billion faces; use more sectors")]
    TooManyFaces(ItemLabel),
    /// The opening does not exist.
    #[error("sector `{sector}` has no opening {opening}, only {openings}")]
    NoSuchOpening {
        /// The sector's name.
        sector: String,
        /// The requested opening.
        opening: u16,
        /// The number of openings.
        openings: usize,
    },
    /// The sector, by name, has 60,000 openings; openings have 16-bit ids.
    #[error("sector `{0}` has 60,000 openings already; split it")]
    TooManyOpenings(String),
}

impl Scene {
    /// Begins a batch of changes of items and openings.
    ///
    /// ```
    /// # use enfilade::*;
    /// # let mut scene = enfilade_scenes::built_in("two-rooms").expect("a scene").scene;
    /// # let hall = SectorId(0);
    /// let lamp = scene.geometry(hall).expect("not a custom sector").id_of(ItemIndex(0));
    /// let mut edit = scene.edit();
    /// edit.set_transform(hall, lamp, Transform::translation([0.0, 1.0, 0.0]))?;
    /// let edited = edit.finish()?;
    /// assert_eq!((edited.items, edited.rebuilt), (1, 0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// Cost: O(log items) per change if the order of the sector can be updated in place.
    /// [`Method::Bsp`](crate::Method::Bsp), [`Method::BspFront`](crate::Method::BspFront) and, where an occluder
    /// changes, [`Method::Cell`](crate::Method::Cell) rebuild their order in [`Edit::finish`] instead; so does
    /// [`Method::Pvs`](crate::Method::Pvs) where openings change. The first edit
    /// of a sector whose data is shared, with a clone of the scene or another owner of the geometry, copies that data.
    #[doc(alias = "dynamic objects")]
    pub fn edit(&mut self) -> Edit<'_> {
        self.discard_changes();
        Edit { scene: self }
    }
}

impl Edit<'_> {
    /// Returns the scene without the pending changes.
    pub fn scene(&self) -> &Scene {
        self.scene
    }

    /// Adds an item to a sector and returns its id. It takes the lowest free index, such as that of an item removed in
    /// an earlier edit, with a new generation, and its index as its key. Items share a mesh if they pass the same
    /// [`Arc`]; a mesh that no item uses any more is dropped.
    ///
    /// # Errors
    /// Returns an [`EditError`] and adds nothing.
    pub fn add(
        &mut self,
        sector: SectorId,
        name: &str,
        mesh: impl Into<Arc<Mesh>>,
        sector_from_item: Transform,
    ) -> Result<ItemId, EditError> {
        let (_, geometry, changes) = self.parts(sector)?;
        let added = changes.add(geometry, name, mesh.into(), sector_from_item.columns());
        added.map_err(|unfit| {
            let label = ItemLabel {
                name: name.to_owned(),
                key: u64::from(changes.next_index(geometry).0),
            };
            edit_error(unfit, label, geometry)
        })
    }

    /// Removes an item from a sector.
    ///
    /// # Errors
    /// Returns an [`EditError`] and removes nothing.
    pub fn remove(&mut self, sector: SectorId, item: ItemId) -> Result<(), EditError> {
        self.change(sector, item, |changes, geometry| changes.remove(geometry, item))
    }

    /// Replaces the transform of an item.
    ///
    /// # Errors
    /// Returns an [`EditError`] and leaves the item unchanged.
    pub fn set_transform(
        &mut self,
        sector: SectorId,
        item: ItemId,
        sector_from_item: Transform,
    ) -> Result<(), EditError> {
        let place = sector_from_item.columns();
        self.change(sector, item, |changes, geometry| {
            changes.set_transform(geometry, item, place)
        })
    }

    /// Replaces the transforms of many items of a sector: as [`Edit::set_transform`] for each, but faster.
    ///
    /// Replaces the contents of `refused` with the position in `transforms` of each item that could not be moved, and
    /// the reason. Such an item stays where it was in the scene: draw it without culling until a transform is accepted. Of
    /// several transforms of one item the last counts. Neither this nor [`Edit::finish`] allocates once the buffers of the
    /// scene have grown, except where nodes of an octree or kd-tree split.
    ///
    /// # Errors
    /// Returns [`EditError::NoSuchSector`], [`EditError::RemovedSector`] or [`EditError::CustomSector`] and moves nothing.
    pub fn set_transforms(
        &mut self,
        sector: SectorId,
        transforms: impl IntoIterator<Item = (ItemId, Transform)>,
        refused: &mut Vec<(usize, EditError)>,
    ) -> Result<(), EditError> {
        refused.clear();
        let (name, geometry, changes) = self.parts(sector)?;
        for (number, (item, transform)) in transforms.into_iter().enumerate() {
            if let Err(unfit) = changes.set_transform(geometry, item, transform.columns()) {
                refused.push((number, refusal(unfit, name, item, geometry, changes)));
            }
        }
        Ok(())
    }

    /// Replaces the mesh of an item and keeps its transform.
    ///
    /// # Errors
    /// Returns an [`EditError`] and leaves the item unchanged.
    pub fn set_mesh(
        &mut self,
        sector: SectorId,
        item: ItemId,
        mesh: impl Into<Arc<Mesh>>,
    ) -> Result<(), EditError> {
        let mesh = mesh.into();
        self.change(sector, item, |changes, geometry| {
            changes.set_mesh(geometry, item, mesh)
        })
    }

    /// Sets how an item takes part in looks. Default: [`ItemOptions::default`].
    ///
    /// # Errors
    /// Returns an [`EditError`] and leaves the item unchanged.
    pub fn set_options(
        &mut self,
        sector: SectorId,
        item: ItemId,
        options: ItemOptions,
    ) -> Result<(), EditError> {
        self.change(sector, item, |changes, geometry| {
            changes.set_options(geometry, item, options)
        })
    }

    /// Sets the key of an item; see [`GeometryBuilder::set_key`](crate::GeometryBuilder::set_key).
    ///
    /// # Errors
    /// Returns an [`EditError`] and changes nothing.
    pub fn set_key(&mut self, sector: SectorId, item: ItemId, key: u64) -> Result<(), EditError> {
        self.change(sector, item, |changes, geometry| {
            changes.set_key(geometry, item, key)
        })
    }

    /// Moves an item to another sector, with its name, key, mesh and options; `sector_from_item` is its transform there.
    /// Returns its id there. The materials of its mesh are those of the new sector with the same numbers.
    ///
    /// An item that reaches through an opening belongs in both sectors: use [`Edit::add`] for the second.
    ///
    /// # Errors
    /// Returns an [`EditError`] and leaves the item where it is.
    pub fn move_to(
        &mut self,
        from: SectorId,
        item: ItemId,
        to: SectorId,
        sector_from_item: Transform,
    ) -> Result<ItemId, EditError> {
        let (name, geometry, changes) = self.parts(from)?;
        let state = changes.state(geometry, item);
        let state = state.map_err(|unfit| refusal(unfit, name, item, geometry, changes))?;
        let moved = self.add(to, &state.name, state.mesh, sector_from_item)?;
        self.set_key(to, moved, state.key)?;
        self.set_options(to, moved, state.options)?;
        self.remove(from, item)?;
        Ok(moved)
    }

    /// Adds an opening to a sector and returns its id, after those of the others. It is visible from its front, the side
    /// from which its corners are counter-clockwise, and an opaque face until [`Scene::add_portal`] or
    /// [`Scene::add_door`] connects it.
    ///
    /// # Errors
    /// Returns an [`EditError`] and adds nothing.
    pub fn add_opening(
        &mut self,
        sector: SectorId,
        name: &str,
        outline: ConvexPolygon,
    ) -> Result<OpeningId, EditError> {
        let (sector, geometry, changes) = self.parts(sector)?;
        let name = name.to_owned();
        let added = changes.add_opening(geometry, Opening { name, outline });
        added.map_err(|_| EditError::TooManyOpenings(sector.to_owned()))
    }

    /// Removes an opening; [`Edit::finish`] removes the portal that leads out of it. The last opening of the sector takes
    /// its id; returns the id that the last one had, unless it is the removed one. Portals keep their ids and their
    /// openings.
    ///
    /// A baked PVS of the sector is dropped: lines of sight that ended at the opening may go on, so bake again, and until
    /// then use another method than [`Method::Pvs`](crate::Method::Pvs).
    ///
    /// # Errors
    /// Returns an [`EditError`] and removes nothing.
    pub fn remove_opening(
        &mut self,
        sector: SectorId,
        opening: OpeningId,
    ) -> Result<Option<OpeningId>, EditError> {
        let (sector, geometry, changes) = self.parts(sector)?;
        if !changes.remove_opening(geometry, opening) {
            return Err(EditError::NoSuchOpening {
                sector: sector.to_owned(),
                opening: opening.0,
                openings: changes.opening_count(geometry),
            });
        }
        let last = OpeningId(changes.opening_count(geometry) as u16);
        Ok((last != opening).then_some(last))
    }

    /// Applies all pending changes.
    ///
    /// # Errors
    /// Returns [`SceneError::Unsuited`] if a sector would need too much memory, or its geometry would no longer meet the
    /// requirement of its method, and leaves
    /// the scene unchanged.
    pub fn finish(self) -> Result<EditStats, SceneError> {
        let scene = &mut *self.scene;
        let limit = scene.limit_bytes;
        let mut edited = EditStats::default();
        for sector in 0..scene.sectors.len() {
            if scene.sectors[sector].changes.is_empty() {
                continue;
            }
            match scene.exchange(sector, limit) {
                Ok(done) => edited.add(&done),
                Err(why) => {
                    for done in 0..sector {
                        if !scene.sectors[done].changes.is_empty() {
                            // The state before the edit was within the limit, so restoring it needs no limit.
                            let _ = scene.exchange(done, u64::MAX);
                        }
                    }
                    return Err(SceneError::unsuited(&scene.sectors[sector].name, why));
                }
            }
        }
        for sector in (0..scene.sectors.len() as u32).map(SectorId) {
            scene.follow_openings(sector);
        }
        Ok(edited)
    }

    fn change(
        &mut self,
        sector: SectorId,
        item: ItemId,
        change: impl FnOnce(&mut Changes, &Geometry) -> Result<(), Unfit>,
    ) -> Result<(), EditError> {
        let (name, geometry, changes) = self.parts(sector)?;
        change(changes, geometry).map_err(|unfit| refusal(unfit, name, item, geometry, changes))
    }

    /// Returns the name, the geometry and the pending changes of a sector.
    fn parts(&mut self, sector: SectorId) -> Result<(&str, &Geometry, &mut Changes), EditError> {
        let sectors = self.scene.sectors.len();
        let Some(placed) = self.scene.sectors.get_mut(sector.0 as usize) else {
            return Err(EditError::NoSuchSector {
                sector: sector.0,
                sectors,
            });
        };
        match &placed.body {
            Body::BuiltIn { sector, .. } => Ok((&placed.name, sector.geometry(), &mut placed.changes)),
            Body::Custom(_) => Err(EditError::CustomSector(placed.name.clone())),
            Body::Removed(_) => Err(EditError::RemovedSector(sector.0)),
        }
    }
}

impl Drop for Edit<'_> {
    fn drop(&mut self) {
        self.scene.discard_changes();
    }
}

impl Scene {
    fn discard_changes(&mut self) {
        for placed in &mut self.sectors {
            placed.changes.clear();
        }
    }

    fn exchange(&mut self, number: usize, limit: u64) -> Result<EditStats, UnsuitedMethod> {
        let placed = &mut self.sectors[number];
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
            .edit(&mut placed.changes, limit)
            .map_err(|reason| method.unsuited(reason))?;
        placed.builds += edited.rebuilt;
        let space = placed.space();
        self.boxes.change(SectorId(number as u32), space);
        Ok(edited)
    }
}

/// Returns the error for a change of an item that was refused.
fn refusal(unfit: Unfit, sector: &str, item: ItemId, geometry: &Geometry, changes: &Changes) -> EditError {
    if unfit == Unfit::NoSuchItem {
        let sector = sector.to_owned();
        return EditError::NoSuchItem { sector, item };
    }
    edit_error(unfit, changes.label(geometry, item.index), geometry)
}

fn edit_error(unfit: Unfit, item: ItemLabel, geometry: &Geometry) -> EditError {
    match unfit {
        Unfit::NoSuchItem => unreachable!("the item was found before"),
        Unfit::NotFinite => EditError::NotFinite(item),
        Unfit::TooFar => EditError::TooFar(item),
        Unfit::NoFaces => EditError::NoFaces(item),
        Unfit::NoSuchMaterial(material) => EditError::NoSuchMaterial {
            item,
            material,
            materials: geometry.materials().len(),
        },
        Unfit::TooManyFaces => EditError::TooManyFaces(item),
    }
}
