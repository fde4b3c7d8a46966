//! Creates cameras at player starts and intermission points.

use super::axes::{direction, turned};
use super::entities::Entity;
use enfilade::Camera;

/// Height of a player's eye above the entity origin, in map units.
const EYE: f32 = 22.0;
const EYE_IN_QUAKE_3: f32 = 26.0;
/// Vertical field of view, in radians: 90° horizontally at an aspect ratio of 4:3, as in both games.
const FOV: f32 = 1.287_002_2;
/// Near-plane distance, smaller than the distance that walls keep from a player's eye.
const NEAR: f32 = 1.0;

/// Entity classes, most useful first.
const CLASSES: [&str; 10] = [
    "info_player_start",
    "info_player_deathmatch",
    "info_player_coop",
    "info_player_start2",
    "info_player_team1",
    "info_player_team2",
    "team_CTF_redplayer",
    "team_CTF_blueplayer",
    "info_intermission",
    "info_player_intermission",
];

/// Returns the cameras of a map, by class and then in entity order. Named after the class if it has one entity,
/// otherwise with the entity index.
pub(super) fn cameras(entities: &[Entity], is_quake3: bool) -> Vec<Camera> {
    let mut cameras = Vec::new();
    for class in CLASSES {
        let of_class = || entities.iter().filter(|entity| entity.class() == class);
        let is_one = of_class().count() == 1;
        for entity in of_class() {
            let origin = entity.three("origin").unwrap_or_default();
            let name = if is_one {
                class.to_owned()
            } else {
                format!("{class}#{}", entity.number)
            };
            cameras.extend(camera(
                entity,
                origin,
                name,
                class.contains("intermission"),
                is_quake3,
            ));
        }
    }
    cameras
}

/// Returns `None` if the position is so far from the origin that the look-at point rounds to it.
fn camera(
    entity: &Entity,
    origin: [f32; 3],
    name: String,
    is_still: bool,
    is_quake3: bool,
) -> Option<Camera> {
    let eye_height = match (is_still, is_quake3) {
        (true, _) => 0.0,
        (false, false) => EYE,
        (false, true) => EYE_IN_QUAKE_3,
    };
    let eye = turned([origin[0], origin[1], origin[2] + eye_height]);
    // Both games store pitch (positive is down) before yaw.
    let turned_by = entity.three("mangle").or(entity.three("angles"));
    let [down, around] = match turned_by {
        Some([down, around, _]) => [down, around],
        None => [
            0.0,
            entity
                .number("angle")
                .filter(|angle| *angle >= 0.0)
                .unwrap_or(0.0),
        ],
    };
    // Straight up or down, the up vector would be undefined.
    let ahead = direction(around, (-down).clamp(-89.0, 89.0));
    // One unit ahead, or more if rounding would lose that.
    let far = eye.iter().fold(1000.0, |far: f32, part| far.max(part.abs())) / 1000.0;
    let toward = [0, 1, 2].map(|axis| eye[axis] + far * ahead[axis]);
    let is_sound = toward.iter().all(|part| part.is_finite()) && toward != eye;
    is_sound.then_some(Camera {
        name,
        fov_y: FOV,
        z_near: Some(NEAR),
        ..Camera::new(eye, toward)
    })
}
