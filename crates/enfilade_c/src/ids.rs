//! Ids of C: an index, and a number that tells what has it from everything else.

use crate::status::{EnfiladeStatus, Failure};
use enfilade::{ItemId, SectorId};
use std::fmt::Display;
use std::sync::atomic::{AtomicU32, Ordering};

/// An item of a scene. 0 is none.
pub type EnfiladeItemId = u64;
/// A sector of a scene. 0 is none, or, where the documentation says so, any.
pub type EnfiladeSectorId = u64;
/// A portal of a scene. 0 is none.
pub type EnfiladePortalId = u64;
/// A room of an EnfiladeRooms. 0 is none.
pub type EnfiladeRoomId = u64;
/// A door of an EnfiladeRooms. 0 is none.
pub type EnfiladeDoorId = u64;

/// The ids of one kind in one object, of things whose indices are not used again.
#[derive(Clone, Copy)]
pub(crate) struct IdSpace {
    /// The upper half of each id: another number for each space.
    tag: u32,
    name: &'static str,
}

impl IdSpace {
    pub(crate) fn new(name: &'static str) -> IdSpace {
        static SERIAL: AtomicU32 = AtomicU32::new(1);
        // Far from each other, because the generations of items count up from here; odd, so all numbers come up once.
        let serial = SERIAL.fetch_add(1, Ordering::Relaxed);
        let tag = serial.wrapping_mul(0x9E37_79B1).max(1);
        IdSpace { tag, name }
    }

    pub(crate) fn id(self, index: u32) -> u64 {
        u64::from(self.tag) << 32 | u64::from(index)
    }

    /// Returns the index of an id of this space, if it is below `count`.
    pub(crate) fn index(self, id: u64, count: usize) -> Result<u32, Failure> {
        let index = id as u32;
        let is_one = id >> 32 == u64::from(self.tag) && (index as usize) < count;
        is_one.then_some(index).ok_or_else(|| no_such(self.name, id))
    }
}

pub(crate) fn no_such(name: &str, id: impl Display) -> Failure {
    Failure::new(
        EnfiladeStatus::NoSuchId,
        "c/no-such-id",
        format_args!("there is no {name} {id}; it was removed, or belongs to something else"),
    )
}

/// The ids of the items of a scene, which they keep when they move to another sector.
pub(crate) struct ItemTable {
    slots: Vec<Slot>,
    free: Vec<u32>,
    /// For each sector and index of an item there, its slot plus one; 0 for none.
    slot_of: Vec<Vec<u32>>,
    first_generation: u32,
}

#[derive(Clone, Copy)]
struct Slot {
    generation: u32,
    item: Option<(SectorId, ItemId)>,
}

impl ItemTable {
    pub(crate) fn new() -> ItemTable {
        ItemTable {
            slots: Vec::new(),
            free: Vec::new(),
            slot_of: Vec::new(),
            first_generation: IdSpace::new("item").tag,
        }
    }

    /// Returns the id that [`ItemTable::add`] gives next, after `before` others.
    pub(crate) fn add(&mut self, sector: SectorId, item: ItemId) -> EnfiladeItemId {
        let slot = self.free.pop().unwrap_or_else(|| {
            self.slots.push(Slot {
                generation: self.first_generation,
                item: None,
            });
            self.slots.len() as u32 - 1
        });
        self.slots[slot as usize].item = Some((sector, item));
        self.note(sector, item, slot + 1);
        self.id(slot)
    }

    /// Returns the sector of an item, and its id there.
    pub(crate) fn get(&self, id: EnfiladeItemId) -> Result<(SectorId, ItemId), Failure> {
        let slot = self.slots.get(id as u32 as usize);
        let item = slot.filter(|slot| u64::from(slot.generation) == id >> 32);
        item.and_then(|slot| slot.item).ok_or_else(|| no_such("item", id))
    }

    /// Forgets an item that [`ItemTable::get`] finds.
    pub(crate) fn remove(&mut self, id: EnfiladeItemId) {
        let slot = &mut self.slots[id as u32 as usize];
        slot.generation = slot.generation.wrapping_add(1).max(1);
        if let Some((sector, item)) = slot.item.take() {
            self.note(sector, item, 0);
            self.free.push(id as u32);
        }
    }

    /// Forgets all items of a sector.
    pub(crate) fn remove_sector(&mut self, sector: SectorId) {
        let slots = self.slot_of.get_mut(sector.0 as usize);
        for slot in slots.map(std::mem::take).unwrap_or_default() {
            if let Some(slot) = slot.checked_sub(1) {
                self.remove(self.id(slot));
            }
        }
    }

    /// Notes that an item is in another sector now.
    pub(crate) fn relocate(&mut self, id: EnfiladeItemId, sector: SectorId, item: ItemId) {
        let slot = id as u32;
        if let Some((sector, item)) = self.slots[slot as usize].item.replace((sector, item)) {
            self.note(sector, item, 0);
        }
        self.note(sector, item, slot + 1);
    }

    /// Returns the id of an item; 0 if it has none, as items of sectors that are read from their file on demand.
    pub(crate) fn id_of(&self, sector: SectorId, item: ItemId) -> EnfiladeItemId {
        let slots = self.slot_of.get(sector.0 as usize);
        let slot = slots.and_then(|slots| slots.get(item.index.0 as usize)?.checked_sub(1));
        let is_it = |&slot: &u32| self.slots[slot as usize].item == Some((sector, item));
        slot.filter(is_it).map_or(0, |slot| self.id(slot))
    }

    /// Iterates over the ids of all items.
    pub(crate) fn ids(&self) -> impl Iterator<Item = EnfiladeItemId> {
        let slots = self.slots.iter().zip(0..);
        slots.filter_map(|(slot, number)| slot.item.map(|_| self.id(number)))
    }

    fn id(&self, slot: u32) -> EnfiladeItemId {
        u64::from(self.slots[slot as usize].generation) << 32 | u64::from(slot)
    }

    fn note(&mut self, sector: SectorId, item: ItemId, slot_plus_one: u32) {
        let [sector, index] = [sector.0, item.index.0].map(|number| number as usize);
        if self.slot_of.len() <= sector {
            self.slot_of.resize_with(sector + 1, Vec::new);
        }
        let slots = &mut self.slot_of[sector];
        if slots.len() <= index {
            slots.resize(index + 1, 0);
        }
        slots[index] = slot_plus_one;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade::ItemIndex;

    #[test]
    fn an_id_of_a_removed_item_never_names_another() {
        let mut table = ItemTable::new();
        let mut known = Vec::new();
        for turn in 0..100_u32 {
            let sector = SectorId(turn % 3);
            let item = ItemId {
                index: ItemIndex(turn % 5),
                generation: turn,
            };
            let id = table.add(sector, item);
            assert!(id != 0 && !known.contains(&id));
            assert_eq!(table.get(id).ok(), Some((sector, item)));
            assert_eq!(table.id_of(sector, item), id);
            if turn % 2 == 0 {
                table.remove(id);
                assert!(table.get(id).is_err());
                assert_eq!(table.id_of(sector, item), 0);
            }
            known.push(id);
        }
    }

    #[test]
    fn ids_of_one_space_are_refused_by_another() {
        let [one, other] = [(); 2].map(|()| IdSpace::new("sector"));
        assert_eq!(one.index(one.id(7), 8).ok(), Some(7));
        assert!(one.index(one.id(7), 7).is_err());
        assert!(other.index(one.id(7), 8).is_err());
        assert!(one.index(0, 8).is_err());
    }
}
