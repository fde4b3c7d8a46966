//! The reference: traces rays through portals to find the possible owners of each sample.

use super::EPSILON;
use super::bundle::Bundle;
use super::chains::{Chain, ChainId, Chains};
use super::hits::Hits;
use super::layers::{Layers, Pane};
use super::lens::{Lens, POSITIONS, RAYS, of_pixel};
use super::openings::Entered;
use super::sector::{Starts, sector_of_eye, sectors_of_start};
use super::tree::{Meeting, MeshTrees, Trees};
use super::truth::{Possible, RowTruth, Truth};
use crate::geometry::Owner;
use crate::ids::{ItemIndex, OpeningId, SectorId};
use crate::scene::Scene;
use crate::view::View;
use crate::view::options::Limits;
use glam::{DAffine3, DVec4};
use rayon::prelude::*;
use std::collections::HashSet;

/// An independent ray-cast oracle for a scene: computes which surfaces are visible at each sample.
///
/// Every method's result is compared with it; see [`Truth::check`] and [`Contestants`](super::Contestants).
#[doc(alias = "ray tracer")]
#[doc(alias = "ground truth")]
#[doc(alias = "oracle")]
pub struct Reference {
    sectors: Vec<Option<Trees>>,
}

impl Reference {
    /// Builds the ray-tracing trees; this is the slow part. Custom sectors are empty for the reference.
    ///
    /// It knows all [`ItemOptions`](crate::ItemOptions) but the limits of distance and size, and looks at all layers.
    pub fn new(scene: &Scene) -> Reference {
        Reference::of_layers(scene, u32::MAX)
    }

    /// As [`Reference::new`], for looks at some layers ([`ViewerOptions::layers`](crate::ViewerOptions::layers)).
    pub fn of_layers(scene: &Scene, layers: u32) -> Reference {
        let mut built = MeshTrees::default();
        let sectors = scene
            .sectors()
            .map(|id| {
                scene
                    .geometry(id)
                    .map(|geometry| Trees::build(geometry, layers, &mut built))
            })
            .collect();
        Reference { sectors }
    }

    /// Traces five rays through each sample of a view, on all threads of the current rayon pool. `limits` must be those
    /// of the viewers under test.
    pub fn see(&self, scene: &Scene, view: &View, limits: &Limits) -> Truth {
        let lens = Lens::new(scene, view);
        let rows = self.rows(
            scene,
            view,
            &lens,
            limits,
            |tracer, pixel, row: &mut RowTruth| {
                row.sample(tracer.along(lens.about_centre(pixel), RAYS));
            },
            RowTruth::settle,
        );
        Truth::new(view.size(), rows, listed_anyway(scene))
    }

    /// Traces one ray through each of `places` random positions per pixel, chosen by `seed`: every item hit must be in
    /// the visible set of a strict method. The result cannot check a picture.
    pub fn see_anywhere(&self, scene: &Scene, view: &View, limits: &Limits, places: u32, seed: u64) -> Truth {
        let lens = Lens::new(scene, view);
        let rows = self.rows(
            scene,
            view,
            &lens,
            limits,
            |tracer, pixel, row: &mut RowTruth| {
                let mut chance = of_pixel(seed, pixel);
                let mut left = places as usize;
                while left > 0 {
                    // Rays of one pixel traverse the same AABBs; tracing them as a bundle is faster.
                    let used = left.min(POSITIONS);
                    let seen = tracer.along(lens.anywhere(pixel, used, &mut chance), used);
                    seen.chunks(1).for_each(|ray| row.position(ray));
                    left -= used;
                }
            },
            RowTruth::settle,
        );
        Truth::new(view.size(), rows, listed_anyway(scene))
    }

    /// Finds the alpha-blended and alpha-tested layers in front of the opaque surface at each sample of a view, in
    /// order.
    pub fn layers(&self, scene: &Scene, view: &View, limits: &Limits) -> Layers {
        let lens = Lens::new(scene, view);
        let rows = self.rows(
            scene,
            view,
            &lens,
            limits,
            |tracer, pixel, layers: &mut Layers| {
                layers.sample(tracer.along(lens.about_centre(pixel), RAYS));
            },
            |_| {},
        );
        Layers::of_rows(view.size(), rows)
    }

