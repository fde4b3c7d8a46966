//! Lines that show what Enfilade knows: rooms, portals, the frozen frustum, and the boxes of hidden entities.

use crate::cameras::EnfiladeCameras;
use crate::components::{Mirror, Portal};
use crate::plugin::EnfiladeSystems;
use crate::portals::placed;
use crate::scene::EnfiladeScene;
use bevy_app::prelude::*;
use bevy_camera::Camera;
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_gizmos::AppGizmoBuilder;
use bevy_gizmos::config::{GizmoConfigGroup, GizmoConfigStore};
use bevy_gizmos::gizmos::Gizmos;
use bevy_math::bounding::Aabb3d;
use bevy_math::{Affine3A, DVec3, Vec3};
use bevy_reflect::Reflect;
use bevy_transform::prelude::GlobalTransform;
use enfilade::{Aabb, View};

/// Draws lines of the group [`EnfiladeGizmos`], by Bevy's `GizmoPlugin`: one of the default plugins with Bevy's feature
/// `bevy_gizmos_render`.
#[derive(Clone, Copy, Debug, Default)]
pub struct EnfiladeGizmosPlugin;

/// What is drawn; change it in Bevy's `GizmoConfigStore`.
#[derive(Clone, Copy, Debug, Reflect, GizmoConfigGroup)]
pub struct EnfiladeGizmos {
    /// Boxes of rooms: green if a camera sees them, else grey.
    pub sectors: bool,
    /// Outlines of portals and mirrors: yellow if open, red if closed.
    pub portals: bool,
    /// Frustums of cameras with [`FreezeVisibility`](crate::FreezeVisibility).
    pub frustum: bool,
    /// Boxes of entities in the frustums that are hidden.
    pub hidden: bool,
}

impl Default for EnfiladeGizmos {
    fn default() -> EnfiladeGizmos {
        EnfiladeGizmos {
            sectors: true,
            portals: true,
            frustum: true,
            hidden: false,
        }
    }
}

impl Plugin for EnfiladeGizmosPlugin {
    fn build(&self, app: &mut App) {
        app.init_gizmo_group::<EnfiladeGizmos>()
            .add_systems(PostUpdate, draw.after(EnfiladeSystems::Cull));
    }
}

const SEEN: Color = Color::srgb(0.3, 0.85, 0.45);
const UNSEEN: Color = Color::srgb(0.45, 0.45, 0.5);
const OPEN: Color = Color::srgb(1.0, 0.8, 0.25);
const CLOSED: Color = Color::srgb(0.9, 0.3, 0.25);
const FRUSTUM: Color = Color::srgb(0.45, 0.75, 1.0);
const HIDDEN: Color = Color::srgb(1.0, 0.45, 0.35);

fn draw(
    mut gizmos: Gizmos<EnfiladeGizmos>,
    store: Res<GizmoConfigStore>,
    scene: Res<EnfiladeScene>,
    cameras: Res<EnfiladeCameras>,
    views: Query<Entity, With<Camera>>,
    portals: Query<(&Portal, &GlobalTransform)>,
    mirrors: Query<(&Mirror, &GlobalTransform)>,
) {
    let (_, wanted) = store.config::<EnfiladeGizmos>();
    let boxed = |bounds: &Aabb| Aabb3d {
        min: bounds.min.into(),
        max: bounds.max.into(),
    };
    if wanted.sectors {
        for (room, bounds) in &scene.rooms.boxes {
            let sets = views.iter().filter_map(|camera| cameras.visible_set(camera));
            let mut passages = sets.flat_map(|set| set.passages());
            let is_seen = passages.any(|passage| passage.sector == *room);
            gizmos.aabb_3d(
                boxed(bounds),
                Affine3A::IDENTITY,
                if is_seen { SEEN } else { UNSEEN },
            );
        }
    }
    if wanted.portals {
        for (portal, transform) in &portals {
            let color = if portal.open { OPEN } else { CLOSED };
            gizmos.lineloop(placed(&portal.corners, &transform.affine()), color);
        }
        for (mirror, transform) in &mirrors {
            gizmos.lineloop(placed(&mirror.corners, &transform.affine()), OPEN);
        }
    }
    for camera in &views {
        if wanted.hidden {
            for &entity in cameras.hidden(camera) {
                if let Some((bounds, _)) = scene.bounds(entity) {
                    gizmos.aabb_3d(boxed(&bounds), Affine3A::IDENTITY, HIDDEN);
                }
            }
        }
        if let Some(view) = cameras.frozen_view(camera).filter(|_| wanted.frustum) {
            let reach = scene
                .scene()
                .sectors()
                .map(|sector| scene.scene().bounds(sector).longest_side());
            draw_frustum(&mut gizmos, view, reach.fold(1.0, f32::max));
        }
    }
}

fn draw_frustum(gizmos: &mut Gizmos<EnfiladeGizmos>, view: &View, reach: f32) {
    let [width, height] = view.size().map(f64::from);
    let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
    let rays = corners.map(|corner| {
        let [origin, direction] = view.ray(corner).map(|part| DVec3::from(part).as_vec3());
        (origin, direction.normalize_or_zero())
    });
    for (origin, direction) in rays {
        gizmos.line(origin, origin + direction * reach, FRUSTUM);
    }
    for part in [0.02, 0.2] {
        let ring: Vec<Vec3> = rays
            .map(|(origin, direction)| origin + direction * part * reach)
            .to_vec();
        gizmos.lineloop(ring, FRUSTUM);
    }
}
