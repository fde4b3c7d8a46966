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
mod shapes;
#[cfg(test)]
mod tests;
mod tile;

pub use shapes::{Occluder, Volume};

use super::Sight;
use crate::aperture::Rect;
use crate::passage::Passage;
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
        MaskedDepth {
            level: Level::new(),
            fill: Fill::default(),
            grid: Grid::default(),
            near: 0.0,
        }
    }
}

impl MaskedDepth {
    /// Starts over: only the passage's aperture is open, everything else counts as covered.
    pub fn clear(&mut self, passage: &Passage) {
        self.grid.clear(passage);
        self.near = f64::from(passage.near);
    }

    /// Lets an occluder hide what is behind it; gives the number of samples it covers.
    pub fn hide(&mut self, occluder: &Occluder, passage: &Passage) -> u64 {
        self.fill.hide(&mut self.grid, occluder, passage)
    }

    /// How much of a box can still be seen. `Partly` when unsure.
    pub fn sees(&mut self, rect: &Rect, nearest: f32, volume: &Volume) -> Sight {
        let seen =
            dispatch!(self.level, simd => ask::sees(simd, &self.grid, rect, nearest, volume, self.near));
        if seen { Sight::Partly } else { Sight::Hidden }
    }

    /// Memory in bytes for a screen of this size.
    pub fn needs_bytes(size: [u32; 2]) -> u64 {
        let tiles = u64::from(size[0].div_ceil(COLUMNS as u32)) * u64::from(size[1].div_ceil(ROWS as u32));
        tiles * (size_of::<Tile>() + size_of::<f32>()) as u64
    }
}
