//! A look step by step, for teaching and debugging (feature `steps`).
//!
//! A look with a limit of steps ends after these, as if all that follows were hidden, and keeps the state of the cover. Looks
//! are deterministic, so a look with one step fewer is one step backwards.

use crate::ids::{ItemIndex, OpeningId, PassageId};
use crate::view::aperture::Rect;
use crate::view::canvas::{Canvas, CoverSpan};
use crate::view::passage::Passage;
use crate::view::region::Visibility;

/// One step of a look, from [`Viewer::look_steps`](crate::Viewer::look_steps).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum LookStep {
    /// An occluder was selected and rasterized into the cover, before the traversal. Only methods that select occluders
    /// have such steps: those with [`Method::occluders`](crate::Method::occluders) above 0, or others if
    /// [`ViewerOptions::occluders`](crate::ViewerOptions::occluders) asks for some.
    Occluder {
        /// The passage that is to be traversed.
        passage: PassageId,
        /// The item that the occluder belongs to.
        item: ItemIndex,
        /// Corners of the convex polygon, in the space of the sector.
        corners: Vec<[f32; 3]>,
    },
    /// A box was tested: a node of a tree, an item or a cluster.
    Box {
        /// The passage that is traversed.
        passage: PassageId,
        /// The samples that the box may cover.
        rect: Rect,
        /// Its greatest reversed depth.
        rev_depth: f32,
        /// The answer.
        visibility: Visibility,
    },
    /// A cluster passed the tests. If it can occlude, a cover that takes faces has rasterized it.
    Cluster {
        /// The passage that is traversed.
        passage: PassageId,
        /// The item.
        item: ItemIndex,
        /// The cluster; `None` for all of the item's.
        cluster: Option<u32>,
    },
    /// An opening passed the tests.
    Opening {
        /// The passage that is traversed.
        passage: PassageId,
        /// The opening.
        opening: OpeningId,
    },
}

/// The steps of the current look.
#[derive(Debug)]
pub(crate) struct StepLog {
    pub(crate) limit: usize,
    pub(crate) steps: Vec<LookStep>,
    /// The passage that is traversed.
    passage: PassageId,
    /// The cover of the passage in which the limit was reached, or of the last.
    cover: Option<(Passage, Rows)>,
}

impl StepLog {
    pub(crate) fn new(limit: usize) -> StepLog {
        StepLog {
            limit,
            steps: Vec::new(),
            passage: PassageId(0),
            cover: None,
        }
    }

    pub(crate) fn begin_passage(&mut self, passage: PassageId) {
        self.passage = passage;
    }

    pub(crate) fn passage(&self) -> PassageId {
        self.passage
    }

    /// Whether the look ends here.
    pub(crate) fn is_full(&self) -> bool {
        self.steps.len() >= self.limit
    }

    /// Keeps the state of a cover, which `show` emits, unless the look has ended in a passage before.
    pub(crate) fn keep_cover(&mut self, passage: &Passage, show: impl FnOnce(&mut dyn Canvas)) {
        if self.cover.is_some()
            && self
                .steps
                .last()
                .is_none_or(|step| step.passage() != self.passage())
        {
            return;
        }
        let mut rows = Rows::default();
        show(&mut rows);
        self.cover = Some((passage.clone(), rows));
    }

    /// Emits the cover that was kept.
    pub(crate) fn emit_cover(&self, canvas: &mut dyn Canvas) {
        if let Some((passage, rows)) = &self.cover {
            canvas.enter(self.passage(), passage);
            for (y, spans) in &rows.0 {
                canvas.cover(*y, spans);
            }
        }
    }
}

impl LookStep {
    /// Returns the passage of the step.
    pub fn passage(&self) -> PassageId {
        let (LookStep::Occluder { passage, .. }
        | LookStep::Box { passage, .. }
        | LookStep::Cluster { passage, .. }
        | LookStep::Opening { passage, .. }) = self;
        *passage
    }
}

/// Rows of a cover, by number.
#[derive(Debug, Default)]
struct Rows(Vec<(u16, Vec<CoverSpan>)>);

impl Canvas for Rows {
    fn enter(&mut self, _: PassageId, _: &Passage) {}

    fn row(&mut self, _: u16, _: &[crate::view::canvas::Span]) {}

    fn wants_cover(&self) -> bool {
        true
    }

    fn cover(&mut self, y: u16, spans: &[CoverSpan]) {
        self.0.push((y, spans.to_vec()));
    }
}
