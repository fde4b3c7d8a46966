//! Ceiling decoration: coffers with rosettes, ribs, beams, stucco fields.

use super::room::{Room, arched};
use super::workshop::Workshop;
use crate::envelope::{ARC, Axis, Ceiling, Plan, Side, arc, inwards};
use crate::shape::{Shape, block, fluted, lathe, surround};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec2, Vec3, vec2, vec3};
use std::f32::consts::TAU;
use std::sync::Arc;

/// Materials of a coffer: ribs, gilded steps, rosette.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coffering {
    pub(crate) rib: MaterialId,
    pub(crate) step: MaterialId,
    pub(crate) rosette: MaterialId,
}

/// Coffers over a flat ceiling, or over the flat middle of a coved one.
pub(crate) fn coffer_flat(room: &mut Room, size: f32, coffering: Coffering) {
    let (inset, up) = match room.design.ceiling {
        Ceiling::Cove(inset, rise) => (inset, rise),
        _ => (0.0, 0.0),
    };
    let corners = inwards(&room.design.plan.corners(), inset);
    let [least, most] = [corners[1], corners[3]];
    let height = room.design.height + up;
    let count = ((most - least) / size).round().max(Vec2::ONE);
    let step = (most - least) / count;
    let coffer = flat_coffer(room.shop, step, 0.3, coffering);
    for row in 0..count.y as usize {
        for column in 0..count.x as usize {
            let at = least + step * vec2(column as f32 + 0.5, row as f32 + 0.5);
            room.put("coffer", &coffer, Transform::translation([at.x, height, at.y]));
        }
    }
}

/// Adds coffers to a vault: one for every `every` segments of its arc, about as long as wide.
pub(crate) fn coffer_vault(room: &mut Room, every: usize, coffering: Coffering) {
    let (Plan::Rectangle(x, z) | Plan::Apse(x, z, _), Ceiling::Vault(axis, rise)) =
        (room.design.plan, room.design.ceiling)
    else {
        return;
    };
    let height = room.design.height;
    let [west, east, north, south] = [x[0], x[1], z[0], z[1]];
    // The arc at the vault's beginning, and the direction along it.
    let (start, length, along) = match axis {
        Axis::NorthSouth => (
            arc(vec2(west, south), vec2(east, south), height, rise),
            south - north,
            Side::North,
        ),
        Axis::WestEast => (
            arc(vec2(west, north), vec2(west, south), height, rise),
            east - west,
            Side::East,
        ),
    };
    let along = along.direction();
    let along = vec3(along.x, 0.0, along.y);
    for i in (every / 2..ARC).step_by(every) {
        let first = i - every / 2;
        let [left, right] = [start[first], start[first + every]];
        let wide = left.distance(right);
        let count = (length / wide).round().max(1.0);
        let deep = length / count;
        let coffer = flat_coffer(room.shop, vec2(wide, deep), 0.12 * wide.min(deep), coffering);
        // Coffer axes: across the arc, out of the ceiling's upper side, back along the vault.
        let across = (right - left) / wide;
        let upwards = across.cross(along);
        let upwards = if upwards.y < 0.0 { -upwards } else { upwards };
        let back = across.cross(upwards);
        // Coffers hang from the middle of their arc's chord.
        let middle = 0.5 * (left + right);
        for step in 0..count as usize {
            let at = middle + along * deep * (step as f32 + 0.5);
            let place = [across, upwards, back, at].map(|column| column.to_array());
            room.put("coffer", &coffer, Transform::from_columns(place));
        }
    }
}

