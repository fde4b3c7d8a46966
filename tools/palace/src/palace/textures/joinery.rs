//! Painted architecture: panelled walls, inlaid floors, a sky on a ceiling.

use super::noise::{clouds, step, veins};
use super::sheet::{painted, tile};
use enfilade::{Texture, Wrap};
use glam::{Vec2, Vec3, vec2};
use std::f32::consts::TAU;
use std::sync::Arc;

/// Distance from the outline of a rectangle, negative inside it.
fn beyond(at: Vec2, middle: Vec2, half: Vec2) -> f32 {
    let off = (at - middle).abs() - half;
    off.max(Vec2::ZERO).length() + off.max_element().min(0.0)
}

/// One wall panel from floor to cornice, `field` framed in ivory and gold; repeats horizontally.
pub(super) fn panelled_wall(name: &str, field: Vec3, seed: u32) -> Arc<Texture> {
    let [ivory, gold] = [Vec3::new(0.66, 0.60, 0.48), Vec3::new(0.62, 0.40, 0.10)];
    painted(name, [128, 512], [Wrap::Repeat, Wrap::Clamp], |at| {
        // In units of the height; a panel is a quarter of it wide.
        let at = vec2(0.25 * at.x, 1.0 - at.y);
        let middle = 0.125;
        let grain = 1.0 + 0.04 * clouds(vec2(at.x * 4.0, at.y), [6, 24], 2, seed);
        // Lines that are light above and dark below look like mouldings.
        let relief = |from: f32, wide: f32| {
            let part = (from / wide).clamp(0.0, 1.0);
            if (0.0..wide).contains(&from) {
                0.72 + 0.5 * (0.5 * TAU * part).sin()
            } else {
                1.0
            }
        };
        let skirting = at.y < 0.055;
        let rail = (0.225..0.25).contains(&at.y);
        let frieze = at.y > 0.90;
        if skirting || rail {
            let from = if skirting { at.y } else { at.y - 0.225 };
            return (
                ivory * 0.92 * relief(from, if skirting { 0.055 } else { 0.025 }) * grain,
                1.0,
            );
        }
        if frieze {
            let leaf = (TAU * at.x * 32.0).sin().abs();
            let row = (at.y - 0.94).abs() < 0.012 + 0.010 * leaf;
            let edge = (at.y - 0.905).abs() < 0.004 || (at.y - 0.98).abs() < 0.004;
            let color = if row || edge {
                gold * (0.8 + 0.4 * leaf)
            } else {
                ivory
            };
            return (color * grain, 1.0);
        }
        let [low, high] = if at.y < 0.225 {
            [0.075, 0.21]
        } else {
            [0.285, 0.87]
        };
        let center = vec2(middle, 0.5 * (low + high));
        let half = vec2(0.098, 0.5 * (high - low));
        let off = beyond(at, center, half);
        let inner = beyond(at, center, half - Vec2::splat(0.016));
        let color = if off > 0.0 {
            ivory
        } else if off > -0.006 {
            gold * (0.75 + 0.45 * relief(-off, 0.006))
        } else if inner > -0.003 && inner < 0.0 {
            gold * 0.9
        } else if at.y < 0.225 {
            field * 0.72
        } else {
            // A spray of leaves up the middle of the field.
            let up = (at.y - low) / (high - low);
            let stem = 0.010 * (TAU * 3.0 * up).sin();
            let beside = (at.x - middle - stem).abs();
            let leaf = 0.030 * (TAU * 7.0 * up).sin().abs() * (1.0 - (2.0 * up - 1.0).powi(4));
            let drawn = step(0.003, 0.0, beside - 0.0015).max(0.55 * step(0.004, 0.0, beside - leaf));
            field.lerp(gold * 1.1, 0.55 * drawn * f32::from((0.06..0.94).contains(&up)))
        };
        (color * grain, 1.0)
    })
}

/// Inlaid marble: stars of eight points in octagons, small squares between them.
pub(super) fn inlaid_floor() -> Arc<Texture> {
    tile("inlaid floor", 256, |at| {
        let off = at - Vec2::splat(0.5);
        let away = off.abs();
        let octagon = away
            .max_element()
            .max((away.x + away.y) * std::f32::consts::FRAC_1_SQRT_2);
        let star = away
            .max_element()
            .min((away.x + away.y) * std::f32::consts::FRAC_1_SQRT_2);
        let cloud = clouds(at, [4, 4], 3, 510);
        let vein = veins(at, [4, 5], 6.0, 520);
        let marble = |ground: Vec3, veined: Vec3| (ground * (1.0 + 0.12 * cloud)).lerp(veined, 0.5 * vein);
        let pale = marble(Vec3::new(0.74, 0.70, 0.62), Vec3::splat(0.5));
        let red = marble(Vec3::new(0.30, 0.10, 0.07), Vec3::new(0.5, 0.36, 0.3));
        let green = marble(Vec3::new(0.07, 0.19, 0.12), Vec3::new(0.34, 0.46, 0.36));
        let color = match () {
            () if octagon > 0.47 => green,
            () if octagon > 0.445 => marble(Vec3::new(0.55, 0.40, 0.16), Vec3::splat(0.5)),
            () if star < 0.12 => red,
            () if star < 0.21 => pale,
            () if star < 0.25 && octagon < 0.36 => red,
            () => pale,
        };
        let joint = step(0.002, 0.006, (octagon - 0.47).abs().min((octagon - 0.445).abs()));
        color * (0.75 + 0.25 * joint)
    })
}

/// Clouds on a blue sky, as on painted ceilings; repeats with a long period.
pub(super) fn painted_sky() -> Arc<Texture> {
    tile("painted sky", 256, |at| {
        let cloud = clouds(at, [3, 3], 5, 530);
        let lit = clouds(at + vec2(0.012, 0.018), [3, 3], 5, 530);
        let cover = step(-0.05, 0.45, cloud);
        let blue = Vec3::new(0.20, 0.38, 0.66);
        let white = Vec3::new(1.0, 0.95, 0.88) * (0.86 + 0.5 * (cloud - lit)).clamp(0.5, 1.05);
        blue.lerp(white, cover)
    })
}
