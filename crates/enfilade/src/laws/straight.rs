//! Straight lines through portal chains, tested one by one, what blocks them, and direct light along them: the reference for
//! light beams, lit pictures and shadows.

use crate::geometry::Alpha;
use crate::ids::{ItemIndex, LightId, PortalId, SectorId};
use crate::query::{Location, RayEnd};
use crate::scene::{Light, LightShape, Scene};
use crate::sector::Ray;
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

/// The straight line from a point to a point of the last sector of a chain of portals, in the space of each sector.
struct Line {
    /// Its ends in each sector's space, first to last.
    ends: Vec<[DVec3; 2]>,
    /// Where it crosses each portal, 0 at its start and 1 at its end.
    crossings: Vec<f64>,
}

impl Line {
    /// Returns the line if it passes through all openings of the chain, in order. `Err` if rounding decides.
    fn through(scene: &Scene, from: DVec3, chain: &[PortalId], to: DVec3) -> Result<Option<Line>, Unsure> {
        let portals: Vec<_> = chain.iter().map(|id| &scene.portals()[id.0 as usize]).collect();
        let mut starts = vec![from];
        for portal in &portals {
            starts.push(
                portal
                    .there_from_here
                    .0
                    .transform_point3(starts[starts.len() - 1]),
            );
        }
        let mut targets = vec![to];
        for portal in portals.iter().rev() {
            let back = portal.there_from_here.0.inverse();
            targets.push(back.transform_point3(targets[targets.len() - 1]));
        }
        targets.reverse();
        let mut crossings: Vec<f64> = Vec::new();
        let mut unsure = false;
        for (i, portal) in portals.iter().enumerate() {
            let outline = &scene.sector(portal.from).openings()[usize::from(portal.opening.0)].outline;
            let corners: Vec<DVec3> = (outline.corners().iter())
                .map(|corner| DVec3::from(corner.map(f64::from)))
                .collect();
            let normal = DVec3::from(outline.normal().map(f64::from));
            let [near, far] = [starts[i], targets[i]].map(|point| normal.dot(point - corners[0]));
            if near < -CLEAR || far > CLEAR {
                return Ok(None);
            }
            unsure |= near < CLEAR || far > -CLEAR;
            let at = near / (near - far);
            let inside = margin(&corners, normal, starts[i].lerp(targets[i], at));
            // A length, compared as one.
            let length = starts[i].distance(targets[i]);
            let after = crossings
                .last()
                .map_or(f64::INFINITY, |last| (at - last) * length);
            if inside < -CLEAR || after < -CLEAR {
                return Ok(None);
            }
            unsure |= inside < CLEAR || after < CLEAR;
            crossings.push(at);
        }
        if unsure {
            return Err(Unsure);
        }
        let ends = starts
            .into_iter()
            .zip(targets)
            .map(|(start, target)| [start, target]);
        Ok(Some(Line {
            ends: ends.collect(),
            crossings,
        }))
    }

    /// Calls `hit` with each opaque face, as its sector, item and index, that keeps light from going along the line: one that is
    /// seen from its start, but not the one that it leads to. Closed openings block it too, and so do open ones that are not of
    /// the chain. `Err` if rounding decides about any, or an alpha test.
    fn blockers(
        &self,
        scene: &Scene,
        sectors: &[SectorId],
        chain: &[PortalId],
        onto: &SurfacePoint,
        mut hit: impl FnMut(SectorId, Option<(ItemIndex, u32)>),
    ) -> Result<(), Unsure> {
        for (i, (&sector, &[start, end])) in sectors.iter().zip(&self.ends).enumerate() {
            let first = if i == 0 { 0.0 } else { self.crossings[i - 1] };
            let last = self.crossings.get(i).copied().unwrap_or(1.0);
            let length = start.distance(end);
            let meets = |corners: &[DVec3], double_sided: bool| -> Result<bool, Unsure> {
                let normal = corners
                    .windows(2)
                    .map(|pair| (pair[0] - corners[0]).cross(pair[1] - corners[0]))
                    .sum::<DVec3>()
                    .normalize_or_zero();
                let [near, far] = [start, end].map(|point| normal.dot(point - corners[0]));
                if normal == DVec3::ZERO || (near - far).abs() < CLEAR * 1e-3 {
                    return Ok(false);
                }
                let at = near / (near - far);
                let inside = margin(corners, normal, start.lerp(end, at));
                let within = ((at - first) * length).min((last - at) * length);
                if inside < -CLEAR || within < -CLEAR || (near < 0.0 && !double_sided) {
                    return Ok(false);
                }
                if inside < CLEAR || within < CLEAR {
                    Err(Unsure)
                } else {
                    Ok(true)
                }
            };
            let own = scene.sector(sector);
            for (number, opening) in own.openings().iter().enumerate() {
                let leaves = chain
                    .get(i)
                    .is_some_and(|id| usize::from(scene.portals()[id.0 as usize].opening.0) == number);
                let corners: Vec<DVec3> = (opening.outline.corners().iter())
                    .map(|corner| DVec3::from(corner.map(f64::from)))
                    .collect();
                if !leaves && meets(&corners, false)? {
                    hit(sector, None);
                }
            }
            let Some(geometry) = scene.geometry(sector) else {
                continue;
            };
            for (item, placed) in (0..).map(ItemIndex).zip(geometry.items()) {
                let mesh = geometry.mesh_of(item);
                let transform = placed.transform();
                for face in 0..mesh.face_count() {
                    if i + 1 == sectors.len() && (item, face) == onto.face {
                        continue;
                    }
                    let cluster = &mesh.clusters()[mesh.cluster_of(face)];
                    let material = geometry.material(cluster);
                    if material.alpha == Alpha::Blend || !placed.options.is_drawn {
                        continue;
                    }
                    let corners: Vec<DVec3> = (mesh.face(face).iter())
                        .map(|&corner| transform.point_f64(mesh.positions()[corner as usize]).into())
                        .collect();
                    let corners: Vec<DVec3> = match transform.mirrors() {
                        true => corners.into_iter().rev().collect(),
                        false => corners,
                    };
                    if meets(&corners, material.double_sided)? {
                        if material.alpha == Alpha::Mask {
                            return Err(Unsure);
                        }
                        hit(sector, Some((item, face)));
                    }
                }
            }
        }
        Ok(())
    }
}

