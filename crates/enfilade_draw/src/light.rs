//! A sun, an ambient sky, and a little light from the eye, so that no corner of a closed room is flat.

use enfilade::Surface;
use glam::{DVec3, Vec3};

/// Towards the sun, in the space of the fragment at hand; nothing casts a shadow.
const SUN: Vec3 = Vec3::new(0.424, 0.755, 0.5);
const SUNLIGHT: Vec3 = Vec3::new(0.58, 0.53, 0.45);
const ZENITH: Vec3 = Vec3::new(0.36, 0.40, 0.48);
const GROUND: Vec3 = Vec3::new(0.20, 0.18, 0.16);
const FROM_THE_EYE: f32 = 0.22;

/// Where a passage's eye stands and looks from, in the space of the fragment.
#[derive(Clone, Copy, Default)]
pub(crate) struct Eye {
    pub(crate) at: DVec3,
    /// Against the line of sight, unit length.
    pub(crate) back: DVec3,
}

/// The light that a surface sends to an eye, linear.
///
/// It depends on the normal alone, not on the place, so that the triangles of a wall do not show.
pub(crate) fn lit(surface: &Surface, eye: &Eye) -> [f32; 3] {
    let normal = turned_to(eye, surface);
    let upward = 0.5 + 0.5 * normal.y;
    let ambient = GROUND * (1.0 - upward) + ZENITH * upward;
    let sun = SUNLIGHT * normal.dot(SUN).max(0.0);
    let [r, g, b, _] = surface.color;
    (Vec3::new(r, g, b) * (ambient + sun + FROM_THE_EYE * normal.dot(eye.back.as_vec3()).abs())).into()
}

/// The normal of the side that an eye sees: from behind, a double-sided face is lit on that side.
pub(crate) fn turned_to(eye: &Eye, surface: &Surface) -> Vec3 {
    let normal = Vec3::from(surface.normal);
    let behind = (eye.at - DVec3::from(surface.point.map(f64::from))).dot(normal.as_dvec3()) < 0.0;
    if behind { -normal } else { normal }
}

/// The sky in a direction whose y is up.
pub(crate) fn sky(direction: DVec3) -> [f32; 3] {
    let up = direction.normalize_or_zero().y as f32;
    let horizon = Vec3::new(0.78, 0.84, 0.90);
    let color = if up >= 0.0 {
        horizon.lerp(Vec3::new(0.18, 0.36, 0.68), up.sqrt())
    } else {
        horizon.lerp(Vec3::new(0.28, 0.27, 0.26), (-3.0 * up).min(1.0))
    };
    color.into()
}
