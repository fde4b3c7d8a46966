//! Rooms: which entity is in which.

use crate::components::Sector;
use bevy_ecs::prelude::*;
use bevy_platform::collections::HashMap;
use enfilade::{Aabb, SectorId};

/// The sector of all that is in no room.
pub(crate) const OUTDOORS: SectorId = SectorId(0);

/// The entities with a [`Sector`], and the boxes of what they own.
#[derive(Default)]
pub(crate) struct Rooms {
    pub(crate) sectors: HashMap<Entity, SectorId>,
    /// Smallest first. Not the boxes of the scene's sectors: what reaches into a room does not make it larger.
    pub(crate) boxes: Vec<(SectorId, Aabb)>,
}

impl Rooms {
    pub(crate) fn is_empty(&self) -> bool {
        self.sectors.is_empty()
    }

    /// Returns the room that an entity is, or is a descendant of.
    pub(crate) fn owner(&self, entity: Entity, parents: &Query<&ChildOf>) -> Option<SectorId> {
        if self.is_empty() {
            return None;
        }
        std::iter::once(entity)
            .chain(parents.iter_ancestors(entity))
            .find_map(|ancestor| self.sectors.get(&ancestor).copied())
    }

    /// Returns where what is in no room is: outdoors, and in each room whose box it reaches into.
    pub(crate) fn reached(&self, bounds: &Aabb) -> Vec<SectorId> {
        let meets = self
            .boxes
            .iter()
            .filter(|(_, room)| room.meets(bounds))
            .map(|(sector, _)| *sector);
        let mut reached: Vec<SectorId> = std::iter::once(OUTDOORS).chain(meets).collect();
        reached.sort_unstable();
        reached
    }

    /// Returns the smallest room whose box contains a point.
    pub(crate) fn at(&self, point: [f32; 3]) -> Option<SectorId> {
        let mut containing = self.boxes.iter().filter(|(_, room)| room.contains(point));
        containing.next().map(|(sector, _)| *sector)
    }

    /// Returns whether a point is in the box of a room, or, outdoors, in none.
    pub(crate) fn reaches(&self, room: SectorId, point: [f32; 3]) -> bool {
        match room {
            OUTDOORS => self.at(point).is_none(),
            _ => self
                .boxes
                .iter()
                .any(|(sector, held)| *sector == room && held.contains(point)),
        }
    }

    /// Replaces the boxes; returns whether they differ.
    pub(crate) fn set_boxes(&mut self, owned: impl Iterator<Item = (SectorId, Aabb)>) -> bool {
        let mut boxes: HashMap<SectorId, Aabb> = HashMap::default();
        for (sector, bounds) in owned {
            let room = boxes.entry(sector).or_insert(Aabb::EMPTY);
            *room = room.union(&bounds);
        }
        let mut boxes: Vec<(SectorId, Aabb)> = boxes.into_iter().collect();
        boxes.sort_unstable_by(|(a, of_a), (b, of_b)| of_a.volume().total_cmp(&of_b.volume()).then(a.cmp(b)));
        let differs = boxes != self.boxes;
        self.boxes = boxes;
        differs
    }

    /// Returns the entity that a sector is.
    pub(crate) fn entity(&self, sector: SectorId) -> Option<Entity> {
        let mut all = self.sectors.iter();
        all.find(|(_, of)| **of == sector).map(|(entity, _)| *entity)
    }

    /// Returns the sector of an entity, if that is a room.
    pub(crate) fn sector(&self, entity: Entity) -> Option<SectorId> {
        self.sectors.get(&entity).copied()
    }
}

/// Whether rooms came or went, or the hierarchy changed.
pub(crate) type RoomsChanged<'w, 's> = (
    Query<'w, 's, Entity, Added<Sector>>,
    RemovedComponents<'w, 's, Sector>,
    Query<'w, 's, Entity, Changed<ChildOf>>,
    RemovedComponents<'w, 's, ChildOf>,
);
