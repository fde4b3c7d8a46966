//! The reference's result for a view, and the comparison of a method's answer with it.

use super::chains::{Chain, Chains, PassageChains};
use super::owners::OwnerPicture;
use super::reference::RayResult;
use crate::geometry::Owner;
use crate::ids::{ItemIndex, PassageId, SectorId};
use crate::view::visible::VisibleSet;
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// A possible owner of a sample; `None` for the background.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Possible {
    pub(super) chain: Chain,
    pub(super) owner: Option<Owner>,
}

/// The possible owners of each sample of a view, as found by [`Reference`](super::Reference).
pub struct Truth {
    size: [u32; 2],
    chains: Chains,
    /// Possible owners, sample after sample, and the end index of each sample; empty if the result is not for a
    /// picture.
    possible: Vec<Possible>,
    ends: Vec<u32>,
    contested: u64,
    /// Items that certainly own a sample, or certainly are a layer in front at one.
    certain: BTreeSet<(Chain, ItemIndex)>,
    /// Items that may own a sample, or be a layer in front at one.
    imaginable: HashSet<(Chain, ItemIndex)>,
    /// Items that any method may list although they are hidden.
    listed_anyway: HashSet<(SectorId, ItemIndex)>,
    /// Sets of items of which one certainly owns a sample, though not which, and at how many samples.
    contests: BTreeMap<Vec<(Chain, ItemIndex)>, u64>,
}

/// Results of one row, to be merged into a [`Truth`].
#[derive(Default)]
pub(super) struct RowTruth {
    possible: Vec<Possible>,
    ends: Vec<u32>,
    contested: u64,
    certain: Vec<(Chain, ItemIndex)>,
    imaginable: Vec<(Chain, ItemIndex)>,
    contests: Vec<(Vec<(Chain, ItemIndex)>, u64)>,
    /// Buffers for the current sample, kept to reuse their memory.
    here: Vec<Possible>,
    glass: Vec<(Chain, ItemIndex)>,
}

impl RowTruth {
    /// Adds a sample of a picture from its rays.
    pub(super) fn sample(&mut self, rays: &[RayResult]) {
        self.position(rays);
        self.possible.extend_from_slice(&self.here);
        self.ends.push(self.possible.len() as u32);
    }

    /// Adds a position that belongs to no picture: records only its visible items.
    pub(super) fn position(&mut self, rays: &[RayResult]) {
        self.here.clear();
        self.here
            .extend(rays.iter().flat_map(|ray| ray.possible.iter().copied()));
        self.here.sort_unstable();
        self.here.dedup();
        let item = |p: &Possible| p.owner.and_then(Owner::item).map(|item| (p.chain, item));
        let first = self.here.first().and_then(item);
        let one_item =
            self.here.len() == 1 || (first.is_some() && self.here.iter().all(|p| item(p) == first));
        self.contested += u64::from(!one_item);
        if let Some(seen) = first.filter(|_| one_item) {
            push_new(&mut self.certain, seen);
        }
        for seen in self.here.iter().filter_map(item) {
            push_new(&mut self.imaginable, seen);
        }
        if !one_item && self.here.iter().all(|p| item(p).is_some()) {
            self.contest();
        }
        self.bounds(rays);
        self.glass.clear();
        let glass = rays.iter().flat_map(|ray| &ray.glass);
        self.glass.extend(glass.map(|pane| (pane.chain, pane.item)));
        self.glass.sort_unstable();
        self.glass.dedup();
        for &seen in &self.glass {
            let mut all = rays.iter();
            if all.all(|ray| {
                ray.glass
                    .iter()
                    .any(|pane| pane.sure && (pane.chain, pane.item) == seen)
            }) {
                push_new(&mut self.certain, seen);
            }
            push_new(&mut self.imaginable, seen);
        }
    }

    /// Records the items at the current sample that are only bounds.
    fn bounds(&mut self, rays: &[RayResult]) {
        for &(chain, item, _) in rays.iter().flat_map(|ray| &ray.bounds) {
            let is_sure = |ray: &RayResult| ray.bounds.contains(&(chain, item, true));
            if rays.iter().all(is_sure) {
                push_new(&mut self.certain, (chain, item));
            }
        }
    }

