//! The built-in palace: an enfilade of twelve rooms, with a gallery, a court and cabinets beside it, a garden before
//! its last rooms, and a gallery of convex cells along the garden.

mod cameras;
mod case;
mod ceiling;
mod cells;
mod column;
mod crown;
mod doll_house;
mod doors;
mod drapery;
mod floor;
mod fountain;
mod garden;
mod head;
mod hearth;
mod lamps;
mod light;
mod living_picture;
mod name;
mod ornament;
mod palette;
mod panel;
mod park;
mod picture;
mod plan;
mod room;
mod rooms;
mod sculpt;
mod seat;
mod secret;
mod statue;
mod table;
mod textures;
mod trim;
mod windows;
mod workshop;

use doors::{DOORS, Gate};
use enfilade::{Method, OpeningId, SceneBuilder, SectorId};
use enfilade_scenes::BuiltIn;
use enfilade_scenes::Random;
use glam::Vec2;
use plan::{Name, ROOMS};
use room::{Doorway, Room};
use std::collections::HashMap;
use workshop::Workshop;

/// Seed of the built-in palace.
pub(crate) const SEED: u64 = 1_783;

/// Builds the palace. Paintings and the positions of small items depend on the seed; rooms and doors do not.
pub(crate) fn palace(seed: u64) -> BuiltIn {
    let mut scene = SceneBuilder::new();
    let mut shop = Workshop::default();
    let mut random = Random::new(seed);
    let mut door_ends: Vec<Vec<(SectorId, OpeningId)>> = vec![Vec::new(); DOORS.len()];
    let mut doll_house_front = None;
    // One-way portals, with the rooms they lead to.
    let mut one_way = Vec::new();
    let mut ids = HashMap::new();
    for (name, design) in Name::ALL.into_iter().zip(ROOMS) {
        let mut room = Room::new(design, &mut shop, Random::new(random.bits()));
        let mut openings = Vec::new();
        for (number, door) in DOORS.iter().enumerate() {
            if door.from == name || door.to == name {
                openings.push((number, open(&mut room, door.name, &door.gate, door.from == name)));
            }
        }
        if name == Name::Study {
            doll_house_front = Some(doll_house::stand(&mut room));
        }
        let leaves = match name {
            Name::SecretPassage => Some((
                secret::way_out(&mut room),
                Name::Library,
                secret::library_from_here(),
            )),
            Name::PictureRoom => Some((
                living_picture::hang(&mut room),
                Name::Court,
                living_picture::court_from_here(),
            )),
            _ => None,
        };
        rooms::furnish(&mut room, name);
        let id = if name == Name::Garden {
            // Walls on two sides only; the ground closes the rest.
            let closed = room.close_beside(&park::WALLS);
            closed.seen_by(Method::FloatingHorizon, &mut scene, design.name)
        } else {
            room.close().add_to(&mut scene, design.name)
        };
        ids.insert(name, id);
        one_way.extend(leaves.map(|(opening, to, there_from_here)| ((id, opening), to, there_from_here)));
        for (door, opening) in openings {
            door_ends[door].push((id, opening));
        }
        if let (Name::Study, Some(front)) = (name, doll_house_front) {
            doll_house::join(
                &mut scene,
                (id, front),
                &doll_house::doll_house(&mut shop, random.bits()),
            );
        }
    }
    // The fountain changes every frame, so it uses a method without precomputation.
    let id = scene.add(fountain::GROTTO.name, fountain::fountain(), Method::ZBuffer);
    for lamp in fountain::lamps() {
        scene.light(lamp.in_sector(id));
    }
    let arches = (0..DOORS.len()).filter(|&number| DOORS[number].to == Name::Fountain);
    for (opening, number) in arches.enumerate() {
        door_ends[number].push((id, OpeningId(opening as u16)));
    }
    for cell in cells::CELLS {
        let (closed, openings) = cell.build(&mut shop);
        let id = closed.seen_by(Method::Cell, &mut scene, cell.title);
        for (door, opening) in openings {
            door_ends[door].push((id, opening));
        }
    }
    for (from, to, there_from_here) in one_way {
        scene.portal(from, ids[&to], there_from_here);
    }
    for ends in door_ends {
        let [a, b] = ends.try_into().expect("a door has two sides");
        scene.door(a, b);
    }
    BuiltIn {
        scene: scene.build().expect("the palace stands"),
        cameras: cameras::cameras(),
    }
}

/// Cuts a gate into a room, which is the gate's near room if `near` is set, else the far one. The opening faces the
/// room.
fn open(room: &mut Room, name: &str, gate: &Gate, near: bool) -> OpeningId {
    let at = Vec2::from(gate.at);
    let mut outline = gate.outline();
    let side = if near { gate.looks } else { gate.looks.opposite() };
    if !near {
        outline.reverse();
    }
    let wall = room.wall(side);
    let Gate {
        width,
        sill,
        spring,
        rise,
        ..
    } = *gate;
    let doorway = Doorway {
        wall: room.design.plan.wall(side),
        along: wall.along(at),
        width,
        sill,
        spring,
        rise,
        depth: (at - wall.left).dot(side.direction()),
    };
    room.doorway(doorway, outline.clone());
    room.opening(name, &outline)
}
