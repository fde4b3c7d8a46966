//! Positions that know their sector, and how they move through portals.
//!
//! Source: RenderWare, Portal culling: bodies and cameras that cross a portal change section and coordinates.

use crate::geom::{ConvexPolygon, Pierced, Transform, is_in_range, nearest_in, pierced};
use crate::scene::{Portal, PortalId, Scene, SectorId};
use glam::DVec3;

/// A position in a sector's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    /// Where it is.
    pub sector: SectorId,
    /// Where in it, in its own space.
    pub position: [f32; 3],
}

/// Where a step leads.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MoveResult {
    /// Where it ends.
    pub place: Location,
    /// From the space that it began in to the one that it ends in: turns a body and its course.
    pub there_from_here: Transform,
    /// The portals that it went through, in order.
    pub crossed: Vec<PortalId>,
    /// Whether it went through every portal on the way. If not, it ends behind the opening of the first one that it did not
    /// go through, in the space before it: that was one more than [`MoveResult::MAX_CROSSED`], or led beyond
    /// [`MAX_COORDINATE`](crate::MAX_COORDINATE), as portals that enlarge again and again do.
    pub complete: bool,
}

impl MoveResult {
    /// Portals that one step goes through at most.
    pub const MAX_CROSSED: usize = 256;
}

/// A sector that a body stands in.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyInSector {
    /// Where its middle is, as seen from that sector; it may lie outside.
    pub place: Location,
    /// Its radius there.
    pub radius: f32,
    /// From the space of the sector that its middle is in.
    pub there_from_here: Transform,
    /// The portals between, in order.
    pub crossed: Vec<PortalId>,
}

impl Scene {
    /// Moves a point, or the middle of a sphere, by a step, through every open portal that it crosses from the front to
    /// the back; nothing else stops it. What ends in the plane of an opening has not crossed it. A step that is not finite, or
    /// ends beyond [`MAX_COORDINATE`](crate::MAX_COORDINATE), is none.
    ///
    /// Cost: O(openings) for each sector on the way.
    pub fn walk(&self, from: Location, step: [f32; 3]) -> MoveResult {
        let mut walked = MoveResult {
            place: from,
            there_from_here: Transform::IDENTITY,
            crossed: Vec::new(),
            complete: true,
        };
        let end: [f32; 3] = std::array::from_fn(|axis| from.position[axis] + step[axis]);
        if !from.position.iter().chain(&end).all(|&value| is_in_range(value)) {
            return walked;
        }
        walked.place.position = end;
        // Both ends of the step, in the space at hand; what is nearer than `at` along it lies behind.
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
            // The far end is what will be asked of later: it is rounded before, not after, sides are told.
            let rounded = there[1].as_vec3();
            if !rounded.to_array().into_iter().all(is_in_range) {
                walked.complete = false;
                break;
            }
            ends = [there[0], rounded.as_dvec3()];
            walked.place = Location {
                sector: portal.to,
                position: rounded.into(),
            };
            walked.there_from_here = portal.there_from_here * walked.there_from_here;
            walked.crossed.push(portal_id);
        }
        walked
    }

    /// The next portal that a step crosses, if any.
    fn next_crossed(&self, walked: &MoveResult, ends: [DVec3; 2], at: f64) -> Option<(PortalId, Pierced)> {
        let sector = walked.place.sector;
        let mut first: Option<(PortalId, Pierced)> = None;
        for (portal_id, outline) in self.ways_out(sector) {
            // A line crosses a plane once: it has just come through this one.
            if (walked.crossed.last()).is_some_and(|&came| self.leads_back(came, portal_id)) {
                continue;
            }
            let Some(pierced) = pierced(outline, ends) else {
                continue;
            };
            // Where the last step ended, rounding may have left it a little behind an opening that it is before.
            let starts_here = walked.crossed.is_empty();
            let before = pierced.from_front || (starts_here && pierced.distance >= -slack(outline));
            let ahead = pierced.at >= at - 1e-9;
            let nearer = first.is_none_or(|(_, known)| pierced.at < known.at);
            if before && pierced.to_behind && ahead && nearer {
                first = Some((portal_id, pierced));
            }
        }
        first
    }

    /// The open portals of a sector, and the outlines of the openings that they lead out of.
    pub(crate) fn ways_out(&self, sector: SectorId) -> impl Iterator<Item = (PortalId, &ConvexPolygon)> {
        let openings = self.sector(sector).openings().iter().zip(0..);
        openings.filter_map(move |(opening, number)| {
            let portal = self.portal_of(sector, crate::geometry::OpeningId(number))?;
            let open = self.portals()[portal.0 as usize].open && !self.is_flat();
            open.then_some((portal, &opening.outline))
        })
    }

    /// Is a portal the way back through the opening that one has come through?
    pub(crate) fn leads_back(&self, came: PortalId, portal: PortalId) -> bool {
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

    /// The sectors that a sphere stands in, its own first: those that it reaches into through open portals, however
    /// many in a row. A body is seen whole if it is an item of each, at the place that is given here.
    ///
    /// A position beyond [`MAX_COORDINATE`](crate::MAX_COORDINATE) is in its own sector only, and the sphere is in at most
    /// 64 sectors. It may say one too many: where the sphere reaches an opening, but not through the one before it.
    pub fn stands_in(&self, place: Location, radius: f32) -> Vec<BodyInSector> {
        let mut all = vec![BodyInSector {
            place,
            radius,
            there_from_here: Transform::IDENTITY,
            crossed: Vec::new(),
        }];
        let mut next = 0;
        while next < all.len() && all.len() < MAX_PRESENT {
            let here = all[next].clone();
            next += 1;
            let middle = DVec3::from(here.place.position.map(f64::from));
            for (portal_id, outline) in self.ways_out(here.place.sector) {
                let portal = &self.portals()[portal_id.0 as usize];
                if (here.crossed.last()).is_some_and(|&came| self.leads_back(came, portal_id))
                    || !reaches(outline, middle, f64::from(here.radius))
                {
                    continue;
                }
                let there = portal.there_from_here;
                let position = there.point(here.place.position);
                if !position.into_iter().all(is_in_range) {
                    continue;
                }
                let mut crossed = here.crossed.clone();
                crossed.push(portal_id);
                all.push(BodyInSector {
                    place: Location {
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

/// Sectors that one body stands in at most.
const MAX_PRESENT: usize = 64;

/// Does a sphere before an opening reach it?
fn reaches(outline: &ConvexPolygon, middle: DVec3, radius: f64) -> bool {
    let corners = corners(outline);
    let normal = DVec3::from(outline.normal().map(f64::from));
    normal.dot(middle - corners[0]) >= -slack(outline)
        && nearest_in(&corners, middle).distance(middle) < radius
}

/// How far a point may lie behind an opening that it is before: what f32 positions and the flatness of outlines lose.
pub(crate) fn slack(outline: &ConvexPolygon) -> f64 {
    let bounds = outline.bounds();
    let farthest = (bounds.min.iter().chain(&bounds.max)).fold(0.0_f32, |most, value| most.max(value.abs()));
    1e-5 * f64::from(bounds.longest_side()) + 4.0 * f64::from(f32::EPSILON) * f64::from(farthest)
}

/// The corners of an outline.
pub(super) fn corners(outline: &ConvexPolygon) -> Vec<DVec3> {
    let corners = outline.corners().iter();
    corners.map(|corner| DVec3::from(corner.map(f64::from))).collect()
}
