//! A look: follows openings from sector to sector, and gathers or draws through each passage.

use crate::contract::Contract;
use crate::geometry::{Alpha, Geometry, Owner};
use crate::ids::{PassageId, PortalId};
use crate::mesh::Cluster;
use crate::scene::Scene;
use crate::starts::Starts;
use crate::stats::Stats;
use crate::view::View;
use crate::view::canvas::{Canvas, Span};
use crate::view::collector::{CollectedItem, CollectedOpening, Collector};
use crate::view::memory::Memory;
use crate::view::options::ViewerOptions;
use crate::view::passage::Passage;
use crate::view::region::Region;
#[cfg(feature = "steps")]
use crate::view::step_log::{LookStep, StepLog};
use crate::view::viewer::Viewer;
use crate::view::visible::{VisibleItem, VisibleSet};

impl Viewer {
    /// Computes the visible set of a view.
    ///
    /// Exact and conservative methods miss nothing that is visible at the view's sample positions, strict ones nothing at any
    /// position in a pixel ([`Contract`](crate::Contract)). Returns an empty set without passages for a view whose sector is
    /// not in the scene; [`VisibleSet::complete`] is `false` then.
    #[doc(alias = "cull")]
    #[doc(alias = "visibility query")]
    #[doc(alias = "occlusion query")]
    #[doc(alias = "determine visibility")]
    pub fn look(&mut self, scene: &Scene, view: &View) -> &VisibleSet {
        self.run(scene, view, None);
        &self.set
    }

    /// Draws a view to `canvas`, and returns its visible set as [`Viewer::look`] does.
    #[doc(alias = "render")]
    pub fn draw(&mut self, scene: &Scene, view: &View, canvas: &mut dyn Canvas) -> &VisibleSet {
        let (options, mut sectors) = (self.options_for(view), scene.sectors());
        if sectors.all(|id| !scene.sector(id).draws_what_was_gathered(&options)) {
            self.run(scene, view, Some(canvas));
        } else {
            self.run(scene, view, None);
            self.paint(scene, view, canvas);
        }
        &self.set
    }

    /// Looks, and ends after `limit` steps, as if all that follows were hidden. Returns the steps, and emits the state of
    /// the cover that the last of them left to [`Canvas::cover`]: that of the passage it belongs to.
    ///
    /// For teaching and debugging: one more step goes forwards, one fewer backwards. Uses one thread, covers of the screen's
    /// size, and no coherence. The visible set of the viewer is that of the steps.
    #[cfg(feature = "steps")]
    #[cfg_attr(docsrs, doc(cfg(feature = "steps")))]
    pub fn look_steps(
        &mut self,
        scene: &Scene,
        view: &View,
        limit: usize,
        canvas: &mut dyn Canvas,
    ) -> Vec<LookStep> {
        let options = self.options;
        (self.options.parallel, self.options.coherence) = (false, false);
        self.options.cover_size = None;
        self.memory.steps = Some(Box::new(StepLog::new(limit)));
        self.run(scene, view, None);
        self.options = options;
        let Some(log) = self.memory.steps.take() else {
            return Vec::new();
        };
        log.emit_cover(canvas);
        log.steps
    }

    /// Runs the traversal orders through the last look's passages again, without covers, to measure what the orders
    /// alone cost. Returns the number of faces emitted.
    pub fn walk(&mut self, scene: &Scene) -> u64 {
        let passages = self.set.passages.iter();
        passages
            .map(|passage| scene.sector(passage.sector).walk(passage, &mut self.memory))
            .sum()
    }

    fn run(&mut self, scene: &Scene, view: &View, canvas: Option<&mut dyn Canvas>) {
        self.memory.stats = Stats::default();
        self.memory.trace = canvas.as_ref().is_some_and(|canvas| canvas.wants_work());
        self.memory.recall.begin_look();
        let look = Look {
            scene,
            options: self.options_for(view),
            memory: &mut self.memory,
            set: &mut self.set,
            entered: &mut self.entered,
            spare: &mut self.spare,
            canvas: canvas.map(|canvas| canvas as &mut dyn Canvas),
            gathered: None,
        };
        look.begin(view);
    }

