//! Profiles swept along a path: cornices, skirtings, frames.

use super::{Shape, fill};
use enfilade::MaterialId;
use glam::{Vec2, Vec3, vec2, vec3};

/// Sweeps a profile of (out, up) along a path on the floor plan, mitred at its corners.
///
/// The path consists of (x, z) with the room on its right. `out` is measured from the path into the room, `up` from
/// `height`. The profile runs from its lower end to its upper end. An open path is closed at both ends.
pub(crate) fn moulding(
    material: MaterialId,
    path: &[Vec2],
    closed: bool,
    height: f32,
    profile: &[[f32; 2]],
) -> Shape {
    let count = path.len();
    let into_room = |i: usize| {
        let along = (path[(i + 1) % count] - path[i % count]).normalize();
        vec2(-along.y, along.x)
    };
    let mitre = |i: usize| {
        let before = if i > 0 || closed {
            into_room(i + count - 1)
        } else {
            into_room(0)
        };
        let after = if i + 1 < count || closed {
            into_room(i)
        } else {
            before
        };
        (before + after) / (1.0 + before.dot(after))
    };
    let rows: Vec<Vec<Vec3>> = (0..count)
        .map(|i| {
            let mitre = mitre(i);
            (profile.iter())
                .map(|&[out, up]| {
                    let at = path[i] + mitre * out;
                    vec3(at.x, height + up, at.y)
                })
                .collect()
        })
        .collect();
    let mut shape = Shape::new();
    for i in 0..count - usize::from(!closed) {
        let [left, right] = [&rows[i], &rows[(i + 1) % count]];
        for j in 0..profile.len() - 1 {
            shape.face(material, &[left[j], right[j], right[j + 1], left[j + 1]]);
        }
    }
    if !closed {
        for face in fill(&rows[0], &[]) {
            shape.face(material, &face);
        }
        let end: Vec<Vec3> = rows[count - 1].iter().rev().copied().collect();
        for face in fill(&end, &[]) {
            shape.face(material, &face);
        }
    }
    shape
}

/// Sweeps a profile of (inwards, out of the wall) around a rectangle on a wall: x right, y up, z out of the wall, the
/// rectangle's lower left corner at the origin. The profile runs inwards.
pub(crate) fn frame(material: MaterialId, [width, height]: [f32; 2], profile: &[[f32; 2]]) -> Shape {
    let path = [
        vec2(0.0, 0.0),
        vec2(0.0, -height),
        vec2(width, -height),
        vec2(width, 0.0),
    ];
    let outwards: Vec<[f32; 2]> = profile.iter().rev().copied().collect();
    moulding(material, &path, true, 0.0, &outwards).bent(on_wall)
}

/// Sweeps a profile of (away from the outline, out of the wall) around a counter-clockwise outline on a wall. An open
/// outline is closed at both ends. The profile runs away from the outline.
pub(crate) fn surround(material: MaterialId, outline: &[Vec2], closed: bool, profile: &[[f32; 2]]) -> Shape {
    let path: Vec<Vec2> = outline.iter().map(|at| vec2(at.x, -at.y)).collect();
    let towards: Vec<[f32; 2]> = profile.iter().rev().copied().collect();
    moulding(material, &path, closed, 0.0, &towards).bent(on_wall)
}

/// Rotates floor coordinates onto the wall: up becomes out of the wall.
fn on_wall(at: Vec3) -> Vec3 {
    vec3(at.x, -at.z, at.y)
}
