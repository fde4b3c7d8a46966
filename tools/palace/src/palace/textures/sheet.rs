//! A texture under construction.

use enfilade::{Texture, Wrap};
use glam::{Vec2, Vec3, vec2};
use std::sync::{Arc, LazyLock};

/// sRGB bytes of linear values, in steps fine enough for every dark byte.
static ENCODED: LazyLock<Vec<u8>> = LazyLock::new(|| {
    const STEPS: usize = 8192;
    let encode = |linear: f32| {
        if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        }
    };
    (0..=STEPS)
        .map(|i| (255.0 * encode(i as f32 / STEPS as f32) + 0.5) as u8)
        .collect()
});

/// Generates a texture: `color` is called for the centre of each texel, from 0 to 1 across and down, and returns linear
/// red, green, blue and coverage.
pub(super) fn painted(
    name: &str,
    [wide, high]: [u32; 2],
    wrap: [Wrap; 2],
    color: impl Fn(Vec2) -> (Vec3, f32),
) -> Arc<Texture> {
    let encoded = &*ENCODED;
    let byte = |linear: f32| encoded[(linear.clamp(0.0, 1.0) * (encoded.len() - 1) as f32) as usize];
    let texels = (0..high)
        .flat_map(|y| (0..wide).map(move |x| vec2(x as f32 + 0.5, y as f32 + 0.5)))
        .map(|at| {
            let (color, coverage) = color(at / vec2(wide as f32, high as f32));
            let [r, g, b] = color.to_array().map(byte);
            [r, g, b, (255.0 * coverage.clamp(0.0, 1.0) + 0.5) as u8]
        })
        .collect();
    let mut texture = Texture::new(name, [wide, high], texels).expect("as many texels as it has room for");
    texture.wrap = wrap;
    Arc::new(texture)
}

/// Generates a repeating opaque texture.
pub(super) fn tile(name: &str, side: u32, color: impl Fn(Vec2) -> Vec3) -> Arc<Texture> {
    painted(name, [side; 2], [Wrap::Repeat; 2], |at| (color(at), 1.0))
}
