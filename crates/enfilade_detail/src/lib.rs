//! Levels of detail (LOD): an item is a box at first; once visible, it gets a mesh as fine as its size on the screen
//! needs.
//!
//! Between looks, [`Details::refine`] gives each visible item the coarsest level whose geometric error, projected to
//! pixels, is within a tolerance. A level is built when it is first needed; the work per step is limited. Until then
//! the item keeps the best level already built. Items with levels are no special kind of item: [`Details`] replaces
//! their meshes by scene edits, so every method, every query and the reference see ordinary meshes.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3 (an object is tested by its volume,
//!     and refined only if visible); hysteresis as in Luebke and others, Level of Detail for 3D Graphics, 2003, section
//!     4.5.
//! Cost: a step is O(visible items with levels), plus an edit of the changed items, plus the time the sources take.
//! Visible sets refer to the current levels, not to the true surface: an item is visible if its current level is. A
//! coarse level can be hidden where a finer one would show past its occluder; only the box contains every level. A
//! level with an error above 0 is no occluder and hides nothing.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod bezier;
mod choose;
mod source;

pub use bezier::{BezierError, BezierPatch, BezierSurface};
pub use source::DetailSource;

use choose::WantedLevel;
use enfilade::{
    Edit, EditError, ItemId, ItemOptions, MAX_COORDINATE, Mesh, Scene, SceneError, SectorId, Transform,
    VisibleSet,
};
use source::Levels;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// LOD manager: the items of a scene that have levels of detail.
///
/// Keep it beside the scene and call [`Details::refine`] after each look. Looks see the current level of an item: an
/// item with a coarse level becomes visible when that level does, not when its finest level would.
#[doc(alias = "LOD")]
#[doc(alias = "level of detail")]
#[derive(Default)]
pub struct Details {
    options: DetailOptions,
    items: BTreeMap<Key, DetailedItem>,
    /// Each source once, keyed by its address.
    sources: BTreeMap<usize, Levels>,
    step: u64,
}

/// LOD tolerance and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct DetailOptions {
    /// Maximum error on the screen, in pixels; above 0.
    pub tolerance_px: f32,
    /// Hysteresis: a coarser level is chosen only if its error is this many times below the tolerance, so that items do
    /// not flicker between two levels. At least 1.
    pub hysteresis: f32,
    /// Streaming budget: no further level is started after this many faces were built in a step. At least one level is
    /// built.
    pub faces_per_step: u64,
    /// Memory limit for levels, in bytes. Above it, levels of invisible items are dropped.
    pub bytes: u64,
}

impl Default for DetailOptions {
    /// 1 pixel, hysteresis 1.25, 100,000 faces, 256 MB.
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

/// New level per item.
type Changes = BTreeMap<Key, Option<u32>>;

/// An item with levels.
struct DetailedItem {
    source: usize,
    /// Current level; `None`: the box.
    level: Option<u32>,
    /// Whether it is an occluder when drawn with an exact level.
    may_hide: bool,
    seen_at: u64,
}

/// Statistics of a [`Details::refine`] step.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct RefineStats {
    /// Number of levels built.
    pub built: u32,
    /// Number of faces of those levels.
    pub faces: u64,
    /// Number of items whose level changed.
    pub changed: u32,
    /// Number of items whose level is still too coarse because the budget of the step was used up.
    pub waiting: u32,
    /// Items that keep their level because the new one could not be built or does not fit, and the reason. Each level
    /// of a source is reported once, for the first item that needed it.
    pub failed: Vec<(SectorId, ItemId, String)>,
    /// Memory of all levels kept, in bytes.
    pub bytes: u64,
}

impl Details {
    /// Creates a manager without items.
    pub fn new(options: DetailOptions) -> Details {
        Details {
            options,
            ..Details::default()
        }
    }

