//! The depth plane of a triangle on the screen, and its values along a scanline.

use crate::view::aperture::Rect;
use glam::DVec3;
use std::cmp::Ordering;

/// A triangle that is being rasterized.
#[derive(Clone, Copy)]
#[repr(C)]
pub(crate) struct Triangle {
    /// Reversed depth at the sample in column x, row y is `rev_depth · (x + ½, y + ½, 1)`, clamped to
    /// `least..=greatest`.
    pub(crate) least: f64,
    pub(crate) greatest: f64,
    /// Number of its face.
    pub(crate) owner: u32,
    pub(crate) rev_depth: DVec3,
}

/// Reversed depth along one scanline.
#[derive(Clone, Copy)]
pub(crate) struct Row {
    base: f64,
    step: f64,
    least: f64,
    greatest: f64,
}

impl Triangle {
    /// Returns a triangle of constant reversed depth, parallel to the screen.
    #[inline(always)]
    pub(crate) fn flat(rev_depth: f32) -> Triangle {
        let rev_depth = f64::from(rev_depth);
        Triangle {
            owner: 0,
            rev_depth: DVec3::new(0.0, 0.0, rev_depth),
            least: rev_depth,
            greatest: rev_depth,
        }
    }

    /// Returns the bits of the largest reversed depth of any sample.
    #[inline(always)]
    pub(crate) fn nearest(&self) -> u32 {
        (self.greatest as f32).to_bits()
    }

    /// Returns the reversed depth along row `y`.
    #[inline(always)]
    pub(crate) fn row(&self, y: u16) -> Row {
        Row {
            base: self.rev_depth.y * (f64::from(y) + 0.5) + (self.rev_depth.x * 0.5 + self.rev_depth.z),
            step: self.rev_depth.x,
            least: self.least,
            greatest: self.greatest,
        }
    }
}

impl Triangle {
    /// Compares the depth with that of another triangle over all samples of `rect`, assuming that both cover it:
    /// `Greater` if this one is nearer everywhere, `Less` if it is farther everywhere, by more than the rounding of
    /// samples. `None` if neither is certain.
    #[inline(always)]
    pub(crate) fn compare_depth(&self, other: &Triangle, rect: &Rect) -> Option<Ordering> {
        const ROUNDING: f64 = 1.0 / (1_u64 << 20) as f64;
        let [mut nearer, mut farther] = [true, true];
        // Both depths are linear, and so is their difference: a comparison that holds at the corners holds everywhere
        // in the rectangle.
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
    /// Returns the reversed depth at column `x`.
    #[inline(always)]
    pub(crate) fn at(&self, x: u16) -> f64 {
        self.within(self.base + self.step * f64::from(x))
    }

    /// Returns the plane's reversed depth at column `x` without clamping, so also outside the triangle.
    #[inline(always)]
    pub(crate) fn beyond(&self, x: u16) -> f64 {
        self.base + self.step * f64::from(x)
    }

    /// Returns the reversed depth at column `x` as the bits of an f32. The bits of positive floats sort like the
    /// floats.
    #[inline(always)]
    pub(crate) fn bits(&self, x: i32) -> u32 {
        (self.within(self.base + self.step * f64::from(x)) as f32).to_bits()
    }

    /// Returns the bits of the reversed depth at eight columns, starting at `x`.
    #[inline(always)]
    pub(crate) fn eight_bits(&self, x: u16) -> [u32; 8] {
        const COLUMNS: [f64; 8] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let mut bits = [0; 8];
        for (bits, column) in bits.iter_mut().zip(COLUMNS) {
            *bits = (self.within(self.base + self.step * (f64::from(x) + column)) as f32).to_bits();
        }
        bits
    }

    /// Clamps to `least..=greatest`. Unlike `f64::clamp`, it cannot panic.
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
