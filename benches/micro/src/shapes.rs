//! The faces that rows rasterize: many of one size on the screen, generated with a fixed seed.

use super::lens::Lens;
use std::f64::consts::TAU;

/// Separate faces: none shares a corner with another.
pub(super) struct Shapes {
    pub(super) positions: Vec<[f32; 3]>,
    /// Number of corners per face, 3 or 4.
    pub(super) sides: usize,
}

/// Order of the faces.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum FaceOrder {
    BackToFront,
    FrontToBack,
}

/// Distances of the farthest and the nearest face.
pub(super) const FAR: f64 = 1000.0;
pub(super) const NEAR: f64 = 10.0;
/// Maximum relative change of the reversed depth from the centre of a face to a corner.
const TILT: f64 = 0.01;
/// Share of the screen width, at its left, for faces that cross the near plane; the others are in the rest. So the
/// former never occlude the latter, whatever the order.
const STRIP: f64 = 0.1;

impl Shapes {
    /// Creates faces with `sides` corners and an area of `pixels` each, at random positions and rotations, sorted by
    /// distance.
    pub(super) fn new(lens: &Lens, sides: usize, pixels: f64, count: usize, order: FaceOrder) -> Shapes {
        let mut random = RandomNumbers(1);
        let mut shapes = Shapes::empty(sides, count);
        for number in 0..count {
            shapes.add(lens, &mut random, [0.0, 1.0], pixels, rev_depth_of(number, count));
        }
        if order == FaceOrder::FrontToBack {
            shapes = Shapes {
                positions: shapes.faces().rev().flatten().copied().collect(),
                sides,
            };
        }
        shapes
    }

    /// Creates triangles as [`Shapes::new`], but every tenth has one corner in front of the near plane, about half of
    /// those behind the eye; about `pixels` of its area remain after clipping.
    pub(super) fn near(lens: &Lens, pixels: f64, count: usize) -> Shapes {
        let mut random = RandomNumbers(2);
        let mut shapes = Shapes::empty(3, count);
        for number in 0..count {
            if number % 10 == 0 {
                shapes.add_near(lens, &mut random, pixels);
            } else {
                shapes.add(
                    lens,
                    &mut random,
                    [STRIP, 1.0],
                    pixels,
                    rev_depth_of(number, count),
                );
            }
        }
        shapes
    }

    /// Returns the same faces with reversed winding.
    pub(super) fn reversed(mut self) -> Shapes {
        let sides = self.sides;
        self.positions.chunks_exact_mut(sides).for_each(<[_]>::reverse);
        self
    }

    /// Creates one quad that covers the whole screen, at distance `w`.
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

    /// Returns the corners of each face.
    pub(super) fn faces(&self) -> impl DoubleEndedIterator<Item = &[[f32; 3]]> + ExactSizeIterator {
        self.positions.chunks_exact(self.sides)
    }

    fn empty(sides: usize, count: usize) -> Shapes {
        Shapes {
            positions: Vec::with_capacity(sides * count),
            sides,
        }
    }

    /// Adds a face that is entirely between these shares of the screen width.
    fn add(
        &mut self,
        lens: &Lens,
        random: &mut RandomNumbers,
        [left, right]: [f64; 2],
        pixels: f64,
        rev_depth: f64,
    ) {
        let sides = self.sides as f64;
        let turn = random.uniform();
        let mut around = [[0.0; 2]; 4];
        for (number, corner) in around[..self.sides].iter_mut().enumerate() {
            // Clockwise in numbers, because y points down: counter-clockwise on the screen.
            let angle = -TAU * (turn + (number as f64 + 0.4 * (random.uniform() - 0.5)) / sides);
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
            between(left * width, right * width, random.uniform()),
            between(0.0, height, random.uniform()),
        ];
        let steepest = TAU * random.uniform();
        let tilt = [TILT * steepest.cos(), TILT * steepest.sin()];
        self.positions.extend(around.iter().map(|[x, y]| {
            let pixel = [middle[0] + radius * x, middle[1] + radius * y];
            lens.point(pixel, 1.0 / (rev_depth * (1.0 + tilt[0] * x + tilt[1] * y)))
        }));
    }

    /// Adds a triangle with one corner in front of the near plane. Clipping leaves a quad with two corners on the
    /// plane: on the screen about a parallelogram if the other two corners are twice as far away as the near plane.
    fn add_near(&mut self, lens: &Lens, random: &mut RandomNumbers, pixels: f64) {
        let ahead = lens.near * (1.5 + random.uniform());
        let turn = TAU * random.uniform();
        let side = pixels.sqrt();
        let [along, across] = [[turn.cos(), turn.sin()], [turn.sin(), -turn.cos()]];
        let [width, height] = lens.size.map(f64::from);
        let first = [
            2.0 * side + (STRIP * width - 4.0 * side) * random.uniform(),
            2.0 * side + (height - 4.0 * side) * random.uniform(),
        ];
        let moved = |from: [f64; 2], by: [f64; 2]| [from[0] + side * by[0], from[1] + side * by[1]];
        let a = lens.point(first, ahead);
        let b = lens.point(moved(first, along), ahead);
        // The first corner, mirrored at this point of the near plane.
        let on_plane = lens.point(moved(first, across), lens.near);
        let behind = [0, 1, 2].map(|axis| 2.0 * on_plane[axis] - a[axis]);
        self.positions.extend([a, b, behind]);
    }
}

/// Returns the reversed depth of a face by its number, the farthest first.
fn rev_depth_of(number: usize, count: usize) -> f64 {
    (FAR / NEAR).powf(number as f64 / count as f64) / FAR
}

/// A random number generator with a fixed sequence per seed.
///
/// Source: Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators, OOPSLA 2014 (SplitMix64).
pub(super) struct RandomNumbers(pub(super) u64);

impl RandomNumbers {
    /// Returns a random number in [0, 1).
    pub(super) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
