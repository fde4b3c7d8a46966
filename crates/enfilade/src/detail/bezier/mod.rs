//! Surfaces of Bézier patches, tessellated as finely as they are wanted, without cracks between neighbours.
//!
//! A level is a tolerance; how many steps a patch takes along u and v follows from it (`steps`), and an edge takes as many
//! as the patch along it that takes most (`weave`).
//! Source: Filip, Magedson, Markot. Surface algorithms using bounds on derivatives. CAGD 1986.
//! Cost: O(triangles made); a surface keeps its control points only.
//! A level without error is made of what is flat as it stands: no other hides.

mod steps;
mod weave;

use super::DetailSource;
use crate::geom::Aabb;
use crate::geometry::MaterialId;
use crate::mesh::Mesh;
use glam::DVec3;
use std::error::Error;
use std::sync::Arc;
use steps::{Bend, MAX_STEPS};
use thiserror::Error as ThisError;
use weave::weave;

/// Sixteen control points of a bicubic patch, row after row: a row runs along u, rows follow each other along v. Its front is
/// the side from which u turns to v counter-clockwise.
pub type BezierPatch = [[f32; 3]; 16];

/// A surface of bicubic Bézier patches: a [`DetailSource`] whose levels halve the error each.
///
/// Patches that share an edge must have the same four control points there; then there is no crack between them.
#[derive(Clone, Debug)]
pub struct BezierSurface {
    patches: Vec<BezierPatch>,
    material: MaterialId,
    bounds: Aabb,
    /// How far the corners of each level may be off, in f64 and before they are rounded.
    tolerances: Vec<f64>,
    /// How far the finest steps may be off, and how much rounding adds.
    left: [f64; 2],
}

/// Why patches do not make a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ThisError)]
#[non_exhaustive]
pub enum BezierError {
    /// There is none.
    #[error("a surface needs at least one patch")]
    NoPatches,
    /// A control point is NaN or infinite.
    #[error("control point {point} of patch {patch} is not finite")]
    NotFinite {
        /// Which patch, counted from 0.
        patch: usize,
        /// Which point of it, counted from 0.
        point: usize,
    },
}

/// Levels of a surface, at most.
const MAX_LEVELS: i32 = 14;

impl BezierSurface {
    /// Checks the patches.
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
        // −0 becomes 0: edges are known by the bits of their points.
        let patches: Vec<BezierPatch> = patches
            .iter()
            .map(|points| points.map(|p| p.map(|value| value + 0.0)))
            .collect();
        let bends = || patches.iter().map(Bend::of);
        // A patch lies within its control points' hull.
        let bounds = Aabb::of(patches.iter().flatten().copied());
        let size = DVec3::from(bounds.max.map(f64::from)).distance(DVec3::from(bounds.min.map(f64::from)));
        let finest = bends().map(|bend| bend.error([MAX_STEPS; 2])).fold(0.0, f64::max);
        let farthest = patches.iter().flatten().flatten().map(|value| value.abs());
        // Half of a last bit on each axis; corners of what does not bend are control points, and not rounded.
        let rounding = match bends().all(|bend| bend.is_none()) {
            true => 0.0,
            false => 1.01 * 3_f64.sqrt() * 0.5_f64.powi(24) * f64::from(farthest.fold(0.0, f32::max)),
        };
        let mut tolerances: Vec<f64> = (0..MAX_LEVELS)
            .map(|level| 0.125 * size * 0.5_f64.powi(level))
            .collect();
        // Finer than the finest steps are, or than rounding leaves them, would be no better.
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
