//! Room envelopes: a box-shaped room with holes in its walls, closed without cracks.
//!
//! Adjacent surfaces share their corners bit for bit: a floor has a corner at each end of a doorway. So rays leave a
//! room through openings only.

use crate::laws::stage::{BROWN, Doorway, GREY, WHITE};
use crate::shape::{Shape, fill};
use glam::{Vec2, Vec3, vec2, vec3};

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

/// The closed inner surface of a room, in pieces.
pub(crate) struct Envelope {
    pub(crate) floor: Shape,
    /// One for each side, with the sides of its holes.
    pub(crate) walls: [Shape; 4],
    pub(crate) ceiling: Shape,
}

/// Builds the closed surface of a room with its floor at y = 0. Each hole leads from its wall to its opening.
pub(crate) fn envelope(x: [f32; 2], z: [f32; 2], height: f32, holes: &[Doorway]) -> Envelope {
    // Clockwise as seen from above: walls run from left to right as seen from inside.
    let corners = [
        vec2(x[0], z[1]),
        vec2(x[0], z[0]),
        vec2(x[1], z[0]),
        vec2(x[1], z[1]),
    ];
    let mut floor = Shape::new();
    let mut floor_outline = Vec::new();
    let walls = Side::ALL.map(|side| {
        let [left, right] = [corners[side as usize], corners[(side as usize + 1) % 4]];
        let mut wall = Shape::new();
        let mut holes: Vec<HoleSides> = holes
            .iter()
            .filter(|hole| hole.side == side)
            .map(|hole| HoleSides::new(hole, left))
            .collect();
        let from_left = |hole: &HoleSides| vec2(hole.near[0].x, hole.near[0].z).distance(left);
        holes.sort_by(|a, b| from_left(a).total_cmp(&from_left(b)));
        let mut outline = vec![vec3(left.x, 0.0, left.y)];
        let mut windows = Vec::new();
        for hole in &holes {
            if hole.near[0].y == 0.0 {
                outline.push(hole.near[0]);
                outline.extend(hole.near[1..].iter().rev());
                // The sill is part of the floor.
                floor.face(BROWN, &hole.side(0));
            } else {
                windows.push(hole.near.clone());
                wall.face(BROWN, &hole.side(0));
            }
            for i in 1..hole.near.len() {
                wall.face(BROWN, &hole.side(i));
            }
        }
        floor_outline.extend(outline.iter().copied().filter(|corner| corner.y == 0.0));
        outline.push(vec3(right.x, 0.0, right.y));
        outline.push(vec3(right.x, height, right.y));
        outline.push(vec3(left.x, height, left.y));
        for face in fill(&outline, &windows) {
            wall.face(WHITE, &face);
        }
        wall
    });
    floor_outline.reverse();
    for face in fill(&floor_outline, &[]) {
        floor.face(GREY, &face);
    }
    let mut ceiling = Shape::new();
    ceiling.face(GREY, &corners.map(|at| vec3(at.x, height, at.y)));
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
}

impl HoleSides {
    fn new(hole: &Doorway, left: Vec2) -> HoleSides {
        let far = hole.outline();
        let onto_wall = |corner: &Vec3| match hole.side {
            Side::West | Side::East => vec3(left.x, corner.y, corner.z),
            Side::North | Side::South => vec3(corner.x, corner.y, left.y),
        };
        HoleSides {
            near: far.iter().map(onto_wall).collect(),
            far,
        }
    }

    /// Returns the side from an edge of the near outline to that of the far one.
    fn side(&self, i: usize) -> [Vec3; 4] {
        let next = (i + 1) % self.near.len();
        [self.near[i], self.near[next], self.far[next], self.far[i]]
    }
}
