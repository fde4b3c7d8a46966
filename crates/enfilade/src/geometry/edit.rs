//! Adds, removes, moves and replaces items, and adds and removes openings, between looks.
//!
//! The changes of an edit are checked one by one and collected; then all of them are swapped with the current state, so
//! that swapping again undoes them. Ids stay valid; a new item takes the lowest free index.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3: a small change touches a few
//!     nodes.
//! Cost: O(1) to collect a change, O(log items) to apply it; O(items) additions per edit if the number of faces of an
//!     item changes; O(openings) per edit that changes these. Changes that move items allocate nothing once the buffers
//!     have grown.

use super::builder::placed_bounds;
use super::openings::{MAX_OPENINGS, Openings};
use super::slots::Slots;
use super::{BakedCells, Geometry, Item, ItemLabel, ItemOptions, Opening};
use crate::geom::{Aabb, Transform, is_in_range};
use crate::ids::{ItemId, ItemIndex, MeshId, OpeningId};
use crate::mesh::{Cluster, Mesh};
use std::sync::{Arc, Mutex, Weak};

/// Changes to swap in, item by item. Keeps its buffers from edit to edit.
#[derive(Debug, Default)]
pub(crate) struct Changes {
    /// One for each changed item: in the order of requests, and sorted by item once they are applied.
    list: Vec<Change>,
    /// For each item one more than the index of its change in `list`; 0 if it has none, as beyond the end.
    places: Vec<u32>,
    /// The last free index that was taken, and the number of indices appended after the last item.
    last_free: Option<u32>,
    appended: u32,
    /// Change of the total number of faces.
    more_faces: i64,
    /// The last generation that was given to an item, by this edit or an earlier one.
    generation: u32,
    /// The new or, once swapped in, the previous openings; `None` if they do not change.
    openings: Option<OpeningsChange>,
    pub(crate) exchanged: Exchanged,
}

/// The openings after the changes, and which of them existed before.
#[derive(Debug)]
pub(crate) struct OpeningsChange {
    list: Vec<Opening>,
    /// For each opening after the changes its id before; `None` if it is new.
    pub(crate) ids_before: Vec<Option<OpeningId>>,
    /// The baked PVS after the changes: none if an opening was removed, because a line of sight may go on there.
    cells: Option<Arc<BakedCells>>,
}

/// The new or, once swapped in, the previous state of an item.
#[derive(Debug)]
struct Change {
    item: ItemIndex,
    sector_from_item: [[f32; 3]; 4],
    bounds: Aabb,
    /// What else changes. Most items only move, often thousands in an edit, so it is stored apart.
    rest: Option<Box<Rest>>,
}

/// What rarely changes.
#[derive(Debug)]
struct Rest {
    mesh: MeshChange,
    options: ItemOptions,
    key: u64,
    generation: u32,
    /// The new name, if it changes.
    name: Option<String>,
}

/// The mesh after a change.
#[derive(Debug)]
enum MeshChange {
    /// The item exists before and after, with the same mesh.
    Same,
    /// The item exists after the change, with this mesh.
    New(Arc<Mesh>),
    /// The item does not exist after the change.
    Gone,
}

/// An item that an edit changed, and the AABB that it had before.
#[derive(Clone, Copy, Debug)]
pub struct MovedItem {
    /// The item. Its current AABB is in the geometry, and empty if the item was removed.
    pub item: ItemIndex,
    /// Previous AABB, in the space of the sector; empty if the item was added.
    pub old_bounds: Aabb,
}

/// The result of an exchange.
#[derive(Debug, Default)]
pub(crate) struct Exchanged {
    /// Sorted by item.
    pub(crate) moved: Vec<MovedItem>,
    /// The mesh slots with another mesh than before, sorted.
    pub(crate) meshes: Vec<MeshId>,
    /// The nodes of the tree updated last; scratch memory.
    pub(crate) touched: Vec<u32>,
    /// Number of nodes of the geometry's octree that were updated.
    pub(crate) nodes: u64,
    /// Meshes that items no longer use; scratch memory.
    left: Vec<MeshId>,
}

