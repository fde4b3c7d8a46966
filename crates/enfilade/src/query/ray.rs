//! Ray casts that follow portals.

use crate::geom::{Transform, is_in_range, pierced};
use crate::ids::{OpeningId, PortalId, SectorId};
use crate::scene::Scene;
use crate::sector::{Hit, Ray};
use glam::DVec3;

/// Result of [`Scene::cast`]: where a ray ends, and the portals it crossed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RayCast {
    /// The sector in which the ray ends.
    pub sector: SectorId,
    /// The obstacle that stops the ray.
    pub end: RayEnd,
    /// Distance over all portals, in multiples of the length of the ray's direction; infinite for [`RayEnd::Nothing`].
    pub distance: f64,
    /// Maps the space of the start to that of `sector`.
    pub there_from_here: Transform,
    /// The portals crossed, in order.
    pub crossed: Vec<PortalId>,
}

/// Obstacle at the end of a [`RayCast`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum RayEnd {
    /// A face. [`Hit::distance`] counts from the last portal.
    Face(Hit),
    /// An opening, hit from the front, that is closed or leads nowhere.
    Closed(OpeningId),
    /// An opening that is not followed, because it exceeds [`RayCast::MAX_CROSSED`], leads beyond
    /// [`MAX_COORDINATE`](crate::MAX_COORDINATE), or scales the direction out of the range of f32, as portals that
    /// scale up or down repeatedly do.
    Limit(OpeningId),
    /// No obstacle: the ray goes to infinity.
    Nothing,
}

impl RayCast {
    /// Maximum number of portals that one ray crosses.
    pub const MAX_CROSSED: usize = 256;
}

impl Scene {
    /// Casts a ray from a sector through open portals and returns the first hit.
    ///
    /// The direction may have any length but 0; distances are multiples of it. All faces stop the ray, from both sides.
    ///
    /// Cost: per sector on the way, that of its [`Sector::cast`](crate::Sector::cast) and O(openings).
    #[doc(alias = "raycast")]
    #[doc(alias = "pick")]
    #[doc(alias = "picking")]
    pub fn cast(&self, from: SectorId, ray: &Ray) -> RayCast {
        self.cast_until(from, ray, f64::INFINITY)
    }

    /// Casts a ray as [`Scene::cast`] does, but follows no opening that is farther than `limit`.
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

    /// Returns the nearest opening that a ray enters from the front, and the distance to it.
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
        // Normalized, because a direction that portals have scaled down would be lost in rounding when added to a far
        // origin.
        let length = direction.abs().max_element();
        openings
            .filter_map(|(id, opening)| {
                let mut pierced = pierced(&opening.outline, [origin, origin + direction / length])?;
                pierced.at /= length;
                // The second point may be on either side of the plane, so only the side of the origin and the sign of
                // the distance count.
                let inwards = pierced.at >= 0.0 && pierced.from_front;
                (inwards && pierced.at.is_finite() && !is_way_back(id)).then_some((id, pierced.at))
            })
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Returns `true` if f32 can represent a ray that has crossed a portal.
fn is_followed(ray: &Ray) -> bool {
    let length = ray
        .direction
        .into_iter()
        .fold(0.0, |most: f32, value| most.max(value.abs()));
    ray.origin.into_iter().all(is_in_range) && (1e-30..=1e30).contains(&length)
}