/// Adds rings of coffers to a dome, one field for each of the dome's sides.
pub(crate) fn coffer_dome(room: &mut Room, coffering: Coffering) {
    let (Plan::Round(center, reach, sides), Ceiling::Dome(rise, lantern)) =
        (room.design.plan, room.design.ceiling)
    else {
        return;
    };
    const STEPS: usize = 10;
    let half = reach * (0.5 * TAU / sides as f32).tan();
    let steepest = (lantern / reach).acos();
    let corner = |ring: usize, side: f32| {
        let (sin, cos) = (steepest * ring as f32 / STEPS as f32).sin_cos();
        vec3(side * half * cos, rise * sin, -reach * cos)
    };
    for ring in (0..STEPS - 1).step_by(2) {
        let outline = [
            corner(ring + 2, 1.0),
            corner(ring + 2, -1.0),
            corner(ring, -1.0),
            corner(ring, 1.0),
        ];
        let depth = 0.13 * outline[0].distance(outline[1]).min(1.2);
        let coffer = room.shop.piece(format!("dome coffer {ring}"), || {
            coffer(&outline, depth, coffering)
        });
        for side in 0..sides {
            let turn = f64::from(TAU) * side as f64 / sides as f64;
            let place = Transform::translation([center[0], room.design.height, center[1]])
                * Transform::rotation([0.0, 1.0, 0.0], turn);
            room.put("coffer", &coffer, place);
        }
    }
}

/// A coffer below the plane y = 0, its middle at the origin.
fn flat_coffer(shop: &mut Workshop, size: Vec2, depth: f32, coffering: Coffering) -> Arc<Mesh> {
    shop.piece(format!("coffer {size} {depth} {coffering:?}"), || {
        let half = 0.5 * size;
        let corner = |x: f32, z: f32| vec3(x * half.x, 0.0, z * half.y);
        coffer(
            &[
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ],
            depth,
            coffering,
        )
    })
}

/// Ribs and steps around a field, with a rosette in it. The outline is counter-clockwise as seen from the room.
fn coffer(outline: &[Vec3; 4], depth: f32, Coffering { rib, step, rosette }: Coffering) -> Shape {
    let middle = outline.iter().sum::<Vec3>() / 4.0;
    let normal = (outline[1] - outline[0])
        .cross(outline[3] - outline[0])
        .normalize();
    let ring =
        |inset: f32, out: f32| outline.map(|corner| corner.lerp(middle, inset) + normal * (out * depth));
    let rings = [
        ring(0.0, 1.0),
        ring(0.2, 1.0),
        ring(0.24, 0.86),
        ring(0.24, 0.6),
        ring(0.36, 0.52),
        ring(0.4, 0.4),
        ring(0.4, 0.12),
        ring(0.46, 0.02),
    ];
    let mut shape = Shape::new();
    for (i, pair) in rings.windows(2).enumerate() {
        let material = if i % 3 == 1 { step } else { rib };
        for side in 0..4 {
            let next = (side + 1) % 4;
            shape.face(
                material,
                &[pair[0][side], pair[0][next], pair[1][next], pair[1][side]],
            );
        }
    }
    let reach = 0.3 * (outline[0].distance(outline[1])).min(outline[1].distance(outline[2]));
    let across = (outline[1] - outline[0]).normalize();
    let place = [across, normal, across.cross(normal), middle].map(|column| column.to_array());
    shape.add(
        &self::rosette(rosette, reach, 0.6 * depth),
        Transform::from_columns(place),
    );
    shape
}

/// A flower of eight petals at the origin, facing up.
pub(crate) fn rosette(material: MaterialId, reach: f32, height: f32) -> Shape {
    let petals = [[0.98, 0.0], [1.0, 0.25], [0.7, 0.5], [0.3, 0.28], [0.0, 0.28]];
    let mut shape = fluted(
        material,
        &petals.map(|[out, up]| [out * reach, up * height]),
        8,
        3,
        0.3,
    );
    let bud = [[0.26, 0.2], [0.28, 0.5], [0.16, 0.8], [0.0, 0.9]];
    shape.join(lathe(
        material,
        &bud.map(|[out, up]| [out * reach, up * height]),
        10,
    ));
    shape
}

