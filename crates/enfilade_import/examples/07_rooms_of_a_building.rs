//! Walks through a building: which room it is, what is heard, and which doors must open. Run: cargo run --release
//! --example 07_rooms_of_a_building -p enfilade_import -- building.glb

#![allow(clippy::print_stdout, reason = "an example prints what it finds")]

use enfilade::{Method, Scene};
use enfilade_bake::{
    DoorId, DoorKind, RoomGraph, RoomOptions, RoomTracker, SoundLoss, find_rooms, is_door_name,
};
use enfilade_import::{ReadOptions, SceneRoomItems, read};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = match std::env::args().nth(1) {
        Some(file) => {
            read(file.as_ref(), &ReadOptions::default())?.scene(Method::ZBuffer, Method::DEFAULT_LIMIT)?
        }
        None => enfilade_scenes::built_in("house").ok_or("no house")?.scene,
    };
    let mut rooms = rooms_of(&scene)?;

    // The largest rooms: a radio plays in one, and a listener walks there from the other.
    let mut indoors: Vec<_> = rooms
        .rooms()
        .iter()
        .zip(0..)
        .filter(|(_, id)| rooms.outside().map(|room| room.0) != Some(*id))
        .collect();
    indoors.sort_by(|a, b| b.0.area.total_cmp(&a.0.area));
    let middle = |place: usize| {
        let [low, high] = indoors.get(place)?.0.bounds;
        Some([0, 1, 2].map(|axis| 0.5 * (low[axis] + high[axis])))
    };
    let (Some(radio), Some(start)) = (middle(0), middle(1)) else {
        return Err("it has fewer than two rooms".into());
    };
    let loss = SoundLoss::default();
    println!(
        "through closed doors the radio seems {:.0} m away",
        rooms.heard_from(start, radio, &loss).unwrap_or(f64::INFINITY)
    );

    // Open the doors on the way, and no others.
    let is_passable = |door: DoorId| {
        matches!(
            rooms.doors()[door.0 as usize].kind,
            DoorKind::Door | DoorKind::Opening
        )
    };
    let Some(path) = rooms.path_by(start, radio, |door| is_passable(door).then_some(0.0)) else {
        return Err("no way leads there".into());
    };
    for &door in &path.doors {
        rooms.set_open(door, true);
    }
    println!(
        "doors and openings on the way of {1:.1} m: {0}; rooms that may be seen from the start: {2}",
        path.doors.len(),
        path.length,
        rooms.relevant(rooms.room_at(start).ok_or("no room")?).len()
    );

    // Walk from door to door in steps of half a metre.
    let mut stops: Vec<[f64; 3]> = vec![start];
    stops.extend(
        path.doors
            .iter()
            .map(|door| rooms.doors()[door.0 as usize].middle()),
    );
    stops.push(radio);
    let mut tracker = RoomTracker::default();
    for leg in stops.windows(2) {
        for step in 0..=20 {
            let at =
                [0, 1, 2].map(|axis| leg[0][axis] + f64::from(step) / 20.0 * (leg[1][axis] - leg[0][axis]));
            if let Some(change) = tracker.moved(&rooms, at)
                && let Some(room) = change.entered
            {
                let name = &rooms.rooms()[room.0 as usize].name;
                println!(
                    "enters {name}; the radio seems {:.0} m away",
                    rooms.heard_from(at, radio, &loss).unwrap_or(f64::INFINITY)
                );
            }
        }
    }
    Ok(())
}

fn rooms_of(scene: &Scene) -> Result<RoomGraph, Box<dyn Error>> {
    let name = |sector, item| scene.geometry(sector).map_or("", |geometry| geometry.name(item));
    let items = SceneRoomItems::of(scene, |sector, item| is_door_name(name(sector, item)));
    Ok(find_rooms(&items.input, &RoomOptions::default())?.graph)
}
