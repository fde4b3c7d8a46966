//! Cylinders and cones made of rectangles and triangles.

use super::{BLUE, Figure, GREEN, IVORY, ORANGE, RED, ROSE, TEAL, VIOLET, YELLOW};
use crate::BuiltIn;
use crate::camera::camera_with_fov;
use crate::shape::{Shape, around};
use enfilade::MaterialId;
use glam::{Vec3, vec3};

/// One turn of the wheel of hues for every eight sides.
const SIDES: [MaterialId; 8] = [TEAL, BLUE, VIOLET, ROSE, RED, ORANGE, YELLOW, GREEN];

/// Returns a regular polygon around the y axis, counter-clockwise as seen from above.
fn ring(sides: usize, radius: f32, y: f32) -> Vec<Vec3> {
    around(sides)
        .map(|at| vec3(radius * at.x, y, radius * at.y))
        .collect()
}

/// A closed cylinder: `sides` rectangles, a lid and a bottom. Both sorts are right.
///
/// It is tall and seen obliquely, so that the hidden faces have a farther nearest corner, and a farther mean, than the
/// faces that hide them. With a level eye, or a flat cylinder of many sides, the bottom's nearest corner would be
/// nearer than those of the silhouette faces, and minimal z wrong.
pub(crate) fn cylinder(sides: usize) -> BuiltIn {
    let [low, high] = [-1.25, 1.25].map(|y| ring(sides, 1.0, y));
    let mut figure = Figure::tilted(30.0);
    for i in 0..sides {
        let next = (i + 1) % sides;
        let side = [low[i], low[next], high[next], high[i]];
        figure.polygon(&format!("side {i}"), SIDES[i % SIDES.len()], &side);
    }
    figure.polygon("lid", IVORY, &high);
    figure.polygon("bottom", IVORY, &low.iter().rev().copied().collect::<Vec<_>>());
    figure.seen_from(vec![camera_with_fov(
        "front",
        [0.3, -0.5, 4.6],
        [0.0, 0.0, 0.0],
        42.0,
    )])
}

/// A cone on its tip: `sides` triangles and a base. Where the base is visible, both sorts are right.
///
/// From `base hidden`, a view that the thesis does not mention, minimal z is wrong: the base has the nearest corner of
/// all and is painted over the sides that hide it.
pub(crate) fn cone(sides: usize) -> BuiltIn {
    let tip = vec3(0.0, -1.3, 0.0);
    let base = ring(sides, 1.3, 1.0);
    let mut figure = Figure::tilted(40.0);
    for i in 0..sides {
        let side = [tip, base[(i + 1) % sides], base[i]];
        figure.polygon(&format!("side {i}"), SIDES[i % SIDES.len()], &side);
    }
    figure.polygon("base", IVORY, &base);
    figure.seen_from(vec![
        camera_with_fov("base seen", [0.3, -0.4, 4.0], [0.0, 0.05, 0.0], 42.0),
        camera_with_fov("base hidden", [0.3, -2.9, 3.3], [0.0, 0.25, 0.1], 42.0),
    ])
}

/// Four cylinders of sixty rectangles each, without lids: the 240 faces that the thesis measures.
///
/// They overlap on the screen. Some of their inside is visible, and both sorts are right.
pub(crate) fn four_cylinders() -> BuiltIn {
    const SIDES: usize = 60;
    let mut figure = Figure::new();
    for (name, color, [x, z], radius, height) in [
        ("left", TEAL, [-1.5, 0.3], 0.75, 1.9),
        ("front", ORANGE, [0.2, 1.6], 0.7, 1.3),
        ("right", ROSE, [1.7, 0.2], 0.8, 2.2),
        ("back", BLUE, [0.1, -1.6], 0.9, 2.9),
    ] {
        let place = vec3(x, 0.0, z);
        let [low, high] = [0.0, height].map(|y| ring(SIDES, radius, y));
        let mut tube = Shape::new();
        for i in 0..SIDES {
            let next = (i + 1) % SIDES;
            let side = [low[i], low[next], high[next], high[i]];
            tube.face(color, &side.map(|corner| corner + place));
        }
        figure.thing(name, &tube);
    }
    figure.seen_from(vec![camera_with_fov(
        "from above",
        [0.6, 3.0, 6.4],
        [0.1, 1.1, 0.0],
        42.0,
    )])
}
