//! Glass and cut-outs along rays: what lies over what, and how a picture is held against it.
//!
//! A sample's five rays must agree on what they meet, in which order, and that it is in front, or it says nothing: there
//! two panes cross, or one ends.

use super::EPSILON;
use super::chains::{Chain, Chains, PassageChains};
use super::reference::RaySees;
use crate::canvas::{Canvas, Span};
use crate::geometry::{ItemId, Owner};
use crate::passage::{Passage, PassageId};

/// A face of glass, or of a cut-out, that a ray meets.
#[derive(Clone, Copy)]
pub(super) struct Pane {
    pub(super) chain: Chain,
    pub(super) item: ItemId,
    pub(super) face: u32,
    /// How many portals lie before it.
    pub(super) depth: u16,
    /// How far it is, at the least and at the most.
    pub(super) w: [f64; 2],
    /// Is it in front for certain?
    pub(super) sure: bool,
}

/// A face through a chain of portals.
type Layer = (Chain, Owner);

/// The glass over each sample of a view, from the farthest to the nearest.
#[derive(Default)]
pub struct Layers {
    width: usize,
    chains: Chains,
    /// Of each sample; `None` where its rays do not agree.
    samples: Vec<Option<Vec<Layer>>>,
}

/// A canvas that keeps the glass that is painted over each sample, in order.
pub struct LayerPicture {
    width: usize,
    passages: PassageChains,
    /// Of the passage that is being painted.
    chain: Option<Chain>,
    samples: Vec<Vec<Layer>>,
}

/// How a picture's glass compares with the truth.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct LayerVerdict {
    /// Samples with glass on which all rays agree.
    pub compared: usize,
    /// Those of them that have two layers or more.
    pub stacked: usize,
    /// The most layers of any.
    pub deepest: usize,
    /// Samples with other glass, or in another order: x, y.
    pub different: Vec<[u32; 2]>,
}

impl Layers {
    pub(super) fn of_rows(size: [u32; 2], rows: Vec<(Chains, Layers)>) -> Layers {
        let mut all = Layers {
            width: size[0] as usize,
            ..Layers::default()
        };
        for (chains, mut row) in rows {
            let numbers = all.chains.add_all(&chains);
            for (chain, _) in row.samples.iter_mut().flatten().flatten() {
                *chain = chain.renumbered(&numbers);
            }
            all.samples.append(&mut row.samples);
        }
        all
    }

    pub(super) fn sample(&mut self, rays: &[RaySees]) {
        let all: Option<Vec<Vec<Layer>>> = rays.iter().map(along).collect();
        let agreed = all.and_then(|mut all| {
            let first = all.swap_remove(0);
            all.iter().all(|other| *other == first).then_some(first)
        });
        self.samples.push(agreed);
    }

    /// Holds a picture against it, wherever the rays of a sample agree.
    pub fn check(&self, picture: &LayerPicture) -> LayerVerdict {
        let mut verdict = LayerVerdict::default();
        let numbers = self.chains.numbers_of(&picture.passages.chains);
        for (sample, (truth, painted)) in self.samples.iter().zip(&picture.samples).enumerate() {
            let Some(truth) = truth else { continue };
            verdict.compared += usize::from(!truth.is_empty());
            verdict.stacked += usize::from(truth.len() > 1);
            verdict.deepest = verdict.deepest.max(truth.len());
            let painted = (painted.iter()).map(|(chain, owner)| (chain.found(&numbers), *owner));
            if !painted.eq(truth.iter().map(|&(chain, owner)| (Some(chain), owner))) {
                let at = [sample % self.width, sample / self.width];
                verdict.different.push(at.map(|value| value as u32));
            }
        }
        verdict
    }

    /// What lies over a sample, and what a picture has there, as text: for the message of a law that fails.
    pub fn describe(&self, picture: &LayerPicture, [x, y]: [u32; 2]) -> String {
        let sample = y as usize * self.width + x as usize;
        format!("{:?}, not {:?}", picture.samples[sample], self.samples[sample])
    }
}

/// The glass along a ray, the farthest first; `None` where it is not certain.
fn along(ray: &RaySees) -> Option<Vec<Layer>> {
    let one_way = ray
        .possible
        .iter()
        .all(|possible| possible.chain == ray.possible[0].chain);
    if !one_way || ray.glass.iter().any(|pane| !pane.sure) {
        return None;
    }
    let mut panes = ray.glass.clone();
    panes.sort_by(|a, b| b.depth.cmp(&a.depth).then(b.w[0].total_cmp(&a.w[0])));
    let touch = |pair: &[Pane]| {
        let [behind, before] = [&pair[0], &pair[1]];
        behind.depth == before.depth && behind.w[0] <= before.w[1] * (1.0 + EPSILON)
    };
    if panes.windows(2).any(touch) {
        return None;
    }
    let layer = |pane: &Pane| (pane.chain, Owner::Face(pane.item, pane.face));
    Some(panes.iter().map(layer).collect())
}

impl LayerPicture {
    /// An empty picture.
    pub fn new(size: [u32; 2]) -> LayerPicture {
        LayerPicture {
            width: size[0] as usize,
            passages: PassageChains::default(),
            chain: None,
            samples: vec![Vec::new(); size[0] as usize * size[1] as usize],
        }
    }
}

impl Canvas for LayerPicture {
    fn enter(&mut self, id: PassageId, passage: &Passage) {
        self.chain = Some(self.passages.of(id, passage));
    }

    fn row(&mut self, y: u16, spans: &[Span]) {
        for span in spans {
            let start = usize::from(y) * self.width;
            let run = start + usize::from(span.x0)..start + usize::from(span.x1);
            for sample in &mut self.samples[run] {
                if span.see_through {
                    sample.extend(self.chain.map(|chain| (chain, span.owner)));
                } else {
                    // What hides covers what was painted before.
                    sample.clear();
                }
            }
        }
    }
}
