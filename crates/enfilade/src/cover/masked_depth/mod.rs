//! Masked occlusion buffer: for each 8×4 samples two reversed depths, and a mask that says which of them holds where.
//!
//! Sixteen bytes say of 32 samples what would take a depth buffer 128, and one comparison answers for all of them. It
//! holds no picture: few chosen occluders go in first, then boxes are held against it, and the faces of what a walk finds
//! hide what it finds later.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016; the answer does not depend
//!     on how many sub-tiles a kernel takes at once. Beyond the paper: the second test, by a box's outline and front
//!     sides, and holding faces against the tiles as boxes are. Leaving out faces that are small on the screen: Boreskov,
//!     Hierarchical s-buffer for scenes of high complexity.
//! Cost: clear O(tiles of the aperture); an occluder or a face O(tiles it reaches into); a box O(tiles of its rectangle)
//!     where it is hidden, less where it is plainly seen.
//! Conservative: what is stored is never nearer than the truth, a box is never asked about farther than it is, and what
//!     is equally near is seen.

mod ask;
mod batch;
mod coarse;
mod faces;
mod fill;
mod grid;
mod mesh;
mod outline;
mod rows;
mod show;
#[cfg(test)]
mod tests;
mod tile;
mod worker;

use super::{Cover, Hides};
use crate::aperture::Rect;
use crate::canvas::{Canvas, CoverShape};
use crate::faces::Faces;
use crate::occluders::{Occluder, OccluderMeasure};
use crate::order::Unsorted;
use crate::passage::Passage;
use crate::region::{Region, Visibility};
use crate::simd::level;
use crate::stats::Stats;
use fearless_simd::{Level, dispatch};
use fill::Fill;
use grid::Grid;
pub use mesh::OccluderMesh;
use tile::{COLUMNS, ROWS, Tile};
use worker::Worker;

/// Samples of a box, for each face in it, from which on its faces are let in. Where they have fewer, what they hide is not
/// worth setting them up.
const WORTH: u64 = 4;

/// A masked occlusion buffer.
pub struct MaskedDepth {
    level: Level,
    fill: Fill,
    worker: Worker,
    /// Those of strips.
    workers: Vec<Worker>,
    grid: Grid,
    near: f64,
}

impl Default for MaskedDepth {
    fn default() -> MaskedDepth {
        MaskedDepth::at(level())
    }
}

impl MaskedDepth {
    /// At a SIMD level, which changes the time it takes and no bit of what it says.
    fn at(level: Level) -> MaskedDepth {
        MaskedDepth {
            level,
            fill: Fill::at(level),
            worker: Worker::at(level),
            workers: Vec::new(),
            grid: Grid::default(),
            near: 0.0,
        }
    }
}

impl Cover for MaskedDepth {
    type CullNeeds = Unsorted;

    fn sees(&mut self, region: &Region) -> Visibility {
        let seen = dispatch!(self.level, simd => self.grid.sees(simd, region, self.near));
        if seen {
            Visibility::Partial
        } else {
            Visibility::Hidden
        }
    }

    fn needs_bytes(size: [u32; 2]) -> u64 {
        let tiles = u64::from(size[0].div_ceil(COLUMNS as u32)) * u64::from(size[1].div_ceil(ROWS as u32));
        tiles * (size_of::<Tile>() + size_of::<f32>()) as u64
    }

    const SHAPE: Option<CoverShape> = Some(CoverShape::Tiles);

    fn show(&mut self, passage: &Passage, canvas: &mut dyn Canvas) {
        self.grid.show(passage, canvas);
    }
}

impl Hides for MaskedDepth {
    const MEASURE: OccluderMeasure = OccluderMeasure::ProjectedArea;
    // The faces that are found, from near to far, hide as much, and choosing takes longer than letting them in.
    const OCCLUDERS: u32 = 0;

    fn clear(&mut self, passage: &Passage) {
        self.grid.clear(passage);
        self.near = f64::from(passage.near);
    }

    fn hide(&mut self, occluder: &Occluder, passage: &Passage, stats: &mut Stats) {
        stats.samples += self.fill.hide(&mut self.grid, occluder, passage);
    }

    const TAKES_FACES: bool = true;

    fn hide_faces(&mut self, faces: &Faces, region: &Region, passage: &Passage, stats: &mut Stats) {
        if !Self::are_too_fine(faces.count() as u64, region) {
            self.worker
                .hide_batch(&mut self.grid.all(), faces, passage, stats);
        }
    }

    fn are_too_fine(triangles: u64, region: &Region) -> bool {
        let Rect { x0, y0, x1, y1 } = region.rect;
        u64::from(x1 - x0) * u64::from(y1 - y0) < WORTH * triangles
    }
}
