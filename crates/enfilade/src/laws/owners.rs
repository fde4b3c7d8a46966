//! A picture of which face was painted at each sample.

use crate::canvas::{Canvas, Span};
use crate::content::Owner;
use crate::passage::{Passage, PassageId};

/// A canvas that keeps the owner of each sample; glass is left aside.
pub struct OwnerPicture {
    width: usize,
    chain: u64,
    owners: Vec<Option<(u64, Owner)>>,
}

impl OwnerPicture {
    /// An empty picture.
    pub fn new(size: [u32; 2]) -> OwnerPicture {
        OwnerPicture {
            width: size[0] as usize,
            chain: 0,
            owners: vec![None; size[0] as usize * size[1] as usize],
        }
    }

    pub(super) fn at(&self, sample: usize) -> Option<(u64, Owner)> {
        self.owners[sample]
    }

    /// The owner painted at sample (x, y), whatever passage it is seen through.
    pub fn owner(&self, [x, y]: [u32; 2]) -> Option<Owner> {
        self.owners[y as usize * self.width + x as usize].map(|(_, owner)| owner)
    }

    /// Samples on which anything is painted.
    pub fn painted(&self) -> usize {
        self.owners.iter().flatten().count()
    }

    /// Do two pictures show the same owners everywhere, through the same passages?
    pub fn same(&self, other: &OwnerPicture) -> bool {
        self.owners == other.owners
    }
}

impl Canvas for OwnerPicture {
    fn enter(&mut self, _id: PassageId, passage: &Passage) {
        self.chain = passage.chain;
    }

    fn row(&mut self, y: u16, spans: &[Span]) {
        for span in spans.iter().filter(|span| !span.see_through) {
            let start = usize::from(y) * self.width;
            let run = start + usize::from(span.x0)..start + usize::from(span.x1);
            self.owners[run].fill(Some((self.chain, span.owner)));
        }
    }
}
