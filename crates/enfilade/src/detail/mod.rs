//! Levels of detail: a volume now, geometry when it is found visible, as fine as it is large on the screen.
//!
//! Looks see what stands in the scene. Between them, what was seen is refined: each item that was gets the coarsest level
//! whose error is below a tolerance in pixels where it stands; a level is built when it is wanted first, and a look's
//! building is bounded. What is not built yet is drawn by what there is.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3 (an object is tested by its volume, and
//!     only then refined); hysteresis as in Luebke and others, Level of Detail for 3D Graphics, 2003, section 4.5.
//! Cost: a step O(items with levels that are seen), an edit of those that change, and what sources take to build.
//! Judged as drawn: what is behind a level with an error is seen past it, and an item that is drawn by one is seen where
//! that is. Only a volume is sure to be seen where anything of the item would be.

mod bezier;
mod choose;
mod source;

pub use bezier::{BezierError, BezierPatch, BezierSurface};
pub use source::DetailSource;

use crate::geom::{MAX_COORDINATE, Transform};
use crate::geometry::ItemId;
use crate::mesh::Mesh;
use crate::scene::{EditError, Scene, SceneError, SectorId};
use crate::visible::VisibleSet;
use choose::Wanted;
use source::Levels;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The items of a scene that have levels of detail.
///
/// Lives beside the scene: look, then [`Details::refine`], then look again. An item is judged as it is drawn: one that was
/// not seen for long, and by a coarse level, comes into view when that level does, not when it would itself.
#[derive(Default)]
pub struct Details {
    options: DetailOptions,
    items: BTreeMap<Key, Held>,
    /// Each source once, by its address.
    sources: BTreeMap<usize, Levels>,
    step: u64,
}

/// How fine, and how much at once.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DetailOptions {
    /// How far off its true place anything may be drawn, in pixels; above 0.
    pub tolerance_px: f32,
    /// A coarser level is taken only where its error is this many times below the tolerance, so that one does not flicker
    /// between two; at least 1.
    pub hysteresis: f32,
    /// When so many faces were built in one step, no further level is begun; at least one is.
    pub faces_per_step: u64,
    /// When levels take more memory than this, in bytes, those that are not seen are given up.
    pub bytes: u64,
}

impl Default for DetailOptions {
    /// One pixel, a quarter, 100,000 faces, 256 MB.
    fn default() -> DetailOptions {
        DetailOptions {
            tolerance_px: 1.0,
            hysteresis: 1.25,
            faces_per_step: 100_000,
            bytes: 256_000_000,
        }
    }
}

type Key = (SectorId, ItemId);

/// The levels that items get.
type Changes = BTreeMap<Key, Option<u32>>;

/// An item with levels.
struct Held {
    source: usize,
    /// What it is drawn by; `None`: its volume.
    level: Option<u32>,
    /// May it hide where it is exact?
    may_hide: bool,
    seen_at: u64,
}

/// What a step did.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct RefineStats {
    /// Levels that were built.
    pub built: u32,
    /// Faces of those levels.
    pub faces: u64,
    /// Items that have another level now.
    pub changed: u32,
    /// Items that are drawn by a coarser level than they should be, as the step was over.
    pub waiting: u32,
    /// Items that keep what they have, as a level could not be made or does not fit, and why. Each level of a source is told
    /// once, for the item that asked first.
    pub failed: Vec<(SectorId, ItemId, String)>,
    /// Memory of all levels that are kept, in bytes.
    pub bytes: u64,
}

impl Details {
    /// Nothing yet.
    pub fn new(options: DetailOptions) -> Details {
        Details {
            options,
            ..Details::default()
        }
    }

    /// Adds an item to a scene: for now its volume, which hides nothing. Items that share a source share its levels.
    ///
    /// # Errors
    /// [`DetailError`], and then nothing is added.
    pub fn add(
        &mut self,
        scene: &mut Scene,
        sector: SectorId,
        name: &str,
        source: Arc<dyn DetailSource>,
        sector_from_item: Transform,
    ) -> Result<ItemId, DetailError> {
        let source = self.levels_of(source)?;
        let mut edit = scene.edit();
        let volume = Arc::clone(self.sources[&source].mesh(None));
        let item = edit.add(sector, name, volume, sector_from_item)?;
        edit.set_occluder(sector, item, false)?;
        edit.finish()?;
        self.items.insert((sector, item), Held::new(source, true));
        Ok(item)
    }

