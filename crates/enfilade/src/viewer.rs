//! The working memory of one camera, and how it follows openings from sector to sector.

use crate::canvas::{Canvas, Span};
use crate::collector::{CollectedItem, CollectedOpening, Collector};
use crate::geometry::{Alpha, Geometry, Owner};
use crate::memory::Memory;
use crate::mesh::Cluster;
use crate::passage::{Passage, PassageId};
use crate::region::Region;
use crate::scene::{PortalId, Scene};
use crate::stats::Stats;
use crate::view::View;
use crate::visible::{VisibleItem, VisibleSet};

/// Looks at scenes with one camera, and keeps what it learns from frame to frame.
///
/// Many viewers may look at one scene at once.
#[derive(Default)]
pub struct Viewer {
    memory: Memory,
    set: VisibleSet,
    /// What painting a set goes through, where that takes a second time.
    painted: VisibleSet,
    /// Passages whose openings are being followed, each behind an opening of the one before; empty between looks.
    entered: Vec<(PassageId, Collector)>,
    spare: Vec<Collector>,
    limits: Limits,
    cover_size: Option<[u32; 2]>,
}

/// Where following openings ends. What bites makes the set incomplete, and says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Portals followed in a row, 0 to 65,535.
    pub max_crossings: u16,
    /// Passages of one look, at least 1.
    pub max_passages: u32,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            max_crossings: 64,
            max_passages: 65_536,
        }
    }
}

impl Viewer {
    /// A viewer that remembers nothing yet.
    pub fn new() -> Viewer {
        Viewer::default()
    }

    /// Where following openings ends.
    pub fn limits(&self) -> Limits {
        self.limits
    }

    /// Changes where following openings ends.
    pub fn set_limits(&mut self, limits: Limits) {
        self.limits = limits;
    }

    /// May what the last look saw be seen first? On unless told; it changes the cost, never the answer.
    pub fn set_coherence(&mut self, coherence: bool) {
        self.memory.coherence = coherence;
        self.memory.recall.forget();
    }

    /// May a look use all threads of the rayon pool that it is called in, or else of the global one? On unless told, as far as
    /// the library has the feature `rayon`; in a pool of one thread it makes no difference. It changes the cost and what
    /// [`Viewer::stats`] counts, never the answer.
    ///
    /// Off suits a program that looks by many viewers at once, or must not wait for its pool: while a look waits for other
    /// threads, its own may be given other work of the pool, so hold no lock then that such work takes. Threads have buffers
    /// of their own, all together about as large as those of one. Drawing is done by the caller's thread.
    pub fn set_parallel(&mut self, parallel: bool) {
        self.memory.parallel = parallel;
    }

    /// How many occluders methods take that choose them, for each passage; `None`, as many as suits each method, unless
    /// told. It changes what is called visible, never so that anything visible is missed. 0: trees leave out only what is
    /// out of view; the masked buffer has the faces that it finds.
    pub fn set_occluders(&mut self, occluders: Option<u32>) {
        self.memory.occluders = occluders;
    }

    /// Columns and rows of the covers of methods that can do with fewer than the screen's
    /// ([`Method::takes_cover_size`](crate::Method::takes_cover_size)); `None`, as many as the screen has, unless told.
    /// The fewer, the less a look costs and the more it calls visible: such a method is conservative. Where it is none or
    /// more than the screen has, the nearest that makes sense is taken.
    pub fn set_cover_size(&mut self, cover_size: Option<[u32; 2]>) {
        self.cover_size = cover_size;
    }

    /// What can be seen. A view that fails [`View::check`] sees nothing.
    pub fn look(&mut self, scene: &Scene, view: &View) -> &VisibleSet {
        self.shape_covers(view);
        self.run(scene, view, None);
        &self.set
    }

