//! Visualizes a low-resolution cover at the resolution of the screen.

use crate::ids::PassageId;
use crate::view::canvas::{Canvas, CoverSpan, Span};
use crate::view::passage::Passage;

/// A canvas for cells of a low-resolution cover, which it maps to the samples of another canvas, clipped to the
/// aperture.
pub(super) struct CellUpscaler<'a> {
    canvas: &'a mut dyn Canvas,
    passage: &'a Passage,
    /// Cells per sample, by axis.
    scale: [f64; 2],
    spans: Vec<CoverSpan>,
    open: Vec<[u16; 2]>,
}

impl<'a> CellUpscaler<'a> {
    /// Creates a canvas for a passage at the resolution of the screen and a cover of `cells` [columns, rows].
    pub(super) fn new(canvas: &'a mut dyn Canvas, passage: &'a Passage, cells: [u32; 2]) -> CellUpscaler<'a> {
        CellUpscaler {
            canvas,
            scale: [0, 1].map(|axis| f64::from(cells[axis]) / f64::from(passage.size[axis])),
            passage,
            spans: Vec::new(),
            open: Vec::new(),
        }
    }

    /// Returns the first sample whose centre is not before the start of a cell.
    fn first(&self, cell: u16, axis: usize) -> u16 {
        (f64::from(cell) / self.scale[axis] - 0.5).ceil().max(0.0) as u16
    }
}

impl Canvas for CellUpscaler<'_> {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}

    fn row(&mut self, _y: u16, _spans: &[Span]) {}

    fn cover(&mut self, y: u16, spans: &[CoverSpan]) {
        for row in self.first(y, 1)..self.first(y + 1, 1) {
            self.spans.clear();
            self.passage.aperture.open_in_row(row, &mut self.open);
            for span in spans {
                let [x0, x1] = [self.first(span.x0, 0), self.first(span.x1, 0)];
                let within = self.open.iter().map(|open| [open[0].max(x0), open[1].min(x1)]);
                let seen = within.filter(|[x0, x1]| x0 < x1);
                self.spans
                    .extend(seen.map(|[x0, x1]| CoverSpan { x0, x1, ..*span }));
            }
            self.canvas.cover(row, &self.spans);
        }
    }
}
