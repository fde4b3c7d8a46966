//! The scene graph: sectors connected by portals. Only this folder knows the target of each opening.
//!
//! A scene can be nested in another scene. Building the outer scene copies the sectors of the inner one into it, and
//! the inner scene's named exits become openings that portals can connect. So a look always traverses one flat graph,
//! however deeply scenes are nested: nesting costs nothing in a look, and one number names the sector of a passage.
//! Source: Boreskov, Using portals to create aggregate scenes; RenderWare, Portal culling.

mod builder;
mod edit;
mod error;
mod graph;
mod light;
mod locate;
mod portal;

pub use builder::{PortalEnd, SceneBuilder};
pub use edit::{Edit, EditError};
pub use error::{ErrorSubject, SceneError};
pub use light::{Light, LightShape};
pub use portal::Portal;

use crate::geom::{Aabb, Transform};
use crate::geometry::{Changes, Geometry};
use crate::ids::{ItemIndex, OpeningId, PortalId, SectorId};
use crate::method::{EditableSector, Method, UnsuitedMethod};
use crate::sector::{BuildStats, Sector};
use crate::threads;
use crate::view::View;
use locate::Boxes;
use std::collections::HashSet;
use std::sync::Arc;

/// Sectors connected by portals: the world that a [`Viewer`](crate::Viewer) looks at.
///
/// Build one with a [`SceneBuilder`]. Looks and queries take `&Scene`, so any number of threads can share it; changes
/// need `&mut Scene`. A clone shares the geometry and what the methods built.
#[doc(alias = "world")]
#[doc(alias = "scene graph")]
#[derive(Clone)]
pub struct Scene {
    sectors: Vec<SceneSector>,
    boxes: Boxes,
    portals: Vec<Portal>,
    flat: bool,
    lights: Vec<Light>,
    /// Memory limit per sector for what its method builds, in bytes.
    limit_bytes: u64,
    /// Openings that an outer scene can connect when this scene is nested in it.
    exits: Vec<Exit>,
}

/// A sector and its state in the scene.
#[derive(Clone)]
struct SceneSector {
    name: String,
    body: Body,
    /// Whether its box extends upwards (+Y) to infinity for [`Scene::locate`].
    open_above: bool,
    /// Number of times its method was built.
    builds: u64,
    /// The portal that leads out of each opening.
    portals: Vec<Option<PortalId>>,
    /// The changes of an edit in progress; empty between edits, but keeps its buffers.
    changes: Changes,
}

#[derive(Clone)]
enum Body {
    /// Geometry with a built-in method, which can be replaced.
    BuiltIn {
        method: Method,
        sector: Arc<dyn EditableSector>,
    },
    /// A sector implemented by the user.
    Custom(Arc<dyn Sector>),
    /// A sector that was removed; holds nothing.
    Removed(Arc<dyn EditableSector>),
}

/// A named opening of a scene, for use when the scene is nested.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Exit {
    name: String,
    sector: SectorId,
    opening: OpeningId,
}

impl Scene {
    /// Returns the number of sectors. [Removed](Scene::remove_sector) ones count, as empty sectors.
    pub fn sector_count(&self) -> usize {
        self.sectors.len()
    }

    /// Iterates over the ids of all sectors, in ascending order.
    pub fn sectors(&self) -> impl Iterator<Item = SectorId> + use<> {
        (0..self.sectors.len() as u32).map(SectorId)
    }

    /// Returns a sector as the trait object that computes its visibility.
    ///
    /// # Panics
    /// Panics if the scene has no sector `id`, as do the other methods of [`Scene`] that take a [`SectorId`].
    pub fn sector(&self, id: SectorId) -> &dyn Sector {
        self.sectors[id.0 as usize].sector()
    }

    /// Returns the name of a sector.
    pub fn sector_name(&self, id: SectorId) -> &str {
        &self.sectors[id.0 as usize].name
    }

