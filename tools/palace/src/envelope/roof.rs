//! Ceilings: flat or coved ceilings, vaults, domes.

use super::{ARC, Axis, Ceiling, Plan, Side, inwards, rectangle};
use crate::shape::Shape;
use enfilade::MaterialId;
use glam::{Vec2, Vec3, vec3};
use std::f64::consts::PI;

/// Returns for each wall the corners of its upper edge between its ends, from right to left; and the ceiling.
pub(super) fn roof(
    plan: Plan,
    height: f32,
    ceiling: Ceiling,
    material: MaterialId,
) -> (Vec<Vec<Vec3>>, Shape) {
    let corners = plan.corners();
    let mut tops = vec![Vec::new(); corners.len()];
    let mut shape = Shape::new();
    let edge = |inset: f32, up: f32| -> Vec<Vec3> {
        inwards(&corners, inset)
            .iter()
            .map(|at| vec3(at.x, height + up, at.y))
            .collect()
    };
    match ceiling {
        Ceiling::Sky => {}
        Ceiling::Flat => shape.face(material, &edge(0.0, 0.0)),
        Ceiling::Cove(inset, rise) => {
            const STEPS: usize = 6;
            let rings: Vec<Vec<Vec3>> = (0..=STEPS)
                .map(|i| {
                    let (sin, cos) = (0.5 * PI * i as f64 / STEPS as f64).sin_cos();
                    let inset = inset * (1.0 - cos as f32);
                    if i == 0 {
                        edge(0.0, 0.0)
                    } else {
                        edge(inset, rise * sin as f32)
                    }
                })
                .collect();
            rings_inside(&mut shape, material, &rings);
            shape.face(material, &rings[STEPS]);
        }
        Ceiling::Dome(rise, lantern) => {
            const STEPS: usize = 10;
            let Plan::Round(center, reach, _) = plan else {
                panic!("a dome needs a round room")
            };
            let center = Vec2::from(center);
            let ring = |scale: f32, up: f32| -> Vec<Vec3> {
                let at = |corner: &Vec2| center + (*corner - center) * scale;
                corners
                    .iter()
                    .map(|corner| vec3(at(corner).x, height + up, at(corner).y))
                    .collect()
            };
            let open = lantern / reach;
            let steepest = f64::from(open).acos();
            let mut rings: Vec<Vec<Vec3>> = (1..=STEPS)
                .map(|i| {
                    let (sin, cos) = (steepest * i as f64 / STEPS as f64).sin_cos();
                    ring(cos as f32, rise * sin as f32)
                })
                .collect();
            rings.insert(0, edge(0.0, 0.0));
            let top = rings[STEPS][0].y - height;
            rings.push(ring(open, top + 2.2 * lantern));
            rings_inside(&mut shape, material, &rings);
            shape.face(material, &rings[rings.len() - 1]);
        }
        Ceiling::Vault(axis, rise) => vault(plan, height, axis, rise, material, &mut tops, &mut shape),
    }
    (tops, shape)
}

/// Adds bands between rings that are clockwise as seen from above, facing inwards.
fn rings_inside(shape: &mut Shape, material: MaterialId, rings: &[Vec<Vec3>]) {
    for pair in rings.windows(2) {
        let count = pair[0].len();
        for i in 0..count {
            let next = (i + 1) % count;
            shape.face(material, &[pair[0][i], pair[0][next], pair[1][next], pair[1][i]]);
        }
    }
}

/// Returns the corners of a vault's arc from `left` to `right`, both included, as seen along the vault.
pub(crate) fn arc(left: Vec2, right: Vec2, height: f32, rise: f32) -> Vec<Vec3> {
    let middle = 0.5 * (left + right);
    (0..=ARC)
        .map(|i| {
            let (sin, cos) = (PI * i as f64 / ARC as f64).sin_cos();
            // The ends equal the walls' corners bit for bit.
            match i {
                0 => vec3(left.x, height, left.y),
                ARC => vec3(right.x, height, right.y),
                _ => {
                    let at = middle + (left - middle) * cos as f32;
                    vec3(at.x, height + rise * sin as f32, at.y)
                }
            }
        })
        .collect()
}

fn vault(
    plan: Plan,
    height: f32,
    axis: Axis,
    rise: f32,
    material: MaterialId,
    tops: &mut [Vec<Vec3>],
    shape: &mut Shape,
) {
    let (x, z, apse) = match plan {
        Plan::Rectangle(x, z) => (x, z, None),
        Plan::Apse(x, z, side) => (x, z, Some(side)),
        Plan::Round(..) => panic!("a vault needs a rectangular room or an apse"),
    };
    let corners = rectangle(x, z);
    // The two ends of the vault, each with its arc as seen from inside.
    let ends = match axis {
        Axis::NorthSouth => [Side::North, Side::South],
        Axis::WestEast => [Side::East, Side::West],
    };
    let [far, near] = ends.map(|side| {
        let [left, right] = [corners[side as usize], corners[(side as usize + 1) % 4]];
        arc(left, right, height, rise)
    });
    for i in 0..ARC {
        // As seen from inside at the far end, the near arc runs the other way.
        shape.face(material, &[far[i], far[i + 1], near[ARC - i - 1], near[ARC - i]]);
    }
    for (side, arc) in ends.into_iter().zip([&far, &near]) {
        if apse == Some(side) {
            half_dome(plan, arc, height, rise, material, shape);
        } else {
            tops[plan.wall(side)] = arc[1..ARC].iter().rev().copied().collect();
        }
    }
}

/// Adds a half dome over an apse, bounded by the arc of the vault before it.
fn half_dome(plan: Plan, arc: &[Vec3], height: f32, rise: f32, material: MaterialId, shape: &mut Shape) {
    const HALF: usize = ARC / 2;
    let Plan::Apse(_, _, side) = plan else { return };
    let corners = plan.corners();
    let first = side as usize;
    let center = plan.center();
    // From the left end of the arc around the apse to the right end.
    let point = |around: usize, up: usize| -> Vec3 {
        let foot = corners[(first + around) % corners.len()];
        match (around, up) {
            (_, HALF) => arc[HALF],
            (0, _) => arc[up],
            (HALF, _) => arc[ARC - up],
            (_, 0) => vec3(foot.x, height, foot.y),
            _ => {
                let (sin, cos) = (0.5 * PI * up as f64 / HALF as f64).sin_cos();
                let at = center + (foot - center) * cos as f32;
                vec3(at.x, height + rise * sin as f32, at.y)
            }
        }
    };
    for around in 0..HALF {
        for up in 0..HALF {
            let face = [
                point(around, up),
                point(around + 1, up),
                point(around + 1, up + 1),
                point(around, up + 1),
            ];
            if up + 1 == HALF {
                shape.triangle(material, [face[0], face[1], face[2]]);
            } else {
                shape.face(material, &face);
            }
        }
    }
}
