//! Portal chains, stored portal by portal.
//!
//! The methods identify a chain by a hash. Here chains are compared by their portals, so a hash collision in a method
//! is detected.

use crate::ids::{PassageId, PortalId, SectorId};
use crate::view::passage::Passage;
use std::collections::HashMap;

/// Index of a chain in a [`Chains`]; 0 is the empty chain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct ChainId(u32);

/// A chain of portals that starts in the eye's sector, and the sector in which it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Chain {
    pub(super) id: ChainId,
    pub(super) sector: SectorId,
}

/// All chains met so far, as a prefix tree: the last portal of each and its parent chain.
#[derive(Clone, Debug, Default)]
pub(super) struct Chains {
    links: Vec<(ChainId, PortalId)>,
    longer: HashMap<(ChainId, PortalId), ChainId>,
}

impl Chains {
    /// Returns the chain extended by `portal`; adds it if it is new.
    pub(super) fn through(&mut self, chain: ChainId, portal: PortalId) -> ChainId {
        *self.longer.entry((chain, portal)).or_insert_with(|| {
            self.links.push((chain, portal));
            ChainId(self.links.len() as u32)
        })
    }

    /// Returns the portals of a chain, in order.
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

    /// Maps each chain of `other`, in its order, to the id here; `None` for chains that are not here.
    pub(super) fn numbers_of(&self, other: &Chains) -> Vec<Option<ChainId>> {
        let mut numbers = vec![Some(ChainId(0))];
        for &(before, portal) in &other.links {
            let before = numbers[before.0 as usize];
            numbers.push(before.and_then(|before| self.longer.get(&(before, portal)).copied()));
        }
        numbers
    }

    /// Adds all chains of `other`. Returns the id here of each, in its order.
    pub(super) fn add_all(&mut self, other: &Chains) -> Vec<ChainId> {
        let mut numbers = vec![ChainId(0)];
        for &(before, portal) in &other.links {
            numbers.push(self.through(numbers[before.0 as usize], portal));
        }
        numbers
    }
}

impl Chain {
    /// Returns the same chain in another list; `numbers` comes from [`Chains::add_all`].
    pub(super) fn renumbered(self, numbers: &[ChainId]) -> Chain {
        let id = numbers[self.id.0 as usize];
        Chain { id, ..self }
    }

    /// Returns the same chain in another list; `numbers` comes from [`Chains::numbers_of`].
    pub(super) fn found(self, numbers: &[Option<ChainId>]) -> Option<Chain> {
        numbers[self.id.0 as usize].map(|id| Chain { id, ..self })
    }
}

/// The chains of the passages of one look, found through each passage's parent.
#[derive(Clone, Default)]
pub(super) struct PassageChains {
    pub(super) chains: Chains,
    known: HashMap<PassageId, Chain>,
}

impl PassageChains {
    /// Returns the chain of a passage. Its parent must have been passed in before.
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