    /// Calls `pixel` for each pixel and `settle` after each row, rows in parallel. Returns the chains and the result of
    /// each row.
    fn rows<const N: usize, T: Default + Send>(
        &self,
        scene: &Scene,
        view: &View,
        lens: &Lens,
        limits: &Limits,
        pixel: impl Fn(&mut RowTracer<'_, N>, [u32; 2], &mut T) + Sync,
        settle: impl Fn(&mut T) + Sync,
    ) -> Vec<(Chains, T)> {
        let Some(sector) = sector_of_eye(scene, view) else {
            return Vec::new();
        };
        let row = |y| {
            let mut tracer = RowTracer {
                reference: self,
                scene,
                limits,
                near: lens.near,
                oblique: lens.oblique,
                is_parallel: view.is_parallel(),
                sector,
                chains: Chains::default(),
                rays: std::array::from_fn(|_| RayResult::default()),
                pending: Vec::new(),
            };
            let mut result = T::default();
            (0..view.size()[0]).for_each(|x| pixel(&mut tracer, [x, y], &mut result));
            settle(&mut result);
            (tracer.chains, result)
        };
        (0..view.size()[1]).into_par_iter().map(row).collect()
    }
}

/// Possible results of one ray, over all portal chains that it may follow.
#[derive(Clone, Default)]
pub(super) struct RayResult {
    pub(super) possible: Vec<Possible>,
    /// Alpha-blended and alpha-tested hits in front of the opaque surface.
    pub(super) glass: Vec<Pane>,
    /// Items that are only bounds and begin in front of the opaque surface, and whether they certainly do.
    pub(super) bounds: Vec<(Chain, ItemIndex, bool)>,
}

/// Traces the bundles of one row, one after another.
struct RowTracer<'a, const N: usize> {
    reference: &'a Reference,
    scene: &'a Scene,
    limits: &'a Limits,
    near: f64,
    /// Oblique near plane, in the space of the eye's sector.
    oblique: Option<DVec4>,
    is_parallel: bool,
    /// Sector of the eye.
    sector: SectorId,
    chains: Chains,
    rays: [RayResult; N],
    pending: Vec<TracedBundle<N>>,
}

/// A bundle in a sector, behind a chain of portals.
struct TracedBundle<const N: usize> {
    chain: Chain,
    bundle: Bundle<N>,
    active: [bool; N],
    /// Whether each ray certainly follows this chain.
    certain: [bool; N],
    /// Minimum and maximum parameter at which each ray passes the last portal; 0 at the eye.
    entry: [[f64; 2]; N],
    depth: u16,
}

/// An opening that rays of the bundle enter.
struct OpeningEntry<const N: usize> {
    opening: OpeningId,
    active: [bool; N],
    /// Minimum and maximum parameter at which each ray enters.
    entry: [[f64; 2]; N],
}

impl<const N: usize> OpeningEntry<N> {
    fn new(opening: OpeningId) -> OpeningEntry<N> {
        OpeningEntry {
            opening,
            active: [false; N],
            entry: [[0.0; 2]; N],
        }
    }
}

