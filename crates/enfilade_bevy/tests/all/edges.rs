use crate::world::*;
use bevy_asset::RenderAssetUsages;
use bevy_camera::visibility::NoFrustumCulling;
use bevy_camera::{Camera, CameraProjection, PerspectiveProjection, RenderTargetInfo, Viewport};
use bevy_math::{UVec2, Vec3};
use bevy_mesh::{Mesh, Mesh3d, PrimitiveTopology};
use bevy_transform::prelude::Transform;
use enfilade_bevy::*;

fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::from_xyz(x, y, z)
}

#[test]
fn an_empty_world_is_looked_at_and_nothing_is_seen() {
    let mut app = an_app();
    let camera = add_camera(&mut app, Transform::IDENTITY);
    for _ in 0..3 {
        app.update();
        assert!(visible(&app, camera).is_empty());
    }
}

#[test]
fn a_world_without_cameras_is_synchronized() {
    let mut app = an_app();
    let mesh = add_mesh(&mut app, a_box(Vec3::ONE));
    let entity = app.world_mut().spawn((Mesh3d(mesh), Occluder::OneSided)).id();
    app.update();
    let scene = app.world().resource::<EnfiladeScene>();
    assert!(scene.contains(entity) && scene.is_occluder(entity));
    assert_eq!(scene.scene().item_count(), 1);
}

#[test]
fn meshes_without_positions_or_with_numbers_that_are_none_are_drawn_and_hide_nothing() {
    let mut app = an_app();
    let camera = add_camera(&mut app, Transform::IDENTITY);
    let bare = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    let nan = a_mesh(vec![[f32::NAN; 3]; 3], vec![0, 1, 2]);
    let huge = a_mesh(vec![[1e30; 3], [-1e30; 3], [1e30, -1e30, 0.0]], vec![0, 1, 2]);
    let unused = {
        let mut positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
        positions.push([f32::NAN; 3]);
        a_mesh(positions, vec![0, 1, 2])
    };
    for mesh in [bare, nan, huge, unused] {
        let mesh = add_mesh(&mut app, mesh);
        app.world_mut()
            .spawn((Mesh3d(mesh), Occluder::TwoSided, at(0.0, 0.0, -4.0)));
    }
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.4)));
    let far = app.world_mut().spawn((Mesh3d(small), at(3.0, 0.0, -9.0))).id();
    for _ in 0..3 {
        app.update();
    }
    assert!(visible(&app, camera).contains(&far));
}

#[test]
fn a_wall_whose_mesh_never_reaches_the_renderer_hides_only_as_a_proxy() {
    let mut app = an_app();
    let camera = add_camera(&mut app, Transform::IDENTITY);
    let mut wall = a_box(Vec3::new(4.0, 3.0, 0.1));
    wall.asset_usage = RenderAssetUsages::MAIN_WORLD;
    let [wall, small] = [wall, a_box(Vec3::splat(0.5))].map(|mesh| add_mesh(&mut app, mesh));
    app.world_mut().spawn((Mesh3d(small.clone()), at(0.0, 0.0, -9.0)));
    let undrawn = app
        .world_mut()
        .spawn((Mesh3d(wall.clone()), Occluder::OneSided, at(0.0, 0.0, -5.0)));
    let undrawn = undrawn.id();
    app.update();
    assert_eq!(visible(&app, camera).len(), 2);
    app.world_mut().despawn(undrawn);
    app.world_mut()
        .spawn((Mesh3d(small), OccluderProxy(wall), at(0.0, 0.0, -5.0)));
    app.update();
    assert_eq!(visible(&app, camera).len(), 1);
}

#[test]
fn a_transform_that_is_no_number_loses_nothing_else() {
    let mut app = an_app();
    let camera = add_camera(&mut app, Transform::IDENTITY);
    let mesh = add_mesh(&mut app, a_box(Vec3::splat(0.5)));
    let place = at(f32::NAN, 0.0, -3.0);
    let lost = (Mesh3d(mesh.clone()), Occluder::OneSided, place);
    let lost = app.world_mut().spawn(lost).id();
    let there = app.world_mut().spawn((Mesh3d(mesh), at(0.0, 0.0, -5.0))).id();
    app.update();
    assert!(visible(&app, camera).contains(&there));
    app.world_mut().entity_mut(lost).insert(at(0.0, 0.0, -3.0));
    app.update();
    assert_eq!(visible(&app, camera), [lost]);
}

