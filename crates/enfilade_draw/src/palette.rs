//! Colour conversion (sRGB and linear) and diagnostic palettes.

use std::sync::LazyLock;

/// sRGB byte of each linear value in steps of 1/65535.
static ENCODED: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let encode = |step: u16| {
        let linear = f64::from(step) / 65535.0;
        let srgb = if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        };
        (255.0 * srgb + 0.5) as u8
    };
    (0..=u16::MAX).map(encode).collect()
});

/// Returns the table of sRGB bytes for 65,536 linear values, for loops over many pixels.
pub(crate) fn encoded() -> &'static [u8] {
    &ENCODED
}

/// Linear value of each sRGB byte, 0 to 1.
static DECODED: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let srgb = byte as f64 / 255.0;
        let linear = if srgb <= 0.040_45 {
            srgb / 12.92
        } else {
            ((srgb + 0.055) / 1.055).powf(2.4)
        };
        linear as f32
    })
});

/// Returns the table of linear values of sRGB bytes, for loops over many texels.
pub(crate) fn decoded() -> &'static [f32; 256] {
    &DECODED
}

/// Encodes linear RGB as sRGB bytes (IEC 61966-2-1), clamped to 0 to 1.
pub(crate) fn encode(linear: [f32; 3]) -> [u8; 3] {
    linear.map(|value| ENCODED[(value.clamp(0.0, 1.0) * 65535.0 + 0.5) as usize])
}

/// Returns a colour for an index. Consecutive indices differ in hue by the golden angle, so that few look alike.
pub(crate) fn distinct(number: u64) -> [f32; 3] {
    let mixed = number.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let hue = (mixed >> 40) as f32 / (1_u32 << 24) as f32;
    let light = 0.35 + 0.5 * (mixed >> 16 & 0xFF) as f32 / 255.0;
    let wave = |shift: f32| {
        let at = (hue + shift).fract() * 6.0 - 3.0;
        (at.abs() - 1.0).clamp(0.0, 1.0)
    };
    [0.0, 2.0 / 3.0, 1.0 / 3.0].map(|shift| light * (0.25 + 0.75 * wave(shift)))
}

/// Returns a colour from blue through green and yellow to red, for `part` from 0 to 1.
pub(crate) fn rainbow(part: f32) -> [f32; 3] {
    along(
        &[
            [0.05, 0.1, 0.7],
            [0.0, 0.6, 0.7],
            [0.1, 0.7, 0.1],
            [0.9, 0.8, 0.05],
            [0.8, 0.05, 0.03],
        ],
        part,
    )
}

/// Returns a colour from black through blue, green and yellow to white, for `part` from 0 to 1.
pub(crate) fn heat(part: f32) -> [f32; 3] {
    along(
        &[
            [0.0; 3],
            [0.05, 0.05, 0.5],
            [0.05, 0.5, 0.25],
            [0.9, 0.7, 0.05],
            [1.0; 3],
        ],
        part,
    )
}

/// Returns a colour from night blue through violet and copper to cream, for `part` from 0 to 1.
pub(crate) fn dusk(part: f32) -> [f32; 3] {
    along(
        &[
            [0.006, 0.010, 0.045],
            [0.045, 0.040, 0.16],
            [0.22, 0.09, 0.20],
            [0.62, 0.27, 0.16],
            [0.95, 0.72, 0.42],
        ],
        part,
    )
}

fn along(stops: &[[f32; 3]], part: f32) -> [f32; 3] {
    let at = part.clamp(0.0, 1.0) * (stops.len() - 1) as f32;
    let first = (at as usize).min(stops.len() - 2);
    let between = at - first as f32;
    std::array::from_fn(|i| stops[first][i] * (1.0 - between) + stops[first + 1][i] * between)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_the_way_to_linear_light_and_back() {
        for byte in 0..=255 {
            assert_eq!(encode([decoded()[usize::from(byte)]; 3]), [byte; 3]);
        }
    }

    #[test]
    fn neighbouring_numbers_have_different_colours() {
        for number in 0..1000 {
            assert_ne!(encode(distinct(number)), encode(distinct(number + 1)));
        }
    }
}
