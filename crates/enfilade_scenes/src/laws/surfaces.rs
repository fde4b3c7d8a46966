//! Difficult faces: intersecting, coplanar, seen from behind, without area.

use super::stage::{
    BLUE, BLUE_GLASS, BLUE_SHEET, BROWN, Doorway, GREEN, GREEN_SHEET, GREY, LEAF, RED, RED_GLASS, RED_SHEET,
    Stage, WHITE, YELLOW, YELLOW_SHEET, alone, joined, sheet,
};
use crate::BuiltIn;
use crate::camera::camera;
use crate::envelope::Side;
use crate::random::Random;
use crate::shape::{Shape, around, ball, block, cuboid, prism, taper};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec2, Vec3, vec2, vec3};
use std::sync::Arc;

/// Adds a floor of 12 by 12 units.
fn floor(stage: &mut Stage) {
    stage.thing(
        "floor",
        &sheet(
            GREY,
            vec3(-6.0, 0.0, 6.0),
            vec3(12.0, 0.0, 0.0),
            vec3(0.0, 0.0, -12.0),
        ),
    );
}

/// Items that no back-to-front order draws correctly.
///
/// On the left two sheets intersect; in the middle three long boxes overlap cyclically; on the right two boxes and a
/// ball overlap in volume.
pub(crate) fn crossing() -> BuiltIn {
    let mut stage = Stage::new();
    floor(&mut stage);
    stage.thing(
        "red sheet",
        &sheet(
            RED_SHEET,
            vec3(-4.5, 0.2, -1.0),
            vec3(2.0, 0.0, 2.0),
            vec3(0.0, 2.0, 0.0),
        ),
    );
    stage.thing(
        "blue sheet",
        &sheet(
            BLUE_SHEET,
            vec3(-4.5, 0.2, 1.0),
            vec3(2.0, 0.0, -2.0),
            vec3(0.0, 2.0, 0.0),
        ),
    );
    let bar = |material: MaterialId| block(material, [-1.3, -0.15, -0.15], [1.3, 0.15, 0.15]);
    for (i, (name, material)) in [("first", RED), ("second", GREEN), ("third", BLUE)]
        .into_iter()
        .enumerate()
    {
        let turn = i as f64 * 2.0 * std::f64::consts::PI / 3.0;
        // A side of a triangle, tilted so that one end is before its neighbour and the other behind it.
        let place = Transform::translation([0.0, 1.4, 0.0])
            * Transform::rotation([0.0, 0.0, 1.0], turn)
            * Transform::translation([0.0, -0.45, 0.0])
            * Transform::rotation([0.0, 1.0, 0.0], 0.35);
        stage.placed(name, &bar(material), place);
    }
    stage.thing("box", &block(YELLOW, [2.6, 0.2, -0.8], [4.2, 1.4, 0.8]));
    let turned = Transform::translation([3.4, 0.2, 0.0]) * Transform::rotation([0.0, 1.0, 0.0], 0.785);
    stage.placed("turned box", &cuboid(BROWN, [1.5, 1.0, 1.5]), turned);
    stage.placed(
        "ball",
        &ball(RED, 0.8, 10, 14),
        Transform::translation([3.4, 1.3, 0.2]),
    );
    alone(
        stage,
        vec![
            camera("sheets", [-3.4, 1.6, 4.5], [-3.5, 1.2, 0.0]),
            camera("cycle", [0.1, 1.5, 4.5], [0.0, 1.4, 0.0]),
            camera("solids", [5.2, 2.2, 4.2], [3.4, 0.8, 0.0]),
            camera("all", [0.0, 2.6, 7.5], [0.0, 1.0, 0.0]),
        ],
    )
}

