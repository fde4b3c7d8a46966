//! Whether one place sees another.

use super::beam::LightReach;
use super::place::Location;
use super::ray::{RayCast, RayEnd};
use crate::scene::{PortalId, Scene};
use crate::sector::Ray;
use crate::viewer::Limits;

/// A straight line from one place to another that nothing stops.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SightLine {
    /// From the first place to where the other appears from it, in the space of the first.
    pub direction: [f32; 3],
    /// The portals that it goes through, in order.
    pub crossed: Vec<PortalId>,
}

impl Scene {
    /// Does one place see another, straight or through open portals? Gives the first line that is found, by the fewest
    /// portals; `None` where no line is, or none within the default [`Limits`], or a position is not finite. Faces of glass stop it as others do.
    ///
    /// Cost: O(beams that reach the other's sector) rays.
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
        // Where a line ends before the other place, by rounding, it ends there.
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
