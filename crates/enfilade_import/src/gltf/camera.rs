//! Cameras of the scene, with the transforms of their nodes.

use super::document::{Camera as Source, Document, Orthographic, Perspective, find};
use super::names::Names;
use super::nodes::SceneNode;
use super::plan::Plan;
use crate::rooms::{room_around, room_nearest};
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, Room};
use enfilade::{Aabb, Camera, SectorId, Transform};
use glam::DVec3;

/// Returns the cameras of the scene, each with the height of its view volume if it is orthographic; adds a warning for each
/// invalid one.
pub(super) fn read(
    document: &Document,
    plan: &Plan,
    rooms: &[Room],
    warnings: &mut Warnings,
) -> Result<Vec<(Camera, Option<f32>)>, BrokenRule> {
    let names = Names::of(document, |_, node| node.camera.is_some());
    let mut cameras = Vec::new();
    for placed in plan.shown() {
        let number = placed.node;
        let node = &document.nodes[number as usize];
        let Some(camera) = node.camera else { continue };
        let source = find(&document.cameras, camera, "camera", || document.node_name(number))?;
        let name = names.name(number, node);
        let camera = match (&*source.kind, source) {
            (
                "perspective",
                Source {
                    perspective: Some(lens),
                    ..
                },
            ) => perspective(&name, *lens, &placed.world).map(|camera| (camera, None)),
            (
                "orthographic",
                Source {
                    orthographic: Some(lens),
                    ..
                },
            ) => {
                let home = || home(plan, placed, rooms);
                let camera = orthographic(&name, *lens, &placed.world, rooms, home);
                camera.map(|camera| (camera, Some(2.0 * lens.ymag)))
            }
            _ => None,
        };
        match camera {
            Some(camera) => cameras.push(camera),
            None => warnings.name(WarningKind::BadCameras, || document.node_name(number)),
        }
    }
    Ok(cameras)
}

/// Returns the position, up vector and backward vector of a camera, which looks along −Z of its node with +Y up. Scale
/// is ignored.
fn frame(world: &Transform) -> Option<[DVec3; 3]> {
    let [_, up, back, eye] = world.columns().map(|column| DVec3::from(column.map(f64::from)));
    Some([eye, up.try_normalize()?, back.try_normalize()?])
}

fn rounded(v: DVec3) -> [f64; 3] {
    v.as_vec3().to_array().map(f64::from)
}

fn perspective(name: &str, lens: Perspective, world: &Transform) -> Option<Camera> {
    let Perspective {
        yfov,
        znear,
        zfar,
        aspect_ratio,
    } = lens;
    let [eye, up, back] = frame(world)?;
    // The aspect ratio and the far plane are not used, because the viewport defines the former and nothing is culled by
    // distance. They are still validated, because a camera with an invalid value is probably wrong in others too.
    let others = zfar.is_none_or(|zfar| zfar > znear) && aspect_ratio.is_none_or(|ratio| ratio > 0.0);
    if !(others && yfov > 0.0 && yfov < std::f32::consts::PI && znear > 0.0 && znear.is_finite()) {
        return None;
    }
    let ahead = (eye.abs().max_element() / 1000.0).max(1.0);
    Some(Camera {
        name: name.to_owned(),
        eye: rounded(eye),
        toward: rounded(eye - ahead * back),
        up: rounded(up),
        fov_y: yfov,
        z_near: Some(znear),
        sector: None,
    })
}

/// Camera distance for an orthographic view, as a multiple of half the depth range of the scene. With it, perspective
/// moves nothing by more than half a pixel at the sides of a 1280-pixel-wide viewport.
const AWAY: f64 = 1281.0;

/// Approximates an orthographic camera by a perspective one far behind it, because a [`View`](enfilade::View) is in
/// perspective: so far that in a 1280-pixel-wide viewport no vertex moves by more than about half a pixel. Geometry halfway
/// between the near and far ends of the scene has the correct size, and the near plane is that of the file.
fn orthographic(
    name: &str,
    lens: Orthographic,
    world: &Transform,
    rooms: &[Room],
    home: impl FnOnce() -> Option<SectorId>,
) -> Option<Camera> {
    let Orthographic {
        xmag,
        ymag,
        znear,
        zfar,
    } = lens;
    let others = xmag > 0.0 && zfar > znear;
    let [ymag, znear, zfar] = [ymag, znear, zfar].map(f64::from);
    let [eye, up, back] = frame(world)?;
    if !(others && ymag > 0.0 && znear >= 0.0 && ymag.is_finite() && znear.is_finite()) {
        return None;
    }
    // Depth range of the scene in front of the camera, along the view direction.
    let all = rooms
        .iter()
        .fold(Aabb::EMPTY, |all, room| all.union(&room.geometry.bounds()));
    let depths = all
        .corners()
        .map(|corner| (eye - DVec3::from(corner.map(f64::from))).dot(back));
    let ends = |better: fn(f64, f64) -> f64, none: f64| match all.is_empty() {
        true => none,
        false => depths.into_iter().fold(f64::NAN, better).max(znear),
    };
    let (nearest, farthest) = (ends(f64::min, znear), ends(f64::max, znear + 1.0));
    // Geometry beyond the far plane needs no accuracy, so the camera can stay closer.
    let farthest = if zfar > nearest {
        farthest.min(zfar)
    } else {
        farthest
    };
    let (middle, half) = (0.5 * (nearest + farthest), 0.5 * (farthest - nearest));
    let away = (AWAY * half).max(ymag).max(2.0 * (middle - znear));
    let camera = Camera {
        name: name.to_owned(),
        eye: rounded(eye + (away - middle) * back),
        toward: rounded(eye - middle * back),
        up: rounded(up),
        fov_y: (2.0 * (ymag / away).atan()) as f32,
        z_near: Some((away - (middle - znear)) as f32),
        sector: home(),
    };
    // A view volume that is too small for its distance from the origin is lost to rounding.
    camera.view([1, 1]).is_ok().then_some(camera)
}

/// Returns the room of a camera in the file. The moved position of an orthographic camera cannot determine it.
fn home(plan: &Plan, placed: &SceneNode, rooms: &[Room]) -> Option<SectorId> {
    let eye = placed.world.columns()[3];
    let [own, rest] = plan.homes(placed, rooms.len());
    own.or_else(|| room_around(rooms, eye))
        .or(rest)
        .or_else(|| room_nearest(rooms, eye))
}
