//! A cache of meshes that occur more than once in the palace.

use super::palette::dress;
use super::sculpt::Carved;
use crate::shape::Shape;
use enfilade::Mesh;
use std::collections::HashMap;
use std::sync::Arc;

/// The meshes built so far, by kind.
#[derive(Default)]
pub(crate) struct Workshop {
    made: HashMap<String, Arc<Mesh>>,
    carved: HashMap<String, Arc<Carved>>,
}

impl Workshop {
    /// Returns the mesh of this kind; calls `make` the first time. `kind` must encode everything that `make` depends
    /// on.
    pub(crate) fn piece(&mut self, kind: String, make: impl FnOnce() -> Shape) -> Arc<Mesh> {
        self.mesh(kind, || make().dressed(dress))
    }

    /// As [`Workshop::piece`], for meshes that are not built from a [`Shape`].
    pub(crate) fn mesh(&mut self, kind: String, make: impl FnOnce() -> Arc<Mesh>) -> Arc<Mesh> {
        Arc::clone(self.made.entry(kind).or_insert_with(make))
    }

    /// As [`Workshop::piece`], for sculptures, which occur in several materials.
    pub(crate) fn carved(&mut self, kind: String, make: impl FnOnce() -> Carved) -> Arc<Carved> {
        Arc::clone(self.carved.entry(kind).or_insert_with(|| Arc::new(make())))
    }
}
