//! Stacked glass layers: everything behind and between them must be right at every sample.

use super::stage::{
    BLUE, BLUE_GLASS, BROWN, Doorway, GREEN, LEAF, RED, RED_GLASS, Stage, YELLOW, finished, sheet,
};
use crate::BuiltIn;
use crate::camera::camera;
use crate::envelope::Side;
use crate::shape::{Shape, ball, block, knot, lathe};
use enfilade::{MaterialId, Method, SceneBuilder, Transform};
use glam::{Vec3, vec3};

const MIRROR: Doorway = Doorway {
    name: "mirror",
    side: Side::North,
    plane: -3.05,
    along: [-2.6, 1.0],
    up: [0.3, 2.6],
};
const DOOR: Doorway = Doorway {
    name: "door",
    along: [1.6, 2.6],
    up: [0.0, 2.2],
    ..MIRROR
};

/// A room with a mirror, and a door to another room.
///
/// Two panes intersect like a turnstile's; a third passes through a statue; three nested bottles contain a yellow ball;
/// the mirror shows all of it again. A pane leans in the doorway, half of it in either room, with leaves before and
/// behind it.
pub(crate) fn bottles() -> BuiltIn {
    let [mut room, mut back] = [Stage::new(), Stage::new()];
    let openings = room.room([-3.0, 3.0], [-3.0, 3.0], 3.0, &[MIRROR, DOOR]);
    let home = back.room([-3.0, 3.0], [-7.0, -3.1], 3.0, &[DOOR.other_side()])[0];
    room.thing("table", &block(BROWN, [-2.2, 0.0, -0.6], [-0.4, 0.9, 0.6]));
    for (name, glass, size) in [
        ("large bottle", BLUE_GLASS, 1.0),
        ("middle bottle", RED_GLASS, 0.72),
        ("small bottle", BLUE_GLASS, 0.45),
    ] {
        room.placed(
            name,
            &bottle(glass, size),
            Transform::translation([-1.3, 0.91, 0.0]),
        );
    }
    room.placed(
        "yellow ball",
        &ball(YELLOW, 0.08, 8, 12),
        Transform::translation([-1.3, 1.08, 0.0]),
    );
    let upright = |glass: MaterialId, foot: Vec3, along: Vec3| sheet(glass, foot, along, vec3(0.0, 2.0, 0.0));
    room.thing(
        "first pane",
        &upright(RED_GLASS, vec3(0.1, 0.2, -0.6), vec3(1.1, 0.0, 1.0)),
    );
    room.thing(
        "second pane",
        &upright(BLUE_GLASS, vec3(0.1, 0.2, 0.4), vec3(1.1, 0.0, -1.0)),
    );
    room.placed(
        "statue",
        &knot(GREEN, 2, 3, 0.4, 0.15, 0.1, 48, 8),
        Transform::translation([2.0, 1.2, -1.0]),
    );
    room.thing(
        "pane through the statue",
        &upright(BLUE_GLASS, vec3(1.3, 0.4, -1.2), vec3(1.4, 0.0, 0.4)),
    );
    let leaning = sheet(
        RED_GLASS,
        vec3(1.7, 0.0, -2.7),
        vec3(0.8, 0.0, 0.0),
        vec3(0.0, 2.0, -0.8),
    );
    for stage in [&mut room, &mut back] {
        stage.thing("leaning pane", &leaning);
    }
    for (name, z) in [("leaves before", -4.0), ("leaves behind", -4.8)] {
        back.thing(
            name,
            &sheet(LEAF, vec3(1.9, 0.3, z), vec3(0.4, 0.0, 0.1), vec3(0.0, 1.2, 0.0)),
        );
    }
    back.thing("pillar", &block(BLUE, [1.8, 0.0, -4.5], [2.2, 1.3, -4.2]));
    back.thing(
        "last pane",
        &upright(BLUE_GLASS, vec3(1.5, 0.1, -3.8), vec3(1.2, 0.0, 0.0)),
    );
    back.thing("chest", &block(RED, [0.6, 0.0, -6.6], [2.8, 0.9, -5.8]));
    let mut scene = SceneBuilder::new();
    let room = scene.add("room", room.build(), Method::HierarchicalZ);
    let back = scene.add("back room", back.build(), Method::HierarchicalZ);
    scene.mirror(room, openings[0]);
    scene.door((room, openings[1]), (back, home));
    finished(
        scene,
        vec![
            camera("the bottles", [-0.9, 1.5, 1.9], [-1.3, 1.2, 0.0]),
            camera("the panes", [0.9, 1.5, 2.6], [0.6, 1.2, -0.5]),
            camera("the statue", [1.0, 1.6, 1.3], [2.0, 1.2, -1.0]),
            camera("through the door", [2.1, 1.5, 0.9], [2.1, 1.1, -4.0]),
            camera("from the back room", [2.2, 1.5, -5.4], [1.6, 1.2, 0.0]),
            camera("in the bottle", [-1.28, 1.1, 0.12], [-1.4, 1.3, -3.0]),
        ],
    )
}

/// A bottle 1.35 × `size` metres high, 5 cm above the floor, open above and closed below.
fn bottle(glass: MaterialId, size: f32) -> Shape {
    let profile = [
        [0.0, 0.0],
        [0.42, 0.0],
        [0.46, 0.06],
        [0.46, 0.75],
        [0.16, 1.05],
        [0.14, 1.35],
    ];
    lathe(
        glass,
        &profile.map(|[radius, height]| [radius * size * 0.8, (height + 0.05 / size) * size]),
        14,
    )
}