/// Rounding decides.
#[derive(Clone, Copy, Debug)]
struct Unsure;

/// Returns how far inside the edges of a convex outline a point of its plane is.
fn margin(corners: &[DVec3], normal: DVec3, point: DVec3) -> f64 {
    let edges = (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()]));
    let off = edges.map(|(a, b)| normal.cross(b - a).normalize_or_zero().dot(point - a));
    off.fold(f64::INFINITY, f64::min)
}

/// Returns `true` if the straight line from a location to a point of the last sector passes through all openings of a
/// chain, in order. `None` if rounding decides.
pub fn goes_straight(scene: &Scene, from: Location, chain: &[PortalId], to: [f64; 3]) -> Option<bool> {
    let from = DVec3::from(from.position.map(f64::from));
    let line = Line::through(scene, from, chain, to.into());
    line.ok().map(|line| line.is_some())
}

/// The direct light of a scene's lamps along all portal chains, with or without shadows.
pub struct Lamplight<'a> {
    scene: &'a Scene,
    ways: Vec<LampChain>,
    has_shadows: bool,
}

/// One portal chain from a lamp into a sector.
struct LampChain {
    id: LightId,
    light: Light,
    chain: Vec<PortalId>,
    /// The sectors along the chain, the light's first.
    sectors: Vec<SectorId>,
    /// Maps that sector's space to the lamp's.
    lamp_from_here: DAffine3,
    /// Position of the lamp in the space of the last sector; `scale` is the length there per unit length at the lamp.
    lamp: DVec3,
    /// Unit direction of a spot light's axis or of a sun in that sector's space; zero for a point light.
    onwards: DVec3,
    scale: f64,
}

/// A point of a face that may be lit.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// The sector of the face; the point and the normal are in its space.
    pub sector: SectorId,
    /// Position.
    pub point: [f64; 3],
    /// Unit normal, on the side that is looked at.
    pub normal: [f64; 3],
    /// Item and index of the face.
    pub face: (ItemIndex, u32),
}

impl SurfacePoint {
    /// Returns the point that a ray, as its origin and direction, meets first, through portals. `None` if it meets no face, a
    /// transparent one, or one from behind.
    pub fn first_along(
        scene: &Scene,
        from: SectorId,
        [origin, direction]: [[f64; 3]; 2],
    ) -> Option<SurfacePoint> {
        let [origin, direction] = [origin, direction].map(DVec3::from);
        let ray = Ray {
            origin: origin.as_vec3().into(),
            direction: direction.as_vec3().into(),
        };
        let cast = scene.cast(from, &ray);
        let RayEnd::Face(hit) = cast.end else { return None };
        let surface = scene.sector(cast.sector).surface(hit.item.index, hit.face);
        // One-sided faces are invisible from behind, and the ray passes through glass.
        if hit.from_behind || surface.alpha != Alpha::Opaque {
            return None;
        }
        let there = cast.there_from_here.0;
        let [start, point] =
            [origin, origin + direction * cast.distance].map(|at| there.transform_point3(at));
        let normal = DVec3::from(surface.normal.map(f64::from));
        Some(SurfacePoint {
            sector: cast.sector,
            point: point.into(),
            normal: (normal * normal.dot(start - point).signum()).into(),
            face: (hit.item.index, hit.face),
        })
    }
}

