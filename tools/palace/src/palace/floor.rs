//! Paving: tiles and planks over a room's plan, clipped at its walls.

use super::room::PAVING;
use crate::envelope::{Plan, inwards};
use crate::shape::{Shape, clip};
use enfilade::MaterialId;
use enfilade_scenes::Random;
use glam::{Vec2, vec2, vec3};
use std::f64::consts::TAU;

/// A pattern with its size in metres and its materials.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Floor {
    /// Squares of two colors, set diagonally.
    Checker(f32, [MaterialId; 2]),
    /// Octagons of two colors, with small squares between them.
    Octagons(f32, [MaterialId; 3]),
    /// Herringbone planks: width of one, three kinds of wood.
    Herringbone(f32, [MaterialId; 3]),
    /// Framed square panels of planks that alternate in direction.
    Parquet(f32, [MaterialId; 3]),
    /// Tumbling blocks: rhombs of three colors.
    Cubes(f32, [MaterialId; 3]),
    /// Rings of petals around the middle of the room: width of a ring.
    Star(f32, [MaterialId; 3]),
    /// No pattern.
    Bare,
}

/// Paves a room: the pattern, and around it a border of the given material and width.
pub(crate) fn paving(plan: Plan, floor: Floor, border: MaterialId, width: f32) -> Shape {
    let outline = plan.corners();
    let region = inwards(&outline, width);
    let mut shape = Shape::new();
    let corner = |at: Vec2| vec3(at.x, PAVING, at.y);
    if matches!(floor, Floor::Bare) {
        return shape;
    }
    for i in 0..outline.len() {
        let next = (i + 1) % outline.len();
        // The plan is clockwise as seen from above, so the inner edge of the border comes first.
        let face = [outline[next], outline[i], region[i], region[next]].map(corner);
        shape.face(border, &face);
    }
    let mut lay = |material: MaterialId, tile: &[Vec2]| {
        let cut = clip(tile, &region);
        if cut.len() >= 3 {
            let places = hewn(tile, &cut);
            let face: Vec<_> = cut.into_iter().map(corner).collect();
            shape.placed(material, &face, &places);
        }
    };
    let middle = plan.center();
    let reach = region
        .iter()
        .fold(0.0, |most: f32, at| most.max(at.distance(middle)));
    match floor {
        Floor::Checker(side, colors) => {
            let diagonal = side * std::f32::consts::SQRT_2;
            let count = (reach / (0.5 * diagonal)) as i32 + 1;
            for row in -count..=count {
                for column in -count..=count {
                    if (row + column) % 2 != 0 {
                        continue;
                    }
                    let at = middle + 0.5 * diagonal * vec2(column as f32, row as f32);
                    lay(colors[row.rem_euclid(2) as usize], &diamond(at, 0.5 * diagonal));
                }
            }
        }
        Floor::Octagons(side, [even, odd, small]) => {
            let cut = 0.29 * side;
            let count = (reach / side) as i32 + 1;
            for row in -count..=count {
                for column in -count..=count {
                    let at = middle + side * vec2(column as f32, row as f32);
                    let large = if (row + column) % 2 == 0 { even } else { odd };
                    lay(large, &octagon(at, 0.5 * side, cut));
                    lay(small, &diamond(at + Vec2::splat(0.5 * side), cut));
                }
            }
        }
        Floor::Herringbone(width, woods) => herringbone(&mut lay, middle, reach, width, woods),
        Floor::Parquet(side, [dark, woods @ ..]) => parquet(&mut lay, middle, reach, side, dark, woods),
        Floor::Cubes(side, colors) => cubes(&mut lay, middle, reach, side, colors),
        Floor::Star(width, colors) => star(&mut lay, middle, reach, width, colors),
        Floor::Bare => {}
    }
    shape
}

/// Returns the texture coordinates of a clipped tile's corners. The grain runs along the tile's longest side, and the
/// tile's position selects its part of the texture.
fn hewn(tile: &[Vec2], cut: &[Vec2]) -> Vec<Vec2> {
    let count = tile.len();
    let side = |i: usize| tile[(i + 1) % count] - tile[i];
    let longest = (0..count).fold(0, |best, i| {
        if side(i).length_squared() > 1.001 * side(best).length_squared() {
            i
        } else {
            best
        }
    });
    let along = side(longest).normalize_or(Vec2::Y);
    let middle = tile.iter().sum::<Vec2>() / count as f32;
    let [x, z] = middle
        .to_array()
        .map(|value| (value * 64.0).round() as i64 as u64);
    let mut random = Random::new(x.wrapping_mul(0x1_0000_0001).wrapping_add(z));
    let [u, v] = [random.unit(), random.unit()].map(|part| 4.0 * part);
    cut.iter()
        .map(|&at| vec2(u + (at - middle).perp_dot(along), v + (at - middle).dot(along)))
        .collect()
}

/// Returns a rectangle between two corners, counter-clockwise as seen from above.
fn rectangle(from: Vec2, to: Vec2) -> [Vec2; 4] {
    [vec2(from.x, to.y), to, vec2(to.x, from.y), from]
}

fn diamond(at: Vec2, reach: f32) -> [Vec2; 4] {
    [
        vec2(0.0, reach),
        vec2(reach, 0.0),
        vec2(0.0, -reach),
        vec2(-reach, 0.0),
    ]
    .map(|corner| at + corner)
}

