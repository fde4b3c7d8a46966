//! Where things are made once, however often they stand in the palace.

use super::palette::dress;
use crate::shape::Shape;
use enfilade::Mesh;
use std::collections::HashMap;
use std::sync::Arc;

/// The things made so far, by what they are.
#[derive(Default)]
pub(crate) struct Workshop {
    made: HashMap<String, Arc<Mesh>>,
}

impl Workshop {
    /// The thing of this kind; `make` is asked the first time. `kind` must tell apart all that `make` depends on.
    pub(crate) fn piece(&mut self, kind: String, make: impl FnOnce() -> Shape) -> Arc<Mesh> {
        self.mesh(kind, || make().dressed(dress))
    }

    /// The same for what is no [`Shape`].
    pub(crate) fn mesh(&mut self, kind: String, make: impl FnOnce() -> Arc<Mesh>) -> Arc<Mesh> {
        Arc::clone(self.made.entry(kind).or_insert_with(make))
    }
}
