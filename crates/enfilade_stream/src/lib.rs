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
//!     // Draw what is visible; `pager.is_absent` tells what has no mesh yet.
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
//! The visible set of any look contains all that a look at the whole scene would see, and is equal to it once nothing visible
//! is absent (exact methods).
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod loader;
#[cfg(test)]
mod tests;

pub use enfilade_import::Pages;

use enfilade::{ItemId, ItemIndex, Mesh, Scene, SceneError, SectorId, VisibleSet};
use enfilade_import::Import;
use loader::Loader;
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
}

impl Default for PagerOptions {
    /// 512 MB, 2 threads, 8 pages a step.
    fn default() -> PagerOptions {
        PagerOptions {
            bytes: 512_000_000,
            threads: 2,
            pages_per_step: 8,
        }
    }
}

/// What a step did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct PagerStats {
    /// Visible items whose mesh is absent, after this step. Each counts once.
    pub absent: u32,
    /// Pages that came into the scene.
    pub loaded: u32,
    /// Pages that left it.
    pub dropped: u32,
    /// Pages that are being read, or are next.
    pub loading: u32,
    /// Visible pages that are not loaded, because the budget is used up by others that are visible too.
    pub over_budget: u32,
    /// Memory of the pages in the scene and of those that are being read, in bytes.
    pub bytes: u64,
    /// Pages that cannot be read, and why. Each is reported once, and stays absent.
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
    /// The page of each item, by sector and index; `None` if it is always in memory.
    page_of: Vec<Vec<Option<u32>>>,
    /// The box of each mesh, by its index in the file.
    boxes: Vec<Option<Arc<Mesh>>>,
    step: u64,
}

/// A page, and the items with its meshes.
struct Page {
    items: Vec<PagedItem>,
    /// Memory of its meshes: their lists and what is computed of them; an estimate before they were read.
    bytes: u64,
    state: State,
    /// The last step in which one of its items was visible, and the size of the largest on the screen in that step.
    seen_at: u64,
    size_px: u16,
}

/// A page that comes into the scene or leaves it.
struct Changed {
    number: u32,
    /// Its meshes in the scene; none if it was absent.
    before: Vec<(u32, Arc<Mesh>)>,
}

struct PagedItem {
    sector: SectorId,
    item: ItemId,
    /// Index in the file.
    mesh: u32,
}

enum State {
    Absent,
    /// It waits to be read, is being read, or has been read.
    Asked,
    Present(Vec<(u32, Arc<Mesh>)>),
    Failed,
}

