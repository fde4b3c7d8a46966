//! One way from the eye into a sector, through zero or more portals.

use crate::aperture::{Aperture, CellRoom, Rect, Rows};
use crate::entrance::Entrance;
use crate::geom::{Aabb, ConvexPolygon, Transform};
use crate::geometry::{Geometry, OpeningId};
use crate::opening_view::{OpeningView, may_touch_eye};
use crate::region::{Region, Volume};
use crate::scene::{Portal, PortalId, SectorId};
use crate::sector::Contract;
use crate::view::View;
use fearless_simd::Level;
use glam::{DAffine3, DMat3, DVec3};

/// A passage of a look, by its place in [`VisibleSet::passages`](crate::VisibleSet::passages).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PassageId(pub u32);

/// One way from the eye into a sector, through zero or more portals: the state of the recursion, the record an
/// engine draws from, and the answer to "which rooms are seen".
#[derive(Clone, Debug)]
pub struct Passage {
    /// The passage one step nearer to the eye; `None` for the one that the eye stands in.
    pub parent: Option<PassageId>,
    /// The portal through which it leaves its parent.
    pub portal: Option<PortalId>,
    /// The sector it leads into.
    pub sector: SectorId,
    /// Portals followed on the way, 0 where the eye stands.
    pub crossings: u16,
    /// What is promised of what is reported through it: by its sector and all on the way to it together.
    pub contract: Contract,
    /// The part of the screen that is left.
    pub aperture: Aperture,
    /// What is nearer than this along the line of sight neither is seen nor hides.
    pub near: f32,
    /// The whole screen, in pixels.
    pub(crate) size: [u32; 2],
    /// Are openings plain holes?
    pub(crate) flat: bool,
    /// Is what is seen anywhere in a pixel asked for, not only what is seen in its middle?
    pub(crate) any_place: bool,
    /// Names the chain of portals: equal for the same way in the next frame.
    pub(crate) chain: u64,
    /// What boxes are asked about at, known once a look.
    pub(crate) level: Level,
    eye_from_sector: DAffine3,
    screen_from_eye: DMat3,
    pub(crate) screen_from_sector: DAffine3,
    /// What lies beyond the last portal: n · (X, Y, W) ≥ d, with d ≥ 0.
    pub(crate) entry: Option<(DVec3, f64)>,
    /// Where sight enters the sector; `None` where the eye stands in it.
    pub(crate) entrance: Option<Entrance>,
}

/// How far beyond the plane of the last portal a face must be, relatively: what lies in it is not beyond it.
pub(crate) const BEYOND: f64 = 1.0 + 1.0 / (1_u64 << 18) as f64;

impl Passage {
    /// The passage that the eye stands in.
    pub(crate) fn at_the_eye(view: &View, sector: SectorId, flat: bool) -> Passage {
        let (eye_from_sector, screen_from_eye) = (view.eye_from_sector(), view.screen_from_eye());
        Passage {
            parent: None,
            portal: None,
            sector,
            crossings: 0,
            contract: Contract::Approximate,
            aperture: Aperture::screen(view.size),
            near: view.near,
            size: view.size,
            flat,
            any_place: false,
            chain: u64::from(sector.0),
            level: crate::simd::level(),
            eye_from_sector,
            screen_from_eye,
            screen_from_sector: compose(&screen_from_eye, &eye_from_sector),
            entry: None,
            entrance: None,
        }
    }

    /// What is left behind an opening of this passage's sector; `None` where no sample is.
    pub(crate) fn through(
        &self,
        own_id: PassageId,
        portal_id: PortalId,
        portal: &Portal,
        outline: &ConvexPolygon,
        rows: Option<Rows>,
    ) -> Option<Passage> {
        let view = OpeningView::new(self, outline)?;
        let aperture = self.aperture.behind(view.corners(), rows, self.any_place)?;
        let here_from_there = portal.there_from_here.inverse()?;
        let eye_from_sector = self.eye_from_sector * here_from_there.0;
        Some(Passage {
            parent: Some(own_id),
            portal: Some(portal_id),
            sector: portal.to,
            crossings: self.crossings + 1,
            contract: self.contract,
            aperture,
            near: self.near,
            size: self.size,
            flat: self.flat,
            any_place: false,
            chain: self.chain_through(portal_id),
            level: self.level,
            eye_from_sector,
            screen_from_eye: self.screen_from_eye,
            screen_from_sector: compose(&self.screen_from_eye, &eye_from_sector),
            entry: Some(view.plane()),
            entrance: Some(Entrance::new(outline, &portal.there_from_here)),
        })
    }

    /// The name of the way that goes on through a portal.
    pub(crate) fn chain_through(&self, portal: PortalId) -> u64 {
        next_chain(self.chain, portal)
    }

