//! Paintings with visible brush strokes: landscapes, the sea, ruins, a bunch of flowers, portraits.

use super::noise::{clouds, random_unit, step};
use super::sheet::painted;
use enfilade::{Texture, Wrap};
use glam::{Vec2, Vec3, vec2, vec3};
use std::f32::consts::TAU;
use std::sync::Arc;

/// Numbers of wide and of tall paintings.
pub(crate) const BROAD: usize = 7;
pub(crate) const HIGH: usize = 4;

/// Width by height of wide paintings; tall ones are transposed.
pub(crate) const ASPECT: f32 = 4.0 / 3.0;

/// Generates one painting; wide ones first.
pub(super) fn painting(number: usize) -> Arc<Texture> {
    if number < BROAD {
        broad(number)
    } else {
        high(number - BROAD)
    }
}

fn broad(which: usize) -> Arc<Texture> {
    let seed = 600 + 10 * which as u32;
    brushed(
        &format!("painting {}", which + 1),
        [256, 192],
        seed,
        move |at| match which {
            0 => land(at, seed, &MORNING, true),
            1 => land(at, seed, &EVENING, false),
            2 => land(at, seed, &NOON, true),
            3 => sea(at, seed, &NOON),
            4 => sea(at, seed, &EVENING),
            5 => ruin(at, seed, &MORNING),
            _ => ruin(at, seed, &EVENING),
        },
    )
}

fn high(which: usize) -> Arc<Texture> {
    let seed = 800 + 10 * which as u32;
    let name = format!("painting {}", BROAD + which + 1);
    brushed(&name, [144, 192], seed, move |at| match which {
        0 => flowers(at, seed),
        1 => person(at, vec3(0.45, 0.05, 0.05), true, seed),
        2 => person(at, vec3(0.06, 0.12, 0.30), false, seed),
        _ => person(at, vec3(0.10, 0.22, 0.12), true, seed),
    })
}

/// Colors of a time of day: sky at zenith and horizon, light, distance haze.
struct Hour {
    above: Vec3,
    horizon: Vec3,
    light: Vec3,
    far: Vec3,
}

const MORNING: Hour = Hour {
    above: Vec3::new(0.20, 0.36, 0.60),
    horizon: Vec3::new(0.85, 0.76, 0.58),
    light: Vec3::new(1.0, 0.93, 0.78),
    far: Vec3::new(0.33, 0.43, 0.52),
};
const NOON: Hour = Hour {
    above: Vec3::new(0.12, 0.28, 0.58),
    horizon: Vec3::new(0.66, 0.76, 0.82),
    light: Vec3::new(1.0, 1.0, 0.92),
    far: Vec3::new(0.28, 0.42, 0.50),
};
const EVENING: Hour = Hour {
    above: Vec3::new(0.12, 0.10, 0.26),
    horizon: Vec3::new(0.95, 0.45, 0.13),
    light: Vec3::new(0.95, 0.55, 0.32),
    far: Vec3::new(0.26, 0.14, 0.24),
};

/// Applies brush strokes, which smear colors along short lines, and a varnish that darkens the corners.
fn brushed(name: &str, size: [u32; 2], seed: u32, color: impl Fn(Vec2) -> Vec3) -> Arc<Texture> {
    painted(name, size, [Wrap::Clamp; 2], |at| {
        let pull = vec2(
            clouds(at, [22, 30], 2, seed + 900),
            clouds(at, [26, 34], 2, seed + 910),
        );
        let moved = at + 0.012 * pull;
        let bristle = 0.06 * clouds(vec2(at.x, at.y + 0.1 * pull.x), [40, 90], 1, seed + 920);
        let from_middle = (at - Vec2::splat(0.5)).length();
        let varnish = vec3(1.0, 0.96, 0.86) * (1.0 - 0.45 * step(0.35, 0.75, from_middle));
        (color(moved) * (1.0 + bristle) * varnish, 1.0)
    })
}

