//! Cameras of the scene, where their nodes put them.

use super::document::{Camera as Source, Document, Perspective, find};
use super::names::Names;
use super::nodes::Placed;
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, Camera};
use enfilade::Transform;
use glam::DVec3;

/// The perspective cameras among the nodes; others are warned of.
pub(super) fn read(
    document: &Document,
    placed: &[Placed],
    warnings: &mut Warnings,
) -> Result<Vec<Camera>, BrokenRule> {
    let names = Names::of(document, |node| node.camera.is_some());
    let mut cameras = Vec::new();
    for Placed {
        node: number, world, ..
    } in placed
    {
        let node = &document.nodes[*number as usize];
        let Some(camera) = node.camera else { continue };
        let source = find(&document.cameras, camera, "camera", || {
            document.node_name(*number)
        })?;
        match lens(source).and_then(|lens| stand(&names.name(*number, node), lens, world)) {
            Ok(camera) => cameras.push(camera),
            Err(kind) => warnings.name(kind, || document.node_name(*number)),
        }
    }
    Ok(cameras)
}

fn lens(source: &Source) -> Result<Perspective, WarningKind> {
    match source.perspective {
        Some(lens) if source.kind == "perspective" => Ok(lens),
        _ if source.kind == "orthographic" => Err(WarningKind::OrthographicCameras),
        _ => Err(WarningKind::BadCameras),
    }
}

/// A camera looks along −Z of its node with +Y up; the node's scale does not count.
fn stand(name: &str, lens: Perspective, world: &Transform) -> Result<Camera, WarningKind> {
    let Perspective { yfov, znear } = lens;
    let [_, up, back, eye] = world.columns().map(|column| DVec3::from(column.map(f64::from)));
    let (Some(up), Some(back)) = (up.try_normalize(), back.try_normalize()) else {
        return Err(WarningKind::BadCameras);
    };
    if !(yfov > 0.0 && yfov < std::f32::consts::PI && znear > 0.0 && znear.is_finite()) {
        return Err(WarningKind::BadCameras);
    }
    let ahead = (eye.abs().max_element() / 1000.0).max(1.0);
    let rounded = |v: DVec3| v.as_vec3().to_array();
    Ok(Camera {
        name: name.to_owned(),
        eye: rounded(eye),
        toward: rounded(eye - ahead * back),
        up: rounded(up),
        fov_y: yfov,
        near: znear,
    })
}
