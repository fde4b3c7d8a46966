//! Puts a scene together, and refuses one that cannot be.

use super::locate::Boxes;
use super::{
    Body, ErrorSubject, Exit, Light, LightId, Placed, Portal, PortalId, Scene, SceneError, SectorId,
};
use crate::geom::{Transform, is_in_range};
use crate::geometry::{Geometry, Opening, OpeningId};
use crate::method::Method;
use crate::sector::Sector;
use std::sync::Arc;

/// Gathers sectors and portals; [`SceneBuilder::build`] checks them.
#[derive(Default)]
pub struct SceneBuilder {
    sectors: Vec<Waiting>,
    nested: Vec<Scene>,
    portals: Vec<(PortalEnd, PortalEnd, Transform)>,
    exits: Vec<(String, PortalEnd)>,
    lights: Vec<Light>,
    open_above: Vec<SectorId>,
    limit_bytes: Option<u64>,
}

enum Waiting {
    BuiltIn(String, Arc<Geometry>, Method),
    Custom(String, Arc<dyn Sector>),
}

/// A scene that stands in another, by the order of [`SceneBuilder::nest`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NestedId(u32);

/// One end of a portal: an opening of a sector, a named exit of a nested scene, or anywhere in a sector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PortalEnd {
    /// An opening of a sector of this scene.
    Opening(SectorId, OpeningId),
    /// An exit of a scene that stands in this one.
    Exit(NestedId, String),
    /// Anywhere in a sector of this scene, as its portal's transform says: a portal may lead there, as a teleport does,
    /// but not out of it.
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

impl SceneBuilder {
    /// Starts with nothing.
    pub fn new() -> SceneBuilder {
        SceneBuilder::default()
    }

    /// What one sector's method may build, in bytes; [`Method::DEFAULT_LIMIT`] unless told.
    pub fn limit_bytes(&mut self, limit: u64) {
        self.limit_bytes = Some(limit);
    }

    /// Adds geometry as a sector that `method` sees.
    pub fn add(&mut self, name: &str, geometry: impl Into<Arc<Geometry>>, method: Method) -> SectorId {
        self.sectors
            .push(Waiting::BuiltIn(name.to_owned(), geometry.into(), method));
        SectorId(self.sectors.len() as u32 - 1)
    }

    /// Adds a sector of one's own.
    pub fn add_custom(&mut self, name: &str, sector: Arc<dyn Sector>) -> SectorId {
        self.sectors.push(Waiting::Custom(name.to_owned(), sector));
        SectorId(self.sectors.len() as u32 - 1)
    }

    /// Lets a scene stand in this one. It is entered and left through its exits only.
    pub fn nest(&mut self, scene: &Scene) -> NestedId {
        self.nested.push(scene.clone());
        NestedId(self.nested.len() as u32 - 1)
    }

    /// One way out of `from`, into the sector that `to` is an opening of.
    pub fn portal(
        &mut self,
        from: impl Into<PortalEnd>,
        to: impl Into<PortalEnd>,
        there_from_here: Transform,
    ) -> &mut Self {
        self.portals.push((from.into(), to.into(), there_from_here));
        self
    }

    /// Two portals between two openings at one place, in sectors that share their space.
    pub fn door(&mut self, a: impl Into<PortalEnd>, b: impl Into<PortalEnd>) -> &mut Self {
        let (a, b) = (a.into(), b.into());
        self.portal(a.clone(), b.clone(), Transform::IDENTITY)
            .portal(b, a, Transform::IDENTITY)
    }

    /// A portal back into the sector of `opening` that reflects in the opening's plane. An opening that is not
    /// there is reported by [`SceneBuilder::build`].
    pub fn mirror(&mut self, sector: SectorId, opening: OpeningId) -> &mut Self {
        let outline = match self.sectors.get(sector.0 as usize) {
            Some(Waiting::BuiltIn(_, geometry, _)) => {
                geometry.openings().get(opening.0 as usize).map(|o| &o.outline)
            }
            Some(Waiting::Custom(_, own)) => own.openings().get(opening.0 as usize).map(|o| &o.outline),
            None => None,
        };
        let reflection = outline.map_or(Transform::IDENTITY, |outline| {
            Transform::reflection(outline.corners()[0], outline.normal())
        });
        self.portal((sector, opening), (sector, opening), reflection)
    }

    /// Names an opening through which one leaves this scene when it stands in another.
    pub fn exit(&mut self, name: &str, from: impl Into<PortalEnd>) -> &mut Self {
        self.exits.push((name.to_owned(), from.into()));
        self
    }

    /// Hangs up a lamp in a sector of this scene.
    pub fn light(&mut self, light: Light) -> LightId {
        self.lights.push(light);
        LightId(self.lights.len() as u32 - 1)
    }

    /// States that a sector has no top, as a garden or a courtyard: [`Scene::locate`] extends its box upwards (+Y) without end.
    /// Affects nothing else.
    pub fn open_above(&mut self, sector: SectorId) -> &mut Self {
        self.open_above.push(sector);
        self
    }