    /// Records the items that contest the current sample.
    fn contest(&mut self) {
        let item = |p: &Possible| p.owner.and_then(Owner::item).map(|item| (p.chain, item));
        let mut items: Vec<_> = self.here.iter().filter_map(item).collect();
        items.dedup();
        match self.contests.last_mut() {
            Some((last, samples)) if *last == items => *samples += 1,
            _ => self.contests.push((items, 1)),
        }
    }

    /// Removes duplicates. Called on the tracing threads, which is faster than doing it while merging.
    pub(super) fn settle(&mut self) {
        for items in [&mut self.certain, &mut self.imaginable] {
            items.sort_unstable();
            items.dedup();
        }
        self.contests.sort_unstable();
        self.contests.dedup_by(|next, kept| {
            let is_same = next.0 == kept.0;
            kept.1 += if is_same { next.1 } else { 0 };
            is_same
        });
    }
}

/// Neighbouring samples mostly have the same item; skips repetitions.
fn push_new(items: &mut Vec<(Chain, ItemIndex)>, seen: (Chain, ItemIndex)) {
    if items.last() != Some(&seen) {
        items.push(seen);
    }
}

/// Comparison of a method's answer with the reference.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Verdict {
    /// Items that certainly own a sample, or certainly are a layer in front at one; counted once over all passages.
    pub reference_visible: usize,
    /// False culls: those of them that are missing from the set, or from the set of their passage. If several items may
    /// own a sample and none of them is in the set, the first of them.
    pub missed: Vec<(SectorId, ItemIndex)>,
    /// Items in the set that are visible at no sample; counted once over all passages.
    pub extra: usize,
    /// Wrong pixels: samples painted with an owner that is not possible. Transparent layers are ignored.
    pub pixels_different: u64,
    /// Contested samples: more than one item, or an item and the background, may own them.
    pub pixels_contested: u64,
    /// Samples of the reference's picture.
    pub pixels: u64,
}

impl Truth {
    pub(super) fn new(
        size: [u32; 2],
        rows: Vec<(Chains, RowTruth)>,
        listed_anyway: HashSet<(SectorId, ItemIndex)>,
    ) -> Truth {
        let mut truth = Truth {
            size,
            chains: Chains::default(),
            possible: Vec::new(),
            ends: Vec::new(),
            contested: 0,
            certain: BTreeSet::new(),
            imaginable: HashSet::new(),
            listed_anyway,
            contests: BTreeMap::new(),
        };
        for (chains, row) in rows {
            let numbers = truth.chains.add_all(&chains);
            let seen = |(chain, item): (Chain, ItemIndex)| (chain.renumbered(&numbers), item);
            let before = truth.possible.len() as u32;
            truth.contested += row.contested;
            truth.certain.extend(row.certain.into_iter().map(seen));
            truth.imaginable.extend(row.imaginable.into_iter().map(seen));
            for (items, samples) in row.contests {
                let mut items: Vec<_> = items.into_iter().map(seen).collect();
                items.sort_unstable();
                *truth.contests.entry(items).or_default() += samples;
            }
            truth
                .possible
                .extend(row.possible.into_iter().map(|possible| Possible {
                    chain: possible.chain.renumbered(&numbers),
                    ..possible
                }));
            truth.ends.extend(row.ends.into_iter().map(|end| before + end));
        }
        truth
    }

    /// Returns the certainly visible items; each once over all passages.
    pub fn visible(&self) -> BTreeSet<(SectorId, ItemIndex)> {
        self.certain
            .iter()
            .map(|(chain, item)| (chain.sector, *item))
            .collect()
    }

