//! Wall trim: skirting, rail, panels, cornice, door frames.

use super::palette::WHITE_MARBLE;
use super::panel::panels;
use super::room::{Doorway, PAVING, Room, Style, arched};
use super::workshop::Workshop;
use crate::shape::{Shape, block, moulding, prism, surround, taper};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec2, Vec3, vec2, vec3};
use std::sync::Arc;

/// Height of the rail that divides a wall.
pub(crate) const RAIL: f32 = 1.02;

/// Width of the frame around a doorway.
const ARCHITRAVE: f32 = 0.26;

const SKIRTING: [[f32; 2]; 7] = [
    [0.0, 0.0],
    [0.05, 0.0],
    [0.05, 0.2],
    [0.035, 0.23],
    [0.035, 0.25],
    [0.015, 0.29],
    [0.0, 0.29],
];
const RAIL_PROFILE: [[f32; 2]; 7] = [
    [0.0, -0.05],
    [0.02, -0.05],
    [0.03, -0.02],
    [0.055, 0.0],
    [0.055, 0.03],
    [0.03, 0.05],
    [0.0, 0.05],
];

/// Decorates all walls up to `top` metres, except the taken extents.
pub(crate) fn dress(room: &mut Room, top: f32, cornice_size: f32) {
    let style = room.design.style;
    let corners = room.design.plan.corners();
    let floor_gaps: Vec<Vec<[f32; 2]>> = (0..corners.len())
        .map(|wall| {
            (room.doorways.iter())
                .filter(|door| door.wall == wall && door.sill == 0.0)
                .map(|door| door.reach(ARCHITRAVE - 0.02))
                .collect()
        })
        .collect();
    let mut skirting = Shape::new();
    for (path, closed) in runs(&corners, &floor_gaps) {
        skirting.join(moulding(style.trim, &path, closed, 0.0, &SKIRTING));
    }
    room.make("skirting", &skirting);
    let mut rail = Shape::new();
    for (path, closed) in runs(&corners, &room.taken) {
        if path.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f32>() < 0.4 {
            continue;
        }
        rail.join(moulding(style.gilt, &path, closed, RAIL, &RAIL_PROFILE));
    }
    room.make("rail", &rail);
    cornice(room, &corners, top, cornice_size);
    for (number, wall) in room.walls().into_iter().enumerate() {
        let free = free_stretches(wall.length(), &room.taken[number]);
        for [from, to] in free {
            panels(room, wall, from, to, top - 1.5 * cornice_size);
        }
    }
    for door in room.doorways.clone() {
        door_case(room, &door);
    }
}

/// A cornice round the whole room whose upper edge is at `top`.
pub(crate) fn cornice(room: &mut Room, corners: &[Vec2], top: f32, size: f32) {
    let Style { trim, gilt, .. } = room.design.style;
    let parts: [(MaterialId, &[[f32; 2]]); 5] = [
        (
            gilt,
            &[
                [0.0, -0.36],
                [0.05, -0.36],
                [0.07, -0.30],
                [0.05, -0.24],
                [0.0, -0.24],
            ],
        ),
        (
            trim,
            &[[0.0, 0.0], [0.1, 0.0], [0.1, 0.12], [0.2, 0.2], [0.24, 0.3]],
        ),
        (gilt, &[[0.24, 0.3], [0.28, 0.32], [0.28, 0.38], [0.24, 0.4]]),
        (
            trim,
            &[
                [0.24, 0.4],
                [0.5, 0.48],
                [0.56, 0.52],
                [0.56, 0.68],
                [0.62, 0.72],
                [0.72, 0.86],
                [0.74, 0.92],
            ],
        ),
        (gilt, &[[0.74, 0.92], [0.78, 0.94], [0.78, 1.0], [0.0, 1.0]]),
    ];
    let mut shape = Shape::new();
    for (material, profile) in parts {
        let sized: Vec<[f32; 2]> = profile
            .iter()
            .map(|point| point.map(|value| value * size))
            .collect();
        shape.join(moulding(material, corners, true, top - size, &sized));
    }
    room.make("cornice", &shape);
    for wall in room.walls() {
        let dentils = dentils(room.shop, trim, wall.length(), size);
        room.put("dentils", &dentils, wall.at(0.0, top - 0.62 * size));
    }
}

