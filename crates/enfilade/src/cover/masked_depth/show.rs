//! Draws the sub-tiles: which samples the reference layer hides and which the working layer.

use super::grid::Grid;
use super::tile::{ACROSS, COLUMNS, ROWS, SUB_COLUMNS, SUB_ROWS, SUB_TILES};
use crate::canvas::{Canvas, CoverSpan, HiddenBy};
use crate::cover::show::{push, show_rows};
use crate::passage::Passage;

impl Grid {
    pub(super) fn show(&self, passage: &Passage, canvas: &mut dyn Canvas) {
        show_rows(passage, canvas, |y, [x0, x1], spans| {
            let [row, y] = [usize::from(y) / ROWS, usize::from(y) % ROWS];
            for x in x0..x1 {
                let [column, within] = [usize::from(x) / COLUMNS, usize::from(x) % COLUMNS];
                let index = row * self.columns + column;
                let tile = &self.tiles[index];
                let sub = y / SUB_ROWS * ACROSS + within / SUB_COLUMNS;
                let rev_depth = tile.rev_depth_at(within, y);
                let by = if tile.is_working(within, y) {
                    HiddenBy::Working
                } else if rev_depth > 0.0 {
                    HiddenBy::Reference
                } else {
                    HiddenBy::Nothing
                };
                let cell = (index * SUB_TILES + sub) as u32;
                push(
                    spans,
                    CoverSpan {
                        x0: x,
                        x1: x + 1,
                        cell,
                        by,
                        rev_depth: [rev_depth; 2],
                    },
                );
            }
        });
    }
}
