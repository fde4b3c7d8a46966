//! Builds a scene from sectors and portals, and validates it.

use super::graph::check_door;
use super::locate::Boxes;
use super::{Body, ErrorSubject, Exit, Light, Portal, Scene, SceneError, SceneSector};
use crate::geom::{Transform, is_in_range};
use crate::geometry::{Changes, Geometry, Opening};
use crate::ids::{LightId, NestedId, OpeningId, PortalId, SectorId};
use crate::method::Method;
use crate::sector::Sector;
use std::sync::Arc;

/// Builder for a [`Scene`]: collects sectors, portals and lights, which [`SceneBuilder::build`] checks and connects.
///
/// ```
/// use enfilade::*;
///
/// let doorway = ConvexPolygon::rectangle([-0.5, 0.0, -3.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0])?;
/// let [mut hall, mut study] = [(); 2].map(|()| GeometryBuilder::new([]));
/// let [out, back] = [hall.opening("out", doorway.clone()), study.opening("back", doorway.flipped())];
/// let mut scene = SceneBuilder::new();
/// let hall = scene.add("hall", hall.build()?, Method::ZBuffer);
/// let study = scene.add("study", study.build()?, Method::HierarchicalZ);
/// scene.door((hall, out), (study, back));
/// assert_eq!(scene.build()?.portals().len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "world builder")]
#[derive(Default)]
pub struct SceneBuilder {
    sectors: Vec<PendingSector>,
    nested: Vec<Scene>,
    portals: Vec<(PortalEnd, PortalEnd, Transform)>,
    /// The portals out of the first openings of doors, by their index; the next portal leads back.
    doors: Vec<usize>,
    exits: Vec<(String, PortalEnd)>,
    lights: Vec<Light>,
    open_above: Vec<SectorId>,
    limit_bytes: Option<u64>,
}

pub(super) enum PendingSector {
    BuiltIn(String, Arc<Geometry>, Method),
    Custom(String, Arc<dyn Sector>),
}

/// One end of a portal: an opening of a sector, a named exit of a nested scene, or any position in a sector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortalEnd {
    /// An opening of a sector of this scene.
    Opening(SectorId, OpeningId),
    /// A named exit of a scene that is nested in this one.
    Exit(NestedId, String),
    /// A position in a sector of this scene, given by the portal's transform. A portal may lead there, as a teleporter
    /// does, but not start there.
    Anywhere(SectorId),
}

impl From<(SectorId, OpeningId)> for PortalEnd {
    fn from((sector, opening): (SectorId, OpeningId)) -> PortalEnd {
        PortalEnd::Opening(sector, opening)
    }
}

impl From<SectorId> for PortalEnd {
    fn from(sector: SectorId) -> PortalEnd {
        PortalEnd::Anywhere(sector)
    }
}

impl From<(NestedId, &str)> for PortalEnd {
    fn from((scene, exit): (NestedId, &str)) -> PortalEnd {
        PortalEnd::Exit(scene, exit.to_owned())
    }
}

impl Scene {
    /// Builds a scene of one sector, called "scene", without portals.
    ///
    /// # Errors
    /// Returns the errors of [`SceneBuilder::build`]: the geometry may not meet the requirement of the method, or the
    /// method may need too much memory.
    pub fn single(geometry: impl Into<Arc<Geometry>>, method: Method) -> Result<Scene, SceneError> {
        let mut scene = SceneBuilder::new();
        scene.add("scene", geometry, method);
        scene.build()
    }
}

impl SceneBuilder {
    /// Creates an empty builder.
    pub fn new() -> SceneBuilder {
        SceneBuilder::default()
    }

    /// Sets the memory limit per sector for what its method builds, in bytes. Default: [`Method::DEFAULT_LIMIT`].
    pub fn limit_bytes(&mut self, limit: u64) {
        self.limit_bytes = Some(limit);
    }

    /// Adds a sector with the given geometry and method. Names need not be unique. Returns its id.
    pub fn add(&mut self, name: &str, geometry: impl Into<Arc<Geometry>>, method: Method) -> SectorId {
        self.sectors
            .push(PendingSector::BuiltIn(name.to_owned(), geometry.into(), method));
        SectorId(self.sectors.len() as u32 - 1)
    }

