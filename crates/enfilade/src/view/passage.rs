//! A chain of portals from the eye into a sector, with its clip region and transform.

use super::View;
use crate::contract::Contract;
use crate::geom::{Aabb, ConvexPolygon, MAX_COORDINATE, Transform};
use crate::geometry::{Geometry, Item};
use crate::ids::{OpeningId, PassageId, PortalId, SectorId};
use crate::threads;
use crate::view::aperture::{Aperture, CellRoom, Rect, Rows};
use crate::view::entrance::Entrance;
use crate::view::opening_view::{OpeningView, may_touch_eye};
use crate::view::options::ViewerOptions;
use crate::view::region::{Clip, Region, Volume};
use crate::view::screen_map::ScreenMap;
use fearless_simd::Level;
use glam::{DAffine3, DMat4, DVec3, DVec4};

/// A chain of zero or more portals from the eye into a sector, with its clip region and view matrix.
///
/// An engine draws each passage with its own matrix ([`Passage::clip_from_sector`]), scissor ([`Passage::scissor`]) and clip
/// plane ([`Passage::entry_plane`]).
#[doc(alias = "portal path")]
#[doc(alias = "clip view")]
#[derive(Clone, Debug)]
pub struct Passage {
    /// The passage one portal nearer to the eye; `None` for the eye's own sector, and for each sector that rays of a parallel
    /// view start in.
    pub parent: Option<PassageId>,
    /// The portal from the parent; `None` for the eye's own sector.
    pub portal: Option<PortalId>,
    /// The sector at the end of the chain.
    pub sector: SectorId,
    /// Number of portals in the chain; 0 for the eye's own sector.
    pub crossings: u16,
    /// The combined contract of the sectors on the chain, including this one ([`Contract::combined_with`]).
    pub contract: Contract,
    /// The clip region: the screen area visible through all portals of the chain.
    pub aperture: Aperture,
    /// Near-plane distance along the view direction ([`View::z_near`]), in eye space; geometry in front of it is neither
    /// visible nor an occluder. In a parallel view 1, the reciprocal of the reversed depth of its near plane.
    ///
    /// Eye space is the same in all passages of a look, so `z_near` and reversed depths mean the same, whatever the portals
    /// scale by. One unit of the passage's sector is as many units of eye space as [`Passage::eye_from_sector`] scales by.
    pub z_near: f32,
    /// Size of the viewport, in pixels.
    pub size: [u32; 2],
    /// Options of the look. The cover size is `None` if it is that of the screen.
    pub options: ViewerOptions,
    /// Whether no portal is followed and openings are empty holes (`Scene::without_portals`).
    pub(crate) flat: bool,
    /// Whether items take part whatever their own limits.
    ignores_limits: bool,
    /// Visibility is computed for sample positions up to this far from the pixel centre, in pixels along each axis: 0 at
    /// the centre only, 0.5 anywhere in the pixel.
    pub(crate) spread: f64,
    /// Hash of the chain of portals: the same chain has the same hash in the next frame.
    pub(crate) chain: u64,
    /// SIMD level of box tests; looked up once per look.
    pub(crate) level: Level,
    eye_from_sector: DAffine3,
    lens: Lens,
    clip_from_eye: DMat4,
    /// Position of the viewport in the render target, in pixels.
    origin: [u32; 2],
    pub(crate) screen_from_sector: ScreenMap,
    /// Entry plane (oblique near plane): the sector's side is n · (X, Y, W) ≥ d, with d ≥ 0.
    pub(crate) entry: Option<(DVec3, f64)>,
    /// Outline of the last opening, in the space of the sector; `None` for the eye's own sector.
    pub(crate) entrance: Option<Entrance>,
}

/// The projection of a view, and the depth range of a passage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    /// To (X, Y, W), or, if parallel, to (column, row, distance from the near plane).
    pub(crate) screen_from_eye: DAffine3,
    pub(crate) is_parallel: bool,
    /// Distance from the near plane at which reversed depth is 0: twice as far as the farthest geometry, or as the far plane
    /// of the view, if what will be looked at is not known. Infinite in perspective.
    far: f64,
}

impl Lens {
    /// Returns the height on the screen, in pixels, of a unit of eye space that is upright on the screen: at a distance of 1,
    /// or at any in a parallel view.
    fn pixels_per_unit(&self) -> f64 {
        // Without the part along the view direction, which off-centre and sheared projections have.
        let [y, ahead] = [1, 2].map(|row| self.screen_from_eye.matrix3.row(row));
        y.reject_from(ahead).length()
    }