impl<const N: usize> RowTracer<'_, N> {
    /// Traces the first `used` rays of a bundle from the eye.
    fn along(&mut self, bundle: Bundle<N>, used: usize) -> &[RayResult] {
        for ray in &mut self.rays {
            ray.possible.clear();
            ray.glass.clear();
            ray.bounds.clear();
        }
        // Openings are not clipped at the near plane of a perspective view: one that contains the eye must stay open.
        let start = if self.is_parallel { self.near } else { 0.0 };
        let mut entry = [[start; 2]; N];
        let mut active: [bool; N] = std::array::from_fn(|ray| ray < used);
        if let Some(plane) = self.oblique {
            for ray in 0..N {
                let [origin, direction] = [bundle.origin_of(ray), bundle.directions[ray]];
                let [at, slope] = [plane.dot(origin.extend(1.0)), plane.truncate().dot(direction)];
                entry[ray] = [-at / slope; 2];
                // Rays along the plane see nothing behind it.
                active[ray] &= slope > 0.0;
            }
        }
        let chain = |sector| Chain {
            id: ChainId::default(),
            sector,
        };
        for ray in (0..used).filter(|&ray| !active[ray]) {
            let chain = chain(self.sector);
            self.rays[ray].possible.push(Possible { chain, owner: None });
        }
        let starts: [Starts; N] = std::array::from_fn(|ray| match self.is_parallel {
            true => {
                let [origin, direction] = [bundle.origin_of(ray), bundle.directions[ray]];
                sectors_of_start(self.scene, self.sector, origin, self.near * direction)
            }
            false => Starts::from_slice(&[self.sector]),
        });
        let mut all: Vec<SectorId> = starts[..used].iter().flatten().copied().collect();
        all.sort_unstable();
        all.dedup();
        for sector in all {
            self.pending.push(TracedBundle {
                chain: chain(sector),
                bundle,
                active: std::array::from_fn(|ray| active[ray] && starts[ray].contains(&sector)),
                certain: std::array::from_fn(|ray| starts[ray].len() == 1),
                entry,
                depth: 0,
            });
        }
        while let Some(way) = self.pending.pop() {
            self.follow(&way);
        }
        &self.rays[..used]
    }

    /// Traces the active rays through a sector.
    fn follow(&mut self, way: &TracedBundle<N>) {
        let TracedBundle { chain, certain, .. } = *way;
        let Some(trees) = &self.reference.sectors[chain.sector.0 as usize] else {
            return;
        };
        let from = way.entry.map(|entry| entry.map(|w| w.max(self.near)));
        let mut hits = Hits::new(way.active, from);
        if !self.scene.is_flat() {
            meet_openings(way, trees, &mut hits);
        }
        trees.walk(&way.bundle, &way.active, &mut hits);

        let mut ahead: Vec<OpeningEntry<N>> = Vec::new();
        // Number of openings that each ray enters, and whether it may end in this sector.
        let (mut ways, mut ends) = ([0; N], [false; N]);
        for &(Meeting { ray, w, hides, .. }, owner) in hits.meetings() {
            match owner {
                Owner::Opening(opening) if self.leads_on(way, opening) => {
                    ways[ray] += 1;
                    let known = ahead.iter().position(|known| known.opening == opening);
                    let known = known.unwrap_or_else(|| {
                        ahead.push(OpeningEntry::new(opening));
                        ahead.len() - 1
                    });
                    ahead[known].active[ray] = true;
                    ahead[known].entry[ray] = w;
                }
                Owner::Face(item, face) if !hides => {
                    let in_front = w[1] < hits.first_hiding(ray) * (1.0 - EPSILON);
                    let sure = certain[ray] && in_front && hits.certainly_beyond(ray, w[0]);
                    self.rays[ray].glass.push(Pane {
                        chain,
                        item,
                        face,
                        depth: way.depth,
                        w,
                        sure,
                    });
                }
                owner => {
                    ends[ray] = true;
                    // What is not drawn hides, and leaves the background.
                    let is_drawn = owner.item().is_none_or(|item| trees.is_drawn(item));
                    let owner = is_drawn.then_some(owner);
                    self.rays[ray].possible.push(Possible { chain, owner });
                }
            }
        }
        trees.pass_bounds(&way.bundle, &way.active, |ray, item, [enter, leave]| {
            let begins = enter.max(from[ray][1]);
            if leave > from[ray][0] && begins <= hits.nearest(ray) {
                let in_front = begins < hits.first_hiding(ray) * (1.0 - EPSILON);
                let sure = certain[ray] && in_front && leave > from[ray][1] * (1.0 + EPSILON);
                self.rays[ray].bounds.push((chain, item, sure));
            }
        });
        for ray in (0..N).filter(|&ray| way.active[ray] && hits.nearest(ray) == f64::INFINITY) {
            ends[ray] = true;
            self.rays[ray].possible.push(Possible { chain, owner: None });
        }
        let certain = std::array::from_fn(|ray| certain[ray] && ways[ray] == 1 && !ends[ray]);
        for ahead in ahead {
            self.go_through(way, &ahead, certain);
        }
    }

    fn leads_on(&self, way: &TracedBundle<N>, opening: OpeningId) -> bool {
        let portal = self.scene.portal_of(way.chain.sector, opening);
        portal.is_some_and(|id| self.scene.portals()[id.0 as usize].open)
            && way.depth < self.limits.max_crossings
    }

    fn go_through(&mut self, way: &TracedBundle<N>, ahead: &OpeningEntry<N>, certain: [bool; N]) {
        let Some(portal_id) = self.scene.portal_of(way.chain.sector, ahead.opening) else {
            return;
        };
        let portal = &self.scene.portals()[portal_id.0 as usize];
        let there_from_here: DAffine3 = portal.there_from_here.0;
        self.pending.push(TracedBundle {
            chain: Chain {
                id: self.chains.through(way.chain.id, portal_id),
                sector: portal.to,
            },
            bundle: way.bundle.moved(&there_from_here),
            active: ahead.active,
            certain,
            entry: ahead.entry,
            depth: way.depth + 1,
        });
    }
}

/// Returns the items that also an exact method may list although they are hidden: those that are only bounds, and those
/// that are never culled.
fn listed_anyway(scene: &Scene) -> HashSet<(SectorId, ItemIndex)> {
    let mut listed = HashSet::new();
    for sector in scene.sectors() {
        let Some(geometry) = scene.geometry(sector) else {
            continue;
        };
        for (item, placed) in (0..).map(ItemIndex).zip(geometry.items()) {
            if placed.options.never_cull || geometry.mesh_of(item).face_count() == 0 {
                listed.insert((sector, item));
            }
        }
    }
    listed
}

/// Adds the openings that the rays enter.
fn meet_openings<const N: usize>(way: &TracedBundle<N>, trees: &Trees, hits: &mut Hits<N>) {
    for (outline, number) in trees.openings().iter().zip(0..) {
        for ray in (0..N).filter(|&ray| way.active[ray]) {
            let Some(Entered { w, sure }) = outline.entered(&way.bundle, ray) else {
                continue;
            };
            // Not clipped at the near plane: an opening that contains the eye must stay open.
            let [first, last] = way.entry[ray];
            if w[1] >= first * (1.0 - EPSILON) {
                let certain = sure && (last == 0.0 || w[0] > last * (1.0 + EPSILON));
                let meeting = Meeting {
                    ray,
                    w,
                    item: ItemIndex(u32::MAX),
                    face: 0,
                    hides: true,
                };
                hits.take(meeting, Owner::Opening(OpeningId(number)), certain);
            }
        }
    }
}
