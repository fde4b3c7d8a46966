//! What the plugin costs per frame: a town of 10,200 houses, two cameras, with none, 1,000 and 10,000 of them moving.
//!
//! `cargo run --release --no-default-features --example cost`
#![expect(clippy::print_stdout, reason = "examples print")]

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets, RenderAssetUsages};
use bevy_camera::primitives::Frustum;
use bevy_camera::visibility::{VisibilityPlugin, VisibleEntities};
use bevy_camera::{
    Camera, CameraProjection, CameraProjectionPlugin, PerspectiveProjection, Projection, RenderTargetInfo,
};
use bevy_ecs::prelude::*;
use bevy_math::{UVec2, Vec3};
use bevy_mesh::{Indices, Mesh, Mesh3d, MeshPlugin, PrimitiveTopology};
use bevy_transform::TransformPlugin;
use bevy_transform::prelude::Transform;
use enfilade_bevy::{EnfiladeCameras, EnfiladePlugin, EnfiladeSettings, Occluder, Samples};
use std::time::{Duration, Instant};

const HOUSES: usize = 10_200;
const PER_ROW: usize = 102;
const FRAMES: usize = 300;

fn main() {
    println!("milliseconds per frame of two cameras at 1280x720: median and p99 of {FRAMES} frames");
    for samples in [Samples::Centers, Samples::Four, Samples::Any] {
        for moving in [0, 1000, 10_000] {
            let [mut sync, mut look, mut frames, mut frames_without] = [const { Vec::new() }; 4];
            let mut apps = [true, false].map(|enabled| a_town(enabled, samples));
            let (mut visible, mut hidden) = (0, 0);
            for frame in 0..FRAMES {
                for (app, times) in apps.iter_mut().zip([&mut frames, &mut frames_without]) {
                    step(app, frame, moving);
                    let start = Instant::now();
                    app.update();
                    times.push(start.elapsed());
                }
                let stats = apps[0].world().resource::<EnfiladeCameras>().stats();
                sync.push(stats.sync_time);
                look.push(stats.look_time);
                (visible, hidden) = (stats.visible, stats.hidden);
            }
            let of = |times: &mut Vec<Duration>| {
                times.sort_unstable();
                let at = |part: usize| 1e3 * times[(times.len() - 1) * part / 100].as_secs_f64();
                format!("{:.2} ({:.2})", at(50), at(99))
            };
            println!(
                "{samples:?}, {moving} moving: sync {}, look {}, the whole update {}, without Enfilade {}; {visible} visible, \
                 {hidden} hidden",
                of(&mut sync),
                of(&mut look),
                of(&mut frames),
                of(&mut frames_without)
            );
        }
    }
}

fn a_town(enabled: bool, samples: Samples) -> App {
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
    let mut settings = app.world_mut().resource_mut::<EnfiladeSettings>();
    (settings.enabled, settings.samples) = (enabled, Some(samples));
    let house = app.world_mut().resource_mut::<Assets<Mesh>>().add(a_house());
    for number in 0..HOUSES {
        app.world_mut()
            .spawn((Mesh3d(house.clone()), Occluder::OneSided, place(number, 0)));
    }
    let size = UVec2::new(1280, 720);
    let projection = PerspectiveProjection {
        fov: 1.0,
        aspect_ratio: size.x as f32 / size.y as f32,
        far: 5000.0,
        ..PerspectiveProjection::default()
    };
    for toward in [Vec3::NEG_Z, Vec3::new(1.0, 0.0, -0.3)] {
        let mut camera = Camera::default();
        camera.computed.clip_from_view = projection.get_clip_from_view();
        camera.computed.target_info = Some(RenderTargetInfo {
            physical_size: size,
            scale_factor: 1.0,
        });
        let at = Transform::from_xyz(714.0 + 7.0, 1.7, 3.0).looking_to(toward, Vec3::Y);
        app.world_mut().spawn((
            camera,
            Projection::Perspective(projection.clone()),
            Frustum::default(),
            VisibleEntities::default(),
            at,
        ));
    }
    // Settles what is built once.
    (0..5).for_each(|_| app.update());
    app
}

fn place(number: usize, frame: usize) -> Transform {
    let sway = 0.3 * ((frame + number) as f32 * 0.1).sin();
    let [x, z] = [number % PER_ROW, number / PER_ROW].map(|part| part as f32 * 14.0);
    Transform::from_xyz(x + sway, 0.0, -z)
}

fn step(app: &mut App, frame: usize, moving: usize) {
    let mut houses = app.world_mut().query_filtered::<&mut Transform, With<Mesh3d>>();
    let world = app.world_mut();
    for (number, mut transform) in houses.iter_mut(world).enumerate().take(moving) {
        *transform = place(number, frame);
    }
}

fn a_house() -> Mesh {
    let corner = |number: u32| [number & 1, number & 2, number & 4].map(|bit| f32::from(u8::from(bit != 0)));
    let positions: Vec<[f32; 3]> = (0..8)
        .map(corner)
        .map(|[x, y, z]| [8.0 * x - 4.0, 12.0 * y, 8.0 * z - 4.0])
        .collect();
    let quads = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let indices = quads
        .iter()
        .flat_map(|&[a, b, c, d]: &[u32; 4]| [a, b, c, a, c, d]);
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    mesh.insert_indices(Indices::U32(indices.collect()));
    mesh
}
