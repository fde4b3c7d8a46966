//! Openings that are not doors in a wall: mirrors, nested scenes, a free-standing doorway.

use super::stage::{
    BLUE, BROWN, Doorway, GREEN, GREY, RED, RED_SHEET, Stage, WHITE, YELLOW, both_ways, finished, lamp, sheet,
};
use crate::BuiltIn;
use crate::camera::camera;
use crate::envelope::Side;
use crate::shape::{Shape, ball, block, cuboid, fill, knot};
use enfilade::{Method, Scene, SceneBuilder, Transform};
use glam::{Vec3, vec3};

const GLASS: Doorway = Doorway {
    name: "glass",
    side: Side::North,
    plane: -3.05,
    along: [-1.2, 1.2],
    up: [0.4, 2.5],
};

/// A room with a mirror on its northern wall.
///
/// A red ball is before the mirror, and a box behind its glass, outside the room, which must not be visible in it. A
/// one-sided poster faces the mirror and turns its back to the eye: it is visible in the mirror only. A bar passes
/// through the glass: its front end is visible twice, its back end never.
pub(crate) fn mirror() -> BuiltIn {
    let mut stage = Stage::new();
    let opening = stage.room([-3.0, 3.0], [-3.0, 3.0], 3.0, &[GLASS])[0];
    stage.placed(
        "ball",
        &ball(RED, 0.4, 10, 14),
        Transform::translation([0.9, 1.0, -1.2]),
    );
    stage.thing(
        "behind the glass",
        &block(GREEN, [-0.8, 0.6, -5.0], [0.8, 2.0, -4.0]),
    );
    stage.thing(
        "poster",
        &sheet(
            YELLOW,
            vec3(-0.2, 1.0, -1.6),
            vec3(-0.8, 0.0, 0.0),
            vec3(0.0, 0.9, 0.0),
        ),
    );
    stage.thing("bar", &block(BLUE, [-0.9, 0.7, -4.2], [-0.75, 0.85, -2.2]));
    stage.thing("table", &block(BROWN, [1.2, 0.7, 0.2], [2.4, 0.8, 1.4]));
    let mut scene = SceneBuilder::new();
    let room = scene.add("room", stage.build(), Method::HierarchicalZ);
    scene.mirror(room, opening);
    lamp(&mut scene, room, [-1.6, 2.2, -1.0], 6.0);
    finished(
        scene,
        vec![
            camera("straight", [0.0, 1.5, 2.6], [0.0, 1.4, -3.0]),
            camera("aslant", [2.6, 1.5, 1.8], [-0.6, 1.4, -3.0]),
            camera("grazing", [2.7, 1.5, -2.4], [-1.0, 1.4, -3.1]),
            camera("close", [0.2, 1.5, -2.95], [0.3, 1.4, -4.0]),
            camera("away", [0.0, 1.5, -2.0], [0.0, 1.2, 3.0]),
        ],
    )
}

/// Two parallel mirrors with a torus knot and a stick between them. Each reflects the other, until less than a pixel
/// remains.
pub(crate) fn mirrors() -> BuiltIn {
    let mut stage = Stage::new();
    let other = Doorway {
        name: "other glass",
        plane: 3.05,
        side: Side::South,
        ..GLASS
    };
    let openings = stage.room([-3.0, 3.0], [-3.0, 3.0], 3.0, &[GLASS, other]);
    stage.placed(
        "knot",
        &knot(RED, 2, 3, 0.4, 0.15, 0.07, 48, 7),
        Transform::translation([0.5, 1.3, 0.0]),
    );
    stage.thing("stick", &block(BLUE, [-0.7, 0.0, -0.5], [-0.6, 2.0, -0.4]));
    let mut scene = SceneBuilder::new();
    let room = scene.add("room", stage.build(), Method::HierarchicalZ);
    for opening in openings {
        scene.mirror(room, opening);
    }
    lamp(&mut scene, room, [0.9, 2.4, 1.2], 7.0);
    finished(
        scene,
        vec![
            camera("straight", [0.0, 1.5, 1.5], [0.0, 1.4, -3.0]),
            camera("aslant", [1.0, 1.6, 2.0], [-0.4, 1.3, -3.0]),
            camera("from the corner", [2.8, 2.4, 2.8], [-1.0, 1.0, -2.0]),
        ],
    )
}

