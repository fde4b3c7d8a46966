//! The aggregate: sectors joined by portals. Only this folder knows where openings lead.
//!
//! A scene can stand in another like a sector: its sectors become the outer scene's when that is built, its
//! named exits become openings to join. So a look follows one flat graph, however deeply scenes are nested.
//! Source: Boreskov, Using portals to create aggregate scenes; RenderWare, Portal culling.

mod builder;
mod edit;
mod error;
mod light;
mod locate;
mod portal;

pub use builder::{NestedId, PortalEnd, SceneBuilder};
pub use edit::{Edit, EditError};
pub use error::{ErrorSubject, SceneError};
pub use light::{Light, LightId, LightShape};
pub use portal::{Portal, PortalId, SectorId};

use crate::geom::{Aabb, Transform};
use crate::geometry::{Geometry, ItemId, OpeningId};
use crate::method::{EditableSector, Method, Unsuited};
use crate::sector::{BuildStats, Sector};
use crate::threads;
use crate::view::View;
use locate::Boxes;
use std::collections::HashSet;
use std::sync::Arc;

/// Sectors, and portals that join them. Shared and immutable while looked at.
#[derive(Clone)]
pub struct Scene {
    sectors: Vec<Placed>,
    boxes: Boxes,
    portals: Vec<Portal>,
    /// The portal of each opening, sector after sector; `first_opening` says where a sector's begin.
    portal_of: Vec<Option<PortalId>>,
    first_opening: Vec<u32>,
    flat: bool,
    lights: Vec<Light>,
    /// What one sector's method may build, in bytes.
    limit_bytes: u64,
    /// Openings through which one leaves the scene, when it stands in another.
    exits: Vec<Exit>,
}

/// A sector in a scene.
#[derive(Clone)]
struct Placed {
    name: String,
    body: Body,
    /// It has no top: its box goes up without end.
    open_above: bool,
    /// How often its method was built.
    builds: u64,
}

#[derive(Clone)]
enum Body {
    /// Geometry seen by a method of ours; the method can be exchanged.
    BuiltIn {
        method: Method,
        sector: Arc<dyn EditableSector>,
    },
    /// A sector of the user's own.
    Custom(Arc<dyn Sector>),
}

/// A named way out of a scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Exit {
    name: String,
    sector: SectorId,
    opening: OpeningId,
}

impl Scene {
    /// How many sectors there are.
    pub fn sector_count(&self) -> usize {
        self.sectors.len()
    }

    /// The ids of all sectors.
    pub fn sectors(&self) -> impl Iterator<Item = SectorId> + use<> {
        (0..self.sectors.len() as u32).map(SectorId)
    }

    /// A sector, as whatever sees it.
    pub fn sector(&self, id: SectorId) -> &dyn Sector {
        self.sectors[id.0 as usize].sector()
    }

    /// A sector's name.
    pub fn sector_name(&self, id: SectorId) -> &str {
        &self.sectors[id.0 as usize].name
    }

    /// What a sector is made of; `None` where it is one of the user's own.
    pub fn geometry(&self, id: SectorId) -> Option<&Arc<Geometry>> {
        match &self.sectors[id.0 as usize].body {
            Body::BuiltIn { sector, .. } => Some(sector.geometry()),
            Body::Custom(_) => None,
        }
    }

    /// How a sector is seen; `None` where it is one of the user's own.
    pub fn method(&self, id: SectorId) -> Option<Method> {
        match &self.sectors[id.0 as usize].body {
            Body::BuiltIn { method, .. } => Some(*method),
            Body::Custom(_) => None,
        }
    }

    /// The portals, by [`PortalId`].
    pub fn portals(&self) -> &[Portal] {
        &self.portals
    }

    /// Where an opening leads; `None` where it leads nowhere.
    pub fn portal_of(&self, sector: SectorId, opening: OpeningId) -> Option<PortalId> {
        let [first, end] = [0, 1].map(|next| self.first_opening[sector.0 as usize + next]);
        let index = first + u32::from(opening.0);
        if index < end {
            self.portal_of[index as usize]
        } else {
            None
        }
    }

