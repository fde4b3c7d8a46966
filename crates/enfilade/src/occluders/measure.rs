//! Measures how much an occluder hides, and bounds the measure of everything in a box.
//!
//! Source: Coorg, Teller, Real-Time Occlusion Culling for Models with Large Occluders, I3D 1997, section 3.3, for the
//!     area-angle measure.
//! Cost: O(corners) for a polygon, O(1) for a box.
//! The bound of a box is never below the measure of a polygon in it, including rounding.

use super::screen::clip;
use super::{OccluderSet, Polygon, cofactor, greatest_stretch};
use crate::geom::Aabb;
use crate::geometry::Geometry;
use crate::ids::ItemIndex;
use crate::view::passage::Passage;
use crate::view::region::{Region, Volume};
use crate::view::screen_map::ScreenMap;
use glam::{DAffine3, DMat3, DVec2, DVec3};

/// Measure by which occluders are ranked for selection; larger is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OccluderMeasure {
    /// Area-angle measure, about the solid angle that the occluder hides, in steradians: A · (N · V) / D², with A its
    /// area, N its unit normal, V the unit direction from its centre to the eye and D the distance.
    ///
    /// V is not the viewing direction: with that, the walls of a corridor would count for nothing.
    AreaAngle,
    /// Projected area inside the aperture's rectangle, in pixels.
    ProjectedArea,
}

/// Minimum projected area of a selected occluder inside the aperture's rectangle, in pixels, for either measure. A
/// smaller one hides hardly a sample and costs a cover as much as any.
const LEAST_PIXELS: f64 = 16.0;

/// An item whose polygons are in the queue.
#[derive(Clone, Copy, Debug)]
pub(super) struct EnteredItem {
    pub(super) item: ItemIndex,
    pub(super) screen_from_item: ScreenMap,
    sector_from_item: DAffine3,
    /// Maps area vectors (area times normal) to sector space.
    areas: DMat3,
    /// Upper bound of the factor by which `areas` lengthens a vector.
    pub(super) stretch: f64,
    /// Eye position in the object space of the item.
    pub(super) eye: DVec3,
    /// Upper bound of the factor by which the map from sector to object space lengthens a vector.
    pub(super) shrink: f64,
    /// Direction towards the viewer of a parallel view, in the item's space.
    pub(super) back: Option<DVec3>,
}

impl EnteredItem {
    /// Computes the transforms of an item as seen through a passage.
    pub(super) fn of(item: ItemIndex, geometry: &Geometry, passage: &Passage) -> EnteredItem {
        let sector_from_item = geometry.item(item).transform();
        let screen_from_item = passage.screen_from(&sector_from_item);
        let areas = cofactor(&sector_from_item.0.matrix3);
        EnteredItem {
            item,
            screen_from_item,
            areas,
            stretch: greatest_stretch(areas) * ROUND_UP,
            eye: screen_from_item.eye(),
            back: screen_from_item.parallel_back(),
            shrink: greatest_stretch(sector_from_item.0.matrix3.inverse()) * ROUND_UP,
            sector_from_item: sector_from_item.0,
        }
    }
}

/// Factor larger than any f64 rounding in bounds and measures: a bound must not be below a value that it bounds.
const ROUND_UP: f64 = 1.0 + 1e-9;

/// Factor by which reversed depth is rounded up: larger than the error of summing the sides of a box near the eye.
const NEARER: f64 = 1.0 + 1.0 / (1_u64 << 20) as f64;

/// Parameters of one selection.
pub(super) struct Chooser<'a> {
    pub(super) set: &'a OccluderSet,
    pub(super) geometry: &'a Geometry,
    pub(super) passage: &'a Passage,
    measure: OccluderMeasure,
    /// Eye position in sector space.
    pub(super) eye: DVec3,
    /// Upper bound of the projected area, in pixels, of an area of 1 at distance 1 along the view direction; in a parallel
    /// view, at any distance.
    pixels: f64,
}