/// A cabinet in a room: a nested scene, twice as large as it looks and rotated by a right angle; it contains a casket,
/// which is a nested scene again.
///
/// Its shell is an item of the room with a hole in its front. From the side the shell hides its contents; from straight
/// ahead the ball in the casket is visible through both fronts. A hatch in the cabinet's wall leads to a window in the
/// room's eastern wall, from where the outside of the cabinet is visible again.
pub(crate) fn nested() -> BuiltIn {
    let [left, right, low, high, front] = [-0.5, 0.5, 0.6, 1.6, -1.98];
    let outline: Vec<Vec3> = [(left, low), (right, low), (right, high), (left, high)]
        .map(|(x, y)| vec3(x, y, front))
        .to_vec();
    let mut stage = Stage::new();
    let window = stage.room([-3.0, 3.0], [-3.0, 3.0], 3.0, &[WINDOW])[0];
    stage.thing(
        "cabinet",
        &shell(RED, &outline, [-0.7, 0.7], [0.5, 1.7], [-2.8, -1.9]),
    );
    stage.thing("beside it", &block(YELLOW, [1.2, 0.0, -2.6], [2.0, 0.9, -1.8]));
    stage.thing("before it", &block(BLUE, [-0.6, 0.0, -0.4], [-0.3, 1.1, -0.1]));
    let opening = stage.opening("cabinet", &outline);

    let mut scene = SceneBuilder::new();
    let room = scene.add("room", stage.build(), Method::HierarchicalZ);
    let inside = scene.nest(&inside_the_cabinet());
    let there_from_here = Transform::from_columns([
        [0.0, 0.0, 2.0],
        [0.0, 2.0, 0.0],
        [-2.0, 0.0, 0.0],
        [96.04, -1.2, 0.0],
    ]);
    both_ways(&mut scene, (room, opening), (inside, "front"), there_from_here);
    lamp(&mut scene, room, [0.4, 1.9, 0.6], 6.0);
    let from_the_window = Transform::from_columns([
        [0.0, 0.0, -2.0],
        [0.0, 2.0, 0.0],
        [2.0, 0.0, 0.0],
        [101.7, -1.6, 7.45],
    ]);
    both_ways(&mut scene, (room, window), (inside, "hatch"), from_the_window);
    finished(
        scene,
        vec![
            camera("straight", [0.0, 1.2, 1.8], [0.0, 1.1, -2.0]),
            camera("aslant", [1.9, 1.6, 0.2], [0.0, 1.1, -2.2]),
            camera("beside", [2.8, 1.4, -2.4], [0.0, 1.1, -2.4]),
            camera("close", [0.1, 1.2, -1.6], [0.0, 1.1, -2.6]),
            camera("at the window", [-0.8, 1.6, 1.2], [3.0, 1.3, -0.1]),
            camera("inside, back", [101.5, 1.2, 0.4], [98.0, 0.8, 0.0]),
            camera("inside, at the hatch", [101.1, 1.5, -0.9], [101.8, 1.1, 1.3]),
        ],
    )
}

/// The cabinet's hatch on the room's side: half as large as in the cabinet.
const WINDOW: Doorway = Doorway {
    name: "window",
    side: Side::East,
    plane: 3.05,
    along: [-0.4, 0.4],
    up: [1.0, 1.8],
};

/// The nested scene of the cabinet. Its front is the plane x = 100, its width runs along z.
fn inside_the_cabinet() -> Scene {
    let front = Doorway {
        name: "front",
        side: Side::West,
        plane: 100.0,
        along: [-1.0, 1.0],
        up: [0.0, 2.0],
    };
    let hatch = Doorway {
        name: "hatch",
        side: Side::South,
        plane: 1.35,
        along: [100.9, 102.5],
        up: [0.4, 2.0],
    };
    let mut stage = Stage::new();
    let exits = stage.room([100.1, 103.0], [-1.3, 1.3], 2.3, &[front, hatch]);
    stage.thing("jar", &block(GREEN, [100.8, 0.0, -0.9], [101.2, 0.7, -0.5]));
    let outline: Vec<Vec3> = [(-0.4, 0.5), (0.4, 0.5), (0.4, 1.3), (-0.4, 1.3)]
        .map(|(z, y)| vec3(102.03, y, z))
        .to_vec();
    stage.thing("casket", &casket(&outline));
    let opening = stage.opening("casket", &outline);
    let mut scene = SceneBuilder::new();
    let inside = scene.add("cabinet", stage.build(), Method::HierarchicalZ);
    let casket = scene.nest(&inside_the_casket());
    let move_there = Transform::translation([200.0 - 102.03, 0.0, 0.0]);
    both_ways(&mut scene, (inside, opening), (casket, "lid"), move_there);
    for (name, out) in ["front", "hatch"].into_iter().zip(exits) {
        scene.exit(name, (inside, out));
    }
    scene.build().expect("the cabinet is sound")
}

fn inside_the_casket() -> Scene {
    let lid = Doorway {
        name: "lid",
        side: Side::West,
        plane: 200.0,
        along: [-0.4, 0.4],
        up: [0.5, 1.3],
    };
    let mut stage = Stage::new();
    let out = stage.room([200.05, 200.9], [-0.5, 0.5], 1.5, &[lid])[0];
    stage.placed(
        "ball",
        &ball(RED, 0.25, 10, 14),
        Transform::translation([200.6, 0.9, 0.0]),
    );
    let mut scene = SceneBuilder::new();
    let casket = scene.add("casket", stage.build(), Method::HierarchicalZ);
    scene.exit("lid", (casket, out));
    lamp(&mut scene, casket, [200.3, 1.2, 0.3], 3.0);
    scene.build().expect("the casket is sound")
}

