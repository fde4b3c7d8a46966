//! The built-in palace: an enfilade of twelve rooms, with a gallery, a court and cabinets beside it.

mod ceiling;
mod column;
mod envelope;
mod floor;
mod palette;
mod plan;
mod room;
mod trim;
mod workshop;

use crate::random::Random;
use crate::{BuiltIn, Camera};
use enfilade::{FragmentId, Method, OpeningId, SceneBuilder};
use envelope::{Ceiling, Side};
use glam::{Vec2, Vec3, vec2, vec3};
use plan::{DOORS, Door, ROOMS};
use room::{Doorway, Room, arched};
use workshop::Workshop;

/// The seed of the palace that everybody knows.
pub(crate) const SEED: u64 = 1_783;

/// Builds the palace. Paintings, books and the lie of small things follow from the seed; rooms and doors do not.
pub(crate) fn palace(seed: u64) -> BuiltIn {
    let mut scene = SceneBuilder::new();
    let mut shop = Workshop::default();
    let mut random = Random::new(seed);
    let mut door_ends: Vec<Vec<(FragmentId, OpeningId)>> = vec![Vec::new(); DOORS.len()];
    for (place, design) in ROOMS.iter().enumerate() {
        let mut room = Room::new(*design, &mut shop, Random::new(random.bits()));
        let id = FragmentId(place as u32);
        for (door, ends) in DOORS.iter().zip(&mut door_ends) {
            if let Some(opening) = hang_door(&mut room, door, place) {
                ends.push((id, opening));
            }
        }
        let top = room.design.height;
        trim::dress(&mut room, top, 0.6);
        let s = room.design.style;
        let p = floor::paving(design.plan, s.floor, s.gilt, 0.4);
        room.make("paving", &p);
        let (content, mirrors) = room.close();
        let added = scene.add(design.name, content, Method::HierarchicalZ);
        debug_assert_eq!(added, id);
        for mirror in mirrors {
            scene.mirror(id, mirror);
        }
    }
    for ends in door_ends {
        let [a, b] = ends.try_into().expect("a door has two sides");
        scene.door(a, b);
    }
    BuiltIn { scene: scene.build().expect("the palace stands"), cameras: vec![
        Camera::new("enfilade", [0.0, 1.65, -0.7], [0.0, 1.65, -120.0])
    ] }
}

/// Cuts a door into a room, if it is one of its two; the opening looks into the room.
fn hang_door(room: &mut Room, door: &Door, place: usize) -> Option<OpeningId> {
    let ahead = door.looks.direction();
    let right = vec2(-ahead.y, ahead.x);
    let at = Vec2::from(door.at);
    let mut outline: Vec<Vec3> = arched(door.width, door.sill, door.spring, door.rise)
        .into_iter()
        .map(|corner| {
            let on_plan = at + right * corner.x;
            vec3(on_plan.x, corner.y, on_plan.y)
        })
        .collect();
    let side = if door.from as usize == place {
        door.looks
    } else if door.to as usize == place {
        outline.reverse();
        door.looks.opposite()
    } else {
        return None;
    };
    let wall = room.wall(side);
    let along = wall.along(at);
    let depth = (at - wall.left).dot(side.direction());
    let Door { width, sill, spring, rise, .. } = *door;
    room.doorway(
        Doorway { wall: room.design.plan.wall(side), along, width, sill, spring, rise, depth },
        outline.clone(),
    );
    Some(room.opening(door.name, &outline))
}