    /// Adds a custom sector: a user-defined implementation of [`Sector`]. Returns its id.
    pub fn add_custom(&mut self, name: &str, sector: Arc<dyn Sector>) -> SectorId {
        self.sectors.push(PendingSector::Custom(name.to_owned(), sector));
        SectorId(self.sectors.len() as u32 - 1)
    }

    /// Nests a copy of a built scene in this one. Portals can connect it through its named exits only.
    pub fn nest(&mut self, scene: &Scene) -> NestedId {
        self.nested.push(scene.clone());
        NestedId(self.nested.len() as u32 - 1)
    }

    /// Adds a one-way portal that leads out of `from` into the sector of `to`. `there_from_here` maps the space of
    /// `from` to the space of `to`: rigid, uniformly scaling or reflecting.
    ///
    /// The portal gets its id in [`SceneBuilder::build`], after those of nested scenes; [`Scene::portal_of`] returns
    /// it.
    #[doc(alias = "portal link")]
    #[doc(alias = "teleporter")]
    pub fn portal(
        &mut self,
        from: impl Into<PortalEnd>,
        to: impl Into<PortalEnd>,
        there_from_here: Transform,
    ) -> &mut Self {
        self.portals.push((from.into(), to.into(), there_from_here));
        self
    }

    /// Adds two portals, one each way, between two coincident openings of sectors that share a coordinate space.
    ///
    /// [`SceneBuilder::build`] checks that both openings exist, that no other portal leads out of them, and that they face
    /// opposite ways ([`ConvexPolygon::flipped`]). It does not check that their outlines coincide: if they do not, the door
    /// leads to another part of the other sector.
    ///
    /// [`ConvexPolygon::flipped`]: crate::ConvexPolygon::flipped
    #[doc(alias = "doorway")]
    pub fn door(&mut self, a: impl Into<PortalEnd>, b: impl Into<PortalEnd>) -> &mut Self {
        let (a, b) = (a.into(), b.into());
        self.doors.push(self.portals.len());
        self.portal(a.clone(), b.clone(), Transform::IDENTITY)
            .portal(b, a, Transform::IDENTITY)
    }

    /// Adds a portal from an opening back into its own sector, reflected in the plane of the opening.
    /// [`SceneBuilder::build`] reports an opening that does not exist.
    pub fn mirror(&mut self, sector: SectorId, opening: OpeningId) -> &mut Self {
        let outline = match self.sectors.get(sector.0 as usize) {
            Some(PendingSector::BuiltIn(_, geometry, _)) => {
                geometry.openings().get(opening.0 as usize).map(|o| &o.outline)
            }
            Some(PendingSector::Custom(_, custom)) => {
                custom.openings().get(opening.0 as usize).map(|o| &o.outline)
            }
            None => None,
        };
        let reflection = outline.map_or(Transform::IDENTITY, |outline| {
            Transform::reflection(outline.corners()[0], outline.normal())
        });
        self.portal((sector, opening), (sector, opening), reflection)
    }

    /// Names an opening as an exit: an outer scene in which this one is nested can connect it. Names must be unique.
    pub fn exit(&mut self, name: &str, from: impl Into<PortalEnd>) -> &mut Self {
        self.exits.push((name.to_owned(), from.into()));
        self
    }

    /// Adds a light to a sector of this scene. Returns its id.
    pub fn light(&mut self, light: Light) -> LightId {
        self.lights.push(light);
        LightId(self.lights.len() as u32 - 1)
    }

    /// Declares that a sector has no top, as a garden or a courtyard: [`Scene::locate`] extends its box upwards (+Y) to
    /// infinity. Affects nothing else.
    pub fn open_above(&mut self, sector: SectorId) -> &mut Self {
        self.open_above.push(sector);
        self
    }

