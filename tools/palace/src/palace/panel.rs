//! Panels on walls: framed fields, many of figured silk.

use super::room::{Room, Style, Wall};
use super::trim::RAIL;
use super::workshop::Workshop;
use crate::shape::frame;
use enfilade::{MaterialId, Mesh};
use glam::vec3;
use std::sync::Arc;

/// Adds panels to one free stretch of wall, below the rail and above it.
pub(super) fn panels(room: &mut Room, wall: Wall, from: f32, to: f32, top: f32) {
    let Style {
        gilt, dado, field, ..
    } = room.design.style;
    let count = ((to - from) / 2.1).round().max(1.0);
    let step = (to - from) / count;
    for i in 0..count as usize {
        let left = from + step * i as f32 + 0.14;
        let width = step - 0.28;
        let low = panel(room.shop, [width, RAIL - 0.12 - 0.4], gilt, dado);
        room.put("dado panel", &low, wall.at(left, 0.4));
        let high = panel(room.shop, [width, top - RAIL - 0.22], gilt, field);
        room.put("panel", &high, wall.at(left, RAIL + 0.2));
    }
}

/// A framed field on a wall.
fn panel(shop: &mut Workshop, size: [f32; 2], edge: MaterialId, field: MaterialId) -> Arc<Mesh> {
    let [width, height] = size;
    shop.piece(format!("panel {size:?} {} {}", edge.0, field.0), || {
        const PROFILE: [[f32; 2]; 6] = [
            [0.0, 0.0],
            [0.0, 0.02],
            [0.015, 0.035],
            [0.04, 0.035],
            [0.055, 0.02],
            [0.06, 0.006],
        ];
        let mut shape = frame(edge, size, &PROFILE);
        let corner = |x: f32, y: f32| vec3(x, y, 0.006);
        let inset = 0.06;
        let [right, top] = [width - inset, height - inset];
        shape.face(
            field,
            &[
                corner(inset, inset),
                corner(right, inset),
                corner(right, top),
                corner(inset, top),
            ],
        );
        shape
    })
}