    /// Returns the geometry of a sector; `None` for a custom or removed sector.
    pub fn geometry(&self, id: SectorId) -> Option<&Arc<Geometry>> {
        match &self.sectors[id.0 as usize].body {
            Body::BuiltIn { sector, .. } => Some(sector.geometry()),
            Body::Custom(_) | Body::Removed(_) => None,
        }
    }

    /// Returns the method of a sector; `None` for a custom or removed sector.
    pub fn method(&self, id: SectorId) -> Option<Method> {
        match &self.sectors[id.0 as usize].body {
            Body::BuiltIn { method, .. } => Some(*method),
            Body::Custom(_) | Body::Removed(_) => None,
        }
    }

    /// Returns all portals, indexed by [`PortalId`]. Removed ones stay in the list, closed: test with
    /// [`Scene::has_portal`].
    pub fn portals(&self) -> &[Portal] {
        &self.portals
    }

    /// Returns the portal that leads out of an opening; `None` if the opening has none.
    pub fn portal_of(&self, sector: SectorId, opening: OpeningId) -> Option<PortalId> {
        let portals = &self.sectors[sector.0 as usize].portals;
        portals.get(usize::from(opening.0)).copied().flatten()
    }

    /// Opens or closes a portal, in O(1); a removed one stays closed. A closed portal is opaque. A portal is one-way: the portal back, if there is
    /// one, keeps its state.
    pub fn set_open(&mut self, portal: PortalId, open: bool) {
        self.portals[portal.0 as usize].open = open && self.has_portal(portal);
    }

    /// Replaces the geometry of a sector and keeps its method. No other sector is rebuilt, so put geometry that changes
    /// every frame in a sector of its own. The number of openings must not change, but the openings may move; to change it,
    /// use [`Edit::add_opening`] and [`Edit::remove_opening`].
    ///
    /// Cost: that of building the method, which is negligible for [`Method::ZBuffer`] and [`Method::SBuffer`].
    ///
    /// # Errors
    /// Returns [`SceneError::CustomSector`], [`SceneError::RemovedSector`], [`SceneError::Openings`] or
    /// [`SceneError::Unsuited`], and leaves the sector unchanged.
    pub fn set_geometry(
        &mut self,
        id: SectorId,
        geometry: impl Into<Arc<Geometry>>,
    ) -> Result<(), SceneError> {
        let geometry = geometry.into();
        let (before, method) = self.editable(id)?;
        let [had, has] = [before, &geometry].map(|geometry| geometry.openings().len());
        if had != has {
            let sector = self.sector_name(id).to_owned();
            return Err(SceneError::Openings { sector, had, has });
        }
        self.rebuild(id, geometry, method)?;
        let space = self.sectors[id.0 as usize].space();
        self.boxes.change(id, space);
        Ok(())
    }

    /// Replaces the method of a sector. No other sector is rebuilt.
    ///
    /// # Errors
    /// Returns [`SceneError::CustomSector`], [`SceneError::RemovedSector`] or [`SceneError::Unsuited`], and leaves the
    /// sector unchanged.
    pub fn set_method(&mut self, id: SectorId, method: Method) -> Result<(), SceneError> {
        let (geometry, _) = self.editable(id)?;
        self.rebuild(id, Arc::clone(geometry), method)
    }

    fn editable(&self, id: SectorId) -> Result<(&Arc<Geometry>, Method), SceneError> {
        match &self.sectors[id.0 as usize].body {
            Body::BuiltIn { sector, method } => Ok((sector.geometry(), *method)),
            Body::Custom(_) => Err(SceneError::CustomSector(self.sector_name(id).to_owned())),
            Body::Removed(_) => Err(SceneError::RemovedSector(id.0)),
        }
    }

    fn rebuild(&mut self, id: SectorId, geometry: Arc<Geometry>, method: Method) -> Result<(), SceneError> {
        let placed = &mut self.sectors[id.0 as usize];
        let built = placed.rebuild(geometry, method, self.limit_bytes);
        built.map_err(|why| SceneError::unsuited(&placed.name, why))
    }

