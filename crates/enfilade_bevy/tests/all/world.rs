//! An app without a window or a renderer, and an independent answer to what its cameras see.

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets, Handle, RenderAssetUsages};
use bevy_camera::primitives::Frustum;
use bevy_camera::visibility::{InheritedVisibility, RenderLayers, VisibilityPlugin, VisibleEntities};
use bevy_camera::{
    Camera, CameraProjection, CameraProjectionPlugin, PerspectiveProjection, Projection, RenderTargetInfo,
};
use bevy_ecs::prelude::*;
use bevy_math::{UVec2, Vec2, Vec3};
use bevy_mesh::{Indices, Mesh, Mesh3d, MeshPlugin, PrimitiveTopology};
use bevy_transform::TransformPlugin;
use bevy_transform::prelude::{GlobalTransform, Transform};
use enfilade_bevy::{EnfiladePlugin, EnfiladeSettings, NotOccluder, Occluder, Samples};
use std::any::TypeId;
use std::collections::BTreeSet;

pub(crate) const SIZE: UVec2 = UVec2::new(320, 240);

/// Random samples per picture.
const RAYS: u32 = 600;

pub(crate) fn an_app() -> App {
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
    app
}

/// Turns culling off and on again, as an app does at run time.
pub(crate) fn set_enabled(app: &mut App, enabled: bool) {
    app.world_mut().resource_mut::<EnfiladeSettings>().enabled = enabled;
}

pub(crate) fn add_mesh(app: &mut App, mesh: Mesh) -> Handle<Mesh> {
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

/// A box around the origin.
pub(crate) fn a_box(half: Vec3) -> Mesh {
    let corner = |number: u32| {
        let sign = |bit: u32| if number & bit == 0 { -1.0 } else { 1.0 };
        (half * Vec3::new(sign(1), sign(2), sign(4))).to_array()
    };
    let quads = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let indices: Vec<u32> = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [a, b, c, a, c, d])
        .collect();
    a_mesh((0..8).map(corner).collect(), indices)
}

pub(crate) fn a_mesh(positions: Vec<[f32; 3]>, indices: Vec<u32>) -> Mesh {
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    mesh.insert_indices(Indices::U32(indices));
    mesh
}

pub(crate) fn add_camera(app: &mut App, at: Transform) -> Entity {
    let projection = PerspectiveProjection {
        fov: 1.2,
        aspect_ratio: SIZE.x as f32 / SIZE.y as f32,
        near: 0.1,
        far: 1000.0,
        ..PerspectiveProjection::default()
    };
    let mut camera = Camera::default();
    camera.computed.clip_from_view = projection.get_clip_from_view();
    camera.computed.target_info = Some(RenderTargetInfo {
        physical_size: SIZE,
        scale_factor: 1.0,
    });
    let projection = Projection::Perspective(projection);
    app.world_mut()
        .spawn((
            camera,
            projection,
            Frustum::default(),
            VisibleEntities::default(),
            at,
        ))
        .id()
}

/// Returns what is left to draw for a camera.
pub(crate) fn visible(app: &App, camera: Entity) -> Vec<Entity> {
    let list = app.world().get::<VisibleEntities>(camera);
    list.expect("a camera").get(TypeId::of::<Mesh3d>()).to_vec()
}

