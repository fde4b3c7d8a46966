//! Looks of many views: one task each, on the threads of the pool.

#[cfg(all(test, feature = "rayon"))]
mod tests;

use crate::scene::Scene;
use crate::threads;
use crate::view::View;
use crate::view::options::ViewerOptions;
use crate::view::viewer::Viewer;
use crate::view::viewers::{KeptView, Viewers};
use crate::view::visible::VisibleSet;
use std::sync::{Mutex, PoisonError};

/// One look: its view, and the buffers that stay with it.
pub(crate) struct Task<'a> {
    pub(crate) view: &'a View,
    pub(crate) set: &'a mut VisibleSet,
    pub(crate) kept: &'a mut KeptView,
}

impl Viewers {
    /// Computes the visible sets of several views, and returns them in the same order. Each is the same as that of
    /// [`Viewer::look`].
    #[doc(alias = "cull")]
    pub fn look_many(&mut self, scene: &Scene, views: &[View]) -> &[VisibleSet] {
        self.sets.resize_with(views.len(), VisibleSet::default);
        self.kept.resize_with(views.len(), KeptView::default);
        let each = views.iter().zip(&mut self.sets).zip(&mut self.kept);
        let mut tasks: Vec<Task> = each.map(|((view, set), kept)| Task { view, set, kept }).collect();
        look_each(&mut self.threads, &self.options, scene, &mut tasks);
        &self.sets
    }
}

/// Does each look, on as many threads as the options allow. `viewers` are the buffers of the threads.
pub(crate) fn look_each(
    viewers: &mut Vec<Viewer>,
    options: &ViewerOptions,
    scene: &Scene,
    tasks: &mut [Task],
) {
    if !(options.parallel && tasks.len() > 1) {
        if viewers.is_empty() {
            viewers.push(Viewer::new());
        }
        for task in tasks {
            task.run(&mut viewers[0], *options, scene);
        }
        return;
    }
    let alone = ViewerOptions {
        // Otherwise a look that waits for others could begin another one, with further buffers.
        parallel: false,
        ..*options
    };
    let idle = Mutex::new(std::mem::take(viewers));
    let lock = || idle.lock().unwrap_or_else(PoisonError::into_inner);
    threads::for_each(tasks, |_, task| {
        let taken = lock().pop();
        let mut viewer = taken.unwrap_or_default();
        task.run(&mut viewer, alone, scene);
        lock().push(viewer);
    });
    *viewers = idle.into_inner().unwrap_or_else(PoisonError::into_inner);
}

impl Task<'_> {
    fn run(&mut self, viewer: &mut Viewer, options: ViewerOptions, scene: &Scene) {
        viewer.options = options;
        std::mem::swap(&mut viewer.set, self.set);
        std::mem::swap(&mut viewer.memory.recall, &mut self.kept.recall);
        viewer.look(scene, self.view);
        std::mem::swap(&mut viewer.set, self.set);
        std::mem::swap(&mut viewer.memory.recall, &mut self.kept.recall);
        self.kept.stats = viewer.memory.stats;
    }
}