    /// Returns how many times the method of a sector was built, the first build included; 0 for a custom sector.
    pub fn builds(&self, id: SectorId) -> u64 {
        self.sectors[id.0 as usize].builds
    }

    /// Replaces the transform of a portal, in O(1). The sector behind it appears moved as a whole.
    ///
    /// # Errors
    /// Returns [`SceneError::NotSimilar`], [`SceneError::TooFar`] or [`SceneError::RemovedPortal`], and leaves the portal
    /// unchanged.
    pub fn set_portal(&mut self, portal: PortalId, there_from_here: Transform) -> Result<(), SceneError> {
        if !self.has_portal(portal) {
            return Err(SceneError::RemovedPortal(portal.0));
        }
        let mut moved = self.portals[portal.0 as usize].clone();
        moved.there_from_here = there_from_here;
        moved.check(portal.0 as usize, self.sector(moved.from).openings())?;
        self.portals[portal.0 as usize] = moved;
        Ok(())
    }

    /// Returns a copy of the scene in which all sectors but the custom ones use `method`. The copy shares the
    /// geometries.
    ///
    /// # Errors
    /// Returns the reason if a sector needs more than `limit_bytes` for what the method builds, or lacks what the method
    /// [requires](Method::requires).
    pub fn with_method(&self, method: Method, limit_bytes: u64) -> Result<Scene, UnsuitedMethod> {
        let mut scene = self.clone();
        scene.limit_bytes = limit_bytes;
        // Of sectors that share a geometry, the first builds the data that the others reuse; built in parallel, each
        // would build it again.
        let mut geometries = HashSet::new();
        let is_first = |placed: &&mut SceneSector| match &placed.body {
            Body::BuiltIn { sector, .. } => geometries.insert(Arc::as_ptr(sector.geometry())),
            Body::Custom(_) | Body::Removed(_) => false,
        };
        let (first, others): (Vec<_>, Vec<_>) = scene.sectors.iter_mut().partition(is_first);
        for sectors in [first, others] {
            let mut building: Vec<_> = sectors.into_iter().map(|placed| (placed, Ok(()))).collect();
            threads::for_each(&mut building, |_, (placed, built)| {
                if let Body::BuiltIn { sector, .. } = &placed.body {
                    *built = placed.rebuild(Arc::clone(sector.geometry()), method, limit_bytes);
                }
            });
            building.into_iter().try_for_each(|(_, built)| built)?;
        }
        Ok(scene)
    }

    /// Returns `true` if all sectors but the custom ones meet the requirements of a method ([`Method::suits`]).
    pub fn suits(&self, method: Method) -> bool {
        let mut geometries = self.sectors().filter_map(|id| self.geometry(id));
        geometries.all(|geometry| method.suits(geometry))
    }

    /// Returns a copy of the scene in which no portal is followed and openings are empty holes.
    #[must_use]
    pub fn without_portals(&self) -> Scene {
        Scene {
            flat: true,
            ..self.clone()
        }
    }

    /// Returns `true` if portals are ignored: the scene is one made by [`Scene::without_portals`].
    pub fn is_flat(&self) -> bool {
        self.flat
    }

    /// Returns the sector that contains a point: the smallest of those whose boxes contain it. If no box contains it,
    /// returns the sector with the nearest box. `None` only if the scene has no sectors.
    ///
    /// The box of a sector that is [open above](SceneBuilder::open_above) has no top, so a point on a roof or a balcony
    /// is in the garden. The smallest of several such boxes is the one with the smallest footprint.
    ///
    /// If the point is on the boundary of all boxes that contain it, as in a doorway where two boxes meet, returns the
    /// sector whose centre is farther along the viewing direction, from `point` to `toward`, so that the doorway is
    /// behind the eye.
    ///
    /// Cost: O(log sectors) where few boxes overlap.
    #[doc(alias = "point location")]
    pub fn locate<T: Into<f64>>(&self, point: [T; 3], toward: [T; 3]) -> Option<SectorId> {
        let around = self.boxes.locate(point.map(Into::into), toward.map(Into::into));
        around.or_else(|| self.sectors().find(|&id| self.has_sector(id)))
    }