/// Returns what rays through random samples of a camera's pixels meet up to the first that hides.
///
/// With a straightforward test of every triangle, by none of Enfilade's code.
pub(crate) fn seen_by_rays(
    app: &mut App,
    camera: Entity,
    samples: Samples,
    random: &mut fastrand::Rng,
) -> BTreeSet<Entity> {
    let triangles = all_triangles(app, camera);
    let world = app.world();
    let at = world.get::<GlobalTransform>(camera).expect("a camera").affine();
    let clip_from_view = world.get::<Camera>(camera).expect("a camera").clip_from_view();
    let view_from_clip = clip_from_view.inverse();
    let mut seen = BTreeSet::new();
    for _ in 0..RAYS {
        let pixel = random.u32(..SIZE.x * SIZE.y);
        let corner = Vec2::new((pixel % SIZE.x) as f32, (pixel / SIZE.x) as f32);
        let within = match samples {
            Samples::Centers => Vec2::splat(0.5),
            Samples::Four => Vec2::from(enfilade::View::FOUR_SAMPLES[random.usize(..4)]) + 0.5,
            Samples::Any => Vec2::new(random.f32(), random.f32()),
        };
        let ndc = (corner + within) / SIZE.as_vec2() * Vec2::new(2.0, -2.0) + Vec2::new(-1.0, 1.0);
        let near = view_from_clip.project_point3(ndc.extend(1.0));
        let [origin, through] = [at.translation.into(), at.transform_point3(near)];
        let mut met: Vec<(f32, Entity, bool)> = triangles
            .iter()
            .filter_map(|triangle| Some((triangle.meets(origin, through)?, triangle.entity, triangle.hides)))
            .filter(|(distance, ..)| *distance >= 1.0)
            .collect();
        met.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        // A face a hair behind another may be what the picture shows.
        let first = met
            .iter()
            .find(|(.., hides)| *hides)
            .map_or(f32::INFINITY, |met| met.0);
        seen.extend(met.iter().take_while(|met| met.0 <= first).map(|met| met.1));
    }
    seen
}

struct Triangle {
    entity: Entity,
    corners: [Vec3; 3],
    hides: bool,
    is_two_sided: bool,
}

impl Triangle {
    /// Returns the distance along a ray, in multiples of `through - origin` (Möller and Trumbore, 1997).
    fn meets(&self, origin: Vec3, through: Vec3) -> Option<f32> {
        let direction = through - origin;
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let across = direction.cross(ac);
        let determinant = ab.dot(across);
        if determinant == 0.0 || (determinant < 0.0 && !self.is_two_sided) {
            return None;
        }
        let from_a = origin - a;
        let u = from_a.dot(across) / determinant;
        let around = from_a.cross(ab);
        let v = direction.dot(around) / determinant;
        let distance = ac.dot(around) / determinant;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some(distance)
    }
}

fn all_triangles(app: &mut App, camera: Entity) -> Vec<Triangle> {
    let layers = app
        .world()
        .get::<RenderLayers>(camera)
        .cloned()
        .unwrap_or_default();
    type Drawn<'a> = (
        Entity,
        &'a Mesh3d,
        &'a GlobalTransform,
        &'a InheritedVisibility,
        Option<&'a Occluder>,
        Has<NotOccluder>,
        Option<&'a RenderLayers>,
    );
    let world = app.world_mut();
    let mut query = world.query::<Drawn>();
    let assets = world.resource::<Assets<Mesh>>();
    let mut triangles = Vec::new();
    for (entity, mesh, transform, inherited, occluder, is_no_occluder, of) in query.iter(world) {
        if !inherited.get() || !layers.intersects(of.unwrap_or_default()) {
            continue;
        }
        let Some(mesh) = assets.get(&mesh.0) else { continue };
        let Ok(positions) = mesh.try_attribute(Mesh::ATTRIBUTE_POSITION) else {
            continue;
        };
        let positions = positions.as_float3().expect("positions");
        let indices: Vec<usize> = mesh.indices().expect("indices").iter().collect();
        for corners in indices.chunks_exact(3) {
            let corner = |number: usize| transform.transform_point(positions[corners[number]].into());
            triangles.push(Triangle {
                entity,
                corners: [0, 1, 2].map(corner),
                hides: occluder.is_some() && !is_no_occluder,
                is_two_sided: occluder == Some(&Occluder::TwoSided),
            });
        }
    }
    triangles
}

/// Asserts that a camera misses nothing that it sees.
pub(crate) fn check(
    app: &mut App,
    camera: Entity,
    samples: Samples,
    random: &mut fastrand::Rng,
    frame: &str,
) {
    let seen = seen_by_rays(app, camera, samples, random);
    let visible: BTreeSet<Entity> = visible(app, camera).into_iter().collect();
    let missed: Vec<&Entity> = seen.difference(&visible).collect();
    assert!(
        missed.is_empty(),
        "{frame}: {missed:?} of {} are missed",
        seen.len()
    );
}
