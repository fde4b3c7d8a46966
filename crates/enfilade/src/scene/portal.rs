//! Portals: the targets of openings.

use super::SceneError;
use crate::geom::{Transform, is_in_range};
use crate::geometry::Opening;
use crate::ids::{OpeningId, SectorId};

/// One-way link from an opening of a sector into a sector, with a transform between their spaces.
///
/// A door is two portals, one each way. A mirror is one that leads back into its own sector.
#[doc(alias = "portal link")]
#[doc(alias = "doorway")]
#[doc(alias = "gateway")]
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Portal {
    /// The source sector.
    pub from: SectorId,
    /// The opening of the source sector.
    pub opening: OpeningId,
    /// The target sector.
    pub to: SectorId,
    /// Maps the space of `from` to the space of `to`: rigid, uniformly scaling or reflecting.
    pub there_from_here: Transform,
    /// Whether the portal is followed. A closed portal is an opaque face.
    pub open: bool,
}

impl Portal {
    /// Checks the transform: that it is a similarity, can be inverted, and maps the opening of this portal, one of
    /// `openings`, within [`MAX_COORDINATE`](crate::MAX_COORDINATE). `number` names the portal in the error.
    pub(super) fn check(&self, number: usize, openings: &[Opening]) -> Result<(), SceneError> {
        if !self.there_from_here.is_similarity() {
            return Err(SceneError::NotSimilar(number));
        }
        let mut corners = openings[usize::from(self.opening.0)].outline.corners().iter();
        let is_in_range =
            |&corner: &[f32; 3]| self.there_from_here.point(corner).into_iter().all(is_in_range);
        if self.there_from_here.inverse().is_none() || !corners.all(is_in_range) {
            return Err(SceneError::TooFar(number));
        }
        Ok(())
    }
}
