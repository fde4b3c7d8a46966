//! What the rows rasterise: many faces of one size on the screen, made by a fixed seed.

use super::lens::Lens;
use std::f64::consts::TAU;

/// Separate faces: none shares a corner with another.
pub(super) struct Shapes {
    pub(super) positions: Vec<[f32; 3]>,
    /// Corners of a face, 3 or 4.
    pub(super) sides: usize,
}

/// In which order they come.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum From {
    Back,
    Front,
}

/// How far away the farthest and the nearest are.
pub(super) const FAR: f64 = 1000.0;
pub(super) const NEAR: f64 = 10.0;
/// By how much the reversed depth of a face changes from its middle to its farthest corner, relatively.
const TILT: f64 = 0.01;
/// Faces that cross the near plane stand in this part of the screen, at its left, and the others in the rest: so the first
/// hide none of the others, whatever the order.
const STRIP: f64 = 0.1;

impl Shapes {
    /// Faces with so many `sides` and pixels of area each, in random places and turned at random, sorted by distance.
    pub(super) fn new(lens: &Lens, sides: usize, pixels: f64, count: usize, from: From) -> Shapes {
        let mut dice = Dice(1);
        let mut shapes = Shapes::empty(sides, count);
        for number in 0..count {
            shapes.add(lens, &mut dice, [0.0, 1.0], pixels, rev_depth_of(number, count));
        }
        if from == From::Front {
            shapes = Shapes {
                positions: shapes.faces().rev().flatten().copied().collect(),
                sides,
            };
        }
        shapes
    }

    /// Triangles as [`Shapes::new`] makes them, but that every tenth has one corner before the near plane, half of these
    /// behind the eye; about `pixels` of it are beyond.
    pub(super) fn near(lens: &Lens, pixels: f64, count: usize) -> Shapes {
        let mut dice = Dice(2);
        let mut shapes = Shapes::empty(3, count);
        for number in 0..count {
            if number % 10 == 0 {
                shapes.add_near(lens, &mut dice, pixels);
            } else {
                shapes.add(lens, &mut dice, [STRIP, 1.0], pixels, rev_depth_of(number, count));
            }
        }
        shapes
    }

    /// The same faces, seen from behind.
    pub(super) fn turned(mut self) -> Shapes {
        let sides = self.sides;
        self.positions.chunks_exact_mut(sides).for_each(<[_]>::reverse);
        self
    }

    /// One face over the whole screen, so far away.
    pub(super) fn backdrop(lens: &Lens, w: f64) -> Shapes {
        let [width, height] = lens.size.map(f64::from);
        let corners = [
            [-1.0, height + 1.0],
            [width + 1.0, height + 1.0],
            [width + 1.0, -1.0],
            [-1.0, -1.0],
        ];
        Shapes {
            positions: corners.map(|corner| lens.point(corner, w)).to_vec(),
            sides: 4,
        }
    }

    /// The corners of each face.
    pub(super) fn faces(&self) -> impl DoubleEndedIterator<Item = &[[f32; 3]]> + ExactSizeIterator {
        self.positions.chunks_exact(self.sides)
    }

    fn empty(sides: usize, count: usize) -> Shapes {
        Shapes {
            positions: Vec::with_capacity(sides * count),
            sides,
        }
    }

    /// Adds a face that is all in these parts of the screen's width.
    fn add(&mut self, lens: &Lens, dice: &mut Dice, [left, right]: [f64; 2], pixels: f64, rev_depth: f64) {
        let sides = self.sides as f64;
        let turn = dice.roll();
        let mut around = [[0.0; 2]; 4];
        for (number, corner) in around[..self.sides].iter_mut().enumerate() {
            // Clockwise where y goes down: counter-clockwise as one sees it.
            let angle = -TAU * (turn + (number as f64 + 0.4 * (dice.roll() - 0.5)) / sides);
            *corner = [angle.cos(), angle.sin()];
        }
        let around = &around[..self.sides];
        let next = around.iter().cycle().skip(1);
        let area: f64 = around
            .iter()
            .zip(next)
            .map(|(p, q)| p[1] * q[0] - p[0] * q[1])
            .sum();
        let radius = (pixels / (0.5 * area)).sqrt();
        let [width, height] = lens.size.map(f64::from);
        let between = |low: f64, high: f64, roll: f64| low + radius + (high - low - 2.0 * radius) * roll;
        let middle = [
            between(left * width, right * width, dice.roll()),
            between(0.0, height, dice.roll()),
        ];
        let steepest = TAU * dice.roll();
        let tilt = [TILT * steepest.cos(), TILT * steepest.sin()];
        self.positions.extend(around.iter().map(|[x, y]| {
            let pixel = [middle[0] + radius * x, middle[1] + radius * y];
            lens.point(pixel, 1.0 / (rev_depth * (1.0 + tilt[0] * x + tilt[1] * y)))
        }));
    }

    /// Adds a triangle with one corner before the near plane. What is beyond has two corners there: it is about a
    /// parallelogram on the screen where the two corners ahead are twice as far away as the near plane.
    fn add_near(&mut self, lens: &Lens, dice: &mut Dice, pixels: f64) {
        let ahead = lens.near * (1.5 + dice.roll());
        let turn = TAU * dice.roll();
        let side = pixels.sqrt();
        let [along, across] = [[turn.cos(), turn.sin()], [turn.sin(), -turn.cos()]];
        let [width, height] = lens.size.map(f64::from);
        let first = [
            2.0 * side + (STRIP * width - 4.0 * side) * dice.roll(),
            2.0 * side + (height - 4.0 * side) * dice.roll(),
        ];
        let moved = |from: [f64; 2], by: [f64; 2]| [from[0] + side * by[0], from[1] + side * by[1]];
        let a = lens.point(first, ahead);
        let b = lens.point(moved(first, along), ahead);
        // As far beyond this point of the near plane as it is from the first corner.
        let on_plane = lens.point(moved(first, across), lens.near);
        let behind = [0, 1, 2].map(|axis| 2.0 * on_plane[axis] - a[axis]);
        self.positions.extend([a, b, behind]);
    }
}

/// Of a face in the row of all, the farthest first.
fn rev_depth_of(number: usize, count: usize) -> f64 {
    (FAR / NEAR).powf(number as f64 / count as f64) / FAR
}

/// Numbers by chance, always the same.
///
/// Source: Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators, OOPSLA 2014 (SplitMix64).
pub(super) struct Dice(pub(super) u64);

impl Dice {
    /// From 0 to below 1.
    pub(super) fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