fn octagon(at: Vec2, reach: f32, cut: f32) -> [Vec2; 8] {
    let near = reach - cut;
    [(-near, reach), (near, reach), (reach, near), (reach, -near)]
        .into_iter()
        .chain([(near, -reach), (-near, -reach), (-reach, -near), (-reach, near)])
        .map(|(x, z)| at + vec2(x, z))
        .collect::<Vec<_>>()
        .try_into()
        .expect("eight corners")
}

type Lay<'a> = dyn FnMut(MaterialId, &[Vec2]) + 'a;

fn herringbone(lay: &mut Lay, middle: Vec2, reach: f32, width: f32, woods: [MaterialId; 3]) {
    const LONG: i32 = 5;
    // Planks of 1 by `LONG` widths on a grid rotated by 45°. A plank along x begins wherever (column - row) is 0 modulo
    // twice its length, and one along z ends beside it.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turned = |at: Vec2| middle + width * vec2(half * (at.x - at.y), half * (at.x + at.y));
    let count = (reach / width) as i32 + LONG + 1;
    for row in -count..=count {
        for column in -count..=count {
            let wood = woods[(7 * row + 3 * column).rem_euclid(11) as usize % 3];
            let at = vec2(column as f32, row as f32);
            let size = match (column - row).rem_euclid(2 * LONG) {
                0 => vec2(LONG as f32, 1.0),
                LONG => vec2(1.0, LONG as f32),
                _ => continue,
            };
            // Planks along z extend down from their corner, so that they meet the end of the plank above.
            let at = if size.y > 1.0 {
                at - vec2(0.0, size.y - 1.0)
            } else {
                at
            };
            lay(wood, &rectangle(at, at + size).map(turned));
        }
    }
}

fn parquet(lay: &mut Lay, middle: Vec2, reach: f32, side: f32, dark: MaterialId, woods: [MaterialId; 2]) {
    const PLANKS: i32 = 5;
    let count = (reach / side) as i32 + 1;
    let edge = 0.09 * side;
    for row in -count..=count {
        for column in -count..=count {
            let corner = middle + side * (vec2(column as f32, row as f32) - Vec2::splat(0.5));
            let [near, far] = [edge, side - edge].map(|inset| corner + Vec2::splat(inset));
            let end = corner + Vec2::splat(side);
            for frame in [
                rectangle(corner, vec2(end.x, near.y)),
                rectangle(vec2(corner.x, far.y), end),
                rectangle(vec2(corner.x, near.y), vec2(near.x, far.y)),
                rectangle(vec2(far.x, near.y), vec2(end.x, far.y)),
            ] {
                lay(dark, &frame);
            }
            let step = (far - near) / PLANKS as f32;
            for plank in 0..PLANKS {
                let [a, b] = [plank, plank + 1].map(|i| step * i as f32);
                let plank_at = if (row + column) % 2 == 0 {
                    rectangle(vec2(near.x + a.x, near.y), vec2(near.x + b.x, far.y))
                } else {
                    rectangle(vec2(near.x, near.y + a.y), vec2(far.x, near.y + b.y))
                };
                lay(woods[plank as usize % 2], &plank_at);
            }
        }
    }
}

fn cubes(lay: &mut Lay, middle: Vec2, reach: f32, side: f32, colors: [MaterialId; 3]) {
    let [low, high] = [0.5 * side, 0.5 * 3.0_f32.sqrt() * side];
    let count = (reach / side) as i32 + 2;
    for row in -count..=count {
        for column in -count..=count {
            let shift = if row % 2 == 0 { 0.0 } else { high };
            let at = middle + vec2(2.0 * high * column as f32 + shift, 1.5 * side * row as f32);
            let to = |x: f32, z: f32| at + vec2(x, z);
            let [down, up] = [to(0.0, side), to(0.0, -side)];
            let [east, west] = [to(high, low), to(-high, low)];
            let [north_east, north_west] = [to(high, -low), to(-high, -low)];
            lay(colors[0], &[at, north_east, up, north_west]);
            lay(colors[1], &[at, north_west, west, down]);
            lay(colors[2], &[at, down, east, north_east]);
        }
    }
}

fn star(lay: &mut Lay, middle: Vec2, reach: f32, width: f32, colors: [MaterialId; 3]) {
    const PETALS: usize = 32;
    let at = |ring: f32, petal: f32| {
        let (sin, cos) = (TAU * f64::from(petal) / PETALS as f64).sin_cos();
        middle + vec2(cos as f32, -sin as f32) * (ring * width)
    };
    let rings = (reach / width) as usize + 2;
    lay(
        colors[2],
        &(0..PETALS)
            .map(|petal| at(1.0, petal as f32 + 0.5))
            .collect::<Vec<_>>(),
    );
    for ring in 1..rings {
        for petal in 0..PETALS {
            let [near, far] = [ring as f32, ring as f32 + 1.0];
            let turn = petal as f32 + 0.5 * (ring % 2) as f32;
            let [a, b, c] = [at(near, turn), at(far, turn + 0.5), at(near, turn + 1.0)];
            lay(colors[ring % 3], &[a, b, c]);
            lay(colors[(ring + 1) % 3], &[b, at(far, turn + 1.5), c]);
        }
    }
}