fn sky(at: Vec2, horizon: f32, seed: u32, hour: &Hour) -> Vec3 {
    let up = ((horizon - at.y) / horizon).clamp(0.0, 1.0);
    let sun = vec2(0.68, horizon - 0.10);
    let glow = step(0.45, 0.0, (at - sun).length());
    let disc = step(0.035, 0.028, (at - sun).length());
    let cloud = step(
        0.0,
        0.8,
        clouds(vec2(at.x, at.y * 2.2), [2, 3], 5, seed) + 0.25 * up,
    );
    let pale = hour.light.lerp(Vec3::ONE, 0.3) * 0.9;
    hour.horizon
        .lerp(hour.above, up.powf(0.8))
        .lerp(hour.light, 0.55 * glow)
        .lerp(pale, 0.6 * cloud * (0.4 + 0.6 * up))
        .lerp(Vec3::new(1.0, 0.92, 0.7), disc)
}

/// Returns the upper edge of hills at a horizontal position.
fn ridge(x: f32, base: f32, high: f32, cells: i32, seed: u32) -> f32 {
    base - high * clouds(vec2(x, 0.5), [cells, 3], 3, seed)
}

/// A valley with a river, hills behind it, and optional trees.
fn land(at: Vec2, seed: u32, hour: &Hour, trees: bool) -> Vec3 {
    let horizon = 0.5;
    let mut color = sky(at, horizon, seed, hour);
    let greens = [
        hour.far,
        hour.far.lerp(vec3(0.14, 0.24, 0.10), 0.45),
        vec3(0.14, 0.22, 0.06),
        vec3(0.07, 0.10, 0.03),
    ];
    for (i, green) in greens.into_iter().enumerate() {
        let near = i as f32 / 3.0;
        let edge = ridge(
            at.x,
            horizon + 0.28 * near,
            0.16 - 0.08 * near,
            2 + i as i32,
            seed + 1 + i as u32,
        );
        if at.y > edge {
            let slope = 0.8 + 0.5 * clouds(at, [7, 14], 3, seed + 20 + i as u32) - 0.4 * (at.y - edge);
            color = green * hour.light * slope;
        }
    }
    let bend = 0.42 + 0.16 * ((at.y - 0.66) * 13.0).sin();
    let wide = 0.22 * (at.y - 0.66);
    if at.y > 0.68 && (at.x - bend).abs() < wide {
        let gleam = 0.8 + 0.3 * clouds(at, [4, 30], 2, seed + 30);
        color = hour.horizon.lerp(hour.above, 0.35) * gleam;
    }
    if trees {
        for i in 0..4 {
            let own = |what: i32| random_unit([i, what], seed);
            let foot = vec2(
                [0.10, 0.20, 0.80, 0.93][i as usize] + 0.05 * own(0),
                0.80 + 0.12 * own(1),
            );
            let tall = 0.38 + 0.22 * own(2);
            let trunk = (at.x - foot.x + 0.01 * (at.y * 20.0).sin()).abs() < 0.008;
            if trunk && at.y < foot.y && at.y > foot.y - 0.6 * tall {
                color = vec3(0.06, 0.035, 0.02);
            }
            let crown = foot - vec2(0.0, 0.72 * tall);
            let off = (at - crown) / vec2(0.30 * tall, 0.36 * tall);
            let rough = 0.35 * clouds(at, [14, 12], 3, seed + 50 + i as u32);
            if off.length() + rough < 1.0 {
                let lit = 0.55 - 0.45 * off.y + 0.3 * off.x + rough;
                color = vec3(0.16, 0.20, 0.045) * hour.light * lit.max(0.1);
            }
        }
    }
    color
}

/// The sea with ships on it.
fn sea(at: Vec2, seed: u32, hour: &Hour) -> Vec3 {
    let horizon = 0.60;
    let mut color = sky(at, horizon, seed, hour);
    if at.y > horizon {
        let near = (at.y - horizon) / (1.0 - horizon);
        let wave = clouds(vec2(at.x, near.sqrt()), [5, 26], 3, seed + 3);
        let path = step(0.12 + 0.25 * near, 0.0, (at.x - 0.68).abs());
        let deep = hour.above.lerp(vec3(0.02, 0.09, 0.10), 0.6) * (1.1 - 0.4 * near);
        color = deep.lerp(hour.light, 0.55 * path * step(-0.3, 0.5, wave)) * (1.0 + 0.4 * wave);
    }
    for (x, y, size) in [(0.34, 0.70, 0.44), (0.80, 0.615, 0.12), (0.12, 0.61, 0.08)] {
        let off = (at - vec2(x, y)) / size;
        color = ship(off).unwrap_or(color);
    }
    color
}