#[test]
fn an_entity_that_comes_and_goes_in_one_frame_leaves_nothing_behind() {
    let mut app = an_app();
    add_camera(&mut app, Transform::IDENTITY);
    let mesh = add_mesh(&mut app, a_box(Vec3::ONE));
    for _ in 0..3 {
        let entity = app
            .world_mut()
            .spawn((Mesh3d(mesh.clone()), Occluder::OneSided))
            .id();
        app.world_mut().despawn(entity);
        // The id is used again.
        let other = app
            .world_mut()
            .spawn((Mesh3d(mesh.clone()), at(0.0, 0.0, -5.0)))
            .id();
        app.update();
        assert_eq!(app.world().resource::<EnfiladeScene>().scene().item_count(), 1);
        app.world_mut().despawn(other);
        app.update();
        assert_eq!(app.world().resource::<EnfiladeScene>().scene().item_count(), 0);
    }
}

#[test]
fn a_window_that_is_resized_or_closed_is_looked_into_at_its_size() {
    let mut app = an_app();
    let camera = add_camera(&mut app, Transform::IDENTITY);
    let wall = add_mesh(&mut app, a_box(Vec3::new(4.0, 3.0, 0.1)));
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.5)));
    app.world_mut()
        .spawn((Mesh3d(wall), Occluder::OneSided, at(0.0, 0.0, -5.0)));
    app.world_mut().spawn((Mesh3d(small), at(0.0, 0.0, -9.0)));
    for (size, expected) in [([2, 2], 2), ([3000, 17], 1), ([0, 0], 2), ([640, 480], 1)] {
        let projection = PerspectiveProjection {
            fov: 1.2,
            aspect_ratio: size[0].max(1) as f32 / size[1].max(1) as f32,
            ..PerspectiveProjection::default()
        };
        let mut view = app.world_mut().get_mut::<Camera>(camera).expect("a camera");
        view.computed.clip_from_view = projection.get_clip_from_view();
        view.computed.target_info = Some(RenderTargetInfo {
            physical_size: UVec2::from(size),
            scale_factor: 1.0,
        });
        app.update();
        assert_eq!(visible(&app, camera).len(), expected, "{size:?}");
    }
    let mut view = app.world_mut().get_mut::<Camera>(camera).expect("a camera");
    view.viewport = Some(Viewport {
        physical_size: UVec2::new(100, 50),
        ..Viewport::default()
    });
    app.update();
    assert_eq!(visible(&app, camera).len(), 1);
    let mut view = app.world_mut().get_mut::<Camera>(camera).expect("a camera");
    (view.viewport, view.computed.target_info) = (None, None);
    app.update();
    assert_eq!(
        visible(&app, camera).len(),
        2,
        "what is drawn of no window is not known"
    );
}

#[test]
fn a_camera_that_draws_back_faces_sees_through_one_sided_walls() {
    let mut app = an_app();
    let corners = [
        [-9.0, -9.0, 0.0],
        [9.0, -9.0, 0.0],
        [9.0, 9.0, 0.0],
        [-9.0, 9.0, 0.0],
    ];
    let toward_camera = add_mesh(&mut app, a_mesh(corners.to_vec(), vec![0, 1, 2, 0, 2, 3]));
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.5)));
    app.world_mut()
        .spawn((Mesh3d(toward_camera), Occluder::OneSided, at(0.0, 0.0, -5.0)));
    app.world_mut().spawn((Mesh3d(small), at(0.0, 0.0, -9.0)));
    let mirrored = Transform::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    for (transform, invert_culling, expected) in [
        (Transform::IDENTITY, false, 1),
        (Transform::IDENTITY, true, 2),
        (mirrored, false, 2),
        (mirrored, true, 1),
    ] {
        let camera = add_camera(&mut app, transform);
        let mut view = app.world_mut().get_mut::<Camera>(camera).expect("a camera");
        view.invert_culling = invert_culling;
        app.update();
        assert_eq!(
            visible(&app, camera).len(),
            expected,
            "{transform:?}, {invert_culling}"
        );
        app.world_mut().despawn(camera);
    }
}

