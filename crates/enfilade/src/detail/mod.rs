//! Levels of detail: a volume now, geometry when it is found visible, as fine as it is large on the screen.
//!
//! Looks see what stands in the scene. Between them, what was seen is refined: each item that was gets the coarsest level
//! whose error is below a tolerance in pixels where it stands; a level is built when it is wanted first, and a look's
//! building is bounded. What is not built yet is drawn by what there is.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3 (an object is tested by its volume, and
//!     only then refined); hysteresis as in Luebke and others, Level of Detail for 3D Graphics, 2003, section 4.5.
//! Cost: a step O(items with levels that are seen), an edit of those that change, and what sources take to build.
//! Only a level without error hides: what is behind a coarser one is seen past it, whatever method looks.

mod bezier;
mod choose;
mod source;

pub use bezier::{BezierPatch, BezierSurface};
pub use source::DetailSource;

use crate::content::ItemId;
use crate::geom::Transform;
use crate::scene::{EditError, FragmentId, Scene, SceneError};
use crate::visible::VisibleSet;
use choose::Wanted;
use source::Levels;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The items of a scene that have levels of detail.
///
/// Lives beside the scene: look, then [`Details::refine`], then look again.
#[derive(Default)]
pub struct Details {
    options: DetailOptions,
    items: BTreeMap<(FragmentId, ItemId), Held>,
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

/// An item with levels.
struct Held {
    source: usize,
    /// What it is drawn by; `None`: its volume.
    level: Option<u32>,
    seen_at: u64,
}

/// What a step did.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Refined {
    /// Levels that were built, and their faces.
    pub built: u32,
    /// Faces of those levels.
    pub faces: u64,
    /// Items that have another level now.
    pub changed: u32,
    /// Items that are drawn by a coarser level than they should be, as the step was over.
    pub waiting: u32,
    /// Items that keep what they have, as their source failed, and why; each is told once.
    pub failed: Vec<(FragmentId, ItemId, String)>,
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

    /// Adds an item to a scene: for now its volume, of `material`, which hides nothing.
    ///
    /// # Errors
    /// As [`Edit::add`](crate::Edit::add) and [`Edit::finish`](crate::Edit::finish); then nothing is added.
    pub fn add(
        &mut self,
        scene: &mut Scene,
        fragment: FragmentId,
        name: &str,
        source: Arc<dyn DetailSource>,
        fragment_from_item: Transform,
    ) -> Result<ItemId, DetailError> {
        let key = self.levels_of(source);
        let volume = Arc::clone(&self.sources[&key].volume);
        let mut edit = scene.edit();
        let item = edit.add(fragment, name, volume, fragment_from_item)?;
        edit.set_hides(fragment, item, false)?;
        edit.finish()?;
        self.hold(fragment, item, key);
        Ok(item)
    }

    /// Gives levels to items that are in the scene: for now their volumes.
    ///
    /// # Errors
    /// As [`Edit::set_mesh`](crate::Edit::set_mesh) and [`Edit::finish`](crate::Edit::finish); then none is changed.
    pub fn adopt(
        &mut self,
        scene: &mut Scene,
        items: impl IntoIterator<Item = (FragmentId, ItemId, Arc<dyn DetailSource>)>,
    ) -> Result<(), DetailError> {
        let mut edit = scene.edit();
        let mut adopted = Vec::new();
        for (fragment, item, source) in items {
            let key = self.levels_of(source);
            edit.set_mesh(fragment, item, Arc::clone(&self.sources[&key].volume))?;
            edit.set_hides(fragment, item, false)?;
            adopted.push((fragment, item, key));
        }
        edit.finish()?;
        for (fragment, item, key) in adopted {
            self.hold(fragment, item, key);
        }
        Ok(())
    }

    /// Forgets an item, which keeps the level that it has: before it is removed from the scene.
    pub fn forget(&mut self, fragment: FragmentId, item: ItemId) {
        self.items.remove(&(fragment, item));
    }

    /// The level that an item is drawn by, if it has any; `Some(None)` where that is its volume.
    pub fn level(&self, fragment: FragmentId, item: ItemId) -> Option<Option<u32>> {
        self.items.get(&(fragment, item)).map(|held| held.level)
    }

    fn levels_of(&mut self, source: Arc<dyn DetailSource>) -> usize {
        let key = Arc::as_ptr(&source).addr();
        self.sources.entry(key).or_insert_with(|| Levels::new(source));
        key
    }

    fn hold(&mut self, fragment: FragmentId, item: ItemId, source: usize) {
        let held = Held {
            source,
            level: None,
            seen_at: self.step,
        };
        self.items.insert((fragment, item), held);
    }

