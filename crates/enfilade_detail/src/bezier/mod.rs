//! Adaptive, crack-free tessellation of Bézier patches.
//!
//! Each level has a tolerance. It determines the number of steps along u and v in each patch (`steps`); an edge takes
//! the larger step count of its two patches (`weave`).
//! Source: Filip, Magedson, Markot. Surface algorithms using bounds on derivatives. CAGD 1986.
//! Cost: O(triangles made); a surface stores only its control points.
//! Only levels of flat, evenly parametrized patches are exact, so only these are occluders.

mod steps;
mod weave;

use crate::DetailSource;
use enfilade::{Aabb, MaterialId, Mesh};
use glam::DVec3;
use std::error::Error;
use std::sync::Arc;
use steps::{Bend, MAX_STEPS};
use thiserror::Error as ThisError;
use weave::weave;

/// The sixteen control points of a bicubic patch, row by row: u runs along a row, v from row to row. Its front is the
/// side from which the turn from u to v is counter-clockwise.
pub type BezierPatch = [[f32; 3]; 16];

/// A surface of bicubic Bézier patches: a [`DetailSource`] in which each level has half the error of the one before.
///
/// Patches that share an edge must have the same four control points there; then there is no crack between them.
#[derive(Clone, Debug)]
pub struct BezierSurface {
    patches: Vec<BezierPatch>,
    material: MaterialId,
    bounds: Aabb,
    /// Maximum geometric error of each level, in f64 and before rounding.
    tolerances: Vec<f64>,
    /// Error at the maximum step count, and additional rounding error.
    left: [f64; 2],
}

/// Why patches cannot form a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ThisError)]
#[non_exhaustive]
pub enum BezierError {
    /// The list of patches is empty.
    #[error("a surface needs at least one patch")]
    NoPatches,
    /// A control point is NaN or infinite.
    #[error("control point {point} of patch {patch} is not finite")]
    NotFinite {
        /// Index of the patch.
        patch: usize,
        /// Index of the control point in the patch.
        point: usize,
    },
}

/// Maximum number of levels.
const MAX_LEVELS: i32 = 14;

impl BezierSurface {
    /// Creates a surface from its patches.
    ///
    /// # Errors
    /// One [`BezierError`] for the first broken rule.
    pub fn new(patches: &[BezierPatch], material: MaterialId) -> Result<BezierSurface, BezierError> {
        if patches.is_empty() {
            return Err(BezierError::NoPatches);
        }
        for (patch, points) in patches.iter().enumerate() {
            let mut all = points.iter();
            if let Some(point) = all.position(|p| p.iter().any(|value| !value.is_finite())) {
                return Err(BezierError::NotFinite { patch, point });
            }
        }
        // −0 becomes 0, as shared edges are found by the bits of their points.
        let patches: Vec<BezierPatch> = patches
            .iter()
            .map(|points| points.map(|p| p.map(|value| value + 0.0)))
            .collect();
        let bends = || patches.iter().map(Bend::of);
        // A patch is within the convex hull of its control points.
        let bounds = Aabb::of(patches.iter().flatten().copied());
        let size = DVec3::from(bounds.max.map(f64::from)).distance(DVec3::from(bounds.min.map(f64::from)));
        let finest = bends().map(|bend| bend.error([MAX_STEPS; 2])).fold(0.0, f64::max);
        let farthest = patches.iter().flatten().flatten().map(|value| value.abs());
        // Half an ulp on each axis. Without curvature all vertices are control points, which need no rounding.
        let rounding = match bends().all(|bend| bend.is_none()) {
            true => 0.0,
            false => 1.01 * 3_f64.sqrt() * 0.5_f64.powi(24) * f64::from(farthest.fold(0.0, f32::max)),
        };
        let mut tolerances: Vec<f64> = (0..MAX_LEVELS)
            .map(|level| 0.125 * size * 0.5_f64.powi(level))
            .collect();
        // Drops levels finer than the maximum step count or f32 rounding can deliver.
        let enough = tolerances
            .iter()
            .position(|&tolerance| rounding == 0.0 || tolerance <= finest.max(rounding));
        tolerances.truncate(enough.map_or(tolerances.len(), |last| last + 1));
        Ok(BezierSurface {
            patches,
            material,
            bounds,
            tolerances,
            left: [finest, rounding],
        })
    }

    fn tolerance(&self, level: u32) -> f64 {
        self.tolerances[(level as usize).min(self.tolerances.len() - 1)]
    }
}

impl DetailSource for BezierSurface {
    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn material(&self) -> MaterialId {
        self.material
    }

    fn levels(&self) -> u32 {
        self.tolerances.len() as u32
    }

    fn error(&self, level: u32) -> f32 {
        let [finest, rounding] = self.left;
        if rounding == 0.0 {
            return 0.0;
        }
        let error = self.tolerance(level).max(finest) + rounding;
        (error as f32).next_up()
    }

    fn build(&self, level: u32) -> Result<Arc<Mesh>, Box<dyn Error + Send + Sync>> {
        let (positions, corners) = weave(&self.patches, self.tolerance(level))?;
        Ok(Arc::new(Mesh::triangles(&positions, &corners, self.material)?))
    }
}

#[cfg(test)]
mod tests;
