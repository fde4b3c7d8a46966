//! The rays that go through a pixel.

use super::DELTA_PX;
use super::bundle::Bundle;
use crate::view::View;
use glam::DVec3;

/// Rays through a sample: through its centre, and through the four places about it.
pub(super) const RAYS: usize = 5;

/// Places in a pixel that are looked through together.
pub(super) const PLACES: usize = 16;

/// Numbers by chance, the same for the same seed. Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators,
/// 2014.
pub(super) struct Chance(u64);

impl Chance {
    /// For pixel (x, y).
    pub(super) fn new(seed: u64, [x, y]: [u32; 2]) -> Chance {
        Chance(seed ^ u64::from(x) << 40 ^ u64::from(y) << 20)
    }

    /// From 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ mixed >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Directions of rays, computed from the view as its docs state it, not as the methods do.
pub(super) struct Lens {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    focal: f64,
    middle: [f64; 2],
}

impl Lens {
    pub(super) fn new(view: &View) -> Lens {
        let [eye, toward, up] = [view.eye, view.toward, view.up].map(|v| DVec3::from(v.map(f64::from)));
        let forward = (toward - eye).normalize();
        let upright = [up, DVec3::Z, DVec3::X]
            .into_iter()
            .map(|up| forward.cross(up.normalize_or_zero()));
        let right = upright
            .into_iter()
            .find(|r| r.length_squared() > 1e-16)
            .unwrap_or(DVec3::X)
            .normalize();
        let [width, height] = view.size.map(f64::from);
        let half_tangent = f64::from((0.5 * f64::from(view.fov_y)).tan() as f32);
        Lens {
            eye,
            forward,
            right,
            up: right.cross(forward),
            focal: 0.5 * height / half_tangent,
            middle: [
                0.5 * width - f64::from(view.sample[0]),
                0.5 * height - f64::from(view.sample[1]),
            ],
        }
    }

    /// The rays through the centre of pixel (x, y), and about it.
    pub(super) fn about_centre(&self, [x, y]: [u32; 2]) -> Bundle<RAYS> {
        let [x, y] = [x, y].map(|place| f64::from(place) + 0.5);
        let places = [[0.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
        Bundle {
            origin: self.eye,
            directions: places.map(|[dx, dy]| self.direction(x + dx * DELTA_PX, y + dy * DELTA_PX)),
        }
    }

    /// Rays through the next `used` places in pixel (x, y); the others are spare, and as the first.
    pub(super) fn anywhere(&self, [x, y]: [u32; 2], used: usize, chance: &mut Chance) -> Bundle<PLACES> {
        let mut place = || {
            let [dx, dy] = [(); 2].map(|()| chance.next());
            self.direction(f64::from(x) + dx, f64::from(y) + dy)
        };
        let mut directions = [place(); PLACES];
        directions[1..used].fill_with(place);
        Bundle {
            origin: self.eye,
            directions,
        }
    }

    fn direction(&self, x: f64, y: f64) -> DVec3 {
        let [right, down] = [
            (x - self.middle[0]) / self.focal,
            (y - self.middle[1]) / self.focal,
        ];
        self.forward + self.right * right - self.up * down
    }
}
