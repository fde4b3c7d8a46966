//! Panels on walls: framed fields, some of figured silk.

use super::room::{Room, Style, Wall};
use super::trim::RAIL;
use super::workshop::Workshop;
use crate::shape::frame;
use enfilade::{MaterialId, Mesh};
use glam::{Vec2, Vec3, vec2, vec3};
use std::sync::Arc;

/// Panels over one free stretch, below the rail and above it.
pub(super) fn panels(room: &mut Room, wall: Wall, from: f32, to: f32, top: f32) {
    let Style {
        gilt,
        dado,
        field,
        wall: ground,
        ..
    } = room.design.style;
    let count = ((to - from) / 2.1).round().max(1.0);
    let step = (to - from) / count;
    for i in 0..count as usize {
        let left = from + step * i as f32 + 0.14;
        let width = step - 0.28;
        let low = panel(room.shop, [width, RAIL - 0.12 - 0.4], gilt, dado, None);
        room.put("dado panel", &low, wall.at(left, 0.4));
        let figure = (field != ground).then_some(ground);
        let high = panel(room.shop, [width, top - RAIL - 0.22], gilt, field, figure);
        room.put("panel", &high, wall.at(left, RAIL + 0.2));
    }
}

/// A framed field on a wall; its silk is figured with lozenges where a second material is given.
fn panel(
    shop: &mut Workshop,
    size: [f32; 2],
    edge: MaterialId,
    field: MaterialId,
    figure: Option<MaterialId>,
) -> Arc<Mesh> {
    let [width, height] = size;
    shop.piece(
        format!("panel {size:?} {} {} {figure:?}", edge.0, field.0),
        || {
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
            if let Some(figure) = figure {
                let [columns, rows] =
                    [right - inset, top - inset].map(|side| (side / 0.34).max(1.0) as usize);
                let step = vec2((right - inset) / columns as f32, (top - inset) / rows as f32);
                for row in 0..rows {
                    for column in 0..columns {
                        let shifted = if row % 2 == 0 { 0.5 } else { 1.0 };
                        if column as f32 + shifted + 0.4 > columns as f32 {
                            continue;
                        }
                        let at = Vec2::splat(inset) + step * vec2(column as f32 + shifted, row as f32 + 0.5);
                        for face in fleuron(at, (0.42 * step.min_element()).min(0.15)) {
                            shape.face(figure, &face);
                        }
                    }
                }
            }
            shape
        },
    )
}

/// A small flower of four petals, woven into silk.
fn fleuron(at: Vec2, reach: f32) -> [Vec<Vec3>; 4] {
    std::array::from_fn(|petal| {
        let (along, across) = [
            (vec2(0.0, 1.0), vec2(-1.0, 0.0)),
            (vec2(-1.0, 0.0), vec2(0.0, -1.0)),
            (vec2(0.0, -1.0), vec2(1.0, 0.0)),
            (vec2(1.0, 0.0), vec2(0.0, 1.0)),
        ][petal];
        let long = if petal % 2 == 0 { 1.0 } else { 0.62 };
        [(0.06, 0.0), (0.6, -0.22), (1.0, 0.0), (0.6, 0.22)]
            .map(|(out, side)| at + reach * (along * out * long + across * side))
            .map(|at| at.extend(0.011))
            .to_vec()
    })
}
