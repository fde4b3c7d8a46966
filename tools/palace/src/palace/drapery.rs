//! Curtains, swags and carpets.

use super::palette::{
    BLUE_CURTAIN, BLUE_RUG, GREEN_CURTAIN, GREEN_RUG, LACE, RED_CURTAIN, RED_RUG, ROSE_RUG, YELLOW_RUG,
};
use super::textures::BORDER;
use super::workshop::Workshop;
use crate::shape::{Shape, around, cloth as hang, loft};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec2, Vec3, vec2, vec3};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// Texture coordinates of cloth, for positions in metres across it and above its hem. Lace is uniform; curtains have a
/// hem 4 m below their upper edge and repeat every half metre.
fn woven(cloth: MaterialId, across: f32, up: f32) -> Vec2 {
    if cloth == LACE {
        vec2(across, -up)
    } else {
        vec2(2.0 * across, 1.0 - 0.25 * up)
    }
}

/// Half the depth of the folds of heavy cloth and of lace.
const FOLD: f32 = 0.034;
const LACE_FOLD: f32 = 0.016;

/// Radius of curtain rods.
const ROD: f32 = 0.02;

/// Distance in z from the axis of a rod back to that of the thin one for lace.
const TO_LACE: f32 = 0.075;

/// Length of a rod beyond the cloth on either side, with its finial.
pub(crate) const ROD_END: f32 = 0.155;

/// Layers in front of a wall, from the architrave's face out: lace, and curtains under the rod. Each has room for its
/// folds, so that no layer meets the next.
pub(crate) const ROD_STAND: f32 = 0.2;
pub(crate) const LACE_STAND: f32 = ROD_STAND - TO_LACE;

/// A curtain gathered to one side by a cord: it hangs from `wide` metres of rod, its tied edge at x = 0, the free one
/// at x = `wide`, its folds on both sides of z = 0. In wall coordinates.
pub(crate) fn curtain(
    shop: &mut Workshop,
    wide: f32,
    high: f32,
    cloth: MaterialId,
    cord: MaterialId,
) -> Arc<Mesh> {
    shop.piece(format!("curtain {wide} {high} {} {}", cloth.0, cord.0), || {
        const FOLDS: f32 = 6.0;
        const DOWN: usize = 16;
        let tie = 0.4;
        let (most, steps) = if cloth == LACE {
            (LACE_FOLD, 36)
        } else {
            (FOLD, 48)
        };
        let breadth = |up: f32| {
            // Full width at the rod, a fifth at the cord, a little wider at the floor.
            let off = if up > tie {
                ((up - tie) / (1.0 - tie)).powf(1.6)
            } else {
                0.25 * ((tie - up) / tie).powf(0.7)
            };
            wide * (0.22 + 0.78 * off)
        };
        // Fold depth limited for the width: deeper folds would show their dark sides.
        let deep = |breadth: f32| (0.008 + 0.2 * breadth / FOLDS).min(most);
        let point = |across: usize, down: usize| -> Vec3 {
            let [u, v] = [across as f32 / steps as f32, down as f32 / DOWN as f32];
            let breadth = breadth(1.0 - v);
            vec3(
                u * breadth,
                high * (1.0 - v),
                deep(breadth) * (TAU * FOLDS * u + 0.8 * v).cos(),
            )
        };
        let place = |across: usize, down: usize| {
            let [u, v] = [across as f32 / steps as f32, down as f32 / DOWN as f32];
            // 1.5 times as wide as the rod, which makes the folds.
            woven(cloth, 1.5 * wide * u, high * (1.0 - v))
        };
        let columns: Vec<Vec<_>> = (0..=steps)
            .map(|across| {
                let corner = |down| (point(across, down), place(across, down));
                (0..=DOWN).rev().map(corner).collect()
            })
            .collect();
        let mut shape = hang(cloth, &columns);
        let gathered = breadth(tie);
        let half = [0.5 * gathered, deep(gathered)];
        shape.add(
            &loop_around(cord, half),
            Transform::translation([half[0], tie * high, 0.0]),
        );
        shape
    })
}

