//! Adds and removes sectors and portals between looks.
//!
//! Ids of sectors and portals are never reused: what was removed leaves an empty place, so a stale id never names another
//! sector or portal. Cost: O(1) for a portal; O(log sectors) for a new sector, and that of building its method; O(portals)
//! to remove a sector.

use super::builder::{PendingSector, build_sector};
use super::{Body, ErrorSubject, Portal, Scene, SceneError, SceneSector};
use crate::geom::{Aabb, Transform};
use crate::geometry::{Geometry, GeometryBuilder, Opening};
use crate::ids::{OpeningId, PortalId, SectorId};
use crate::method::Method;
use crate::sector::Sector;
use std::sync::Arc;

impl Scene {
    /// Adds a sector with the given geometry and method, and returns its id. Nothing leads there until
    /// [`Scene::add_portal`] or [`Scene::add_door`] connects it; to give a sector that exists an opening for that, use
    /// [`Edit::add_opening`](crate::Edit::add_opening).
    ///
    /// ```
    /// # use enfilade::*;
    /// # let mut scene = enfilade_scenes::built_in("two-rooms").expect("a scene").scene;
    /// # let hall = SectorId(0);
    /// // A hole in the hall's floor, and the cellar that is seen through it.
    /// let hole = ConvexPolygon::rectangle([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0])?;
    /// let mut cellar = GeometryBuilder::new([]);
    /// let up = cellar.opening("up", hole.flipped());
    /// let cellar = scene.add_sector("cellar", cellar.build()?, Method::HierarchicalZ)?;
    /// let mut edit = scene.edit();
    /// let down = edit.add_opening(hall, "down", hole)?;
    /// edit.finish()?;
    /// scene.add_door((hall, down), (cellar, up))?;
    /// // Later:
    /// scene.remove_sector(cellar);
    /// scene.edit().remove_opening(hall, down)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Returns [`SceneError::Unsuited`] if the geometry does not meet the requirement of the method, or the method needs
    /// too much memory, and adds nothing.
    #[doc(alias = "streaming")]
    pub fn add_sector(
        &mut self,
        name: &str,
        geometry: impl Into<Arc<Geometry>>,
        method: Method,
    ) -> Result<SectorId, SceneError> {
        self.place(PendingSector::BuiltIn(name.to_owned(), geometry.into(), method))
    }

    /// Adds a custom sector, and returns its id.
    ///
    /// # Errors
    /// Returns [`SceneError::BadBounds`] and adds nothing.
    pub fn add_custom_sector(&mut self, name: &str, sector: Arc<dyn Sector>) -> Result<SectorId, SceneError> {
        self.place(PendingSector::Custom(name.to_owned(), sector))
    }

    fn place(&mut self, pending: PendingSector) -> Result<SectorId, SceneError> {
        let placed = build_sector(pending, self.limit_bytes)?;
        let id = SectorId(self.sectors.len() as u32);
        self.boxes.push(placed.space());
        self.sectors.push(placed);
        Ok(id)
    }

    /// Removes a sector with its items, openings and exits, and all portals into and out of it. Openings of other
    /// sectors that led there stay, as opaque faces. Returns `false` if it was removed before.
    ///
    /// It keeps its place as an empty sector without openings: [`Scene::sectors`] still lists it, and its id is not reused.
    /// A view from there is empty, and its lights reach nothing.
    pub fn remove_sector(&mut self, id: SectorId) -> bool {
        if !self.has_sector(id) {
            return false;
        }
        for portal in (0..self.portals.len() as u32).map(PortalId) {
            let ends = &self.portals[portal.0 as usize];
            if ends.from == id || ends.to == id {
                self.remove_portal(portal);
            }
        }
        self.exits.retain(|exit| exit.sector != id);
        self.sectors[id.0 as usize] = SceneSector::new(String::new(), removed());
        self.boxes.change(id, Aabb::EMPTY);
        true
    }

    /// Returns `true` if there is a sector with this id that was not removed.
    pub fn has_sector(&self, id: SectorId) -> bool {
        let placed = self.sectors.get(id.0 as usize);
        placed.is_some_and(|placed| !matches!(placed.body, Body::Removed(_)))
    }

    /// Declares whether a sector has no top; see [`SceneBuilder::open_above`](crate::SceneBuilder::open_above).
    pub fn set_open_above(&mut self, id: SectorId, open_above: bool) {
        let placed = &mut self.sectors[id.0 as usize];
        placed.open_above = open_above;
        self.boxes.change(id, placed.space());
    }

    /// Adds a one-way portal that leads out of an opening into the sector `to`, and returns its id. `there_from_here` maps
    /// the space of the first sector to that of the second: rigid, uniformly scaling or reflecting. For a mirror, pass
    /// [`Transform::reflection`] and the same sector.
    ///
    /// # Errors
    /// Returns the errors of portals in [`SceneBuilder::build`](crate::SceneBuilder::build), or
    /// [`SceneError::RemovedSector`], and adds nothing.
    pub fn add_portal(
        &mut self,
        from: (SectorId, OpeningId),
        to: SectorId,
        there_from_here: Transform,
    ) -> Result<PortalId, SceneError> {
        let id = PortalId(self.portals.len() as u32);
        let subject = ErrorSubject::Portal(id.0 as usize);
        self.check_end(&subject, to, None)?;
        self.check_end(&subject, from.0, Some(from.1))?;
        let placed = &mut self.sectors[from.0.0 as usize];
        let portal = Portal {
            from: from.0,
            opening: from.1,
            to,
            there_from_here,
            open: true,
        };
        portal.check(id.0 as usize, placed.openings())?;
        placed.connect(from.1, id, |PortalId(portal)| {
            ErrorSubject::Portal(portal as usize)
        })?;
        self.portals.push(portal);
        Ok(id)
    }

