//! Places and lengths by chance.

use enfilade::Aabb;
use enfilade_scenes::Random;

/// In a box, or a little outside.
pub(crate) fn about(random: &mut Random, bounds: &Aabb) -> [f32; 3] {
    let (size, center) = (bounds.size(), bounds.center());
    let off = random.point(1.0);
    std::array::from_fn(|axis| center[axis] + 0.6 * size[axis] * off[axis])
}

/// A length: small ones as often as large ones, up to `most`.
pub(crate) fn length(random: &mut Random, most: f32) -> f32 {
    most * 10.0_f32.powf(-4.0 * random.unit())
}