/// A band of cord around a bundle of cloth of this half width and half depth.
fn loop_around(cord: MaterialId, [wide, deep]: [f32; 2]) -> Shape {
    const SIDES: usize = 28;
    const BAND: [[f32; 2]; 6] = [
        [-0.012, -0.03],
        [0.010, -0.03],
        [0.018, -0.02],
        [0.018, 0.02],
        [0.010, 0.03],
        [-0.012, 0.03],
    ];
    // Flattened circles contain the corners of the bundle where ellipses would not.
    let flattened = |value: f32| value.signum() * value.abs().sqrt();
    let rings: Vec<Vec<Vec3>> = BAND
        .iter()
        .map(|&[out, up]| {
            around(SIDES)
                .map(|at| {
                    let [x, z] = [flattened(at.x), flattened(at.y)];
                    vec3((wide + out) * x, up, (deep + out) * z)
                })
                .collect()
        })
        .collect();
    metal(cord, &rings)
}

/// Creates the surface through rings of metal or cord. Where only alpha-tested materials may be, it is the gold braid of
/// a curtain.
fn metal(material: MaterialId, rings: &[Vec<Vec3>]) -> Shape {
    const BRAID: f32 = 0.11;
    if ![RED_CURTAIN, GREEN_CURTAIN, BLUE_CURTAIN].contains(&material) {
        return loft(material, rings);
    }
    let place = [0.20, 0.25, 0.30].map(|across| woven(material, across, BRAID));
    let mut shape = Shape::new();
    for pair in rings.windows(2) {
        let [below, above] = [&pair[0], &pair[1]];
        for i in 0..below.len() {
            let next = (i + 1) % below.len();
            shape.placed(material, &[below[i], below[next], above[next]], &place);
            shape.placed(material, &[below[i], above[next], above[i]], &place);
        }
    }
    shape
}

/// A block between two corners, as [`metal`].
fn bar(material: MaterialId, low: [f32; 3], high: [f32; 3]) -> Shape {
    let tip = |z: f32| vec![vec3(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), z); 4];
    let ring = |z: f32| {
        [[0, 0], [1, 0], [1, 1], [0, 1]]
            .map(|[x, y]| vec3([low[0], high[0]][x], [low[1], high[1]][y], z))
            .to_vec()
    };
    let [back, front] = [low[2], high[2]];
    metal(material, &[tip(back), ring(back), ring(front), tip(front)])
}

/// A surface of revolution about the x axis, of (radius, x), as [`metal`].
fn turned(material: MaterialId, profile: &[[f32; 2]], sides: usize) -> Shape {
    let rings: Vec<Vec<Vec3>> = profile
        .iter()
        .map(|&[radius, x]| {
            around(sides)
                .map(|at| vec3(x, radius * at.x, radius * -at.y))
                .collect()
        })
        .collect();
    metal(material, &rings)
}

/// Swags over a window: `count` arcs of cloth over a rod, with brackets to the wall, `stand` behind its axis. The left
/// end of the cloth is at the origin.
pub(crate) fn swags(
    shop: &mut Workshop,
    wide: f32,
    count: usize,
    stand: f32,
    cloth: MaterialId,
    gilt: MaterialId,
) -> Arc<Mesh> {
    shop.piece(format!("swags {wide} {count} {stand} {}", cloth.0), || {
        const ACROSS: usize = 10;
        const DOWN: usize = 7;
        /// Rows that lead over the rod to its front: height and distance in front of its axis.
        const OVER: [[f32; 2]; 2] = [[0.024, -0.006], [0.02, 0.03]];
        let step = wide / count as f32;
        let mut shape = Shape::new();
        for bow in 0..count {
            let corner = |across: usize, row: usize| -> (Vec3, Vec2) {
                let u = across as f32 / ACROSS as f32;
                let x = step * (bow as f32 + u);
                let Some(down) = row.checked_sub(OVER.len()) else {
                    let [up, out] = OVER[row];
                    return (vec3(x, up, out), woven(cloth, 1.2 * step * u, 0.5 + up));
                };
                let v = down as f32 / DOWN as f32;
                let sag = (PI * u).sin();
                // Clear of the folds of the curtains below.
                let folds = 0.5 - 0.5 * (2.0 * TAU * v).cos();
                let out = FOLD + 0.012 + 0.02 * v + 0.028 * sag * folds;
                let at = vec3(x, -0.52 * sag * v - 0.13 * v * (1.0 - sag), out);
                (at, woven(cloth, 1.2 * step * u, 0.5 * (1.0 - v)))
            };
            let columns: Vec<Vec<_>> = (0..=ACROSS)
                .map(|across| {
                    (0..=OVER.len() + DOWN)
                        .rev()
                        .map(|row| corner(across, row))
                        .collect()
                })
                .collect();
            shape.join(hang(cloth, &columns));
        }
        rod(&mut shape, wide, stand, gilt);
        shape
    })
}