    /// Returns the map from a space to the screen.
    fn after(&self, eye_from_here: &DAffine3) -> ScreenMap {
        let mut linear = self.screen_from_eye * *eye_from_here;
        if self.is_parallel {
            let per_unit = -1.0 / self.far;
            for column in [
                &mut linear.matrix3.x_axis,
                &mut linear.matrix3.y_axis,
                &mut linear.matrix3.z_axis,
                &mut linear.translation,
            ] {
                column.z *= per_unit;
            }
            linear.translation.z += 1.0;
        }
        ScreenMap {
            linear,
            is_parallel: self.is_parallel,
        }
    }
}

/// Minimum distance of a face from the eye to be behind the entry plane, relative to the plane: faces in the plane are
/// not behind it.
pub(crate) const BEYOND: f64 = 1.0 + 1.0 / (1_u64 << 18) as f64;

impl Passage {
    /// Returns the passage of the eye's own sector. [`Passage::fit`] it to the sector.
    pub(crate) fn at_the_eye(view: &View, sector: SectorId, flat: bool) -> Passage {
        let eye_from_sector = view.eye_from_sector().0;
        let lens = Lens {
            screen_from_eye: view.screen_from_eye(),
            is_parallel: view.is_parallel(),
            far: 2.0 * view.far(),
        };
        let screen_from_sector = lens.after(&eye_from_sector);
        Passage {
            parent: None,
            portal: None,
            sector,
            crossings: 0,
            contract: Contract::Approximate,
            aperture: Aperture::screen(view.size()),
            z_near: if lens.is_parallel { 1.0 } else { view.z_near() },
            size: view.size(),
            options: ViewerOptions::default(),
            flat,
            ignores_limits: view.is_light(),
            spread: 0.0,
            chain: u64::from(sector.0),
            level: crate::simd::level(),
            eye_from_sector,
            lens,
            clip_from_eye: DMat4::from_cols_array_2d(&view.clip_from_eye()),
            origin: view.viewport().origin,
            screen_from_sector,
            entry: view.near_plane().map(|[x, y, z, d]| {
                let (normal, distance) = screen_from_sector.half_space(DVec3::new(x, y, z), -d);
                let length = normal.length();
                (normal / length, distance / length)
            }),
            entrance: None,
        }
    }

    /// Returns the same passage in another sector that the near rectangle of a parallel view touches.
    pub(crate) fn starting_in(&self, sector: SectorId, aperture: Aperture) -> Passage {
        Passage {
            sector,
            chain: u64::from(sector.0),
            ..self.with_aperture(aperture)
        }
    }

    /// Sets the depth range of a parallel view, so that reversed depth is above 0 everywhere in the bounds of the sector.
    /// Does nothing in perspective.
    pub(crate) fn fit(&mut self, bounds: &Aabb) {
        if !self.lens.is_parallel {
            return;
        }
        let depth = (self.lens.screen_from_eye * self.eye_from_sector).matrix3.row(2);
        let offset = (self.lens.screen_from_eye * self.eye_from_sector).translation.z;
        let [min, max] = [bounds.min, bounds.max].map(|corner| {
            DVec3::from(corner.map(|at| f64::from(at).clamp(-FARTHEST_COORDINATE, FARTHEST_COORDINATE)))
        });
        let [low, high] = [depth * min, depth * max];
        let farthest = offset + low.max(high).element_sum();
        let size = (depth * (max - min)).abs().element_sum();
        // Bounds that are empty, or entirely in front of the near plane, show nothing at any depth.
        let far = (2.0 * farthest)
            .max(size / 1024.0)
            .max(f64::from(f32::MIN_POSITIVE));
        let old = std::mem::replace(&mut self.lens.far, far);
        self.screen_from_sector = self.lens.after(&self.eye_from_sector);
        if let Some((normal, distance)) = &mut self.entry {
            // Reversed depth was `scale` * the new one + 1 - `scale`.
            let scale = far / old;
            normal.z -= *distance * (1.0 - scale);
            *distance *= scale;
            let length = normal.length();
            (*normal, *distance) = (*normal / length, *distance / length);
        }
    }

