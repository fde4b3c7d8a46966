//! Adds, removes, moves and replaces items between looks.
//!
//! The changes of an edit are checked one by one and collected; then all of them are swapped with the current state, so
//! that swapping again undoes them. Item ids stay valid; a new item takes the lowest free id.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3: a small change touches a few
//!     nodes.
//! Cost: O(log items) per change; O(items) additions per edit if the number of faces of an item changes.

use super::builder::{MAX_OPENINGS, placed_bounds};
use super::slots::Slots;
use super::{Geometry, Item};
use crate::geom::{Aabb, Transform, is_in_range};
use crate::ids::{ItemIndex, MeshId};
use crate::mesh::Mesh;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, Weak};

/// The new or the previous state of an item.
#[derive(Clone, Debug)]
pub(crate) struct Placing {
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) place: [[f32; 3]; 4],
    pub(crate) is_occluder: bool,
}

/// Changes to swap in, item by item.
#[derive(Debug, Default)]
pub(crate) struct Changes {
    items: BTreeMap<ItemIndex, Change>,
    /// The last free id that was taken, and the number of ids appended after the last item.
    last_free: Option<u32>,
    appended: u32,
    /// Change of the total number of faces.
    more_faces: i64,
}

#[derive(Debug)]
struct Change {
    /// The new state; `None` removes the item.
    placing: Option<Placing>,
    bounds: Aabb,
    /// The new name, if it changes.
    name: Option<String>,
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
    pub(crate) meshes: BTreeSet<MeshId>,
    /// Number of nodes of the geometry's octree that were updated.
    pub(crate) nodes: u64,
}

/// Why the new state of an item is invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unfit {
    NotFinite,
    TooFar,
    NoFaces,
    NoSuchMaterial(u32),
    TooManyFaces,
}

impl Placing {
    /// Returns the current state of an item.
    fn at(geometry: &Geometry, item: ItemIndex) -> Placing {
        let placed = geometry.item(item);
        Placing {
            mesh: Arc::clone(&geometry.meshes[placed.mesh.0 as usize]),
            place: placed.sector_from_item,
            is_occluder: placed.is_occluder,
        }
    }

    /// Checks the new state; returns its AABB in the space of the sector.
    fn check(&self, geometry: &Geometry) -> Result<Aabb, Unfit> {
        let materials = geometry.materials.len();
        let clusters = self.mesh.clusters();
        if let Some(cluster) = clusters.iter().find(|c| c.material.0 as usize >= materials) {
            return Err(Unfit::NoSuchMaterial(cluster.material.0));
        }
        if clusters.is_empty() {
            return Err(Unfit::NoFaces);
        }
        let bounds = placed_bounds(&Transform::from_columns(self.place), &self.mesh);
        let values = || {
            bounds
                .min
                .iter()
                .chain(&bounds.max)
                .chain(self.place.iter().flatten())
        };
        if values().any(|value| value.is_nan()) {
            return Err(Unfit::NotFinite);
        }
        if values().any(|value| !is_in_range(*value)) {
            return Err(Unfit::TooFar);
        }
        Ok(bounds)
    }
}

impl Changes {
    /// Returns the state of an item after the changes; `None` if it does not exist then.
    fn placing(&self, geometry: &Geometry, item: ItemIndex) -> Option<Placing> {
        match self.items.get(&item) {
            Some(change) => change.placing.clone(),
            None => geometry.holds(item).then(|| Placing::at(geometry, item)),
        }
    }

    /// Returns the name of an item after the changes.
    pub(crate) fn name<'a>(&'a self, geometry: &'a Geometry, item: ItemIndex) -> &'a str {
        let change = self.items.get(&item).and_then(|change| change.name.as_deref());
        change.unwrap_or_else(|| {
            if geometry.holds(item) {
                geometry.name(item)
            } else {
                ""
            }
        })
    }

