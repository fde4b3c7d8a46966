//! Random positions and lengths.

use enfilade::Aabb;
use enfilade_scenes::Random;

/// Returns a position in a box, or slightly outside.
pub(crate) fn about(random: &mut Random, bounds: &Aabb) -> [f32; 3] {
    let (size, center) = (bounds.size(), bounds.center());
    let off = random.point(1.0);
    std::array::from_fn(|axis| center[axis] + 0.6 * size[axis] * off[axis])
}

/// Returns a length up to `most`; small ones are as frequent as large ones.
pub(crate) fn length(random: &mut Random, most: f32) -> f32 {
    most * 10.0_f32.powf(-4.0 * random.unit())
}
