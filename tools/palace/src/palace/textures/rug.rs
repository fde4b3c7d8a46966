//! Rugs: a quarter of one, to be mirrored.
//!
//! The first half of the texture is the border, [`BORDER`] metres wide, the second a quarter of the figure that fills
//! the field repeatedly. The ends, at the top, have a fringe.

use super::noise::{clouds, random_unit, step};
use super::sheet::painted;
use enfilade::{Texture, Wrap};
use glam::{Vec2, Vec3, vec2};
use std::f32::consts::TAU;
use std::sync::Arc;

/// Width of the border, in metres: half the texture.
pub(crate) const BORDER: f32 = 0.6;

/// A rug with the colors of its ground, its border and its figures.
pub(super) fn rug(name: &str, [ground, border, figure]: [Vec3; 3], seed: u32) -> Arc<Texture> {
    painted(name, [256; 2], [Wrap::Mirror; 2], |at| {
        // Knots, one or two texels wide.
        let knot = (at * 128.0).floor();
        let wool = 0.80
            + 0.25 * random_unit([knot.x as i32, knot.y as i32], seed)
            + 0.10 * clouds(at, [5, 5], 2, seed);
        if at.y < 0.055 {
            let thread = (at.x * 64.0).fract();
            let loose = 0.02 * random_unit([(at.x * 64.0) as i32, 1], seed);
            let coverage = step(0.42, 0.30, (thread - 0.5).abs()) * f32::from(at.y > loose);
            return (Vec3::new(0.62, 0.54, 0.38) * wool, coverage);
        }
        let from_edge = (at.x / 0.5).min((at.y - 0.055) / 0.445);
        let color = if from_edge < 1.0 {
            let along = if at.x / 0.5 < (at.y - 0.055) / 0.445 {
                at.y
            } else {
                at.x
            };
            bordered(from_edge, along, [ground, border, figure])
        } else {
            field((at - Vec2::splat(0.5)) * 2.0, [ground, border, figure])
        };
        (color * wool, 1.0)
    })
}

/// The border, `from_edge` 0 to 1; eight repeats of its pattern to the texture.
fn bordered(from_edge: f32, along: f32, [ground, border, figure]: [Vec3; 3]) -> Vec3 {
    let stripe = |from: f32, to: f32| (from..to).contains(&from_edge);
    if stripe(0.0, 0.06) || stripe(0.90, 0.96) {
        return border * 0.8;
    }
    if stripe(0.06, 0.11) || stripe(0.22, 0.26) || stripe(0.74, 0.78) || stripe(0.96, 1.0) {
        return figure;
    }
    let phase = (along * 8.0 + 0.5).fract() - 0.5;
    if stripe(0.11, 0.22) || stripe(0.78, 0.90) {
        let middle = if from_edge < 0.5 { 0.165 } else { 0.84 };
        let dot = (2.0 * (2.0 * phase).abs().fract() - 1.0).abs() * 0.06 + (from_edge - middle).abs();
        return if dot < 0.045 { figure } else { ground };
    }
    // A vine that winds through the wide stripe, with a flower in every bend.
    let vine = 0.5 + 0.12 * (TAU * phase).sin();
    let off = vec2(phase.abs() - 0.25, (from_edge - 0.5) * 1.2);
    let petals = 0.13 + 0.035 * (6.0 * off.y.atan2(off.x)).cos();
    let away = off.length();
    if away < 0.05 {
        figure
    } else if away < petals {
        ground.lerp(Vec3::ONE, 0.12)
    } else if away < petals + 0.025 || (from_edge - vine).abs() < 0.02 {
        figure * 0.85
    } else {
        border
    }
}

/// A quarter of a medallion, its middle at (1, 1), and of a smaller one at (0, 0).
fn field(at: Vec2, [ground, border, figure]: [Vec3; 3]) -> Vec3 {
    let lobed = |from: Vec2, lobes: f32, depth: f32| {
        let off = at - from;
        off.length() * (1.0 + depth * (lobes * off.y.atan2(off.x)).cos())
    };
    let large = lobed(Vec2::ONE, 8.0, 0.10);
    let small = lobed(Vec2::ZERO, 8.0, -0.14);
    let rings: [(f32, Vec3); 6] = [
        (0.09, figure),
        (0.20, ground * 1.15),
        (0.24, figure),
        (0.50, border),
        (0.56, figure),
        (0.60, ground * 0.7),
    ];
    for (reach, color) in rings {
        if large < reach {
            let leaf = (16.0 * (at.y - 1.0).atan2(at.x - 1.0)).cos() > 0.35 && (0.30..0.44).contains(&large);
            return if leaf { figure } else { color };
        }
    }
    for (reach, color) in [(0.10, figure), (0.24, border), (0.28, figure)] {
        if small < reach {
            return color;
        }
    }
    // Sprigs strewn between.
    let sprig = at * 7.0;
    let cell = sprig.floor();
    let off = sprig - cell - Vec2::splat(0.5);
    let petals = 0.20 + 0.10 * (4.0 * off.y.atan2(off.x)).cos();
    if off.length() < petals && (cell.x + cell.y) % 2.0 == 0.0 {
        if off.length() < 0.07 { border } else { figure * 0.9 }
    } else {
        ground
    }
}
