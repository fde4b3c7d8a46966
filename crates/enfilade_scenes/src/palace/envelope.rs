//! What encloses a room: its plan, its walls with holes, its ceiling, closed without a crack.
//!
//! Surfaces that meet are made of the same corners, bit for bit: a wall's upper edge is the vault's lower one, a
//! floor has a corner wherever a doorway begins. So no ray gets out but through an opening.

use super::palette::PLASTER;
use crate::shape::{Shape, fill};
use enfilade::MaterialId;
use glam::{Vec2, Vec3, vec2, vec3};
use std::f64::consts::PI;

/// Outline of a room seen from above.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Plan {
    /// A rectangle: least and greatest x, least and greatest z.
    Rectangle([f32; 2], [f32; 2]),
    /// A regular polygon: its center, the distance of its walls from it, and their number, a multiple of 4.
    Round([f32; 2], f32, usize),
    /// A rectangle and, beyond the named end, half a circle over its whole width.
    Apse([f32; 2], [f32; 2], Side),
}

/// A direction on the plan, and the wall that one sees looking there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// To −x.
    West,
    /// To −z.
    North,
    /// To +x.
    East,
    /// To +z.
    South,
}

/// What closes a room above its walls.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Ceiling {
    Flat,
    /// Flat in the middle, curved down to the walls: how far it reaches inwards, how far up.
    Cove(f32, f32),
    /// A vault whose crown, so far above the walls, runs from west to east or from north to south.
    Vault(Axis, f32),
    /// A dome over a round room: its height above the walls, and the radius of the lantern in its middle.
    Dome(f32, f32),
    /// None.
    Sky,
}

/// The direction in which a vault runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    WestEast,
    NorthSouth,
}

/// A hole in a wall: a doorway, a window, a niche.
#[derive(Clone, Debug)]
pub(crate) struct Hole {
    /// The wall, by its place on the plan.
    pub(crate) wall: usize,
    /// Outline at the far end, counter-clockwise seen from the room; convex.
    pub(crate) far: Vec<Vec3>,
    /// What the far end is closed with; `None` where an opening closes it.
    pub(crate) back: Option<MaterialId>,
    /// What the sides of the hole are made of.
    pub(crate) reveal: MaterialId,
}

/// Sides of a vault's arc; even, so that a corner stands at the crown.
pub(crate) const ARC: usize = 24;

/// The closed inner surface of a room, piece by piece.
pub(crate) struct Envelope {
    pub(crate) floor: Shape,
    /// One for each wall, with the sides of its holes.
    pub(crate) walls: Vec<Shape>,
    pub(crate) ceiling: Shape,
}

