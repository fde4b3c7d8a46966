//! Edits: items that come, go, move and change, between looks.
//!
//! Everything asked for is checked at once, and done at the end, all of it or nothing. Orders that can follow in place do;
//! others are built anew. A viewer's memory stays right: what it saw last and is no more is not asked for again.

use super::{Body, Scene, SceneError, SectorId};
use crate::geom::{MAX_COORDINATE, Transform};
use crate::geometry::{Changes, ItemId, Placing, Unfit};
use crate::mesh::Mesh;
use crate::method::{EditStats, Unsuited};
use std::collections::BTreeMap;
use std::sync::Arc;
use thiserror::Error;

/// Changes of items that are not yet done: [`Edit::finish`] does them. Dropped before, it leaves the scene as it was.
///
/// An item that stands in several sectors is one in each.
#[must_use = "nothing changes before `finish`"]
pub struct Edit<'a> {
    scene: &'a mut Scene,
    changes: BTreeMap<SectorId, Changes>,
}

/// Why an item cannot be changed so. It stays as it was, and the rest of the edit goes on.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EditError {
    /// The scene has no such sector.
    #[error("there is no sector {sector}: the scene has {sectors}")]
    NoSuchSector {
        /// Which was asked for.
        sector: u32,
        /// How many there are.
        sectors: usize,
    },
    /// The sector is one of the user's own.
    #[error("sector `{0}` is one of your own: its items are its own affair")]
    NotOurs(String),
    /// There is no such item, or not any more.
    #[error("sector `{sector}` has no item {item}: it was removed, or never there")]
    NoSuchItem {
        /// The sector's name.
        sector: String,
        /// Which was asked for.
        item: u32,
    },
    /// A place is NaN.
    #[error("item `{0}` would stand at a place that is no number")]
    NotFinite(String),
    /// The item, or its transform, would reach beyond [`MAX_COORDINATE`].
    #[error("item `{0}` would reach farther out than {MAX_COORDINATE:e} units")]
    TooFar(String),
    /// A mesh has no faces.
    #[error("item `{0}` would have no faces; remove it instead")]
    NoFaces(String),
    /// A mesh is made of a material that the sector does not have.
    #[error("item `{item}` is made of material {material}, but its sector has only {materials}")]
    NoSuchMaterial {
        /// The item's name.
        item: String,
        /// The material that its mesh names.
        material: u32,
        /// How many there are.
        materials: usize,
    },
    /// Faces are numbered with 32 bits.
    #[error("with item `{0}` there would be 4 billion faces in one sector")]
    TooManyFaces(String),
}

impl Scene {
    /// Begins to change items, between looks.
    ///
    /// ```
    /// # use enfilade::*;
    /// # let mut scene = enfilade_scenes::built_in("two-rooms").expect("a scene").scene;
    /// # let hall = SectorId(0);
    /// let mut edit = scene.edit();
    /// edit.place(hall, ItemId(0), Transform::translation([0.0, 1.0, 0.0]))?;
    /// let edited = edit.finish()?;
    /// assert_eq!((edited.items, edited.rebuilt), (1, 0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// Cost: O(log items) for each change where the sector's order can follow in place, which is all but
    /// [`Method::Bsp`](crate::Method::Bsp) and [`Method::BspFront`](crate::Method::BspFront), and
    /// [`Method::Cell`](crate::Method::Cell) where what changes hides anything: those are built anew at the end. What the scene shares with a copy of it, or a geometry that somebody else holds too, becomes its own first, once.
    pub fn edit(&mut self) -> Edit<'_> {
        Edit {
            scene: self,
            changes: BTreeMap::new(),
        }
    }
}

