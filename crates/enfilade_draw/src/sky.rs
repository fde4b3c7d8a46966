//! The sky behind all geometry.

use crate::pixels::{Pixel, pixel};
use enfilade::View;
use glam::{DVec3, Vec3};

/// View directions of samples, for the sky.
pub(crate) struct Sky {
    corner: DVec3,
    right: DVec3,
    down: DVec3,
}

impl Sky {
    pub(crate) fn new(view: &View) -> Sky {
        let [dx, dy] = [0, 1].map(|axis| f64::from(view.sample()[axis]) + View::GENERIC_OFFSET[axis]);
        let direction = |x: f64, y: f64| DVec3::from(view.ray([x + 0.5 + dx, y + 0.5 + dy])[1]);
        let corner = direction(0.0, 0.0);
        Sky {
            corner,
            right: direction(1.0, 0.0) - corner,
            down: direction(0.0, 1.0) - corner,
        }
    }

    /// Returns the linear colour of the sky at pixel (x, y).
    pub(crate) fn at(&self, at: [usize; 2]) -> Vec3 {
        color(self.up(at))
    }

    /// Fills pixels from (x, y) on with the colours of [`Sky::at`], in loops written for auto-vectorization.
    pub(crate) fn paint(&self, [x, y]: [usize; 2], pixels: &mut [Pixel]) {
        const LANES: usize = 16;
        for (x, pixels) in (x..).step_by(LANES).zip(pixels.chunks_mut(LANES)) {
            let mut ups = [0.0; LANES];
            for (lane, up) in ups.iter_mut().enumerate() {
                *up = self.up([x + lane, y]);
            }
            let mut colors = [Vec3::ZERO; LANES];
            for (color, up) in colors.iter_mut().zip(ups) {
                *color = self::color(up);
            }
            for (at, color) in pixels.iter_mut().zip(colors) {
                *at = pixel(color);
            }
        }
    }

    /// Returns the y component of the unit view direction at pixel (x, y).
    #[inline]
    fn up(&self, [x, y]: [usize; 2]) -> f32 {
        let direction = self.corner + self.right * x as f64 + self.down * y as f64;
        (direction.y / direction.length()) as f32
    }
}

/// Returns the sky's colour for the y component of a unit direction; for NaN, that of the horizon.
#[inline]
fn color(up: f32) -> Vec3 {
    const HORIZON: Vec3 = Vec3::new(0.78, 0.84, 0.90);
    const ABOVE: Vec3 = Vec3::new(0.18, 0.36, 0.68);
    const BELOW: Vec3 = Vec3::new(0.28, 0.27, 0.26);
    let [above, below] = [up.max(0.0).sqrt(), (-3.0 * up).clamp(0.0, 1.0)];
    HORIZON + (ABOVE - HORIZON) * above + (BELOW - HORIZON) * below
}
