use crate::world::*;
use bevy_app::App;
use bevy_asset::{Assets, Handle};
use bevy_camera::visibility::{RenderLayers, ViewVisibility, Visibility};
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_mesh::{Mesh, Mesh3d};
use bevy_transform::prelude::Transform;
use enfilade_bevy::*;
use fastrand::Rng;
use std::collections::BTreeSet;

fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::from_xyz(x, y, z)
}

#[test]
fn a_crate_behind_a_wall_is_not_drawn_until_the_wall_is_gone() {
    let mut app = an_app();
    let wall = add_mesh(&mut app, a_box(Vec3::new(4.0, 3.0, 0.1)));
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.5)));
    let camera = add_camera(&mut app, Transform::IDENTITY);
    let wall = app
        .world_mut()
        .spawn((Mesh3d(wall), Occluder::OneSided, at(0.0, 0.0, -5.0)))
        .id();
    let behind = app
        .world_mut()
        .spawn((Mesh3d(small.clone()), at(0.0, 0.0, -9.0)))
        .id();
    let before = app.world_mut().spawn((Mesh3d(small), at(1.0, 0.0, -3.0))).id();
    app.update();
    assert_eq!(visible(&app, camera), sorted([wall, before]));
    let stats = app.world().resource::<EnfiladeCameras>().stats();
    assert_eq!((stats.cameras, stats.visible, stats.hidden), (1, 2, 1));
    assert_eq!(app.world().resource::<EnfiladeCameras>().hidden(camera), [behind]);
    // It is one flag for all views, and shadows go by it.
    assert!(app.world().get::<ViewVisibility>(behind).expect("a flag").get());

    app.world_mut().entity_mut(wall).insert(NotOccluder);
    app.update();
    assert_eq!(visible(&app, camera), sorted([wall, before, behind]));
    app.world_mut().entity_mut(wall).remove::<NotOccluder>();
    app.update();
    assert_eq!(visible(&app, camera), sorted([wall, before]));

    set_enabled(&mut app, false);
    app.update();
    assert_eq!(visible(&app, camera).len(), 3);
    app.world_mut().despawn(before);
    set_enabled(&mut app, true);
    app.update();
    assert_eq!(visible(&app, camera), [wall]);

    app.world_mut().entity_mut(camera).insert(NoVisibilityCulling);
    app.update();
    assert_eq!(visible(&app, camera).len(), 2);
    app.world_mut().entity_mut(camera).remove::<NoVisibilityCulling>();
    app.world_mut().despawn(wall);
    app.update();
    assert_eq!(visible(&app, camera), [behind]);
}

fn sorted<const N: usize>(mut entities: [Entity; N]) -> [Entity; N] {
    entities.sort_unstable();
    entities
}

#[test]
fn messages_say_what_came_into_sight_and_what_went() {
    let mut app = an_app();
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.5)));
    let wall = add_mesh(&mut app, a_box(Vec3::new(4.0, 3.0, 0.1)));
    let camera = add_camera(&mut app, Transform::IDENTITY);
    let entity = app.world_mut().spawn((Mesh3d(small), at(0.0, 0.0, -9.0))).id();
    let mut said = || {
        app.update();
        let mut messages = app
            .world_mut()
            .resource_mut::<Messages<EntityVisibilityChanged>>();
        let said: Vec<_> = messages.drain().map(|said| (said.entity, said.visible)).collect();
        said
    };
    assert_eq!(said(), [(entity, true)]);
    assert_eq!(said(), []);
    let wall = Mesh3d(wall);
    let wall = app
        .world_mut()
        .spawn((wall, Occluder::OneSided, at(0.0, 0.0, -5.0)))
        .id();
    let mut said = || {
        app.update();
        let mut messages = app
            .world_mut()
            .resource_mut::<Messages<EntityVisibilityChanged>>();
        let said: BTreeSet<_> = messages.drain().map(|said| (said.entity, said.visible)).collect();
        said
    };
    assert_eq!(said(), BTreeSet::from([(wall, true), (entity, false)]));
    let scene = app.world().resource::<EnfiladeScene>();
    let between = |z| scene.first_between(Vec3::ZERO, Vec3::new(0.0, 0.0, z));
    assert_eq!([between(-4.0), between(-9.0)], [None, Some(wall)]);
    app.world_mut()
        .entity_mut(camera)
        .insert(Transform::from_rotation(Quat::from_rotation_y(3.0)));
    app.update();
    let messages = app.world().resource::<Messages<EntityVisibilityChanged>>();
    let mut cursor = messages.get_cursor();
    assert_eq!(
        cursor.read(messages).filter(|said| !said.visible).count(),
        1,
        "the wall"
    );
    // Nothing is hidden while culling is off.
    app.world_mut().entity_mut(camera).insert(Transform::IDENTITY);
    app.update();
    for (enabled, visible) in [(false, true), (true, false)] {
        set_enabled(&mut app, enabled);
        app.world_mut()
            .resource_mut::<Messages<EntityVisibilityChanged>>()
            .clear();
        app.update();
        let mut messages = app
            .world_mut()
            .resource_mut::<Messages<EntityVisibilityChanged>>();
        let said: Vec<_> = messages.drain().map(|said| (said.entity, said.visible)).collect();
        assert_eq!(said, [(entity, visible)]);
    }
}