    /// The same passage for a sector with this contract. What is `painted` has samples, whatever a method promises of
    /// the places between them.
    pub(crate) fn held_to(self, own: Contract, painted: bool) -> Passage {
        Passage {
            contract: match self.parent {
                Some(_) => self.contract.combined_with(own),
                None => own,
            },
            any_place: own == Contract::Strict && !painted,
            ..self
        }
    }

    /// The same passage on a screen of fewer pixels, here cells: what any place in them shows is asked for.
    pub(crate) fn in_cells(&self, cells: [u32; 2], room: &mut CellRoom) -> Passage {
        let scale = [0, 1].map(|axis| f64::from(cells[axis]) / f64::from(self.size[axis]));
        let scaling = DMat3::from_diagonal(DVec3::new(scale[0], scale[1], 1.0));
        let screen_from_eye = scaling * self.screen_from_eye;
        let aperture = if self.parent.is_none() {
            Aperture::screen(cells)
        } else {
            self.aperture.in_cells(scale, room)
        };
        Passage {
            size: cells,
            any_place: true,
            screen_from_eye,
            screen_from_sector: compose(&screen_from_eye, &self.eye_from_sector),
            entry: self
                .entry
                .map(|(normal, distance)| (normal / DVec3::new(scale[0], scale[1], 1.0), distance)),
            ..self.with_aperture(aperture)
        }
    }

    /// The same passage with another aperture.
    pub(crate) fn with_aperture(&self, aperture: Aperture) -> Passage {
        Passage {
            parent: self.parent,
            portal: self.portal,
            sector: self.sector,
            crossings: self.crossings,
            contract: self.contract,
            aperture,
            near: self.near,
            size: self.size,
            flat: self.flat,
            any_place: self.any_place,
            chain: self.chain,
            level: self.level,
            eye_from_sector: self.eye_from_sector,
            screen_from_eye: self.screen_from_eye,
            screen_from_sector: self.screen_from_sector,
            entry: self.entry,
            entrance: self.entrance,
        }
    }

    /// From the space of the sector to eye space: x right, y up, z back.
    pub fn eye_from_sector(&self) -> Transform {
        Transform(self.eye_from_sector)
    }

    /// Is the sector seen mirrored?
    pub fn mirrored(&self) -> bool {
        self.eye_from_sector().mirrors()
    }

    /// Lengths in eye space for one in the space of the sector.
    pub(crate) fn eye_scale(&self) -> f64 {
        self.eye_from_sector.matrix3.x_axis.length()
    }

    /// How far rounding may move a corner in the space of (X, Y, W): more the farther the eye is from the sector's
    /// origin, for its coordinates there cancel.
    pub(crate) fn corner_rounding(&self) -> f64 {
        const ROUNDING: f64 = 1.0 / (1_u64 << 50) as f64;
        ROUNDING * self.screen_from_sector.translation.length()
    }

    /// The eye's place in the space of the sector; behind a portal, where it would stand there.
    pub fn eye(&self) -> [f64; 3] {
        eye_in(&self.screen_from_sector).into()
    }

    /// Where the eye stands, and against the line of sight, in the space of the sector.
    pub(crate) fn stance(&self) -> (DVec3, DVec3) {
        let back = self.eye_from_sector.matrix3.transpose() * DVec3::Z;
        (eye_in(&self.screen_from_sector), back.normalize_or_zero())
    }

    /// May any part of a box, given in another space, be in the view's frustum and beyond the last portal?
    pub(crate) fn frustum_meets(&self, screen_from_local: &DAffine3, bounds: &Aabb) -> bool {
        let limits = Rect {
            x0: 0,
            y0: 0,
            x1: self.size[0] as u16,
            y1: self.size[1] as u16,
        };
        Region::in_rect(self, limits, f64::from(self.near), screen_from_local, bounds).is_some()
    }

    /// May any part of a box in the space of the sector be seen through the passage, were nothing in its way?
    pub fn may_show(&self, bounds: &Aabb) -> bool {
        Region::of(self, &self.screen_from_sector, bounds).is_some()
    }

