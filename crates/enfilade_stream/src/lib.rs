//! Worlds larger than memory: loads what is visible, drops what has not been seen for long.
//!
//! A baked scene (`.enf`) groups its meshes into pages by octree subtrees. [`Pages::open`] reads everything but these;
//! absent meshes are boxes that may be visible and hide nothing, so that a look misses nothing whatever is loaded. After each
//! look, [`Pager::step`] asks for the absent pages that the look found visible, the largest on the screen first, and puts into
//! the scene what has arrived. Threads of its own read and check pages; a look never waits for the disk.
//!
//! ```no_run
//! use enfilade::{Method, View, Viewer};
//! use enfilade_import::{Pages, ReadOptions};
//! use enfilade_stream::{Pager, PagerOptions};
//!
//! let (import, pages) = Pages::open("town.enf".as_ref(), &ReadOptions::default())?;
//! let mut scene = import.scene(Method::Masked, Method::DEFAULT_LIMIT)?;
//! let mut pager = Pager::new(import, pages, PagerOptions::default());
//! let mut viewer = Viewer::new();
//! loop {
//!     let view = View::new([0.0, 1.6, 0.0], [1.0, 1.6, 0.0], [1280, 720])?;
//!     let seen = viewer.look(&scene, &view);
//!     // Draw what is visible; `pager.level` is what to draw of an item that has no mesh yet.
//!     let stats = pager.step(&mut scene, &[seen])?;
//!     if stats.failed.is_empty() {
//!         # break;
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, for octree subtrees that are loaded as needed and
//!     dropped when not.
//! Cost: a step is O(visible items + pages), plus an edit of the items of the pages that came or went.
//! The visible set of any look contains all that a look at the whole scene would see, unless it hits a limit
//! (`VisibleSet::complete`), and is equal to it once nothing visible is absent (exact methods).
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod hints;
mod loader;
mod page;
mod residency;
#[cfg(test)]
mod tests;

pub use enfilade_import::{Hint, Pages};
pub use hints::{HintCheck, HintError, HintOptions, HintSampler};

use enfilade::{ItemId, ItemIndex, Mesh, Scene, SceneError, SectorId, VisibleSet};
use enfilade_import::Import;
use loader::{Loader, Request};
use page::{HintedPages, Page, PageChange, PagedItem, State, mesh_in};
use std::sync::Arc;
use std::time::Duration;

/// Limits of a [`Pager`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PagerOptions {
    /// Memory for meshes, in bytes. Pages that are visible stay even if all of them take more; then no further page is loaded.
    pub bytes: u64,
    /// Threads that read and check pages, at least 1.
    pub threads: usize,
    /// Maximum number of pages that are read at once, and that a step puts into the scene. At least 1. The fewer, the later
    /// everything is there; the more, the more is read that is found hidden once nearer pages are there.
    pub pages_per_step: u32,
    /// Whether coarser meshes are loaded too, to draw while a page is absent: [`Pager::level`].
    pub levels: bool,
}

impl Default for PagerOptions {
    /// 512 MB, 2 threads, 8 pages a step, with coarser meshes.
    fn default() -> PagerOptions {
        PagerOptions {
            bytes: 512_000_000,
            threads: 2,
            pages_per_step: 8,
            levels: true,
        }
    }
}

/// What a step did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct PagerStats {
    /// Visible items whose mesh is absent, after this step. Each counts once.
    pub absent: u32,
    /// How many of them have a coarser mesh to draw.
    pub coarse: u32,
    /// Pages that came into the scene.
    pub loaded: u32,
    /// Pages that left it.
    pub dropped: u32,
    /// Pages that are being read, or are next.
    pub loading: u32,
    /// Visible pages that are not loaded, because the budget is used up by others that are visible too.
    pub over_budget: u32,
    /// Memory of the pages in the scene, of coarser meshes, and of those that are being read, in bytes.
    pub bytes: u64,
    /// Pages that cannot be read, or their coarser meshes, and why. Each is reported once, and stays absent.
    pub failed: Vec<(u32, String)>,
}

/// Keeps in a scene the meshes of what is visible.
///
/// The scene may be edited in between: the pager leaves items alone whose mesh was replaced, or that were removed.
#[doc(alias = "streaming")]
#[doc(alias = "out-of-core")]
pub struct Pager {
    options: PagerOptions,
    loader: Loader,
    pages: Vec<Page>,
    /// The mesh of each item, by sector and index; `None` if it is always in memory.
    mesh_refs: Vec<Vec<Option<MeshRef>>>,
    /// The box of each mesh, by its index in the file.
    boxes: Vec<Option<Arc<Mesh>>>,
    hints: Vec<HintedPages>,
    step: u64,
}

