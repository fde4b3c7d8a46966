//! Rays that follow portals.

use crate::geom::{Transform, is_in_range, pierced};
use crate::geometry::OpeningId;
use crate::scene::{PortalId, Scene, SectorId};
use crate::sector::{Hit, Ray};
use glam::DVec3;

/// Where a ray ends.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RayCast {
    /// In which sector.
    pub sector: SectorId,
    /// What stops it there.
    pub end: RayEnd,
    /// How far that is, over all portals, in lengths of the ray's direction.
    pub distance: f64,
    /// From the space that the ray begins in to that of `sector`.
    pub there_from_here: Transform,
    /// The portals that it went through, in order.
    pub crossed: Vec<PortalId>,
}

/// What stops a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum RayEnd {
    /// A face; its distance is counted from the last portal.
    Face(Hit),
    /// An opening, from its front, that is closed or leads nowhere.
    Closed(OpeningId),
    /// An opening that is not followed: it would be one more than [`RayCast::MAX_CROSSED`], or leads beyond
    /// [`MAX_COORDINATE`](crate::MAX_COORDINATE), or to where the ray's direction is too short or too long for 32-bit
    /// numbers, as portals that enlarge or shrink again and again do.
    Limit(OpeningId),
    /// Nothing, however far.
    Nothing,
}

impl RayCast {
    /// Portals that one ray goes through at most.
    pub const MAX_CROSSED: usize = 256;
}

impl Scene {
    /// Follows a ray through every open portal that it crosses, to the first thing that stops it.
    ///
    /// Cost: for each sector on the way that of its own [`Sector::cast`](crate::Sector::cast), and O(openings).
    pub fn cast(&self, from: SectorId, ray: &Ray) -> RayCast {
        self.cast_until(from, ray, f64::INFINITY)
    }

    /// As [`Scene::cast`], but follows no opening that is farther than `limit`.
    pub(super) fn cast_until(&self, from: SectorId, ray: &Ray, limit: f64) -> RayCast {
        let mut cast = RayCast {
            sector: from,
            end: RayEnd::Nothing,
            distance: 0.0,
            there_from_here: Transform::IDENTITY,
            crossed: Vec::new(),
        };
        let mut ray = *ray;
        loop {
            let hit = self.sector(cast.sector).cast(&ray);
            let opening = self.next_opening(cast.sector, &ray, cast.crossed.last().copied());
            let Some((opening, at)) = opening.filter(|&(_, at)| hit.is_none_or(|hit| at <= hit.distance))
            else {
                cast.end = hit.map_or(RayEnd::Nothing, RayEnd::Face);
                cast.distance += hit.map_or(f64::INFINITY, |hit| hit.distance);
                return cast;
            };
            cast.distance += at;
            let way = self.portal_of(cast.sector, opening);
            let Some(portal_id) = way.filter(|id| self.portals()[id.0 as usize].open) else {
                cast.end = RayEnd::Closed(opening);
                return cast;
            };
            if cast.crossed.len() == RayCast::MAX_CROSSED || cast.distance > limit {
                cast.end = RayEnd::Limit(opening);
                return cast;
            }
            let portal = &self.portals()[portal_id.0 as usize];
            let there = portal.there_from_here;
            let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
            let beyond = Ray {
                origin: there.0.transform_point3(origin + direction * at).as_vec3().into(),
                direction: there.direction(ray.direction),
            };
            if !is_followed(&beyond) {
                cast.end = RayEnd::Limit(opening);
                return cast;
            }
            ray = beyond;
            cast.sector = portal.to;
            cast.there_from_here = there * cast.there_from_here;
            cast.crossed.push(portal_id);
        }
    }

    /// The nearest opening that a ray goes into from the front, and where.
    fn next_opening(
        &self,
        sector: SectorId,
        ray: &Ray,
        came_through: Option<PortalId>,
    ) -> Option<(OpeningId, f64)> {
        if self.is_flat() {
            return None;
        }
        let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
        let is_way_back = |opening: OpeningId| {
            let portal = self.portal_of(sector, opening);
            (came_through.zip(portal)).is_some_and(|(came, portal)| self.leads_back(came, portal))
        };
        let openings = (0..).map(OpeningId).zip(self.sector(sector).openings());
        // Added to a far origin, a direction that portals have shrunk would be lost in rounding.
        let length = direction.abs().max_element();
        openings
            .filter_map(|(id, opening)| {
                let mut pierced = pierced(&opening.outline, [origin, origin + direction / length])?;
                pierced.at /= length;
                // From the front, and ahead: the second point may lie before the plane or behind it.
                let inwards = pierced.at >= 0.0 && pierced.from_front;
                (inwards && pierced.at.is_finite() && !is_way_back(id)).then_some((id, pierced.at))
            })
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Whether 32-bit numbers can hold a ray that has come through a portal.
fn is_followed(ray: &Ray) -> bool {
    let length = ray
        .direction
        .into_iter()
        .fold(0.0, |most: f32, value| most.max(value.abs()));
    ray.origin.into_iter().all(is_in_range) && (1e-30..=1e30).contains(&length)
}
