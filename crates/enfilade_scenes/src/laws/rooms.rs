//! Rooms joined by doors, and cameras in difficult positions.

use super::stage::{BLUE, BROWN, Doorway, GREEN, GREY, RED, RED_SHEET, Stage, YELLOW, joined};
use crate::BuiltIn;
use crate::camera::camera;
use crate::envelope::Side;
use crate::shape::{Shape, ball, block, cuboid, fill, lathe};
use enfilade::{Camera, Transform};
use glam::{Vec3, vec3};

/// A door in the plane x = 0, as seen from the room to its west.
const DOOR: Doorway = Doorway {
    name: "door",
    side: Side::East,
    plane: 0.0,
    along: [-0.5, 0.5],
    up: [0.0, 2.0],
};

/// Returns the western room, x from −5 to the door, and its eastern neighbour, up to x = 5.
fn pair() -> [(Stage, enfilade::OpeningId); 2] {
    let [mut west, mut east] = [Stage::new(), Stage::new()];
    let out = west.room([-5.0, -0.1], [-2.5, 2.5], 3.0, &[DOOR])[0];
    let back = east.room([0.1, 5.0], [-2.5, 2.5], 3.0, &[DOOR.other_side()])[0];
    [(west, out), (east, back)]
}

/// Two rooms with a door between them.
///
/// In the eastern room a red ball is in line with the door, a green box to its left and a blue one to its right: the
/// door shows only items in line with it. A yellow box is in the western room beside the door.
pub(crate) fn two_rooms() -> BuiltIn {
    let [(mut west, out), (mut east, back)] = pair();
    east.placed(
        "ball",
        &ball(RED, 0.5, 10, 14),
        Transform::translation([4.0, 1.0, 0.0]),
    );
    east.thing("left box", &block(GREEN, [2.5, 0.0, -2.2], [3.3, 1.0, -1.4]));
    east.thing("right box", &block(BLUE, [2.5, 0.0, 1.4], [3.3, 1.0, 2.2]));
    west.thing("near box", &block(YELLOW, [-1.2, 0.0, 1.0], [-0.4, 1.0, 1.8]));
    joined(
        (west, out),
        (east, back),
        vec![
            camera("in line", [-4.5, 1.6, 0.0], [5.0, 1.2, 0.0]),
            camera("aslant", [-4.5, 1.6, 2.0], [1.0, 1.0, -0.6]),
            camera("grazing", [-0.4, 1.6, 2.2], [0.2, 1.0, -2.0]),
            camera("way back", [4.6, 1.6, 0.3], [-5.0, 1.2, 0.0]),
            camera("away", [-1.0, 1.6, 0.0], [-5.0, 1.2, 0.0]),
        ],
    )
}

/// A pillar before a door.
///
/// From the middle of the western room the pillar covers the door almost entirely. The boxes in the eastern room are
/// visible to its left and right only, and the one behind it not at all.
pub(crate) fn pillar() -> BuiltIn {
    let [(mut west, out), (mut east, back)] = pair();
    let pillar = [
        [0.0, 0.0],
        [0.35, 0.0],
        [0.3, 0.3],
        [0.28, 2.6],
        [0.36, 2.8],
        [0.36, 3.0],
        [0.0, 3.0],
    ];
    west.placed(
        "pillar",
        &lathe(GREY, &pillar, 20),
        Transform::translation([-0.9, 0.0, 0.0]),
    );
    for (name, material, z) in [("left", GREEN, -1.1), ("behind", RED, -0.2), ("right", BLUE, 0.7)] {
        east.thing(name, &block(material, [4.0, 0.0, z], [4.5, 1.6, z + 0.4]));
    }
    joined(
        (west, out),
        (east, back),
        vec![
            camera("covered", [-4.5, 1.5, 0.0], [0.0, 1.2, 0.0]),
            camera("past it", [-4.0, 1.5, 1.6], [0.2, 1.2, -0.2]),
            camera("before it", [-1.5, 1.5, 0.0], [0.0, 1.2, 0.0]),
            camera("between", [-0.45, 1.5, 0.3], [5.0, 1.0, 0.0]),
        ],
    )
}

