//! Rows that rasterize faces.

use super::Workload;
use super::screen::{Screen, draw};
use super::shapes::Shapes;
use super::truth::{ErrorCounts, Truth};
use enfilade::OccluderMesh;
use std::time::Instant;

/// Faces that are rasterized into an empty depth buffer.
pub(super) struct Faces {
    shapes: Shapes,
    meshes: Vec<OccluderMesh>,
    /// Number of times all faces are rasterized in one run.
    passes: u64,
}

impl Faces {
    /// Creates a row that rasterizes the faces once per run; use it for many faces.
    pub(super) fn once(shapes: Shapes) -> Faces {
        let meshes = shapes.meshes();
        Faces {
            shapes,
            meshes,
            passes: 1,
        }
    }

    /// Creates a row that rasterizes the faces repeatedly per run; use it for few faces, which stay in the cache.
    pub(super) fn repeated(shapes: Shapes) -> Faces {
        Faces {
            passes: 1000,
            ..Faces::once(shapes)
        }
    }
}

impl Workload for Faces {
    fn count(&self) -> u64 {
        self.shapes.faces().len() as u64 * self.passes
    }

    fn run(&mut self, screen: &mut Screen) -> f64 {
        // Clearing the buffer is not part of the cost of a face.
        screen.cover.begin(&screen.view);
        let start = Instant::now();
        for _ in 0..self.passes {
            draw(&mut screen.cover, &self.meshes);
        }
        start.elapsed().as_secs_f64()
    }

    fn check(&mut self, screen: &mut Screen) -> ErrorCounts {
        let mut truth = Truth::new(screen.lens);
        self.shapes.faces().for_each(|face| truth.add(face));
        self.run(screen);
        truth.check(&screen.cover.depth())
    }
}