impl Pager {
    /// Creates a pager for the scene of an import, whose pages are all absent. Starts its threads.
    pub fn new(import: Import, pages: Pages, options: PagerOptions) -> Pager {
        let mut list: Vec<Page> = (0..pages.count())
            .map(|page| Page {
                items: Vec::new(),
                bytes: pages.bytes(page) / 4 * 5,
                state: State::Absent,
                seen_at: 0,
                size_px: 0,
            })
            .collect();
        let mut boxes = vec![None; pages.mesh_count() as usize];
        let mut page_of = Vec::new();
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
                    page
                })
            });
            page_of.push(of_room.collect());
        }
        Pager {
            loader: Loader::new(Arc::new(pages), options.threads.max(1)),
            options,
            pages: list,
            page_of,
            boxes,
            step: 0,
        }
    }

    /// Returns `true` if the mesh of an item is not in the scene: it is a box there.
    pub fn is_absent(&self, sector: SectorId, item: ItemId) -> bool {
        let page = self.page(sector, item);
        page.is_some_and(|page| !matches!(self.pages[page as usize].state, State::Present(_)))
    }

    fn page(&self, sector: SectorId, item: ItemId) -> Option<u32> {
        // Items that were added later have another generation, and no page.
        let of_sector = self
            .page_of
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
            && let Some((number, read)) = self.loader.arrived()
        {
            let page = &mut self.pages[number as usize];
            match read {
                Ok(meshes) => {
                    page.bytes = meshes.iter().map(|(_, mesh)| mesh.bytes()).sum();
                    page.state = State::Present(meshes);
                    changed.push(Changed {
                        number,
                        before: Vec::new(),
                    });
                    stats.loaded += 1;
                }
                Err(why) => {
                    page.state = State::Failed;
                    stats.failed.push((number, why.to_string()));
                }
            }
        }
        self.note(seen);
        let dropped = self.ask(&mut stats);
        stats.dropped = dropped.len() as u32;
        changed.extend(dropped);
        self.exchange(scene, changed)?;
        stats.absent = self.count_absent(seen);
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
                let Some(number) = self.page(sector, visible.item) else {
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
        }
    }

    /// Asks for the visible pages that are absent, and returns those that leave the scene for them.
    fn ask(&mut self, stats: &mut PagerStats) -> Vec<Changed> {
        let being_read = self.loader.being_read();
        for (number, page) in (0..).zip(&mut self.pages) {
            if matches!(page.state, State::Asked) && !being_read.contains(&number) {
                page.state = State::Absent;
            }
        }
        let mut bytes = self.bytes();
        let numbers = 0..self.pages.len() as u32;
        let (step, pages) = (self.step, &mut self.pages);
        let is_wanted = |page: &Page| matches!(page.state, State::Absent) && page.seen_at == step;
        let mut wanted: Vec<u32> = numbers
            .clone()
            .filter(|&page| is_wanted(&pages[page as usize]))
            .collect();
        wanted.sort_by_key(|&page| (u16::MAX - pages[page as usize].size_px, page));
        let is_unseen = |page: &Page| matches!(page.state, State::Present(_)) && page.seen_at < step;
        let mut unseen: Vec<u32> = numbers.filter(|&page| is_unseen(&pages[page as usize])).collect();
        unseen.sort_by_key(|&page| (pages[page as usize].seen_at, page));
        let mut unseen = unseen.into_iter();
        let (mut dropped, mut asked) = (Vec::new(), Vec::new());
        // Returns whether there is room for so many bytes more, after what has not been seen for longest has left.
        let mut make_room = |pages: &mut [Page], bytes: &mut u64, needs: u64| {
            while *bytes + needs > self.options.bytes
                && let Some(number) = unseen.next()
            {
                let page = &mut pages[number as usize];
                *bytes -= page.bytes;
                if let State::Present(before) = std::mem::replace(&mut page.state, State::Absent) {
                    dropped.push(Changed { number, before });
                }
            }
            *bytes + needs <= self.options.bytes
        };
        // Pages may take more than was estimated before they were read.
        make_room(pages, &mut bytes, 0);
        // The largest hide others, which then need not be read.
        let at_once = (self.options.pages_per_step.max(1) as usize).saturating_sub(being_read.len());
        for number in wanted {
            if asked.len() >= at_once {
                break;
            }
            let needs = pages[number as usize].bytes;
            if !make_room(pages, &mut bytes, needs) {
                stats.over_budget += 1;
                continue;
            }
            bytes += needs;
            pages[number as usize].state = State::Asked;
            asked.push(number);
        }
        stats.loading = (asked.len() + being_read.len()) as u32;
        self.loader.ask(asked);
        dropped
    }

    /// Gives the items of pages their meshes or boxes. On an error, the pages are as before.
    fn exchange(&mut self, scene: &mut Scene, changed: Vec<Changed>) -> Result<(), SceneError> {
        if changed.is_empty() {
            return Ok(());
        }
        let mut edit = scene.edit();
        for Changed { number, before } in &changed {
            let page = &mut self.pages[*number as usize];
            let after = match &page.state {
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
                    self.page_of[sector.0 as usize][item.index.0 as usize] = None;
                }
                is_ours
            });
        }
        let finished = edit.finish();
        if finished.is_err() {
            for Changed { number, before } in changed {
                self.pages[number as usize].state = if before.is_empty() {
                    State::Absent
                } else {
                    State::Present(before)
                };
            }
        }
        finished.map(|_| ())
    }

    fn count_absent(&self, seen: &[&VisibleSet]) -> u32 {
        let absent = seen.iter().flat_map(|set| {
            let items = set.items().iter();
            items.map(|visible| (set.passage(visible.passage).sector, visible.item))
        });
        let mut absent: Vec<_> = absent
            .filter(|&(sector, item)| self.is_absent(sector, item))
            .collect();
        absent.sort_unstable();
        absent.dedup();
        absent.len() as u32
    }

    fn bytes(&self) -> u64 {
        let in_memory = |page: &&Page| matches!(page.state, State::Present(_) | State::Asked);
        self.pages.iter().filter(in_memory).map(|page| page.bytes).sum()
    }
}

fn mesh_in(meshes: &[(u32, Arc<Mesh>)], mesh: u32) -> Option<&Arc<Mesh>> {
    let at = meshes.binary_search_by_key(&mesh, |(index, _)| *index);
    at.ok().map(|at| &meshes[at].1)
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
