//! What may be seen, and how an answer is held against it.

use super::owners::OwnerPicture;
use super::reference::RaySees;
use crate::content::{ItemId, Owner};
use crate::scene::FragmentId;
use crate::visible::VisibleSet;
use std::collections::{BTreeSet, HashSet};

/// A way through portals, and the fragment it ends in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Chain {
    pub(super) hash: u64,
    pub(super) fragment: FragmentId,
}

/// What may own a sample; `None` where nothing is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Possible {
    pub(super) chain: Chain,
    pub(super) owner: Option<Owner>,
}

/// What may be seen at each sample of a view.
pub struct Truth {
    size: [u32; 2],
    /// Possible owners, sample after sample, and where each sample's end; nothing where it is not about a picture.
    possible: Vec<Possible>,
    ends: Vec<u32>,
    contested: u64,
    /// Items that certainly own a sample, or certainly are in front at one.
    certain: BTreeSet<(Chain, ItemId)>,
    /// Items that may own a sample, or be in front at one.
    imaginable: HashSet<(Chain, ItemId)>,
}

/// One sample's part of a truth.
pub(super) struct Sample {
    possible: Vec<Possible>,
    certain: Option<(Chain, ItemId)>,
    contested: bool,
    certain_glass: Vec<(Chain, ItemId)>,
    glass: Vec<(Chain, ItemId)>,
}

impl Sample {
    pub(super) fn of(rays: &[RaySees]) -> Sample {
        let mut possible: Vec<Possible> = rays.iter().flat_map(|ray| ray.possible.iter().copied()).collect();
        possible.sort_unstable();
        possible.dedup();
        let item = |p: &Possible| p.owner.and_then(Owner::item).map(|item| (p.chain, item));
        let first = possible.first().and_then(item);
        let one_item = possible.len() == 1 || (first.is_some() && possible.iter().all(|p| item(p) == first));
        let mut glass: Vec<_> = rays
            .iter()
            .flat_map(|ray| ray.glass.iter().map(|&(chain, item, _)| (chain, item)))
            .collect();
        glass.sort_unstable();
        glass.dedup();
        let certain_glass = glass.iter().copied().filter(|&(chain, item)| {
            rays.iter().all(|ray| {
                ray.glass
                    .iter()
                    .any(|&(c, i, sure)| sure && c == chain && i == item)
            })
        });
        Sample {
            certain: first.filter(|_| one_item),
            contested: !one_item,
            certain_glass: certain_glass.collect(),
            glass,
            possible,
        }
    }
}

/// How an answer compares with the truth.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Verdict {
    /// Items that certainly own a sample, or certainly are in front at one; over all passages, each counted once.
    pub reference_visible: usize,
    /// Those of them that are not in the set, or not in the set of the passage they are seen through.
    pub missed: Vec<(FragmentId, ItemId)>,
    /// Items in the set that cannot be seen at any sample; over all passages, each counted once.
    pub extra: usize,
    /// Samples painted with what cannot own them; glass is left aside.
    pub pixels_different: u64,
    /// Samples that more than one item may own.
    pub pixels_contested: u64,
}

impl Truth {
    /// Of samples that are not those of a picture.
    pub(super) fn of_set(size: [u32; 2], rows: Vec<Vec<Sample>>) -> Truth {
        Truth {
            possible: Vec::new(),
            ends: Vec::new(),
            ..Truth::new(size, rows)
        }
    }

    pub(super) fn new(size: [u32; 2], rows: Vec<Vec<Sample>>) -> Truth {
        let mut truth = Truth {
            size,
            possible: Vec::new(),
            ends: Vec::new(),
            contested: 0,
            certain: BTreeSet::new(),
            imaginable: HashSet::new(),
        };
        for sample in rows.into_iter().flatten() {
            truth.contested += u64::from(sample.contested);
            truth.certain.extend(sample.certain);
            truth.certain.extend(sample.certain_glass);
            let owners = sample
                .possible
                .iter()
                .filter_map(|p| Some((p.chain, p.owner?.item()?)));
            truth.imaginable.extend(owners);
            truth.imaginable.extend(sample.glass);
            truth.possible.extend(sample.possible);
            truth.ends.push(truth.possible.len() as u32);
        }
        truth
    }

    /// Items that certainly are seen; over all passages, each counted once.
    pub fn visible(&self) -> BTreeSet<(FragmentId, ItemId)> {
        self.certain
            .iter()
            .map(|(chain, item)| (chain.fragment, *item))
            .collect()
    }

    /// Holds a visible set, and the picture that was drawn with it, against the truth. The viewer must have had the
    /// limits that the reference was given.
    pub fn check(&self, set: &VisibleSet, picture: Option<&OwnerPicture>) -> Verdict {
        let answered: HashSet<(Chain, ItemId)> = set
            .items()
            .iter()
            .map(|visible| {
                let passage = set.passage(visible.passage);
                (
                    Chain {
                        hash: passage.chain,
                        fragment: passage.fragment,
                    },
                    visible.item,
                )
            })
            .collect();
        let flat = |items: &mut dyn Iterator<Item = &(Chain, ItemId)>| -> BTreeSet<(FragmentId, ItemId)> {
            items.map(|(chain, item)| (chain.fragment, *item)).collect()
        };
        let missed = flat(&mut self.certain.iter().filter(|seen| !answered.contains(seen)));
        let extra = flat(&mut answered.iter().filter(|seen| !self.imaginable.contains(seen)));
        Verdict {
            reference_visible: self.visible().len(),
            missed: missed.into_iter().collect(),
            extra: extra.len(),
            pixels_different: picture.map_or(0, |picture| self.different(picture).count() as u64),
            pixels_contested: self.contested,
        }
    }

    /// The samples (x, y) that a picture paints with what cannot own them.
    pub fn different<'a>(&'a self, picture: &'a OwnerPicture) -> impl Iterator<Item = [u32; 2]> + 'a {
        (0..self.ends.len())
            .filter(|&sample| {
                let start = sample
                    .checked_sub(1)
                    .map_or(0, |before| self.ends[before] as usize);
                let allowed = &self.possible[start..self.ends[sample] as usize];
                !match picture.at(sample) {
                    Some((hash, owner)) => allowed
                        .iter()
                        .any(|p| p.chain.hash == hash && p.owner == Some(owner)),
                    None => allowed.iter().any(|p| p.owner.is_none()),
                }
            })
            .map(|sample| [sample as u32 % self.size[0], sample as u32 / self.size[0]])
    }

    /// What may own sample (x, y), as text: for the message of a law that fails.
    pub fn describe(&self, [x, y]: [u32; 2]) -> String {
        let sample = (y * self.size[0] + x) as usize;
        let start = sample
            .checked_sub(1)
            .map_or(0, |before| self.ends[before] as usize);
        format!("{:?}", &self.possible[start..self.ends[sample] as usize])
    }
}