    /// Opens or closes a portal, in O(1). The way back, if there is one, is a portal of its own.
    pub fn set_open(&mut self, portal: PortalId, open: bool) {
        self.portals[portal.0 as usize].open = open;
    }

    /// Gives a sector other geometry, seen by the same method: what moves every frame has a sector of its own, and no
    /// other is touched. Its openings may move but not become more or fewer.
    ///
    /// Cost: that of building the method, which is next to nothing for [`Method::ZBuffer`] and [`Method::SBuffer`].
    ///
    /// # Errors
    /// [`SceneError::NotOurs`], [`SceneError::Openings`], [`SceneError::TooLarge`], [`SceneError::NotBaked`] or
    /// [`SceneError::NotConvex`], and then it stays as it was.
    pub fn set_geometry(
        &mut self,
        id: SectorId,
        geometry: impl Into<Arc<Geometry>>,
    ) -> Result<(), SceneError> {
        let geometry = geometry.into();
        let (before, method) = self.ours(id)?;
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

    /// Has a sector seen by another method; no other is touched.
    ///
    /// # Errors
    /// [`SceneError::NotOurs`], [`SceneError::TooLarge`], [`SceneError::NotBaked`], [`SceneError::NotConvex`] or [`SceneError::TerrainUnusable`], and then it
    /// stays as it was.
    pub fn set_method(&mut self, id: SectorId, method: Method) -> Result<(), SceneError> {
        let (geometry, _) = self.ours(id)?;
        self.rebuild(id, Arc::clone(geometry), method)
    }

    fn ours(&self, id: SectorId) -> Result<(&Arc<Geometry>, Method), SceneError> {
        match &self.sectors[id.0 as usize].body {
            Body::BuiltIn { sector, method } => Ok((sector.geometry(), *method)),
            Body::Custom(_) => Err(SceneError::NotOurs(self.sector_name(id).to_owned())),
        }
    }

    fn rebuild(&mut self, id: SectorId, geometry: Arc<Geometry>, method: Method) -> Result<(), SceneError> {
        let placed = &mut self.sectors[id.0 as usize];
        let built = placed.rebuild(geometry, method, self.limit_bytes);
        built.map_err(|why| SceneError::unsuited(&placed.name, why))
    }

    /// How often a sector's method was built since the sector was added; 0 of one of the user's own.
    pub fn builds(&self, id: SectorId) -> u64 {
        self.sectors[id.0 as usize].builds
    }

    /// Moves where a portal leads, in O(1): the sector behind it moves as a whole.
    ///
    /// # Errors
    /// [`SceneError::NotSimilar`] or [`SceneError::TooFar`], and then it stays as it was.
    pub fn set_portal(&mut self, portal: PortalId, there_from_here: Transform) -> Result<(), SceneError> {
        if !there_from_here.is_similarity() {
            return Err(SceneError::NotSimilar(portal.0 as usize));
        }
        let mut moved = self.portals[portal.0 as usize].clone();
        moved.there_from_here = there_from_here;
        let openings = self.sector(moved.from).openings();
        if !moved.leads_in_range(&openings[usize::from(moved.opening.0)]) {
            return Err(SceneError::TooFar(portal.0 as usize));
        }
        self.portals[portal.0 as usize] = moved;
        Ok(())
    }

    /// The same scene with every sector of ours seen by `method`. Geometries are shared, not copied.
    ///
    /// # Errors
    /// [`Unsuited::TooLarge`] where a sector would need more than `limit_bytes` for what the method builds,
    /// [`Unsuited::NotBaked`], [`Unsuited::NotConvex`] or [`Unsuited::TerrainUnusable`] where one has not what the method goes by.
    pub fn with_method(&self, method: Method, limit_bytes: u64) -> Result<Scene, Unsuited> {
        let mut scene = self.clone();
        scene.limit_bytes = limit_bytes;
        // Of sectors of one geometry the first builds what the others share: side by side each would build its own.
        let mut geometries = HashSet::new();
        let is_first = |placed: &&mut Placed| match &placed.body {
            Body::BuiltIn { sector, .. } => geometries.insert(Arc::as_ptr(sector.geometry())),
            Body::Custom(_) => false,
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

    /// Has every sector of ours what a method goes by ([`Method::suits`])?
    pub fn suits(&self, method: Method) -> bool {
        let mut geometries = self.sectors().filter_map(|id| self.geometry(id));
        geometries.all(|geometry| method.suits(geometry))
    }

    /// The same scene with its openings as plain holes: no portal is followed.
    #[must_use]
    pub fn without_portals(&self) -> Scene {
        Scene {
            flat: true,
            ..self.clone()
        }
    }

    pub(crate) fn is_flat(&self) -> bool {
        self.flat
    }

    /// The sector that a point stands in: of those whose boxes hold it, the smallest; else the one whose box is
    /// nearest. `None` only where the scene has no sector.
    ///
    /// The box of a sector that is [open above](SceneBuilder::open_above) has no top: whoever is on a roof or a balcony is in
    /// the garden. Of several such boxes, the smallest is the one that covers the least ground.
    ///
    /// Boxes that end in a doorway both hold an eye that stands in it: then the one whose middle is nearer to where
    /// the eye looks (`toward`) is taken, so that the doorway is behind the eye.
    ///
    /// Cost: O(log sectors) where few boxes overlap.
    pub fn locate(&self, point: [f32; 3], toward: [f32; 3]) -> Option<SectorId> {
        self.boxes.locate(point, toward)
    }

    /// The sector that a view's eye stands in; `None` where the scene has none, or not the one that the view names.
    pub fn sector_of(&self, view: &View) -> Option<SectorId> {
        match view.sector {
            Some(id) => ((id.0 as usize) < self.sectors.len()).then_some(id),
            None => self.locate(view.eye, view.toward),
        }
    }

    /// Whether [`SceneBuilder::open_above`] was called for a sector.
    pub fn is_open_above(&self, id: SectorId) -> bool {
        self.sectors[id.0 as usize].open_above
    }

    /// The smallest box around a sector's geometry, in the sector's own space.
    pub fn bounds(&self, id: SectorId) -> Aabb {
        self.sector(id).bounds()
    }

    /// Items of all sectors; one that stands in two is counted twice. Of the user's own, as many as they say.
    pub fn item_count(&self) -> usize {
        let items = |id| match self.geometry(id) {
            Some(geometry) => geometry.item_count(),
            None => self.sector(id).item_count() as usize,
        };
        self.sectors().map(items).sum()
    }

    /// Triangles of all sectors, each copy counted. Of the user's own, as many as they [say](Sector::item_triangles).
    pub fn triangle_count(&self) -> u64 {
        self.sectors().map(|id| self.triangles_of(id)).sum()
    }

    /// The same of one sector.
    pub fn triangles_of(&self, id: SectorId) -> u64 {
        let own = self.sector(id);
        match self.geometry(id) {
            Some(geometry) => geometry.triangle_count(),
            None => (0..own.item_count())
                .map(|item| own.item_triangles(ItemId(item), &[]))
                .sum(),
        }
    }

    /// Memory in bytes, of geometries and of what methods built over them.
    pub fn bytes(&self) -> u64 {
        let sectors = self.sectors().map(|id| self.sector(id).bytes()).sum::<u64>();
        let portals = size_of_val(&*self.portals) + size_of_val(&*self.portal_of);
        sectors + self.boxes.bytes() + portals as u64
    }

    /// What methods built, over all sectors: sums, and the depth of the deepest tree.
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

impl Placed {
    fn sector(&self) -> &dyn Sector {
        match &self.body {
            Body::BuiltIn { sector, .. } => &**sector,
            Body::Custom(sector) => &**sector,
        }
    }

    /// The box by which an eye is located.
    fn space(&self) -> Aabb {
        let mut space = self.sector().bounds();
        if self.open_above && !space.is_empty() {
            space.max[1] = f32::INFINITY;
        }
        space
    }

    /// Has this geometry seen by this method, or stays as it was.
    fn rebuild(&mut self, geometry: Arc<Geometry>, method: Method, limit_bytes: u64) -> Result<(), Unsuited> {
        let sector = method.build_editable(geometry, limit_bytes)?;
        self.body = Body::BuiltIn { method, sector };
        self.builds += 1;
        Ok(())
    }
}