    /// Applies `change` to the state of an item; `None` if there is no such item.
    pub(crate) fn change(
        &mut self,
        geometry: &Geometry,
        item: ItemIndex,
        change: impl FnOnce(Placing) -> Option<Placing>,
    ) -> Option<Result<(), Unfit>> {
        let was = self.placing(geometry, item)?;
        let had = was.mesh.face_count();
        Some(self.set(geometry, item, had, change(was)))
    }

    /// Sets the new state of an item that has `had` faces so far.
    fn set(
        &mut self,
        geometry: &Geometry,
        item: ItemIndex,
        had: u32,
        placing: Option<Placing>,
    ) -> Result<(), Unfit> {
        let bounds = placing
            .as_ref()
            .map_or(Ok(Aabb::EMPTY), |placing| placing.check(geometry))?;
        let faces = placing.as_ref().map_or(0, |placing| placing.mesh.face_count());
        let more_faces = self.more_faces + i64::from(faces) - i64::from(had);
        if geometry.face_count() as i64 + more_faces > i64::from(u32::MAX) - MAX_OPENINGS as i64 {
            return Err(Unfit::TooManyFaces);
        }
        self.more_faces = more_faces;
        let change = self.items.entry(item).or_insert(Change {
            placing: None,
            bounds,
            name: None,
        });
        change.bounds = bounds;
        change.placing = placing;
        Ok(())
    }

    /// Adds an item; returns its id.
    pub(crate) fn add(
        &mut self,
        geometry: &Geometry,
        name: &str,
        placing: Placing,
    ) -> Result<ItemIndex, Unfit> {
        let next = self.last_free.map_or(0, |last| last + 1);
        let free = geometry
            .slots
            .as_ref()
            .and_then(|slots| slots.free_items.range(next..).next().copied());
        let item = ItemIndex(free.unwrap_or(geometry.items.len() as u32 + self.appended));
        self.set(geometry, item, 0, Some(placing))?;
        match free {
            Some(number) => self.last_free = Some(number),
            None => self.appended += 1,
        }
        if let Some(change) = self.items.get_mut(&item) {
            change.name = Some(name.to_owned());
        }
        Ok(item)
    }

    /// Returns `true` if there are no changes.
    pub(crate) fn is_empty(&self) -> bool {
        self.items.is_empty()
    }
}

impl Geometry {
    /// Swaps the items with those of `changes`; swapping again undoes it.
    pub(crate) fn exchange(&mut self, changes: &mut Changes) -> Exchanged {
        let mut done = Exchanged::default();
        let known = self.slots.take();
        let mut slots = known.unwrap_or_else(|| {
            let slots = Slots::new(&mut self.meshes, &self.items);
            done.meshes.insert(slots.nothing);
            slots
        });
        let mut left = Vec::new();
        let mut renumbered = self.items.len();
        for (&item, change) in &mut changes.items {
            if item.0 as usize == self.items.len() {
                self.push_nothing(&mut slots);
            }
            let (was, had) = (self.item(item).bounds, self.mesh_of(item).face_count());
            left.extend(self.exchange_one(item, change, &mut slots, &mut done));
            if self.mesh_of(item).face_count() != had {
                renumbered = renumbered.min(item.0 as usize);
            }
            done.moved.push(MovedItem {
                item,
                old_bounds: was,
            });
        }
        changes.more_faces = -changes.more_faces;
        // Last, because another item may have started to use a mesh that one item left.
        let unused = left
            .into_iter()
            .filter(|&mesh| slots.drop_unused(mesh, &mut self.meshes));
        done.meshes.extend(unused);
        self.slots = Some(slots);
        self.renumber(renumbered);
        self.follow(&mut done);
        self.shared = Mutex::new(Weak::<()>::new());
        done
    }

    /// Appends an empty item slot.
    fn push_nothing(&mut self, slots: &mut Slots) {
        let number = self.items.len();
        self.items.push(Item::nothing(slots.nothing));
        self.names.push("");
        self.first_faces.push(self.first_faces[number]);
        slots.free_items.insert(number as u32);
    }