/// Why the new state of an item is invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unfit {
    NoSuchItem,
    NotFinite,
    TooFar,
    NoFaces,
    NoSuchMaterial(u32),
    TooManyFaces,
}

/// An item without its place.
pub(crate) struct ItemState {
    pub(crate) name: String,
    pub(crate) key: u64,
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) options: ItemOptions,
}

/// The maximum number of openings is reached.
pub(crate) struct TooManyOpenings;

impl Changes {
    /// Replaces the transform of an item.
    pub(crate) fn set_transform(
        &mut self,
        geometry: &Geometry,
        item: ItemId,
        sector_from_item: [[f32; 3]; 4],
    ) -> Result<(), Unfit> {
        self.check_exists(geometry, item)?;
        let bounds = bounds_of(self.mesh_of(geometry, item.index), &sector_from_item)?;
        let change = self.change_of(geometry, item.index);
        (change.sector_from_item, change.bounds) = (sector_from_item, bounds);
        Ok(())
    }

    /// Replaces the mesh of an item.
    pub(crate) fn set_mesh(
        &mut self,
        geometry: &Geometry,
        item: ItemId,
        mesh: Arc<Mesh>,
    ) -> Result<(), Unfit> {
        self.check_exists(geometry, item)?;
        check_mesh(geometry, &mesh)?;
        let had = self.mesh_of(geometry, item.index).face_count();
        let more_faces = self.with_faces(geometry, i64::from(mesh.face_count()) - i64::from(had))?;
        let placed = self.get(item.index).map(|change| change.sector_from_item);
        let sector_from_item = placed.unwrap_or(geometry.item(item.index).sector_from_item);
        let bounds = bounds_of(&mesh, &sector_from_item)?;
        self.more_faces = more_faces;
        self.change_of(geometry, item.index).bounds = bounds;
        let is_held = geometry.index_of(item).is_some();
        self.rest_of(geometry, item.index).mesh =
            if is_held && Arc::ptr_eq(&mesh, geometry.mesh_arc(item.index)) {
                MeshChange::Same
            } else {
                MeshChange::New(mesh)
            };
        Ok(())
    }

    /// Sets how an item takes part in looks.
    pub(crate) fn set_options(
        &mut self,
        geometry: &Geometry,
        item: ItemId,
        options: ItemOptions,
    ) -> Result<(), Unfit> {
        self.check_exists(geometry, item)?;
        self.rest_of(geometry, item.index).options = options;
        Ok(())
    }

    /// Sets the key of an item.
    pub(crate) fn set_key(&mut self, geometry: &Geometry, item: ItemId, key: u64) -> Result<(), Unfit> {
        self.check_exists(geometry, item)?;
        self.rest_of(geometry, item.index).key = key;
        Ok(())
    }

    /// Removes an item.
    pub(crate) fn remove(&mut self, geometry: &Geometry, item: ItemId) -> Result<(), Unfit> {
        self.check_exists(geometry, item)?;
        self.more_faces -= i64::from(self.mesh_of(geometry, item.index).face_count());
        self.change_of(geometry, item.index).bounds = Aabb::EMPTY;
        self.rest_of(geometry, item.index).mesh = MeshChange::Gone;
        Ok(())
    }

    /// Adds an item; returns its id.
    pub(crate) fn add(
        &mut self,
        geometry: &Geometry,
        name: &str,
        mesh: Arc<Mesh>,
        sector_from_item: [[f32; 3]; 4],
    ) -> Result<ItemId, Unfit> {
        check_mesh(geometry, &mesh)?;
        let more_faces = self.with_faces(geometry, i64::from(mesh.face_count()))?;
        let bounds = bounds_of(&mesh, &sector_from_item)?;
        self.more_faces = more_faces;
        let index = self.next_index(geometry);
        if (index.0 as usize) < geometry.items.len() {
            self.last_free = Some(index.0);
        } else {
            self.appended += 1;
        }
        // Counts on even if the edit is discarded: its ids must not name items of a later one.
        let last = geometry.slots.as_ref().map_or(0, |slots| slots.last_generation);
        let generation = 1 + self.generation.max(last);
        self.generation = generation;
        self.push(Change {
            item: index,
            sector_from_item,
            bounds,
            rest: Some(Box::new(Rest {
                mesh: MeshChange::New(mesh),
                options: ItemOptions::default(),
                key: u64::from(index.0),
                generation,
                name: Some(name.to_owned()),
            })),
        });
        Ok(ItemId { index, generation })
    }

