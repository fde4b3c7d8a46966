//! Rows that rasterise faces.

use super::ceilings::Ceiling;
use super::screen::Screen;
use super::shapes::Shapes;
use super::truth::Truth;
use super::{Found, SUB_TILE_BYTES, Work};
use enfilade::cover::Hides;
use enfilade::{OccluderMesh, Stats};
use std::time::Instant;

/// Faces that go into an empty cover.
pub(super) struct Faces {
    shapes: Shapes,
    mesh: OccluderMesh,
    /// How often they go in for one figure.
    passes: u64,
}

impl Faces {
    /// So many that going in once takes long enough to be measured.
    pub(super) fn once(shapes: Shapes) -> Faces {
        let mesh = shapes.mesh();
        Faces {
            shapes,
            mesh,
            passes: 1,
        }
    }

    /// So few that they stay in the cache.
    pub(super) fn again_and_again(shapes: Shapes) -> Faces {
        Faces {
            passes: 1000,
            ..Faces::once(shapes)
        }
    }
}

impl Work for Faces {
    fn count(&self) -> u64 {
        self.shapes.faces().len() as u64 * self.passes
    }

    fn run(&mut self, screen: &mut Screen) -> f64 {
        let mut stats = Stats::default();
        // Emptying the cover is no part of what a face takes.
        screen.cover.clear(&screen.passage);
        let start = Instant::now();
        for _ in 0..self.passes {
            screen.cover.hide_mesh(&self.mesh, &screen.passage, &mut stats);
        }
        start.elapsed().as_secs_f64()
    }

    fn hold(&mut self, screen: &mut Screen) -> Found {
        let mut truth = Truth::new(screen.lens);
        let sub_tiles: u64 = self.shapes.faces().map(|face| truth.add(face)).sum();
        self.run(screen);
        let (least_bytes, ceiling) = if sub_tiles > 0 {
            (sub_tiles * SUB_TILE_BYTES, Ceiling::L2)
        } else {
            // Of backs only the corners must be read.
            let corner = size_of::<[f32; 3]>() + size_of::<u32>();
            ((self.shapes.positions.len() * corner) as u64, Ceiling::L1)
        };
        Found {
            held: truth.hold(|x, y| screen.cover.rev_depth_at(x, y)),
            least_bytes: least_bytes * self.passes,
            ceiling,
        }
    }
}