/// Coplanar faces of different items.
///
/// Pictures coincide with a wall, one over a corner of another; a box of height zero is on the floor; two equal boxes
/// have the same position; a rug is slightly above the floor.
pub(crate) fn coplanar() -> BuiltIn {
    let mut stage = Stage::new();
    floor(&mut stage);
    let on_wall = |x: f32, y: f32, wide: f32, high: f32, material: MaterialId| {
        sheet(
            material,
            vec3(x, y, -3.0),
            vec3(wide, 0.0, 0.0),
            vec3(0.0, high, 0.0),
        )
    };
    // At equal depth the item added first wins: one picture comes before the wall.
    stage.thing("red picture", &on_wall(-3.0, 1.0, 1.6, 1.2, RED));
    stage.thing("wall", &on_wall(-4.0, 0.0, 8.0, 4.0, WHITE));
    stage.thing("blue picture", &on_wall(-1.8, 1.6, 1.6, 1.2, BLUE));
    stage.thing("green picture", &on_wall(1.0, 1.0, 2.0, 2.0, GREEN));
    stage.thing("stamp", &on_wall(1.5, 1.5, 0.5, 0.5, YELLOW));
    stage.thing("flat box", &block(RED_SHEET, [-2.5, 0.0, -0.5], [-1.0, 0.0, 1.0]));
    stage.thing(
        "rug",
        &sheet(
            BLUE,
            vec3(0.5, 1e-5, 1.5),
            vec3(2.0, 0.0, 0.0),
            vec3(0.0, 0.0, -2.0),
        ),
    );
    for name in ["twin", "other twin"] {
        stage.thing(name, &block(BROWN, [3.0, 0.0, -1.5], [3.8, 1.0, -0.7]));
    }
    stage.thing("plinth", &block(GREEN, [-3.8, 0.0, -3.0], [-3.3, 0.8, -2.0]));
    alone(
        stage,
        vec![
            camera("wall", [0.0, 1.8, 3.0], [0.0, 1.8, -3.0]),
            camera("aslant", [4.5, 1.4, -1.6], [-1.0, 1.4, -3.0]),
            camera("floor", [0.0, 2.5, 4.0], [0.0, 0.0, 0.0]),
            camera("from above", [0.0, 5.0, 0.2], [0.0, 0.0, 0.0]),
        ],
    )
}

/// Alpha-blended panes and alpha-tested leaves, which are never occluders.
///
/// Panes are before a ball and behind it, and intersect each other; a pane behind the wall is hidden; leaves are before
/// a box; a pane is before the door to a second room, and another just behind it.
pub(crate) fn glass() -> BuiltIn {
    let door = Doorway {
        name: "door",
        side: Side::North,
        plane: -3.0,
        along: [1.0, 2.4],
        up: [0.0, 2.2],
    };
    let [mut near, mut far] = [Stage::new(), Stage::new()];
    let out = near.room([-4.0, 4.0], [-2.9, 4.0], 3.2, &[door])[0];
    let back = far.room([-4.0, 4.0], [-7.0, -3.1], 3.2, &[door.other_side()])[0];
    let pane = |material: MaterialId, x: f32, z: f32, wide: f32| {
        sheet(
            material,
            vec3(x, 0.3, z),
            vec3(wide, 0.0, 0.0),
            vec3(0.0, 2.0, 0.0),
        )
    };
    near.thing("front pane", &pane(BLUE_GLASS, -2.6, 0.6, 1.4));
    near.placed(
        "ball",
        &ball(RED, 0.5, 10, 14),
        Transform::translation([-1.6, 1.2, -0.4]),
    );
    near.thing("back pane", &pane(RED_GLASS, -2.0, -1.4, 1.4));
    near.thing(
        "crossing pane",
        &sheet(
            RED_GLASS,
            vec3(-2.4, 0.5, 1.2),
            vec3(1.0, 0.0, -1.2),
            vec3(0.0, 1.6, 0.0),
        ),
    );
    near.thing("box", &block(BROWN, [-0.3, 0.0, -2.2], [0.5, 1.4, -1.4]));
    let mut random = Random::new(3);
    let mut leaves = Shape::new();
    for _ in 0..40 {
        let at = vec3(0.1, 1.1, -0.6) + Vec3::from(random.point(0.5));
        let [a, b] = [random.point(0.16), random.point(0.16)].map(Vec3::from);
        leaves.triangle(LEAF, [at, at + a, at + b]);
    }
    near.thing("leaves", &leaves);
    near.thing("door pane", &pane(BLUE_GLASS, 0.9, -2.6, 1.6));
    near.thing("hidden pane", &pane(RED_GLASS, -3.5, -2.95, 1.0));
    far.thing("pane behind the door", &pane(RED_GLASS, 1.2, -3.3, 0.7));
    far.placed(
        "green ball",
        &ball(GREEN, 0.6, 10, 14),
        Transform::translation([1.8, 1.0, -5.4]),
    );
    joined(
        (near, out),
        (far, back),
        vec![
            camera("all", [0.0, 1.6, 3.6], [0.0, 1.2, -2.0]),
            camera("panes", [-1.8, 1.5, 2.6], [-1.8, 1.2, -1.0]),
            camera("leaves", [0.4, 1.4, 1.0], [0.1, 1.0, -2.0]),
            camera("door", [1.6, 1.5, 0.4], [1.7, 1.2, -4.0]),
            camera("way back", [2.0, 1.5, -6.4], [1.4, 1.2, 0.0]),
        ],
    )
}