/// Materials of the three.
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

    /// Unit vector on the plan, as (x, z).
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
    /// Corners in clockwise order from above, as (x, z): so walls read from left to right for who stands inside.
    pub(crate) fn corners(self) -> Vec<Vec2> {
        match self {
            Plan::Rectangle(x, z) => rectangle(x, z).to_vec(),
            Plan::Round(center, reach, sides) => {
                let step = 2.0 * PI / sides as f64;
                let radius = f64::from(reach) / (0.5 * step).cos();
                let snapped = |value: f64| {
                    // The walls that doors stand in must lie on their planes exactly.
                    let value = value as f32;
                    if (value.abs() - reach).abs() < 1e-4 { reach.copysign(value) } else { value }
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

    /// The wall that stands on a side.
    pub(crate) fn wall(self, side: Side) -> usize {
        let bay = side as usize;
        match self {
            Plan::Rectangle(..) => bay,
            Plan::Round(_, _, sides) => bay * sides / 4,
            Plan::Apse(_, _, apse) if bay > apse as usize => bay + ARC / 2 - 1,
            Plan::Apse(..) => bay,
        }
    }

    /// The middle of the floor, as (x, z); of an apse, the middle of its circle.
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
    [vec2(x[0], z[1]), vec2(x[0], z[0]), vec2(x[1], z[0]), vec2(x[1], z[1])]
}

/// The corners between `left` and `right` of half a circle that bulges `outwards`.
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

/// The closed surface of a room.
pub(crate) fn envelope(plan: Plan, height: f32, ceiling: Ceiling, holes: &[Hole], finish: Finish) -> Envelope {
    let corners = plan.corners();
    let count = corners.len();
    let (tops, ceiling) = roof(plan, height, ceiling, finish.ceiling);
    let mut floor_outline: Vec<Vec3> = Vec::new();
    let mut floor = Shape::new();
    let mut walls = Vec::with_capacity(count);
    for wall in 0..count {
        let [left, right] = [corners[wall], corners[(wall + 1) % count]];
        let mut shape = Shape::new();
        let mut holes: Vec<Bored> =
            holes.iter().filter(|hole| hole.wall == wall).map(|hole| Bored::new(hole, left, right)).collect();
        holes.sort_by(|a, b| a.near[0].xz().distance(left).total_cmp(&b.near[0].xz().distance(left)));
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
    Envelope { floor, walls, ceiling }
}

/// A hole as it goes through its wall; both outlines begin with the lower edge.
struct Bored {
    near: Vec<Vec3>,
    far: Vec<Vec3>,
    back: Option<MaterialId>,
    reveal: MaterialId,
}

impl Bored {
    fn new(hole: &Hole, left: Vec2, right: Vec2) -> Bored {
        let lowest = hole.far.iter().fold(f32::INFINITY, |least, corner| least.min(corner.y));
        let count = hole.far.len();
        let first = (0..count)
            .find(|&i| hole.far[i].y == lowest && hole.far[(i + 1) % count].y == lowest)
            .expect("a hole has a level lower edge");
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
        Bored { near: far.iter().map(onto_wall).collect(), far, back: hole.back, reveal: hole.reveal }
    }

    /// The sides from the wall to the far end, and what closes it there. The sill is part of the floor if given.
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

/// For each wall the corners of its upper edge between its ends, from right to left; and the ceiling.
fn roof(plan: Plan, height: f32, ceiling: Ceiling, material: MaterialId) -> (Vec<Vec<Vec3>>, Shape) {
    let corners = plan.corners();
    let mut tops = vec![Vec::new(); corners.len()];
    let mut shape = Shape::new();
    let edge = |inset: f32, up: f32| -> Vec<Vec3> {
        inwards(&corners, inset).iter().map(|at| vec3(at.x, height + up, at.y)).collect()
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
                    if i == 0 { edge(0.0, 0.0) } else { edge(inset, rise * sin as f32) }
                })
                .collect();
            rings_inside(&mut shape, material, &rings);
            shape.face(material, &rings[STEPS]);
        }
        Ceiling::Dome(rise, lantern) => {
            const STEPS: usize = 10;
            let Plan::Round(center, reach, _) = plan else { panic!("only round rooms have domes") };
            let center = Vec2::from(center);
            let ring = |scale: f32, up: f32| -> Vec<Vec3> {
                let at = |corner: &Vec2| center + (*corner - center) * scale;
                corners.iter().map(|corner| vec3(at(corner).x, height + up, at(corner).y)).collect()
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
            shape.face(PLASTER, &rings[rings.len() - 1]);
        }
        Ceiling::Vault(axis, rise) => vault(plan, height, axis, rise, material, &mut tops, &mut shape),
    }
    (tops, shape)
}

/// Bands between rings that run clockwise from above, seen from inside.
fn rings_inside(shape: &mut Shape, material: MaterialId, rings: &[Vec<Vec3>]) {
    for pair in rings.windows(2) {
        let count = pair[0].len();
        for i in 0..count {
            let next = (i + 1) % count;
            shape.face(material, &[pair[0][i], pair[0][next], pair[1][next], pair[1][i]]);
        }
    }
}

/// The plan with all walls moved inwards.
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

/// Corners of a vault's arc from `left` to `right`, both included, as seen by who looks along the vault.
pub(crate) fn arc(left: Vec2, right: Vec2, height: f32, rise: f32) -> Vec<Vec3> {
    let middle = 0.5 * (left + right);
    (0..=ARC)
        .map(|i| {
            let (sin, cos) = (PI * i as f64 / ARC as f64).sin_cos();
            // The ends are the walls' corners, to the last bit.
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
        Plan::Round(..) => panic!("a round room has a dome"),
    };
    let corners = rectangle(x, z);
    // The two ends of the vault, each with its arc seen from inside.
    let ends = match axis {
        Axis::NorthSouth => [Side::North, Side::South],
        Axis::WestEast => [Side::East, Side::West],
    };
    let [far, near] = ends.map(|side| {
        let [left, right] = [corners[side as usize], corners[(side as usize + 1) % 4]];
        arc(left, right, height, rise)
    });
    for i in 0..ARC {
        // Seen from inside at the far end, the near arc runs the other way.
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

/// Half a dome over an apse, whose edge is the arc of the vault before it.
fn half_dome(plan: Plan, arc: &[Vec3], height: f32, rise: f32, material: MaterialId, shape: &mut Shape) {
    const HALF: usize = ARC / 2;
    let Plan::Apse(_, _, side) = plan else { return };
    let corners = plan.corners();
    let first = side as usize;
    let center = plan.center();
    // From the left end of the arc round the apse to the right end.
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
            let face =
                [point(around, up), point(around + 1, up), point(around + 1, up + 1), point(around, up + 1)];
            if up + 1 == HALF {
                shape.triangle(material, [face[0], face[1], face[2]]);
            } else {
                shape.face(material, &face);
            }
        }
    }
}

/// The plan coordinates of a corner.
trait OnPlan {
    fn xz(&self) -> Vec2;
}

impl OnPlan for Vec3 {
    fn xz(&self) -> Vec2 {
        vec2(self.x, self.z)
    }
}
