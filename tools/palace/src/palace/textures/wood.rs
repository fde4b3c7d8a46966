//! Repeating textures of wood and bark, with vertical grain.

use super::noise::{clouds, random_unit, step};
use super::sheet::tile;
use enfilade::Texture;
use glam::{Vec3, vec2};
use std::f32::consts::TAU;
use std::sync::Arc;

/// Polished wood of any color: year rings cut lengthwise, and pores.
pub(super) fn grain() -> Arc<Texture> {
    tile("wood", 256, |at| {
        let bend = 0.5 * clouds(at, [3, 1], 2, 101) + 0.12 * clouds(at, [8, 2], 2, 102);
        let ring = (TAU * (7.0 * at.x + 1.6 * bend)).sin();
        let streak = clouds(at, [40, 2], 2, 103);
        let pore = step(0.25, 0.75, clouds(at, [90, 9], 1, 104));
        let value = 0.84 + 0.09 * ring + 0.10 * streak - 0.15 * pore;
        Vec3::new(1.02, 1.0, 0.94 + 0.05 * ring) * value
    })
}

/// Boards side by side, five to a metre, in varying tones.
pub(super) fn boards() -> Arc<Texture> {
    tile("boards", 256, |at| {
        let board = (at.x * 5.0).floor();
        let inside = at.x * 5.0 - board;
        let own = vec2(at.x, at.y + 0.37 * random_unit([board as i32, 0], 111));
        let bend = 0.5 * clouds(own, [10, 1], 2, 112);
        let ring = (TAU * (20.0 * at.x + 2.0 * bend)).sin();
        let streak = clouds(own, [60, 2], 2, 113);
        let gap = step(0.0, 0.05, inside.min(1.0 - inside));
        let tone = 0.76 + 0.18 * random_unit([board as i32, 1], 114);
        Vec3::new(1.0, 0.98, 0.95) * (tone + 0.06 * ring + 0.08 * streak) * (0.35 + 0.65 * gap)
    })
}

/// The bark of a tree.
pub(super) fn bark() -> Arc<Texture> {
    tile("bark", 128, |at| {
        let rib = clouds(at, [14, 4], 3, 121);
        Vec3::splat(0.75 + 0.45 * rib)
    })
}
