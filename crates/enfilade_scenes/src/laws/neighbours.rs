//! Two faces that share an edge, and a third: a result for one of the two need not hold for the other.

use super::stage::{BLUE_SHEET, GREEN_SHEET, RED_SHEET, Stage, YELLOW_SHEET, alone, sheet};
use crate::BuiltIn;
use crate::camera::camera;
use crate::shape::Shape;
use glam::vec3;

/// Two wings that share a short edge, and a beam above it: one wing passes behind the beam, the other before it.
///
/// The beam does not meet the edge, so its position relative to one wing implies nothing for the other. It leans, so
/// that all of the first wing is behind its plane. Source: the counter-example to statement 3 of Boreskov, Hierarchical
/// s-buffer for scenes of high complexity.
pub(crate) fn wings() -> BuiltIn {
    let mut stage = Stage::new();
    let at = |x: f32, y: f32| vec3(x, y, 1.5 - 0.25 * y);
    let mut beam = Shape::new();
    beam.triangle(BLUE_SHEET, [at(-14.0, 7.5), at(14.0, 7.5), at(0.0, 10.0)]);
    stage.thing("beam", &beam);
    let [low, high] = [vec3(0.0, 0.0, 0.0), vec3(0.0, 2.0, 0.0)];
    let mut wings = Shape::new();
    wings.triangle(RED_SHEET, [low, high, vec3(-10.0, 10.0, -10.0)]);
    wings.triangle(RED_SHEET, [high, low, vec3(10.0, 10.0, 10.0)]);
    stage.thing("wings", &wings);
    alone(
        stage,
        vec![
            camera("front", [0.0, 5.0, 30.0], [0.0, 5.0, 0.0]),
            camera("below", [1.0, -6.0, 26.0], [0.0, 6.0, 0.0]),
            camera("back", [0.0, 5.0, -30.0], [0.0, 5.0, 0.0]),
        ],
    )
}

/// A floor of strips, and a board that passes through it along a seam; beside it a fin on another seam.
///
/// The board touches both strips of its seam, is behind one of them and before the other.
pub(crate) fn seams() -> BuiltIn {
    let mut stage = Stage::new();
    let mut floor = Shape::new();
    for strip in -4_i8..4 {
        let x = f32::from(strip);
        for row in -2_i8..2 {
            let z = f32::from(row);
            let corners = [[x, z + 1.0], [x + 1.0, z + 1.0], [x + 1.0, z], [x, z]];
            floor.face(YELLOW_SHEET, &corners.map(|[x, z]| vec3(x, 0.0, z)));
        }
    }
    let board = |material, x: f32, rise: f32| {
        sheet(
            material,
            vec3(x - 0.8, -rise, 1.5),
            vec3(1.6, 2.0 * rise, 0.0),
            vec3(0.0, 0.0, -3.0),
        )
    };
    stage.thing("early board", &board(RED_SHEET, -2.0, 0.4));
    stage.thing("floor", &floor);
    stage.thing("late board", &board(BLUE_SHEET, 2.0, -0.3));
    stage.thing(
        "fin",
        &sheet(
            GREEN_SHEET,
            vec3(0.0, 0.0, 1.0),
            vec3(0.0, 0.0, -2.0),
            vec3(0.0, 0.9, 0.0),
        ),
    );
    alone(
        stage,
        vec![
            camera("above", [0.3, 4.5, 3.0], [0.0, 0.0, 0.0]),
            camera("below", [0.5, -3.5, 3.5], [0.0, 0.0, 0.0]),
            camera("along", [-2.0, 0.6, 5.0], [-1.0, 0.0, 0.0]),
        ],
    )
}
