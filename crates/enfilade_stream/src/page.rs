//! A page of a scene: which of its meshes are in memory, and its priority for loading.

use crate::{Hint, MeshRef};
use enfilade::{Aabb, ItemId, ItemIndex, Mesh, SectorId};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Meshes by their index in the file, in this order.
pub(crate) type Meshes = Vec<(u32, Arc<Mesh>)>;

/// A page, and the items with its meshes.
pub(crate) struct Page {
    pub(crate) items: Vec<PagedItem>,
    pub(crate) meshes: State,
    /// Coarser meshes, loaded only while the meshes are not.
    pub(crate) levels: State,
    /// Memory of the meshes: their lists and what is computed of them; an estimate before they were read.
    pub(crate) bytes: u64,
    /// The same for the coarser meshes.
    pub(crate) level_bytes: u64,
    /// The last step in which one of its items was visible, and the size of the largest on the screen in that step.
    pub(crate) seen_at: u64,
    pub(crate) size_px: u16,
    /// The last step in which the eye was in a region whose hints name the page.
    pub(crate) hinted_at: u64,
    /// The last step in which the page was to be prefetched, and its rank among those pages.
    pub(crate) prefetch_at: u64,
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
    Requested,
    Present(Meshes),
    Failed,
}

impl State {
    fn is_in_memory(&self) -> bool {
        matches!(self, State::Requested | State::Present(_))
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
            prefetch_at: 0,
            rank: 0,
        }
    }

    /// Marks the page as named by hints in this step, and as to be prefetched if it has a `rank`.
    pub(crate) fn hint(&mut self, step: u64, rank: Option<u32>) {
        self.hinted_at = step;
        if let Some(rank) = rank {
            self.rank = if self.is_prefetch(step) {
                self.rank.min(rank)
            } else {
                rank
            };
            self.prefetch_at = step;
        }
    }

    /// Returns `true` if the page is to be loaded before it is visible.
    pub(crate) fn is_prefetch(&self, step: u64) -> bool {
        self.prefetch_at == step
    }

    /// Returns the key by which requests are sorted, the most urgent first; `None` if the page is neither visible nor to be
    /// prefetched.
    pub(crate) fn priority(&self, step: u64) -> Option<(bool, u32)> {
        if self.seen_at != step {
            return self.is_prefetch(step).then_some((true, self.rank));
        }
        // A box that hints do not name is most likely visible only because its occluders are absent. But a large one may itself be
        // an occluder.
        let size_px = self.size_px / if self.hinted_at == step { 1 } else { 4 };
        Some((false, u32::from(u16::MAX - size_px)))
    }

    /// Returns the memory of what is loaded or requested, in bytes.
    pub(crate) fn memory(&self) -> u64 {
        let of = |state: &State, bytes| if state.is_in_memory() { bytes } else { 0 };
        of(&self.meshes, self.bytes) + of(&self.levels, self.level_bytes)
    }

    /// Returns the memory that evicting the page frees, in bytes.
    pub(crate) fn evictable_bytes(&self) -> u64 {
        let of = |state: &State, bytes| {
            if matches!(state, State::Present(_)) {
                bytes
            } else {
                0
            }
        };
        of(&self.meshes, self.bytes) + of(&self.levels, self.level_bytes)
    }

    /// Drops the coarser meshes if the meshes are loaded: only one of the two is drawn.
    pub(crate) fn drop_levels_if_loaded(&mut self) {
        if matches!(self.meshes, State::Present(_)) {
            self.levels.take();
        }
    }
}

/// A page that was loaded into the scene or evicted from it.
pub(crate) struct PageChange {
    pub(crate) number: u32,
    /// Its meshes in the scene; none if it was absent.
    pub(crate) before: Meshes,
}

impl PageChange {
    pub(crate) fn loaded(number: u32) -> PageChange {
        PageChange {
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
    /// `mesh_refs` are those of each item, by sector and index.
    pub(crate) fn new(hint: &Hint, mesh_refs: &[Vec<Option<MeshRef>>]) -> HintedPages {
        let page = |&(SectorId(sector), ItemIndex(item)): &(SectorId, ItemIndex)| {
            let mesh_ref = mesh_refs.get(sector as usize)?.get(item as usize)?;
            mesh_ref.map(|mesh_ref| mesh_ref.page)
        };
        let mut known = BTreeSet::new();
        let pages = hint.items.iter().filter_map(page);
        HintedPages {
            sector: hint.sector,
            bounds: hint.bounds,
            pages: pages.filter(|&page| known.insert(page)).collect(),
        }
    }

    /// Returns the squared distance of a position from the region.
    pub(crate) fn distance_squared(&self, eye: [f32; 3]) -> f32 {
        let Aabb { min, max } = self.bounds;
        let outside = (0..3).map(|axis| (min[axis] - eye[axis]).max(eye[axis] - max[axis]).max(0.0));
        outside.map(|distance| distance * distance).sum()
    }
}

pub(crate) fn mesh_in(meshes: &[(u32, Arc<Mesh>)], mesh: u32) -> Option<&Arc<Mesh>> {
    let at = meshes.binary_search_by_key(&mesh, |(index, _)| *index);
    at.ok().map(|at| &meshes[at].1)
}