/// A ship with its water line at 0, of length and height 1.
fn ship(at: Vec2) -> Option<Vec3> {
    let hull = at.y > -0.13 - 0.10 * at.x * at.x && at.y < 0.02 && at.x.abs() < 0.42 + 0.6 * (-at.y);
    if hull {
        let band = (-0.09..-0.06).contains(&at.y);
        return Some(if band {
            vec3(0.62, 0.44, 0.16)
        } else {
            vec3(0.09, 0.05, 0.03)
        });
    }
    for (mast, tall) in [(-0.24, 0.72), (0.04, 0.88), (0.28, 0.62)] {
        for sail in 0..3 {
            let [low, high] = [0.0, 0.26].map(|part| 0.17 + tall * (0.28 * sail as f32 + part));
            let up = -at.y;
            let wide = 0.135 - 0.025 * sail as f32;
            let belly = 0.03 * (std::f32::consts::PI * ((up - low) / (high - low)).clamp(0.0, 1.0)).sin();
            let x = at.x - mast - belly;
            if (low..high).contains(&up) && x.abs() < wide {
                return Some(Vec3::new(0.82, 0.74, 0.58) * (0.78 + 1.6 * x));
            }
        }
        if (at.x - mast).abs() < 0.008 && (0.0..tall + 0.22).contains(&-at.y) {
            return Some(vec3(0.10, 0.06, 0.03));
        }
    }
    None
}

/// Columns of a ruined temple before a plain.
fn ruin(at: Vec2, seed: u32, hour: &Hour) -> Vec3 {
    let mut color = land(at, seed, hour, false);
    let stone = |lit: f32| vec3(0.62, 0.52, 0.38) * hour.light * lit;
    for (i, x) in [0.12, 0.24, 0.36, 0.48].into_iter().enumerate() {
        let top = [0.26, 0.26, 0.26, 0.46][i];
        let off = (at.x - x) / 0.026;
        if off.abs() < 1.0 && at.y > top && at.y < 0.84 {
            let flute = 0.12 * (off * 14.0).sin();
            color = stone(0.45 + 0.5 * (off + 0.6).clamp(0.0, 1.0) + flute);
        }
        if off.abs() < 1.45 && ((top - 0.02..top + 0.015).contains(&at.y) || (0.83..0.86).contains(&at.y)) {
            color = stone(0.8);
        }
    }
    let broken = 0.40 + 0.03 * clouds(at, [20, 20], 2, seed + 9);
    if (0.17..0.24).contains(&at.y) && at.x > 0.07 && at.x < broken {
        color = stone(0.7 + 0.2 * f32::from(at.y < 0.19));
    }
    for (x, y) in [(0.62, 0.86), (0.70, 0.89), (0.44, 0.90)] {
        let off = (at - vec2(x, y)) / vec2(0.05, 0.028);
        if off.length() < 1.0 {
            color = stone(0.6 - 0.4 * off.y);
        }
    }
    color
}

/// Flowers in a vase on a table.
fn flowers(at: Vec2, seed: u32) -> Vec3 {
    let mut color = vec3(0.05, 0.035, 0.025) * (1.2 + clouds(at, [3, 4], 3, seed));
    if at.y > 0.82 {
        color = vec3(0.26, 0.11, 0.05) * (1.0 + 0.3 * clouds(at, [3, 30], 2, seed + 1));
    }
    let up = (0.90 - at.y) / 0.32;
    let belly = 0.07 + 0.10 * (up * 2.9).sin().max(0.0).powf(0.8);
    let across = (at.x - 0.5) / belly;
    if (0.0..1.0).contains(&up) && across.abs() < 1.0 {
        let pattern = if (TAU * 2.0 * up + 6.0 * across).sin() > 0.5 {
            0.35
        } else {
            1.0
        };
        let light = 0.35 + 0.6 * (0.6 - across).clamp(0.0, 1.0);
        color = vec3(0.62 * pattern, 0.66 * pattern.max(0.5), 0.72) * light;
    }
    for i in 0..46 {
        let own = |what: i32| random_unit([i, what], seed);
        let (sin, cos) = (TAU * own(0)).sin_cos();
        let middle = vec2(0.5, 0.40) + vec2(cos * 0.36, sin * 0.27) * own(1).sqrt();
        let reach = 0.045 + 0.06 * own(2);
        let off = (at - middle) / vec2(1.0, 0.75);
        let petals = reach * (0.8 + 0.2 * (5.0 * off.y.atan2(off.x) + 9.0 * own(3)).cos());
        let away = off.length();
        if away < petals {
            let kinds = [
                vec3(0.75, 0.10, 0.10),
                vec3(0.88, 0.62, 0.52),
                vec3(0.90, 0.84, 0.70),
                vec3(0.85, 0.58, 0.10),
                vec3(0.08, 0.16, 0.05),
                vec3(0.26, 0.16, 0.46),
            ];
            let kind = kinds[(6.0 * own(4)) as usize % 6];
            let light = 0.5 + 0.7 * (0.5 - off.y / petals * 0.4 - off.x / petals * 0.3);
            color = kind * light * (0.6 + 0.4 * (away / petals * 9.0).sin().abs());
        }
    }
    color
}

