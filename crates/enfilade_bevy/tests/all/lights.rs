//! What is hidden from a camera is still there for lights: its shadow may be seen.

use crate::world::*;
use bevy_app::App;
use bevy_asset::AssetApp;
use bevy_camera::Camera3d;
use bevy_camera::visibility::{CascadesVisibleEntities, CubemapVisibleEntities, VisibleMeshEntities};
use bevy_ecs::prelude::*;
use bevy_image::Image;
use bevy_light::cluster::GlobalClusterSettings;
use bevy_light::{DirectionalLight, LightPlugin, PointLight, SpotLight};
use bevy_math::Vec3;
use bevy_mesh::Mesh3d;
use bevy_transform::prelude::Transform;
use enfilade_bevy::Occluder;

#[test]
fn a_crate_behind_a_wall_still_casts_its_shadows() {
    let mut app = an_app();
    app.init_asset::<Image>()
        .add_plugins(LightPlugin)
        .insert_resource(GlobalClusterSettings {
            supports_storage_buffers: true,
            clustered_decals_are_usable: false,
            gpu_clustering: None,
            max_uniform_buffer_clusterable_objects: 256,
            view_cluster_bindings_max_indices: 1024,
        });
    let wall = add_mesh(&mut app, a_box(Vec3::new(4.0, 3.0, 0.1)));
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.5)));
    let camera = add_camera(&mut app, Transform::IDENTITY);
    app.world_mut().entity_mut(camera).insert(Camera3d::default());
    let at = Transform::from_xyz;
    app.world_mut()
        .spawn((Mesh3d(wall), Occluder::OneSided, at(0.0, 0.0, -5.0)));
    let hidden = app.world_mut().spawn((Mesh3d(small), at(0.0, 0.0, -9.0))).id();
    // The lamp and the spot light are between the wall and the crate.
    let sun = DirectionalLight {
        shadow_maps_enabled: true,
        ..DirectionalLight::default()
    };
    let down = Transform::from_xyz(0.0, 9.0, 0.0).looking_at(Vec3::ZERO, Vec3::Z);
    let sun = app.world_mut().spawn((sun, down)).id();
    let lamp = PointLight {
        shadow_maps_enabled: true,
        ..PointLight::default()
    };
    let lamp = app.world_mut().spawn((lamp, at(0.0, 2.0, -7.0))).id();
    let spot = SpotLight {
        shadow_maps_enabled: true,
        ..SpotLight::default()
    };
    let spot = app.world_mut().spawn((spot, at(0.0, 0.0, -6.0))).id();

    let mut casters = |is_enabled: bool| {
        set_enabled(&mut app, is_enabled);
        app.update();
        assert_eq!(visible(&app, camera).contains(&hidden), !is_enabled);
        casters(&app, camera, [sun, lamp, spot])
    };
    let with = casters(true);
    for (light, casters) in ["sun", "lamp", "spot"].into_iter().zip(&with) {
        assert!(casters.contains(&hidden), "the {light} lights {casters:?}");
    }
    assert_eq!(with, casters(false));
}

/// Returns the entities in the shadow maps of a sun, a lamp and a spot light.
fn casters(app: &App, camera: Entity, [sun, lamp, spot]: [Entity; 3]) -> [Vec<Entity>; 3] {
    let world = app.world();
    let cascades = world.get::<CascadesVisibleEntities>(sun).expect("a sun");
    let faces = world.get::<CubemapVisibleEntities>(lamp).expect("a lamp");
    let cone = world.get::<VisibleMeshEntities>(spot).expect("a spot light");
    let all = |lists: &mut dyn Iterator<Item = &VisibleMeshEntities>| {
        let mut entities: Vec<Entity> = lists.flat_map(|list| list.entities.iter().copied()).collect();
        entities.sort_unstable();
        entities
    };
    [
        all(&mut cascades.entities.get(&camera).into_iter().flatten()),
        all(&mut faces.iter()),
        all(&mut std::iter::once(cone)),
    ]
}
