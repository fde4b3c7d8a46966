//! Reports the owners of the tiles' samples.

use super::{State, TILE, TILE_SHIFT, Tiles};
use crate::aperture::Rect;
use crate::cover::report::Report;
use crate::cover::samples::{OPEN, lower_half};
use fearless_simd::dispatch;

impl Tiles {
    /// Reports all owners: tile by tile, or row by row if the report needs runs.
    pub(in crate::cover) fn report(&self, report: &mut Report) {
        if report.wants_rows() {
            self.report_rows(report);
        } else {
            dispatch!(self.level, _simd => self.report_tiles(report));
        }
    }

    #[inline(always)]
    fn report_tiles(&self, report: &mut Report) {
        let Rect { x0, y0, x1, y1 } = self.rect;
        for row in usize::from(y0) >> TILE_SHIFT..usize::from(y1).div_ceil(TILE) {
            for column in usize::from(x0) >> TILE_SHIFT..usize::from(x1).div_ceil(TILE) {
                let index = self.index(column, row);
                match self.tiles[index].state {
                    State::Empty => {}
                    State::Whole(number) => {
                        let Rect { x0, y0, x1, y1 } = self.rect(column, row);
                        let samples = u64::from(x1 - x0) * u64::from(y1 - y0);
                        report.some(lower_half(self.triangles[number as usize].owner), samples);
                    }
                    State::Written => {
                        for samples in &self.blocks[index].0 {
                            report.eight(samples);
                        }
                    }
                }
            }
        }
    }

    fn report_rows(&self, report: &mut Report) {
        let Rect { x0, y0, x1, y1 } = self.rect;
        for y in y0..y1 {
            let row = usize::from(y) >> TILE_SHIFT;
            for column in usize::from(x0) >> TILE_SHIFT..usize::from(x1).div_ceil(TILE) {
                let Rect { x0, x1, .. } = self.rect(column, row);
                let index = self.index(column, row);
                match self.tiles[index].state {
                    State::Empty => report.run(x0, x1, OPEN as u32),
                    State::Whole(number) => {
                        report.run(x0, x1, lower_half(self.triangles[number as usize].owner));
                    }
                    State::Written => {
                        let samples = &self.blocks[index].0[usize::from(y) % TILE];
                        let first = usize::from(x0) % TILE;
                        report.samples(x0, &samples[first..first + usize::from(x1 - x0)]);
                    }
                }
            }
            report.end_row(y, &self.rect, self.trace.as_ref());
        }
    }
}