    /// Paints what can be seen, and gives the set as [`Viewer::look`] does.
    pub fn draw(&mut self, scene: &Scene, view: &View, canvas: &mut dyn Canvas) -> &VisibleSet {
        self.shape_covers(view);
        let (memory, mut sectors) = (&self.memory, scene.sectors());
        if sectors.all(|id| !scene.sector(id).draws_what_was_gathered(memory)) {
            self.run(scene, view, Some(canvas));
        } else {
            self.run(scene, view, None);
            self.paint(scene, view, canvas);
        }
        &self.set
    }

    /// What the last look saw.
    pub fn visible(&self) -> &VisibleSet {
        &self.set
    }

    /// What the last look cost.
    pub fn stats(&self) -> &Stats {
        &self.memory.stats
    }

    /// Goes through the orders of the last look's passages once more, holding nothing against covers: what the orders
    /// alone cost. Gives the number of faces handed out.
    pub fn walk(&mut self, scene: &Scene) -> u64 {
        let passages = self.set.passages.iter();
        passages
            .map(|passage| scene.sector(passage.sector).walk(passage, &mut self.memory))
            .sum()
    }

    fn shape_covers(&mut self, view: &View) {
        let cells = self
            .cover_size
            .map(|size| [0, 1].map(|axis| size[axis].clamp(1, view.size[axis].max(1))));
        self.memory.cover_size = cells.filter(|&cells| cells != view.size);
    }

    fn run(&mut self, scene: &Scene, view: &View, canvas: Option<&mut dyn Canvas>) {
        self.memory.stats = Stats::default();
        self.memory.trace = canvas.as_ref().is_some_and(|canvas| canvas.wants_work());
        self.memory.recall.begin_look();
        let look = Look {
            scene,
            limits: self.limits,
            memory: &mut self.memory,
            set: &mut self.set,
            entered: &mut self.entered,
            spare: &mut self.spare,
            canvas: canvas.map(|canvas| canvas as &mut dyn Canvas),
            gathered: None,
        };
        look.begin(view);
    }

