//! Shared test support for occlusion trees: shapes in eye space, and random numbers.

mod odd;
mod oracle;
mod walls;

use super::*;
use crate::view::region::Volume;

/// A screen of 1000 × 800 pixels.
const SCREEN: [[f64; 2]; 4] = [[0.0, 0.0], [0.0, 800.0], [1000.0, 800.0], [1000.0, 0.0]];
const NEAR: f64 = 1e-12;

/// Returns (X, Y, W) of a point given as distances right of, above and ahead of the eye.
fn on_screen([right, up, ahead]: [f64; 3]) -> DVec3 {
    let focal = 700.0;
    DVec3::new(focal * right + 500.0 * ahead, -focal * up + 400.0 * ahead, ahead)
}

/// A convex polygon in the space of (X, Y, W).
#[derive(Clone, Debug)]
struct Polygon {
    corners: Vec<DVec3>,
    plane: (DVec3, f64),
}

impl Polygon {
    /// Accepts either winding; `None` if the eye is in the plane.
    fn new(corners: &[[f64; 3]]) -> Option<Polygon> {
        let mut corners: Vec<DVec3> = corners.iter().map(|&c| on_screen(c)).collect();
        let first = corners[0];
        let normal: DVec3 = corners[1..]
            .windows(2)
            .map(|pair| (pair[0] - first).cross(pair[1] - first))
            .sum::<DVec3>()
            .normalize();
        let distance = normal.dot(first);
        if distance.abs() < 1e-13 * first.length() {
            return None;
        }
        // In this space y points down: a polygon that is counter-clockwise from the eye has its normal toward the eye.
        if distance > 0.0 {
            corners.reverse();
        }
        let plane = if distance > 0.0 {
            (normal, distance)
        } else {
            (-normal, -distance)
        };
        Some(Polygon { corners, plane })
    }

    fn occluder(&self) -> Occluder<'_> {
        Occluder {
            corners: &self.corners,
            plane: self.plane,
        }
    }

    /// Returns `true` if it hides a point. `slack`: distance outside its edges that still counts as inside, in pixels.
    fn hides(&self, point: DVec3, slack: f64) -> bool {
        let (normal, distance) = self.plane;
        let beyond = normal.dot(point) > distance * (1.0 - slack * 1e-6);
        let inside = |(i, &from): (usize, &DVec3)| {
            let line = self.corners[(i + 1) % self.corners.len()].cross(from);
            line.dot(point) / line.x.hypot(line.y) > -slack * point.z
        };
        beyond && self.corners.iter().enumerate().all(inside)
    }
}

fn square(center: [f64; 3], half: f64) -> Polygon {
    let [x, y, z] = center;
    let corners =
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[a, b]| [x + a * half, y + b * half, z]);
    Polygon::new(&corners).expect("the eye is not in its plane")
}

/// A box aligned with the eye's axes.
fn volume(min: [f64; 3], max: [f64; 3]) -> Volume {
    let side = |axis: usize| {
        let mut to = min;
        to[axis] = max[axis];
        on_screen(to) - on_screen(min)
    };
    Volume {
        origin: on_screen(min),
        sides: [side(0), side(1), side(2)],
        is_parallel: false,
    }
}

/// Both kinds of tree with the same occluders.
#[derive(Default)]
struct Both {
    faces: OcclusionTree<ByFaces>,
    boxes: OcclusionTree<ByBox>,
}

impl Both {
    fn new(occluders: &[Polygon]) -> Both {
        let mut both = Both::default();
        both.fill(&SCREEN, occluders);
        both
    }

    /// Clears the trees and inserts occluders; `outline` is counter-clockwise on the screen.
    fn fill(&mut self, outline: &[[f64; 2]], occluders: &[Polygon]) {
        self.faces.tree.open(outline, &Rect::default());
        self.boxes.tree.open(outline, &Rect::default());
        for polygon in occluders {
            self.hide(&polygon.occluder(), NEAR, None);
        }
    }

    fn hide(&mut self, occluder: &Occluder, near: f64, entry: Option<(DVec3, f64)>) {
        self.faces.insert(occluder, near, entry, 0.0);
        self.boxes.insert(occluder, near, entry, 0.0);
    }

