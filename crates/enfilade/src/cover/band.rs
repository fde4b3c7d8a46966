//! Runs of samples in eight rows.

use super::half_plane::HalfPlane;
use crate::aperture::Rect;
use fearless_simd::f64x8;
use fearless_simd::prelude::*;

/// Rows are handed out by eights, from a multiple of eight.
pub(super) const BAND: usize = 8;

/// Runs of samples in up to eight rows, from row `y`, a multiple of eight.
pub(crate) struct Band {
    pub(super) y: u16,
    /// The first column and the one after the last, of each row; equal where it holds no sample.
    pub(super) runs: [[u16; 2]; BAND],
}

impl Band {
    /// The samples of `rect` that all planes hold, in the rows from `y` on, and how many these are; `None` where there
    /// are none.
    #[inline(always)]
    pub(super) fn held<S: Simd>(simd: S, y: u16, rect: &Rect, planes: &[HalfPlane]) -> Option<(Band, u64)> {
        const ROWS: [f64; BAND] = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];
        let rows = f64x8::from_slice(simd, &ROWS) + f64::from(y);
        let mut x0 = f64x8::splat(simd, f64::from(rect.x0));
        let mut x1 = f64x8::splat(simd, f64::from(rect.x1));
        let limits = [x0, x1];
        for plane in planes {
            plane.narrow(simd, rows, limits, &mut x0, &mut x1);
        }
        let [x0, x1]: [[f64; BAND]; 2] = [x0.into(), x1.into()];
        let mut runs = [[0; 2]; BAND];
        let mut samples = 0;
        for row in usize::from(rect.y0.saturating_sub(y))..usize::from(rect.y1 - y).min(BAND) {
            if x0[row] < x1[row] {
                samples += u64::from(x1[row] as u16 - x0[row] as u16);
                runs[row] = [x0[row] as u16, x1[row] as u16];
            }
        }
        (samples > 0).then_some((Band { y, runs }, samples))
    }

    /// The rows that hold a sample.
    #[inline(always)]
    pub(super) fn rows(&self) -> impl Iterator<Item = (u16, [u16; 2])> + '_ {
        (self.y..).zip(self.runs).filter(|(_, [x0, x1])| x0 < x1)
    }
}
