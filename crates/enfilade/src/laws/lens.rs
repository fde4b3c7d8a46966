//! Rays through a pixel.

use super::DELTA_PX;
use super::bundle::Bundle;
use crate::random::SplitMix;
use crate::view::View;
use glam::{DMat4, DVec2, DVec3, DVec4};

/// Rays per sample: one through the centre and four around it.
pub(super) const RAYS: usize = 5;

/// Random positions of a pixel that are traced as one bundle.
pub(super) const POSITIONS: usize = 16;

/// Returns the random numbers of pixel (x, y).
pub(super) fn of_pixel(seed: u64, [x, y]: [u32; 2]) -> SplitMix {
    SplitMix(seed ^ u64::from(x) << 40 ^ u64::from(y) << 20)
}

/// Computes ray directions from one 4×4 matrix, derived from the documentation of [`View`] alone.
pub(super) struct Lens {
    eye: DVec3,
    /// From clip space (x right, y up, −w to w; reversed depth, infinite far plane) to sector space.
    sector_from_clip: DMat4,
    forward: DVec3,
    size: [f64; 2],
    sample: [f64; 2],
}

impl Lens {
    pub(super) fn new(view: &View) -> Lens {
        let [eye, toward, up] = [view.eye, view.toward, view.up].map(|v| DVec3::from(v.map(f64::from)));
        let forward = (toward - eye).normalize();
        let is_usable = |up: &DVec3| forward.cross(up.normalize_or_zero()).length_squared() > 1e-16;
        let up = [up, DVec3::Z, DVec3::X]
            .into_iter()
            .find(is_usable)
            .unwrap_or(DVec3::Y);
        let [width, height] = view.size.map(f64::from);
        // Rounded to f32 as the contract demands: not all machines compute the same tangent in f64.
        let half_tangent = f64::from((0.5 * f64::from(view.fov_y)).tan() as f32);
        let clip_from_eye = DMat4::from_cols(
            DVec4::new(height / (width * half_tangent), 0.0, 0.0, 0.0),
            DVec4::new(0.0, 1.0 / half_tangent, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 0.0, -1.0),
            DVec4::new(0.0, 0.0, f64::from(view.near), 0.0),
        );
        // No translation: rays start at the eye, and a translation would lose precision far from the origin.
        let eye_from_sector =
            glam::dcamera::rh::view::look_to_mat4(DVec3::ZERO, forward, up.normalize_or_zero());
        Lens {
            eye,
            sector_from_clip: (clip_from_eye * eye_from_sector).inverse(),
            forward,
            size: [width, height],
            sample: (DVec2::from(view.sample.map(f64::from)) + DVec2::from(View::GENERIC_OFFSET)).into(),
        }
    }

    /// Returns the rays through the centre of pixel (x, y) and around it.
    pub(super) fn about_centre(&self, [x, y]: [u32; 2]) -> Bundle<RAYS> {
        let [x, y] = [x, y].map(|place| f64::from(place) + 0.5);
        let places = [[0.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
        Bundle {
            origin: self.eye,
            directions: places.map(|[dx, dy]| self.direction(x + dx * DELTA_PX, y + dy * DELTA_PX)),
        }
    }

    /// Returns rays through the next `used` random positions in pixel (x, y). The remaining rays are copies of the
    /// first.
    pub(super) fn anywhere(&self, [x, y]: [u32; 2], used: usize, chance: &mut SplitMix) -> Bundle<POSITIONS> {
        let mut place = || {
            let [dx, dy] = [(); 2].map(|()| chance.fraction());
            self.direction(f64::from(x) + dx, f64::from(y) + dy)
        };
        let mut directions = [place(); POSITIONS];
        directions[1..used].fill_with(place);
        Bundle {
            origin: self.eye,
            directions,
        }
    }

    /// Returns the direction through the screen position (x, y), in pixels, y down. Its component along the view
    /// direction is 1.
    fn direction(&self, x: f64, y: f64) -> DVec3 {
        let [x, y] = [x + self.sample[0], y + self.sample[1]];
        let clip = DVec4::new(
            2.0 * x / self.size[0] - 1.0,
            1.0 - 2.0 * y / self.size[1],
            0.0,
            1.0,
        );
        let direction = (self.sector_from_clip * clip).truncate();
        direction / direction.dot(self.forward)
    }
}
