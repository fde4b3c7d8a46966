//! Support for tests: random numbers, and all SIMD levels of this machine.

use fearless_simd::Level;
use glam::DVec3;

/// A pseudo-random number generator; the same seed gives the same numbers.
pub(crate) struct Dice(fastrand::Rng);

impl Dice {
    pub(crate) fn new(seed: u64) -> Dice {
        Dice(fastrand::Rng::with_seed(seed))
    }

    /// Returns a number in [0, 1).
    pub(crate) fn roll(&mut self) -> f64 {
        self.0.f64()
    }

    /// Returns an index below `end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        self.0.usize(..end)
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll()
    }

    /// Returns a number from −`most` to `most`.
    pub(crate) fn within(&mut self, most: f64) -> f64 {
        self.between(-most, most)
    }

    /// As [`Dice::within`], but sometimes NaN, infinite, zero or huge.
    pub(crate) fn odd(&mut self, most: f64) -> f64 {
        match self.below(80) {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            3 => 0.0,
            4 => 1e300,
            _ => self.within(most),
        }
    }

    /// Returns a number from `low` to `high`, uniform on a logarithmic scale.
    pub(crate) fn by_ratio(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.roll())
    }

    /// Returns a point whose coordinates are from −`reach` to `reach`.
    pub(crate) fn point(&mut self, reach: f64) -> DVec3 {
        DVec3::from([(); 3].map(|()| self.within(reach)))
    }

    pub(crate) fn direction(&mut self) -> DVec3 {
        self.point(1.0).normalize_or(DVec3::X)
    }
}

/// Returns all SIMD levels of this machine.
pub(crate) fn levels() -> Vec<Level> {
    let best = Level::new();
    let mut levels = vec![best, Level::baseline()];
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_sse4_2().map(Level::Sse4_2));
        levels.extend(best.as_avx2().map(Level::Avx2));
    }
    levels
}