    /// Swaps one item; returns the mesh that it no longer uses.
    fn exchange_one(
        &mut self,
        item: ItemIndex,
        change: &mut Change,
        slots: &mut Slots,
        done: &mut Exchanged,
    ) -> Option<MeshId> {
        let number = item.0 as usize;
        let had = self.items[number].mesh;
        if let Some(after) = &mut change.placing
            && Arc::ptr_eq(&after.mesh, &self.meshes[had.0 as usize])
        {
            let Item {
                sector_from_item,
                bounds,
                is_occluder,
                ..
            } = &mut self.items[number];
            std::mem::swap(sector_from_item, &mut after.place);
            std::mem::swap(bounds, &mut change.bounds);
            std::mem::swap(is_occluder, &mut after.is_occluder);
            return None;
        }
        let before = (!slots.free_items.contains(&item.0)).then(|| Placing::at(self, item));
        let after = std::mem::replace(&mut change.placing, before);
        let bounds = std::mem::replace(&mut change.bounds, self.items[number].bounds);
        if let Some(name) = &mut change.name {
            let before = self.names.get(number).to_owned();
            self.names.set(number, &std::mem::replace(name, before));
        }
        self.items[number] = match after {
            Some(after) => {
                let (mesh, is_new) = slots.take(&after.mesh, &mut self.meshes);
                done.meshes.extend(is_new.then_some(mesh));
                slots.free_items.remove(&item.0);
                Item {
                    mesh,
                    sector_from_item: after.place,
                    bounds,
                    is_occluder: after.is_occluder,
                }
            }
            None => {
                slots.free_items.insert(item.0);
                Item::nothing(slots.nothing)
            }
        };
        let left = change.placing.is_some().then_some(had);
        left.into_iter().for_each(|mesh| slots.give_back(mesh));
        left
    }

    /// Recomputes the face numbers from item `from` on.
    fn renumber(&mut self, from: usize) {
        for item in from..self.items.len() {
            let faces = self.meshes[self.items[item].mesh.0 as usize].face_count();
            self.first_faces[item + 1] = self.first_faces[item] + faces;
        }
    }

    /// Updates the octree over the items, if it was built, and the AABB of the geometry.
    fn follow(&mut self, done: &mut Exchanged) {
        let items = &self.items;
        let boxes = |item: u32| items[item as usize].bounds;
        let all = if let Some(tree) = self.item_tree.get_mut() {
            let mut touched = Vec::new();
            for MovedItem { item, old_bounds } in &done.moved {
                tree.shift(item.0, old_bounds, &boxes, &mut touched);
            }
            done.nodes = touched.len() as u64;
            tree.tidy(items.len(), &boxes);
            tree.root().map_or(Aabb::EMPTY, |root| *tree.bounds(root))
        } else {
            items
                .iter()
                .fold(Aabb::EMPTY, |sum, item| sum.union(&item.bounds))
        };
        let holes = self
            .opening_tree
            .root()
            .map(|root| self.opening_tree.bounds(root));
        self.bounds = holes.map_or(all, |holes| all.union(holes));
    }
}

impl Item {
    /// Returns the content of an empty slot; `mesh` has no faces.
    fn nothing(mesh: MeshId) -> Item {
        Item {
            mesh,
            sector_from_item: Transform::IDENTITY.columns(),
            bounds: Aabb::EMPTY,
            is_occluder: true,
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
            names: self.names.clone(),
            slots: self.slots.clone(),
            openings: self.openings.clone(),
            cells: self.cells.clone(),
            #[cfg(feature = "terrain")]
            terrains: self.terrains.clone(),
            item_tree: self.item_tree.clone(),
            opening_tree: self.opening_tree.clone(),
            outline_corners: self.outline_corners.clone(),
            outline_ends: self.outline_ends.clone(),
            first_faces: self.first_faces.clone(),
            bounds: self.bounds,
            shared: Mutex::new(Weak::<()>::new()),
        }
    }
}
