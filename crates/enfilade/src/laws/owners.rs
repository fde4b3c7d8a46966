//! A picture of the face that owns each sample.

use super::chains::{Chain, Chains, PassageChains};
use crate::geometry::Owner;
use crate::ids::PassageId;
use crate::view::canvas::{Canvas, Span};
use crate::view::passage::Passage;

/// A canvas that records the opaque owner of each sample; transparent spans are ignored.
pub struct OwnerPicture {
    width: usize,
    passages: PassageChains,
    /// Chain of the passage being painted.
    chain: Option<Chain>,
    owners: Vec<Option<(Chain, Owner)>>,
}

impl OwnerPicture {
    /// Creates an empty picture of `size` pixels.
    pub fn new(size: [u32; 2]) -> OwnerPicture {
        OwnerPicture {
            width: size[0] as usize,
            passages: PassageChains::default(),
            chain: None,
            owners: vec![None; size[0] as usize * size[1] as usize],
        }
    }

    pub(super) fn at(&self, sample: usize) -> Option<(Chain, Owner)> {
        self.owners[sample]
    }

    pub(super) fn chains(&self) -> &Chains {
        &self.passages.chains
    }

    /// Returns the owner of sample (x, y), whatever its passage.
    pub fn owner(&self, [x, y]: [u32; 2]) -> Option<Owner> {
        self.owners[y as usize * self.width + x as usize].map(|(_, owner)| owner)
    }

    /// Describes the owner of sample (x, y) and the portals it is seen through, for the message of a failed law.
    pub fn describe(&self, [x, y]: [u32; 2]) -> String {
        match self.owners[y as usize * self.width + x as usize] {
            Some((chain, owner)) => {
                format!("{owner:?} through portals {:?}", self.chains().portals(chain.id))
            }
            None => "nothing".to_owned(),
        }
    }

    /// Returns the number of painted samples.
    pub fn painted(&self) -> usize {
        self.owners.iter().flatten().count()
    }

    /// Returns `true` if both pictures show the same owners through the same portals at every sample.
    pub fn same(&self, other: &OwnerPicture) -> bool {
        let numbers = self.chains().numbers_of(other.chains());
        let found = |seen: &Option<(Chain, Owner)>| match seen {
            Some((chain, owner)) => chain.found(&numbers).map(|chain| Some((chain, *owner))),
            None => Some(None),
        };
        let theirs = other.owners.iter().map(found);
        self.owners.len() == other.owners.len() && self.owners.iter().map(|seen| Some(*seen)).eq(theirs)
    }
}

impl Canvas for OwnerPicture {
    fn enter(&mut self, id: PassageId, passage: &Passage) {
        self.chain = Some(self.passages.of(id, passage));
    }

    fn row(&mut self, y: u16, spans: &[Span]) {
        for span in spans.iter().filter(|span| !span.see_through) {
            let start = usize::from(y) * self.width;
            let run = start + usize::from(span.x0)..start + usize::from(span.x1);
            self.owners[run].fill(self.chain.map(|chain| (chain, span.owner)));
        }
    }
}
