//! Line of sight between two locations, through portals.

use super::beam::LightReach;
use super::location::Location;
use super::ray::{RayCast, RayEnd};
use crate::ids::PortalId;
use crate::scene::Scene;
use crate::sector::Ray;
use crate::view::options::Limits;

/// Unobstructed straight line between two locations, from [`Scene::sees`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SightLine {
    /// Vector from the first location to the apparent position of the second, in the space of the first.
    pub direction: [f32; 3],
    /// The portals that the line crosses, in order.
    pub crossed: Vec<PortalId>,
}

impl Scene {
    /// Tests the line of sight between two locations, straight or through open portals.
    ///
    /// Returns the first unobstructed line found, by the fewest portals. `None` if there is none within the default
    /// [`Limits`], or if a position is not finite. All faces are obstacles, alpha-blended ones too.
    ///
    /// Cost: one ray per beam that reaches the sector of the second location ([`Scene::reach`]).
    #[doc(alias = "line of sight")]
    #[doc(alias = "LOS")]
    #[doc(alias = "visibility test")]
    pub fn sees(&self, from: Location, to: Location) -> Option<SightLine> {
        if !from
            .position
            .iter()
            .chain(&to.position)
            .all(|value| value.is_finite())
        {
            return None;
        }
        let reached = self.reach(from, f32::INFINITY, &Limits::default());
        let reaches = |beam: &&LightReach| beam.sector == to.sector && beam.holds(to.position.map(f64::from));
        let mut beams = reached.iter().filter(reaches);
        beams.find_map(|beam| self.line_through(from, to, beam, &reached))
    }

    fn line_through(
        &self,
        from: Location,
        to: Location,
        beam: &LightReach,
        all: &[LightReach],
    ) -> Option<SightLine> {
        // Fraction of the line that must be unobstructed; the rest is tolerance for rounding.
        const THERE: f64 = 1.0 - 1e-5;
        let up = |beam: &&LightReach| beam.parent.map(|parent| &all[parent as usize]);
        let chain = std::iter::successors(Some(beam), up);
        let mut crossed: Vec<PortalId> = chain.filter_map(|beam| beam.portal).collect();
        crossed.reverse();
        let image = beam.there_from_here.inverse()?.point_f64(to.position);
        let direction = std::array::from_fn(|axis| (image[axis] - f64::from(from.position[axis])) as f32);
        let ray = Ray {
            origin: from.position,
            direction,
        };
        let RayCast {
            end,
            distance,
            crossed: followed,
            ..
        } = self.cast_until(from.sector, &ray, THERE);
        let arrives = direction == [0.0; 3] || end == RayEnd::Nothing || distance >= THERE;
        (arrives && followed.starts_with(&crossed)).then_some(SightLine { direction, crossed })
    }
}
