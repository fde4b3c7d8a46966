//! Room envelopes: plan, walls with holes, floor and ceiling, closed without cracks.
//!
//! Adjacent surfaces share their corners bit for bit: a wall's upper edge is the vault's lower one, and a floor has a
//! corner at each end of a doorway. So rays leave a room through openings only.

mod roof;

pub(crate) use roof::arc;

use crate::shape::{Shape, fill};
use enfilade::MaterialId;
use glam::{Vec2, Vec3, vec2, vec3};
use std::f64::consts::PI;

/// Outline of a room seen from above.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Plan {
    /// A rectangle: minimum and maximum x, minimum and maximum z.
    Rectangle([f32; 2], [f32; 2]),
    /// A regular polygon: center, distance of the walls from it, and number of walls, a multiple of 4.
    Round([f32; 2], f32, usize),
    /// A rectangle extended beyond the named end by a half circle over its whole width.
    Apse([f32; 2], [f32; 2], Side),
}

/// A direction on the plan, and the wall in that direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Towards −x.
    West,
    /// Towards −z.
    North,
    /// Towards +x.
    East,
    /// Towards +z.
    South,
}

/// The ceiling of a room.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Ceiling {
    Flat,
    /// Flat in the middle, curved down to the walls: horizontal and vertical extent of the curve.
    Cove(f32, f32),
    /// A vault: direction of its crown, and the crown's height above the walls.
    Vault(Axis, f32),
    /// A dome over a round room: height above the walls, and radius of the lantern in its middle.
    Dome(f32, f32),
    /// Open to the sky.
    Sky,
}

/// Direction of a vault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    WestEast,
    NorthSouth,
}

/// A hole in a wall: a doorway, a window, a niche.
#[derive(Clone, Debug)]
pub(crate) struct Hole {
    /// Index of the wall on the plan.
    pub(crate) wall: usize,
    /// Outline at the far end, counter-clockwise as seen from the room; convex.
    pub(crate) far: Vec<Vec3>,
    /// Material that closes the far end; `None` where an opening closes it.
    pub(crate) back: Option<MaterialId>,
    /// Material of the hole's sides.
    pub(crate) reveal: MaterialId,
}

/// Segments of a vault's arc; even, so that the crown is a corner.
pub(crate) const ARC: usize = 24;

/// The closed inner surface of a room, in pieces.
pub(crate) struct Envelope {
    pub(crate) floor: Shape,
    /// One for each wall, with the sides of its holes.
    pub(crate) walls: Vec<Shape>,
    pub(crate) ceiling: Shape,
}

/// Materials of floor, walls and ceiling.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Finish {
    pub(crate) floor: MaterialId,
    pub(crate) wall: MaterialId,
    pub(crate) ceiling: MaterialId,
}

impl Side {
    pub(crate) const ALL: [Side; 4] = [Side::West, Side::North, Side::East, Side::South];

    pub(crate) fn opposite(self) -> Side {
        Side::ALL[(self as usize + 2) % 4]
    }

    /// Returns the unit vector on the plan, as (x, z).
    pub(crate) fn direction(self) -> Vec2 {
        match self {
            Side::West => vec2(-1.0, 0.0),
            Side::North => vec2(0.0, -1.0),
            Side::East => vec2(1.0, 0.0),
            Side::South => vec2(0.0, 1.0),
        }
    }
}

impl Plan {
    /// Returns the corners in clockwise order as seen from above, as (x, z): walls run from left to right as seen from
    /// inside.
    pub(crate) fn corners(self) -> Vec<Vec2> {
        match self {
            Plan::Rectangle(x, z) => rectangle(x, z).to_vec(),
            Plan::Round(center, reach, sides) => {
                let step = 2.0 * PI / sides as f64;
                let radius = f64::from(reach) / (0.5 * step).cos();
                let snapped = |value: f64| {
                    // Walls with doors must be exactly on their planes.
                    let value = value as f32;
                    if (value.abs() - reach).abs() < 1e-4 {
                        reach.copysign(value)
                    } else {
                        value
                    }
                };
                (0..sides)
                    .map(|i| {
                        let (sin, cos) = (step * (i as f64 - 0.5)).sin_cos();
                        Vec2::from(center) + vec2(snapped(-radius * cos), snapped(-radius * sin))
                    })
                    .collect()
            }
            Plan::Apse(x, z, side) => {
                let mut corners = rectangle(x, z).to_vec();
                let bay = side as usize;
                let [left, right] = [corners[bay], corners[(bay + 1) % 4]];
                let round = half_circle(left, right, side.direction());
                corners.splice(bay + 1..bay + 1, round);
                corners
            }
        }
    }

    /// Returns the index of the wall on a side.
    pub(crate) fn wall(self, side: Side) -> usize {
        let bay = side as usize;
        match self {
            Plan::Rectangle(..) => bay,
            Plan::Round(_, _, sides) => bay * sides / 4,
            Plan::Apse(_, _, apse) if bay > apse as usize => bay + ARC / 2 - 1,
            Plan::Apse(..) => bay,
        }
    }

    /// Returns the middle of the floor, as (x, z); of an apse, the middle of its circle.
    pub(crate) fn center(self) -> Vec2 {
        match self {
            Plan::Rectangle(x, z) => 0.5 * vec2(x[0] + x[1], z[0] + z[1]),
            Plan::Round(center, ..) => center.into(),
            Plan::Apse(x, z, side) => {
                let corners = rectangle(x, z);
                0.5 * (corners[side as usize] + corners[(side as usize + 1) % 4])
            }
        }
    }
}