    /// Returns what an item takes along to another sector.
    pub(crate) fn state(&self, geometry: &Geometry, item: ItemId) -> Result<ItemState, Unfit> {
        self.check_exists(geometry, item)?;
        let ItemLabel { name, key } = self.label(geometry, item.index);
        let rest = self.get(item.index).and_then(|change| change.rest.as_ref());
        Ok(ItemState {
            name,
            key,
            mesh: Arc::clone(self.mesh_of(geometry, item.index)),
            options: rest.map_or_else(|| geometry.item(item.index).options, |rest| rest.options),
        })
    }

    /// Returns the index that the next added item gets: the lowest free one.
    pub(crate) fn next_index(&self, geometry: &Geometry) -> ItemIndex {
        let next = self.last_free.map_or(0, |last| last + 1);
        let slots = geometry.slots.as_ref();
        let free = slots.and_then(|slots| slots.free_items.range(next..).next().copied());
        ItemIndex(free.unwrap_or(geometry.items.len() as u32 + self.appended))
    }

    /// Returns the name and the key of an existing item after the changes.
    pub(crate) fn label(&self, geometry: &Geometry, item: ItemIndex) -> ItemLabel {
        let rest = self.get(item).and_then(|change| change.rest.as_ref());
        let name = rest.and_then(|rest| rest.name.as_deref());
        ItemLabel {
            name: name.unwrap_or_else(|| geometry.name(item)).to_owned(),
            key: rest.map_or_else(|| geometry.key(item), |rest| rest.key),
        }
    }

    /// Adds an opening; returns its id.
    pub(crate) fn add_opening(
        &mut self,
        geometry: &Geometry,
        opening: Opening,
    ) -> Result<OpeningId, TooManyOpenings> {
        let change = self.openings_of(geometry);
        let id = change.ids_before.len();
        if id >= MAX_OPENINGS {
            return Err(TooManyOpenings);
        }
        change.list.push(opening);
        change.ids_before.push(None);
        Ok(OpeningId(id as u16))
    }

    /// Removes an opening, and gives its id to the last one; returns `false` if there is none.
    pub(crate) fn remove_opening(&mut self, geometry: &Geometry, opening: OpeningId) -> bool {
        let number = usize::from(opening.0);
        if number >= self.opening_count(geometry) {
            return false;
        }
        let change = self.openings_of(geometry);
        change.list.swap_remove(number);
        change.ids_before.swap_remove(number);
        change.cells = None;
        true
    }

    /// Returns the number of openings after the changes.
    pub(crate) fn opening_count(&self, geometry: &Geometry) -> usize {
        let change = self.openings.as_ref();
        change.map_or(geometry.openings().len(), |change| change.ids_before.len())
    }

    fn openings_of(&mut self, geometry: &Geometry) -> &mut OpeningsChange {
        self.openings.get_or_insert_with(|| OpeningsChange {
            list: geometry.openings().to_vec(),
            ids_before: (0..geometry.openings().len() as u16)
                .map(|id| Some(OpeningId(id)))
                .collect(),
            cells: geometry.cells.clone(),
        })
    }

    /// Returns the changes of openings, if there are any.
    pub(crate) fn openings(&self) -> Option<&OpeningsChange> {
        self.openings.as_ref()
    }

    /// Returns `true` if there are no changes.
    pub(crate) fn is_empty(&self) -> bool {
        self.list.is_empty() && self.openings.is_none()
    }