    /// By how many pixels a point of an item moves on the screen, at most, where it is moved by one unit of the item's space
    /// somewhere within `bounds`, a box of that space; 0 where none of the box may be seen.
    pub fn pixels_per_unit(&self, sector_from_item: &Transform, bounds: &Aabb) -> f64 {
        let screen_from_item = self.screen_from(sector_from_item);
        let Some(Region { rect, nearest, .. }) = Region::of(self, &screen_from_item, bounds) else {
            return 0.0;
        };
        let rows = screen_from_item.matrix3.transpose();
        // The screen place (X, Y) / W moves by (dX − x dW, dY − y dW) / W: most at a corner, for it is convex in x and y.
        let stretch = [
            [rect.x0, rect.y0],
            [rect.x1, rect.y0],
            [rect.x0, rect.y1],
            [rect.x1, rect.y1],
        ]
        .map(|corner| {
            let [x, y] = corner.map(f64::from);
            let [a, b] = [rows.x_axis - x * rows.z_axis, rows.y_axis - y * rows.z_axis];
            let [aa, bb, ab] = [a.dot(a), b.dot(b), a.dot(b)];
            (0.5 * (aa + bb) + (0.25 * (aa - bb).powi(2) + ab * ab).sqrt()).sqrt()
        })
        .into_iter()
        .fold(0.0, f64::max);
        stretch * f64::from(nearest).min(1.0 / f64::from(self.near))
    }

    /// Where the eye stands in the space of the sector, and the direction in which it sees the place (x, y) of the
    /// screen, in pixels: of a length of 1 along the line of sight, in units at the eye.
    pub fn ray(&self, [x, y]: [f64; 2]) -> [[f64; 3]; 2] {
        let back = self.screen_from_sector.matrix3.inverse();
        [self.eye(), (back * DVec3::new(x, y, 1.0)).into()]
    }

    /// An opening of a geometry as the eye meets it; `None` where it faces away or is seen edge-on.
    pub(crate) fn view_of<'a>(&self, geometry: &'a Geometry, opening: OpeningId) -> Option<OpeningView<'a>> {
        OpeningView::new(self, &geometry.openings()[usize::from(opening.0)].outline)
    }

    /// What of the aperture is left behind an opening of the sector.
    #[cfg(test)]
    pub(crate) fn aperture_behind(
        &self,
        outline: &ConvexPolygon,
        rows: Option<Rows>,
        any_place: bool,
    ) -> Option<Aperture> {
        let view = OpeningView::new(self, outline)?;
        self.aperture.behind(view.corners(), rows, any_place)
    }

    /// What is seen of a box around openings, which have no near limit.
    pub(crate) fn region_around_openings(&self, bounds: &Aabb) -> Option<Region> {
        const AT_THE_EYE: f64 = 1e-30;
        let (rect, from_here) = (self.aperture.rect(), &self.screen_from_sector);
        if may_touch_eye(bounds, DVec3::from(self.eye())) {
            return Some(Region {
                rect,
                nearest: f32::INFINITY,
                volume: Volume::new(from_here, bounds),
            });
        }
        Region::in_rect(self, rect, AT_THE_EYE, from_here, bounds).filter(|region| !region.rect.is_empty())
    }

    /// Whether any part of a region around openings comes before the near distance: nothing can hide that part, and covers
    /// need not know what is so near.
    pub(crate) fn is_before_near(&self, region: &Region) -> bool {
        f64::from(region.nearest) * f64::from(self.near) >= 1.0
    }

    /// Pixels that stand for a distance of 1 across the line of sight, at a distance of 1 along it.
    pub(crate) fn focal(&self) -> f64 {
        self.screen_from_eye.x_axis.x
    }

    /// From an item's space to (X, Y, W).
    pub(crate) fn screen_from(&self, sector_from_item: &Transform) -> DAffine3 {
        self.screen_from_sector * sector_from_item.0
    }
}

/// The name of a chain of portals that is one longer; never that of the chain itself.
pub(crate) fn next_chain(chain: u64, portal: PortalId) -> u64 {
    // Mixed before the portal comes in: portal 1 after sector 0 is not portal 0 after sector 1.
    let mix = |name: u64| name.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
    // The complement, for portal 0 must change the name of sector 0.
    mix(mix(chain) ^ !u64::from(portal.0))
}

/// Where the eye stands in the space that `screen_from_local` maps from; the origin where that is flattened.
pub(crate) fn eye_in(screen_from_local: &DAffine3) -> DVec3 {
    let back = screen_from_local.matrix3.inverse() * -screen_from_local.translation;
    if back.is_finite() { back } else { DVec3::ZERO }
}

fn compose(screen_from_eye: &DMat3, eye_from_sector: &DAffine3) -> DAffine3 {
    DAffine3 {
        matrix3: *screen_from_eye * eye_from_sector.matrix3,
        translation: *screen_from_eye * eye_from_sector.translation,
    }
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
                assert!(names.insert(way), "{way} is the name of two ways");
            }
            ways = ways
                .iter()
                .flat_map(|&way| (0..30).map(move |portal| next_chain(way, PortalId(portal))))
                .collect();
        }
        assert!(names.len() > 25_000);
    }
}
