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
fn where_portals_lead_farther_than_looks_follow_nothing_is_hidden() {
    let mut house = a_house();
    let passages = |house: &mut House, max: u32| {
        let mut settings = house.app.world_mut().resource_mut::<EnfiladeSettings>();
        settings.options.limits.max_passages = max;
    };
    // The first is the room of the camera.
    passages(&mut house, 1);
    assert!(house.sees(house.beside) && house.sees(house.in_line));
    assert_eq!(
        house
            .app
            .world()
            .resource::<EnfiladeCameras>()
            .hidden(house.camera),
        []
    );
    passages(&mut house, 2);
    assert!(house.sees(house.in_line) && !house.sees(house.beside));
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

#[test]
fn a_doorway_joins_its_rooms_wherever_it_is_in_their_wall() {
    for case in 0..162 {
        let [wall_of, owner, offset, turned, names_to] =
            [case % 3, case / 3 % 3, case / 9 % 3, case / 27 % 2, case / 54 % 3];
        let mut app = an_app();
        let cameras = [(0.0, 0.0), (-6.0, std::f32::consts::PI)].map(|(z, turn)| {
            let place = at(0.0, 1.5, z).with_rotation(Quat::from_rotation_y(turn));
            add_camera(&mut app, place)
        });
        let floor = add_mesh(&mut app, a_box(Vec3::new(3.0, 0.05, 2.9)));
        let small = add_mesh(&mut app, a_box(Vec3::splat(0.2)));
        let jamb = add_mesh(&mut app, a_box(Vec3::new(1.25, 1.5, 0.1)));
        let rooms = [0.0, -6.0].map(|z| {
            let room = app.world_mut().spawn((Sector, at(0.0, 0.0, z))).id();
            for y in [0.0, 3.0] {
                let part = (Mesh3d(floor.clone()), at(0.0, y, 0.0), ChildOf(room));
                app.world_mut().spawn(part);
            }
            room
        });
        let ends = [-5.0_f32, -1.0].map(|z| {
            let room = usize::from(z < -3.0);
            let place = at(0.0, 1.0, z + 6.0 * room as f32);
            app.world_mut()
                .spawn((Mesh3d(small.clone()), place, ChildOf(rooms[room])))
                .id()
        });
        let yard = app
            .world_mut()
            .spawn((Mesh3d(small.clone()), at(0.0, 1.0, -20.0)))
            .id();
        let below = |entity: &mut EntityWorldMut, owner: usize, z: f32| {
            match rooms.get(owner) {
                Some(&room) => entity.insert((
                    at(
                        entity.get::<Transform>().map_or(0.0, |at| at.translation.x),
                        1.5,
                        z + 6.0 * owner as f32,
                    ),
                    ChildOf(room),
                )),
                None => entity,
            };
        };
        for x in [-1.75, 1.75] {
            let mut part = app.world_mut().spawn((Mesh3d(jamb.clone()), at(x, 1.5, -3.0)));
            below(&mut part, wall_of, -3.0);
        }
        let z = -3.0 + 0.1 * (offset as f32 - 1.0);
        let mut portal = Portal::rectangle(Vec2::new(1.0, 3.0));
        // Without an owner, it is the one in which the other end is.
        portal.to = (names_to > 0).then(|| rooms[if owner < 2 { 1 - owner } else { names_to - 1 }]);
        let mut door = app.world_mut().spawn((portal, at(0.0, 1.5, z)));
        below(&mut door, owner, z);
        if turned == 1
            && let Some(mut place) = door.get_mut::<Transform>()
        {
            place.rotation = Quat::from_rotation_y(std::f32::consts::PI);
        }
        app.update();
        for (camera, end) in cameras.into_iter().zip(ends) {
            let seen = visible(&app, camera);
            assert!(seen.contains(&end), "case {case}");
            assert!(!seen.contains(&yard), "case {case}: it is not linked");
        }
    }
}

#[test]
fn a_doorway_in_the_middle_of_a_room_hides_nothing() {
    let mut house = a_house();
    let place = at(0.0, 1.0, 0.5);
    house.app.world_mut().entity_mut(house.door).insert(place);
    assert!(house.sees(house.beside) && house.sees(house.in_yard));
    // In a wall that it does not know, but with a name for where it leads.
    let mut door = house
        .app
        .world_mut()
        .get_mut::<Portal>(house.door)
        .expect("a door");
    door.to = Some(house.rooms[1]);
    house
        .app
        .world_mut()
        .entity_mut(house.door)
        .insert(at(0.0, 1.0, -2.0));
    assert!(house.sees(house.in_line) && house.sees(house.in_yard));
    let turned = at(0.0, 1.5, 0.0).with_rotation(Quat::from_rotation_y(std::f32::consts::PI));
    house.app.world_mut().entity_mut(house.camera).insert(turned);
    house.app.update();
    let cameras = house.app.world().resource::<EnfiladeCameras>();
    assert!(cameras.visible_set(house.camera).is_some(), "culled for again");
}

#[test]
fn a_frozen_set_stays_where_no_room_is() {
    let mut house = a_house();
    house.app.update();
    let before = visible(&house.app, house.camera);
    house
        .app
        .world_mut()
        .entity_mut(house.camera)
        .insert(FreezeVisibility);
    house.app.update();
    let far = at(0.0, 9.0, 9.0).looking_at(Vec3::new(0.0, 0.0, -6.0), Vec3::Y);
    house.app.world_mut().entity_mut(house.camera).insert(far);
    house.app.update();
    let frozen = visible(&house.app, house.camera);
    assert!(!frozen.is_empty() && frozen.iter().all(|entity| before.contains(entity)));
    house
        .app
        .world_mut()
        .entity_mut(house.camera)
        .remove::<FreezeVisibility>();
    assert!(
        house.sees(house.beside),
        "no portal leads outdoors, so it is left alone"
    );
}