    /// Returns the sector of a view: [`View::sector`] if it is set, else the one that contains the eye
    /// ([`Scene::locate`]). `None` if the scene has no sectors or not the one that the view names.
    pub fn sector_of(&self, view: &View) -> Option<SectorId> {
        match view.sector {
            Some(id) => ((id.0 as usize) < self.sectors.len()).then_some(id),
            None => self.locate(view.eye(), view.toward()),
        }
    }

    /// Returns `true` if [`SceneBuilder::open_above`] was called for a sector.
    pub fn is_open_above(&self, id: SectorId) -> bool {
        self.sectors[id.0 as usize].open_above
    }

    /// Returns the bounding box of a sector, in the space of the sector.
    pub fn bounds(&self, id: SectorId) -> Aabb {
        self.sector(id).bounds()
    }

    /// Returns the number of items in all sectors. An item that is in two sectors counts twice. For a custom sector,
    /// adds [`Sector::item_count`].
    pub fn item_count(&self) -> usize {
        let items = |id| match self.geometry(id) {
            Some(geometry) => geometry.item_count(),
            None => self.sector(id).item_count() as usize,
        };
        self.sectors().map(items).sum()
    }

    /// Returns the number of triangles in all sectors, counting every instance. For a custom sector, adds
    /// [`Sector::item_triangles`].
    pub fn triangle_count(&self) -> u64 {
        self.sectors().map(|id| self.triangles_of(id)).sum()
    }

    /// Returns the number of triangles in one sector, counting every instance.
    pub fn triangles_of(&self, id: SectorId) -> u64 {
        let own = self.sector(id);
        match self.geometry(id) {
            Some(geometry) => geometry.triangle_count(),
            None => (0..own.item_count())
                .map(|item| own.item_triangles(ItemIndex(item), &[]))
                .sum(),
        }
    }

    /// Returns the memory used by the geometries and by what the methods built, in bytes.
    pub fn bytes(&self) -> u64 {
        let sectors = self.sectors().map(|id| self.sector(id).bytes()).sum::<u64>();
        let of_openings: usize = self
            .sectors
            .iter()
            .map(|placed| size_of_val(&*placed.portals))
            .sum();
        let portals = size_of_val(&*self.portals) + of_openings;
        sectors + self.boxes.bytes() + portals as u64
    }

    /// Returns build statistics over all sectors: sums of the counts, and the depth of the deepest tree.
    pub fn build_stats(&self) -> BuildStats {
        self.sectors()
            .map(|id| self.sector(id).build_stats())
            .fold(BuildStats::default(), |sum, built| BuildStats {
                faces: sum.faces + built.faces,
                splits: sum.splits + built.splits,
                depth: sum.depth.max(built.depth),
            })
    }
}

impl SceneSector {
    fn sector(&self) -> &dyn Sector {
        match &self.body {
            Body::BuiltIn { sector, .. } => &**sector,
            Body::Custom(sector) => &**sector,
            Body::Removed(sector) => &**sector,
        }
    }

    /// Returns the box that [`Scene::locate`] uses.
    fn space(&self) -> Aabb {
        let mut space = self.sector().bounds();
        if self.open_above && !space.is_empty() {
            space.max[1] = f32::INFINITY;
        }
        space
    }

    /// Builds `method` for `geometry` and replaces both; on an error nothing changes.
    fn rebuild(
        &mut self,
        geometry: Arc<Geometry>,
        method: Method,
        limit_bytes: u64,
    ) -> Result<(), UnsuitedMethod> {
        let sector = method.build_editable(geometry, limit_bytes)?;
        self.body = Body::BuiltIn { method, sector };
        self.builds += 1;
        Ok(())
    }
}
