//! How a cover came to its answer, sample by sample: for pictures of the work.

use crate::aperture::Rect;
use crate::canvas::Canvas;

/// How often each sample was tested, and with which batch its owner came.
#[derive(Default)]
pub(super) struct Trace {
    width: usize,
    /// The batch at hand, counted from 1.
    pub(super) batch: u32,
    tested: Vec<u16>,
    batches: Vec<u32>,
}

impl Trace {
    /// Nothing was tested yet in a rectangle.
    pub(super) fn new(rect: &Rect) -> Trace {
        let samples = usize::from(rect.x1) * usize::from(rect.y1);
        Trace {
            width: usize::from(rect.x1),
            batch: 0,
            tested: vec![0; samples],
            batches: vec![0; samples],
        }
    }

    /// A face was tested at samples `x0..x1` of row `y`.
    pub(super) fn test(&mut self, y: u16, x0: u16, x1: u16) {
        let start = usize::from(y) * self.width;
        for tested in &mut self.tested[start + usize::from(x0)..start + usize::from(x1)] {
            *tested = tested.saturating_add(1);
        }
    }

    /// The owner of samples `x0..x1` of row `y` came with this batch.
    pub(super) fn own(&mut self, y: u16, x0: u16, x1: u16, batch: u32) {
        let start = usize::from(y) * self.width;
        self.batches[start + usize::from(x0)..start + usize::from(x1)].fill(batch);
    }

    /// Tells a canvas about row `y` of a rectangle.
    pub(super) fn tell(&self, y: u16, rect: &Rect, canvas: &mut dyn Canvas) {
        let start = usize::from(y) * self.width;
        let run = start + usize::from(rect.x0)..start + usize::from(rect.x1);
        canvas.work(y, rect.x0, &self.tested[run.clone()], &self.batches[run]);
    }
}