    /// Gives levels to items that are in the scene: for now their volumes.
    ///
    /// # Errors
    /// [`DetailError`], and then none is changed.
    pub fn adopt(
        &mut self,
        scene: &mut Scene,
        items: impl IntoIterator<Item = (SectorId, ItemId, Arc<dyn DetailSource>)>,
    ) -> Result<(), DetailError> {
        let mut adopted = Vec::new();
        for (sector, item, source) in items {
            let is_occluder = scene_item(scene, (sector, item)).is_none_or(|(_, is_occluder)| is_occluder);
            adopted.push(((sector, item), Held::new(self.levels_of(source)?, is_occluder)));
        }
        let mut edit = scene.edit();
        for ((sector, item), held) in &adopted {
            edit.set_mesh(*sector, *item, Arc::clone(self.sources[&held.source].mesh(None)))?;
            edit.set_occluder(*sector, *item, false)?;
        }
        edit.finish()?;
        self.items.extend(adopted);
        Ok(())
    }

    /// Forgets an item, which keeps the level that it has. One that was removed from the scene, or given another mesh, need
    /// not be forgotten.
    pub fn forget(&mut self, sector: SectorId, item: ItemId) {
        self.items.remove(&(sector, item));
    }

    /// The level that an item is drawn by, if it has any; `Some(None)` where that is its volume.
    pub fn level(&self, sector: SectorId, item: ItemId) -> Option<Option<u32>> {
        self.items.get(&(sector, item)).map(|held| held.level)
    }

    fn levels_of(&mut self, source: Arc<dyn DetailSource>) -> Result<usize, DetailError> {
        let address = Arc::as_ptr(&source).addr();
        if let Entry::Vacant(free) = self.sources.entry(address) {
            free.insert(Levels::new(source)?);
        }
        Ok(address)
    }

    /// Is an item still what was made of it here?
    fn holds(&self, scene: &Scene, key: Key) -> bool {
        let held = self.items.get(&key).zip(scene_item(scene, key));
        held.is_some_and(|(held, (mesh, _))| Arc::ptr_eq(mesh, self.sources[&held.source].mesh(held.level)))
    }

    /// Gives what was seen the levels that it wants, as far as they can be built within one step.
    ///
    /// `seen` is what looks at the scene as it is now saw, each of its own camera.
    ///
    /// # Errors
    /// [`SceneError::TooLarge`] where a method cannot see so fine a scene, [`SceneError::NotConvex`] where it cannot see
    /// levels that hide; then it stays as it was.
    pub fn refine(&mut self, scene: &mut Scene, seen: &[&VisibleSet]) -> Result<RefineStats, SceneError> {
        self.step += 1;
        let mut refined = RefineStats::default();
        let mut changes = Changes::new();
        for wanted in self.wanted(scene, seen) {
            if let Some(level) = self.take(&wanted, &mut refined) {
                changes.insert(wanted.key, level);
            }
        }
        self.give_up(&mut changes);
        let changed = self.change(scene, changes, &mut refined);
        refined.bytes = self.drop_unused();
        changed.map(|()| refined)
    }

    /// The level that an item gets now, if it is another than it has. Builds it, if there is room.
    fn take(&mut self, wanted: &Wanted, refined: &mut RefineStats) -> Option<Option<u32>> {
        let held = self.items.get_mut(&wanted.key)?;
        held.seen_at = self.step;
        let levels = self.sources.get_mut(&held.source)?;
        let room = refined.built == 0 || refined.faces < self.options.faces_per_step;
        if room && levels.lacks(wanted.level) {
            match levels.build(wanted.level) {
                Ok(faces) => {
                    refined.built += 1;
                    refined.faces += faces;
                }
                Err(why) => refined.failed.push((wanted.key.0, wanted.key.1, why)),
            }
        }
        let best = levels.best_for(wanted.level);
        refined.waiting += u32::from(levels.lacks(wanted.level) && best < Some(wanted.level));
        (best != held.level).then_some(best)
    }

