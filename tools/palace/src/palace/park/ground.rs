//! Terrain of the garden, and paving on it.
//!
//! A terrace along the walls, a bank down to a lawn with a basin, a knoll for the pavilion, a dry valley north of it.
//! At the edges it rises to hills that block view and movement.

use super::{AXIS, BASIN, BASIN_RADII, KNOLL};
use crate::palace::palette::MEADOW;
use crate::palace::room::Room;
use crate::shape::{Shape, clip};
use enfilade::{HeightField, MaterialId, Transform};
use glam::{Vec2, Vec3, vec2, vec3};
use std::sync::Arc;

/// Position of the first sample, their spacing, and their numbers from west to east and from north to south. The last
/// samples are within the walls.
const CORNER: Vec2 = vec2(-119.2, -176.2);
const CELL: f32 = 0.875;
const SAMPLES: [u32; 2] = [129, 97];

/// Height of the terrace, just above the foot of the walls, and of the lawn below it.
pub(super) const TERRACE: f32 = 0.04;
pub(super) const LAWN_LEVEL: f32 = -1.5;
/// Distances from the walls at which the bank begins and ends, in the east and in the south.
pub(super) const BANK: [[f32; 2]; 2] = [[17.0, 20.6], [9.0, 12.6]];
/// Height of the hills at the edges, and their width.
const HILLS: [f32; 2] = [10.8, 22.0];

/// Edges without walls, as end points.
const EDGES: [[Vec2; 2]; 4] = [
    [vec2(-119.2, -92.2), vec2(-70.0, -92.2)],
    [vec2(-119.2, -92.2), vec2(-119.2, -176.2)],
    [vec2(-119.2, -176.2), vec2(-7.2, -176.2)],
    [vec2(-7.2, -176.2), vec2(-7.2, -166.0)],
];

/// A height field and its triangles.
pub(super) struct Ground {
    field: Arc<HeightField>,
}

impl Ground {
    pub(super) fn new() -> Ground {
        let heights: Vec<f32> = (0..SAMPLES[1])
            .flat_map(|row| (0..SAMPLES[0]).map(move |column| vec2(column as f32, row as f32)))
            .map(|sample| relief(CORNER + CELL * sample))
            .collect();
        let cell = [f64::from(CELL); 2];
        let field = HeightField::new(SAMPLES, cell, heights).expect("a height for each sample");
        Ground {
            field: Arc::new(field),
        }
    }

    /// Adds the terrain to a room.
    pub(super) fn lay(&self, room: &mut Room) {
        let at = Transform::translation([CORNER.x, 0.0, CORNER.y]);
        room.ground(Arc::clone(&self.field), MEADOW, at);
    }

    /// Returns the height of the ground at (x, z).
    pub(super) fn height(&self, at: Vec2) -> f32 {
        let most = vec2(SAMPLES[0] as f32 - 1.001, SAMPLES[1] as f32 - 1.001);
        let on_grid = ((at - CORNER) / CELL).clamp(Vec2::ZERO, most);
        let [column, row] = on_grid.floor().to_array().map(|value| value as u32);
        let Vec2 { x, y } = on_grid.fract();
        let height = |right: u32, down: u32| self.field.position(column + right, row + down)[1];
        let [north_east, south_west] = [height(1, 0), height(0, 1)];
        if x + y <= 1.0 {
            let north_west = height(0, 0);
            north_west + (north_east - north_west) * x + (south_west - north_west) * y
        } else {
            let south_east = height(1, 1);
            south_east + (south_west - south_east) * (1.0 - x) + (north_east - south_east) * (1.0 - y)
        }
    }

    /// Returns a point on the ground.
    pub(super) fn on(&self, at: Vec2) -> Vec3 {
        vec3(at.x, self.height(at), at.y)
    }

    /// Projects a convex polygon of the plan onto the ground, raised by `over`.
    pub(super) fn laid(&self, material: MaterialId, outline: &[Vec2], over: f32) -> Shape {
        let least = outline.iter().copied().fold(Vec2::INFINITY, Vec2::min);
        let most = outline.iter().copied().fold(Vec2::NEG_INFINITY, Vec2::max);
        let cells = vec2(SAMPLES[0] as f32 - 1.0, SAMPLES[1] as f32 - 1.0);
        let first = ((least - CORNER) / CELL).floor().clamp(Vec2::ZERO, cells);
        let last = ((most - CORNER) / CELL).ceil().clamp(Vec2::ZERO, cells);
        let mut shape = Shape::new();
        for row in first.y as u32..last.y as u32 {
            for column in first.x as u32..last.x as u32 {
                let corner = |right: u32, down: u32| {
                    let [x, y, z] = self.field.position(column + right, row + down);
                    vec3(CORNER.x + x, y, CORNER.y + z)
                };
                let [nw, ne, sw, se] = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
                for triangle in [[nw, sw, ne], [ne, sw, se]] {
                    let part = clip(&triangle.map(|at| vec2(at.x, at.z)), outline);
                    if part.len() < 3 {
                        continue;
                    }
                    let up = |at: &Vec2| vec3(at.x, plane_at(triangle, *at) + over, at.y);
                    shape.face(material, &part.iter().map(up).collect::<Vec<_>>());
                }
            }
        }
        shape
    }
}

