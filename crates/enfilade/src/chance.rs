//! Support for SIMD tests: random numbers, and all SIMD levels of this machine.

use fearless_simd::Level;

/// A pseudo-random number generator; the same seed gives the same numbers.
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Dice {
        Dice(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Returns a number from −`most` to `most`.
    pub(crate) fn within(&mut self, most: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        most * ((self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    }

    /// As [`Dice::within`], but sometimes NaN, infinite, zero or huge.
    pub(crate) fn odd(&mut self, most: f64) -> f64 {
        match (self.within(1.0) * 40.0) as i32 {
            39 => f64::NAN,
            38 => f64::INFINITY,
            37 => f64::NEG_INFINITY,
            36 => 0.0,
            35 => 1e300,
            _ => self.within(most),
        }
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