    /// Discards all changes.
    pub(crate) fn clear(&mut self) {
        for change in self.list.drain(..) {
            self.places[change.item.0 as usize] = 0;
        }
        self.last_free = None;
        self.appended = 0;
        self.more_faces = 0;
        self.openings = None;
    }

    fn get(&self, item: ItemIndex) -> Option<&Change> {
        let place = self.places.get(item.0 as usize).copied().unwrap_or(0);
        self.list.get((place as usize).wrapping_sub(1))
    }

    /// Checks that an item exists after the changes so far.
    fn check_exists(&self, geometry: &Geometry, item: ItemId) -> Result<(), Unfit> {
        let exists = match self.get(item.index).and_then(|change| change.rest.as_ref()) {
            Some(rest) => !matches!(rest.mesh, MeshChange::Gone) && rest.generation == item.generation,
            None => geometry.index_of(item).is_some(),
        };
        exists.then_some(()).ok_or(Unfit::NoSuchItem)
    }

    /// Returns the mesh of an existing item after the changes so far.
    fn mesh_of<'a>(&'a self, geometry: &'a Geometry, item: ItemIndex) -> &'a Arc<Mesh> {
        match self.get(item).and_then(|change| change.rest.as_ref()) {
            Some(rest) => match &rest.mesh {
                MeshChange::New(mesh) => mesh,
                _ => geometry.mesh_arc(item),
            },
            None => geometry.mesh_arc(item),
        }
    }

    /// Returns the change of an existing item; one that changes nothing if there was none yet.
    fn change_of(&mut self, geometry: &Geometry, item: ItemIndex) -> &mut Change {
        if self.get(item).is_none() {
            let placed = geometry.item(item);
            self.push(Change {
                item,
                sector_from_item: placed.sector_from_item,
                bounds: placed.bounds,
                rest: None,
            });
        }
        let place = self.places[item.0 as usize] as usize;
        &mut self.list[place - 1]
    }

    fn rest_of(&mut self, geometry: &Geometry, item: ItemIndex) -> &mut Rest {
        self.change_of(geometry, item).rest.get_or_insert_with(|| {
            Box::new(Rest {
                mesh: MeshChange::Same,
                options: geometry.item(item).options,
                key: geometry.key(item),
                generation: geometry.id_of(item).generation,
                name: None,
            })
        })
    }

    fn push(&mut self, change: Change) {
        let item = change.item.0 as usize;
        if self.places.len() <= item {
            self.places.resize(item + 1, 0);
        }
        self.list.push(change);
        self.places[item] = self.list.len() as u32;
    }

    /// Returns the change of the total number of faces if `more` are added to it.
    fn with_faces(&self, geometry: &Geometry, more: i64) -> Result<i64, Unfit> {
        let more_faces = self.more_faces + more;
        if geometry.face_count() as i64 + more_faces > i64::from(u32::MAX) - MAX_OPENINGS as i64 {
            return Err(Unfit::TooManyFaces);
        }
        Ok(more_faces)
    }
}

impl Clone for Changes {
    /// Returns no changes: a scene is copied without those of an edit that was leaked.
    fn clone(&self) -> Changes {
        Changes {
            generation: self.generation,
            ..Changes::default()
        }
    }
}

/// Checks that a mesh has faces, and only materials of the geometry.
fn check_mesh(geometry: &Geometry, mesh: &Mesh) -> Result<(), Unfit> {
    let materials = geometry.materials.len();
    let clusters = mesh.clusters();
    let is_unknown = |c: &&Cluster| !c.faces.is_empty() && c.material.0 as usize >= materials;
    match clusters.iter().find(is_unknown) {
        Some(cluster) => Err(Unfit::NoSuchMaterial(cluster.material.0)),
        None if clusters.is_empty() => Err(Unfit::NoFaces),
        None => Ok(()),
    }
}