    /// Builds the method of every sector and connects the portals.
    ///
    /// Of a portal it checks that its sectors and openings exist, that its transform is a similarity and keeps the
    /// opening within [`MAX_COORDINATE`](crate::MAX_COORDINATE), that no other portal leads out of the opening, and that
    /// the openings of a door face opposite ways.
    /// Of a custom sector it checks the bounds.
    ///
    /// # Errors
    /// Returns a [`SceneError`] for the first rule that is broken.
    pub fn build(self) -> Result<Scene, SceneError> {
        let limit = self.limit_bytes.unwrap_or(Method::DEFAULT_LIMIT);
        let direct_sectors = self.sectors.len();
        let mut sectors = Vec::with_capacity(direct_sectors);
        for pending in self.sectors {
            sectors.push(build_sector(pending, limit)?);
        }
        for id in self.open_above {
            let placed = sectors.get_mut(id.0 as usize);
            let placed = placed.ok_or(SceneError::NoSuchSector {
                subject: ErrorSubject::OpenAbove,
                sector: id.0,
                sectors: direct_sectors,
            })?;
            placed.open_above = true;
        }
        let mut joined = FlatGraph {
            direct_sectors,
            sectors,
            portals: Vec::new(),
            lights: Vec::new(),
            scenes: Vec::new(),
        };
        for (number, light) in self.lights.into_iter().enumerate() {
            if !light.is_sound() || light.sector.0 as usize >= direct_sectors {
                return Err(SceneError::BadLight(number));
            }
            joined.lights.push(light);
        }
        for scene in self.nested {
            joined.append(scene);
        }
        let nested_portals = joined.portals.len();
        for (number, (from, to, there_from_here)) in self.portals.into_iter().enumerate() {
            let subject = ErrorSubject::Portal(number);
            let (from, opening) = joined.resolve_opening(&subject, &from)?;
            let (to, end) = joined.resolve(&subject, &to)?;
            let portal = Portal {
                from,
                opening,
                to,
                there_from_here,
                open: true,
            };
            let openings = joined.sectors[from.0 as usize].openings();
            portal.check(number, openings)?;
            if let Some(end) = end.filter(|_| self.doors.binary_search(&number).is_ok()) {
                let there = joined.sectors[to.0 as usize].openings();
                check_door(&openings[usize::from(opening.0)], &there[usize::from(end.0)])?;
            }
            joined.portals.push(portal);
        }
        let mut exits = Vec::new();
        for (name, from) in self.exits {
            let subject = ErrorSubject::Exit(name.clone());
            if exits.iter().any(|exit: &Exit| exit.name == name) {
                return Err(SceneError::TwoExits(name));
            }
            let (sector, opening) = joined.resolve_opening(&subject, &from)?;
            exits.push(Exit {
                name,
                sector,
                opening,
            });
        }
        joined.finish(nested_portals, exits, limit)
    }
}

pub(super) fn build_sector(pending: PendingSector, limit: u64) -> Result<SceneSector, SceneError> {
    Ok(match pending {
        PendingSector::Custom(name, sector) => {
            let bounds = sector.bounds();
            // The bounds of a sky may be infinite.
            let is_sound = |side: f32| side.is_infinite() || is_in_range(side);
            if !bounds.min.into_iter().chain(bounds.max).all(is_sound) {
                return Err(SceneError::BadBounds(name));
            }
            SceneSector::new(name, Body::Custom(sector))
        }
        PendingSector::BuiltIn(name, geometry, method) => {
            let built = method.build_editable(geometry, limit);
            let sector = built.map_err(|why| SceneError::unsuited(&name, why))?;
            SceneSector::new(name, Body::BuiltIn { method, sector })
        }
    })
}

/// The flat graph of sectors and portals into which nested scenes are copied.
struct FlatGraph {
    direct_sectors: usize,
    sectors: Vec<SceneSector>,
    portals: Vec<Portal>,
    lights: Vec<Light>,
    scenes: Vec<Vec<Exit>>,
}

impl FlatGraph {
    fn append(&mut self, scene: Scene) {
        let shift = self.sectors.len() as u32;
        let moved = |id: SectorId| SectorId(id.0 + shift);
        let kept = (0..)
            .map(PortalId)
            .zip(&scene.portals)
            .filter(|&(id, _)| scene.has_portal(id));
        self.portals.extend(kept.map(|(_, portal)| Portal {
            from: moved(portal.from),
            to: moved(portal.to),
            ..portal.clone()
        }));
        self.scenes.push(
            scene
                .exits
                .into_iter()
                .map(|exit| Exit {
                    sector: moved(exit.sector),
                    ..exit
                })
                .collect(),
        );
        self.lights.extend(scene.lights.into_iter().map(|light| Light {
            sector: moved(light.sector),
            ..light
        }));
        self.sectors.extend(scene.sectors);
    }

