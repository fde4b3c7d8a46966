//! A random number generator with the same output on every platform.

use glam::DVec3;

/// SplitMix64 (Steele, Lea, Flood. Fast Splittable Pseudorandom Number Generators. OOPSLA 2014).
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    /// Creates a stream. Different seeds give independent streams, even consecutive ones.
    pub(crate) fn new(seed: u64) -> Random {
        let mut random = Random(seed.wrapping_mul(0xd134_2543_de82_ef95));
        random.bits();
        random
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// Returns a number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns an index in 0..`count`; `count` is at least 1.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }

    /// Returns a random point inside a convex polygon, never on an edge. Points near corners are as likely as points
    /// near the middle.
    pub(crate) fn point_in(&mut self, corners: &[DVec3]) -> DVec3 {
        let mut sum = DVec3::ZERO;
        let mut total = 0.0;
        for &corner in corners {
            let weight = (self.unit() + 1e-3).powi(3);
            sum += corner * weight;
            total += weight;
        }
        sum / total
    }
}
