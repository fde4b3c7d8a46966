//! Min/max quadtree levels over the heights.

use super::Heights;
use crate::geom::is_in_range;
use crate::terrain::{BLOCK, HeightFieldError, bad_height};
use crate::threads;

/// Minimum and maximum heights of one quadtree level's squares, row after row.
pub(super) struct Level {
    /// Number of squares from west to east and from north to south.
    pub(super) size: [u32; 2],
    /// Minimum and maximum height of each square.
    spans: Vec<[f32; 2]>,
}

/// The empty height range.
pub(super) const NO_SPAN: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

/// Extends a height range by some heights.
pub(super) fn spanned([low, high]: [f32; 2], heights: &[f32]) -> [f32; 2] {
    let least = heights.iter().fold(low, |least, &height| least.min(height));
    let greatest = heights.iter().fold(high, |most, &height| most.max(height));
    [least, greatest]
}

impl Level {
    /// Builds all levels: level 0 holds the blocks, each further one 2×2 squares of the one before, up to a single
    /// square.
    pub(super) fn all(heights: &impl Heights) -> Result<Vec<Level>, HeightFieldError> {
        let mut levels = vec![Level::of_blocks(heights)?];
        while let Some(last) = levels.last().filter(|level| level.size != [1, 1]) {
            levels.push(last.above());
        }
        Ok(levels)
    }

    /// Reads all heights; the block rows are processed in parallel.
    fn of_blocks(heights: &impl Heights) -> Result<Level, HeightFieldError> {
        struct Row<'a> {
            spans: &'a mut [[f32; 2]],
            hole: Option<HeightFieldError>,
        }
        let samples = heights.size();
        let size = samples.map(|side| (side - 1).div_ceil(BLOCK));
        let mut spans = vec![NO_SPAN; size[0] as usize * size[1] as usize];
        let rows = spans.chunks_mut(size[0] as usize);
        let mut rows: Vec<Row> = rows.map(|spans| Row { spans, hole: None }).collect();
        threads::for_each(&mut rows, |number, row| {
            let mut line = vec![0.0; samples[0] as usize];
            let first = number as u32 * BLOCK;
            for at in first..(first + BLOCK + 1).min(samples[1]) {
                heights.read(0, at, &mut line);
                if let Some(column) = line.iter().position(|&height| !is_in_range(height)) {
                    row.hole = Some(bad_height(column as u32, at, line[column]));
                    return;
                }
                for (block, span) in row.spans.iter_mut().enumerate() {
                    let first = block * BLOCK as usize;
                    let end = (first + BLOCK as usize + 1).min(line.len());
                    *span = spanned(*span, &line[first..end]);
                }
            }
        });
        match rows.into_iter().find_map(|row| row.hole) {
            Some(hole) => Err(hole),
            None => Ok(Level { size, spans }),
        }
    }

    fn above(&self) -> Level {
        let size = self.size.map(|side| side.div_ceil(2));
        let mut spans = vec![NO_SPAN; size[0] as usize * size[1] as usize];
        for (place, below) in (0..).zip(&self.spans) {
            let [column, row] = [place % self.size[0] / 2, place / self.size[0] / 2];
            let span = &mut spans[(row * size[0] + column) as usize];
            *span = spanned(*span, below);
        }
        Level { size, spans }
    }

    pub(super) fn span(&self, [column, row]: [u32; 2]) -> [f32; 2] {
        self.spans[row as usize * self.size[0] as usize + column as usize]
    }

    pub(super) fn bytes(&self) -> u64 {
        size_of_val(&*self.spans) as u64
    }
}
