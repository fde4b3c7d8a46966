//! The map from a local space to the screen, for perspective and parallel views alike.
//!
//! All covers compute with homogeneous points (X, Y, W): the pixel is (X / W, Y / W) and reversed depth is 1 / W, which is
//! linear on the screen. A perspective map gives X, Y and W, linear in the position. A parallel map gives the pixel and the
//! reversed depth, linear in the position, and so the point (x, y, 1) / rev_depth. Lines stay lines, planes stay planes,
//! and what is nearer has the smaller W, so everything behind this map is the same for both.
//! Source: Blinn, A Trip Down the Graphics Pipeline: Line Clipping, IEEE CG&A 1991, for the homogeneous view of both.

use crate::geom::Transform;
use fearless_simd::f64x8;
use fearless_simd::prelude::*;
use glam::{DAffine3, DVec3, DVec4};

/// A map from a local space to (X, Y, W).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenMap {
    /// To (X, Y, W), or, if parallel, to (column, row, reversed depth).
    pub(crate) linear: DAffine3,
    pub(crate) is_parallel: bool,
}

impl ScreenMap {
    pub(crate) const IDENTITY: ScreenMap = ScreenMap {
        linear: DAffine3::IDENTITY,
        is_parallel: false,
    };

    /// Returns the same map from the space of an item.
    #[inline(always)]
    pub(crate) fn from(&self, here_from_local: &Transform) -> ScreenMap {
        ScreenMap {
            linear: self.linear * here_from_local.0,
            ..*self
        }
    }

    /// Returns (X, Y, W) of a point.
    #[inline(always)]
    pub(crate) fn point(&self, at: DVec3) -> DVec3 {
        homogeneous(self.linear.transform_point3(at), self.is_parallel)
    }

    /// Returns the position from which the screen is seen. That of a parallel map is infinitely far away: a point so far in
    /// that direction that it is on the same side of every plane, except of those that are edge-on within rounding. The
    /// origin if the map is singular.
    pub(crate) fn eye(&self) -> DVec3 {
        let mut on_screen = -self.linear.translation;
        if self.is_parallel {
            on_screen.z += FAR_AWAY;
        }
        let eye = self.linear.matrix3.inverse() * on_screen;
        if eye.is_finite() { eye } else { DVec3::ZERO }
    }

    /// Returns the direction towards the viewer, against the view direction; not normalized.
    pub(crate) fn back(&self) -> DVec3 {
        if self.is_parallel {
            self.linear.matrix3.inverse() * DVec3::Z
        } else {
            -self.linear.matrix3.row(2)
        }
    }

    /// As [`ScreenMap::back`], per unit of reversed depth; `None` in perspective.
    pub(crate) fn parallel_back(&self) -> Option<DVec3> {
        self.is_parallel.then(|| self.back())
    }

    /// Transforms the half-space n · p ≥ d to n · (X, Y, W) ≥ d.
    pub(crate) fn half_space(&self, normal: DVec3, distance: f64) -> (DVec3, f64) {
        let normal = self.linear.matrix3.inverse().transpose() * normal;
        let distance = distance + normal.dot(self.linear.translation);
        if self.is_parallel {
            swapped(normal, distance)
        } else {
            (normal, distance)
        }
    }

    /// Transforms the half-space n · (X, Y, W) ≥ d to (p, 1) · result ≥ 0.
    pub(crate) fn half_space_here(&self, normal: DVec3, distance: f64) -> DVec4 {
        let (normal, distance) = if self.is_parallel {
            swapped(normal, distance)
        } else {
            (normal, distance)
        };
        let here = self.linear.matrix3.transpose() * normal;
        here.extend(normal.dot(self.linear.translation) - distance)
    }

    /// Whether the map mirrors what is seen: faces that are counter-clockwise in space turn clockwise on a screen with y
    /// down unless it does.
    pub(crate) fn is_mirrored(&self) -> bool {
        // Reversed depth grows towards the viewer, W away from it.
        (self.linear.matrix3.determinant() < 0.0) != self.is_parallel
    }
}

/// Reversed depth of a point that stands for the infinitely far eye of a parallel map, where what is visible has 0.5 to 1.
const FAR_AWAY: f64 = (1_u64 << 36) as f64;

/// Transforms the half-space n · (x, y, r) ≥ d of a parallel view to n · (X, Y, W) ≥ d, and back. (X, Y, W) is (x, y, 1) / r
/// with r above 0, so n.x x + n.y y + n.z r ≥ d is n.x X + n.y Y − d W ≥ −n.z.
#[inline(always)]
pub(crate) fn swapped(normal: DVec3, distance: f64) -> (DVec3, f64) {
    (DVec3::new(normal.x, normal.y, -distance), -normal.z)
}

/// Returns (X, Y, W) of a point mapped by [`ScreenMap::linear`].
#[inline(always)]
pub(crate) fn homogeneous(at: DVec3, is_parallel: bool) -> DVec3 {
    if is_parallel {
        let w = 1.0 / at.z;
        DVec3::new(at.x * w, at.y * w, w)
    } else {
        at
    }
}

/// As [`homogeneous`], for eight points.
#[inline(always)]
pub(crate) fn eight_homogeneous<S: Simd>(
    simd: S,
    [x, y, z]: [f64x8<S>; 3],
    is_parallel: bool,
) -> [f64x8<S>; 3] {
    if is_parallel {
        let w = f64x8::splat(simd, 1.0) / z;
        [x * w, y * w, w]
    } else {
        [x, y, z]
    }
}
