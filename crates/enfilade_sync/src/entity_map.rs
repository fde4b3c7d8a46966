//! The entities of an engine, and the items of a scene that represent them.
//!
//! Idea: an entity with a mesh is an item of the scene. One without is an AABB beside the scene, which is culled by
//! frustum and portals but not by occluders: unlike a mesh of that box, it is found however near the eye is, and inside.
//! Cost: O(log entities) per change, besides that of [`Edit`].

use enfilade::{
    Aabb, Edit, EditError, EditStats, ItemId, ItemOptions, MAX_COORDINATE, Mesh, Scene, SceneError, SectorId,
    Transform, VisibleSet,
};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// An entity of the engine in one sector.
///
/// An entity that reaches through a doorway is spawned in each sector that it reaches into, with the same key. To move
/// an entity to another sector, despawn it in one and spawn it in the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Entity {
    /// The engine's number for the entity. Items that are in the scene without this crate have keys too; keep them apart
    /// by [`GeometryBuilder::set_key`](enfilade::GeometryBuilder::set_key).
    pub key: u64,
    /// The sector.
    pub sector: SectorId,
}

impl Entity {
    /// Creates an entity from the engine's number and its sector.
    pub fn new(key: u64, sector: SectorId) -> Entity {
        Entity { key, sector }
    }
}

/// A new entity.
#[derive(Clone, Copy, Debug)]
pub struct Spawn {
    /// The entity. If it exists already, it is replaced.
    pub entity: Entity,
    /// The engine's number for its mesh; see [`EntityMap::set_mesh`].
    pub mesh: u64,
    /// AABB of all that is drawn of it, in its own space. Used while its mesh is absent.
    pub bounds: Aabb,
    /// Transform from its own space to that of the sector.
    pub transform: Transform,
    /// Whether it may hide others. Use `false` if what is drawn may be smaller than the mesh, as for animated meshes.
    pub is_occluder: bool,
}

/// The changes of a frame, applied in the order of the fields.
#[derive(Clone, Copy, Debug, Default)]
pub struct Changes<'a> {
    /// Entities that are gone.
    pub despawned: &'a [Entity],
    /// New entities.
    pub spawned: &'a [Spawn],
    /// Entities with their new transforms, from their own space to that of their sector.
    pub moved: &'a [(Entity, Transform)],
}

/// What [`EntityMap::sync`] did.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Synced {
    /// Work of the scene.
    pub edited: EditStats,
    /// Entities with a mesh that the scene refused, and the reason. They are listed wherever their boxes may be in view,
    /// until a later change of them is accepted.
    pub refused: Vec<(Entity, EditError)>,
    /// Entities that were to be moved or despawned but do not exist.
    pub unknown: Vec<Entity>,
}

/// How an entity is represented.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Representation {
    /// By an item of the scene with its mesh.
    Mesh(ItemId),
    /// By its AABB in the space of the sector, because its mesh is absent or was refused. It hides nothing, and is
    /// culled by frustum and portals alone.
    Box(Aabb),
    /// By nothing: its box is empty, not finite or beyond [`MAX_COORDINATE`], or its sector does not exist. It is
    /// listed in every view.
    AlwaysVisible,
}

/// An entity that exists.
#[derive(Clone, Copy, Debug)]
struct Placed {
    spawn: Spawn,
    representation: Representation,
}

/// The entities of an engine that a scene represents. Use it with one scene only, whose items of these entities are
/// edited through it alone.
#[derive(Debug, Default)]
pub struct EntityMap {
    meshes: BTreeMap<u64, Arc<Mesh>>,
    /// In a fixed order, as all maps here: visible sets depend on the order of additions where faces coincide.
    entities: BTreeMap<Entity, Placed>,
    /// The entities without an item; `None` is visible everywhere.
    outside: BTreeMap<Entity, Option<Aabb>>,
    /// The meshes that changed since the last sync.
    changed_meshes: BTreeSet<u64>,
    /// The entities as they were before this sync, in the order of changes.
    before: Vec<(Entity, Option<Placed>)>,
}