fn rectangle(x: [f32; 2], z: [f32; 2]) -> [Vec2; 4] {
    [
        vec2(x[0], z[1]),
        vec2(x[0], z[0]),
        vec2(x[1], z[0]),
        vec2(x[1], z[1]),
    ]
}

/// Returns the corners between `left` and `right` of a half circle that bulges `outwards`.
fn half_circle(left: Vec2, right: Vec2, outwards: Vec2) -> Vec<Vec2> {
    let middle = 0.5 * (left + right);
    let reach = 0.5 * left.distance(right);
    (1..ARC / 2)
        .map(|i| {
            let (sin, cos) = (PI * i as f64 / (ARC / 2) as f64).sin_cos();
            middle + (left - middle) * cos as f32 + outwards * (reach * sin as f32)
        })
        .collect()
}

/// Builds the closed surface of a room.
pub(crate) fn envelope(
    plan: Plan,
    height: f32,
    ceiling: Ceiling,
    holes: &[Hole],
    finish: Finish,
) -> Envelope {
    let corners = plan.corners();
    let count = corners.len();
    let (tops, ceiling) = roof::roof(plan, height, ceiling, finish.ceiling);
    let mut floor_outline: Vec<Vec3> = Vec::new();
    let mut floor = Shape::new();
    let mut walls = Vec::with_capacity(count);
    for wall in 0..count {
        let [left, right] = [corners[wall], corners[(wall + 1) % count]];
        let mut shape = Shape::new();
        let mut holes: Vec<HoleSides> = holes
            .iter()
            .filter(|hole| hole.wall == wall)
            .map(|hole| HoleSides::new(hole, left, right))
            .collect();
        holes.sort_by(|a, b| {
            a.near[0]
                .xz()
                .distance(left)
                .total_cmp(&b.near[0].xz().distance(left))
        });
        let mut outline = vec![vec3(left.x, 0.0, left.y)];
        let mut windows = Vec::new();
        for hole in &holes {
            if hole.near[0].y == 0.0 {
                outline.push(hole.near[0]);
                outline.extend(hole.near[1..].iter().rev());
                hole.line(&mut shape, Some(&mut floor));
            } else {
                windows.push(hole.near.clone());
                hole.line(&mut shape, None);
            }
        }
        floor_outline.extend(outline.iter().filter(|corner| corner.y == 0.0));
        outline.push(vec3(right.x, 0.0, right.y));
        outline.push(vec3(right.x, height, right.y));
        outline.extend(&tops[wall]);
        outline.push(vec3(left.x, height, left.y));
        for face in fill(&outline, &windows) {
            shape.face(finish.wall, &face);
        }
        walls.push(shape);
    }
    floor_outline.reverse();
    for face in fill(&floor_outline, &[]) {
        floor.face(finish.floor, &face);
    }
    Envelope {
        floor,
        walls,
        ceiling,
    }
}

/// A hole through its wall; both outlines begin with the lower edge.
struct HoleSides {
    near: Vec<Vec3>,
    far: Vec<Vec3>,
    back: Option<MaterialId>,
    reveal: MaterialId,
}

impl HoleSides {
    fn new(hole: &Hole, left: Vec2, right: Vec2) -> HoleSides {
        let lowest = hole
            .far
            .iter()
            .fold(f32::INFINITY, |least, corner| least.min(corner.y));
        let count = hole.far.len();
        let first = (0..count)
            .find(|&i| hole.far[i].y == lowest && hole.far[(i + 1) % count].y == lowest)
            .expect("a hole with a horizontal lower edge");
        let far: Vec<Vec3> = (0..count).map(|i| hole.far[(first + i) % count]).collect();
        let along = (right - left).normalize();
        let into_room = vec2(-along.y, along.x);
        let onto_wall = |corner: &Vec3| {
            if left.x == right.x {
                vec3(left.x, corner.y, corner.z)
            } else if left.y == right.y {
                vec3(corner.x, corner.y, left.y)
            } else {
                let at = corner.xz() + into_room * (left - corner.xz()).dot(into_room);
                vec3(at.x, corner.y, at.y)
            }
        };
        HoleSides {
            near: far.iter().map(onto_wall).collect(),
            far,
            back: hole.back,
            reveal: hole.reveal,
        }
    }

    /// Adds the sides from the wall to the far end, and the surface that closes it. The sill is added to the floor if
    /// given.
    fn line(&self, wall: &mut Shape, floor: Option<&mut Shape>) {
        let count = self.near.len();
        let side = |i: usize| {
            let next = (i + 1) % count;
            [self.near[i], self.near[next], self.far[next], self.far[i]]
        };
        match floor {
            Some(floor) => floor.face(self.reveal, &side(0)),
            None => wall.face(self.reveal, &side(0)),
        }
        for i in 1..count {
            wall.face(self.reveal, &side(i));
        }
        if let Some(material) = self.back {
            wall.face(material, &self.far);
        }
    }
}

/// Returns the plan with all walls moved inwards.
pub(crate) fn inwards(corners: &[Vec2], inset: f32) -> Vec<Vec2> {
    let count = corners.len();
    let into_room = |i: usize| {
        let along = (corners[(i + 1) % count] - corners[i % count]).normalize();
        vec2(-along.y, along.x)
    };
    (0..count)
        .map(|i| {
            let [before, after] = [into_room(i + count - 1), into_room(i)];
            corners[i] + (before + after) * (inset / (1.0 + before.dot(after)))
        })
        .collect()
}

/// Conversion of a corner to plan coordinates.
trait OnPlan {
    fn xz(&self) -> Vec2;
}

impl OnPlan for Vec3 {
    fn xz(&self) -> Vec2 {
        vec2(self.x, self.z)
    }
}
