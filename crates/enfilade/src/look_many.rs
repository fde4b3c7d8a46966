//! Looks of many views: one task each, on the threads of the pool.

use crate::scene::Scene;
use crate::threads;
use crate::view::View;
use crate::view::viewer::Viewer;
use crate::view::viewers::{KeptView, Viewers};
use crate::view::visible::VisibleSet;
use std::sync::{Mutex, PoisonError};

/// One look: the buffers that stay with its view.
struct Task<'a> {
    view: &'a View,
    set: &'a mut VisibleSet,
    kept: &'a mut KeptView,
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
        if !(self.options.parallel && views.len() > 1) {
            if self.threads.is_empty() {
                self.threads.push(Viewer::new());
            }
            let viewer = &mut self.threads[0];
            viewer.options = self.options;
            for task in &mut tasks {
                task.run(viewer, scene);
            }
            return &self.sets;
        }
        let idle = Mutex::new(std::mem::take(&mut self.threads));
        let lock = || idle.lock().unwrap_or_else(PoisonError::into_inner);
        threads::for_each(&mut tasks, |_, task| {
            let taken = lock().pop();
            let mut viewer = taken.unwrap_or_default();
            viewer.options = self.options;
            // Otherwise a look that waits for others could begin another one, with further buffers.
            viewer.options.parallel = false;
            task.run(&mut viewer, scene);
            lock().push(viewer);
        });
        self.threads = idle.into_inner().unwrap_or_else(PoisonError::into_inner);
        &self.sets
    }
}

impl Task<'_> {
    fn run(&mut self, viewer: &mut Viewer, scene: &Scene) {
        std::mem::swap(&mut viewer.set, self.set);
        std::mem::swap(&mut viewer.memory.recall, &mut self.kept.recall);
        viewer.look(scene, self.view);
        std::mem::swap(&mut viewer.set, self.set);
        std::mem::swap(&mut viewer.memory.recall, &mut self.kept.recall);
        self.kept.stats = viewer.memory.stats;
    }
}

#[cfg(all(test, feature = "rayon"))]
mod tests {
    use super::*;
    use crate::geometry::{GeometryBuilder, Material};
    use crate::ids::MaterialId;
    use crate::mesh::Mesh;
    use crate::method::Method;
    use crate::view::options::ViewerOptions;

    #[test]
    fn there_are_as_many_buffers_as_threads_however_many_views() {
        let mut room = GeometryBuilder::new([Material::opaque([0.5; 3])]);
        let cube = room.mesh(Mesh::cuboid([-1.0; 3], [1.0; 3], MaterialId(0)).expect("a cube"));
        room.item("cube", cube, crate::Transform::IDENTITY);
        let scene = Scene::single(room.build().expect("a room"), Method::Masked).expect("a scene");
        let view = View::new([0.0, 0.0, 9.0], [0.0; 3], [64, 36]).expect("a valid view");
        let views = vec![view; 50];
        for (parallel, count) in [(false, 1), (true, 3)] {
            let mut viewers = Viewers::with_options(ViewerOptions {
                parallel,
                ..ViewerOptions::default()
            });
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(3)
                .build()
                .expect("a pool");
            let sets = pool.install(|| viewers.look_many(&scene, &views).len());
            assert_eq!((sets, viewers.stats().count()), (50, 50));
            assert!(
                (1..=count).contains(&viewers.threads.len()),
                "{}",
                viewers.threads.len()
            );
            assert!(viewers.visible().iter().all(|set| set.items().len() == 1));
            viewers.look_many(&scene, &views[..2]);
            assert_eq!(viewers.visible().len(), 2);
        }
    }
}
