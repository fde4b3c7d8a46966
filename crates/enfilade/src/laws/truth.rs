//! What may be seen, and how an answer is held against it.

use super::chains::{Chain, Chains, PassageChains};
use super::owners::OwnerPicture;
use super::reference::RaySees;
use crate::geometry::{ItemId, Owner};
use crate::passage::PassageId;
use crate::scene::SectorId;
use crate::visible::VisibleSet;
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// What may own a sample; `None` where nothing is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Possible {
    pub(super) chain: Chain,
    pub(super) owner: Option<Owner>,
}

/// What may be seen at each sample of a view.
pub struct Truth {
    size: [u32; 2],
    chains: Chains,
    /// Possible owners, sample after sample, and where each sample's end; nothing where it is not about a picture.
    possible: Vec<Possible>,
    ends: Vec<u32>,
    contested: u64,
    /// Items that certainly own a sample, or certainly are in front at one.
    certain: BTreeSet<(Chain, ItemId)>,
    /// Items that may own a sample, or be in front at one.
    imaginable: HashSet<(Chain, ItemId)>,
    /// Items of which one certainly owns a sample, though not which, and at how many samples.
    contests: BTreeMap<Vec<(Chain, ItemId)>, u64>,
}

/// What rays tell, sample after sample: a part of a truth.
#[derive(Default)]
pub(super) struct Told {
    possible: Vec<Possible>,
    ends: Vec<u32>,
    contested: u64,
    certain: Vec<(Chain, ItemId)>,
    imaginable: Vec<(Chain, ItemId)>,
    contests: Vec<(Vec<(Chain, ItemId)>, u64)>,
    /// For the current sample only; fields so that their memory is reused.
    here: Vec<Possible>,
    glass: Vec<(Chain, ItemId)>,
}

impl Told {
    /// Takes a sample of a picture, seen by such rays.
    pub(super) fn sample(&mut self, rays: &[RaySees]) {
        self.place(rays);
        self.possible.extend_from_slice(&self.here);
        self.ends.push(self.possible.len() as u32);
    }

    /// Takes a place that is in no picture, seen by such rays: only what items may be seen there is kept.
    pub(super) fn place(&mut self, rays: &[RaySees]) {
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

    /// Adds the possible owners of the current sample.
    fn contest(&mut self) {
        let item = |p: &Possible| p.owner.and_then(Owner::item).map(|item| (p.chain, item));
        let mut items: Vec<_> = self.here.iter().filter_map(item).collect();
        items.dedup();
        match self.contests.last_mut() {
            Some((last, samples)) if *last == items => *samples += 1,
            _ => self.contests.push((items, 1)),
        }
    }

    /// Keeps every item once. Done where the rays are followed, on many threads, for the sake of speed.
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

/// Neighbours mostly see the same item: it is not kept for each of them.
fn push_new(items: &mut Vec<(Chain, ItemId)>, seen: (Chain, ItemId)) {
    if items.last() != Some(&seen) {
        items.push(seen);
    }
}

/// How an answer compares with the truth.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Verdict {
    /// Items that certainly own a sample, or certainly are in front at one; over all passages, each counted once.
    pub reference_visible: usize,
    /// Those of them that are not in the set, or not in the set of the passage they are seen through. Where several items
    /// may own a sample and none of them is in the set, the first of them.
    pub missed: Vec<(SectorId, ItemId)>,
    /// Items in the set that cannot be seen at any sample; over all passages, each counted once.
    pub extra: usize,
    /// Samples painted with what cannot own them; glass is left aside.
    pub pixels_different: u64,
    /// Samples that more than one item may own, or an item or nothing.
    pub pixels_contested: u64,
    /// Samples of the reference's picture.
    pub pixels: u64,
}

impl Truth {
    pub(super) fn new(size: [u32; 2], rows: Vec<(Chains, Told)>) -> Truth {
        let mut truth = Truth {
            size,
            chains: Chains::default(),
            possible: Vec::new(),
            ends: Vec::new(),
            contested: 0,
            certain: BTreeSet::new(),
            imaginable: HashSet::new(),
            contests: BTreeMap::new(),
        };
        for (chains, row) in rows {
            let numbers = truth.chains.add_all(&chains);
            let seen = |(chain, item): (Chain, ItemId)| (chain.renumbered(&numbers), item);
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

    /// Items that certainly are seen; over all passages, each counted once.
    pub fn visible(&self) -> BTreeSet<(SectorId, ItemId)> {
        self.certain
            .iter()
            .map(|(chain, item)| (chain.sector, *item))
            .collect()
    }

    /// Items of which one certainly owns a sample, though not which, and at how many samples; the most first. Most often
    /// their faces coincide.
    pub fn contested(&self) -> Vec<(Vec<(SectorId, ItemId)>, u64)> {
        let mut all: BTreeMap<Vec<(SectorId, ItemId)>, u64> = BTreeMap::new();
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

    /// Holds a visible set, and the picture that was drawn with it, against the truth. The viewer must have had the
    /// limits that the reference was given.
    pub fn check(&self, set: &VisibleSet, picture: Option<&OwnerPicture>) -> Verdict {
        let mut passages = PassageChains::default();
        let chains: Vec<Chain> = (0..)
            .map(PassageId)
            .zip(set.passages())
            .map(|(id, passage)| passages.of(id, passage))
            .collect();
        let numbers = self.chains.numbers_of(&passages.chains);
        // `None` for what is seen through a chain that no ray goes along.
        let answered: HashSet<(SectorId, Option<Chain>, ItemId)> = set
            .items()
            .iter()
            .map(|visible| {
                let chain = chains[visible.passage.0 as usize];
                (chain.sector, chain.found(&numbers), visible.item)
            })
            .collect();
        let answer = |&(chain, item): &(Chain, ItemId)| (chain.sector, Some(chain), item);
        let is_missed = |seen: &&(Chain, ItemId)| !answered.contains(&answer(seen));
        let of_several = self
            .contests
            .keys()
            .filter(|items| items.iter().all(|seen| is_missed(&seen)));
        let missed: BTreeSet<(SectorId, ItemId)> = (self.certain.iter().filter(is_missed))
            .chain(of_several.map(|items| &items[0]))
            .map(|(chain, item)| (chain.sector, *item))
            .collect();
        let imaginable: HashSet<_> = self.imaginable.iter().map(answer).collect();
        let extra: BTreeSet<(SectorId, ItemId)> = (answered.difference(&imaginable))
            .map(|&(sector, _, item)| (sector, item))
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

    /// The samples (x, y) that a picture paints with what cannot own them.
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

    /// What may own sample (x, y), as text: for the message of a law that fails.
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