    /// Gives what was seen the levels that it wants, as far as they can be built within one step.
    ///
    /// `seen` is what looks at the scene as it is now saw, each of its own camera.
    ///
    /// # Errors
    /// [`SceneError::TooLarge`] where a method cannot see so fine a scene; then it stays as it was.
    pub fn refine(&mut self, scene: &mut Scene, seen: &[&VisibleSet]) -> Result<Refined, SceneError> {
        self.step += 1;
        let mut refined = Refined::default();
        let mut changes = Vec::new();
        for wanted in self.wanted(scene, seen) {
            if let Some(level) = self.take(&wanted, &mut refined) {
                changes.push((wanted.key, level));
            }
        }
        self.give_up(&mut changes);
        refined.changed = changes.len() as u32;
        self.change(scene, changes)?;
        refined.bytes = self.drop_unused();
        Ok(refined)
    }

    /// The level that an item gets now, if it is another than it has. Builds it, if there is room.
    fn take(&mut self, wanted: &Wanted, refined: &mut Refined) -> Option<Option<u32>> {
        let held = self.items.get_mut(&wanted.key)?;
        held.seen_at = self.step;
        let levels = self.sources.get_mut(&held.source)?;
        if refined.built == 0 || refined.faces < self.options.faces_per_step {
            match levels.build(wanted.level) {
                Ok(None) => {}
                Ok(Some(faces)) => {
                    refined.built += 1;
                    refined.faces += faces;
                }
                Err(why) => {
                    let (fragment, item) = wanted.key;
                    refined.failed.extend(why.map(|why| (fragment, item, why)));
                }
            }
        }
        let best = levels.best_for(wanted.level, held.level);
        refined.waiting += u32::from(best < Some(wanted.level) && !levels.has_failed(wanted.level));
        (best != held.level).then_some(best)
    }

    /// Of what is not seen, those that must go lest levels take too much memory: the longest unseen first.
    fn give_up(&mut self, changes: &mut Vec<((FragmentId, ItemId), Option<u32>)>) {
        let mut bytes: u64 = self.sources.values().map(Levels::bytes).sum();
        if bytes <= self.options.bytes {
            return;
        }
        let unseen = self
            .items
            .iter()
            .filter(|(_, held)| held.seen_at < self.step && held.level.is_some());
        let mut unseen: Vec<_> = unseen.map(|(&key, held)| (held.seen_at, key)).collect();
        unseen.sort_unstable();
        let mut uses: BTreeMap<(usize, u32), usize> = BTreeMap::new();
        for held in self.items.values() {
            if let Some(level) = held.level {
                *uses.entry((held.source, level)).or_default() += 1;
            }
        }
        for (_, key) in unseen {
            if bytes <= self.options.bytes {
                break;
            }
            let held = &self.items[&key];
            let Some(level) = held.level else { continue };
            changes.push((key, None));
            let left = uses.entry((held.source, level)).or_insert(1);
            *left -= 1;
            if *left == 0 {
                bytes -= self.sources[&held.source].bytes_of(level);
            }
        }
    }

    fn change(
        &mut self,
        scene: &mut Scene,
        changes: Vec<((FragmentId, ItemId), Option<u32>)>,
    ) -> Result<(), SceneError> {
        let mut edit = scene.edit();
        let mut gone = BTreeSet::new();
        for &(key, level) in &changes {
            let levels = &self.sources[&self.items[&key].source];
            let asked = edit
                .set_mesh(key.0, key.1, levels.mesh(level))
                .and_then(|()| edit.set_hides(key.0, key.1, levels.is_exact(level)));
            // Somebody has removed it, or its mesh does not fit: then it stays as it is.
            if asked.is_err() {
                gone.insert(key);
            }
        }
        edit.finish()?;
        for (key, level) in changes {
            if gone.contains(&key) {
                self.items.remove(&key);
            } else if let Some(held) = self.items.get_mut(&key) {
                held.level = level;
            }
        }
        Ok(())
    }

    /// Lets go of levels that no item is drawn by; gives the bytes of those that are kept.
    fn drop_unused(&mut self) -> u64 {
        let used: BTreeSet<(usize, u32)> = self
            .items
            .values()
            .filter_map(|held| Some((held.source, held.level?)))
            .collect();
        let sources: BTreeSet<usize> = self.items.values().map(|held| held.source).collect();
        self.sources.retain(|key, _| sources.contains(key));
        let mut bytes: u64 = self.sources.values().map(Levels::bytes).sum();
        if bytes > self.options.bytes {
            for (&key, levels) in &mut self.sources {
                levels.keep(|level| used.contains(&(key, level)));
            }
            bytes = self.sources.values().map(Levels::bytes).sum();
        }
        bytes
    }
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
}
