//! Rays through a pixel.

use super::DELTA_PX;
use super::bundle::Bundle;
use crate::random::SplitMix;
use crate::scene::Scene;
use crate::view::View;
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

/// Rays per sample: one through the centre and four around it.
pub(super) const RAYS: usize = 5;

/// Random positions of a pixel that are traced as one bundle.
pub(super) const POSITIONS: usize = 16;

/// Returns the random numbers of pixel (x, y).
pub(super) fn of_pixel(seed: u64, [x, y]: [u32; 2]) -> SplitMix {
    SplitMix(seed ^ u64::from(x) << 40 ^ u64::from(y) << 20)
}

/// Computes rays from the matrices of a view, independently of the methods.
pub(super) struct Lens {
    eye: DVec3,
    kind: Kind,
    size: [f64; 2],
    sample: [f64; 2],
    /// Ray parameter of the near plane, if it is not oblique.
    pub(super) near: f64,
    /// Oblique near plane: only what is on the side of a positive (x, y, z, 1) · plane is visible.
    pub(super) oblique: Option<DVec4>,
}

enum Kind {
    /// From (x, y, w) of clip space, without translations, to sector space. The distance along the view direction of a
    /// direction vector is its dot product with `forward`.
    Perspective { sector_from_clip: DMat3, forward: DVec3 },
    /// From (x, y, 0) of clip space, relative to the middle of the viewport, to the near plane, relative to the eye.
    Parallel {
        sector_from_clip: DMat3,
        direction: DVec3,
    },
}

impl Lens {
    pub(super) fn new(scene: &Scene, view: &View) -> Lens {
        let clip_from_eye = DMat4::from_cols_array_2d(&view.clip_from_eye());
        let eye = DVec3::from(view.eye());
        // No translation: rays start at the eye, and a translation would lose precision far from the origin.
        let eye_from_sector = view.eye_from_sector().0.matrix3;
        let rows = |numbers: [usize; 3]| {
            let [a, b, c] = numbers.map(|row| clip_from_eye.row(row).truncate());
            DMat3::from_cols(a, b, c).transpose() * eye_from_sector
        };
        let w = clip_from_eye.row(3);
        let lens = Lens {
            eye,
            kind: Kind::Perspective {
                sector_from_clip: rows([0, 1, 3]).inverse(),
                forward: eye_from_sector.transpose() * w.truncate().normalize(),
            },
            size: view.size().map(f64::from),
            sample: (DVec2::from(view.sample().map(f64::from)) + DVec2::from(View::GENERIC_OFFSET)).into(),
            near: f64::from(view.z_near()),
            oblique: view.near_plane().map(DVec4::from),
        };
        if !view.is_parallel() {
            return lens;
        }
        // z is constant in the near plane, and the direction is what changes neither x nor y.
        let sector_from_clip = rows([0, 1, 2]).inverse() * w.w;
        let ahead = sector_from_clip * DVec3::Z;
        let ahead = ahead / (eye_from_sector * ahead).length();
        let direction = ahead * ahead.dot(DVec3::from(view.toward()) - eye).signum();
        // Rays start so far before the near plane that depths that differ by rounding, of all the scene, are equal to the
        // tolerance of the reference, which is a part of the distance.
        let far = scene.sectors().map(|sector| {
            let bounds = scene.bounds(sector);
            let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
            (max - min).max(DVec3::ZERO).length() + (eye.clamp(min.min(max), max) - eye).length()
        });
        let near = far.filter(|far| far.is_finite()).fold(1e-6, f64::max) / direction.length();
        Lens {
            eye: eye - near * direction,
            kind: Kind::Parallel {
                sector_from_clip,
                direction,
            },
            near,
            ..lens
        }
    }

    /// Returns the rays through the centre of pixel (x, y) and around it.
    pub(super) fn about_centre(&self, [x, y]: [u32; 2]) -> Bundle<RAYS> {
        let [x, y] = [x, y].map(|place| f64::from(place) + 0.5);
        let places = [[0.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
        self.through(places.map(|[dx, dy]| [x + dx * DELTA_PX, y + dy * DELTA_PX]))
    }

    /// Returns rays through the next `used` random positions in pixel (x, y). The remaining rays are copies of the
    /// first.
    pub(super) fn anywhere(&self, [x, y]: [u32; 2], used: usize, chance: &mut SplitMix) -> Bundle<POSITIONS> {
        let mut place = || {
            let [dx, dy] = [(); 2].map(|()| chance.fraction());
            [f64::from(x) + dx, f64::from(y) + dy]
        };
        let mut places = [place(); POSITIONS];
        places[1..used].fill_with(place);
        self.through(places)
    }

    /// Returns the rays through screen positions, in pixels, y down. The component of their directions along the view
    /// direction is 1.
    fn through<const N: usize>(&self, places: [[f64; 2]; N]) -> Bundle<N> {
        let clip = places.map(|[x, y]| {
            let [x, y] = [x + self.sample[0], y + self.sample[1]];
            [2.0 * x / self.size[0] - 1.0, 1.0 - 2.0 * y / self.size[1]]
        });
        match &self.kind {
            Kind::Perspective {
                sector_from_clip,
                forward,
            } => Bundle {
                origin: self.eye,
                directions: clip.map(|[x, y]| {
                    let direction = *sector_from_clip * DVec3::new(x, y, 1.0);
                    direction / direction.dot(*forward)
                }),
                offsets: None,
            },
            Kind::Parallel {
                sector_from_clip,
                direction,
            } => {
                let starts = clip.map(|[x, y]| *sector_from_clip * DVec3::new(x, y, 0.0));
                Bundle {
                    origin: self.eye + starts[0],
                    directions: [*direction; N],
                    offsets: Some(starts.map(|start| start - starts[0])),
                }
            }
        }
    }
}