/// Returns the AABB of a transformed mesh in the space of the sector, if it is in range.
fn bounds_of(mesh: &Mesh, sector_from_item: &[[f32; 3]; 4]) -> Result<Aabb, Unfit> {
    let bounds = placed_bounds(&Transform::from_columns(*sector_from_item), mesh);
    let values = sector_from_item.as_flattened();
    if bounds.is_in_range() && values.iter().all(|&value| is_in_range(value)) {
        Ok(bounds)
    } else if values.iter().any(|value| value.is_nan()) {
        Err(Unfit::NotFinite)
    } else {
        Err(Unfit::TooFar)
    }
}

impl Geometry {
    fn mesh_arc(&self, item: ItemIndex) -> &Arc<Mesh> {
        &self.meshes[self.item(item).mesh.0 as usize]
    }

    /// Swaps items and openings with those of `changes`; swapping again undoes it. [`Changes::exchanged`] holds what was
    /// done.
    pub(crate) fn exchange(&mut self, changes: &mut Changes) {
        let Changes {
            list,
            openings,
            exchanged: done,
            ..
        } = changes;
        if let Some(change) = openings {
            let after = Openings::new(std::mem::take(&mut change.list));
            change.list = std::mem::replace(&mut self.openings, after).list;
            std::mem::swap(&mut self.cells, &mut change.cells);
        }
        // So that trees do not depend on the order of requests, and new items are appended in order.
        if !list.is_sorted_by_key(|change| change.item) {
            list.sort_unstable_by_key(|change| change.item);
        }
        for buffer in [&mut done.meshes, &mut done.left] {
            buffer.clear();
        }
        done.moved.clear();
        done.nodes = 0;
        let known = self.slots.take();
        let mut slots = known.unwrap_or_else(|| {
            let slots = Slots::new(&mut self.meshes, &self.items);
            done.meshes.push(slots.nothing);
            slots
        });
        let (mut has_new_faces, mut has_new_kinds) = (false, false);
        for change in list {
            let item = change.item;
            if item.0 as usize == self.items.len() {
                self.push_nothing(&mut slots);
            }
            let placed = &mut self.items[item.0 as usize];
            std::mem::swap(&mut placed.sector_from_item, &mut change.sector_from_item);
            std::mem::swap(&mut placed.bounds, &mut change.bounds);
            done.moved.push(MovedItem {
                item,
                old_bounds: change.bounds,
            });
            if let Some(rest) = &mut change.rest {
                let had = self.mesh_of(item).face_count();
                self.exchange_rest(item, rest, &mut slots, done);
                has_new_faces |= self.mesh_of(item).face_count() != had;
                let options = [&self.items[item.0 as usize].options, &rest.options];
                has_new_kinds |= options.iter().any(|now| now.never_cull || !now.is_drawn);
            }
        }
        changes.more_faces = -changes.more_faces;
        // Last, because another item may have started to use a mesh that one item left.
        let unused = done.left.drain(..);
        done.meshes
            .extend(unused.filter(|&mesh| slots.drop_unused(mesh, &mut self.meshes)));
        done.meshes.sort_unstable();
        done.meshes.dedup();
        self.slots = Some(slots);
        if has_new_faces {
            self.renumber(&done.moved);
        }
        if has_new_kinds {
            self.list_kinds();
        }
        self.follow(done);
        self.shared = Mutex::new(Weak::<()>::new());
    }

    /// Appends an empty item slot.
    fn push_nothing(&mut self, slots: &mut Slots) {
        let number = self.items.len();
        self.items.push(Item::nothing(slots.nothing));
        self.keys.push(0);
        self.names.push("");
        self.first_faces.push(self.first_faces[number]);
        slots.generations.push(0);
        slots.free_items.insert(number as u32);
    }

