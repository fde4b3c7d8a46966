//! A page of a scene: what of it is in memory, and how much it is wanted.

use crate::{Hint, Place};
use enfilade::{Aabb, ItemId, ItemIndex, Mesh, SectorId};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Meshes by their index in the file, in this order.
pub(crate) type Meshes = Vec<(u32, Arc<Mesh>)>;

/// A page, and the items with its meshes.
pub(crate) struct Page {
    pub(crate) items: Vec<PagedItem>,
    pub(crate) meshes: State,
    /// Coarser meshes, which are there only while the meshes are not.
    pub(crate) levels: State,
    /// Memory of the meshes: their lists and what is computed of them; an estimate before they were read.
    pub(crate) bytes: u64,
    /// The same for the coarser meshes.
    pub(crate) level_bytes: u64,
    /// The last step in which one of its items was visible, and the size of the largest on the screen in that step.
    pub(crate) seen_at: u64,
    pub(crate) size_px: u16,
    /// The last step in which an eye was where hints say that it is seen.
    pub(crate) hinted_at: u64,
    /// The last step in which it was among the first of these, which are loaded ahead, and its place among them.
    pub(crate) ahead_at: u64,
    pub(crate) rank: u32,
}

pub(crate) struct PagedItem {
    pub(crate) sector: SectorId,
    pub(crate) item: ItemId,
    /// Index in the file.
    pub(crate) mesh: u32,
}

pub(crate) enum State {
    Absent,
    /// It waits to be read, is being read, or has been read.
    Asked,
    Present(Meshes),
    Failed,
}

impl State {
    fn is_in_memory(&self) -> bool {
        matches!(self, State::Asked | State::Present(_))
    }

    /// Removes the meshes, and returns them.
    pub(crate) fn take(&mut self) -> Option<Meshes> {
        if !matches!(self, State::Present(_)) {
            return None;
        }
        match std::mem::replace(self, State::Absent) {
            State::Present(meshes) => Some(meshes),
            _ => None,
        }
    }
}

impl Page {
    /// An absent page without items, from the bytes of its meshes and coarser meshes in the file.
    pub(crate) fn new(bytes: u64, level_bytes: u64) -> Page {
        Page {
            items: Vec::new(),
            meshes: State::Absent,
            levels: State::Absent,
            bytes: bytes / 4 * 5,
            level_bytes: level_bytes / 4 * 5,
            seen_at: 0,
            size_px: 0,
            hinted_at: 0,
            ahead_at: 0,
            rank: 0,
        }
    }

    /// Notes that hints name it in this step, at this place among those that are loaded ahead if it is one of them.
    pub(crate) fn hint(&mut self, step: u64, rank: Option<u32>) {
        self.hinted_at = step;
        if let Some(rank) = rank {
            self.rank = if self.is_ahead(step) {
                self.rank.min(rank)
            } else {
                rank
            };
            self.ahead_at = step;
        }
    }

    /// Returns `true` if it is loaded before it is visible.
    pub(crate) fn is_ahead(&self, step: u64) -> bool {
        self.ahead_at == step
    }

    /// How much the page is wanted in this step, the least most; `None` if it is not.
    pub(crate) fn urgency(&self, step: u64) -> Option<(bool, u32)> {
        if self.seen_at != step {
            return self.is_ahead(step).then_some((true, self.rank));
        }
        // What hints do not name is most often visible only because what hides it is absent. But what is large may hide much.
        let size_px = self.size_px / if self.hinted_at == step { 1 } else { 4 };
        Some((false, u32::from(u16::MAX - size_px)))
    }

    /// Memory of what is there or being read, in bytes.
    pub(crate) fn memory(&self) -> u64 {
        let of = |state: &State, bytes| if state.is_in_memory() { bytes } else { 0 };
        of(&self.meshes, self.bytes) + of(&self.levels, self.level_bytes)
    }

    /// Memory that is free once the page has left, in bytes.
    pub(crate) fn memory_there(&self) -> u64 {
        let of = |state: &State, bytes| {
            if matches!(state, State::Present(_)) {
                bytes
            } else {
                0
            }
        };
        of(&self.meshes, self.bytes) + of(&self.levels, self.level_bytes)
    }

    /// Coarser meshes are not drawn once the meshes are there.
    pub(crate) fn drop_needless_levels(&mut self) {
        if matches!(self.meshes, State::Present(_)) {
            self.levels.take();
        }
    }
}

/// A page that comes into the scene or leaves it.
pub(crate) struct Changed {
    pub(crate) number: u32,
    /// Its meshes in the scene; none if it was absent.
    pub(crate) before: Meshes,
}

impl Changed {
    pub(crate) fn arrived(number: u32) -> Changed {
        Changed {
            number,
            before: Vec::new(),
        }
    }
}

/// The pages of a [`Hint`], in the order of its items.
pub(crate) struct HintedPages {
    pub(crate) sector: SectorId,
    bounds: Aabb,
    pub(crate) pages: Vec<u32>,
}

impl HintedPages {
    /// `places` are those of each item, by sector and index.
    pub(crate) fn new(hint: &Hint, places: &[Vec<Option<Place>>]) -> HintedPages {
        let page = |&(SectorId(sector), ItemIndex(item)): &(SectorId, ItemIndex)| {
            let place = places.get(sector as usize)?.get(item as usize)?;
            place.map(|place| place.page)
        };
        let mut known = BTreeSet::new();
        let pages = hint.items.iter().filter_map(page);
        HintedPages {
            sector: hint.sector,
            bounds: hint.bounds,
            pages: pages.filter(|&page| known.insert(page)).collect(),
        }
    }

    /// The square of the distance to the part of the room that it is of.
    pub(crate) fn distance(&self, eye: [f32; 3]) -> f32 {
        let Aabb { min, max } = self.bounds;
        let outside = (0..3).map(|axis| (min[axis] - eye[axis]).max(eye[axis] - max[axis]).max(0.0));
        outside.map(|distance| distance * distance).sum()
    }
}

pub(crate) fn mesh_in(meshes: &[(u32, Arc<Mesh>)], mesh: u32) -> Option<&Arc<Mesh>> {
    let at = meshes.binary_search_by_key(&mesh, |(index, _)| *index);
    at.ok().map(|at| &meshes[at].1)
}