impl EntityMap {
    /// Creates a map without entities.
    pub fn new() -> EntityMap {
        EntityMap::default()
    }

    /// Sets or removes a mesh under the engine's number for it. Takes effect at the next [`EntityMap::sync`], for all
    /// entities that use it. Where [`Mesh::new`] or the like refuses a mesh, set none.
    ///
    /// The faces of the mesh must be those that are drawn, for they decide what is visible, and what they hide.
    pub fn set_mesh(&mut self, mesh: u64, built: Option<Arc<Mesh>>) {
        match built {
            Some(built) => self.meshes.insert(mesh, built),
            None => self.meshes.remove(&mesh),
        };
        self.changed_meshes.insert(mesh);
    }

    /// Returns how an entity is represented since the last [`EntityMap::sync`]; `None` if it does not exist.
    pub fn representation(&self, entity: Entity) -> Option<Representation> {
        self.entities
            .get(&entity)
            .map(|placed_entity| placed_entity.representation)
    }

    /// Applies the changes of a frame to the scene, by one edit.
    ///
    /// # Errors
    /// Returns the error of [`Edit::finish`], and leaves the scene and the map unchanged.
    pub fn sync(&mut self, scene: &mut Scene, changes: &Changes) -> Result<Synced, SceneError> {
        let mut synced = Synced::default();
        let mut edit = scene.edit();
        self.before.clear();
        for &entity in changes.despawned {
            if !self.remove(&mut edit, entity) {
                synced.unknown.push(entity);
            }
        }
        self.replace_changed_meshes(&mut edit, &mut synced.refused);
        for spawn in changes.spawned {
            self.remove(&mut edit, spawn.entity);
            self.place(&mut edit, *spawn, &mut synced.refused);
        }
        for (entity, transform) in changes.moved {
            let Some(&Placed {
                mut spawn,
                representation,
            }) = self.entities.get(entity)
            else {
                synced.unknown.push(*entity);
                continue;
            };
            spawn.transform = *transform;
            if let Representation::Mesh(item) = representation
                && edit.set_transform(entity.sector, item, *transform).is_ok()
            {
                self.put(
                    *entity,
                    Some(Placed {
                        spawn,
                        representation,
                    }),
                );
            } else {
                self.remove(&mut edit, *entity);
                self.place(&mut edit, spawn, &mut synced.refused);
            }
        }
        match edit.finish() {
            Ok(edited) => {
                self.changed_meshes.clear();
                synced.edited = edited;
                Ok(synced)
            }
            Err(why) => {
                let mut before = std::mem::take(&mut self.before);
                for (entity, was) in before.drain(..).rev() {
                    self.put(entity, was);
                }
                Err(why)
            }
        }
    }

    /// Iterates over the keys of the entities that are no items of the scene and may be in view, each once per sector: hand
    /// them to [`VisibleKeys::update_with`](enfilade::VisibleKeys::update_with).
    ///
    /// `set` must be of the scene as it is since the last [`EntityMap::sync`]. If it is not
    /// [complete](VisibleSet::complete), keys may be missing here too.
    pub fn in_view_without_mesh(&self, set: &VisibleSet) -> impl Iterator<Item = u64> {
        let may_show = |entity: &Entity, bounds: &Aabb| {
            let passages = set.passages().iter();
            let mut into_sector = passages.filter(|passage| passage.sector == entity.sector);
            into_sector.any(|passage| passage.may_show(bounds))
        };
        let in_view =
            move |entry: &(&Entity, &Option<Aabb>)| entry.1.is_none_or(|bounds| may_show(entry.0, &bounds));
        self.outside.iter().filter(in_view).map(|(entity, _)| entity.key)
    }