/// Returns the height of the plane through three points at a plan position.
fn plane_at([a, b, c]: [Vec3; 3], at: Vec2) -> f32 {
    let normal = (b - a).cross(c - a);
    a.y - (normal.x * (at.x - a.x) + normal.z * (at.y - a.z)) / normal.y
}

/// Returns the distance to the nearest edge without a wall.
pub(super) fn to_the_edge(at: Vec2) -> f32 {
    let to = |[from, to]: [Vec2; 2]| {
        let along = to - from;
        let part = ((at - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        at.distance(from + along * part)
    };
    EDGES.into_iter().map(to).fold(f32::INFINITY, f32::min)
}

/// Returns the distance from the middle of the basin, relative to the distance of its edge.
pub(super) fn to_the_basin(at: Vec2) -> f32 {
    ((at - BASIN) / BASIN_RADII).length()
}

/// Returns the designed height at (x, z), before it is sampled.
fn relief(at: Vec2) -> f32 {
    let [west, north] = [-7.45 - at.x, -92.45 - at.y];
    let below = rise(BANK[0][0], BANK[0][1], west) * rise(BANK[1][0], BANK[1][1], north);
    let mut height = TERRACE + (LAWN_LEVEL - TERRACE) * below;
    let knoll = 1.0 - rise(9.0, 24.0, at.distance(KNOLL));
    // The lawn is flat along the axis, and undulates beside it.
    let wild = below * rise(12.0, 24.0, (at.y - AXIS).abs()) * (1.0 - knoll);
    height += wild * 0.55 * ((0.19 * at.x + 0.6).sin() * (0.16 * at.y).sin() + (0.11 * (at.x - at.y)).sin());
    // A dry valley, bending north.
    let bed = AXIS - 29.0 + 5.0 * (0.07 * (at.x + 60.0)).sin();
    let valley = (-((at.y - bed) / 6.5).powi(2)).exp() * rise(24.0, 38.0, west);
    height -= 2.2 * valley * below * (1.0 - knoll);
    height += 3.4 * knoll;
    height -= 1.5 * below * (1.0 - rise(0.80, 1.0, to_the_basin(at)));
    let edge = to_the_edge(at);
    let hill = 1.0 - rise(0.0, HILLS[1], edge);
    let uneven = 1.0 + 0.16 * (0.13 * at.x).sin() + 0.16 * (0.17 * at.y + 1.0).sin();
    height + HILLS[0] * hill * uneven
}

/// Smoothstep: 0 up to `from`, 1 from `to` on.
fn rise(from: f32, to: f32, value: f32) -> f32 {
    let part = ((value - from) / (to - from)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Dress;

    #[test]
    fn nobody_walks_over_the_edge_and_walls_stand_in_the_ground() {
        let ground = Ground::new();
        for [from, to] in EDGES {
            for step in 0..=100 {
                let at = from.lerp(to, step as f32 / 100.0);
                assert!(ground.height(at) > 6.5, "{at}: {}", ground.height(at));
            }
        }
        for step in 0..=200 {
            let part = step as f32 / 200.0;
            let east = vec2(-7.45, -92.45).lerp(vec2(-7.45, -162.0), part);
            let south = vec2(-7.45, -92.45).lerp(vec2(-66.0, -92.45), part);
            for at in [east, south] {
                assert!(ground.height(at) >= TERRACE, "{at}: {}", ground.height(at));
            }
        }
    }

    #[test]
    fn what_is_laid_on_it_is_as_high_as_it_is() {
        let ground = Ground::new();
        for at in [vec2(-30.3, -110.2), vec2(-80.0, -150.7), vec2(-110.0, -100.0)] {
            let outline = [vec2(-0.2, 0.3), vec2(0.4, 0.2), vec2(0.1, -0.4)].map(|off| at + off);
            let laid = ground.laid(MEADOW, &outline, 0.0).dressed(|_| Dress::Smooth);
            assert!(!laid.positions().is_empty());
            for &[x, y, z] in laid.positions() {
                assert!((y - ground.height(vec2(x, z))).abs() < 1e-4);
            }
        }
    }
}
