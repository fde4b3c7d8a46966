//! Alpha-blended and alpha-tested layers along rays: their order, and the comparison of a picture with it.
//!
//! A sample counts only if its five rays agree on the layers, their order, and that all are in front of the opaque
//! surface. Otherwise two layers intersect there, or one ends, and the sample is skipped.

use super::EPSILON;
use super::chains::{Chain, Chains, PassageChains};
use super::reference::RayResult;
use crate::geometry::Owner;
use crate::ids::{ItemIndex, PassageId};
use crate::view::canvas::{Canvas, Span};
use crate::view::passage::Passage;

/// A hit on an alpha-blended or alpha-tested face.
#[derive(Clone, Copy)]
pub(super) struct Pane {
    pub(super) chain: Chain,
    pub(super) item: ItemIndex,
    pub(super) face: u32,
    /// Number of portals passed before it.
    pub(super) depth: u16,
    /// Minimum and maximum ray parameter.
    pub(super) w: [f64; 2],
    /// Whether it certainly is in front of the nearest opaque surface.
    pub(super) sure: bool,
}

/// A face seen through a chain of portals.
type Layer = (Chain, Owner);

/// The transparent layers over each sample of a view, back to front.
#[derive(Default)]
pub struct Layers {
    width: usize,
    chains: Chains,
    /// Layers per sample; `None` if its rays disagree.
    samples: Vec<Option<Vec<Layer>>>,
}

/// A canvas that records the transparent layers painted over each sample, in order.
pub struct LayerPicture {
    width: usize,
    passages: PassageChains,
    /// Chain of the passage being painted.
    chain: Option<Chain>,
    samples: Vec<Vec<Layer>>,
}

/// Comparison of a picture's transparent layers with the reference.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct LayerVerdict {
    /// Samples with transparent layers on which all rays agree.
    pub compared: usize,
    /// Number of those with two or more layers.
    pub stacked: usize,
    /// Maximum number of layers at a sample.
    pub deepest: usize,
    /// Samples (x, y) whose layers or their order differ.
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

    pub(super) fn sample(&mut self, rays: &[RayResult]) {
        let all: Option<Vec<Vec<Layer>>> = rays.iter().map(along).collect();
        let agreed = all.and_then(|mut all| {
            let first = all.swap_remove(0);
            all.iter().all(|other| *other == first).then_some(first)
        });
        self.samples.push(agreed);
    }

    /// Compares a picture with the reference at every sample whose rays agree.
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

    /// Describes the layers of a picture at a sample and the expected ones, for the message of a failed law.
    pub fn describe(&self, picture: &LayerPicture, [x, y]: [u32; 2]) -> String {
        let sample = y as usize * self.width + x as usize;
        format!(
            "{:?} instead of {:?}",
            picture.samples[sample], self.samples[sample]
        )
    }
}

/// Returns the layers along a ray, back to front; `None` if their order is uncertain.
fn along(ray: &RayResult) -> Option<Vec<Layer>> {
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
    /// Creates an empty picture of `size` pixels.
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
                    // An opaque span overwrites everything painted before.
                    sample.clear();
                }
            }
        }
    }
}
