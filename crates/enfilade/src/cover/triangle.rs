//! A triangle on the screen, and how near it is along a row.

use crate::aperture::Rect;
use glam::DVec3;
use std::cmp::Ordering;

/// A triangle whose samples are being handed out.
#[derive(Clone, Copy)]
#[repr(C)]
pub(crate) struct Triangle {
    /// Reversed depth at a sample is `rev_depth · (x + ½, y + ½, 1)`, kept within `least` and `greatest`.
    pub(super) least: f64,
    pub(super) greatest: f64,
    /// The number of its face.
    pub(super) owner: u32,
    pub(super) rev_depth: DVec3,
}

/// Reversed depth along one row.
#[derive(Clone, Copy)]
pub(crate) struct Row {
    base: f64,
    step: f64,
    least: f64,
    greatest: f64,
}

impl Triangle {
    /// As near everywhere.
    #[inline(always)]
    pub(super) fn flat(rev_depth: f32) -> Triangle {
        let rev_depth = f64::from(rev_depth);
        Triangle {
            owner: 0,
            rev_depth: DVec3::new(0.0, 0.0, rev_depth),
            least: rev_depth,
            greatest: rev_depth,
        }
    }

    /// Bits of the greatest reversed depth of any sample.
    #[inline(always)]
    pub(super) fn nearest(&self) -> u32 {
        (self.greatest as f32).to_bits()
    }

    /// Reversed depth along row `y`.
    #[inline(always)]
    pub(super) fn row(&self, y: u16) -> Row {
        Row {
            base: self.rev_depth.y * (f64::from(y) + 0.5) + (self.rev_depth.x * 0.5 + self.rev_depth.z),
            step: self.rev_depth.x,
            least: self.least,
            greatest: self.greatest,
        }
    }
}

impl Triangle {
    /// Is it nearer (`Greater`) or farther (`Less`) than another at every sample of `rect`, where both are there, by
    /// more than samples are rounded by? `None` where neither is certain.
    #[inline(always)]
    pub(super) fn beside(&self, other: &Triangle, rect: &Rect) -> Option<Ordering> {
        const ROUNDING: f64 = 1.0 / (1_u64 << 20) as f64;
        let [mut nearer, mut farther] = [true, true];
        // Both are linear, and so is their difference: what holds at the corners holds between them.
        for y in [rect.y0, rect.y1 - 1] {
            let [mine, theirs] = [self.row(y), other.row(y)];
            for x in [rect.x0, rect.x1 - 1] {
                let x = f64::from(x);
                let [mine, theirs] = [mine.base + mine.step * x, theirs.base + theirs.step * x];
                nearer &= mine > theirs * (1.0 + ROUNDING);
                farther &= mine < theirs * (1.0 - ROUNDING);
            }
        }
        match (nearer, farther) {
            (true, false) => Some(Ordering::Greater),
            (false, true) => Some(Ordering::Less),
            _ => None,
        }
    }
}

impl Row {
    /// Reversed depth at column `x`.
    #[inline(always)]
    pub(super) fn at(&self, x: u16) -> f64 {
        self.within(self.base + self.step * f64::from(x))
    }

    /// The plane's reversed depth at column `x`, also where the triangle is not.
    #[inline(always)]
    pub(super) fn beyond(&self, x: u16) -> f64 {
        self.base + self.step * f64::from(x)
    }

    /// Reversed depth at column `x`, as bits: those of a positive f32 sort as it does.
    #[inline(always)]
    pub(super) fn bits(&self, x: i32) -> u32 {
        (self.within(self.base + self.step * f64::from(x)) as f32).to_bits()
    }

    /// The same at eight columns, from `x` on.
    #[inline(always)]
    pub(super) fn eight_bits(&self, x: u16) -> [u32; 8] {
        const COLUMNS: [f64; 8] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let mut bits = [0; 8];
        for (bits, column) in bits.iter_mut().zip(COLUMNS) {
            *bits = (self.within(self.base + self.step * (f64::from(x) + column)) as f32).to_bits();
        }
        bits
    }

    /// Unlike `clamp`, nothing here can panic.
    #[inline(always)]
    fn within(&self, rev_depth: f64) -> f64 {
        let rev_depth = if rev_depth < self.least {
            self.least
        } else {
            rev_depth
        };
        if rev_depth > self.greatest {
            self.greatest
        } else {
            rev_depth
        }
    }
}
