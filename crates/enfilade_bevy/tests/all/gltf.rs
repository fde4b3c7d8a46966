use crate::world::*;
use bevy_ecs::prelude::*;
use bevy_gltf::GltfExtras;
use bevy_math::{Quat, Vec3};
use bevy_mesh::{Mesh, Mesh3d};
use bevy_transform::prelude::Transform;
use enfilade_bevy::*;

fn extras(value: &str) -> GltfExtras {
    GltfExtras {
        value: value.to_owned(),
    }
}

fn a_doorway() -> Mesh {
    let corners = [
        [-0.5, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [0.5, 2.0, 0.0],
        [-0.5, 2.0, 0.0],
    ];
    a_mesh(corners.to_vec(), vec![0, 1, 2, 0, 2, 3])
}

/// Two rooms as Bevy's loader makes them of a file: nodes with extras, and meshes below them.
struct File {
    app: bevy_app::App,
    camera: Entity,
    in_line: Entity,
    beside: Entity,
    doorway: Entity,
}

fn a_file(portal: &str, doorway: Mesh) -> File {
    let mut app = an_app();
    let camera = add_camera(&mut app, Transform::from_xyz(0.0, 1.5, 0.0));
    let floor = add_mesh(&mut app, a_box(Vec3::new(3.0, 0.05, 3.0)));
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.2)));
    let doorway = add_mesh(&mut app, doorway);
    let root = app.world_mut().spawn(Transform::from_xyz(0.0, 0.0, -3.0)).id();
    let rooms = [3.0, -3.0].map(|z| {
        let name = if z > 0.0 { "Hall" } else { "Study" };
        let room = (
            Name::new(name),
            extras(r#"{"enfilade": {"kind": "room", "method": "z-buffer"}}"#),
            Transform::from_xyz(0.0, 0.0, z),
            ChildOf(root),
        );
        let room = app.world_mut().spawn(room).id();
        for y in [0.0, 3.0] {
            let part = (
                Mesh3d(floor.clone()),
                Transform::from_xyz(0.0, y, 0.0),
                ChildOf(room),
            );
            app.world_mut().spawn(part);
        }
        room
    });
    let turned = Transform::from_rotation(Quat::from_rotation_y(std::f32::consts::PI));
    let node = (Name::new("door"), extras(portal), turned, ChildOf(root));
    let node = app.world_mut().spawn(node).id();
    let doorway = app
        .world_mut()
        .spawn((Mesh3d(doorway), Transform::default(), ChildOf(node)))
        .id();
    let mut put = |x, z| {
        let place = Transform::from_xyz(x, 1.0, z);
        app.world_mut()
            .spawn((Mesh3d(small.clone()), place, ChildOf(rooms[1])))
            .id()
    };
    File {
        in_line: put(0.0, 2.0),
        beside: put(2.0, 2.5),
        app,
        camera,
        doorway,
    }
}

impl File {
    /// Updates, and returns which of the two items and of the doorway's mesh are drawn.
    fn drawn(&mut self) -> [bool; 3] {
        self.app.update();
        let seen = visible(&self.app, self.camera);
        [self.in_line, self.beside, self.doorway].map(|entity| seen.contains(&entity))
    }
}

#[test]
fn rooms_and_portals_of_a_file_are_there_and_nothing_is_missed_before() {
    let mut file = a_file(r#"{"enfilade": {"kind": "portal", "to": "Study"}}"#, a_doorway());
    for frame in 0..3 {
        assert!(file.drawn()[0], "frame {frame}");
    }
    assert_eq!(file.drawn(), [true, false, false]);
    let rooms = file
        .app
        .world_mut()
        .query::<&Sector>()
        .iter(file.app.world())
        .count();
    assert_eq!(rooms, 2);
}

#[test]
fn while_a_portal_of_a_file_is_incomplete_nothing_is_hidden() {
    let bent = {
        let corners = [
            [-0.5, 0.0, 0.0],
            [0.5, 0.0, 0.4],
            [0.5, 2.0, 0.0],
            [-0.5, 2.0, 0.4],
        ];
        a_mesh(corners.to_vec(), vec![0, 1, 2, 0, 2, 3])
    };
    let unknown = r#"{"enfilade": {"kind": "portal", "to": "Cellar"}}"#;
    let known = r#"{"enfilade": {"kind": "portal", "to": "Study"}}"#;
    for (portal, mesh) in [(unknown, a_doorway()), (known, bent)] {
        let mut file = a_file(portal, mesh);
        for frame in 0..4 {
            assert_eq!(file.drawn()[..2], [true; 2], "{portal}, frame {frame}");
        }
    }
}
