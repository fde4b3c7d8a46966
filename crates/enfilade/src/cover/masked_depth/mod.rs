//! Masked occlusion buffer: for each 8×4 samples two nearnesses, and a mask that says which of them holds where.
//!
//! Sixteen bytes say of 32 samples what would take a depth buffer 128, and one comparison answers for all of them. It
//! holds no picture: chosen occluders go in first, then boxes are held against it.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016; the answer does not depend
//!     on how many sub-tiles a kernel takes at once. Beyond the paper: the second test, by a box's outline and front sides.
//! Cost: clear O(tiles of the aperture); an occluder O(tiles it reaches into); a box O(tiles of its rectangle) where it
//!     is hidden, less where it is plainly seen.
//! Conservative: what is stored is never nearer than the truth, a box is never asked about farther than it is, and what
//!     is equally near is seen.

mod ask;
mod fill;
mod grid;
mod outline;
mod show;
#[cfg(test)]
mod tests;
mod tile;

use super::{Cover, Hides};
use crate::canvas::{Canvas, CoverShape};
use crate::occluders::{Measure, Occluder};
use crate::order::Unsorted;
use crate::passage::Passage;
use crate::region::{Region, Sight};
use crate::stats::Stats;
use fearless_simd::{Level, dispatch};
use fill::Fill;
use grid::Grid;
use tile::{COLUMNS, ROWS, Tile};

/// A masked occlusion buffer.
pub struct MaskedDepth {
    level: Level,
    fill: Fill,
    grid: Grid,
    near: f64,
}

impl Default for MaskedDepth {
    fn default() -> MaskedDepth {
        MaskedDepth::at(Level::new())
    }
}

impl MaskedDepth {
    /// At a SIMD level, which changes the time it takes and no bit of what it says.
    fn at(level: Level) -> MaskedDepth {
        MaskedDepth {
            level,
            fill: Fill::at(level),
            grid: Grid::default(),
            near: 0.0,
        }
    }
}

impl Cover for MaskedDepth {
    type CullNeeds = Unsorted;

    fn sees(&mut self, region: &Region) -> Sight {
        let seen = dispatch!(self.level, simd => self.grid.sees(simd, region, self.near));
        if seen { Sight::Partly } else { Sight::Hidden }
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
    const MEASURE: Measure = Measure::ProjectedArea;
    const OCCLUDERS: u32 = 512;

    fn clear(&mut self, passage: &Passage) {
        self.grid.clear(passage);
        self.near = f64::from(passage.near);
    }

    fn hide(&mut self, occluder: &Occluder, passage: &Passage, stats: &mut Stats) {
        stats.samples += self.fill.hide(&mut self.grid, occluder, passage);
    }
}