    /// Draws the set of the look just done: the same passages, with apertures that exact methods may shrink.
    fn paint(&mut self, scene: &Scene, view: &View, canvas: &mut dyn Canvas) {
        self.memory.trace = canvas.wants_work();
        self.memory.recall.begin_look();
        let mut by_chain: Vec<_> = (0..).map(PassageId).zip(&self.set.passages).collect();
        by_chain.sort_unstable_by_key(|(_, passage)| passage.chain);
        let look = Look {
            scene,
            options: self.options_for(view),
            memory: &mut self.memory,
            set: &mut self.painted,
            entered: &mut self.entered,
            spare: &mut self.spare,
            canvas: Some(canvas),
            gathered: Some(Gathered {
                set: &self.set,
                by_chain: by_chain
                    .into_iter()
                    .map(|(id, passage)| (passage.chain, id))
                    .collect(),
            }),
        };
        look.begin(view);
    }
}

/// The passages and items to draw; nothing else is drawn.
struct Gathered<'a> {
    set: &'a VisibleSet,
    by_chain: Vec<(u64, PassageId)>,
}

impl Gathered<'_> {
    /// Returns the passage with this chain of portals.
    fn id(&self, chain: u64) -> Option<PassageId> {
        let place = self.by_chain.binary_search_by_key(&chain, |&(chain, _)| chain);
        place.ok().map(|place| self.by_chain[place].1)
    }
}

/// The state of one look in progress.
struct Look<'a> {
    scene: &'a Scene,
    options: ViewerOptions,
    memory: &'a mut Memory,
    set: &'a mut VisibleSet,
    entered: &'a mut Vec<(PassageId, Collector)>,
    spare: &'a mut Vec<Collector>,
    canvas: Option<&'a mut dyn Canvas>,
    gathered: Option<Gathered<'a>>,
}