/// Creates a box facing outwards, with a hole of the opening's outline in its southern side.
pub(super) fn shell(
    material: enfilade::MaterialId,
    opening: &[Vec3],
    x: [f32; 2],
    y: [f32; 2],
    z: [f32; 2],
) -> Shape {
    let hole: Vec<Vec3> = opening.iter().map(|at| vec3(at.x, at.y, z[1])).collect();
    let corner = |x: f32, y: f32, z: f32| vec3(x, y, z);
    let mut shape = Shape::new();
    let face = [
        corner(x[0], y[0], z[1]),
        corner(x[1], y[0], z[1]),
        corner(x[1], y[1], z[1]),
        corner(x[0], y[1], z[1]),
    ];
    for part in fill(&face, std::slice::from_ref(&hole)) {
        shape.face(material, &part);
    }
    for i in 0..hole.len() {
        let next = (i + 1) % hole.len();
        shape.face(WHITE, &[hole[i], hole[next], opening[next], opening[i]]);
    }
    let [a, b, c, d] = face;
    let back = vec3(0.0, 0.0, z[0] - z[1]);
    for (from, to) in [(b, a), (c, b), (d, c), (a, d)] {
        shape.face(material, &[from, to, to + back, from + back]);
    }
    shape.face(material, &[b + back, a + back, d + back, c + back]);
    shape
}

/// The casket's shell, facing −x.
fn casket(opening: &[Vec3]) -> Shape {
    let turned: Vec<Vec3> = opening.iter().map(|at| vec3(at.z, at.y, -at.x)).collect();
    shell(BROWN, &turned, [-0.5, 0.5], [0.4, 1.4], [-102.9, -102.0]).bent(|at| vec3(-at.z, at.y, at.x))
}

/// A free-standing doorway in a room that leads into a garden.
///
/// It is an opening from one side only: from the other side, its frame shows the boxes behind it. One way: no portal
/// leads back from the garden.
pub(crate) fn free_doorway() -> BuiltIn {
    let outline: Vec<Vec3> = [(-0.6, 0.0), (0.6, 0.0), (0.6, 2.0), (-0.6, 2.0)]
        .map(|(x, y)| vec3(x, y, 0.0))
        .to_vec();
    let mut stage = Stage::new();
    stage.room([-4.0, 4.0], [-4.0, 4.0], 3.2, &[]);
    let mut frame = block(BROWN, [-0.75, 0.0, -0.08], [-0.6, 2.15, 0.08]);
    frame.join(block(BROWN, [0.6, 0.0, -0.08], [0.75, 2.15, 0.08]));
    frame.join(block(BROWN, [-0.6, 2.0, -0.08], [0.6, 2.15, 0.08]));
    stage.thing("frame", &frame);
    for (name, material, x, z) in [
        ("behind it", RED, -0.3, -2.0),
        ("left of it", BLUE, -2.4, -1.6),
        ("right of it", YELLOW, 1.8, -1.6),
        ("before it", GREEN, 0.3, 2.2),
    ] {
        stage.placed(
            name,
            &cuboid(material, [0.6, 1.2, 0.6]),
            Transform::translation([x, 0.0, z]),
        );
    }
    let opening = stage.opening("doorway", &outline);

    let garden_from_room =
        Transform::translation([60.0, 0.0, 5.0]) * Transform::rotation([0.0, 1.0, 0.0], 0.6);
    let mut garden = Stage::new();
    let into = |at: [f32; 3]| Vec3::from(garden_from_room.point(at));
    let arrival: Vec<Vec3> = outline.iter().rev().map(|at| into(at.to_array())).collect();
    let back = garden.opening("arrival", &arrival);
    let lawn = [
        [-6.0, 0.0, 0.0],
        [6.0, 0.0, 0.0],
        [6.0, 0.0, -12.0],
        [-6.0, 0.0, -12.0],
    ]
    .map(into);
    let mut ground = Shape::new();
    ground.face(GREEN, &lawn);
    garden.thing("lawn", &ground);
    for i in 0..5 {
        let at = into([-3.0 + 1.5 * i as f32, 1.4, -5.0 - 0.8 * (i % 3) as f32]).to_array();
        garden.placed(
            "tree",
            &ball(if i == 2 { RED_SHEET } else { GREEN }, 0.6, 8, 12),
            Transform::translation(at),
        );
        let at = [at[0], 0.0, at[2]];
        garden.placed(
            "trunk",
            &cuboid(GREY, [0.2, 1.0, 0.2]),
            Transform::translation(at),
        );
    }
    let mut scene = SceneBuilder::new();
    let room = scene.add("room", stage.build(), Method::HierarchicalZ);
    let garden = scene.add("garden", garden.build(), Method::HierarchicalZ);
    scene.portal((room, opening), (garden, back), garden_from_room);
    finished(
        scene,
        vec![
            camera("into the garden", [0.2, 1.6, 3.2], [0.0, 1.2, 0.0]),
            camera("past it", [2.6, 1.6, 2.8], [-0.6, 1.2, -0.6]),
            camera("from behind", [0.3, 1.6, -3.4], [0.0, 1.2, 0.0]),
            camera("edge on", [3.5, 1.6, 0.0], [0.0, 1.2, 0.0]),
            camera("at the sill", [0.1, 1.5, 0.05], [0.2, 1.3, -3.0]),
        ],
    )
}
