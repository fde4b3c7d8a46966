//! The closed surface of a convex cell: every wall is one plane, with openings, frames and pictures in it.
//!
//! Adjacent surfaces share their corners bit for bit, as in [`envelope`](crate::envelope). Unlike there, holes have no
//! depth, and each is filled by an opening or a picture.

use super::HEIGHT;
use crate::envelope::{Plan, Side, inwards};
use crate::palace::doors::Gate;
use crate::palace::palette::*;
use crate::shape::{Shape, fill};
use enfilade::{ConvexPolygon, MaterialId};
use glam::{Vec2, Vec3, vec2, vec3};
use std::f64::consts::FRAC_PI_2;

/// Width of the flat frames around openings and pictures.
const FRAME: f32 = 0.16;
const GILT: f32 = 0.11;
/// Size of a picture, in the aspect ratio of the paintings, and the height of its foot.
const PICTURE: [f32; 2] = [2.0, 1.5];
const PICTURE_FOOT: f32 = 1.55;
/// Approximate width of a panel.
const PANEL: f32 = 1.1;

/// The ceiling; convex as seen from inside.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Vaulting {
    /// Horizontal and vertical extent of the curve.
    Cove(f32, f32),
    /// Height.
    Dome(f32),
}

/// A picture in a wall, and the distance of its middle from the wall's left end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Painted {
    side: Side,
    along: f32,
    number: usize,
}

impl Painted {
    pub(crate) const fn new(side: Side, along: f32, number: usize) -> Painted {
        Painted { side, along, number }
    }
}

/// One side of a door or window.
pub(crate) struct End {
    /// Index of the door.
    pub(crate) number: usize,
    pub(crate) gate: Gate,
    /// The wall that contains it.
    side: Side,
    /// Outline, counter-clockwise as seen from inside, from the lower left corner.
    pub(crate) corners: Vec<Vec3>,
    /// Outline of its frame.
    frame: Vec<Vec3>,
}

impl End {
    /// Creates one side of a gate: with `near` the side of the gate's near room, else that of its far room.
    pub(crate) fn new(number: usize, gate: &Gate, near: bool) -> End {
        let wider = Gate {
            width: gate.width + 2.0 * FRAME,
            sill: if gate.sill > 0.0 {
                gate.sill - 0.6 * FRAME
            } else {
                0.0
            },
            spring: if gate.rise > 0.0 {
                gate.spring
            } else {
                gate.spring + FRAME
            },
            rise: if gate.rise > 0.0 { gate.rise + FRAME } else { 0.0 },
            ..*gate
        };
        let [corners, frame] = [gate, &wider].map(|gate| {
            let outline = gate.outline();
            if near { outline } else { from_behind(&outline) }
        });
        End {
            number,
            gate: *gate,
            side: if near { gate.looks } else { gate.looks.opposite() },
            corners,
            frame,
        }
    }

    pub(crate) fn outline(&self) -> ConvexPolygon {
        let corners: Vec<[f32; 3]> = self.corners.iter().map(|corner| corner.to_array()).collect();
        ConvexPolygon::new(&corners).expect("outlines are made convex")
    }

    fn is_door(&self) -> bool {
        self.gate.sill == 0.0
    }
}

/// Returns the outline as seen from the other side, again from the lower left corner.
fn from_behind(outline: &[Vec3]) -> Vec<Vec3> {
    let mut turned = vec![outline[1], outline[0]];
    turned.extend(outline[2..].iter().rev());
    turned
}

/// Floor, walls and ceiling of a bay.
pub(crate) fn bay(
    plan: Plan,
    vaulting: Vaulting,
    panels: MaterialId,
    pictures: &[Painted],
    ends: &[End],
) -> Vec<Shape> {
    let corners = plan.corners();
    let mut floor_outline = Vec::new();
    let mut pieces = Vec::new();
    for number in 0..corners.len() {
        let [left, right] = [corners[number], corners[(number + 1) % corners.len()]];
        let mut wall = Wall {
            left,
            right,
            outline: vec![vec3(left.x, 0.0, left.y)],
            foot: vec![vec3(left.x, 0.0, left.y)],
            holes: Vec::new(),
            shape: Shape::new(),
        };
        let is_here = |side: Side| plan.wall(side) == number;
        let mut ends: Vec<&End> = ends.iter().filter(|end| is_here(end.side)).collect();
        ends.sort_by(|a, b| wall.along(a.corners[0]).total_cmp(&wall.along(b.corners[0])));
        for end in ends {
            wall.pierce(end);
        }
        for picture in pictures.iter().filter(|picture| is_here(picture.side)) {
            wall.paint(picture);
        }
        floor_outline.append(&mut wall.foot);
        pieces.push(wall.finished(panels));
    }
    floor_outline.reverse();
    let mut floor = Shape::new();
    for face in fill(&floor_outline, &[]) {
        floor.face(INLAID_MARBLE, &face);
    }
    pieces.push(floor);
    pieces.push(ceiling(plan, &corners, vaulting));
    pieces
}

struct Wall {
    left: Vec2,
    right: Vec2,
    outline: Vec<Vec3>,
    /// Corners along the floor, from the left end on.
    foot: Vec<Vec3>,
    holes: Vec<Vec<Vec3>>,
    shape: Shape,
}

impl Wall {
    fn along(&self, at: Vec3) -> f32 {
        (vec2(at.x, at.z) - self.left).dot((self.right - self.left).normalize())
    }