    /// Builds every sector's method and joins everything.
    ///
    /// # Errors
    /// One [`SceneError`] for the first broken rule.
    pub fn build(self) -> Result<Scene, SceneError> {
        let limit = self.limit_bytes.unwrap_or(Method::DEFAULT_LIMIT);
        let custom_sectors = self.sectors.len();
        let mut sectors = Vec::with_capacity(custom_sectors);
        for waiting in self.sectors {
            sectors.push(place(waiting, limit)?);
        }
        for id in self.open_above {
            let placed = sectors.get_mut(id.0 as usize);
            let placed = placed.ok_or(SceneError::NoSuchSector {
                subject: ErrorSubject::OpenAbove,
                sector: id.0,
                sectors: custom_sectors,
            })?;
            placed.open_above = true;
        }
        let mut joined = Joined {
            custom_sectors,
            sectors,
            portals: Vec::new(),
            lights: Vec::new(),
            scenes: Vec::new(),
        };
        for (number, light) in self.lights.into_iter().enumerate() {
            if !light.is_sound() || light.sector.0 as usize >= custom_sectors {
                return Err(SceneError::BadLight(number));
            }
            joined.lights.push(light);
        }
        for scene in self.nested {
            joined.take_in(scene);
        }
        let taken_in = joined.portals.len();
        for (number, (from, to, there_from_here)) in self.portals.into_iter().enumerate() {
            if !there_from_here.is_similarity() {
                return Err(SceneError::NotSimilar(number));
            }
            let subject = ErrorSubject::Portal(number);
            let (from, opening) = joined.resolve_opening(&subject, &from)?;
            let (to, _) = joined.resolve(&subject, &to)?;
            let portal = Portal {
                from,
                opening,
                to,
                there_from_here,
                open: true,
            };
            if !portal.leads_in_range(&joined.sectors[from.0 as usize].openings()[usize::from(opening.0)]) {
                return Err(SceneError::TooFar(number));
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
        joined.finish(taken_in, exits, limit)
    }
}

fn place(waiting: Waiting, limit: u64) -> Result<Placed, SceneError> {
    Ok(match waiting {
        Waiting::Custom(name, sector) => {
            let bounds = sector.bounds();
            // A sky may reach to infinity.
            let is_sound = |side: f32| side.is_infinite() || is_in_range(side);
            if !bounds.min.into_iter().chain(bounds.max).all(is_sound) {
                return Err(SceneError::BadBounds(name));
            }
            Placed {
                name,
                body: Body::Custom(sector),
                open_above: false,
                builds: 0,
            }
        }
        Waiting::BuiltIn(name, geometry, method) => {
            let built = method.build_editable(geometry, limit);
            let sector = built.map_err(|why| SceneError::unsuited(&name, why))?;
            Placed {
                name,
                body: Body::BuiltIn { method, sector },
                open_above: false,
                builds: 1,
            }
        }
    })
}

/// The flat graph that nested scenes are taken into.
struct Joined {
    custom_sectors: usize,
    sectors: Vec<Placed>,
    portals: Vec<Portal>,
    lights: Vec<Light>,
    scenes: Vec<Vec<Exit>>,
}

impl Joined {
    fn take_in(&mut self, scene: Scene) {
        let shift = self.sectors.len() as u32;
        let moved = |id: SectorId| SectorId(id.0 + shift);
        self.portals.extend(scene.portals.into_iter().map(|p| Portal {
            from: moved(p.from),
            to: moved(p.to),
            ..p
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
        if sector.0 as usize >= self.custom_sectors {
            return Err(SceneError::NoSuchSector {
                subject: subject.clone(),
                sector: sector.0,
                sectors: self.custom_sectors,
            });
        }
        let placed = &self.sectors[sector.0 as usize];
        let openings = placed.openings().len();
        if let Some(opening) = opening.filter(|opening| usize::from(opening.0) >= openings) {
            let sector = placed.name.clone();
            return Err(SceneError::NoSuchOpening {
                subject: subject.clone(),
                sector,
                opening: opening.0,
                openings,
            });
        }
        Ok((sector, opening))
    }

    fn finish(self, taken_in: usize, exits: Vec<Exit>, limit_bytes: u64) -> Result<Scene, SceneError> {
        let mut first_opening = vec![0];
        for placed in &self.sectors {
            first_opening.push(first_opening[first_opening.len() - 1] + placed.openings().len() as u32);
        }
        let mut portal_of: Vec<Option<PortalId>> = vec![None; first_opening[self.sectors.len()] as usize];
        let subject = |number: usize| {
            number
                .checked_sub(taken_in)
                .map_or(ErrorSubject::PortalWithin, ErrorSubject::Portal)
        };
        for (number, portal) in self.portals.iter().enumerate() {
            let slot = first_opening[portal.from.0 as usize] as usize + usize::from(portal.opening.0);
            if let Some(first) = portal_of[slot].replace(PortalId(number as u32)) {
                let placed = &self.sectors[portal.from.0 as usize];
                return Err(SceneError::TwoPortals {
                    first: subject(first.0 as usize),
                    second: subject(number),
                    opening: placed.openings()[usize::from(portal.opening.0)].name.clone(),
                    sector: placed.name.clone(),
                });
            }
        }
        let boxes = self.sectors.iter().map(Placed::space).collect();
        Ok(Scene {
            boxes: Boxes::new(boxes),
            sectors: self.sectors,
            portals: self.portals,
            portal_of,
            first_opening,
            flat: false,
            lights: self.lights,
            limit_bytes,
            exits,
        })
    }
}

impl Placed {
    fn openings(&self) -> &[Opening] {
        self.sector().openings()
    }
}
