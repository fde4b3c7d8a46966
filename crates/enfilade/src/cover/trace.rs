//! Work counters of a cover, sample by sample, for debug pictures.

use crate::view::aperture::Rect;
use crate::view::canvas::Canvas;

/// Number of depth tests of each sample, and the batch that its owner came with.
#[derive(Default)]
pub(super) struct Trace {
    width: usize,
    /// Number of the current batch, counted from 1.
    pub(super) batch: u32,
    tested: Vec<u16>,
    batches: Vec<u32>,
}

impl Trace {
    /// Creates counters for a rectangle, all zero.
    pub(super) fn new(rect: &Rect) -> Trace {
        let samples = usize::from(rect.x1) * usize::from(rect.y1);
        Trace {
            width: usize::from(rect.x1),
            batch: 0,
            tested: vec![0; samples],
            batches: vec![0; samples],
        }
    }

    /// Counts a depth test at samples `x0..x1` of row `y`.
    pub(super) fn test(&mut self, y: u16, x0: u16, x1: u16) {
        let start = usize::from(y) * self.width;
        for tested in &mut self.tested[start + usize::from(x0)..start + usize::from(x1)] {
            *tested = tested.saturating_add(1);
        }
    }

    /// Records that the owner of samples `x0..x1` of row `y` came with this batch.
    pub(super) fn own(&mut self, y: u16, x0: u16, x1: u16, batch: u32) {
        let start = usize::from(y) * self.width;
        self.batches[start + usize::from(x0)..start + usize::from(x1)].fill(batch);
    }

    /// Emits the counters of row `y` of a rectangle to a canvas.
    pub(super) fn emit_row(&self, y: u16, rect: &Rect, canvas: &mut dyn Canvas) {
        let start = usize::from(y) * self.width;
        let run = start + usize::from(rect.x0)..start + usize::from(rect.x1);
        canvas.work(y, rect.x0, &self.tested[run.clone()], &self.batches[run]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::PassageId;
    use crate::view::canvas::Span;
    use crate::view::passage::Passage;

    #[derive(Default)]
    struct Rows(Vec<(u16, u16, Vec<u16>, Vec<u32>)>);

    impl Canvas for Rows {
        fn enter(&mut self, _id: PassageId, _passage: &Passage) {}

        fn row(&mut self, _y: u16, _spans: &[Span]) {}

        fn work(&mut self, y: u16, x0: u16, tested: &[u16], batch: &[u32]) {
            self.0.push((y, x0, tested.to_vec(), batch.to_vec()));
        }
    }

    #[test]
    fn each_row_tells_what_was_done_in_it() {
        let rect = Rect {
            x0: 1,
            y0: 0,
            x1: 4,
            y1: 3,
        };
        let mut trace = Trace::new(&rect);
        trace.test(1, 1, 3);
        trace.test(1, 2, 4);
        trace.own(1, 2, 3, 7);
        trace.test(2, 3, 4);
        let mut rows = Rows::default();
        for y in 0..3 {
            trace.emit_row(y, &rect, &mut rows);
        }
        let expected = [
            (0, 1, vec![0, 0, 0], vec![0, 0, 0]),
            (1, 1, vec![1, 2, 1], vec![0, 7, 0]),
            (2, 1, vec![0, 0, 1], vec![0, 0, 0]),
        ];
        assert_eq!(rows.0, expected);
    }
}