    /// Whether everything on the screen may be visible: the passage is behind no portal, and all rays start in its sector.
    pub(crate) fn is_unclipped(&self) -> bool {
        self.parent.is_none() && self.aperture.is_unclipped(self.size)
    }

    /// Whether an item takes part in the look: it has a layer in common with the viewer, and is not beyond its own
    /// limits.
    pub(crate) fn takes(&self, item: &Item) -> bool {
        let options = &item.options;
        let has_limits = options.has_limits() && !self.ignores_limits;
        options.layers & self.options.layers != 0 && !(has_limits && self.is_beyond_limits(item))
    }

    /// Whether an item that is never culled is listed.
    pub(crate) fn takes_always(&self, item: &Item) -> bool {
        item.options.is_drawn && item.options.layers & self.options.layers != 0
    }

    /// Whether an item is too far away or too small on the screen to take part in the look.
    fn is_beyond_limits(&self, item: &Item) -> bool {
        let eye = DVec3::from(self.eye());
        let [min, max] = [item.bounds.min, item.bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
        let away = (min - eye).max(eye - max).max(DVec3::ZERO).length();
        let pixels = (max - min).length() * self.lens.pixels_per_unit();
        let distance = match self.lens.is_parallel {
            true => 1.0 / self.eye_scale(),
            false => (0.5 * (min + max) - eye).length(),
        };
        away > f64::from(item.options.max_distance) || pixels < f64::from(item.options.min_size_px) * distance
    }

    /// Returns the passage through a portal, behind an opening of this passage's sector and into the sector `to`; `None`
    /// if its clip region has no sample.
    pub(crate) fn through(
        &self,
        own_id: PassageId,
        portal: PortalId,
        to: SectorId,
        there_from_here: &Transform,
        outline: &ConvexPolygon,
        rows: Option<Rows>,
    ) -> Option<Passage> {
        let view = OpeningView::new(self, outline)?;
        let aperture = self.aperture.behind(
            view.corners(),
            rows,
            self.spread,
            self.options.margin().max(self.options.growth()),
        )?;
        let here_from_there = there_from_here.inverse()?;
        let eye_from_sector = self.eye_from_sector * here_from_there.0;
        Some(Passage {
            parent: Some(own_id),
            portal: Some(portal),
            sector: to,
            crossings: self.crossings + 1,
            contract: self.contract,
            aperture,
            z_near: self.z_near,
            size: self.size,
            options: self.options,
            flat: self.flat,
            ignores_limits: self.ignores_limits,
            spread: 0.0,
            chain: self.chain_through(portal),
            level: self.level,
            eye_from_sector,
            lens: self.lens,
            clip_from_eye: self.clip_from_eye,
            origin: self.origin,
            screen_from_sector: self.lens.after(&eye_from_sector),
            entry: Some(view.plane()),
            entrance: Some(Entrance::new(outline, there_from_here)),
        })
    }

    /// Returns the number of threads that may work on this passage.
    pub(crate) fn threads(&self) -> usize {
        if self.options.parallel {
            threads::count()
        } else {
            1
        }
    }

    /// Returns the hash of this chain extended by a portal.
    pub(crate) fn chain_through(&self, portal: PortalId) -> u64 {
        next_chain(self.chain, portal)
    }

    /// Returns the passage with the contract of its sector applied. When `painted`, visibility is computed for samples
    /// only, even if the method is strict.
    pub(crate) fn with_contract(self, own: Contract, painted: bool) -> Passage {
        Passage {
            contract: match self.parent {
                Some(_) => self.contract.combined_with(own),
                None => own,
            },
            spread: match own {
                Contract::Strict if !painted => 0.5,
                _ => self.options.margin().max(self.options.growth()),
            },
            ..self
        }
    }

    /// Returns the passage at a lower resolution, whose pixels are cells; visibility is computed for any position in a
    /// cell and, if the cells are pixels, within the margin of the options around each sample.
    pub(crate) fn in_cells(&self, cells: [u32; 2], room: &mut CellRoom) -> Passage {
        let scale = [0, 1].map(|axis| f64::from(cells[axis]) / f64::from(self.size[axis]));
        let lens = Lens {
            screen_from_eye: DAffine3::from_scale(DVec3::new(scale[0], scale[1], 1.0))
                * self.lens.screen_from_eye,
            ..self.lens
        };
        let aperture = if self.is_unclipped() {
            Aperture::screen(cells)
        } else {
            self.aperture.in_cells(scale, room)
        };
        Passage {
            size: cells,
            spread: if cells == self.size {
                self.options.margin()
            } else {
                0.5 + self.options.margin() * scale[0].max(scale[1])
            },
            lens,
            screen_from_sector: lens.after(&self.eye_from_sector),
            entry: self
                .entry
                .map(|(normal, distance)| (normal / DVec3::new(scale[0], scale[1], 1.0), distance)),
            ..self.with_aperture(aperture)
        }
    }

    /// Returns the passage with another aperture.
    pub(crate) fn with_aperture(&self, aperture: Aperture) -> Passage {
        Passage {
            parent: self.parent,
            portal: self.portal,
            sector: self.sector,
            crossings: self.crossings,
            contract: self.contract,
            aperture,
            z_near: self.z_near,
            size: self.size,
            options: self.options,
            flat: self.flat,
            ignores_limits: self.ignores_limits,
            spread: self.spread,
            chain: self.chain,
            level: self.level,
            eye_from_sector: self.eye_from_sector,
            lens: self.lens,
            clip_from_eye: self.clip_from_eye,
            origin: self.origin,
            screen_from_sector: self.screen_from_sector,
            entry: self.entry,
            entrance: self.entrance,
        }
    }

    /// Returns the view matrix of this passage, from the space of the sector to the eye space of the view
    /// ([`View::eye_from_sector`]).
    #[doc(alias = "view matrix")]
    pub fn eye_from_sector(&self) -> Transform {
        Transform(self.eye_from_sector)
    }

    /// Returns the view-projection matrix of this passage, as four columns: [`View::clip_from_eye`] times
    /// [`Passage::eye_from_sector`].
    #[doc(alias = "view projection matrix")]
    pub fn clip_from_sector(&self) -> [[f64; 4]; 4] {
        (self.clip_from_eye * DMat4::from(self.eye_from_sector)).to_cols_array_2d()
    }

    /// Returns the scissor rectangle of this passage, in pixels of the render target, y down: x and y of the left top corner,
    /// width and height.
    pub fn scissor(&self) -> [u32; 4] {
        let rect = self.aperture.rect();
        let [left, top] = self.origin;
        let [x0, y0, x1, y1] = [rect.x0, rect.y0, rect.x1, rect.y1].map(u32::from);
        [left + x0, top + y0, x1 - x0, y1 - y0]
    }

    /// Returns the plane of the opening that this passage leads through, in the space of the sector: only points (x, y, z)
    /// with ax + by + cz + d ≥ 0 are visible or hide anything. (a, b, c) has length 1. For the eye's own sector the near plane
    /// if it is oblique ([`View::near_plane`]), else `None`.
    ///
    /// Clip to it when drawing the passage (a user clip plane, or an oblique near plane) unless nothing of the sector is on
    /// the eye's side of the opening, as behind a plain door. Behind a mirror or a teleport it is needed.
    #[doc(alias = "clip plane")]
    #[doc(alias = "oblique near plane")]
    pub fn entry_plane(&self) -> Option<[f64; 4]> {
        let (normal, distance) = self.entry?;
        let plane = self.screen_from_sector.half_space_here(normal, distance);
        Some((plane / plane.truncate().length()).into())
    }

    /// Returns `true` if the chain mirrors the sector (negative determinant), which flips the winding of its faces.
    pub fn mirrored(&self) -> bool {
        self.eye_from_sector().mirrors()
    }

    /// Returns the scale from the space of the sector to eye space.
    pub(crate) fn eye_scale(&self) -> f64 {
        self.eye_from_sector.matrix3.x_axis.length()
    }

    /// Returns the maximum rounding error of a corner in (X, Y, W) space. It grows with the eye's distance from the
    /// sector's origin, because coordinates cancel there.
    pub(crate) fn corner_rounding(&self) -> f64 {
        const ROUNDING: f64 = 1.0 / (1_u64 << 50) as f64;
        // In a parallel view the corner is divided by its reversed depth, 0.5 to 1 where anything is visible.
        let division = if self.lens.is_parallel { 8.0 } else { 1.0 };
        division * ROUNDING * self.screen_from_sector.linear.translation.length()
    }

    /// Returns the eye position in the space of the sector, transformed through the portals of the chain.
    pub fn eye(&self) -> [f64; 3] {
        if self.lens.is_parallel {
            let eye = self.eye_from_sector.inverse().translation;
            return if eye.is_finite() { eye.into() } else { [0.0; 3] };
        }
        self.viewpoint()
    }

    /// Returns the position that everything is seen from, in the space of the sector: the eye, or, in a parallel view, a
    /// position very far behind it.
    pub(crate) fn viewpoint(&self) -> [f64; 3] {
        self.screen_from_sector.eye().into()
    }

    /// Returns the eye position and the unit vector against the view direction, both in the space of the sector.
    pub(crate) fn stance(&self) -> (DVec3, DVec3) {
        let back = self.screen_from_sector.back();
        (self.eye().into(), back.normalize_or_zero())
    }

    /// Returns `true` if any part of an AABB, given in another space, may be in the view frustum and behind the entry
    /// plane.
    pub(crate) fn frustum_meets(&self, screen_from_local: &ScreenMap, bounds: &Aabb) -> bool {
        let clip = Clip {
            rect: Rect {
                x0: 0,
                y0: 0,
                x1: self.size[0] as u16,
                y1: self.size[1] as u16,
            },
            ..self.into()
        };
        Region::within(&clip, screen_from_local, bounds).is_some()
    }

    /// Returns `true` if any part of an AABB in the space of the sector may be visible through the passage, ignoring
    /// occluders; `true` when unsure.
    pub fn may_show(&self, bounds: &Aabb) -> bool {
        Region::of(self, &self.screen_from_sector, bounds).is_some()
    }

    /// Returns how many pixels a point within `bounds` moves on the screen, at most, per unit of movement in the item's
    /// space; use it to select a LOD by its geometric error.
    ///
    /// `bounds` is an AABB in the item's space. Returns 0 if no part of it can be visible.
    pub fn pixels_per_unit(&self, sector_from_item: &Transform, bounds: &Aabb) -> f64 {
        let screen_from_item = self.screen_from(sector_from_item);
        let Some(Region { rect, nearest, .. }) = Region::of(self, &screen_from_item, bounds) else {
            return 0.0;
        };
        let rows = screen_from_item.linear.matrix3.transpose();
        if self.lens.is_parallel {
            return greatest_stretch(rows.x_axis, rows.y_axis);
        }
        // The screen position (X, Y) / W moves by (dX − x dW, dY − y dW) / W: most at a corner, because this is convex
        // in x and y.
        let stretch = [
            [rect.x0, rect.y0],
            [rect.x1, rect.y0],
            [rect.x0, rect.y1],
            [rect.x1, rect.y1],
        ]
        .map(|corner| {
            let [x, y] = corner.map(f64::from);
            greatest_stretch(rows.x_axis - x * rows.z_axis, rows.y_axis - y * rows.z_axis)
        })
        .into_iter()
        .fold(0.0, f64::max);
        stretch * f64::from(nearest).min(1.0 / f64::from(self.z_near))
    }

    /// Returns the ray through screen position (x, y), in pixels: origin (the eye, or a point of the near plane of a
    /// parallel view) and direction, both in the space of the sector. The direction has length 1 along the view direction,
    /// measured in eye space.
    pub fn ray(&self, [x, y]: [f64; 2]) -> [[f64; 3]; 2] {
        if self.lens.is_parallel {
            let back = (self.lens.screen_from_eye * self.eye_from_sector).inverse();
            let origin = back.transform_point3(DVec3::new(x, y, 0.0));
            return [origin.into(), (back.matrix3 * DVec3::Z).into()];
        }
        let back = self.screen_from_sector.linear.matrix3.inverse();
        [self.eye(), (back * DVec3::new(x, y, 1.0)).into()]
    }

    /// Whether the view has a parallel (orthographic) projection.
    pub fn is_parallel(&self) -> bool {
        self.lens.is_parallel
    }

    /// Returns the view of an opening of a geometry; `None` if it faces away or is edge-on.
    pub(crate) fn view_of<'a>(&self, geometry: &'a Geometry, opening: OpeningId) -> Option<OpeningView<'a>> {
        OpeningView::new(self, &geometry.openings()[usize::from(opening.0)].outline)
    }

    /// Returns the clip region behind an opening of the sector.
    #[cfg(test)]
    pub(crate) fn aperture_behind(
        &self,
        outline: &ConvexPolygon,
        rows: Option<Rows>,
        spread: f64,
    ) -> Option<Aperture> {
        let view = OpeningView::new(self, outline)?;
        self.aperture.behind(view.corners(), rows, spread, 0.0)
    }

    /// Projects an AABB around openings, which have no near plane.
    pub(crate) fn region_around_openings(&self, bounds: &Aabb) -> Option<Region> {
        const AT_THE_EYE: f64 = 1e-30;
        let (rect, from_here) = (self.aperture.rect(), &self.screen_from_sector);
        if may_touch_eye(bounds, DVec3::from(self.viewpoint())) {
            return Some(Region {
                rect,
                nearest: f32::INFINITY,
                volume: Volume::new(from_here, bounds),
            });
        }
        let clip = Clip {
            near: match self.lens.is_parallel {
                true => self.near_of_openings(),
                false => AT_THE_EYE,
            },
            ..self.into()
        };
        Region::of(clip, from_here, bounds)
    }

    /// Whether any part of a region around openings is in front of the near plane: nothing can hide that part, so
    /// covers need not store depths this near.
    pub(crate) fn is_before_near(&self, region: &Region) -> bool {
        f64::from(region.nearest) * f64::from(self.z_near) >= 1.0
    }

    /// Returns W of the plane that openings are clipped at. In perspective none: an opening that contains the eye must stay
    /// visible. In a parallel view just before the near plane: one behind it leads to where nothing can be seen from here.
    pub(crate) fn near_of_openings(&self) -> f64 {
        if self.lens.is_parallel { 1.0 - 1e-9 } else { 0.0 }
    }

    /// Returns the function of the position in the space of the sector, as its dot product with (x, y, z, 1), that is the
    /// distance along the view direction, in units of eye space: from the eye, or from the near plane of a parallel view.
    pub(crate) fn distance(&self) -> DVec4 {
        let from_here = self.lens.screen_from_eye * self.eye_from_sector;
        from_here.matrix3.row(2).extend(from_here.translation.z)
    }

    /// Returns the same distance at a reversed depth.
    pub(crate) fn distance_at(&self, rev_depth: f64) -> f64 {
        if self.lens.is_parallel {
            (1.0 - rev_depth) * self.lens.far
        } else {
            1.0 / rev_depth
        }
    }

    /// Returns the projection from eye space.
    pub(crate) fn lens(&self) -> &Lens {
        &self.lens
    }

    /// Returns the map from an item's space to (X, Y, W).
    pub(crate) fn screen_from(&self, sector_from_item: &Transform) -> ScreenMap {
        self.screen_from_sector.from(sector_from_item)
    }
}