/// Beams over a flat ceiling: heavy ones from west to east, light ones across.
pub(crate) fn beams(room: &mut Room, heavy: MaterialId, light: MaterialId, spacing: f32) {
    let Plan::Rectangle(x, z) = room.design.plan else {
        return;
    };
    let height = room.design.height;
    let count = ((z[1] - z[0]) / spacing).round();
    let step = (z[1] - z[0]) / count;
    let long = x[1] - x[0];
    let beam = room.shop.piece(format!("beam {long} {}", heavy.0), || {
        let mut shape = block(heavy, [0.0, -0.42, -0.17], [long, 0.0, 0.17]);
        shape.join(block(light, [0.0, -0.46, -0.1], [long, -0.42, 0.1]));
        shape
    });
    for i in 1..count as usize {
        room.put(
            "beam",
            &beam,
            Transform::translation([x[0], height, z[0] + step * i as f32]),
        );
    }
    let joist = room.shop.piece(format!("joist {step} {}", light.0), || {
        block(light, [-0.07, -0.16, 0.17], [0.07, 0.0, step - 0.17])
    });
    let joists = (long / 0.62) as usize;
    for i in 0..count as usize {
        for j in 0..joists {
            let at = x[0] + long * (j as f32 + 0.5) / joists as f32;
            room.put(
                "joist",
                &joist,
                Transform::translation([at, height, z[0] + step * i as f32]),
            );
        }
    }
}

