//! Portals: the targets of openings.

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
    /// Returns `true` if the transform is invertible and maps `opening`, the one of this portal, within
    /// [`MAX_COORDINATE`](crate::MAX_COORDINATE).
    pub(super) fn leads_in_range(&self, opening: &Opening) -> bool {
        let corners = opening.outline.corners().iter();
        self.there_from_here.inverse().is_some()
            && corners
                .flat_map(|&corner| self.there_from_here.point(corner))
                .all(is_in_range)
    }
}