/// A portrait: head and shoulders before a dark ground.
fn person(at: Vec2, cloth: Vec3, wig: bool, seed: u32) -> Vec3 {
    let glow = step(0.6, 0.1, at.distance(vec2(0.62, 0.35)));
    let mut color = vec3(0.085, 0.065, 0.045) * (0.5 + 1.3 * glow + 0.5 * clouds(at, [3, 4], 3, seed));
    let light = |off: Vec2| (0.75 - 0.45 * off.x - 0.30 * off.y).clamp(0.15, 1.2);
    let hair = (at - vec2(0.5, 0.32)) / vec2(if wig { 0.215 } else { 0.16 }, if wig { 0.25 } else { 0.18 });
    if hair.length() + 0.10 * clouds(at, [16, 14], 2, seed + 2) < 1.0 {
        let curl = 0.75 + 0.35 * clouds(at, [16, 20], 2, seed + 3);
        color = if wig {
            vec3(0.55, 0.52, 0.47)
        } else {
            vec3(0.11, 0.06, 0.03)
        } * curl
            * light(hair);
    }
    let body = (at - vec2(0.5, 1.08)) / vec2(0.46, 0.52);
    if body.length() < 1.0 {
        let fold = 1.0 + 0.5 * clouds(vec2(at.x, at.y * 0.4), [7, 3], 3, seed + 4);
        color = cloth * light(body) * fold * 1.3;
        let sash = (body.x + 0.55 * body.y + 0.25).abs();
        if sash < 0.10 {
            color = vec3(0.66, 0.45, 0.12) * light(body) * fold;
        }
    }
    let neck = (at - vec2(0.5, 0.55)) / vec2(0.065, 0.12);
    let face = (at - vec2(0.5, 0.36)) / vec2(0.115, 0.155);
    let skin = vec3(0.78, 0.50, 0.36);
    if neck.length() < 1.0 {
        color = skin * 0.62 * light(neck);
    }
    let collar = (at - vec2(0.5, 0.655)) / vec2(0.13, 0.075);
    if collar.length() + 0.15 * clouds(at, [20, 20], 1, seed + 5) < 1.0 {
        color = vec3(0.85, 0.82, 0.74) * (0.75 - 0.3 * collar.x);
    }
    if face.length() < 1.0 {
        color = skin * light(face);
        for side in [-1.0, 1.0] {
            let eye = (face - vec2(0.38 * side, -0.12)) / vec2(0.20, 0.09);
            if eye.length() < 1.0 {
                color = if eye.x.abs() < 0.42 {
                    vec3(0.06, 0.04, 0.03)
                } else {
                    vec3(0.72, 0.66, 0.58)
                };
            }
            let brow = (face - vec2(0.40 * side, -0.30)) / vec2(0.26, 0.05);
            if brow.length() < 1.0 {
                color = vec3(0.18, 0.10, 0.06);
            }
        }
        let nose = (face - vec2(0.06, 0.12)) / vec2(0.07, 0.26);
        if nose.length() < 1.0 {
            color *= 0.80;
        }
        let mouth = (face - vec2(0.0, 0.54)) / vec2(0.28, 0.06);
        if mouth.length() < 1.0 {
            color = vec3(0.48, 0.13, 0.10);
        }
    }
    color
}