    /// Swaps what is stored apart of one item.
    fn exchange_rest(&mut self, item: ItemIndex, rest: &mut Rest, slots: &mut Slots, done: &mut Exchanged) {
        let number = item.0 as usize;
        let placed = &mut self.items[number];
        std::mem::swap(&mut placed.options, &mut rest.options);
        std::mem::swap(&mut self.keys[number], &mut rest.key);
        std::mem::swap(&mut slots.generations[number], &mut rest.generation);
        if matches!(rest.mesh, MeshChange::Same) {
            return;
        }
        slots.last_generation = slots.last_generation.max(slots.generations[number]);
        let had = placed.mesh;
        let before = if had == slots.nothing {
            MeshChange::Gone
        } else {
            done.left.push(had);
            slots.give_back(had);
            MeshChange::New(Arc::clone(&self.meshes[had.0 as usize]))
        };
        placed.mesh = match std::mem::replace(&mut rest.mesh, before) {
            MeshChange::New(after) => {
                let (mesh, is_new) = slots.take(&after, &mut self.meshes);
                done.meshes.extend(is_new.then_some(mesh));
                slots.free_items.remove(&item.0);
                mesh
            }
            _ => {
                slots.free_items.insert(item.0);
                slots.nothing
            }
        };
        if let Some(name) = &mut rest.name {
            let before = self.names.get(number).to_owned();
            self.names.set(number, &std::mem::replace(name, before));
        }
    }

    /// Recomputes the face numbers after items have changed. The meshes of others are not touched: in large scenes, hardly any
    /// of them is in the cache.
    fn renumber(&mut self, changed: &[MovedItem]) {
        let mut changed = changed.iter().map(|moved| moved.item.0 as usize).peekable();
        let from = changed.peek().copied().unwrap_or(self.items.len());
        let mut start = self.first_faces[from];
        for item in from..self.items.len() {
            let end = self.first_faces[item + 1];
            let is_changed = changed.next_if_eq(&item).is_some();
            debug_assert!(
                changed.peek().is_none_or(|&next| next > item),
                "each item changes once"
            );
            let faces = if is_changed {
                self.meshes[self.items[item].mesh.0 as usize].face_count()
            } else {
                end - start
            };
            self.first_faces[item + 1] = self.first_faces[item] + faces;
            start = end;
        }
    }

    /// Updates the octree over the items, if it was built, and the AABB of the geometry.
    fn follow(&mut self, done: &mut Exchanged) {
        let items = &self.items;
        let boxes = |item: u32| items[item as usize].bounds;
        let all = if let Some(tree) = self.item_tree.get_mut() {
            done.touched.clear();
            for MovedItem { item, old_bounds } in &done.moved {
                tree.shift(item.0, old_bounds, &boxes, &mut done.touched);
            }
            done.nodes = done.touched.len() as u64;
            tree.tidy(items.len(), &boxes);
            tree.root().map_or(Aabb::EMPTY, |root| *tree.bounds(root))
        } else {
            items
                .iter()
                .fold(Aabb::EMPTY, |sum, item| sum.union(&item.bounds))
        };
        self.bounds = all.union(&self.openings.bounds());
    }
}

impl Item {
    /// Returns the content of an empty slot; `mesh` has no faces.
    fn nothing(mesh: MeshId) -> Item {
        Item {
            mesh,
            sector_from_item: Transform::IDENTITY.columns(),
            bounds: Aabb::EMPTY,
            options: ItemOptions::default(),
        }
    }
}

impl Clone for Geometry {
    /// Returns a deep copy, except that meshes, materials, textures and cells are shared.
    fn clone(&self) -> Geometry {
        Geometry {
            meshes: self.meshes.clone(),
            materials: Arc::clone(&self.materials),
            textures: Arc::clone(&self.textures),
            items: self.items.clone(),
            keys: self.keys.clone(),
            names: self.names.clone(),
            never_culled: self.never_culled.clone(),
            not_drawn: self.not_drawn.clone(),
            slots: self.slots.clone(),
            openings: self.openings.clone(),
            cells: self.cells.clone(),
            #[cfg(feature = "terrain")]
            terrains: self.terrains.clone(),
            item_tree: self.item_tree.clone(),
            first_faces: self.first_faces.clone(),
            bounds: self.bounds,
            shared: Mutex::new(Weak::<()>::new()),
        }
    }
}