/// A row of small blocks under a cornice.
fn dentils(shop: &mut Workshop, material: MaterialId, length: f32, size: f32) -> Arc<Mesh> {
    shop.piece(format!("dentils {} {length} {size}", material.0), || {
        let step = 0.34 * size;
        let count = ((length - 0.6 * size) / step) as i32;
        let start = 0.5 * (length - count as f32 * step);
        let mut shape = Shape::new();
        for i in 0..count {
            let left = start + (i as f32 + 0.2) * step;
            shape.join(block(
                material,
                [left, 0.0, 0.0],
                [left + 0.6 * step, 0.22 * size, 0.42 * size],
            ));
        }
        shape
    })
}

/// Sorts extents and merges those that overlap.
fn merged(stretches: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let mut sorted = stretches.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut whole: Vec<[f32; 2]> = Vec::new();
    for [from, to] in sorted {
        match whole.last_mut() {
            Some(last) if from <= last[1] => last[1] = to.max(last[1]),
            _ => whole.push([from, to]),
        }
    }
    whole
}

/// Returns the extents of a wall between the taken ones.
fn free_stretches(length: f32, taken: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let mut free = Vec::new();
    let mut from = 0.12;
    for [start, end] in merged(taken) {
        free.push([from, start]);
        from = end;
    }
    free.push([from, length - 0.12]);
    free.retain(|[from, to]| to - from > 0.5);
    free
}

/// Adds the frame around a doorway, its threshold, and its crown.
fn door_case(room: &mut Room, door: &Doorway) {
    let style = room.design.style;
    let wall = room.walls()[door.wall];
    let case = room
        .shop
        .piece(format!("case {door:?} {} {}", style.trim.0, style.gilt.0), || {
            case(door, style)
        });
    room.put("door case", &case, wall.at(door.along, 0.0));
    if door.sill == 0.0 {
        let [half, depth] = [0.5 * door.width, door.depth];
        let corner = |x: f32, z: f32| vec3(x, PAVING, z);
        let mut slab = Shape::new();
        slab.face(
            WHITE_MARBLE,
            &[
                corner(-half, 0.0),
                corner(half, 0.0),
                corner(half, -depth),
                corner(-half, -depth),
            ],
        );
        let at = wall.at(door.along, 0.0);
        let slab = slab.bent(|corner| Vec3::from(at.point(corner.to_array())));
        room.make("threshold", &slab);
    }
}

