//! Two rooms and the doorway between them: prints what a camera sees that walks from one into the other.
//!
//! `cargo run --no-default-features --example rooms`; an app with a window adds Bevy's `DefaultPlugins` in the place of those
//! below.
#![expect(clippy::print_stdout, reason = "examples print")]

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets};
use bevy_camera::primitives::Frustum;
use bevy_camera::visibility::{VisibilityPlugin, VisibleEntities};
use bevy_camera::{
    Camera, CameraProjection, CameraProjectionPlugin, PerspectiveProjection, Projection, RenderTargetInfo,
};
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_math::primitives::Cuboid;
use bevy_math::{UVec2, Vec2, Vec3};
use bevy_mesh::{Mesh, Mesh3d, MeshPlugin};
use bevy_transform::TransformPlugin;
use bevy_transform::prelude::Transform;
use enfilade_bevy::{EnfiladePlugin, EnfiladeScene, Occluder, Portal, Sector, SectorVisibilityChanged};
use std::any::TypeId;

fn main() {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        AssetPlugin::default(),
        TransformPlugin,
        MeshPlugin,
        VisibilityPlugin,
        CameraProjectionPlugin,
        EnfiladePlugin::default(),
    ));
    let world = app.world_mut();
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let mut cuboid = |x, y, z| meshes.add(Cuboid::new(x, y, z));
    let [floor, jamb, lamp] = [
        cuboid(6.0, 0.1, 5.8),
        cuboid(2.5, 3.0, 0.2),
        cuboid(0.3, 0.3, 0.3),
    ];
    let at = Transform::from_xyz;
    let room = |world: &mut World, name: &'static str, z| {
        let room = world.spawn((Name::new(name), Sector, at(0.0, 0.0, z))).id();
        for y in [0.0, 3.0] {
            world.spawn((
                Mesh3d(floor.clone()),
                Occluder::OneSided,
                at(0.0, y, 0.0),
                ChildOf(room),
            ));
        }
        room
    };
    let hall = room(world, "hall", 0.0);
    let study = room(world, "study", -6.0);
    // Below no room: the wall is seen from both.
    for x in [-1.75, 1.75] {
        world.spawn((Mesh3d(jamb.clone()), Occluder::OneSided, at(x, 1.5, -3.0)));
    }
    world.spawn((
        Portal::rectangle(Vec2::new(1.0, 3.0)),
        at(0.0, 1.5, -3.0),
        ChildOf(hall),
    ));
    world.spawn((
        Name::new("lamp beside the doorway"),
        Mesh3d(lamp.clone()),
        at(2.0, 1.5, 2.0),
        ChildOf(study),
    ));
    world.spawn((
        Name::new("lamp behind the doorway"),
        Mesh3d(lamp),
        at(0.0, 1.5, 0.0),
        ChildOf(study),
    ));
    let camera = world.spawn(a_camera()).id();
    for step in 0..7 {
        let eye = Vec3::new(1.5, 1.5, 2.0).lerp(Vec3::new(-0.2, 1.5, -5.0), step as f32 / 6.0);
        app.world_mut()
            .entity_mut(camera)
            .insert(Transform::from_translation(eye));
        app.update();
        let mut messages = app
            .world_mut()
            .resource_mut::<Messages<SectorVisibilityChanged>>();
        let changed: Vec<_> = messages.drain().collect();
        let world = app.world();
        let name = |entity: Entity| world.get::<Name>(entity).map_or("a wall", |name| name.as_str());
        let visible = world
            .get::<VisibleEntities>(camera)
            .expect("a camera")
            .get(TypeId::of::<Mesh3d>());
        let lamps = visible.iter().filter(|&&entity| name(entity).starts_with("lamp"));
        let lamps: Vec<&str> = lamps.map(|&entity| name(entity)).collect();
        println!(
            "at {eye:.1}: {} meshes are drawn, among them {lamps:?}",
            visible.len()
        );
        for message in changed {
            let verb = if message.visible {
                "came into"
            } else {
                "went out of"
            };
            println!("  the {} {verb} sight", name(message.sector));
        }
        let lamp = Vec3::new(2.0, 1.5, -4.0);
        if let Some(before) = world.resource::<EnfiladeScene>().first_between(eye, lamp) {
            println!("  in front of the lamp beside the doorway: {}", name(before));
        }
    }
}

/// A camera as Bevy's renderer keeps it for a window of 640x480 pixels.
fn a_camera() -> impl Bundle {
    let projection = PerspectiveProjection {
        aspect_ratio: 4.0 / 3.0,
        ..PerspectiveProjection::default()
    };
    let mut camera = Camera::default();
    camera.computed.clip_from_view = projection.get_clip_from_view();
    camera.computed.target_info = Some(RenderTargetInfo {
        physical_size: UVec2::new(640, 480),
        scale_factor: 1.0,
    });
    (
        camera,
        Projection::Perspective(projection),
        Frustum::default(),
        VisibleEntities::default(),
        Transform::default(),
    )
}
