//! Locations (a position and its sector), and movement through portals.
//!
//! Source: RenderWare, Portal culling: bodies and cameras that cross a portal change section and coordinates.

use crate::geom::{ConvexPolygon, Pierced, Transform, is_in_range, nearest_in, pierced};
use crate::ids::{PortalId, SectorId};
use crate::scene::{Portal, Scene};
use glam::DVec3;

/// Position in a scene: a sector and coordinates in its space.
#[doc(alias = "position")]
#[doc(alias = "world position")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    /// The sector.
    pub sector: SectorId,
    /// Coordinates in the space of the sector, in scene units.
    pub position: [f32; 3],
}

/// Result of [`Scene::walk`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MoveResult {
    /// The location after the step.
    pub location: Location,
    /// Maps the space of the start to that of the end. Apply it to the velocity and orientation of a body.
    pub there_from_here: Transform,
    /// The portals crossed, in order.
    pub crossed: Vec<PortalId>,
    /// Whether every portal on the way was crossed. If `false`, the position is behind the opening of the first portal
    /// not crossed, in the space in front of it: that portal exceeded [`MoveResult::MAX_CROSSED`] or led beyond
    /// [`MAX_COORDINATE`](crate::MAX_COORDINATE), as portals that scale up repeatedly do.
    pub complete: bool,
}

impl MoveResult {
    /// Maximum number of portals that one step crosses.
    pub const MAX_CROSSED: usize = 256;
}

/// Sector that a bounding sphere reaches into, from [`Scene::body_sectors`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyInSector {
    /// The centre of the sphere in the space of that sector; it may be outside of the sector.
    pub location: Location,
    /// The radius in the space of that sector.
    pub radius: f32,
    /// Maps the space of the sphere's own sector to that of this one.
    pub there_from_here: Transform,
    /// The portals crossed to get there, in order.
    pub crossed: Vec<PortalId>,
}

impl Scene {
    /// Moves a point, or the centre of a sphere, by a step through every open portal that it crosses from front to
    /// back. Nothing else stops it. A step that ends in the plane of an opening does not cross it. Does not move at all
    /// if the step is not finite or ends beyond [`MAX_COORDINATE`](crate::MAX_COORDINATE).
    ///
    /// Cost: O(openings) per sector on the way.
    #[doc(alias = "move")]
    #[doc(alias = "teleport")]
    pub fn walk(&self, from: Location, step: [f32; 3]) -> MoveResult {
        let mut walked = MoveResult {
            location: from,
            there_from_here: Transform::IDENTITY,
            crossed: Vec::new(),
            complete: true,
        };
        let end: [f32; 3] = std::array::from_fn(|axis| from.position[axis] + step[axis]);
        if !from.position.iter().chain(&end).all(|&value| is_in_range(value)) {
            return walked;
        }
        walked.location.position = end;
        // Both ends of the step, in the current space; portals at a parameter below `at` are already crossed.
        let mut ends = [from.position, end].map(|point| DVec3::from(point.map(f64::from)));
        let mut at = 0.0;
        while let Some((portal_id, pierced)) = self.next_crossed(&walked, ends, at) {
            if walked.crossed.len() == MoveResult::MAX_CROSSED {
                walked.complete = false;
                break;
            }
            let portal = &self.portals()[portal_id.0 as usize];
            at = pierced.at.max(at);
            let there = ends.map(|point| portal.there_from_here.0.transform_point3(point));
            // Later queries start at the end point: it is rounded before its side of a plane is computed, not after.
            let rounded = there[1].as_vec3();
            if !rounded.to_array().into_iter().all(is_in_range) {
                walked.complete = false;
                break;
            }
            ends = [there[0], rounded.as_dvec3()];
            walked.location = Location {
                sector: portal.to,
                position: rounded.into(),
            };
            walked.there_from_here = portal.there_from_here * walked.there_from_here;
            walked.crossed.push(portal_id);
        }
        walked
    }

    /// Returns the next portal that a step crosses, if any.
    fn next_crossed(&self, walked: &MoveResult, ends: [DVec3; 2], at: f64) -> Option<(PortalId, Pierced)> {
        let sector = walked.location.sector;
        let mut first: Option<(PortalId, Pierced)> = None;
        for (portal_id, outline) in self.open_portals(sector) {
            // A line crosses a plane once, and it has just crossed this one.
            if (walked.crossed.last()).is_some_and(|&came| self.leads_back(came, portal_id)) {
                continue;
            }
            let Some(pierced) = pierced(outline, ends) else {
                continue;
            };
            // Rounding may have left the end of the last step slightly behind an opening that it is in front of.
            let starts_here = walked.crossed.is_empty();
            let before = pierced.from_front || (starts_here && pierced.distance >= -outline.slack());
            let ahead = pierced.at >= at - 1e-9;
            let nearer = first.is_none_or(|(_, known)| pierced.at < known.at);
            if before && pierced.to_behind && ahead && nearer {
                first = Some((portal_id, pierced));
            }
        }
        first
    }