fn case(door: &Doorway, style: Style) -> Shape {
    let Style { trim, gilt, dado, .. } = style;
    const PROFILE: [[f32; 2]; 8] = [
        [0.0, -0.01],
        [0.0, 0.04],
        [0.02, 0.05],
        [0.16, 0.055],
        [0.18, 0.09],
        [0.23, 0.10],
        [0.26, 0.085],
        [0.26, 0.0],
    ];
    let outline = arched(door.width, door.sill, door.spring, door.rise);
    // From the foot on the right over the top to the foot on the left: a doorway has no frame below.
    let path: Vec<Vec2> = outline[1..].iter().chain(&outline[..1]).copied().collect();
    let closed = door.sill > 0.0;
    let mut shape = surround(trim, &path, closed, &PROFILE);
    // Behind the lace of a window, a gilt line would show as specks.
    if !closed {
        let line = [[0.10, 0.053], [0.10, 0.075], [0.13, 0.075], [0.13, 0.054]];
        shape.join(surround(gilt, &path, closed, &line));
    }
    let top = door.spring + door.rise;
    let reach = 0.5 * door.width + ARCHITRAVE;
    // Over windows, curtains hang where a keystone would be.
    if door.rise > 0.0 && door.sill == 0.0 {
        let key = taper(gilt, [0.2, 0.12], 0.5, [0.34, 0.2]);
        shape.add(&key, Transform::translation([0.0, top - 0.06, 0.06]));
    } else if door.sill == 0.0 {
        shape.join(block(
            trim,
            [-reach, top + ARCHITRAVE, 0.0],
            [reach, top + ARCHITRAVE + 0.3, 0.07],
        ));
        shape.join(block(
            dado,
            [-reach + 0.1, top + ARCHITRAVE + 0.06, 0.06],
            [reach - 0.1, top + ARCHITRAVE + 0.24, 0.08],
        ));
        const LEDGE: [[f32; 2]; 8] = [
            [0.0, 0.0],
            [0.09, 0.0],
            [0.11, 0.04],
            [0.2, 0.09],
            [0.24, 0.1],
            [0.24, 0.15],
            [0.26, 0.18],
            [0.0, 0.2],
        ];
        let ledge = moulding(
            trim,
            &[vec2(-reach - 0.1, 0.0), vec2(reach + 0.1, 0.0)],
            false,
            0.0,
            &LEDGE,
        );
        shape.add(&ledge, Transform::translation([0.0, top + ARCHITRAVE + 0.3, 0.0]));
        pediment(&mut shape, trim, gilt, reach + 0.1, top + ARCHITRAVE + 0.5);
    }
    shape
}

/// A low gable over a doorway.
fn pediment(shape: &mut Shape, trim: MaterialId, gilt: MaterialId, reach: f32, foot: f32) {
    const DEEP: f32 = 0.2;
    let rise = 0.36 * reach;
    let bar = 0.14;
    let gable = |out: f32, low: f32, high: f32| {
        [
            vec3(-reach * low, foot, out),
            vec3(reach * low, foot, out),
            vec3(0.0, foot + rise * high, out),
        ]
    };
    shape.face(gilt, &gable(0.06, 1.0, 1.0));
    for side in [-1.0, 1.0] {
        let mut outline = vec![
            vec3(side * reach, foot, 0.0),
            vec3(side * reach, foot + bar, 0.0),
            vec3(0.0, foot + rise + bar, 0.0),
            vec3(0.0, foot + rise, 0.0),
        ];
        if side < 0.0 {
            outline.reverse();
        }
        shape.join(prism(trim, &outline, vec3(0.0, 0.0, DEEP)));
    }
}

/// Returns the stretches of the plan's outline between gaps (extents along each wall); the second value is whether the
/// stretch is the whole outline.
pub(crate) fn runs(corners: &[Vec2], gaps: &[Vec<[f32; 2]>]) -> Vec<(Vec<Vec2>, bool)> {
    if gaps.iter().all(Vec::is_empty) {
        return vec![(corners.to_vec(), true)];
    }
    let count = corners.len();
    let mut runs: Vec<(Vec<Vec2>, bool)> = Vec::new();
    let mut path: Vec<Vec2> = Vec::new();
    // One turn to find the end of the first gap, and one more from there.
    let mut started = false;
    for wall in (0..count).chain(0..count) {
        let [left, right] = [corners[wall], corners[(wall + 1) % count]];
        let along = (right - left).normalize();
        path.push(left);
        for [from, to] in merged(&gaps[wall]) {
            path.push(left + along * from);
            let mut whole = std::mem::replace(&mut path, vec![left + along * to]);
            whole.dedup_by(|a, b| a.distance(*b) < 0.01);
            if started && runs.iter().any(|(run, _)| run[0] == whole[0]) {
                return runs;
            }
            if started && whole.len() > 1 {
                runs.push((whole, false));
            }
            started = true;
        }
    }
    runs
}
