//! Straight lines through portal chains, tested one by one, and direct light along them: the reference for light beams
//! and lit pictures.

use crate::ids::{PortalId, SectorId};
use crate::query::Location;
use crate::scene::{Light, LightShape, Scene};
use glam::{DAffine3, DVec3};

/// Returns all chains of at most `most` open portals that start in a sector, and the sector each leads to.
pub fn chains(scene: &Scene, from: SectorId, most: usize) -> Vec<(Vec<PortalId>, SectorId)> {
    let mut all = vec![(Vec::new(), from)];
    let mut next = 0;
    while next < all.len() {
        let (chain, at) = all[next].clone();
        next += 1;
        if chain.len() == most {
            continue;
        }
        for (portal, id) in scene.portals().iter().zip((0..).map(PortalId)) {
            if portal.open && portal.from == at {
                let mut longer: Vec<PortalId> = chain.clone();
                longer.push(id);
                all.push((longer, portal.to));
            }
        }
    }
    all
}

/// Tolerance in scene units: a line closer than this to an edge or a plane is undecided.
const CLEAR: f64 = 1e-4;

/// Returns `true` if the straight line from a location to a point of the last sector passes through all openings of a
/// chain, in order. `None` if rounding decides.
pub fn goes_straight(scene: &Scene, from: Location, chain: &[PortalId], to: [f64; 3]) -> Option<bool> {
    let portals: Vec<_> = chain.iter().map(|id| &scene.portals()[id.0 as usize]).collect();
    // The origin in each sector's space, first to last, and the target in each, last to first.
    let mut origins = vec![DVec3::from(from.position.map(f64::from))];
    for portal in &portals {
        origins.push(
            portal
                .there_from_here
                .0
                .transform_point3(origins[origins.len() - 1]),
        );
    }
    let mut targets = vec![DVec3::from(to)];
    for portal in portals.iter().rev() {
        let back = portal.there_from_here.0.inverse();
        targets.push(back.transform_point3(targets[targets.len() - 1]));
    }
    targets.reverse();
    let mut last = 0.0;
    let mut unsure = false;
    for (i, portal) in portals.iter().enumerate() {
        let outline = &scene.sector(portal.from).openings()[usize::from(portal.opening.0)].outline;
        let corners: Vec<DVec3> = (outline.corners().iter())
            .map(|corner| DVec3::from(corner.map(f64::from)))
            .collect();
        let normal = DVec3::from(outline.normal().map(f64::from));
        let [near, far] = [origins[i], targets[i]].map(|point| normal.dot(point - corners[0]));
        if near < -CLEAR || far > CLEAR {
            return Some(false);
        }
        unsure |= near < CLEAR || far > -CLEAR;
        let at = near / (near - far);
        let met = origins[i].lerp(targets[i], at);
        let edges = (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()]));
        let off = edges.map(|(a, b)| normal.cross(b - a).normalize().dot(met - a));
        let inside = off.fold(f64::INFINITY, f64::min);
        if inside < -CLEAR || at < last - CLEAR {
            return Some(false);
        }
        unsure |= inside < CLEAR || (i > 0 && at < last + CLEAR);
        last = at;
    }
    (!unsure).then_some(true)
}

/// The direct light of a scene's lamps along all portal chains. Suns are not included.
pub struct Lamplight<'a> {
    scene: &'a Scene,
    ways: Vec<LampChain>,
}

/// One portal chain from a lamp into a sector.
struct LampChain {
    light: Light,
    chain: Vec<PortalId>,
    sector: SectorId,
    /// Position of the lamp in that sector's space; `scale` is the length there per unit length at the lamp.
    lamp: DVec3,
    /// Unit direction of a spot light's axis in that sector's space; zero for a point light.
    onwards: DVec3,
    scale: f64,
}

impl Lamplight<'_> {
    /// Finds the chains of at most `most` portals from each lamp.
    pub fn new(scene: &Scene, most: usize) -> Lamplight<'_> {
        let ways_of = |&light: &Light| {
            let way = move |(chain, sector): (Vec<PortalId>, SectorId)| {
                let there_from_here = chain.iter().fold(DAffine3::IDENTITY, |sum, id| {
                    scene.portals()[id.0 as usize].there_from_here.0 * sum
                });
                LampChain {
                    light,
                    chain,
                    sector,
                    lamp: there_from_here.transform_point3(DVec3::from(light.position.map(f64::from))),
                    onwards: there_from_here
                        .transform_vector3(
                            light
                                .direction()
                                .map_or(DVec3::ZERO, |d| DVec3::from(d.map(f64::from))),
                        )
                        .normalize_or_zero(),
                    scale: there_from_here.matrix3.x_axis.length(),
                }
            };
            chains(scene, light.sector, most).into_iter().map(way)
        };
        let is_lamp = |light: &&Light| !matches!(light.shape, LightShape::Sun { .. });
        let lamps = scene.lights().iter().filter(is_lamp);
        Lamplight {
            scene,
            ways: lamps.flat_map(ways_of).collect(),
        }
    }

    /// Returns the linear color that a white diffuse surface with unit normal `normal` reflects at a point of a sector.
    /// `None` if rounding decides whether a lamp reaches it.
    pub fn at(&self, sector: SectorId, point: [f64; 3], normal: [f64; 3]) -> Option<[f64; 3]> {
        let mut sum = DVec3::ZERO;
        for way in self.ways.iter().filter(|way| way.sector == sector) {
            let from = Location {
                sector: way.light.sector,
                position: way.light.position,
            };
            let to_lamp = way.lamp - DVec3::from(point);
            let cosine = DVec3::from(normal).dot(to_lamp.normalize());
            let strength = way.light.falloff(to_lamp.length() / way.scale)
                * way.light.cone(way.onwards.dot(-to_lamp.normalize()))
                * cosine.max(0.0);
            if strength > 0.0 && goes_straight(self.scene, from, &way.chain, point)? {
                sum += DVec3::from(way.light.color.map(f64::from)) * strength;
            }
        }
        Some(sum.into())
    }
}
