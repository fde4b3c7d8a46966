//! Lights of the scene, with the transforms of their nodes, and the rooms that contain them.
//!
//! Source: KHR_lights_punctual.

use super::document::{Document, Light as Source, find};
use super::plan::Plan;
use crate::rooms::{Frame, room_around};
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, Room};
use enfilade::{Light, LightShape, SectorId, Transform};
use std::f32::consts::{FRAC_PI_2, PI};

/// Returns the lights of the scene, in node order.
pub(super) fn read(
    document: &Document,
    plan: &Plan,
    rooms: &[Room],
    warnings: &mut Warnings,
) -> Result<Vec<Light>, BrokenRule> {
    let carrying = || {
        let shown = plan.shown().iter();
        shown.filter_map(|placed| Some((placed, document.nodes[placed.node as usize].light()?)))
    };
    if carrying().next().is_none() {
        return Ok(Vec::new());
    }
    let sources = document.lights()?;
    let mut lights = Vec::new();
    for (placed, number) in carrying() {
        let name = || document.node_name(placed.node);
        let source = find(&sources, number, "light", name)?;
        let Some(light) = light(source, &placed.world) else {
            warnings.name(WarningKind::BadLights, name);
            continue;
        };
        let [own, rest] = plan.homes(placed, rooms.len());
        let sector = own.unwrap_or_else(|| match light.shape {
            LightShape::Sun { .. } => rest.unwrap_or_else(|| largest(rooms)),
            _ => room_around(rooms, light.position)
                .or(rest)
                .unwrap_or_else(|| largest(rooms)),
        });
        lights.push(Light { sector, ..light });
    }
    Ok(lights)
}

/// Returns a light that shines along −Z of its node, ignoring scale; `None` if its parameters are invalid.
fn light(source: &Source, world: &Transform) -> Option<Light> {
    // glTF intensities are photometric; a white diffuse surface with an illuminance of π has radiance 1.
    let color = source.color.map(|part| part * (source.intensity / PI));
    let is_bright = color.iter().all(|part| part.is_finite() && *part >= 0.0) && source.intensity > 0.0;
    let range = source.range.unwrap_or(f32::INFINITY);
    if !(is_bright && range > 0.0) {
        return None;
    }
    let direction = || Frame::of(world).map(|frame| (-frame.back().as_vec3()).to_array());
    let shape = match &*source.kind {
        "point" => LightShape::Point,
        "directional" => LightShape::Sun {
            direction: direction()?,
        },
        "spot" => {
            let (inner, outer) = (source.spot.inner_cone_angle, source.spot.outer_cone_angle);
            let are_angles = inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= FRAC_PI_2;
            if !are_angles {
                return None;
            }
            LightShape::Spot {
                direction: direction()?,
                // Exporters write equal angles for a cone with a hard edge.
                inner: inner.min(outer.next_down()),
                outer,
            }
        }
        _ => return None,
    };
    Some(Light {
        sector: SectorId(0),
        position: world.columns()[3],
        color,
        range,
        shape,
    })
}

/// Returns the room with the largest AABB.
fn largest(rooms: &[Room]) -> SectorId {
    let volume = |number: &u32| rooms[*number as usize].geometry.bounds().volume();
    let numbers = 0..rooms.len() as u32;
    SectorId(
        numbers
            .max_by(|a, b| volume(a).total_cmp(&volume(b)).then(b.cmp(a)))
            .unwrap_or(0),
    )
}