impl From<&Passage> for Clip {
    fn from(passage: &Passage) -> Clip {
        Clip {
            rect: passage.aperture.rect(),
            near: f64::from(passage.z_near),
            entry: passage.entry,
            spread: passage.spread,
            level: passage.level,
        }
    }
}

/// Returns the hash of a chain extended by a portal. It differs from the hash of the chain itself.
pub(crate) fn next_chain(chain: u64, portal: PortalId) -> u64 {
    // Mixed before the portal is added: portal 1 after sector 0 is not portal 0 after sector 1.
    let mix = |name: u64| name.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
    // The complement, because portal 0 must change the hash of sector 0.
    mix(mix(chain) ^ !u64::from(portal.0))
}

/// Limit of coordinates of bounds, so that depths stay finite where a sector is unbounded.
pub(crate) const FARTHEST_COORDINATE: f64 = 2.0 * MAX_COORDINATE as f64;

/// Returns the length of the longest half-axis of the ellipse that two rows map the unit sphere to.
fn greatest_stretch(a: DVec3, b: DVec3) -> f64 {
    let [aa, bb, ab] = [a.dot(a), b.dot(b), a.dot(b)];
    (0.5 * (aa + bb) + (0.25 * (aa - bb).powi(2) + ab * ab).sqrt()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn two_ways_through_portals_never_share_a_name() {
        let mut names = HashSet::new();
        let mut ways: Vec<u64> = (0..30).collect();
        for _ in 0..3 {
            for &way in &ways {
                assert!(names.insert(way), "two portal chains share the hash {way}");
            }
            ways = ways
                .iter()
                .flat_map(|&way| (0..30).map(move |portal| next_chain(way, PortalId(portal))))
                .collect();
        }
        assert!(names.len() > 25_000);
    }
}