    /// Adds two portals, one each way, between two openings of sectors that share a coordinate space; see
    /// [`SceneBuilder::door`](crate::SceneBuilder::door). Returns the one out of `a`, then the one out of `b`.
    ///
    /// # Errors
    /// As [`Scene::add_portal`], or [`SceneError::DoorFacesOneWay`], and adds nothing.
    pub fn add_door(
        &mut self,
        a: (SectorId, OpeningId),
        b: (SectorId, OpeningId),
    ) -> Result<[PortalId; 2], SceneError> {
        let subject = ErrorSubject::Portal(self.portals.len());
        for (sector, opening) in [a, b] {
            self.check_end(&subject, sector, Some(opening))?;
        }
        let opening = |(sector, opening): (SectorId, OpeningId)| {
            &self.sector(sector).openings()[usize::from(opening.0)]
        };
        check_door(opening(a), opening(b))?;
        let out = self.add_portal(a, b.0, Transform::IDENTITY)?;
        match self.add_portal(b, a.0, Transform::IDENTITY) {
            Ok(back) => Ok([out, back]),
            Err(why) => {
                self.remove_portal(out);
                self.portals.pop();
                Err(why)
            }
        }
    }

    /// Removes a portal. Its opening stays, as an opaque face: to remove that too, use
    /// [`Edit::remove_opening`](crate::Edit::remove_opening). Returns `false` if it was removed before.
    ///
    /// It keeps its place in [`Scene::portals`], closed, and its id is not reused.
    pub fn remove_portal(&mut self, id: PortalId) -> bool {
        if !self.has_portal(id) {
            return false;
        }
        let portal = &mut self.portals[id.0 as usize];
        portal.open = false;
        self.sectors[portal.from.0 as usize].portals[usize::from(portal.opening.0)] = None;
        true
    }

    /// Returns `true` if there is a portal with this id that was not removed.
    pub fn has_portal(&self, id: PortalId) -> bool {
        let portal = self.portals.get(id.0 as usize);
        portal.is_some_and(|portal| self.portal_of(portal.from, portal.opening) == Some(id))
    }

    /// Checks that a sector and, if given, its opening exist.
    fn check_end(
        &self,
        subject: &ErrorSubject,
        sector: SectorId,
        opening: Option<OpeningId>,
    ) -> Result<(), SceneError> {
        let Some(placed) = self.sectors.get(sector.0 as usize) else {
            return Err(SceneError::NoSuchSector {
                subject: subject.clone(),
                sector: sector.0,
                sectors: self.sectors.len(),
            });
        };
        if matches!(placed.body, Body::Removed(_)) {
            return Err(SceneError::RemovedSector(sector.0));
        }
        placed.check_opening(subject, opening)
    }

    /// Follows the changes of openings in an edit: portals keep their openings, and those of removed ones are removed.
    pub(super) fn follow_openings(&mut self, sector: SectorId) {
        let placed = &mut self.sectors[sector.0 as usize];
        let Some(change) = placed.changes.openings() else {
            return;
        };
        let before = std::mem::take(&mut placed.portals);
        let was = |id: &Option<OpeningId>| id.and_then(|id| before[usize::from(id.0)]);
        placed.portals = change.ids_before.iter().map(was).collect();
        for &portal in before.iter().flatten() {
            let now = placed.portals.iter().position(|&led| led == Some(portal));
            let portal = &mut self.portals[portal.0 as usize];
            match now {
                Some(now) => portal.opening = OpeningId(now as u16),
                None => portal.open = false,
            }
        }
        let ids_before = &change.ids_before;
        self.exits.retain_mut(|exit| {
            if exit.sector != sector {
                return true;
            }
            let now = ids_before.iter().position(|&id| id == Some(exit.opening));
            exit.opening = OpeningId(now.unwrap_or(0) as u16);
            now.is_some()
        });
    }
}

/// Checks that two openings can be the two sides of a door.
pub(super) fn check_door(a: &Opening, b: &Opening) -> Result<(), SceneError> {
    if a.outline.normal_f64().dot(b.outline.normal_f64()) > 0.0 {
        return Err(SceneError::DoorFacesOneWay(a.name.clone(), b.name.clone()));
    }
    Ok(())
}

/// Returns what a removed sector leaves: a sector without items and openings.
fn removed() -> Body {
    let empty = GeometryBuilder::default().build().ok();
    let built = empty.and_then(|empty| Method::Masked.build_editable(Arc::new(empty), u64::MAX).ok());
    match built {
        Some(sector) => Body::Removed(sector),
        None => unreachable!("empty geometry suits every method that is always there"),
    }
}
