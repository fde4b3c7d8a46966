//! Plants: leaves, clipped hedges, grass, boughs of trees.

use super::noise::{clouds, random_unit, step};
use super::sheet::{painted, tile};
use enfilade::{Texture, Wrap};
use glam::{Vec2, Vec3, vec2};
use std::f32::consts::PI;
use std::sync::Arc;

/// A leaf from its stalk at the left to its tip at the right; transparent around it.
pub(super) fn leaf() -> Arc<Texture> {
    painted("leaf", [64; 2], [Wrap::Clamp; 2], |at| {
        let off = (at.y - 0.5).abs();
        let broad = 0.34 * (PI * at.x.clamp(0.0, 1.0).powf(0.8)).sin().max(0.0).powf(0.8);
        let teeth = 0.02 * ((at.x * 14.0).fract() - 0.5);
        let blade = step(0.0, 0.02, broad + teeth - off);
        let stalk = step(0.02, 0.01, off) * f32::from(at.x < 0.9);
        let rib = step(0.0, 0.025, off);
        let vein = step(0.0, 0.16, ((at.x * 7.0 - off * 6.0).fract() - 0.5).abs());
        let tone = (0.72 + 0.28 * rib) * (0.85 + 0.15 * vein) * (0.9 + 0.3 * (off - 0.1));
        (Vec3::new(0.98, 1.0, 0.85) * tone, blade.max(stalk))
    })
}

/// Many small leaves over dark gaps, a quarter of a metre or more: a hedge, or grass from above.
fn leaves(name: &str, cells: i32, slim: f32, dark: f32, seed: u32) -> Arc<Texture> {
    tile(name, 128, |at| {
        let scaled = at * cells as f32;
        let floor = scaled.floor();
        // The topmost leaf that covers the point, by the leaf's random height.
        let mut top = (-1.0_f32, 0.0, 0.0);
        for dy in -1..=1 {
            for dx in -1..=1 {
                let cell = [floor.x as i32 + dx, floor.y as i32 + dy];
                let id = cell.map(|c| c.rem_euclid(cells));
                for layer in 0..2 {
                    let own = |what: u32| random_unit(id, seed + 10 * layer + what);
                    let middle = vec2(cell[0] as f32, cell[1] as f32) + vec2(own(0), own(1));
                    let (sin, cos) = (2.0 * PI * own(2)).sin_cos();
                    let off = scaled - middle;
                    let along = off.dot(vec2(cos, sin)) / 0.75;
                    let aside = off.dot(vec2(-sin, cos)) / (0.75 * slim);
                    let inside = along * along + aside.abs() * (0.6 + 0.4 * aside.abs());
                    let height = own(3);
                    if inside < 1.0 && height > top.0 {
                        top = (height, own(4), 1.0 - 0.35 * step(0.25, 0.0, aside.abs()));
                    }
                }
            }
        }
        let (height, tone, rib) = top;
        if height < 0.0 {
            return Vec3::splat(dark);
        }
        let bright = (0.45 + 0.40 * height + 0.25 * tone) * rib;
        Vec3::new(0.9 + 0.2 * tone, 1.0, 0.8) * bright
    })
}

/// Clipped yew.
pub(super) fn hedge() -> Arc<Texture> {
    leaves("hedge", 14, 0.45, 0.25, 300)
}

/// Leaves of a tree's crown, as dense as nothing is seen between them.
pub(super) fn foliage() -> Arc<Texture> {
    leaves("foliage", 13, 0.52, 0.50, 340)
}

/// Mown grass.
pub(super) fn lawn() -> Arc<Texture> {
    let blades = leaves("blades", 20, 0.14, 0.55, 400);
    let blades = blades.texels();
    tile("lawn", 128, |at| {
        let texel = (at * 128.0).min(Vec2::splat(127.0));
        let [_, g, ..] = blades[texel.y as usize * 128 + texel.x as usize];
        let blade = (f32::from(g) / 255.0).powf(2.2);
        let patch = clouds(at, [3, 3], 3, 420);
        Vec3::new(1.0 + 0.10 * patch, 1.0, 0.9) * (0.62 + 0.38 * blade + 0.10 * patch)
    })
}

/// A bough: a cluster of leaves around the middle, the upper ones lighter; transparent around it.
pub(super) fn bough() -> Arc<Texture> {
    const CELLS: i32 = 14;
    painted("bough", [128; 2], [Wrap::Clamp; 2], |at| {
        let scaled = at * CELLS as f32;
        let floor = scaled.floor();
        // The topmost leaf that covers the point, by the leaf's random height.
        let mut top = (-1.0_f32, 0.0, 0.0);
        for dy in -1..=1 {
            for dx in -1..=1 {
                let cell = [floor.x as i32 + dx, floor.y as i32 + dy];
                for layer in 0..3 {
                    let own = |what: u32| random_unit(cell, 440 + 10 * layer + what);
                    let middle = vec2(cell[0] as f32 + own(0), cell[1] as f32 + own(1));
                    let off_middle = middle / CELLS as f32 - Vec2::splat(0.5);
                    let turn = off_middle.y.atan2(off_middle.x);
                    let reach = 0.37 + 0.06 * (3.0 * turn + 1.0).sin() + 0.04 * (7.0 * turn).sin();
                    if off_middle.length() > reach {
                        continue;
                    }
                    let (sin, cos) = (2.0 * PI * own(2)).sin_cos();
                    let off = scaled - middle;
                    let along = off.dot(vec2(cos, sin)) / 0.95;
                    let aside = off.dot(vec2(-sin, cos)) / 0.5;
                    let inside = along * along + aside.abs() * (0.6 + 0.4 * aside.abs());
                    let height = own(3);
                    if inside < 1.0 && height > top.0 {
                        let rib = 1.0 - 0.25 * step(0.22, 0.0, aside.abs());
                        top = (height, own(4), rib);
                    }
                }
            }
        }
        let (height, tone, rib) = top;
        let lit = 0.80 - 0.35 * (at.y - 0.5) + 0.25 * (height - 0.5);
        let color = Vec3::new(0.85 + 0.25 * tone, 1.0, 0.7) * (lit * (0.75 + 0.35 * tone) * rib);
        (color, f32::from(height >= 0.0))
    })
}

/// A tuft of long grass: blades from the lower edge up.
pub(super) fn tuft() -> Arc<Texture> {
    painted("tuft of grass", [128, 64], [Wrap::Clamp; 2], |at| {
        let up = 1.0 - at.y;
        let mut best = (0.0_f32, 0.0);
        for blade in 0..34 {
            let own = |what: u32| random_unit([blade, 0], 480 + what);
            let tall = (0.35 + 0.62 * own(1)) * (1.0 - (2.0 * own(0) - 1.0).powi(4) * 0.6);
            let foot = 0.08 + 0.84 * own(0);
            let lean = 0.22 * (own(2) - 0.5);
            let part = up / tall;
            if part >= 1.0 {
                continue;
            }
            let middle = foot + lean * part * part;
            let inside = 0.016 * (1.0 - part) + 0.003 - (at.x - middle).abs();
            if inside > 0.0 && own(3) + 0.01 > best.0 {
                best = (own(3) + 0.01, 0.55 + 0.45 * part + 0.25 * (own(4) - 0.5));
            }
        }
        let (found, tone) = best;
        (Vec3::new(0.95, 1.0, 0.72) * tone, f32::from(found > 0.0))
    })
}