    fn see(&mut self, volume: &Volume) -> [Visibility; 2] {
        let by_box = self.boxes.box_visibility(volume);
        let by_faces = match (self.faces.is_any_face_visible(volume), by_box) {
            (false, _) => Visibility::Hidden,
            (true, Visibility::Hidden) => Visibility::Partial,
            (true, sight) => sight,
        };
        [by_faces, by_box]
    }
}

/// Deterministic pseudo-random numbers.
struct Chance(u64);

impl Chance {
    /// Returns a number from `low` to `high`.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        (self.between(0.0, count as f64) as usize).min(count - 1)
    }

    fn point(&mut self, spread: f64, ahead: [f64; 2]) -> [f64; 3] {
        let z = self.between(ahead[0], ahead[1]);
        [
            self.between(-spread, spread) * z,
            self.between(-spread, spread) * z,
            z,
        ]
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::from([(); 3].map(|()| self.between(-1.0, 1.0)));
            if (0.01..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }

    /// Returns a convex polygon at a random position and slope.
    fn polygon(&mut self, ahead: [f64; 2], size: [f64; 2]) -> Option<Polygon> {
        let center = DVec3::from(self.point(0.8, ahead));
        let along = self.direction();
        let up = along.cross(self.direction()).normalize_or_zero();
        let half = center.z * self.between(size[0], size[1]);
        let mut angles: Vec<f64> = (0..3 + self.below(4))
            .map(|_| self.between(0.0, std::f64::consts::TAU))
            .collect();
        angles.sort_by(f64::total_cmp);
        let corners: Vec<[f64; 3]> = angles
            .iter()
            .map(|angle| (center + half * (along * angle.cos() + up * angle.sin())).into())
            .collect();
        Polygon::new(&corners)
    }

    fn volume(&mut self, ahead: [f64; 2]) -> Volume {
        let center = DVec3::from(self.point(0.8, ahead));
        let size = center.z * self.between(0.001, 0.3);
        let half = DVec3::from([(); 3].map(|()| size * self.between(0.0, 1.0)));
        volume((center - half).into(), (center + half).into())
    }

    /// Returns the corners of a box and random points on its faces.
    fn places(&mut self, of: &Volume) -> Vec<DVec3> {
        let mut places: Vec<[f64; 3]> = (0..8_u32)
            .map(|corner| [0, 1, 2].map(|axis| f64::from(corner >> axis & 1)))
            .collect();
        for _ in 0..40 {
            let mut place = [(); 3].map(|()| self.between(0.0, 1.0));
            place[self.below(3)] = self.below(2) as f64;
            places.push(place);
        }
        places
            .into_iter()
            .map(|[a, b, c]| of.origin + of.sides[0] * a + of.sides[1] * b + of.sides[2] * c)
            .collect()
    }
}

/// Returns `true` if a point is in front of the near plane and on the screen.
fn in_view(point: &DVec3) -> bool {
    let [x, y] = [point.x / point.z, point.y / point.z];
    point.z > NEAR && (0.0..1000.0).contains(&x) && (0.0..800.0).contains(&y)
}

fn shuffled<T: Clone>(all: &[T], chance: &mut Chance) -> Vec<T> {
    let mut all = all.to_vec();
    for i in (1..all.len()).rev() {
        all.swap(i, chance.below(i + 1));
    }
    all
}

/// Returns the SIMD levels of this machine, without the intermediate ones.
pub(super) fn levels() -> Vec<Level> {
    let mut levels = vec![Level::baseline(), Level::new()];
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(Level::new().as_sse4_2().map(Level::Sse4_2));
        levels.extend(Level::new().as_avx2().map(Level::Avx2));
    }
    levels
}

/// Returns a generator of random numbers: ordinary ones, small integers (for planes through corners), infinities and
/// NaN.
pub(super) fn odd_numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        match state % 251 {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            3..12 => 0.0,
            12 => f64::MAX,
            13 => f64::MIN_POSITIVE,
            14..100 => (state >> 32) as f64 % 8.0 - 4.0,
            _ => (state >> 11) as f64 / (1_u64 << 40) as f64 - 4096.0,
        }
    }
}