impl Edit<'_> {
    /// The scene as it is until [`Edit::finish`].
    pub fn scene(&self) -> &Scene {
        self.scene
    }

    /// Adds an item to a sector. Its number is the lowest that is free: that of one removed in an earlier edit, if any.
    /// The mesh is known by its address, so that copies share it; one that no item is a copy of any more is let go.
    ///
    /// # Errors
    /// [`EditError`], and then nothing is added.
    pub fn add(
        &mut self,
        sector: SectorId,
        name: &str,
        mesh: impl Into<Arc<Mesh>>,
        sector_from_item: Transform,
    ) -> Result<ItemId, EditError> {
        let placing = Placing {
            mesh: mesh.into(),
            place: sector_from_item.columns(),
            is_occluder: true,
        };
        let (scene, changes) = self.of(sector)?;
        let geometry = scene.geometry(sector).ok_or_else(|| not_ours(scene, sector))?;
        let added = changes.add(geometry, name, placing);
        added.map_err(|unfit| told(unfit, name.to_owned(), geometry.materials().len()))
    }

    /// Removes an item.
    ///
    /// # Errors
    /// [`EditError`], and then nothing is removed.
    pub fn remove(&mut self, sector: SectorId, item: ItemId) -> Result<(), EditError> {
        self.change(sector, item, |_| None)
    }

    /// Moves an item.
    ///
    /// # Errors
    /// [`EditError`], and then it stays where it was.
    pub fn place(
        &mut self,
        sector: SectorId,
        item: ItemId,
        sector_from_item: Transform,
    ) -> Result<(), EditError> {
        self.change(sector, item, |was| {
            Some(Placing {
                place: sector_from_item.columns(),
                ..was
            })
        })
    }

    /// Gives an item another mesh, at the same place.
    ///
    /// # Errors
    /// [`EditError`], and then it keeps the one that it had.
    pub fn set_mesh(
        &mut self,
        sector: SectorId,
        item: ItemId,
        mesh: impl Into<Arc<Mesh>>,
    ) -> Result<(), EditError> {
        let mesh = mesh.into();
        self.change(sector, item, |was| Some(Placing { mesh, ..was }))
    }

    /// May an item hide what is behind it? All may unless told: moving ones are culled, and hide others. One that does not
    /// is seen past, in every method, as a cut-out is.
    ///
    /// # Errors
    /// [`EditError`], and then it stays as it was.
    pub fn set_occluder(
        &mut self,
        sector: SectorId,
        item: ItemId,
        is_occluder: bool,
    ) -> Result<(), EditError> {
        self.change(sector, item, |was| Some(Placing { is_occluder, ..was }))
    }

    /// Does everything that was asked for.
    ///
    /// # Errors
    /// [`SceneError::TooLarge`] where a sector would need too much memory, [`SceneError::NotConvex`] where its method sees
    /// convex geometries alone and it would be one no more; and then the scene is as it was.
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
            // What was there before needs no more than it did then.
            let _ = scene.exchange(done, changes, u64::MAX);
        }
        Err(SceneError::unsuited(scene.sector_name(sector), why))
    }

    fn change(
        &mut self,
        sector: SectorId,
        item: ItemId,
        change: impl FnOnce(Placing) -> Option<Placing>,
    ) -> Result<(), EditError> {
        let (scene, changes) = self.of(sector)?;
        let geometry = scene.geometry(sector).ok_or_else(|| not_ours(scene, sector))?;
        let changed = changes
            .change(geometry, item, change)
            .ok_or_else(|| EditError::NoSuchItem {
                sector: scene.sector_name(sector).to_owned(),
                item: item.0,
            })?;
        changed.map_err(|unfit| {
            told(
                unfit,
                changes.name(geometry, item).to_owned(),
                geometry.materials().len(),
            )
        })
    }

    fn of(&mut self, sector: SectorId) -> Result<(&Scene, &mut Changes), EditError> {
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
    fn exchange(&mut self, id: SectorId, changes: &mut Changes, limit: u64) -> Result<EditStats, Unsuited> {
        let placed = &mut self.sectors[id.0 as usize];
        let Body::BuiltIn { method, sector } = &mut placed.body else {
            return Ok(EditStats::default());
        };
        if Arc::get_mut(sector).is_none() {
            // A copy of the scene goes on with the one that both had.
            *sector = method.build_editable(Arc::clone(sector.geometry()), limit)?;
            placed.builds += 1;
        }
        let Some(own) = Arc::get_mut(sector) else {
            unreachable!("it was just made");
        };
        let edited = own.edit(changes, limit)?;
        placed.builds += edited.rebuilt;
        let space = placed.space();
        self.boxes.change(id, space);
        Ok(edited)
    }
}

fn not_ours(scene: &Scene, sector: SectorId) -> EditError {
    EditError::NotOurs(scene.sector_name(sector).to_owned())
}

fn told(unfit: Unfit, item: String, materials: usize) -> EditError {
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