/// Narrow gaps.
///
/// In the western room there is a wall with a slit 2 cm wide, three needle holes and a row of cracks, and coloured
/// boxes behind it. The door to the eastern room is ajar: its leaf leaves a gap of a few centimetres.
pub(crate) fn slits() -> BuiltIn {
    let [(mut west, out), (mut east, back)] = pair();
    let hole = |z: f32, y: f32, wide: f32, high: f32| -> Vec<Vec3> {
        [(z, y), (z + wide, y), (z + wide, y + high), (z, y + high)]
            .map(|(z, y)| vec3(-2.5, y, z))
            .to_vec()
    };
    let mut holes = vec![
        hole(-1.0, 0.4, 0.02, 2.0),
        hole(0.3, 1.5, 0.006, 0.006),
        hole(0.4, 1.5, 0.01, 0.01),
        hole(0.5, 1.5, 0.02, 0.02),
    ];
    holes.extend((0..6).map(|i| hole(1.2, 0.5 + 0.3 * i as f32, 0.8, 0.004)));
    let outline = [(-2.4, 0.0), (2.4, 0.0), (2.4, 2.9), (-2.4, 2.9)].map(|(z, y)| vec3(-2.5, y, z));
    let mut screen = Shape::new();
    for face in fill(&outline, &holes) {
        screen.face(RED_SHEET, &face);
    }
    west.thing("screen", &screen);
    for (i, material) in [GREEN, BLUE, YELLOW, BROWN].into_iter().enumerate() {
        let z = -1.6 + 1.0 * i as f32;
        west.thing(
            "behind the screen",
            &block(material, [-1.6, 0.8, z], [-1.2, 2.0, z + 0.6]),
        );
    }
    let leaf = block(BROWN, [0.0, 0.0, 0.0], [0.05, 1.98, 0.98]);
    let ajar = Transform::translation([0.12, 0.01, -0.48]) * Transform::rotation([0.0, 1.0, 0.0], 0.08);
    east.placed("leaf", &leaf, ajar);
    east.placed(
        "ball",
        &ball(RED, 0.8, 10, 14),
        Transform::translation([3.6, 1.0, 1.3]),
    );
    joined(
        (west, out),
        (east, back),
        vec![
            camera("before the screen", [-4.5, 1.5, 0.0], [-2.5, 1.5, 0.0]),
            camera("at the slit", [-2.56, 1.5, -0.99], [-1.0, 1.4, -0.9]),
            camera("at a needle hole", [-2.52, 1.505, 0.405], [-1.0, 1.5, 0.4]),
            camera("at the door", [-1.1, 1.5, 0.2], [0.2, 1.3, 0.3]),
            camera("at the gap", [-0.25, 1.5, 0.2], [2.0, 1.2, 0.6]),
        ],
    )
}

/// Cameras in unusual positions.
///
/// Two rooms with a door. The eye is in the doorway, a millimetre and a hundredth of a millimetre from its plane, on
/// either side; inside a box; on a wall; so low that the near plane cuts the floor; and looks straight up and down.
pub(crate) fn eye_in_things() -> BuiltIn {
    let [(mut west, out), (mut east, back)] = pair();
    west.thing(
        "box around an eye",
        &block(BLUE, [-3.4, 1.0, -0.4], [-2.6, 2.0, 0.4]),
    );
    let mut hollow = cuboid(RED_SHEET, [0.6, 0.6, 0.6]);
    hollow.join(block(YELLOW, [-0.05, 0.4, -0.28], [0.05, 0.5, -0.2]));
    west.placed("hollow", &hollow, Transform::translation([-4.2, 1.0, 1.5]));
    east.placed(
        "ball",
        &ball(RED, 0.5, 8, 12),
        Transform::translation([3.0, 1.2, 0.3]),
    );
    east.thing("box", &block(GREEN, [1.5, 0.0, -2.0], [2.3, 1.2, -1.2]));
    west.thing("table", &block(BROWN, [-1.8, 0.7, -1.8], [-0.8, 0.8, -0.9]));
    let mut cameras: Vec<Camera> = [("1 mm", 1e-3_f32), ("0.01 mm", 1e-5)]
        .into_iter()
        .flat_map(|(name, off)| {
            [
                camera(
                    &format!("{name} before the door"),
                    [-off, 1.5, 0.1],
                    [4.0, 1.2, 0.0],
                ),
                camera(
                    &format!("{name} behind the door"),
                    [off, 1.5, 0.1],
                    [4.0, 1.2, 0.0],
                ),
                camera(&format!("{name} behind, back"), [off, 1.5, 0.1], [-4.0, 1.2, 0.0]),
                camera(
                    &format!("{name} before, along"),
                    [-off, 1.5, 0.0],
                    [0.0, 1.4, 4.0],
                ),
            ]
        })
        .collect();
    cameras.extend([
        camera("in a box", [-3.0, 1.5, 0.0], [0.0, 1.3, 0.0]),
        camera("in a hollow box", [-4.2, 1.3, 1.5], [-4.2, 1.4, 0.0]),
        camera("on a wall", [-5.0, 1.5, 0.0], [0.0, 1.2, 0.3]),
        camera("along a wall", [-4.0, 1.5, -2.5], [0.0, 1.5, -2.5]),
        camera("near the floor", [-4.0, 0.002, 0.5], [0.0, 0.1, 0.0]),
        camera("straight up", [-2.0, 1.0, 1.0], [-2.0, 3.0, 1.0]),
        camera("straight down", [-1.3, 2.5, -1.3], [-1.3, 0.0, -1.3]),
    ]);
    joined((west, out), (east, back), cameras)
}
