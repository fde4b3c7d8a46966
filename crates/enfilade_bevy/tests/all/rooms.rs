use crate::world::*;
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec2, Vec3};
use bevy_mesh::Mesh3d;
use bevy_transform::prelude::Transform;
use enfilade_bevy::*;

fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::from_xyz(x, y, z)
}

/// Two rooms in a row along −Z, 6 m long, with a door of 1 m between them at z = −3, and a yard around them.
struct House {
    app: bevy_app::App,
    camera: Entity,
    rooms: [Entity; 2],
    door: Entity,
    /// One in each room: in line with the door, and beside it.
    in_line: Entity,
    beside: Entity,
    in_yard: Entity,
}

fn a_house() -> House {
    let mut app = an_app();
    let camera = add_camera(&mut app, at(0.0, 1.5, 0.0));
    let floor = add_mesh(&mut app, a_box(Vec3::new(3.0, 0.05, 3.0)));
    let ceiling = Mesh3d(floor.clone());
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.2)));
    let rooms = [0.0, -6.0].map(|z| {
        let room = app.world_mut().spawn((Sector, at(0.0, 0.0, z))).id();
        app.world_mut()
            .spawn((Mesh3d(floor.clone()), at(0.0, 0.0, 0.0), ChildOf(room)));
        app.world_mut()
            .spawn((ceiling.clone(), at(0.0, 3.0, 0.0), ChildOf(room)));
        room
    });
    let door = Portal::rectangle(Vec2::new(1.0, 2.0));
    let door = (door, at(0.0, 1.0, -3.0), ChildOf(rooms[0]));
    let door = app.world_mut().spawn(door).id();
    let mut put = |place, room: Option<Entity>| {
        let mut entity = app.world_mut().spawn((Mesh3d(small.clone()), place));
        if let Some(room) = room {
            entity.insert(ChildOf(room));
        }
        entity.id()
    };
    House {
        in_line: put(at(0.0, 1.0, -1.0), Some(rooms[1])),
        beside: put(at(2.0, 1.0, 2.5), Some(rooms[1])),
        in_yard: put(at(0.0, 1.0, -20.0), None),
        app,
        camera,
        rooms,
        door,
    }
}

impl House {
    fn sees(&mut self, entity: Entity) -> bool {
        self.app.update();
        visible(&self.app, self.camera).contains(&entity)
    }
}

#[test]
fn a_door_shows_what_is_in_line_with_it_and_nothing_while_it_is_closed() {
    let mut house = a_house();
    assert!(house.sees(house.in_line));
    assert!(!house.sees(house.beside));
    assert!(!house.sees(house.in_yard), "no portal leads there");
    let set_open = |house: &mut House, open| {
        let mut door = house
            .app
            .world_mut()
            .get_mut::<Portal>(house.door)
            .expect("a door");
        door.open = open;
    };
    set_open(&mut house, false);
    assert!(!house.sees(house.in_line));
    let scene = house.app.world().resource::<EnfiladeScene>().scene();
    assert_eq!(scene.portals().len(), 2, "the same portals as before");
    set_open(&mut house, true);
    assert!(house.sees(house.in_line));
    // From behind it: the door is seen through both ways, and the camera is in the room that it is in.
    let turned = at(0.0, 1.5, -6.0).with_rotation(Quat::from_rotation_y(std::f32::consts::PI));
    house.app.world_mut().entity_mut(house.camera).insert(turned);
    assert!(house.sees(house.beside), "it is in the same room now");
}

#[test]
fn rooms_say_that_they_came_into_sight() {
    let mut house = a_house();
    house.app.update();
    let mut messages = house
        .app
        .world_mut()
        .resource_mut::<Messages<SectorVisibilityChanged>>();
    let mut said: Vec<_> = messages.drain().map(|said| (said.sector, said.visible)).collect();
    said.sort_unstable();
    let mut expected = house.rooms.map(|room| (room, true));
    expected.sort_unstable();
    assert_eq!(said, expected);
}

#[test]
fn what_moves_is_in_every_room_that_it_reaches_into() {
    let mut house = a_house();
    let walker = house.in_yard;
    for (z, is_seen) in [(-6.0, true), (-2.0, true), (-20.0, false), (-4.0, true)] {
        house.app.world_mut().entity_mut(walker).insert(at(0.0, 1.0, z));
        assert_eq!(house.sees(walker), is_seen, "{z}");
    }
}

#[test]
fn a_room_without_its_mark_is_outdoors_and_a_camera_outdoors_sees_it() {
    let mut house = a_house();
    house.app.update();
    for room in house.rooms {
        house.app.world_mut().entity_mut(room).remove::<Sector>();
    }
    house.app.world_mut().despawn(house.door);
    assert!(house.sees(house.beside) && house.sees(house.in_line));
    assert!(house.sees(house.in_yard));
    // And back again.
    for room in house.rooms {
        house.app.world_mut().entity_mut(room).insert(Sector);
    }
    assert!(!house.sees(house.in_yard));
    assert!(!house.sees(house.in_line), "there is no door any more");
}

#[test]
fn while_a_portal_leads_nowhere_nothing_is_hidden() {
    let mut house = a_house();
    let lost = Portal::rectangle(Vec2::ONE);
    let lost = house.app.world_mut().spawn((lost, at(500.0, 0.0, 0.0))).id();
    assert!(house.sees(house.beside));
    house.app.world_mut().despawn(lost);
    assert!(!house.sees(house.beside));
}

#[test]
fn a_window_leads_outdoors() {
    let mut house = a_house();
    let window = Portal::rectangle(Vec2::new(1.0, 1.0));
    let place = at(0.0, 1.5, -3.0);
    house
        .app
        .world_mut()
        .spawn((window, place, ChildOf(house.rooms[1])));
    assert!(
        house.sees(house.in_yard),
        "through the door and the window behind it"
    );
}

#[test]
fn a_mirror_shows_what_is_behind_the_camera() {
    let mut house = a_house();
    let back = house
        .app
        .world_mut()
        .spawn((Transform::IDENTITY, ChildOf(house.rooms[0])))
        .id();
    let place = at(2.9, 1.5, 0.0).with_rotation(Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2));
    let mirror = (Mirror::rectangle(Vec2::new(4.0, 2.0)), place, ChildOf(back));
    let small = add_mesh(&mut house.app, a_box(Vec3::splat(0.2)));
    let left = (Mesh3d(small), at(-2.0, 1.5, 0.0), ChildOf(house.rooms[0]));
    let left = house.app.world_mut().spawn(left).id();
    let right = Transform::from_rotation(Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2));
    house
        .app
        .world_mut()
        .entity_mut(house.camera)
        .insert(right.with_translation(Vec3::new(0.0, 1.5, 0.0)));
    house.app.update();
    let sees = |house: &House| {
        let cameras = house.app.world().resource::<EnfiladeCameras>();
        let set = cameras.visible_set(house.camera).expect("it is culled");
        set.items().iter().any(|item| item.key == left.to_bits())
    };
    assert!(!sees(&house));
    house.app.world_mut().spawn(mirror);
    house.app.update();
    assert!(sees(&house));
}
