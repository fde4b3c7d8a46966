//! Tileable noise, the base of clouds, grain and veins.
//!
//! Gradient noise on a lattice that repeats after a whole number of cells.
//! Source: Perlin, Improving noise, 2002. Cost: O(1) each.

use glam::{Vec2, vec2};

/// Returns a hash of a cell as a number from 0 to 1.
pub(super) fn random_unit(cell: [i32; 2], seed: u32) -> f32 {
    scrambled(cell, seed) as f32 / (u32::MAX as f32 + 1.0)
}

fn scrambled([x, y]: [i32; 2], seed: u32) -> u32 {
    let mut bits = (x as u32)
        .wrapping_mul(0x9E37_79B1)
        .wrapping_add((y as u32).wrapping_mul(0x85EB_CA77))
        .wrapping_add(seed.wrapping_mul(0xC2B2_AE3D));
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x2C1B_3C6D);
    bits = (bits ^ (bits >> 12)).wrapping_mul(0x297A_2D39);
    bits ^ (bits >> 15)
}

/// Gradients at the lattice points.
const SLOPES: [[f32; 2]; 8] = {
    const D: f32 = std::f32::consts::FRAC_1_SQRT_2;
    [
        [1.0, 0.0],
        [-1.0, 0.0],
        [0.0, 1.0],
        [0.0, -1.0],
        [D, D],
        [D, -D],
        [-D, D],
        [-D, -D],
    ]
};

/// Returns noise from about −1 to 1, mostly near 0; `at` is in cells and repeats after `period` of them.
pub(super) fn noise(at: Vec2, period: [i32; 2], seed: u32) -> f32 {
    let [x, y] = [floor(at.x), floor(at.y)];
    let off = vec2(at.x - x as f32, at.y - y as f32);
    let [xs, ys] = [
        [wrapped(x, period[0]), wrapped(x + 1, period[0])],
        [wrapped(y, period[1]), wrapped(y + 1, period[1])],
    ];
    let slope = |right: usize, down: usize| {
        let [dx, dy] = SLOPES[(scrambled([xs[right], ys[down]], seed) >> 29) as usize];
        dx * (off.x - right as f32) + dy * (off.y - down as f32)
    };
    let ease = off * off * off * (off * (off * 6.0 - 15.0) + 10.0);
    let mix = |a: f32, b: f32, part: f32| a + (b - a) * part;
    let near = mix(slope(0, 0), slope(1, 0), ease.x);
    let far = mix(slope(0, 1), slope(1, 1), ease.x);
    1.6 * mix(near, far, ease.y)
}

/// Returns the floor, without the library call that `f32::floor` compiles to on older processors.
#[inline]
fn floor(value: f32) -> i32 {
    let whole = value as i32;
    whole - i32::from(whole as f32 > value)
}

/// Wraps a cell into the first period. Most cells are in it or adjacent to it, where no division is needed.
#[inline]
fn wrapped(cell: i32, period: i32) -> i32 {
    if (0..period).contains(&cell) {
        cell
    } else if cell == period {
        0
    } else {
        cell.rem_euclid(period)
    }
}

/// Returns fractal noise; `at` runs from 0 to 1 over the whole, which has `cells` cells at the coarsest octave.
pub(super) fn clouds(at: Vec2, cells: [i32; 2], octaves: u32, seed: u32) -> f32 {
    let mut sum = 0.0;
    let mut size = 1.0;
    let mut period = cells;
    for octave in 0..octaves {
        let scaled = at * vec2(period[0] as f32, period[1] as f32);
        sum += size * noise(scaled, period, seed + octave);
        size *= 0.5;
        period = period.map(|cells| 2 * cells);
    }
    sum
}

/// Displaces a point by noise (domain warping); it repeats as the point does.
pub(super) fn bent(at: Vec2, seed: u32) -> Vec2 {
    at + 0.09 * vec2(clouds(at, [3, 3], 4, seed), clouds(at, [3, 3], 4, seed + 10))
}

/// Returns 1 along thin wandering lines like veins, falling to 0 beside them.
pub(super) fn veins(at: Vec2, cells: [i32; 2], sharpness: f32, seed: u32) -> f32 {
    let line = clouds(at, cells, 2, seed).abs();
    (1.0 - sharpness * line).max(0.0).powi(2)
}

/// Smoothstep: 0 up to `from`, 1 from `to` on.
pub(super) fn step(from: f32, to: f32, value: f32) -> f32 {
    let part = ((value - from) / (to - from)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_comes_round_and_is_smooth() {
        let mut spread = [f32::MAX, f32::MIN];
        for i in 0..2000 {
            let at = vec2(0.137 * i as f32 % 1.0, 0.731 * i as f32 % 1.0);
            let value = clouds(at, [3, 5], 3, 7);
            for shift in [Vec2::X, Vec2::Y, vec2(-1.0, 2.0)] {
                assert!((clouds(at + shift, [3, 5], 3, 7) - value).abs() < 1e-3, "{at}");
            }
            let near = clouds(at + Vec2::splat(1e-4), [3, 5], 3, 7);
            assert!((near - value).abs() < 0.02, "{at}: {value}, then {near}");
            spread = [spread[0].min(value), spread[1].max(value)];
        }
        assert!(spread[0] < -0.4 && spread[1] > 0.4, "{spread:?}");
    }
}
