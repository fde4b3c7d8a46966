//! The projection on the GPU: that of the view, with reversed depth and the view's sample positions.

use enfilade::{Passage, Scene, Transform, View, VisibleSet};
use glam::{DMat3, DMat4, DVec3, DVec4};

/// The projection of a view, from eye space to clip space.
///
/// Depth is near / distance in perspective: 1 in the near plane, 0 infinitely far away, the same for all passages.
/// In a parallel view it falls linearly from 1 in the near plane to 0 at `far`.
pub(crate) struct Lens {
    pub(crate) clip_from_eye: DMat4,
    pub(crate) is_parallel: bool,
    /// Whether faces that are counter-clockwise in eye space are clockwise on the screen.
    pub(crate) mirrors: bool,
}

impl Lens {
    /// Returns the projection of a view. `visible` is the set of its look.
    pub(crate) fn new(scene: &Scene, view: &View, visible: &VisibleSet) -> Lens {
        let own = DMat4::from_cols_array_2d(&view.clip_from_eye());
        let [x, y, w] = [own.row(0), own.row(1), own.row(3)];
        let z = if view.is_parallel() {
            let distance = distance_from_near(view, &own);
            let passages = visible.passages().iter();
            let corners = passages.flat_map(|passage| {
                let eye_from_sector = matrix(&passage.eye_from_sector());
                let corners = scene.bounds(passage.sector).corners();
                corners.map(|corner| eye_from_sector * point(corner.map(f64::from)))
            });
            let farthest = corners
                .map(|at| distance.dot(at))
                .fold(f64::MIN_POSITIVE, f64::max);
            DVec4::W - distance / (2.0 * farthest)
        } else {
            DVec4::W * f64::from(view.z_near())
        };
        // The GPU's samples are at pixel centres, those of the view a little off.
        let off = |axis: usize| {
            let at = f64::from(view.sample()[axis]) + View::GENERIC_OFFSET[axis];
            2.0 * at / f64::from(view.size()[axis])
        };
        let (x, y) = (x - w * off(0), y + w * off(1));
        let is_parallel = view.is_parallel();
        let nearer = if is_parallel { z } else { -w };
        let linear = DMat3::from_cols(x.truncate(), y.truncate(), nearer.truncate());
        Lens {
            clip_from_eye: DMat4::from_cols(x, y, z, w).transpose(),
            is_parallel,
            mirrors: linear.determinant() < 0.0,
        }
    }

    /// Returns the map from the space of a passage's sector to clip space.
    pub(crate) fn clip_from_sector(&self, passage: &Passage) -> DMat4 {
        self.clip_from_eye * matrix(&passage.eye_from_sector())
    }
}

/// Returns the function of the position in eye space that is the distance from the near plane of a parallel view.
fn distance_from_near(view: &View, clip_from_eye: &DMat4) -> DVec4 {
    let [origin, direction] = view.ray([0.0, 0.0]).map(DVec3::from);
    let eye_from_sector = matrix(&view.eye_from_sector());
    let depth = clip_from_eye.row(2);
    let [near, next] = [origin, origin + direction].map(|at| depth.dot(eye_from_sector * point(at.into())));
    (depth - DVec4::W * near) / (next - near)
}

fn point([x, y, z]: [f64; 3]) -> DVec4 {
    DVec4::new(x, y, z, 1.0)
}

pub(crate) fn matrix(transform: &Transform) -> DMat4 {
    let [x, y, z, moved] = transform.columns_f64().map(DVec3::from);
    DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), moved.extend(1.0))
}
