//! Rays through a pixel.

use super::DELTA_PX;
use super::bundle::Bundle;
use crate::random::SplitMix;
use crate::view::View;
use glam::{DMat3, DMat4, DVec2, DVec3};

/// Rays per sample: one through the centre and four around it.
pub(super) const RAYS: usize = 5;

/// Random positions of a pixel that are traced as one bundle.
pub(super) const POSITIONS: usize = 16;

/// Returns the random numbers of pixel (x, y).
pub(super) fn of_pixel(seed: u64, [x, y]: [u32; 2]) -> SplitMix {
    SplitMix(seed ^ u64::from(x) << 40 ^ u64::from(y) << 20)
}

/// Computes ray directions from the matrices of a view, independently of the methods.
pub(super) struct Lens {
    eye: DVec3,
    /// From (x, y, w) of clip space, without translations, to sector space.
    sector_from_clip: DMat3,
    /// The distance along the view direction of a direction vector is its dot product with this.
    forward: DVec3,
    size: [f64; 2],
    sample: [f64; 2],
}

impl Lens {
    pub(super) fn new(view: &View) -> Lens {
        let clip_from_eye = DMat4::from_cols_array_2d(&view.clip_from_eye());
        // No translation: rays start at the eye, and a translation would lose precision far from the origin.
        let eye_from_sector = view.eye_from_sector().0.matrix3;
        let [x, y, w] = [0, 1, 3].map(|row| clip_from_eye.row(row).truncate());
        let clip_from_sector = DMat3::from_cols(x, y, w).transpose() * eye_from_sector;
        Lens {
            eye: view.eye().into(),
            sector_from_clip: clip_from_sector.inverse(),
            forward: eye_from_sector.transpose() * w.normalize(),
            size: view.size().map(f64::from),
            sample: (DVec2::from(view.sample().map(f64::from)) + DVec2::from(View::GENERIC_OFFSET)).into(),
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
        let clip = DVec3::new(2.0 * x / self.size[0] - 1.0, 1.0 - 2.0 * y / self.size[1], 1.0);
        let direction = self.sector_from_clip * clip;
        direction / direction.dot(self.forward)
    }
}