    /// Has items that are not seen drawn by their volumes, the longest unseen first, where levels take too much memory.
    fn give_up(&self, changes: &mut Changes) {
        let limit = self.options.bytes;
        if self.sources.values().map(Levels::bytes).sum::<u64>() <= limit {
            return;
        }
        let mut uses: BTreeMap<(usize, u32), u32> = BTreeMap::new();
        let mut unseen = Vec::new();
        for (&key, held) in &self.items {
            if let Some(level) = changes.get(&key).copied().unwrap_or(held.level) {
                *uses.entry((held.source, level)).or_default() += 1;
                unseen.extend((held.seen_at < self.step).then_some((
                    held.seen_at,
                    key,
                    (held.source, level),
                )));
            }
        }
        unseen.sort_unstable();
        let bytes_of = |(source, level): (usize, u32)| self.sources[&source].bytes_of(level);
        let mut bytes: u64 = uses.keys().copied().map(bytes_of).sum();
        for (_, key, used) in unseen {
            if bytes <= limit {
                break;
            }
            changes.insert(key, None);
            let left = uses.entry(used).or_insert(1);
            *left -= 1;
            bytes -= if *left == 0 { bytes_of(used) } else { 0 };
        }
    }

    fn change(
        &mut self,
        scene: &mut Scene,
        mut changes: Changes,
        refined: &mut RefineStats,
    ) -> Result<(), SceneError> {
        // What somebody has removed or changed meanwhile is theirs.
        changes.retain(|&key, _| {
            let ours = self.holds(scene, key);
            if !ours {
                self.items.remove(&key);
            }
            ours
        });
        let mut edit = scene.edit();
        for (&key, &level) in &changes {
            let held = &self.items[&key];
            let levels = &self.sources[&held.source];
            let is_occluder = held.may_hide && levels.is_exact(level);
            let asked = edit
                .set_mesh(key.0, key.1, Arc::clone(levels.mesh(level)))
                .and_then(|()| edit.set_occluder(key.0, key.1, is_occluder));
            if let Err(why) = asked {
                self.items.remove(&key);
                refined.failed.push((key.0, key.1, why.to_string()));
            }
        }
        edit.finish()?;
        for (key, level) in changes {
            if let Some(held) = self.items.get_mut(&key) {
                held.level = level;
                refined.changed += 1;
            }
        }
        Ok(())
    }

    /// Lets go of levels that no item is drawn by, where all take too much memory; gives the bytes of those that are kept.
    fn drop_unused(&mut self) -> u64 {
        let sources: BTreeSet<usize> = self.items.values().map(|held| held.source).collect();
        self.sources.retain(|key, _| sources.contains(key));
        if self.sources.values().map(Levels::bytes).sum::<u64>() > self.options.bytes {
            let used: BTreeSet<(usize, u32)> = self
                .items
                .values()
                .filter_map(|held| Some((held.source, held.level?)))
                .collect();
            for (&key, levels) in &mut self.sources {
                levels.keep(|level| used.contains(&(key, level)));
            }
        }
        self.sources.values().map(Levels::bytes).sum()
    }
}

impl Held {
    fn new(source: usize, may_hide: bool) -> Held {
        Held {
            source,
            level: None,
            may_hide,
            seen_at: 0,
        }
    }
}

/// The mesh of an item, and whether it hides.
fn scene_item(scene: &Scene, (sector, item): Key) -> Option<(&Arc<Mesh>, bool)> {
    let there = (sector.0 as usize) < scene.sector_count();
    let geometry = there.then(|| scene.geometry(sector)).flatten()?;
    let item = geometry.holds(item).then(|| geometry.item(item))?;
    Some((&geometry.meshes()[item.mesh.0 as usize], item.is_occluder))
}

/// Why an item gets no levels.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DetailError {
    /// It cannot be put into the scene so.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// The scene cannot be changed so.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The box of the source holds nothing, or is not finite and within [`MAX_COORDINATE`].
    #[error(
        "the source's bounds hold nothing, are not finite, or reach farther out than {MAX_COORDINATE:e} units"
    )]
    NoBounds,
    /// The source panicked when it was asked how large it is.
    #[error("the source panicked: {0}")]
    Panicked(String),
}