impl Look<'_> {
    fn begin(mut self, view: &View) {
        let rows = self.set.passages.drain(..).filter_map(|mut passage| {
            let mut rows = passage.aperture.take_rows()?;
            rows.clear();
            Some(rows)
        });
        self.memory.spare_rows.extend(rows);
        self.set.items.clear();
        self.set.clusters.clear();
        let sector = self.scene.sector_of(view);
        // `follow` clears it if a limit is hit.
        self.set.complete = sector.is_some();
        let Some(sector) = sector else { return };
        let mut root = Passage::at_the_eye(view, sector, self.scene.is_flat());
        root.options = self.options;
        let starts = (view.is_parallel() && !view.is_light())
            .then(|| Starts::of(self.scene, view, sector))
            .flatten();
        let Some(starts) = starts else {
            return self.go_through(root);
        };
        for number in 0..starts.sectors().len() {
            let id = starts.sectors()[number];
            let sector = self.scene.sector(id);
            let knows_samples = !sector.draws_what_was_gathered(&self.options)
                && sector.contract(&self.options) != Contract::Strict;
            let by_samples = knows_samples || self.canvas.is_some();
            let spread = self.options.margin().max(self.options.growth()).max(0.5);
            if let Some(aperture) = starts.aperture(number, by_samples, spread) {
                self.go_through(root.starting_in(id, aperture));
            }
        }
    }

    /// Traverses a passage and, depth first, all passages behind its openings.
    ///
    /// The stack is a `Vec`: the limits allow 65,535 portals in a row, too many for recursion on the thread's stack.
    fn go_through(&mut self, root: Passage) {
        // A custom sector may have panicked during the last look.
        self.entered.clear();
        self.pass(root);
        while let Some((id, seen)) = self.entered.last_mut() {
            let id = *id;
            match seen.openings.pop() {
                Some(opening) => {
                    if let Some(child) = self.follow(id, opening) {
                        self.pass(child);
                    }
                }
                None => self.leave(),
            }
        }
    }

    /// Gathers the items visible through a passage, and draws its opaque faces. Its openings are followed next.
    fn pass(&mut self, mut passage: Passage) {
        let scene = self.scene;
        passage.fit(&scene.sector(passage.sector).bounds());
        let own = scene.sector(passage.sector).contract(&self.options);
        let id = PassageId(self.set.passages.len() as u32);
        self.set
            .passages
            .push(passage.with_contract(own, self.canvas.is_some()));
        let sector = scene.sector(self.set.passage(id).sector);
        let mut seen = self.spare.pop().unwrap_or_default();
        self.lend(&mut seen);
        seen.clear(self.canvas.is_some());
        self.enter(id);
        let passage = self.set.passage(id);
        if let Some(gathered) = &self.gathered
            && sector.draws_what_was_gathered(&self.options)
            && let Some(same) = gathered.id(passage.chain)
        {
            seen.report_again(gathered.set, same);
        }
        #[cfg(feature = "steps")]
        if let Some(steps) = &mut self.memory.steps {
            steps.begin_passage(id);
        }
        match self.canvas.as_deref_mut() {
            Some(canvas) => sector.draw(passage, self.memory, &mut seen, canvas),
            None => sector.gather(passage, self.memory, &mut seen),
        }
        self.take_in(id, &seen);
        if self.canvas.is_some() {
            seen.panes.fill(&mut seen.glass);
        }
        self.lend(&mut seen);
        // Openings are followed from the end of the list.
        seen.openings.reverse();
        self.entered.push((id, seen));
    }

    /// Draws the transparent faces of the last passage on the stack over what was visible through its openings.
    fn leave(&mut self) {
        let Some((id, seen)) = self.entered.pop() else {
            return;
        };
        if !seen.panes.is_empty() {
            self.enter(id);
            if let Some(canvas) = self.canvas.as_deref_mut() {
                seen.panes.paint(canvas);
            }
        }
        self.spare.push(seen);
    }

    /// Swaps the shared buffers in or out: only the passage being gathered needs them, and the stack may be deep.
    fn lend(&mut self, seen: &mut Collector) {
        std::mem::swap(&mut seen.spare_rows, &mut self.memory.spare_rows);
        std::mem::swap(&mut seen.glass, &mut self.memory.spare_glass);
        std::mem::swap(&mut seen.report, &mut self.memory.spare_report);
    }

    /// Announces a passage to the canvas, by its index in the set that the caller gets.
    fn enter(&mut self, id: PassageId) {
        let id_in_answer = self.id_in_answer(id);
        if let Some(canvas) = self.canvas.as_deref_mut() {
            canvas.enter(id_in_answer, self.set.passage(id));
        }
    }

    /// Returns the index of a passage in the set that the caller gets, which may differ from the set being drawn.
    fn id_in_answer(&self, id: PassageId) -> PassageId {
        let gathered = self.gathered.as_ref();
        let same = gathered.and_then(|gathered| gathered.id(self.set.passage(id).chain));
        same.unwrap_or(id)
    }

    /// Adds the items that a sector reported to the set.
    fn take_in(&mut self, id: PassageId, seen: &Collector) {
        let passage = &self.set.passages[id.0 as usize];
        let geometry = self.scene.geometry(passage.sector);
        let shift = self.set.clusters.len() as u32;
        self.set.clusters.extend(&seen.clusters);
        let blends = |geometry: &Geometry, item: &CollectedItem| {
            let clusters = geometry.mesh_of(item.item).clusters();
            let is_glass = |cluster: &Cluster| geometry.material(cluster).alpha == Alpha::Blend;
            match &seen.clusters[item.clusters[0] as usize..item.clusters[1] as usize] {
                [] => clusters.iter().any(is_glass),
                known => known.iter().any(|&number| is_glass(&clusters[number as usize])),
            }
        };
        let is_drawn = |geometry: &Geometry, item: &CollectedItem| geometry.item(item.item).options.is_drawn;
        let drawn = seen
            .items
            .iter()
            .filter(|item| geometry.is_none_or(|geometry| is_drawn(geometry, item)));
        let anyway = geometry
            .map_or(&[][..], |geometry| geometry.never_culled())
            .iter()
            .filter(|&&item| {
                let is_new = seen.items.binary_search_by_key(&item, |seen| seen.item).is_err();
                is_new && geometry.is_some_and(|geometry| passage.takes_always(geometry.item(item)))
            });
        let anyway = anyway.map(|&item| CollectedItem {
            item,
            clusters: [0, 0],
        });
        let first = self.set.items.len();
        self.set.items.extend(drawn.copied().chain(anyway).map(|seen| {
            let (item, key, region) = match geometry {
                Some(geometry) => {
                    let screen_from_item = passage.screen_from(&geometry.item(seen.item).transform());
                    let region =
                        Region::of(passage, &screen_from_item, &geometry.mesh_of(seen.item).bounds());
                    (geometry.id_of(seen.item), geometry.key(seen.item), region)
                }
                None => {
                    let sector = self.scene.sector(passage.sector);
                    let bounds = sector.item_bounds(seen.item);
                    let region = Region::of(passage, &passage.screen_from_sector, &bounds);
                    (seen.item.into(), sector.item_key(seen.item), region)
                }
            };
            let size_px = region.map_or(0, |Region { rect, .. }| {
                (rect.x1 - rect.x0).max(rect.y1 - rect.y0)
            });
            VisibleItem {
                passage: id,
                item,
                key,
                size_px,
                blends: geometry.is_some_and(|geometry| blends(geometry, &seen)),
                clusters: seen.clusters.map(|at| at + shift),
            }
        }));
        if geometry.is_some_and(|geometry| !geometry.never_culled().is_empty()) {
            self.set.items[first..].sort_unstable_by_key(|seen| seen.item);
        }
    }

    /// Returns the passage behind an opening if its portal is open and within the limits; otherwise draws the opening
    /// as a face.
    fn follow(&mut self, id: PassageId, seen: CollectedOpening) -> Option<Passage> {
        let passage = self.set.passage(id);
        let way = self.scene.portal_of(passage.sector, seen.opening);
        let Some(portal_id) = way.filter(|&PortalId(index)| self.scene.portals()[index as usize].open) else {
            self.paint_closed(id, seen);
            return None;
        };
        let full = self.set.passages.len() >= self.options.limits.max_passages as usize;
        if full || passage.crossings >= self.options.limits.max_crossings {
            self.set.complete = false;
            self.paint_closed(id, seen);
            return None;
        }
        let portal = &self.scene.portals()[portal_id.0 as usize];
        let outline = &self.scene.sector(passage.sector).openings()[usize::from(seen.opening.0)].outline;
        // Drawing stops where the look before hit a limit.
        let gathered = self.gathered.as_ref();
        if gathered.is_some_and(|gathered| gathered.id(passage.chain_through(portal_id)).is_none()) {
            self.paint_closed(id, seen);
            return None;
        }
        let own_id = self.id_in_answer(id);
        let (to, moved) = (portal.to, &portal.there_from_here);
        passage.through(own_id, portal_id, to, moved, outline, seen.rows)
    }

    fn paint_closed(&mut self, id: PassageId, seen: CollectedOpening) {
        let Some(mut rows) = seen.rows else {
            return;
        };
        self.enter(id);
        if let Some(canvas) = self.canvas.as_deref_mut() {
            let owner = Owner::Opening(seen.opening);
            let span = |&[x0, x1]: &[u16; 2]| Span {
                x0,
                x1,
                owner,
                see_through: false,
            };
            let mut spans: Vec<Span> = Vec::new();
            for y in rows.range() {
                spans.clear();
                spans.extend(rows.row(y).iter().map(span));
                canvas.row(y, &spans);
            }
        }
        rows.clear();
        self.memory.spare_rows.push(rows);
    }
}