/// A rod along x for `wide` metres of cloth, with finials and brackets beside it, and a thin rod for lace behind it if
/// there is room.
fn rod(shape: &mut Shape, wide: f32, stand: f32, gilt: MaterialId) {
    const FINIAL: [[f32; 2]; 9] = [
        [ROD, 0.0],
        [ROD, 0.07],
        [0.03, 0.072],
        [0.03, 0.08],
        [0.016, 0.086],
        [0.032, 0.105],
        [0.034, 0.122],
        [0.02, 0.146],
        [0.0, ROD_END],
    ];
    let left = FINIAL.iter().rev().map(|&[out, along]| [out, -along]);
    let right = FINIAL.iter().map(|&[out, along]| [out, wide + along]);
    let profile: Vec<[f32; 2]> = left.chain(right).collect();
    shape.join(turned(gilt, &profile, 14));
    for x in [-0.045, wide + 0.045] {
        shape.join(bar(gilt, [x - 0.01, -0.014, -stand], [x + 0.01, 0.014, 0.0]));
        let plate = [x - 0.024, -0.06, -stand];
        shape.join(bar(gilt, plate, [x + 0.024, 0.06, 0.014 - stand]));
    }
    if stand > TO_LACE {
        let thin = [
            [0.0, -0.045],
            [0.007, -0.045],
            [0.007, wide + 0.045],
            [0.0, wide + 0.045],
        ];
        let behind = Transform::translation([0.0, 0.0, -TO_LACE]);
        shape.add(&turned(gilt, &thin, 8), behind);
    }
}

/// The rug colors: red, blue, green, rose, yellow.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Rug {
    Red,
    Blue,
    Green,
    Rose,
    Yellow,
}

/// A carpet, `wide` along x, with fringes at both ends of its length along z: a border of fixed width, and as many
/// figures in the field as fit.
pub(crate) fn carpet(shop: &mut Workshop, [wide, long]: [f32; 2], rug: Rug) -> Arc<Mesh> {
    let material = match rug {
        Rug::Red => RED_RUG,
        Rug::Blue => BLUE_RUG,
        Rug::Green => GREEN_RUG,
        Rug::Rose => ROSE_RUG,
        Rug::Yellow => YELLOW_RUG,
    };
    shop.piece(format!("carpet {wide} {long} {}", material.0), || {
        const THICK: f32 = 0.012;
        let [columns, rows] = [stops(wide), stops(long)];
        let mut shape = Shape::new();
        for across in columns.windows(2) {
            for along in rows.windows(2) {
                let corners = [(0, 1), (1, 1), (1, 0), (0, 0)].map(|(i, j)| (across[i], along[j]));
                let at = corners.map(|((x, _), (z, _))| vec3(x, THICK, z));
                shape.placed(material, &at, &corners.map(|((_, u), (_, v))| vec2(u, v)));
            }
        }
        shape
    })
}

/// Returns the section boundaries of a rug along one side, relative to its middle, with their texture coordinates: the
/// border is in the texture's first half; the field repeats the second half, mirrored in turn.
fn stops(length: f32) -> Vec<(f32, f32)> {
    const FIGURE: f32 = 2.0;
    // Keeps off the texels where the border's colors blend into the field.
    const FIELD: f32 = 0.52;
    let half = 0.5 * length;
    let inner = half - BORDER;
    let quarters = 2 * (2.0 * inner / FIGURE).round().max(1.0) as usize;
    let mut stops = vec![(-half, 0.0)];
    stops.extend((0..=quarters).map(|i| {
        let at = inner * (2.0 * i as f32 / quarters as f32 - 1.0);
        (at, if i % 2 == 0 { FIELD } else { 1.0 })
    }));
    stops.push((half, 0.0));
    stops
}
