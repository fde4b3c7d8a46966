//! Beams from a point through openings: the reach of lights, and of sight in all directions.
//!
//! Idea: a beam starts at a point and is clipped by every opening that it crosses; nothing else blocks it.
//! Source: RenderWare, Portal culling: lights reach through portals, transformed.
//! Cost: O(openings) per sector reached, once per chain of portals.

use super::location::{Location, corners};
use crate::geom::{Transform, nearest_in};
use crate::ids::{PortalId, SectorId};
use crate::scene::Scene;
use crate::view::options::Limits;
use glam::DVec3;
use smallvec::SmallVec;

/// Beam from a point into a sector, through zero or more portals, from [`Scene::reach`].
#[doc(alias = "light propagation")]
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LightReach {
    /// Index in the list of the beam that this one continues; `None` for the sector of the point.
    pub parent: Option<u32>,
    /// The portal by which it leaves its parent's sector.
    pub portal: Option<PortalId>,
    /// The sector reached.
    pub sector: SectorId,
    /// Number of portals crossed.
    pub crossings: u16,
    /// Maps the space of the point to that of the sector.
    pub there_from_here: Transform,
    /// Position of the point in the space of the sector.
    pub origin: [f64; 3],
    /// Clip region in the last opening: a convex outline in the space of the sector. Empty for the sector of the point.
    pub window: Vec<[f64; 3]>,
    /// The clip planes of the beam, beyond the last opening: points inside have n · x ≥ d for all.
    planes: SmallVec<[(DVec3, f64); 8]>,
}

impl LightReach {
    /// Iterates over the clip planes (n, d) of the beam, in the space of the sector: points inside have n · x ≥ d for
    /// all. There are none for the sector of the point.
    pub fn planes(&self) -> impl Iterator<Item = ([f64; 3], f64)> {
        self.planes
            .iter()
            .map(|&(normal, distance)| (normal.into(), distance))
    }

    /// Returns `true` if a straight line leads from the point through all openings on the way to `point`, in the space
    /// of the sector. Ignores other obstacles.
    pub fn holds(&self, point: [f64; 3]) -> bool {
        let point = DVec3::from(point);
        self.planes
            .iter()
            .all(|&(normal, distance)| normal.dot(point) >= distance)
    }
}

impl Scene {
    /// Returns the sectors that a point reaches in straight lines through open portals, its own sector first, each
    /// after its parent. Use it to find the sectors that a light affects. `range` is in units of the point's sector.
    ///
    /// A sector that is reached by several chains of portals is listed once per chain. Beams beyond `limits` are left
    /// out, and so are those behind portals that scale up or down repeatedly beyond the range of f64. A position that
    /// is not finite reaches its own sector only.
    #[doc(alias = "light propagation")]
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
                for (portal, _) in self.open_portals(all[next].sector) {
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

    /// Returns the continuation of a beam through a portal; `None` if it is clipped away.
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
        if before < -opening.outline.slack() {
            return None;
        }
        for &(normal, distance) in &beam.planes {
            window = clip(&window, normal, distance);
        }
        if window.len() < 3 {
            return None;
        }
        let off = nearest_in(&window, origin).distance(origin);
        // A point in the plane of an opening goes through it only if it is inside the outline.
        let in_plane = before <= opening.outline.slack();
        if off > range * beam.there_from_here.scale() || (in_plane && off > opening.outline.slack()) {
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

/// Returns the normals of the planes through the origin of a beam and the edges of its window.
fn sides(origin: DVec3, window: &[DVec3]) -> impl Iterator<Item = DVec3> {
    let middle = window.iter().sum::<DVec3>() / window.len() as f64;
    (0..window.len()).map(move |i| {
        let [start, end] = [window[i], window[(i + 1) % window.len()]];
        let normal = (start - origin).cross(end - origin).normalize_or_zero();
        // Points inwards for either winding.
        normal * normal.dot(middle - origin).signum()
    })
}

/// Clips a convex outline to n · x ≥ d.
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
