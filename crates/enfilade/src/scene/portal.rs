//! Where openings lead.

use crate::geom::{Transform, is_in_range};
use crate::geometry::{Opening, OpeningId};

/// A sector of a scene, by its place in [`Scene::sectors`](crate::Scene::sectors).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SectorId(pub u32);

/// A portal of a scene, by its place in [`Scene::portals`](crate::Scene::portals).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PortalId(pub u32);

/// One way through an opening. A door is two of these; a mirror is one, back into its own sector.
#[derive(Clone, Debug, PartialEq)]
pub struct Portal {
    /// The sector one looks out of.
    pub from: SectorId,
    /// The opening of that sector.
    pub opening: OpeningId,
    /// The sector one looks into.
    pub to: SectorId,
    /// From the space of `from` to the space of `to`: rigid, uniformly scaling or reflecting.
    pub there_from_here: Transform,
    /// A closed portal is an opaque face.
    pub open: bool,
}

impl Portal {
    /// Whether what is seen through `opening`, the portal's own, is at coordinates that are allowed, and can be mapped back.
    pub(super) fn leads_in_range(&self, opening: &Opening) -> bool {
        let corners = opening.outline.corners().iter();
        self.there_from_here.inverse().is_some()
            && corners
                .flat_map(|&corner| self.there_from_here.point(corner))
                .all(is_in_range)
    }
}
