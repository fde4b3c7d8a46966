//! Silk, velvet and lace.

use super::noise::{clouds, step};
use super::sheet::{painted, tile};
use enfilade::{Texture, Wrap};
use glam::{Vec2, Vec3, vec2};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// Returns the coverage of a damask flower, 0 to 1. `at` is relative to its middle, in units of the pattern's width.
fn flower(at: Vec2) -> f32 {
    let at = vec2(at.x.abs(), at.y);
    let soft = |inside: f32| step(-0.008, 0.008, inside);
    // A leaf from `foot` towards `tip`.
    let leaf = |foot: Vec2, tip: Vec2, wide: f32| {
        let along = tip - foot;
        let part = (at - foot).dot(along) / along.length_squared();
        let off = (at - foot).perp_dot(along).abs() / along.length();
        let breadth = wide * (PI * part.clamp(0.0, 1.0)).sin().max(0.0).sqrt();
        if (0.0..=1.0).contains(&part) {
            soft(breadth - off) * (1.0 - soft(0.1 * breadth - off))
        } else {
            0.0
        }
    };
    let bud = soft(0.055 - at.distance(vec2(0.0, -0.02)));
    [
        leaf(vec2(0.0, 0.02), vec2(0.0, -0.24), 0.05),
        leaf(vec2(0.02, 0.02), vec2(0.14, -0.17), 0.042),
        leaf(vec2(0.03, 0.05), vec2(0.19, -0.04), 0.038),
        leaf(vec2(0.02, 0.08), vec2(0.16, 0.12), 0.034),
        leaf(vec2(0.0, 0.07), vec2(0.0, 0.26), 0.03),
        bud,
    ]
    .into_iter()
    .fold(0.0, f32::max)
}

/// Silk woven with flowers between wavy bands, in two tones of a color.
pub(super) fn damask() -> Arc<Texture> {
    tile("damask", 256, |at| {
        // Each flower, and those offset by half a pattern.
        let near = |middle: Vec2| {
            let off = at - middle;
            off - off.round()
        };
        let figure = flower(near(vec2(0.25, 0.25))).max(flower(near(vec2(0.75, 0.75))));
        let wave = 0.115 * (TAU * at.y).cos();
        let band = |middle: f32, side: f32| {
            let off = at.x - middle - side * wave;
            let off = (off - off.round()).abs();
            step(0.020, 0.012, off) * step(0.003, 0.009, off)
        };
        let bands = band(0.5, 1.0).max(band(0.0, -1.0));
        let woven = figure.max(bands);
        let thread = 0.03 * (TAU * 64.0 * at.y).sin() * (1.0 - woven) + 0.03 * clouds(at, [96, 24], 1, 201);
        let ground = Vec3::splat(0.70);
        let shine = Vec3::new(1.0, 0.985, 0.93);
        ground.lerp(shine, woven) + Vec3::splat(thread)
    })
}

/// Velvet or other thick cloth: soft, with a brushed nap.
pub(super) fn velvet() -> Arc<Texture> {
    tile("velvet", 128, |at| {
        Vec3::splat(0.86 + 0.12 * clouds(at, [3, 5], 3, 211) + 0.06 * clouds(at, [48, 48], 1, 212))
    })
}

/// A curtain from its hem up, four metres: velvet, gold braid near the lower edge, a fringe with tassels. Repeats every
/// half metre horizontally.
pub(super) fn curtain(name: &str, cloth: Vec3) -> Arc<Texture> {
    let gold = Vec3::new(0.62, 0.40, 0.10);
    painted(name, [64, 512], [Wrap::Repeat, Wrap::Clamp], |at| {
        // In metres above the hem.
        let up = 4.0 * (1.0 - at.y);
        let nap = 0.85 + 0.13 * clouds(vec2(at.x, at.y * 4.0), [4, 16], 2, 221);
        let thread = (at.x * 16.0).fract();
        let fringe = up < 0.09;
        let tassel = step(0.30, 0.20, (thread - 0.5).abs() + 0.1 * step(0.0, 0.03, up) - 0.1);
        let braid = (0.09..0.13).contains(&up) || (0.17..0.19).contains(&up);
        let twist = 0.8 + 0.2 * (TAU * (8.0 * at.x + 12.0 * up)).sin();
        match (fringe, braid) {
            (true, _) => (gold * (0.6 + 0.4 * step(0.5, 0.0, (thread - 0.5).abs())), tassel),
            (_, true) => (gold * twist, 1.0),
            _ => (cloth * nap, 1.0),
        }
    })
}

/// Lace: a net with flowers worked into it.
pub(super) fn lace() -> Arc<Texture> {
    painted("lace", [128; 2], [Wrap::Repeat; 2], |at| {
        let off = at - Vec2::splat(0.5);
        let petal = 0.30 + 0.10 * (5.0 * off.y.atan2(off.x)).cos();
        let bloom = step(petal + 0.02, petal - 0.02, off.length()) * step(0.07, 0.10, off.length());
        let turned = vec2(at.x + at.y, at.x - at.y) * 9.0;
        let mesh = (turned - turned.round()).abs();
        // More thread than holes, so that from afar it is white rather than gone.
        let net = step(0.29, 0.35, mesh.max_element());
        let thread = 0.92 + 0.08 * clouds(at, [32, 32], 1, 231);
        (Vec3::splat(thread), bloom.max(net))
    })
}
