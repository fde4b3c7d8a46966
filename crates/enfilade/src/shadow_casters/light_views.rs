//! The views of a light: a parallel one of a sun, fitted to what receives shadows, one of a spot light, or the six faces of a
//! cube around a point light.

use super::receivers::Receiver;
use crate::geom::Aabb;
use crate::ids::LightId;
use crate::query::LightReach;
use crate::scene::{Light, LightShape, Scene};
use crate::view::options::Limits;
use crate::view::passage::FARTHEST_COORDINATE;
use crate::view::{Camera, View, Viewport};
use glam::{DMat3, DVec3};

/// Widest angle from the axis of a spot light that has one view, in radians; others have the faces of a cube.
const WIDEST: f32 = 1.0;

/// Returns the views of a light, each with its number: of the cube's face (+x, −x, +y, −y, +z, −z of its sector) for a point
/// light and a wide spot light, otherwise 0. `size`: width and height, in pixels.
pub(super) fn of_light(
    scene: &Scene,
    id: LightId,
    receivers: &[Receiver],
    size: u32,
    limits: &Limits,
) -> Vec<(u32, View)> {
    let light = &scene.lights()[id.0 as usize];
    let viewport = Viewport::from([size; 2]);
    let views = match light.shape {
        LightShape::Sun { direction } => {
            let reach = scene.light_reach(id, limits);
            let onwards = DVec3::from(direction.map(f64::from));
            vec![(0, of_sun(scene, light, onwards, receivers, &reach, viewport))]
        }
        LightShape::Spot { direction, outer, .. } if outer <= WIDEST => {
            let onwards = DVec3::from(direction.map(f64::from)).normalize_or(DVec3::NEG_Y);
            vec![(0, of_lamp(scene, light, onwards, 2.02 * outer, viewport))]
        }
        _ => {
            let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter();
            let faces = axes.flat_map(|axis| [axis, -axis]);
            let view = |onwards| of_lamp(scene, light, onwards, std::f32::consts::FRAC_PI_2, viewport);
            (0..).zip(faces.map(view)).collect()
        }
    };
    let views = views.into_iter();
    views
        .filter_map(|(number, view)| Some((number, view?.of_light(light.sector))))
        .collect()
}

/// Returns the view of a lamp in a direction of unit length.
fn of_lamp(scene: &Scene, light: &Light, onwards: DVec3, fov_y: f32, viewport: Viewport) -> Option<View> {
    /// Near plane, relative to the range or the size of the sector. Only an item that is all within this distance of the lamp
    /// would be lost.
    const NEAR: f32 = 1e-6;
    let eye = DVec3::from(light.position.map(f64::from));
    let size = scene.bounds(light.sector).longest_side();
    let z_near = NEAR * light.range.min(size);
    let camera = Camera {
        up: if onwards.y.abs() > 0.9 { DVec3::Z } else { DVec3::Y }.into(),
        fov_y,
        z_near: Some(z_near.clamp(1e-6, 1e-4)),
        ..Camera::new(eye.to_array(), (eye + onwards).to_array())
    };
    camera.view(viewport).ok()
}

/// Returns the view of a sun, whose near plane is before everything in its sector and that shows all receivers; `None` if it
/// shines on none.
///
/// Its size and its place across the light are multiples of a step, so that they seldom change when the camera moves.
fn of_sun(
    scene: &Scene,
    light: &Light,
    onwards: DVec3,
    receivers: &[Receiver],
    reach: &[LightReach],
    viewport: Viewport,
) -> Option<View> {
    let onwards = onwards.normalize_or(DVec3::NEG_Y);
    let up = if onwards.y.abs() > 0.99 {
        DVec3::Z
    } else {
        DVec3::Y
    };
    let right = onwards.cross(up).normalize();
    let up = right.cross(onwards);
    let axes = DMat3::from_cols(right, up, -onwards);
    // Right, up and backwards, in the space of the light's sector.
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for beam in reach {
        let Some(back) = beam.there_from_here.inverse() else {
            continue;
        };
        let first = receivers.partition_point(|receiver| receiver.sector < beam.sector);
        let here = receivers[first..].iter();
        for receiver in here.take_while(|receiver| receiver.sector == beam.sector) {
            let corners = corners(&receiver.bounds);
            let is_outside = |(normal, distance): ([f64; 3], f64)| {
                let normal = DVec3::from(normal);
                let size = normal.abs().dot(corners[0].abs().max(corners[7].abs()));
                let slack = 1e-6 * (size + distance.abs());
                corners
                    .iter()
                    .all(|corner| normal.dot(*corner) < distance - slack)
            };
            if beam.planes().any(is_outside) {
                continue;
            }
            for corner in corners {
                let at = axes.transpose() * back.0.transform_point3(corner);
                (low, high) = (low.min(at), high.max(at));
            }
        }
    }
    if !(low.is_finite() && high.is_finite()) {
        return None;
    }
    let before = corners(&scene.bounds(light.sector))
        .map(|corner| axes.z_axis.dot(corner))
        .into_iter()
        .fold(high.z, f64::max);
    let deep = before - low.z;
    let size = (high - low).truncate();
    let step = |size: f64| 0.125 * size.max(1e-6 * deep).max(1e-9).log2().floor().exp2();
    let steps = [0, 1].map(|axis| step(size[axis]));
    let [x, y] = [0, 1].map(|axis| {
        let [first, last] = [low[axis] / steps[axis] - 0.01, high[axis] / steps[axis] + 0.01];
        [first.floor() * steps[axis], last.ceil() * steps[axis]]
    });
    let margin = 1e-3 * deep.max(size.max_element()) + 1e-6;
    let middle = DVec3::new(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), before + margin);
    let half = [0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])];
    View::of_sun(axes * middle, axes, half, deep + 2.0 * margin, viewport).ok()
}

/// Returns the corners of a box, within the coordinates that geometry may have.
fn corners(bounds: &Aabb) -> [DVec3; 8] {
    let within = |at: f32| f64::from(at).clamp(-FARTHEST_COORDINATE, FARTHEST_COORDINATE);
    bounds.corners().map(|corner| DVec3::from(corner.map(within)))
}