/// Faces seen from behind.
///
/// Boxes are behind the backs of one-sided sheets, and visible; a box with inverted winding shows its far walls; a box
/// and its mirror image, made by a negative scale, both face outwards; half a box is open to the eye.
pub(crate) fn one_sided() -> BuiltIn {
    let mut stage = Stage::new();
    floor(&mut stage);
    let up = vec3(0.0, 1.6, 0.0);
    stage.thing(
        "front",
        &sheet(RED, vec3(-5.0, 0.2, 1.0), vec3(1.4, 0.0, 0.0), up),
    );
    stage.thing(
        "back",
        &sheet(BLUE, vec3(-1.8, 0.2, 1.0), vec3(-1.4, 0.0, 0.0), up),
    );
    for x in [-4.6, -2.8] {
        stage.placed(
            "behind a sheet",
            &cuboid(YELLOW, [0.7, 1.2, 0.7]),
            Transform::translation([x, 0.0, -0.5]),
        );
    }
    stage.placed(
        "inside out",
        &cuboid(GREEN, [1.2, 1.2, 1.2]).flipped(),
        Transform::translation([-0.5, 0.2, 0.0]),
    );
    let wedge = prism(
        BROWN,
        &[vec3(0.0, 0.0, 0.0), vec3(0.0, 0.0, 0.9), vec3(0.9, 0.0, 0.0)],
        vec3(0.0, 1.0, 0.0),
    );
    stage.placed("wedge", &wedge, Transform::translation([1.8, 0.2, 0.0]));
    let mirrored = Transform::translation([1.6, 0.2, 0.0]) * Transform::scaling([-1.0, 1.0, 1.0]);
    stage.placed("mirrored wedge", &wedge, mirrored);
    let thrice = Transform::translation([2.4, 1.8, 0.4]) * Transform::scaling([-0.6, -0.6, -0.6]);
    stage.placed("wedge mirrored thrice", &wedge, thrice);
    let mut half = Shape::new();
    half.face(
        RED,
        &[
            vec3(3.6, 0.2, -0.6),
            vec3(4.8, 0.2, -0.6),
            vec3(4.8, 1.6, -0.6),
            vec3(3.6, 1.6, -0.6),
        ],
    );
    half.face(
        GREEN,
        &[
            vec3(3.6, 0.2, 0.6),
            vec3(3.6, 0.2, -0.6),
            vec3(3.6, 1.6, -0.6),
            vec3(3.6, 1.6, 0.6),
        ],
    );
    half.face(
        BLUE,
        &[
            vec3(4.8, 0.2, 0.6),
            vec3(4.8, 1.6, 0.6),
            vec3(4.8, 1.6, -0.6),
            vec3(4.8, 0.2, -0.6),
        ],
    );
    stage.thing("half a box", &half);
    alone(
        stage,
        vec![
            camera("all", [0.0, 2.0, 7.0], [0.0, 0.9, 0.0]),
            camera("from the other side", [0.0, 2.0, -7.0], [0.0, 0.9, 0.0]),
            camera("sheets", [-3.4, 1.4, 3.4], [-3.4, 0.9, 0.0]),
            camera("wedges", [1.8, 2.2, 3.2], [1.8, 0.9, 0.2]),
            camera("edge on", [-6.0, 1.0, 1.0], [0.0, 1.0, 1.0]),
        ],
    )
}

