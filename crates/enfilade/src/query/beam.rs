//! What a point reaches through openings in straight lines: light, and sight in all directions.
//!
//! A beam leaves a point, is narrowed by every opening that it goes through, and nothing else is in its way.
//! Source: RenderWare, Portal culling: lights reach through portals, transformed.
//! Cost: O(openings) for each sector that it reaches, once for each chain of portals.

use super::place::{Location, corners, slack};
use crate::geom::{Transform, nearest_in};
use crate::scene::{PortalId, Scene, SectorId};
use crate::viewer::Limits;
use glam::DVec3;
use smallvec::SmallVec;

/// A sector that a point reaches into, through zero or more portals.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LightReach {
    /// Where it comes from, by its place in the list; `None` for the sector that the point is in.
    pub parent: Option<u32>,
    /// The portal through which it leaves its parent.
    pub portal: Option<PortalId>,
    /// The sector that is reached.
    pub sector: SectorId,
    /// Portals on the way.
    pub crossings: u16,
    /// From the space that the point is in to that of the sector.
    pub there_from_here: Transform,
    /// Where the point is, as seen from the sector.
    pub origin: [f64; 3],
    /// What the last opening lets through: a convex outline in the sector's space. Empty where the point is.
    pub window: Vec<[f64; 3]>,
    /// The planes that the beam is between, beyond the last opening: it holds points with n · x ≥ d for all.
    planes: SmallVec<[(DVec3, f64); 8]>,
}

impl LightReach {
    /// The planes that the beam is between: it holds points with n · x ≥ d for all (n, d), in the sector's space. None
    /// where the point is.
    pub fn planes(&self) -> impl Iterator<Item = ([f64; 3], f64)> {
        self.planes
            .iter()
            .map(|&(normal, distance)| (normal.into(), distance))
    }

    /// Does a straight line from the point, through all openings on the way, lead to a point of the sector? What is in
    /// its way besides is not asked.
    pub fn holds(&self, point: [f64; 3]) -> bool {
        let point = DVec3::from(point);
        self.planes
            .iter()
            .all(|&(normal, distance)| normal.dot(point) >= distance)
    }
}

impl Scene {
    /// The sectors that a point reaches into in straight lines through open portals, its own first, each after its
    /// parent: the light of a lamp, say. What is farther than `range`, in the point's own units, is not reached.
    ///
    /// A sector that is reached in several ways is there several times. Where `limits` bite, the rest is left out, and so
    /// is what is behind portals that enlarge or shrink again and again until 64-bit numbers end. A position that is not
    /// finite reaches its own sector only.
    pub fn reach(&self, from: Location, range: f32, limits: &Limits) -> Vec<LightReach> {
        let mut all = vec![LightReach {
            parent: None,
            portal: None,
            sector: from.sector,
            crossings: 0,
            there_from_here: Transform::IDENTITY,
            origin: from.position.map(f64::from),
            window: Vec::new(),
            planes: SmallVec::new(),
        }];
        let mut next = 0;
        while next < all.len() && from.position.iter().all(|value| value.is_finite()) {
            if all[next].crossings < limits.max_crossings {
                for (portal, _) in self.ways_out(all[next].sector) {
                    if all.len() >= limits.max_passages as usize {
                        return all;
                    }
                    let child = self.beam_through(&all[next], next as u32, portal, f64::from(range));
                    all.extend(child);
                }
            }
            next += 1;
        }
        all
    }

    /// What of a beam goes on through a portal; `None` if nothing does.
    pub(super) fn beam_through(
        &self,
        beam: &LightReach,
        number: u32,
        portal_id: PortalId,
        range: f64,
    ) -> Option<LightReach> {
        if (beam.portal).is_some_and(|came| self.leads_back(came, portal_id)) {
            return None;
        }
        let portal = &self.portals()[portal_id.0 as usize];
        let opening = &self.sector(portal.from).openings()[usize::from(portal.opening.0)];
        let normal = DVec3::from(opening.outline.normal().map(f64::from));
        let mut window = corners(&opening.outline);
        let origin = DVec3::from(beam.origin);
        let before = normal.dot(origin - window[0]);
        if before < -slack(&opening.outline) {
            return None;
        }
        for &(normal, distance) in &beam.planes {
            window = clip(&window, normal, distance);
        }
        if window.len() < 3 {
            return None;
        }
        let off = nearest_in(&window, origin).distance(origin);
        // A point in the plane of an opening goes through it where it stands in it, and nowhere else.
        let in_plane = before <= slack(&opening.outline);
        if off > range * beam.there_from_here.scale() || (in_plane && off > slack(&opening.outline)) {
            return None;
        }
        let there = portal.there_from_here;
        let moved = |point: DVec3| there.0.transform_point3(point);
        let here_from_there = there.inverse()?.0;
        let there_from_start = there * beam.there_from_here;
        if !(moved(origin).is_finite() && there_from_start.inverse().is_some()) {
            return None;
        }
        let mut child = LightReach {
            parent: Some(number),
            portal: Some(portal_id),
            sector: portal.to,
            crossings: beam.crossings + 1,
            there_from_here: there_from_start,
            origin: moved(origin).into(),
            window: window.iter().map(|&corner| moved(corner).into()).collect(),
            planes: SmallVec::new(),
        };
        let turned = |normal: DVec3| here_from_there.matrix3.transpose() * normal;
        let onwards = turned(-normal).normalize_or_zero();
        let entry = DVec3::from(child.window[0]);
        child.planes.push((onwards, onwards.dot(entry)));
        if in_plane {
            let moved = |&(normal, distance): &(DVec3, f64)| {
                (turned(normal), distance - normal.dot(here_from_there.translation))
            };
            child.planes.extend(beam.planes.iter().map(moved));
        } else {
            let apex = DVec3::from(child.origin);
            let sides = sides(origin, &window).map(turned);
            child
                .planes
                .extend(sides.map(|normal| (normal, normal.dot(apex))));
        }
        Some(child)
    }
}

/// The planes through a beam's origin and the edges of its window.
fn sides(origin: DVec3, window: &[DVec3]) -> impl Iterator<Item = DVec3> {
    let middle = window.iter().sum::<DVec3>() / window.len() as f64;
    (0..window.len()).map(move |i| {
        let [start, end] = [window[i], window[(i + 1) % window.len()]];
        let normal = (start - origin).cross(end - origin).normalize_or_zero();
        // Turned inwards, whichever way the outline runs.
        normal * normal.dot(middle - origin).signum()
    })
}

/// The part of a convex outline where n · x ≥ d.
fn clip(outline: &[DVec3], normal: DVec3, distance: f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(outline.len() + 1);
    for (i, &corner) in outline.iter().enumerate() {
        let next = outline[(i + 1) % outline.len()];
        let [here, there] = [corner, next].map(|point| normal.dot(point) - distance);
        if here >= 0.0 {
            kept.push(corner);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            kept.push(corner + (next - corner) * (here / (here - there)));
        }
    }
    kept
}