    /// Paints the set of the look just done: the same passages, or what exact methods leave of their apertures.
    fn paint(&mut self, scene: &Scene, view: &View, canvas: &mut dyn Canvas) {
        self.memory.trace = canvas.wants_work();
        self.memory.recall.begin_look();
        let mut by_chain: Vec<_> = (0..).map(PassageId).zip(&self.set.passages).collect();
        by_chain.sort_unstable_by_key(|(_, passage)| passage.chain);
        let look = Look {
            scene,
            limits: self.limits,
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

/// What is to be painted and nothing else.
struct Gathered<'a> {
    set: &'a VisibleSet,
    by_chain: Vec<(u64, PassageId)>,
}

impl Gathered<'_> {
    /// The passage of a chain of portals.
    fn id(&self, chain: u64) -> Option<PassageId> {
        let place = self.by_chain.binary_search_by_key(&chain, |&(chain, _)| chain);
        place.ok().map(|place| self.by_chain[place].1)
    }
}

/// One look at work.
struct Look<'a> {
    scene: &'a Scene,
    limits: Limits,
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
        self.set.complete = true;
        let sound = view.check().is_ok();
        if let Some(sector) = self.scene.sector_of(view).filter(|_| sound) {
            let root = Passage::at_the_eye(view, sector, self.scene.is_flat());
            self.go_through(root);
        }
    }

    /// Looks through a passage, and through every passage that its openings lead to.
    ///
    /// The stack is a `Vec`: limits allow 65,535 portals in a row, too many for the thread's own stack.
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

    /// Gathers what is seen through a passage, and paints its opaque faces. Its openings are followed next.
    fn pass(&mut self, passage: Passage) {
        let scene = self.scene;
        let own = match scene.method(passage.sector) {
            Some(method) if self.memory.cover_size.is_some() => method.contract_in_cells(),
            _ => scene.sector(passage.sector).contract(),
        };
        let id = PassageId(self.set.passages.len() as u32);
        self.set
            .passages
            .push(passage.held_to(own, self.canvas.is_some()));
        let sector = scene.sector(self.set.passage(id).sector);
        let mut seen = self.spare.pop().unwrap_or_default();
        self.lend(&mut seen);
        seen.clear(self.canvas.is_some());
        self.enter(id);
        let passage = self.set.passage(id);
        if let Some(gathered) = &self.gathered
            && sector.draws_what_was_gathered(self.memory)
            && let Some(same) = gathered.id(passage.chain)
        {
            seen.report_again(gathered.set, same);
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

    /// Paints the glass of the last passage entered over what was seen through its openings.
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

    /// Lends what all passages share while they are looked through, or takes it back: many are on the way at once.
    fn lend(&mut self, seen: &mut Collector) {
        std::mem::swap(&mut seen.spare_rows, &mut self.memory.spare_rows);
        std::mem::swap(&mut seen.glass, &mut self.memory.spare_glass);
        std::mem::swap(&mut seen.report, &mut self.memory.spare_report);
    }

    /// Tells the canvas which passage comes, by its place in the set that the caller gets.
    fn enter(&mut self, id: PassageId) {
        let id_in_answer = self.id_in_answer(id);
        if let Some(canvas) = self.canvas.as_deref_mut() {
            canvas.enter(id_in_answer, self.set.passage(id));
        }
    }

    /// The place of a passage in the set that the caller gets, which may be another than the one being painted.
    fn id_in_answer(&self, id: PassageId) -> PassageId {
        let gathered = self.gathered.as_ref();
        let same = gathered.and_then(|gathered| gathered.id(self.set.passage(id).chain));
        same.unwrap_or(id)
    }

    /// Takes the items that a sector reported into the set.
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
        self.set.items.extend(seen.items.iter().map(|seen| {
            let region = match geometry {
                Some(geometry) => {
                    let screen_from_item = passage.screen_from(&geometry.item(seen.item).transform());
                    Region::of(passage, &screen_from_item, &geometry.mesh_of(seen.item).bounds())
                }
                None => {
                    let bounds = self.scene.sector(passage.sector).item_bounds(seen.item);
                    Region::of(passage, &passage.screen_from_sector, &bounds)
                }
            };
            let size_px = region.map_or(0, |Region { rect, .. }| {
                (rect.x1 - rect.x0).max(rect.y1 - rect.y0)
            });
            VisibleItem {
                passage: id,
                item: seen.item,
                size_px,
                blends: geometry.is_some_and(|geometry| blends(geometry, seen)),
                clusters: seen.clusters.map(|at| at + shift),
            }
        }));
    }

    /// The passage behind an opening that is open and may be followed; any other opening is painted as a face.
    fn follow(&mut self, id: PassageId, seen: CollectedOpening) -> Option<Passage> {
        let passage = self.set.passage(id);
        let way = self.scene.portal_of(passage.sector, seen.opening);
        let Some(portal_id) = way.filter(|&PortalId(index)| self.scene.portals()[index as usize].open) else {
            self.paint_closed(id, seen);
            return None;
        };
        let full = self.set.passages.len() >= self.limits.max_passages as usize;
        if full || passage.crossings >= self.limits.max_crossings {
            self.set.complete = false;
            self.paint_closed(id, seen);
            return None;
        }
        let portal = &self.scene.portals()[portal_id.0 as usize];
        let outline = &self.scene.sector(passage.sector).openings()[usize::from(seen.opening.0)].outline;
        // Where the look before came to a limit, painting does not go on.
        let gathered = self.gathered.as_ref();
        if gathered.is_some_and(|gathered| gathered.id(passage.chain_through(portal_id)).is_none()) {
            self.paint_closed(id, seen);
            return None;
        }
        let own_id = self.id_in_answer(id);
        passage.through(own_id, portal_id, portal, outline, seen.rows)
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
