//! Draws the spans, each of which has one owner.

use super::SpanBuffer;
use super::rows::COVERED;
use crate::cover::show::show_rows;
use crate::view::canvas::{Canvas, CoverSpan, HiddenBy};
use crate::view::passage::Passage;

impl SpanBuffer {
    pub(super) fn show_spans(&self, passage: &Passage, canvas: &mut dyn Canvas) {
        show_rows(passage, canvas, |y, [x0, x1], shown| {
            let mut x = x0;
            let open = |x0, x1| CoverSpan {
                x0,
                x1,
                cell: 0,
                by: HiddenBy::Nothing,
                rev_depth: [0.0; 2],
            };
            let spans = self.rows.rows[usize::from(y)].spans.iter();
            for span in spans.filter(|span| span.face != COVERED && span.x0 < x1 && x0 < span.x1) {
                if x < span.x0 {
                    shown.push(open(x, span.x0));
                }
                let face = &self.kept[span.face as usize].triangle;
                let row = face.row(y);
                shown.push(CoverSpan {
                    x0: span.x0,
                    x1: span.x1,
                    cell: face.owner + 1,
                    by: HiddenBy::One(face.owner),
                    rev_depth: [span.x0, span.x1 - 1].map(|x| row.at(x) as f32),
                });
                x = span.x1;
            }
            if x < x1 {
                shown.push(open(x, x1));
            }
        });
    }
}