    /// Iterates over the open portals of a sector and the outlines of their openings. A scene
    /// [without portals](Scene::without_portals) has none.
    pub fn open_portals(&self, sector: SectorId) -> impl Iterator<Item = (PortalId, &ConvexPolygon)> {
        let openings = self.sector(sector).openings().iter().zip(0..);
        openings.filter_map(move |(opening, number)| {
            let portal = self.portal_of(sector, crate::ids::OpeningId(number))?;
            let open = self.portals()[portal.0 as usize].open && !self.is_flat();
            open.then_some((portal, &opening.outline))
        })
    }

    /// Returns `true` if `portal` leads back through the opening by which `came` arrived, as the other portal of a door
    /// does.
    pub fn leads_back(&self, came: PortalId, portal: PortalId) -> bool {
        if ![came, portal].into_iter().all(|id| self.has_portal(id)) {
            return false;
        }
        let [came, portal] = [came, portal].map(|id| &self.portals()[id.0 as usize]);
        if portal.from != came.to || portal.to != came.from {
            return false;
        }
        let outline =
            |portal: &Portal| &self.sector(portal.from).openings()[usize::from(portal.opening.0)].outline;
        let [there, back] = [outline(came), outline(portal)].map(corners);
        let [out, home] = [came.there_from_here.0, portal.there_from_here.0];
        let middle = |corners: &[DVec3]| corners.iter().sum::<DVec3>() / corners.len() as f64;
        let near = 1e-3 * f64::from(outline(came).bounds().longest_side());
        let returns = |&corner: &DVec3| {
            home.transform_point3(out.transform_point3(corner))
                .distance(corner)
                <= near
        };
        there.iter().all(returns) && home.transform_point3(middle(&back)).distance(middle(&there)) <= near
    }

    /// Returns the sectors that a sphere reaches into through any number of open portals, its own sector first. To make
    /// a body visible as a whole, add it as an item to each of them at the location returned.
    ///
    /// Returns at most 64 sectors, and only the sphere's own one if its position is beyond
    /// [`MAX_COORDINATE`](crate::MAX_COORDINATE). Conservative: may include a sector whose opening the sphere reaches,
    /// but not through the opening before it.
    pub fn body_sectors(&self, location: Location, radius: f32) -> Vec<BodyInSector> {
        let mut all = vec![BodyInSector {
            location,
            radius,
            there_from_here: Transform::IDENTITY,
            crossed: Vec::new(),
        }];
        let mut next = 0;
        while next < all.len() && all.len() < MAX_SECTORS {
            let here = all[next].clone();
            next += 1;
            let middle = DVec3::from(here.location.position.map(f64::from));
            for (portal_id, outline) in self.open_portals(here.location.sector) {
                let portal = &self.portals()[portal_id.0 as usize];
                if (here.crossed.last()).is_some_and(|&came| self.leads_back(came, portal_id))
                    || !reaches(outline, middle, f64::from(here.radius))
                {
                    continue;
                }
                let there = portal.there_from_here;
                let position = there.point(here.location.position);
                if !position.into_iter().all(is_in_range) {
                    continue;
                }
                let mut crossed = here.crossed.clone();
                crossed.push(portal_id);
                all.push(BodyInSector {
                    location: Location {
                        sector: portal.to,
                        position,
                    },
                    radius: (f64::from(here.radius) * there.scale()) as f32,
                    there_from_here: there * here.there_from_here,
                    crossed,
                });
            }
        }
        all
    }
}

/// Maximum number of sectors that one body is in.
const MAX_SECTORS: usize = 64;

/// Returns `true` if a sphere whose centre is in front of an opening reaches it.
fn reaches(outline: &ConvexPolygon, middle: DVec3, radius: f64) -> bool {
    let corners = corners(outline);
    let normal = DVec3::from(outline.normal().map(f64::from));
    normal.dot(middle - corners[0]) >= -outline.slack()
        && nearest_in(&corners, middle).distance(middle) < radius
}

/// Returns the corners of an outline in f64.
pub(super) fn corners(outline: &ConvexPolygon) -> Vec<DVec3> {
    let corners = outline.corners().iter();
    corners.map(|corner| DVec3::from(corner.map(f64::from))).collect()
}
