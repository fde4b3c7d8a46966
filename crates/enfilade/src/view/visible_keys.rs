//! The keys of visible items, and how they change from look to look.

use super::visible::VisibleSet;

/// The distinct keys of the items of a visible set, and the changes since the update before: what an engine shows, hides,
/// wakes or puts to sleep.
///
/// Keep one beside each [`Viewer`](crate::Viewer). It allocates nothing once its buffers have grown.
///
/// ```
/// # use enfilade::*;
/// # let scene = enfilade_scenes::built_in("two-rooms").expect("a scene");
/// # let view = scene.cameras[0].view([320, 180])?;
/// # let scene = scene.scene;
/// let (mut viewer, mut keys) = (Viewer::new(), VisibleKeys::default());
/// keys.update(viewer.look(&scene, &view));
/// assert_eq!(keys.entered(), keys.all());
/// keys.update(viewer.look(&scene, &view));
/// assert!(keys.entered().is_empty() && keys.left().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "visibility changed")]
#[derive(Clone, Debug, Default)]
pub struct VisibleKeys {
    all: Vec<u64>,
    before: Vec<u64>,
    entered: Vec<u64>,
    left: Vec<u64>,
}

impl VisibleKeys {
    /// Takes the keys of a set, and compares them with those of the update before.
    ///
    /// Cost: O(n log n) for n visible items.
    pub fn update(&mut self, set: &VisibleSet) {
        self.update_with(set, []);
    }

    /// Takes the keys of a set and others that count as visible: those of another view, such as the other eye's, or of objects
    /// that the scene does not hold.
    pub fn update_with(&mut self, set: &VisibleSet, others: impl IntoIterator<Item = u64>) {
        std::mem::swap(&mut self.all, &mut self.before);
        self.all.clear();
        self.all.extend(set.items().iter().map(|item| item.key));
        self.all.extend(others);
        self.all.sort_unstable();
        self.all.dedup();
        missing_from(&self.before, &self.all, &mut self.entered);
        missing_from(&self.all, &self.before, &mut self.left);
    }

    /// Returns the keys that are visible, each once, whatever passages show its items; ascending.
    pub fn all(&self) -> &[u64] {
        &self.all
    }

    /// Returns the keys that became visible with the last update, ascending.
    pub fn entered(&self) -> &[u64] {
        &self.entered
    }

    /// Returns the keys that are no longer visible since the last update, ascending.
    pub fn left(&self) -> &[u64] {
        &self.left
    }

    /// Returns `true` if an item with this key is visible.
    pub fn contains(&self, key: u64) -> bool {
        self.all.binary_search(&key).is_ok()
    }
}

/// Replaces `missing` by the numbers of `these` that are not in `known`; both are ascending without repeats.
fn missing_from(known: &[u64], these: &[u64], missing: &mut Vec<u64>) {
    missing.clear();
    let mut known = known.iter().peekable();
    missing.extend(these.iter().filter(|this| {
        while known.next_if(|other| other < this).is_some() {}
        known.peek() != Some(this)
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Dice;
    use std::collections::BTreeSet;

    #[test]
    fn what_is_missing_is_what_a_set_says() {
        let mut dice = Dice::new(3);
        for _ in 0..500 {
            let [known, these] = [(); 2].map(|()| {
                let count = dice.below(12);
                (0..count)
                    .map(|_| dice.below(16) as u64)
                    .collect::<BTreeSet<u64>>()
            });
            let mut missing = vec![7];
            let list = |set: &BTreeSet<u64>| set.iter().copied().collect::<Vec<_>>();
            missing_from(&list(&known), &list(&these), &mut missing);
            assert_eq!(missing, these.difference(&known).copied().collect::<Vec<_>>());
        }
    }
}