/// The page of an item's mesh, and the mesh.
#[derive(Clone, Copy)]
struct MeshRef {
    page: u32,
    /// Index in the file.
    mesh: u32,
}

impl Pager {
    /// Creates a pager for the scene of an import, whose pages are all absent. Starts its threads.
    pub fn new(import: Import, pages: impl Into<Arc<Pages>>, options: PagerOptions) -> Pager {
        let pages = pages.into();
        let mut list: Vec<Page> = (0..pages.count())
            .map(|page| Page::new(pages.bytes(page), pages.level_bytes(page)))
            .collect();
        let mut boxes = vec![None; pages.mesh_count() as usize];
        let mut mesh_refs = Vec::new();
        for (room, sector) in import.rooms.iter().zip((0..).map(SectorId)) {
            let geometry = &room.geometry;
            let of_room = (geometry.items().iter().zip((0..).map(ItemIndex))).map(|(item, index)| {
                let mesh = pages.mesh_of(sector.0 as usize, item.mesh);
                let page = pages.page_of(mesh);
                let is_paged = !pages.is_resident(page) && !item.bounds.is_empty();
                is_paged.then(|| {
                    boxes[mesh as usize] = Some(Arc::clone(&geometry.meshes()[item.mesh.0 as usize]));
                    let item = index.into();
                    list[page as usize].items.push(PagedItem { sector, item, mesh });
                    MeshRef { page, mesh }
                })
            });
            mesh_refs.push(of_room.collect());
        }
        let hints = pages.hints().iter();
        let hints = hints.map(|hint| HintedPages::new(hint, &mesh_refs)).collect();
        Pager {
            loader: Loader::new(pages, options.threads.max(1)),
            options,
            pages: list,
            mesh_refs,
            boxes,
            hints,
            step: 0,
        }
    }

    /// Returns `true` if the mesh of an item is not in the scene: it is a box there.
    pub fn is_absent(&self, sector: SectorId, item: ItemId) -> bool {
        let mesh_ref = self.mesh_ref(sector, item);
        mesh_ref
            .is_some_and(|mesh_ref| !matches!(self.pages[mesh_ref.page as usize].meshes, State::Present(_)))
    }

    /// Returns a coarser mesh of an item whose own is absent: draw it meanwhile. It is within the box that looks see, and the
    /// materials are those of its mesh. `None` if the mesh is there, or its coarser mesh is not there yet.
    #[doc(alias = "lod")]
    pub fn level(&self, sector: SectorId, item: ItemId) -> Option<&Arc<Mesh>> {
        let mesh_ref = self.mesh_ref(sector, item)?;
        match &self.pages[mesh_ref.page as usize].levels {
            State::Present(levels) => mesh_in(levels, mesh_ref.mesh),
            _ => None,
        }
    }

    fn mesh_ref(&self, sector: SectorId, item: ItemId) -> Option<MeshRef> {
        // Items that were added later have another generation, and no page.
        let of_sector = self
            .mesh_refs
            .get(sector.0 as usize)
            .filter(|_| item.generation == 0)?;
        *of_sector.get(item.index.0 as usize)?
    }

    /// Puts into the scene the pages that have arrived, and asks for those that are visible and absent. Never waits.
    ///
    /// `seen` holds the visible sets of looks at the scene in its current state, one per camera.
    ///
    /// # Errors
    /// [`SceneError::Unsuited`] if the method of a sector cannot handle its meshes; the scene is unchanged then.
    pub fn step(&mut self, scene: &mut Scene, seen: &[&VisibleSet]) -> Result<PagerStats, SceneError> {
        self.step += 1;
        let mut stats = PagerStats::default();
        let mut changed = Vec::new();
        while changed.len() < self.options.pages_per_step.max(1) as usize
            && let Some((request, read)) = self.loader.arrived()
        {
            let (Request::Levels(number) | Request::Page(number)) = request;
            let page = &mut self.pages[number as usize];
            let state = match request {
                Request::Levels(_) => &mut page.levels,
                Request::Page(_) => &mut page.meshes,
            };
            match read {
                Err(why) => {
                    *state = State::Failed;
                    stats.failed.push((number, why.to_string()));
                }
                Ok(meshes) => {
                    let of_mesh = |mesh: &Mesh| mesh.bytes() + size_of::<Mesh>() as u64;
                    let bytes = meshes.iter().map(|(_, mesh)| of_mesh(mesh)).sum();
                    *state = State::Present(meshes);
                    match request {
                        Request::Levels(_) => page.level_bytes = bytes,
                        Request::Page(_) => {
                            page.bytes = bytes;
                            changed.push(PageChange::loaded(number));
                            stats.loaded += 1;
                        }
                    }
                    page.drop_levels_if_loaded();
                }
            }
        }
        self.note(seen);
        let dropped = self.request(&mut stats);
        stats.dropped = dropped.len() as u32;
        changed.extend(dropped);
        self.exchange(scene, changed)?;
        self.count_absent(seen, &mut stats);
        stats.bytes = self.bytes();
        Ok(stats)
    }