/// Arches under a vault, at positions `places` along it from its southern or western end.
pub(crate) fn ribs(room: &mut Room, material: MaterialId, wide: f32, deep: f32, places: &[f32]) {
    let (Plan::Rectangle(x, z) | Plan::Apse(x, z, _), Ceiling::Vault(axis, rise)) =
        (room.design.plan, room.design.ceiling)
    else {
        return;
    };
    let half = 0.5
        * if axis == Axis::NorthSouth {
            x[1] - x[0]
        } else {
            z[1] - z[0]
        };
    let rib = room
        .shop
        .piece(format!("rib {half} {rise} {wide} {deep} {}", material.0), || {
            let [outer, inner] = [(half, rise), (half - deep, rise - deep)]
                .map(|(half, rise)| arc(vec2(-half, 0.0), vec2(half, 0.0), 0.0, rise));
            let mut shape = Shape::new();
            let near = vec3(0.0, 0.0, 0.5 * wide);
            for i in 0..ARC {
                let [a, b, c, d] = [inner[i], inner[i + 1], outer[i + 1], outer[i]];
                shape.face(material, &[a - near, b - near, b + near, a + near]);
                shape.face(material, &[d + near, a + near, b + near, c + near]);
                shape.face(material, &[a - near, d - near, c - near, b - near]);
            }
            shape
        });
    for &place in places {
        let at = match axis {
            Axis::NorthSouth => {
                Transform::translation([0.5 * (x[0] + x[1]), room.design.height, z[1] - place])
            }
            Axis::WestEast => {
                Transform::translation([x[0] + place, room.design.height, 0.5 * (z[0] + z[1])])
                    * Transform::rotation([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_2)
            }
        };
        room.put("rib", &rib, at);
    }
}

/// Gilded stars on the half dome of an apse.
pub(crate) fn stars(room: &mut Room, count: usize, material: MaterialId) {
    let (Plan::Apse(x, z, side), Ceiling::Vault(_, rise)) = (room.design.plan, room.design.ceiling) else {
        return;
    };
    let reach = 0.5
        * if matches!(side, Side::North | Side::South) {
            x[1] - x[0]
        } else {
            z[1] - z[0]
        };
    let center = room.design.plan.center();
    let outwards = side.direction();
    let across = vec2(-outwards.y, outwards.x);
    let star = room.shop.piece(format!("star {}", material.0), || {
        fluted(material, &[[1.0, 0.0], [0.0, 0.3]], 5, 2, 0.6)
    });
    for i in 0..count {
        // A spiral distributes the points evenly over the half ball.
        let up = (i as f32 + 0.5) / count as f32;
        let turn = (i as f32 * 0.618_034).fract() * 0.5 * TAU;
        let out = (1.0 - up * up).sqrt();
        let on_plan = across * (out * turn.cos()) + outwards * (out * turn.sin());
        let at = vec3(
            center.x + reach * on_plan.x,
            room.design.height + rise * up,
            center.y + reach * on_plan.y,
        );
        let normal = -vec3(on_plan.x / reach, up / rise, on_plan.y / reach).normalize();
        let right = normal.any_orthonormal_vector();
        let size = 0.07 + 0.05 * room.random.unit();
        let place = [
            right * size,
            normal * size,
            right.cross(normal) * size,
            at + normal * 0.06,
        ];
        room.put(
            "star",
            &star,
            Transform::from_columns(place.map(|column| column.to_array())),
        );
    }
}

/// A painted field with golden rays, framed, under the arch at a vault's end; it begins `foot` above the walls.
pub(crate) fn lunette(room: &mut Room, side: Side, foot: f32, field: MaterialId, gilt: MaterialId) {
    const RAYS: usize = 15;
    let Ceiling::Vault(_, rise) = room.design.ceiling else {
        return;
    };
    let wall = room.wall(side);
    let half = 0.5 * wall.length();
    // The arch is lower and narrower at the foot of the field than at the vault's.
    let level = foot / rise;
    let [wide, high] = [0.88 * half * (1.0 - level * level).sqrt(), 0.86 * (rise - foot)];
    let lunette = room
        .shop
        .piece(format!("lunette {wide} {high} {} {}", field.0, gilt.0), || {
            let outline = arched(2.0 * wide, 0.0, 0.02, high);
            let mut shape = Shape::new();
            let flat: Vec<Vec3> = outline.iter().map(|at| at.extend(0.02)).collect();
            shape.face(field, &flat);
            const PROFILE: [[f32; 2]; 6] = [
                [0.0, 0.02],
                [0.0, 0.06],
                [0.04, 0.08],
                [0.1, 0.08],
                [0.14, 0.05],
                [0.14, 0.0],
            ];
            shape.join(surround(gilt, &outline, true, &PROFILE));
            for ray in 0..RAYS {
                let turn = 0.5 * TAU * (ray as f32 + 0.5) / RAYS as f32;
                let out = vec2(turn.cos(), turn.sin());
                let across = vec2(-out.y, out.x) * 0.05 * high;
                let long = if ray % 2 == 0 { 0.9 } else { 0.66 };
                let tip = vec2(out.x * wide, out.y * high) * long;
                let near = out * 0.24 * high;
                let face = [near - across, tip, near + across].map(|at| at.extend(0.03));
                shape.face(gilt, &face);
            }
            let sun: Vec<Vec3> = (0..=12)
                .map(|i| 0.5 * TAU * i as f32 / 12.0)
                .map(|turn| vec3(0.27 * high * turn.cos(), 0.27 * high * turn.sin(), 0.035))
                .collect();
            shape.face(gilt, &sun);
            shape
        });
    room.hang("lunette", &lunette, side, half, room.design.height + foot);
}

/// A stucco rose in the middle of a ceiling, around a chandelier's hook.
pub(crate) fn rose(room: &mut Room, at: Vec2, radius: f32, plaster: MaterialId, gilt: MaterialId) {
    let height = room.design.crown();
    let rose = room
        .shop
        .piece(format!("rose {radius} {} {}", plaster.0, gilt.0), || {
            let mut shape = rosette(gilt, 0.45 * radius, 0.12);
            let rings: [[f32; 2]; 6] = [
                [1.0, 0.0],
                [1.0, 0.06],
                [0.94, 0.09],
                [0.88, 0.06],
                [0.86, 0.0],
                [0.86, -0.01],
            ];
            shape.join(lathe(plaster, &rings.map(|[out, up]| [out * radius, up]), 48));
            let petals: [[f32; 2]; 4] = [[0.8, -0.01], [0.78, 0.05], [0.6, 0.05], [0.5, 0.0]];
            shape.join(fluted(
                plaster,
                &petals.map(|[out, up]| [out * radius, up]),
                16,
                3,
                0.12,
            ));
            shape
        });
    let upside_down = Transform::rotation([1.0, 0.0, 0.0], std::f64::consts::PI);
    room.put(
        "ceiling rose",
        &rose,
        Transform::translation([at.x, height, at.y]) * upside_down,
    );
}