    fn resolve_opening(
        &self,
        subject: &ErrorSubject,
        end: &PortalEnd,
    ) -> Result<(SectorId, OpeningId), SceneError> {
        let (sector, opening) = self.resolve(subject, end)?;
        let opening = opening.ok_or_else(|| SceneError::NoOpening(subject.clone()))?;
        Ok((sector, opening))
    }

    fn resolve(
        &self,
        subject: &ErrorSubject,
        end: &PortalEnd,
    ) -> Result<(SectorId, Option<OpeningId>), SceneError> {
        let (sector, opening) = match end {
            PortalEnd::Anywhere(sector) => (*sector, None),
            PortalEnd::Opening(sector, opening) => (*sector, Some(*opening)),
            PortalEnd::Exit(scene, name) => {
                let exits = self.scenes.get(scene.0 as usize).map_or(&[][..], Vec::as_slice);
                let found = exits.iter().find(|exit| exit.name == *name);
                let exit = found.ok_or_else(|| SceneError::NoSuchExit {
                    subject: subject.clone(),
                    exit: name.clone(),
                    exits: exits.iter().map(|exit| exit.name.clone()).collect(),
                })?;
                return Ok((exit.sector, Some(exit.opening)));
            }
        };
        if sector.0 as usize >= self.direct_sectors {
            return Err(SceneError::NoSuchSector {
                subject: subject.clone(),
                sector: sector.0,
                sectors: self.direct_sectors,
            });
        }
        self.sectors[sector.0 as usize].check_opening(subject, opening)?;
        Ok((sector, opening))
    }

    fn finish(
        mut self,
        nested_portals: usize,
        exits: Vec<Exit>,
        limit_bytes: u64,
    ) -> Result<Scene, SceneError> {
        let subject = |PortalId(number): PortalId| {
            let added = (number as usize).checked_sub(nested_portals);
            added.map_or(ErrorSubject::PortalWithin, ErrorSubject::Portal)
        };
        for placed in &mut self.sectors {
            // Those of nested scenes have the ids that they had there.
            placed.portals.fill(None);
        }
        for (id, portal) in (0..).map(PortalId).zip(&self.portals) {
            self.sectors[portal.from.0 as usize].connect(portal.opening, id, subject)?;
        }
        let boxes = self.sectors.iter().map(SceneSector::space).collect();
        Ok(Scene {
            boxes: Boxes::new(boxes),
            sectors: self.sectors,
            portals: self.portals,
            flat: false,
            lights: self.lights,
            limit_bytes,
            exits,
        })
    }
}

impl SceneSector {
    pub(super) fn new(name: String, body: Body) -> SceneSector {
        let mut placed = SceneSector {
            name,
            open_above: false,
            builds: u64::from(matches!(body, Body::BuiltIn { .. })),
            body,
            portals: Vec::new(),
            changes: Changes::default(),
        };
        placed.portals = vec![None; placed.openings().len()];
        placed
    }

    pub(super) fn openings(&self) -> &[Opening] {
        self.sector().openings()
    }

    /// Checks that an opening exists.
    pub(super) fn check_opening(
        &self,
        subject: &ErrorSubject,
        opening: Option<OpeningId>,
    ) -> Result<(), SceneError> {
        let openings = self.openings().len();
        match opening.filter(|opening| usize::from(opening.0) >= openings) {
            Some(opening) => Err(SceneError::NoSuchOpening {
                subject: subject.clone(),
                sector: self.name.clone(),
                opening: opening.0,
                openings,
            }),
            None => Ok(()),
        }
    }

    /// Lets a portal lead out of an opening. `subject` names portals in the error.
    pub(super) fn connect(
        &mut self,
        opening: OpeningId,
        portal: PortalId,
        subject: impl Fn(PortalId) -> ErrorSubject,
    ) -> Result<(), SceneError> {
        let number = usize::from(opening.0);
        if let Some(first) = self.portals[number] {
            return Err(SceneError::TwoPortals {
                first: subject(first),
                second: subject(portal),
                opening: self.openings()[number].name.clone(),
                sector: self.name.clone(),
            });
        }
        self.portals[number] = Some(portal);
        Ok(())
    }
}
