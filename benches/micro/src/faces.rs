//! Rows that rasterize faces.

use super::ceilings::Ceiling;
use super::screen::Screen;
use super::shapes::Shapes;
use super::truth::Truth;
use super::{SUB_TILE_BYTES, Verification, Workload};
use enfilade::{OccluderMesh, Transform};
use std::time::Instant;

/// Faces that are rasterized into an empty depth buffer.
pub(super) struct Faces {
    shapes: Shapes,
    mesh: OccluderMesh,
    /// Number of times all faces are rasterized in one run.
    passes: u64,
}

impl Faces {
    /// Creates a row that rasterizes the faces once per run; use it for many faces.
    pub(super) fn once(shapes: Shapes) -> Faces {
        let mesh = shapes.mesh();
        Faces {
            shapes,
            mesh,
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
            screen.cover.draw(&self.mesh, &Transform::IDENTITY);
        }
        start.elapsed().as_secs_f64()
    }

    fn check(&mut self, screen: &mut Screen) -> Verification {
        let mut truth = Truth::new(screen.lens);
        let sub_tiles: u64 = self.shapes.faces().map(|face| truth.add(face)).sum();
        self.run(screen);
        let (min_bytes, ceiling) = if sub_tiles > 0 {
            (sub_tiles * SUB_TILE_BYTES, Ceiling::L2)
        } else {
            // Of back faces only the vertices and indices must be read.
            let corner = size_of::<[f32; 3]>() + size_of::<u32>();
            ((self.shapes.positions.len() * corner) as u64, Ceiling::L1)
        };
        Verification {
            errors: truth.check(&screen.cover.depth()),
            min_bytes: min_bytes * self.passes,
            ceiling,
        }
    }
}