#[test]
fn what_is_not_culled_by_the_frustum_is_left_alone() {
    let mut app = an_app();
    let camera = add_camera(&mut app, Transform::IDENTITY);
    let wall = add_mesh(&mut app, a_box(Vec3::new(4.0, 3.0, 0.1)));
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.5)));
    app.world_mut()
        .spawn((Mesh3d(wall), Occluder::OneSided, at(0.0, 0.0, -5.0)));
    let place = at(0.0, 0.0, -9.0);
    app.world_mut()
        .spawn((Mesh3d(small.clone()), place, NoFrustumCulling));
    app.world_mut()
        .spawn((Mesh3d(small.clone()), place, AlwaysVisible));
    app.world_mut().spawn((Mesh3d(small), place));
    app.update();
    assert_eq!(visible(&app, camera).len(), 3);
}

#[test]
fn a_proxy_hides_in_the_place_of_a_mesh_of_many_pieces() {
    let mut app = an_app();
    let camera = add_camera(&mut app, Transform::IDENTITY);
    let wall = add_mesh(&mut app, a_box(Vec3::new(4.0, 3.0, 0.1)));
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.5)));
    let bricks = (Mesh3d(small.clone()), OccluderProxy(wall), at(0.0, 0.0, -5.0));
    let bricks = app.world_mut().spawn(bricks).id();
    app.world_mut().spawn((Mesh3d(small), at(2.5, 1.0, -9.0)));
    app.update();
    assert_eq!(visible(&app, camera), [bricks]);
    app.world_mut().entity_mut(bricks).insert(at(0.0, 20.0, -5.0));
    app.update();
    assert_eq!(visible(&app, camera).len(), 1, "the other one");
    app.world_mut().entity_mut(bricks).insert(at(0.0, 0.0, -5.0));
    app.world_mut().entity_mut(bricks).remove::<OccluderProxy>();
    app.update();
    assert_eq!(visible(&app, camera).len(), 2);
}

#[test]
fn a_large_mesh_is_built_on_the_task_pool_and_hides_once_it_is_there() {
    let mut app = an_app();
    let camera = add_camera(&mut app, Transform::IDENTITY);
    let side = 30_u32;
    let positions = (0..side * side).map(|number| {
        let part = |number: u32| number as f32 / (side - 1) as f32 * 10.0 - 5.0;
        [part(number % side), part(number / side), 0.0]
    });
    let quads = (0..(side - 1) * (side - 1)).flat_map(|number| {
        let a = number % (side - 1) + number / (side - 1) * side;
        [a, a + 1, a + side + 1, a, a + side + 1, a + side]
    });
    let wall = a_mesh(positions.collect(), quads.collect());
    let wall = add_mesh(&mut app, wall);
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.5)));
    let wall = (Mesh3d(wall), Occluder::OneSided, at(0.0, 0.0, -5.0));
    let wall = app.world_mut().spawn(wall).id();
    app.world_mut().spawn((Mesh3d(small), at(0.0, 0.0, -9.0)));
    for _ in 0..2000 {
        app.update();
        if visible(&app, camera) == [wall] {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    panic!("the wall hides nothing");
}

#[test]
fn a_look_that_nothing_optimizes_fits_into_a_stack_of_one_megabyte() {
    let levels: Vec<&str> = enfilade::simd_levels().collect();
    for level in levels {
        let look = move || {
            enfilade::use_simd_level(level).expect("a level of this machine");
            let mut app = an_app();
            app.world_mut().resource_mut::<EnfiladeSettings>().samples = Some(Samples::Centers);
            let camera = add_camera(&mut app, Transform::IDENTITY);
            let [wall, small] =
                [Vec3::new(4.0, 3.0, 0.1), Vec3::splat(0.5)].map(|half| add_mesh(&mut app, a_box(half)));
            app.world_mut()
                .spawn((Mesh3d(wall), Occluder::OneSided, at(0.0, 0.0, -5.0)));
            app.world_mut().spawn((Mesh3d(small), at(0.0, 0.0, -9.0)));
            app.update();
            visible(&app, camera).len()
        };
        let thread = std::thread::Builder::new().stack_size(1 << 20).spawn(look);
        let seen = thread.expect("a thread").join();
        assert_eq!(seen.expect("a look"), 1, "{level}");
    }
    let best = enfilade::simd_levels().next().expect("a level");
    enfilade::use_simd_level(best).expect("a level of this machine");
}
