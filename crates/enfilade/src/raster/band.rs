//! Rasterizer output: runs of covered samples in a band of eight rows.

use super::half_plane::HalfPlane;
use crate::view::aperture::Rect;
use fearless_simd::f64x8;
use fearless_simd::prelude::*;

/// Rows per band; a band starts at a multiple of eight.
pub(crate) const BAND: usize = 8;

/// Up to this number of rows, testing each sample is cheaper than computing where an edge crosses each scanline.
const FEW_ROWS: u16 = 4;

/// Runs of samples in up to eight rows, starting at row `y`, a multiple of eight.
pub(crate) struct Band {
    pub(crate) y: u16,
    /// First column and end column (exclusive) of each row; equal for a row without samples.
    pub(crate) runs: [[u16; 2]; BAND],
}

impl Band {
    /// Returns the samples of `rect` inside all half-planes, in the band that starts at row `y`, and their number;
    /// `None` if there are none.
    #[inline(always)]
    pub(crate) fn inside<S: Simd>(simd: S, y: u16, rect: &Rect, planes: &[HalfPlane]) -> Option<(Band, u64)> {
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

    /// Computes [`Band::inside`] by the cheaper of two equivalent algorithms.
    #[inline(always)]
    pub(crate) fn of<S: Simd>(simd: S, y: u16, rect: &Rect, planes: &[HalfPlane]) -> Option<(Band, u64)> {
        let rows = [rect.y0.max(y), rect.y1.min(y + BAND as u16)];
        let is_small = rect.x1 - rect.x0 <= BAND as u16 && rows[1] - rows[0] <= FEW_ROWS;
        if is_small && planes.iter().all(HalfPlane::is_plain) {
            Band::of_few(simd, y, rect, rows, planes)
        } else {
            Band::inside(simd, y, rect, planes)
        }
    }

    /// Computes [`Band::inside`] for up to eight columns by testing each sample, eight at a time. Along a scanline, the
    /// samples inside a plain half-plane are the first or the last ones, so their intersection is one run.
    #[inline(always)]
    fn of_few<S: Simd>(
        simd: S,
        y: u16,
        rect: &Rect,
        rows: [u16; 2],
        planes: &[HalfPlane],
    ) -> Option<(Band, u64)> {
        const COLUMNS: [f64; BAND] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let columns = f64x8::from_slice(simd, &COLUMNS) + (f64::from(rect.x0) + 0.5);
        let all = (1_u64 << (rect.x1 - rect.x0)) - 1;
        let mut held = [all; FEW_ROWS as usize];
        for plane in planes {
            let across = plane.across(columns);
            for (row, held) in (rows[0]..rows[1]).zip(&mut held) {
                *held &= plane
                    .holds_across(simd, across, f64::from(row) + 0.5)
                    .to_bitmask();
            }
        }
        let mut runs = [[0; 2]; BAND];
        let mut samples = 0;
        for (row, held) in (rows[0]..rows[1]).zip(held) {
            if held != 0 {
                let x0 = rect.x0 + held.trailing_zeros() as u16;
                let count = held.count_ones();
                samples += u64::from(count);
                runs[usize::from(row - y)] = [x0, x0 + count as u16];
            }
        }
        (samples > 0).then_some((Band { y, runs }, samples))
    }

    /// Returns the non-empty rows with their runs.
    #[inline(always)]
    pub(crate) fn rows(&self) -> impl Iterator<Item = (u16, [u16; 2])> + '_ {
        (self.y..).zip(self.runs).filter(|(_, [x0, x1])| x0 < x1)
    }
}
