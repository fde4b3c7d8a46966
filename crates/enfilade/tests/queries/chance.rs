//! Numbers by chance, the same every time. Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators, 2014.

use enfilade::Aabb;

pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// From 0 to just below 1.
    pub(crate) fn part(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1_u64 << 24) as f32
    }

    /// From 0 to `end` - 1.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    /// From -1 to 1 on each axis.
    pub(crate) fn vector(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| 2.0 * self.part() - 1.0)
    }

    /// In a box, or a little outside.
    pub(crate) fn about(&mut self, bounds: &Aabb) -> [f32; 3] {
        let (size, center) = (bounds.size(), bounds.center());
        let off = self.vector();
        std::array::from_fn(|axis| center[axis] + 0.6 * size[axis] * off[axis])
    }

    /// A length: small ones as often as large ones, up to `most`.
    pub(crate) fn length(&mut self, most: f32) -> f32 {
        most * 10.0_f32.powf(-4.0 * self.part())
    }
}
