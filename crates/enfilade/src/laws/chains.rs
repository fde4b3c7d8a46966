//! Chains of portals, each listed portal by portal.
//!
//! Methods name a chain by a hash; here no name stands for one, so that two chains with one name would be noticed.

use crate::passage::{Passage, PassageId};
use crate::scene::{PortalId, SectorId};
use std::collections::HashMap;

/// A chain by its number in a [`Chains`]; 0 is the empty one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct ChainId(u32);

/// A chain of portals that begins where the eye is, and the sector that it ends in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Chain {
    pub(super) id: ChainId,
    pub(super) sector: SectorId,
}

/// All chains met so far, as a tree: the last portal of each, and the chain before it.
#[derive(Clone, Debug, Default)]
pub(super) struct Chains {
    links: Vec<(ChainId, PortalId)>,
    longer: HashMap<(ChainId, PortalId), ChainId>,
}

impl Chains {
    /// The chain that goes on through `portal`.
    pub(super) fn through(&mut self, chain: ChainId, portal: PortalId) -> ChainId {
        *self.longer.entry((chain, portal)).or_insert_with(|| {
            self.links.push((chain, portal));
            ChainId(self.links.len() as u32)
        })
    }

    /// The portals of a chain, in order.
    pub(super) fn portals(&self, chain: ChainId) -> Vec<u32> {
        let mut portals = Vec::new();
        let mut next = chain;
        while let Some(last) = next.0.checked_sub(1) {
            let (before, portal) = self.links[last as usize];
            portals.push(portal.0);
            next = before;
        }
        portals.reverse();
        portals
    }

    /// The number that each chain of `other` has here, in its order; `None` for those that are not here.
    pub(super) fn numbers_of(&self, other: &Chains) -> Vec<Option<ChainId>> {
        let mut numbers = vec![Some(ChainId(0))];
        for &(before, portal) in &other.links {
            let before = numbers[before.0 as usize];
            numbers.push(before.and_then(|before| self.longer.get(&(before, portal)).copied()));
        }
        numbers
    }

    /// Adds all chains of `other`; gives the number that each has here, in its order.
    pub(super) fn add_all(&mut self, other: &Chains) -> Vec<ChainId> {
        let mut numbers = vec![ChainId(0)];
        for &(before, portal) in &other.links {
            numbers.push(self.through(numbers[before.0 as usize], portal));
        }
        numbers
    }
}

impl Chain {
    /// The same chain in another list, by what [`Chains::add_all`] gave.
    pub(super) fn renumbered(self, numbers: &[ChainId]) -> Chain {
        let id = numbers[self.id.0 as usize];
        Chain { id, ..self }
    }

    /// The same chain in another list, by what [`Chains::numbers_of`] gave.
    pub(super) fn found(self, numbers: &[Option<ChainId>]) -> Option<Chain> {
        numbers[self.id.0 as usize].map(|id| Chain { id, ..self })
    }
}

/// The chains of the passages of one look, by following each to its parent.
#[derive(Clone, Default)]
pub(super) struct PassageChains {
    pub(super) chains: Chains,
    known: HashMap<PassageId, Chain>,
}

impl PassageChains {
    /// The chain of a passage, whose parent must have been asked for before.
    pub(super) fn of(&mut self, id: PassageId, passage: &Passage) -> Chain {
        let sector = passage.sector;
        let chain = match (passage.parent, passage.portal) {
            (Some(parent), Some(portal)) => {
                let before = self.known[&parent].id;
                let id = self.chains.through(before, portal);
                Chain { id, sector }
            }
            _ => Chain {
                id: ChainId::default(),
                sector,
            },
        };
        self.known.insert(id, chain);
        chain
    }
}