/// A face that keeps the light of a lamp from a point: its sector, and its item and index, or `None` for an opening.
pub type Blocker = (LightId, SectorId, Option<(ItemIndex, u32)>);

impl Lamplight<'_> {
    /// Finds the chains of at most `most` portals from each lamp.
    pub fn new(scene: &Scene, most: usize) -> Lamplight<'_> {
        let ways_of = |(id, &light): (LightId, &Light)| {
            let way = move |(chain, sector): (Vec<PortalId>, SectorId)| {
                let portals = || chain.iter().map(|id| &scene.portals()[id.0 as usize]);
                let there_from_here =
                    portals().fold(DAffine3::IDENTITY, |sum, portal| portal.there_from_here.0 * sum);
                let sectors = std::iter::once(light.sector).chain(portals().map(|portal| portal.to));
                let sectors: Vec<SectorId> = sectors.collect();
                debug_assert_eq!(sectors.last(), Some(&sector));
                let direction = light
                    .direction()
                    .map_or(DVec3::ZERO, |d| DVec3::from(d.map(f64::from)));
                LampChain {
                    id,
                    light,
                    sectors,
                    lamp_from_here: there_from_here.inverse(),
                    lamp: there_from_here.transform_point3(DVec3::from(light.position.map(f64::from))),
                    onwards: there_from_here.transform_vector3(direction).normalize_or_zero(),
                    scale: there_from_here.matrix3.x_axis.length(),
                    chain,
                }
            };
            chains(scene, light.sector, most).into_iter().map(way)
        };
        Lamplight {
            scene,
            ways: (0..).map(LightId).zip(scene.lights()).flat_map(ways_of).collect(),
            has_shadows: false,
        }
    }

    /// Returns the same light, which opaque faces block.
    #[must_use]
    pub fn with_shadows(self) -> Self {
        Lamplight {
            has_shadows: true,
            ..self
        }
    }

    /// Returns the linear color that a white diffuse surface reflects at a point. `None` if rounding decides whether a lamp
    /// reaches it.
    pub fn at(&self, onto: &SurfacePoint) -> Option<[f64; 3]> {
        let (mut sum, mut blocked) = (DVec3::ZERO, false);
        let mut arrives = |way: &LampChain, light: DVec3, line: &Line| {
            if self.has_shadows {
                blocked = false;
                line.blockers(self.scene, &way.sectors, &way.chain, onto, |_, _| blocked = true)?;
            }
            if !blocked {
                sum += light;
            }
            Ok(())
        };
        self.arrivals(onto, &mut arrives).ok()?;
        Some(sum.into())
    }

    /// Returns all faces that keep the light of any lamp from a point. `None` if rounding decides about one.
    pub fn blockers(&self, onto: &SurfacePoint) -> Option<Vec<Blocker>> {
        let mut all = Vec::new();
        let mut arrives = |way: &LampChain, _: DVec3, line: &Line| {
            line.blockers(self.scene, &way.sectors, &way.chain, onto, |sector, face| {
                all.push((way.id, sector, face));
            })
        };
        self.arrivals(onto, &mut arrives).ok()?;
        Some(all)
    }

    /// Calls `arrives` for each chain along which light would arrive at a point if no face blocked it.
    fn arrivals(
        &self,
        onto: &SurfacePoint,
        arrives: &mut dyn FnMut(&LampChain, DVec3, &Line) -> Result<(), Unsure>,
    ) -> Result<(), Unsure> {
        let [point, normal] = [onto.point, onto.normal].map(DVec3::from);
        for way in self
            .ways
            .iter()
            .filter(|way| way.sectors.last() == Some(&onto.sector))
        {
            let color = DVec3::from(way.light.color.map(f64::from));
            let (from, to_lamp, strength) = match way.light.shape {
                LightShape::Sun { direction } => {
                    let held = self.scene.bounds(way.light.sector);
                    let [min, max] = [held.min, held.max].map(|corner| DVec3::from(corner.map(f64::from)));
                    let here = way.lamp_from_here.transform_point3(point);
                    let far = 2.0 * (max - min).length() + 2.0 * here.distance(0.5 * (min + max)) + 1.0;
                    let onwards = DVec3::from(direction.map(f64::from)).normalize();
                    (here - onwards * far, -way.onwards, 1.0)
                }
                _ => {
                    let to_lamp = way.lamp - point;
                    let strength = way.light.falloff(to_lamp.length() / way.scale)
                        * way.light.cone(way.onwards.dot(-to_lamp.normalize()));
                    let from = DVec3::from(way.light.position.map(f64::from));
                    (from, to_lamp, strength)
                }
            };
            let strength = strength * normal.dot(to_lamp.normalize()).max(0.0);
            if strength > 0.0
                && let Some(line) = Line::through(self.scene, from, &way.chain, point)?
            {
                arrives(way, color * strength, &line)?;
            }
        }
        Ok(())
    }
}