    /// Leaves an opening free, and frames it.
    fn pierce(&mut self, end: &End) {
        let count = end.corners.len();
        let first = usize::from(end.is_door());
        for i in first..count {
            let next = (i + 1) % count;
            let ring = [end.frame[i], end.frame[next], end.corners[next], end.corners[i]];
            self.shape.face(WHITE_MARBLE, &ring);
        }
        if end.is_door() {
            // The floor meets the frame's feet, and the opening between them.
            self.foot
                .extend([end.frame[0], end.corners[0], end.corners[1], end.frame[1]]);
            // Up the left side, over the arch and down the right one.
            self.outline.push(end.frame[0]);
            self.outline.extend(end.frame[1..].iter().rev());
        } else {
            self.holes.push(end.frame.clone());
        }
    }

    fn paint(&mut self, picture: &Painted) {
        let right = (self.right - self.left).normalize();
        let [wide, high] = PICTURE;
        let corners = |more: f32| -> [Vec3; 4] {
            let [half, low, top] = [0.5 * wide + more, PICTURE_FOOT - more, PICTURE_FOOT + high + more];
            [(-half, low), (half, low), (half, top), (-half, top)].map(|(across, up)| {
                let at = self.left + right * (picture.along + across);
                vec3(at.x, up, at.y)
            })
        };
        let [canvas, frame] = [corners(0.0), corners(GILT)];
        let places = [vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(1.0, 0.0), vec2(0.0, 0.0)];
        self.shape.placed(painted(picture.number), &canvas, &places);
        for i in 0..4 {
            let next = (i + 1) % 4;
            self.shape
                .face(GOLD, &[frame[i], frame[next], canvas[next], canvas[i]]);
        }
        self.holes.push(frame.to_vec());
    }

    /// Fills the rest of the wall with as many panels as fit.
    fn finished(mut self, panels: MaterialId) -> Shape {
        let length = self.left.distance(self.right);
        let count = (length / PANEL).round().max(1.0);
        self.outline.push(vec3(self.right.x, 0.0, self.right.y));
        self.outline.push(vec3(self.right.x, HEIGHT, self.right.y));
        self.outline.push(vec3(self.left.x, HEIGHT, self.left.y));
        for face in fill(&self.outline, &self.holes) {
            let places: Vec<Vec2> = face
                .iter()
                .map(|&at| vec2(self.along(at) / length * count, 1.0 - at.y / HEIGHT))
                .collect();
            self.shape.placed(panels, &face, &places);
        }
        self.shape
    }
}

/// Rings over the walls, and the flat middle.
fn ceiling(plan: Plan, corners: &[Vec2], vaulting: Vaulting) -> Shape {
    const STEPS: usize = 6;
    // Shifted, so that no two sides show the same clouds; also the approximate distance between rings.
    const SHIFT: f32 = 1.7;
    const RISE: f32 = 1.0;
    let ring = |step: usize| -> Vec<Vec3> {
        if step == 0 {
            return corners.iter().map(|at| vec3(at.x, HEIGHT, at.y)).collect();
        }
        let (sin, cos) = (FRAC_PI_2 * step as f64 / STEPS as f64).sin_cos();
        let (plan, up) = match vaulting {
            Vaulting::Cove(inset, rise) => (inwards(corners, inset * (1.0 - cos as f32)), rise * sin as f32),
            Vaulting::Dome(rise) => {
                // Stops below the top, where an oculus remains.
                let (sin, cos) = (0.86 * FRAC_PI_2 * step as f64 / STEPS as f64).sin_cos();
                let center = plan.center();
                let scaled = corners.iter().map(|&at| center + (at - center) * cos as f32);
                (scaled.collect(), rise * sin as f32)
            }
        };
        plan.iter().map(|at| vec3(at.x, HEIGHT + up, at.y)).collect()
    };
    let material = match vaulting {
        Vaulting::Cove(..) => IVORY,
        Vaulting::Dome(_) => PAINTED_SKY,
    };
    let mut shape = Shape::new();
    for step in 0..STEPS {
        let [below, above] = [ring(step), ring(step + 1)];
        for i in 0..below.len() {
            let next = (i + 1) % below.len();
            let face = [below[i], below[next], above[next], above[i]];
            // Texture coordinates along the wall and upwards, uniform over a face even where it narrows.
            let right = (below[next] - below[i]).normalize();
            let up = (above[i] - below[i]).reject_from(right).normalize();
            let middle = 0.5 * (below[i] + below[next]);
            let places = face.map(|at| {
                let off = at - middle;
                vec2(
                    off.dot(right) + SHIFT * i as f32,
                    -off.dot(up) - RISE * step as f32,
                )
            });
            shape.placed(material, &face, &places);
        }
    }
    let eye = if matches!(vaulting, Vaulting::Dome(_)) {
        SKYLIGHT
    } else {
        PAINTED_SKY
    };
    shape.face(eye, &ring(STEPS));
    shape
}

/// Creates the sides of a hole through a wall, between the two openings at its ends.
pub(crate) fn threshold(ends: &[End]) -> Vec<Shape> {
    let [a, b] = ends else {
        return Vec::new();
    };
    // Both outlines are as seen from within; the near one is reversed here.
    let [near, far] = [from_behind(&a.corners), b.corners.clone()];
    let mut pieces = Vec::new();
    let mut shape = Shape::new();
    for i in 0..near.len() {
        let next = (i + 1) % near.len();
        let material = if i == 0 { GREEN_MARBLE } else { WHITE_MARBLE };
        shape.face(material, &[near[i], near[next], far[next], far[i]]);
    }
    pieces.push(shape);
    pieces
}