/// Degenerate faces.
///
/// Triangles with collinear or equal corners, duplicate faces, slivers a millionth wide, needles a thousand times
/// longer than wide; items scaled flat, or to a point; an item without faces. Boxes behind and beside them are visible
/// as if they did not exist.
pub(crate) fn degenerate() -> BuiltIn {
    let mut stage = Stage::new();
    floor(&mut stage);
    for (i, material) in [RED, GREEN, BLUE].into_iter().enumerate() {
        let at = Transform::translation([-2.0 + 2.0 * i as f32, 0.0, -1.5]);
        stage.placed("box", &cuboid(material, [0.9, 1.3, 0.9]), at);
    }
    let mesh = |points: &[[f32; 3]]| -> Arc<Mesh> {
        let corners: Vec<u32> = (0..points.len() as u32).collect();
        Arc::new(Mesh::triangles(points, &corners, YELLOW_SHEET).expect("triangles may have no area"))
    };
    let on_a_line = [[-2.5, 0.5, 0.0], [-1.5, 1.0, 0.0], [-0.5, 1.5, 0.0]];
    let in_a_point = [[0.0, 0.8, 0.0]; 3];
    let two_alike = [[0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [1.5, 1.4, 0.0]];
    let without_area: Vec<[f32; 3]> = [on_a_line, in_a_point, two_alike].concat();
    stage.copies("without area", &mesh(&without_area), [Transform::IDENTITY]);
    let once = [[1.8, 0.3, 0.2], [2.8, 0.3, 0.2], [2.3, 1.2, 0.2]];
    stage.copies(
        "twice the same face",
        &mesh(&[once, once].concat()),
        [Transform::IDENTITY; 2],
    );
    let slivers: Vec<[f32; 3]> = (0..12)
        .flat_map(|i| {
            let x = -2.8 + 0.4 * i as f32;
            [
                [x, 0.2, 0.4],
                [x + 1e-6 * (1 << i) as f32, 0.2, 0.4],
                [x + 0.1, 1.6, 0.4],
            ]
        })
        .collect();
    stage.copies("slivers", &mesh(&slivers), [Transform::IDENTITY]);
    let needles: Vec<[f32; 3]> = (0..9)
        .flat_map(|i| {
            let y = 0.2 + 0.15 * i as f32;
            [
                [-3.0, y, 0.8],
                [3.0, y + 0.06, 0.8 - 0.1 * i as f32],
                [-3.0, y + 0.003, 0.8],
            ]
        })
        .collect();
    stage.copies("needles", &mesh(&needles), [Transform::IDENTITY]);
    let flat = Transform::translation([-3.5, 0.4, 0.0]) * Transform::scaling([1.0, 1.0, 0.0]);
    stage.placed("flattened", &cuboid(RED_SHEET, [0.8, 1.0, 0.8]), flat);
    let point = Transform::translation([3.4, 0.8, 0.0]) * Transform::scaling([0.0; 3]);
    stage.placed("shrunk to a point", &cuboid(GREEN_SHEET, [0.8, 1.0, 0.8]), point);
    let line = Transform::translation([3.8, 0.4, 0.0]) * Transform::scaling([0.0, 1.0, 0.0]);
    stage.placed("shrunk to a line", &cuboid(BLUE_SHEET, [0.8, 1.0, 0.8]), line);
    stage.copies(
        "nothing",
        &Arc::new(Mesh::new(&[]).expect("nothing is sound")),
        [Transform::IDENTITY],
    );
    alone(
        stage,
        vec![
            camera("front", [0.0, 1.2, 4.5], [0.0, 0.8, 0.0]),
            camera("edge on", [6.0, 0.8, 0.0], [0.0, 0.8, 0.0]),
            camera("close", [-0.4, 0.8, 0.9], [0.0, 0.8, -1.0]),
            camera("from above", [0.0, 5.0, 0.3], [0.0, 0.0, 0.0]),
        ],
    )
}

/// Faces with four to eleven corners.
///
/// Prisms of every number of sides in a row, some upside down; behind them a wall of one face with extra corners on its
/// straight edges, and a fan of tall tapered boxes.
pub(crate) fn polygons() -> BuiltIn {
    let mut stage = Stage::new();
    floor(&mut stage);
    let colors = [RED, GREEN, BLUE, YELLOW, BROWN, WHITE, RED_SHEET, BLUE_SHEET];
    for (i, sides) in (4..=11).enumerate() {
        let outline: Vec<Vec3> = around(sides)
            .map(|at| vec3(0.55 * at.x, 0.0, 0.55 * at.y))
            .collect();
        let shape = prism(colors[i], &outline, vec3(0.1, 0.8, 0.0));
        let lie = if i % 2 == 0 { 0.0 } else { 1.2 };
        let place = Transform::translation([-4.6 + 1.3 * i as f32, 0.5, if i % 2 == 0 { 0.4 } else { -0.6 }])
            * Transform::rotation([1.0, 0.2, 0.0], lie);
        stage.placed("prism", &shape, place);
    }
    let edge: Vec<Vec2> = [
        (-5.0, 0.0),
        (-1.0, 0.0),
        (2.0, 0.0),
        (5.0, 0.0),
        (5.0, 1.5),
        (5.0, 3.0),
    ]
    .into_iter()
    .chain([(1.0, 3.0), (-5.0, 3.0), (-5.0, 2.0)])
    .map(|(x, y)| vec2(x, y))
    .collect();
    let mut wall = Shape::new();
    wall.face(
        WHITE,
        &edge.iter().map(|at| vec3(at.x, at.y, -3.0)).collect::<Vec<_>>(),
    );
    stage.thing("wall", &wall);
    for i in 0..5 {
        let place = Transform::translation([-3.0 + 1.5 * i as f32, 0.0, -2.2])
            * Transform::rotation([0.0, 1.0, 0.0], 0.4 * f64::from(i));
        stage.placed("spire", &taper(GREY, [0.6, 0.6], 2.4, [0.15, 0.3]), place);
    }
    alone(
        stage,
        vec![
            camera("front", [0.0, 1.6, 5.6], [0.0, 0.8, -1.0]),
            camera("aslant", [5.4, 2.4, 2.0], [-1.0, 0.6, -1.0]),
            camera("from above", [0.0, 6.0, -0.5], [0.0, 0.0, -0.6]),
            camera("between", [-0.7, 0.9, 0.1], [1.5, 0.8, -1.6]),
        ],
    )
}