    /// Waits until a page has arrived, for loading screens. Returns `false` if none did before the timeout, or none is being
    /// read.
    pub fn wait(&self, timeout: Duration) -> bool {
        self.loader.wait(timeout)
    }

    /// Notes what is visible.
    fn note(&mut self, seen: &[&VisibleSet]) {
        for set in seen {
            for visible in set.items() {
                let sector = set.passage(visible.passage).sector;
                let Some(MeshRef { page: number, .. }) = self.mesh_ref(sector, visible.item) else {
                    continue;
                };
                let page = &mut self.pages[number as usize];
                let before = if page.seen_at == self.step {
                    page.size_px
                } else {
                    0
                };
                page.size_px = before.max(visible.size_px);
                page.seen_at = self.step;
            }
            let Some(first) = set.passages().first() else {
                continue;
            };
            let eye = first.eye().map(|value| value as f32);
            let of_sector = self.hints.iter().filter(|hint| hint.sector == first.sector);
            let nearest =
                of_sector.min_by(|a, b| a.distance_squared(eye).total_cmp(&b.distance_squared(eye)));
            let mut bytes = 0;
            for (rank, &number) in (0..).zip(nearest.iter().flat_map(|hint| &hint.pages)) {
                let page = &mut self.pages[number as usize];
                bytes += page.bytes;
                // The rest of the budget is for what is visible.
                page.hint(self.step, (bytes <= self.options.bytes / 2).then_some(rank));
            }
        }
    }

    /// Gives the items of pages their meshes or boxes. On an error, the pages are as before.
    fn exchange(&mut self, scene: &mut Scene, changed: Vec<PageChange>) -> Result<(), SceneError> {
        if changed.is_empty() {
            return Ok(());
        }
        let mut edit = scene.edit();
        for PageChange { number, before } in &changed {
            let page = &mut self.pages[*number as usize];
            let after = match &page.meshes {
                State::Present(meshes) => &meshes[..],
                _ => &[],
            };
            page.items.retain(|&PagedItem { sector, item, mesh }| {
                let stand_in = self.boxes[mesh as usize].as_ref();
                let [old, new] = [before, after].map(|meshes| mesh_in(meshes, mesh).or(stand_in));
                let is_ours = old.zip(new).is_some_and(|(old, new)| {
                    holds(edit.scene(), sector, item, old)
                        && edit.set_mesh(sector, item, Arc::clone(new)).is_ok()
                });
                if !is_ours {
                    self.mesh_refs[sector.0 as usize][item.index.0 as usize] = None;
                }
                is_ours
            });
        }
        let finished = edit.finish();
        if finished.is_err() {
            for PageChange { number, before } in changed {
                self.pages[number as usize].meshes = if before.is_empty() {
                    State::Absent
                } else {
                    State::Present(before)
                };
            }
        }
        finished.map(|_| ())
    }

    fn count_absent(&self, seen: &[&VisibleSet], stats: &mut PagerStats) {
        let absent = seen.iter().flat_map(|set| {
            let items = set.items().iter();
            items.map(|visible| (set.passage(visible.passage).sector, visible.item))
        });
        let mut absent: Vec<_> = absent
            .filter(|&(sector, item)| self.is_absent(sector, item))
            .collect();
        absent.sort_unstable();
        absent.dedup();
        stats.absent = absent.len() as u32;
        let coarse = absent
            .iter()
            .filter(|&&(sector, item)| self.level(sector, item).is_some());
        stats.coarse = coarse.count() as u32;
    }

    fn bytes(&self) -> u64 {
        self.pages.iter().map(Page::memory).sum()
    }
}

/// Returns `true` if an item has this mesh.
fn holds(scene: &Scene, sector: SectorId, item: ItemId, mesh: &Arc<Mesh>) -> bool {
    let geometry = scene.geometry(sector);
    geometry.is_some_and(|geometry| {
        let index = geometry.index_of(item);
        index.is_some_and(|index| {
            let held = geometry.item(index).mesh;
            Arc::ptr_eq(&geometry.meshes()[held.0 as usize], mesh)
        })
    })
}