#[test]
fn a_frozen_set_stays_while_the_camera_goes_on() {
    let mut app = an_app();
    let wall = add_mesh(&mut app, a_box(Vec3::new(4.0, 3.0, 0.1)));
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.5)));
    let camera = add_camera(&mut app, Transform::IDENTITY);
    let wall = (Mesh3d(wall), Occluder::OneSided, at(0.0, 0.0, -5.0));
    let wall = app.world_mut().spawn(wall).id();
    let behind = app.world_mut().spawn((Mesh3d(small), at(0.0, 0.0, -9.0))).id();
    app.update();
    app.world_mut().entity_mut(camera).insert(FreezeVisibility);
    app.update();
    // From above, it is in view, but was not.
    let above = at(0.0, 8.0, 0.0).looking_at(Vec3::new(0.0, 0.0, -9.0), Vec3::Y);
    app.world_mut().entity_mut(camera).insert(above);
    app.update();
    assert_eq!(visible(&app, camera), [wall]);
    assert!(
        app.world()
            .resource::<EnfiladeCameras>()
            .frozen_view(camera)
            .is_some()
    );
    app.world_mut().entity_mut(camera).remove::<FreezeVisibility>();
    app.update();
    assert_eq!(visible(&app, camera), sorted([wall, behind]));
}

/// Changes a random world for some frames, and compares each with rays.
#[test]
fn a_world_that_changes_never_loses_what_its_cameras_see() {
    for seed in 0..6 {
        let mut random = Rng::with_seed(seed);
        let mut app = an_app();
        let samples = [Samples::Centers, Samples::Four, Samples::Any][seed as usize % 3];
        app.world_mut().resource_mut::<EnfiladeSettings>().samples = Some(samples);
        let meshes: Vec<_> = (0..5)
            .map(|_| {
                let half = Vec3::new(random.f32(), random.f32(), random.f32()) * 2.0 + 0.1;
                add_mesh(&mut app, a_box(half))
            })
            .collect();
        let cameras = [-1.0, 1.0].map(|x| add_camera(&mut app, at(x, 0.0, 4.0)));
        app.world_mut()
            .entity_mut(cameras[1])
            .insert(RenderLayers::from_layers(&[0, 3]));
        let mut entities: Vec<Entity> = Vec::new();
        let mut hidden = 0;
        for frame in 0..20 {
            if frame == 0 {
                (0..90).for_each(|_| spawn(&mut app, &mut random, &meshes, &mut entities));
            }
            (0..12).for_each(|_| change(&mut app, &mut random, &meshes, &mut entities));
            if random.u8(..8) == 0 {
                let half = Vec3::splat(random.f32() + 0.1);
                let mut assets = app.world_mut().resource_mut::<Assets<Mesh>>();
                let _ = assets.insert(meshes[random.usize(..5)].id(), a_box(half));
            }
            set_enabled(&mut app, random.u8(..10) > 0);
            app.update();
            for camera in cameras {
                let name = format!("seed {seed}, frame {frame}");
                check(&mut app, camera, samples, &mut random, &name);
            }
            hidden += app.world().resource::<EnfiladeCameras>().stats().hidden;
        }
        assert!(hidden > 200, "seed {seed} hides only {hidden}");
    }
}

fn place(random: &mut Rng) -> Transform {
    let mut between = |low: f32, high: f32| low + (high - low) * random.f32();
    let position = Vec3::new(between(-6.0, 6.0), between(-4.0, 4.0), between(-14.0, 1.0));
    let axis = Vec3::new(between(0.0, 1.0), between(0.0, 1.0), between(0.1, 1.0)).normalize();
    let turn = Quat::from_axis_angle(axis, between(0.0, 6.0));
    let mut place = Transform::from_translation(position).with_rotation(turn);
    if random.u8(..8) == 0 {
        // Mirrored, or flat.
        place.scale = Vec3::new([-1.0, 0.0][random.usize(..2)], 1.5, 1.0);
    }
    place
}

fn spawn(app: &mut App, random: &mut Rng, meshes: &[Handle<Mesh>], all: &mut Vec<Entity>) {
    let mesh = Mesh3d(meshes[random.usize(..meshes.len())].clone());
    let mut entity = app.world_mut().spawn((mesh, place(random)));
    if random.u8(..4) > 0 {
        entity.insert(Occluder::OneSided);
    }
    all.push(entity.id());
}

fn change(app: &mut App, random: &mut Rng, meshes: &[Handle<Mesh>], all: &mut Vec<Entity>) {
    let number = random.usize(..all.len());
    if random.bool() {
        return spawn(app, random, meshes, all);
    }
    let mut entity = app.world_mut().entity_mut(all[number]);
    match random.u8(..8) {
        0..=2 => {
            entity.despawn();
            all.swap_remove(number);
        }
        3 => {
            entity.insert(place(random));
        }
        4 => {
            entity.insert([Visibility::Hidden, Visibility::Inherited][random.usize(..2)]);
        }
        5 => {
            match random.u8(..4) {
                0 => entity.insert(NotOccluder),
                1 => entity.remove::<NotOccluder>(),
                2 => entity.remove::<Occluder>(),
                _ => entity.insert(Occluder::TwoSided),
            };
        }
        6 => {
            let layers: [&[usize]; 4] = [&[0], &[3], &[1, 40], &[40, 0]];
            entity.insert(RenderLayers::from_layers(layers[random.usize(..4)]));
        }
        _ => {
            entity.insert(Mesh3d(meshes[random.usize(..meshes.len())].clone()));
        }
    }
}