    /// Returns the sets of items of which one certainly owns a sample, though not which, with their number of samples,
    /// largest number first. Usually their faces are coplanar.
    pub fn contested(&self) -> Vec<(Vec<(SectorId, ItemIndex)>, u64)> {
        let mut all: BTreeMap<Vec<(SectorId, ItemIndex)>, u64> = BTreeMap::new();
        for (items, samples) in &self.contests {
            let mut items: Vec<_> = items.iter().map(|(chain, item)| (chain.sector, *item)).collect();
            items.sort_unstable();
            items.dedup();
            *all.entry(items).or_default() += samples;
        }
        let mut all: Vec<_> = all.into_iter().collect();
        all.sort_by_key(|&(_, samples)| std::cmp::Reverse(samples));
        all
    }

    /// Compares a visible set, and the picture drawn with it, with the reference. The viewer must have had the same
    /// [`Limits`](crate::Limits) as the reference.
    pub fn check(&self, set: &VisibleSet, picture: Option<&OwnerPicture>) -> Verdict {
        let mut passages = PassageChains::default();
        let chains: Vec<Chain> = (0..)
            .map(PassageId)
            .zip(set.passages())
            .map(|(id, passage)| passages.of(id, passage))
            .collect();
        let numbers = self.chains.numbers_of(&passages.chains);
        // `None` for a chain that no ray follows.
        let answered: HashSet<(SectorId, Option<Chain>, ItemIndex)> = set
            .items()
            .iter()
            .map(|visible| {
                let chain = chains[visible.passage.0 as usize];
                (chain.sector, chain.found(&numbers), visible.item.index)
            })
            .collect();
        let answer = |&(chain, item): &(Chain, ItemIndex)| (chain.sector, Some(chain), item);
        let is_missed = |seen: &&(Chain, ItemIndex)| !answered.contains(&answer(seen));
        let of_several = self
            .contests
            .keys()
            .filter(|items| items.iter().all(|seen| is_missed(&seen)));
        let missed: BTreeSet<(SectorId, ItemIndex)> = (self.certain.iter().filter(is_missed))
            .chain(of_several.map(|items| &items[0]))
            .map(|(chain, item)| (chain.sector, *item))
            .collect();
        let imaginable: HashSet<_> = self.imaginable.iter().map(answer).collect();
        let extra: BTreeSet<(SectorId, ItemIndex)> = (answered.difference(&imaginable))
            .map(|&(sector, _, item)| (sector, item))
            .filter(|item| !self.listed_anyway.contains(item))
            .collect();
        Verdict {
            reference_visible: self.visible().len(),
            missed: missed.into_iter().collect(),
            extra: extra.len(),
            pixels_different: picture.map_or(0, |picture| self.different(picture).count() as u64),
            pixels_contested: self.contested,
            pixels: self.ends.len() as u64,
        }
    }

    /// Returns the samples (x, y) that a picture paints with an owner that is not possible.
    pub fn different<'a>(&'a self, picture: &'a OwnerPicture) -> impl Iterator<Item = [u32; 2]> + 'a {
        let numbers = self.chains.numbers_of(picture.chains());
        let is_wrong = move |&sample: &usize| {
            let start = sample
                .checked_sub(1)
                .map_or(0, |before| self.ends[before] as usize);
            let allowed = &self.possible[start..self.ends[sample] as usize];
            !match picture.at(sample) {
                Some((chain, owner)) => {
                    let chain = chain.found(&numbers);
                    let mut all = allowed.iter();
                    all.any(|p| Some(p.chain) == chain && p.owner == Some(owner))
                }
                None => allowed.iter().any(|p| p.owner.is_none()),
            }
        };
        (0..self.ends.len())
            .filter(is_wrong)
            .map(|sample| [sample as u32 % self.size[0], sample as u32 / self.size[0]])
    }

    /// Describes the possible owners of sample (x, y), for the message of a failed law.
    pub fn describe(&self, [x, y]: [u32; 2]) -> String {
        let sample = (y * self.size[0] + x) as usize;
        let start = sample
            .checked_sub(1)
            .map_or(0, |before| self.ends[before] as usize);
        let possible = &self.possible[start..self.ends[sample] as usize];
        let text = |possible: &Possible| {
            let portals = self.chains.portals(possible.chain.id);
            format!("{:?} through portals {portals:?}", possible.owner)
        };
        possible.iter().map(text).collect::<Vec<_>>().join(" or ")
    }
}