    /// Places the entities anew whose mesh changed.
    fn replace_changed_meshes(&mut self, edit: &mut Edit, refused: &mut Vec<(Entity, EditError)>) {
        if self.changed_meshes.is_empty() {
            return;
        }
        let uses = |placed_entity: &&Placed| self.changed_meshes.contains(&placed_entity.spawn.mesh);
        let spawns: Vec<Spawn> = (self.entities.values().filter(uses))
            .map(|placed_entity| placed_entity.spawn)
            .collect();
        for spawn in spawns {
            self.remove(edit, spawn.entity);
            self.place(edit, spawn, refused);
        }
    }

    /// Removes an entity; returns `false` if there is none.
    fn remove(&mut self, edit: &mut Edit, entity: Entity) -> bool {
        let was = self.put(entity, None);
        if let Some(Placed {
            representation: Representation::Mesh(item),
            ..
        }) = was
        {
            // Refused only if another edit has removed the item.
            let _ = edit.remove(entity.sector, item);
        }
        was.is_some()
    }

    /// Adds an entity by its mesh, or else by its box, or else by nothing.
    fn place(&mut self, edit: &mut Edit, spawn: Spawn, refused: &mut Vec<(Entity, EditError)>) {
        let entity = spawn.entity;
        let item = self.meshes.get(&spawn.mesh).and_then(|mesh| {
            let added = add(edit, &spawn, Arc::clone(mesh));
            added.map_err(|why| refused.push((entity, why))).ok()
        });
        let sector_exists = (entity.sector.0 as usize) < edit.scene().sector_count();
        let representation = match (item, box_in_sector(&spawn)) {
            (Some(item), _) => Representation::Mesh(item),
            (None, Some(bounds)) if sector_exists => Representation::Box(bounds),
            _ => Representation::AlwaysVisible,
        };
        self.put(
            entity,
            Some(Placed {
                spawn,
                representation,
            }),
        );
    }

    /// Replaces the state of an entity, and notes and returns the previous one.
    fn put(&mut self, entity: Entity, placed_entity: Option<Placed>) -> Option<Placed> {
        match placed_entity.map(|placed_entity| placed_entity.representation) {
            Some(Representation::Box(bounds)) => self.outside.insert(entity, Some(bounds)),
            Some(Representation::AlwaysVisible) => self.outside.insert(entity, None),
            Some(Representation::Mesh(_)) | None => self.outside.remove(&entity),
        };
        let was = match placed_entity {
            Some(placed_entity) => self.entities.insert(entity, placed_entity),
            None => self.entities.remove(&entity),
        };
        self.before.push((entity, was));
        was
    }
}

/// Adds an item for an entity.
fn add(edit: &mut Edit, spawn: &Spawn, mesh: Arc<Mesh>) -> Result<ItemId, EditError> {
    let Entity { key, sector } = spawn.entity;
    let item = edit.add(sector, "", mesh, spawn.transform)?;
    edit.set_key(sector, item, key)?;
    let options = ItemOptions {
        is_occluder: spawn.is_occluder,
        ..ItemOptions::default()
    };
    edit.set_options(sector, item, options)?;
    Ok(item)
}

/// Returns the AABB of an entity in the space of its sector, rounded outwards; `None` if it is empty, not finite, or
/// out of range.
fn box_in_sector(spawn: &Spawn) -> Option<Aabb> {
    let Spawn {
        bounds, transform, ..
    } = spawn;
    let ends = || bounds.min.iter().chain(&bounds.max);
    if !transform.is_finite() || !ends().all(|end| end.is_finite()) || bounds.is_empty() {
        return None;
    }
    let there = Aabb::of(bounds.corners().map(|corner| transform.point(corner)));
    let grown = Aabb {
        min: there.min.map(f32::next_down),
        max: there.max.map(f32::next_up),
    };
    let in_range = |end: &f32| end.abs() <= MAX_COORDINATE;
    grown.min.iter().chain(&grown.max).all(in_range).then_some(grown)
}
