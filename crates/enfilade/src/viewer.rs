//! The working memory of one camera, and how it follows openings from fragment to fragment.

use crate::canvas::{Canvas, Span};
use crate::content::Owner;
use crate::memory::Memory;
use crate::passage::{Passage, PassageId};
use crate::region::Region;
use crate::scene::{PortalId, Scene};
use crate::seen::{Seen, SeenOpening, paint_glass};
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
    spare: Vec<Seen>,
    limits: Limits,
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

    /// What can be seen. A view that fails [`View::check`] sees nothing.
    pub fn look(&mut self, scene: &Scene, view: &View) -> &VisibleSet {
        self.run(scene, view, None);
        &self.set
    }

    /// Paints what can be seen, and gives the set as [`Viewer::look`] does.
    pub fn draw(&mut self, scene: &Scene, view: &View, canvas: &mut dyn Canvas) -> &VisibleSet {
        self.run(scene, view, Some(canvas));
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
            .map(|passage| scene.fragment(passage.fragment).walk(passage, &mut self.memory))
            .sum()
    }

    fn run(&mut self, scene: &Scene, view: &View, canvas: Option<&mut dyn Canvas>) {
        self.set.passages.clear();
        self.set.items.clear();
        self.set.clusters.clear();
        self.set.complete = true;
        self.memory.stats = Stats::default();
        self.memory.trace = canvas.as_ref().is_some_and(|canvas| canvas.wants_work());
        self.memory.recall.begin_look();
        let Some(fragment) = view
            .check()
            .ok()
            .and_then(|()| scene.locate(view.eye, view.toward))
        else {
            return;
        };
        let root = Passage::at_the_eye(view, fragment, scene.is_flat());
        self.set.passages.push(root);
        let mut look = Look {
            scene,
            limits: self.limits,
            memory: &mut self.memory,
            set: &mut self.set,
            spare: &mut self.spare,
            canvas: canvas.map(|canvas| canvas as &mut dyn Canvas),
        };
        look.pass(PassageId(0));
    }
}

/// One look at work.
struct Look<'a> {
    scene: &'a Scene,
    limits: Limits,
    memory: &'a mut Memory,
    set: &'a mut VisibleSet,
    spare: &'a mut Vec<Seen>,
    canvas: Option<&'a mut dyn Canvas>,
}

impl Look<'_> {
    /// Opaque things going in, then what is behind the openings, then glass coming out.
    ///
    /// Recursion goes no deeper than the limit of crossings.
    fn pass(&mut self, id: PassageId) {
        let scene = self.scene;
        let fragment = scene.fragment(self.set.passage(id).fragment);
        let mut seen = self.spare.pop().unwrap_or_default();
        seen.clear(self.canvas.is_some());
        self.enter(id);
        let passage = self.set.passage(id);
        match self.canvas.as_deref_mut() {
            Some(canvas) => fragment.draw(passage, self.memory, &mut seen, canvas),
            None => fragment.gather(passage, self.memory, &mut seen),
        }
        self.take_in(id, &seen);
        for opening in std::mem::take(&mut seen.openings) {
            self.follow(id, opening);
        }
        if let Some(canvas) = self.canvas.as_deref_mut().filter(|_| !seen.glass.is_empty()) {
            canvas.enter(id, self.set.passage(id));
            paint_glass(&mut seen.glass, canvas);
        }
        self.spare.push(seen);
    }

    fn enter(&mut self, id: PassageId) {
        if let Some(canvas) = self.canvas.as_deref_mut() {
            canvas.enter(id, self.set.passage(id));
        }
    }

    /// Takes the items that a fragment reported into the set.
    fn take_in(&mut self, id: PassageId, seen: &Seen) {
        let passage = &self.set.passages[id.0 as usize];
        let content = self.scene.content(passage.fragment);
        let shift = self.set.clusters.len() as u32;
        self.set.clusters.extend(&seen.clusters);
        self.set.items.extend(seen.items.iter().map(|seen| {
            let region = content.and_then(|content| {
                let screen_from_item = passage.screen_from(&content.item(seen.item).transform());
                Region::of(passage, &screen_from_item, &content.mesh_of(seen.item).bounds())
            });
            let size_px = region.map_or(0, |Region { rect, .. }| {
                (rect.x1 - rect.x0).max(rect.y1 - rect.y0)
            });
            VisibleItem {
                passage: id,
                item: seen.item,
                size_px,
                clusters: seen.clusters.map(|at| at + shift),
            }
        }));
    }

    /// Looks through an opening that is open; one that is not is a face.
    fn follow(&mut self, id: PassageId, seen: SeenOpening) {
        let passage = self.set.passage(id);
        let way = self.scene.portal_of(passage.fragment, seen.opening);
        let Some(portal_id) = way.filter(|&PortalId(index)| self.scene.portals()[index as usize].open) else {
            return self.paint_closed(id, &seen);
        };
        let full = self.set.passages.len() >= self.limits.max_passages as usize;
        if full || passage.crossings >= self.limits.max_crossings {
            self.set.complete = false;
            return self.paint_closed(id, &seen);
        }
        let portal = &self.scene.portals()[portal_id.0 as usize];
        let outline = &self.scene.fragment(passage.fragment).openings()[usize::from(seen.opening.0)].outline;
        if let Some(child) = passage.through(id, portal_id, portal, outline, seen.rows) {
            self.set.passages.push(child);
            self.pass(PassageId(self.set.passages.len() as u32 - 1));
        }
    }

    fn paint_closed(&mut self, id: PassageId, seen: &SeenOpening) {
        self.enter(id);
        let (Some(canvas), Some(rows)) = (self.canvas.as_deref_mut(), &seen.rows) else {
            return;
        };
        for y in rows.range() {
            let owner = Owner::Opening(seen.opening);
            let spans: Vec<Span> = rows
                .row(y)
                .iter()
                .map(|&[x0, x1]| Span {
                    x0,
                    x1,
                    owner,
                    see_through: false,
                })
                .collect();
            canvas.row(y, &spans);
        }
    }
}
