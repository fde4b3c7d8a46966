//! The entities of an engine, and the items of a scene that represent them.
//!
//! Idea: an entity is an item of the scene, by its mesh or else by [`Mesh::bounds_only`]. What the scene refuses either
//! way is listed in every view. Cost: O(log entities) per change, besides that of [`Edit`].

use enfilade::{
    Aabb, Edit, EditError, EditStats, ItemId, ItemOptions, Mesh, Scene, SceneError, SectorId, Transform,
};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// An entity of the engine in one sector.
///
/// An entity that reaches through a doorway is spawned in each sector that it reaches into, with the same key. To move
/// an entity to another sector, despawn it in one and spawn it in the other. Before a sector is removed, despawn its
/// entities.
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
    /// How it takes part in looks. Turn `is_occluder` off if what is drawn may be smaller than the mesh, as for animated
    /// meshes.
    pub options: ItemOptions,
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
    /// Entities with a mesh that the scene refused, and the reason. They are represented otherwise until a later change
    /// of them is accepted; see [`Representation`].
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
    /// By an item of the scene with its box alone, because its mesh is absent or was refused: it is culled as others, and
    /// hides nothing.
    Box(ItemId),
    /// By nothing, because the scene refused its box too: it is empty, not finite or out of range, or its sector does not
    /// exist. It is listed in every view.
    AlwaysVisible,
}

/// An entity that exists.
#[derive(Clone, Copy, Debug)]
struct PlacedEntity {
    spawn: Spawn,
    representation: Representation,
}

/// The entities of an engine that a scene represents. Use it with one scene only, whose items of these entities are
/// edited through it alone.
#[derive(Debug, Default)]
pub struct EntityMap {
    meshes: BTreeMap<u64, Arc<Mesh>>,
    /// In a fixed order, as all maps here: visible sets depend on the order of additions where faces coincide.
    entities: BTreeMap<Entity, PlacedEntity>,
    /// The entities without an item.
    always_visible: BTreeSet<Entity>,
    /// The meshes that changed since the last sync.
    changed_meshes: BTreeSet<u64>,
    /// The entities as they were before this sync, in the order of changes.
    before: Vec<(Entity, Option<PlacedEntity>)>,
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
            let Some(held) = self.entities.get_mut(entity) else {
                synced.unknown.push(*entity);
                continue;
            };
            let was = *held;
            held.spawn.transform = *transform;
            let spawn = held.spawn;
            self.before.push((*entity, Some(was)));
            let (Representation::Mesh(item) | Representation::Box(item)) = was.representation else {
                self.place(&mut edit, spawn, &mut synced.refused);
                continue;
            };
            if edit.set_transform(entity.sector, item, *transform).is_err() {
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

    /// Iterates over the keys of the entities that no item represents, each once per sector: hand them to
    /// [`VisibleKeys::update_with`](enfilade::VisibleKeys::update_with).
    pub fn always_visible(&self) -> impl Iterator<Item = u64> {
        self.always_visible.iter().map(|entity| entity.key)
    }

    /// Places the entities anew whose mesh changed.
    fn replace_changed_meshes(&mut self, edit: &mut Edit, refused: &mut Vec<(Entity, EditError)>) {
        if self.changed_meshes.is_empty() {
            return;
        }
        let uses = |placed_entity: &&PlacedEntity| self.changed_meshes.contains(&placed_entity.spawn.mesh);
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
        if let Some(PlacedEntity {
            representation: Representation::Mesh(item) | Representation::Box(item),
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
        let by_mesh = self.meshes.get(&spawn.mesh).and_then(|mesh| {
            let added = add(edit, &spawn, Arc::clone(mesh));
            added.map_err(|why| refused.push((entity, why))).ok()
        });
        let mut by_box = || add(edit, &spawn, Arc::new(mesh_of_box(&spawn.bounds)?)).ok();
        let representation = match by_mesh {
            Some(item) => Representation::Mesh(item),
            None => by_box().map_or(Representation::AlwaysVisible, Representation::Box),
        };
        self.put(
            entity,
            Some(PlacedEntity {
                spawn,
                representation,
            }),
        );
    }

    /// Replaces the state of an entity, and notes and returns the previous one.
    fn put(&mut self, entity: Entity, placed_entity: Option<PlacedEntity>) -> Option<PlacedEntity> {
        match placed_entity.map(|placed_entity| placed_entity.representation) {
            Some(Representation::AlwaysVisible) => self.always_visible.insert(entity),
            _ => self.always_visible.remove(&entity),
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
    edit.set_options(sector, item, spawn.options)?;
    Ok(item)
}

/// Returns a mesh for a box, grown where it is flat; `None` if it is empty, not finite, or out of range.
fn mesh_of_box(bounds: &Aabb) -> Option<Mesh> {
    let flat = |axis: usize| bounds.min[axis] == bounds.max[axis];
    let min = [0, 1, 2].map(|axis| {
        if flat(axis) {
            bounds.min[axis].next_down()
        } else {
            bounds.min[axis]
        }
    });
    let max = [0, 1, 2].map(|axis| {
        if flat(axis) {
            bounds.max[axis].next_up()
        } else {
            bounds.max[axis]
        }
    });
    Mesh::bounds_only(min, max).ok()
}
