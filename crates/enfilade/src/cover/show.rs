//! Emits the contents of a cover to a canvas, row by row inside the aperture.

use crate::view::aperture::Rect;
use crate::view::canvas::{Canvas, CoverSpan};
use crate::view::passage::Passage;

/// Emits the rows of a passage to a canvas; `run` appends the spans of row `y` in the open columns `run[0]..run[1]`.
///
/// Allocates; a look never calls this function.
pub(super) fn show_rows(
    passage: &Passage,
    canvas: &mut dyn Canvas,
    mut run: impl FnMut(u16, [u16; 2], &mut Vec<CoverSpan>),
) {
    let Rect { y0, y1, .. } = passage.aperture.rect();
    let (mut open, mut spans) = (Vec::new(), Vec::new());
    for y in y0..y1 {
        passage.aperture.open_in_row(y, &mut open);
        spans.clear();
        for &columns in &open {
            run(y, columns, &mut spans);
        }
        canvas.cover(y, &spans);
    }
}

/// Appends a span, or extends the last one if it is of the same cell and hidden by the same occluder.
pub(super) fn push(spans: &mut Vec<CoverSpan>, span: CoverSpan) {
    match spans.last_mut() {
        Some(last) if last.x1 == span.x0 && (last.cell, last.by) == (span.cell, span.by) => {
            last.x1 = span.x1;
            last.rev_depth[1] = span.rev_depth[1];
        }
        _ => spans.push(span),
    }
}