impl<'a> Chooser<'a> {
    /// Prepares a selection for a passage.
    pub(super) fn new(
        set: &'a OccluderSet,
        geometry: &'a Geometry,
        passage: &'a Passage,
        measure: OccluderMeasure,
    ) -> Chooser<'a> {
        let lens = passage.lens();
        let screen_from_eye = lens.screen_from_eye.matrix3;
        let eye_from_screen = screen_from_eye.inverse();
        let rect = passage.aperture.rect();
        // Areas project largest in the corner of the aperture that is farthest from the view direction.
        let corners = [
            [rect.x0, rect.y0],
            [rect.x1, rect.y0],
            [rect.x0, rect.y1],
            [rect.x1, rect.y1],
        ];
        let secant = corners
            .map(|[x, y]| (eye_from_screen * DVec3::new(f64::from(x), f64::from(y), 1.0)).length())
            .into_iter()
            .fold(1.0, f64::max);
        // Portals may scale.
        let scale = greatest_stretch(passage.eye_from_sector().0.matrix3);
        let pixels = if lens.is_parallel {
            screen_from_eye.row(0).cross(screen_from_eye.row(1)).length()
        } else {
            screen_from_eye.determinant().abs() * secant
        };
        Chooser {
            set,
            geometry,
            passage,
            measure,
            eye: passage.screen_from_sector.eye(),
            pixels: pixels * scale * scale * ROUND_UP,
        }
    }

    /// Returns an upper bound of the measure of a polygon in a box, given that its area in the sector is at most
    /// `area`; `None` if no such polygon is worth selecting.
    ///
    /// `eye` is in the space of the box; one unit of that space is at least `shrink`⁻¹ units of the sector.
    pub(super) fn bound(
        &self,
        screen_from_local: &ScreenMap,
        bounds: &Aabb,
        area: f64,
        eye: DVec3,
        shrink: f64,
    ) -> Option<f64> {
        match self.measure {
            OccluderMeasure::ProjectedArea => self.bound_pixels(screen_from_local, bounds, area),
            OccluderMeasure::AreaAngle => self.bound_angle(screen_from_local, bounds, area, eye, shrink),
        }
    }

    /// Returns `true` if [`Chooser::bound`] does not test boxes against the view frustum, so that the caller must do it
    /// before entering them.
    pub(super) fn bounds_ignore_frustum(&self) -> bool {
        self.measure == OccluderMeasure::AreaAngle
    }

    /// Computes [`Chooser::bound`] for [`OccluderMeasure::ProjectedArea`].
    fn bound_pixels(&self, screen_from_local: &ScreenMap, bounds: &Aabb, area: f64) -> Option<f64> {
        let clip = self.passage.into();
        let region = Region::within(&clip, screen_from_local, bounds)?;
        let nearest = match screen_from_local.is_parallel {
            true => 1.0,
            false => f64::from(region.nearest).min(1.0 / clip.near),
        };
        // The rectangle counts samples; half a pixel beyond the outermost ones on each side belongs to the area.
        let side = |from: u16, to: u16| f64::from(to.saturating_sub(from)) + 2.0;
        let rect = side(region.rect.x0, region.rect.x1) * side(region.rect.y0, region.rect.y1);
        let pixels = rect.min(area * self.pixels * nearest * nearest);
        (pixels >= LEAST_PIXELS).then_some(pixels * ROUND_UP)
    }

    /// Computes [`Chooser::bound`] for [`OccluderMeasure::AreaAngle`].
    ///
    /// Only considers the distance of the box: most queued boxes are never examined further.
    fn bound_angle(
        &self,
        screen_from_local: &ScreenMap,
        bounds: &Aabb,
        area: f64,
        eye: DVec3,
        shrink: f64,
    ) -> Option<f64> {
        let near = f64::from(self.passage.z_near);
        let Volume {
            origin,
            sides,
            is_parallel,
        } = Volume::new(screen_from_local, bounds);
        let [mut least, mut greatest] = [origin.z; 2];
        for side in sides {
            least += side.z.min(0.0);
            greatest += side.z.max(0.0);
        }
        // Reversed depth is 1 in the near plane of a parallel view, and more in front of it.
        let is_before_near = if is_parallel { least > 1.0 } else { greatest < near };
        if bounds.is_empty() || is_before_near {
            return None;
        }
        let nearest = if is_parallel {
            1.0
        } else {
            NEARER / least.max(near)
        };
        if area * self.pixels * nearest * nearest < LEAST_PIXELS {
            return None;
        }
        let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
        let distance = eye.clamp(min, max).distance(eye) / shrink;
        Some(area / (distance * distance) * ROUND_UP)
    }

    /// Returns the measure of a polygon; `None` if it is not worth selecting.
    pub(super) fn value(
        &self,
        placed: &EnteredItem,
        polygon: &Polygon,
        corners: &mut Vec<DVec3>,
    ) -> Option<f64> {
        corners.clear();
        let all = self.set.corners_of(polygon).iter();
        corners.extend(all.map(|&corner| placed.screen_from_item.point(corner)));
        let pixels = pixels(corners, self.passage);
        if pixels < LEAST_PIXELS {
            return None;
        }
        Some(match self.measure {
            OccluderMeasure::ProjectedArea => pixels,
            OccluderMeasure::AreaAngle => {
                let way = placed.sector_from_item.transform_point3(polygon.centre) - self.eye;
                let distance = way.length();
                polygon.area * (placed.areas * polygon.normal).dot(way).abs()
                    / (distance * distance * distance)
            }
        })
    }
}

/// Returns the projected area of a polygon in pixels, clipped by the aperture's rectangle, the near plane and the entry
/// plane. Overwrites the corners.
fn pixels(corners: &mut Vec<DVec3>, passage: &Passage) -> f64 {
    let rect = passage.aperture.rect();
    let [x0, y0, x1, y1] = [rect.x0, rect.y0, rect.x1, rect.y1].map(f64::from);
    clip(corners, DVec3::Z, f64::from(passage.z_near));
    for (normal, edge) in [(DVec3::X, x0), (DVec3::Y, y0), (-DVec3::X, -x1), (-DVec3::Y, -y1)] {
        clip(corners, normal - DVec3::Z * edge, 0.0);
    }
    if let Some((normal, distance)) = passage.entry {
        clip(corners, normal, distance);
    }
    let Some(&first) = corners.first() else { return 0.0 };
    let first = (first / first.z).truncate();
    let mut before = DVec2::ZERO;
    let mut doubled = 0.0;
    for corner in &corners[1..] {
        let at = (*corner / corner.z).truncate() - first;
        doubled += before.perp_dot(at);
        before = at;
    }
    0.5 * doubled.abs()
}