    /// Adds an item to a scene, drawn as its box, which is no occluder, until it is refined. Items with the same source
    /// share its levels.
    ///
    /// # Errors
    /// [`DetailError`]; the scene is unchanged then.
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
        let options = ItemOptions {
            is_occluder: false,
            ..ItemOptions::default()
        };
        edit.set_options(sector, item, options)?;
        edit.finish()?;
        self.items.insert((sector, item), DetailedItem::new(source, true));
        Ok(item)
    }

    /// Gives levels to items of a scene. They are drawn as their boxes until they are refined.
    ///
    /// # Errors
    /// [`DetailError`]; no item is changed then.
    pub fn adopt(
        &mut self,
        scene: &mut Scene,
        items: impl IntoIterator<Item = (SectorId, ItemId, Arc<dyn DetailSource>)>,
    ) -> Result<(), DetailError> {
        let mut adopted = Vec::new();
        for (sector, item, source) in items {
            let is_occluder =
                scene_item(scene, (sector, item)).is_none_or(|(_, options)| options.is_occluder);
            adopted.push((
                (sector, item),
                DetailedItem::new(self.levels_of(source)?, is_occluder),
            ));
        }
        let mut edit = scene.edit();
        for ((sector, item), held) in &adopted {
            edit.set_mesh(*sector, *item, Arc::clone(self.sources[&held.source].mesh(None)))?;
            set_occluder(&mut edit, (*sector, *item), false)?;
        }
        edit.finish()?;
        self.items.extend(adopted);
        Ok(())
    }

    /// Stops managing an item; it keeps its current level. Not needed for items that were removed from the scene or
    /// given another mesh.
    pub fn forget(&mut self, sector: SectorId, item: ItemId) {
        self.items.remove(&(sector, item));
    }

    /// Returns the current level of an item: `Some(None)` if it is drawn as its box, `None` if it is not managed.
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

    /// Returns `true` if the item still has the mesh that was set here.
    fn holds(&self, scene: &Scene, key: Key) -> bool {
        let held = self.items.get(&key).zip(scene_item(scene, key));
        held.is_some_and(|(held, (mesh, _))| Arc::ptr_eq(mesh, self.sources[&held.source].mesh(held.level)))
    }

    /// Gives the visible items the levels they need, as far as the budget of one step allows.
    ///
    /// `seen` holds the visible sets of looks at the scene in its current state, one per camera.
    ///
    /// # Errors
    /// [`SceneError::Unsuited`] if a method cannot handle a scene this fine, or the levels that are occluders; the scene
    /// is unchanged then.
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

    /// Returns the new level of an item if it changes. Builds the target level if the budget allows.
    fn take(&mut self, wanted: &WantedLevel, refined: &mut RefineStats) -> Option<Option<u32>> {
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

    /// If the levels exceed the memory limit, switches invisible items back to their boxes, those invisible for longest
    /// first.
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
        // Items that the user removed or changed meanwhile are no longer managed.
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
                .and_then(|()| set_occluder(&mut edit, key, is_occluder));
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

    /// Drops unused levels if all together exceed the memory limit. Returns the bytes that are kept.
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

impl DetailedItem {
    fn new(source: usize, may_hide: bool) -> DetailedItem {
        DetailedItem {
            source,
            level: None,
            may_hide,
            seen_at: 0,
        }
    }
}

/// Sets whether an item is an occluder, and keeps its other options.
fn set_occluder(edit: &mut Edit, (sector, item): Key, is_occluder: bool) -> Result<(), EditError> {
    let known = scene_item(edit.scene(), (sector, item));
    let options = ItemOptions {
        is_occluder,
        ..known.map_or_else(ItemOptions::default, |(_, options)| options)
    };
    edit.set_options(sector, item, options)
}

/// Returns the mesh and the options of an item.
fn scene_item(scene: &Scene, (sector, item): Key) -> Option<(&Arc<Mesh>, ItemOptions)> {
    let there = (sector.0 as usize) < scene.sector_count();
    let geometry = there.then(|| scene.geometry(sector)).flatten()?;
    let item = geometry.item(geometry.index_of(item)?);
    Some((&geometry.meshes()[item.mesh.0 as usize], item.options))
}

/// Why an item cannot get levels.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DetailError {
    /// The item cannot be added or changed.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// The scene cannot be changed.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The source's bounds are empty, not finite, or beyond [`MAX_COORDINATE`].
    #[error("the source's bounds are empty, not finite, or beyond {MAX_COORDINATE:e} units")]
    NoBounds,
    /// The source panicked while its bounds, material and levels were read.
    #[error("the source panicked: {0}")]
    Panicked(String),
}
