//! Leaded glass.

use super::noise::{clouds, random_unit, step};
use super::sheet::painted;
use enfilade::{Texture, Wrap};
use glam::{Vec2, Vec3, vec2};
use std::f32::consts::TAU;
use std::sync::Arc;

/// Clear glass in repeating lozenges; the lead is opaque, the glass nearly transparent.
pub(super) fn leaded() -> Arc<Texture> {
    painted("leaded glass", [128; 2], [Wrap::Repeat; 2], |at| {
        let turned = vec2(at.x + at.y, at.x - at.y) * 2.0;
        let off = (turned - turned.round()).abs();
        let lead = step(0.030, 0.018, off.min_element());
        let cell = turned.floor();
        let id = [cell.x as i32, cell.y as i32].map(|c| c.rem_euclid(4));
        let tint = 0.85 + 0.15 * random_unit(id, 501);
        let ripple = 0.03 * clouds(at, [6, 6], 2, 502);
        let glass = Vec3::new(0.80, 0.90, 0.88) * (tint + ripple);
        (
            glass.lerp(Vec3::splat(0.05), lead),
            0.10 + 0.06 * tint + 0.84 * lead,
        )
    })
}

/// A stained-glass window: a rose of petals over an upright lattice. Returns the emitted color.
pub(super) fn stained() -> Arc<Texture> {
    const JEWELS: [Vec3; 6] = [
        Vec3::new(0.75, 0.06, 0.05),
        Vec3::new(0.05, 0.12, 0.75),
        Vec3::new(0.95, 0.62, 0.10),
        Vec3::new(0.06, 0.45, 0.16),
        Vec3::new(0.42, 0.08, 0.55),
        Vec3::new(0.20, 0.55, 0.85),
    ];
    painted("stained glass", [128, 256], [Wrap::Repeat; 2], |at| {
        let place = vec2(at.x, 2.0 * at.y);
        let (cell, lead) = rose(place - vec2(0.5, 0.5)).unwrap_or_else(|| lattice(place));
        let color = JEWELS[(6.0 * random_unit(cell, 511)) as usize % 6];
        let light = 0.65 + 0.35 * random_unit(cell, 512) + 0.25 * clouds(at, [6, 12], 3, 513);
        (color * light * lead, 1.0)
    })
}

/// Returns the index of the rose's pane at a point, and the distance from the lead, 0 to 1; `None` outside.
fn rose(at: Vec2) -> Option<([i32; 2], f32)> {
    let away = at.length();
    let turn = at.y.atan2(at.x) / TAU;
    let rings = [
        (0.0, 0.10, 1.0),
        (0.10, 0.26, 8.0),
        (0.26, 0.34, 16.0),
        (0.34, 0.45, 12.0),
    ];
    let (number, &(from, to, panes)) = (rings.iter().enumerate()).find(|(_, ring)| away < ring.1)?;
    let part = turn * panes;
    let aside = (part - part.round()).abs() / panes * TAU * away;
    let aside = if panes > 1.0 { aside } else { 1.0 };
    let along = (to - away).min(if from > 0.0 { away - from } else { 1.0 });
    let cell = [
        number as i32 + 40,
        (part.floor() as i32).rem_euclid(panes as i32) % 2,
    ];
    Some((cell, step(0.008, 0.022, aside.min(along))))
}

fn lattice(at: Vec2) -> ([i32; 2], f32) {
    let turned = vec2(6.0 * at.x + 3.0 * at.y, 6.0 * at.x - 3.0 * at.y);
    let cell = turned.floor();
    let off = (turned - cell).min(Vec2::ONE - (turned - cell)).min_element();
    let border = at.x.min(1.0 - at.x);
    let id = if border < 0.07 {
        [9, (at.y * 8.0) as i32 % 16]
    } else {
        [cell.x as i32, cell.y as i32].map(|c| c.rem_euclid(6))
    };
    let row = (at.y * 8.0 - (at.y * 8.0).round()).abs() / 8.0;
    let lead = if border < 0.07 {
        border.min(row).min(0.07 - border)
    } else {
        (0.2 * off).min(border - 0.07)
    };
    (id, step(0.006, 0.018, lead))
}
