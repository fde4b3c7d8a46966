//! Guarantees of visible sets.

use std::fmt;

/// The guarantee that a method gives for its visible set.
///
/// A *sample* is a pixel centre, or the position given by [`View::sample`](crate::View::sample). A face owns a sample
/// if it is the nearest opaque face there.
#[doc(alias = "guarantee")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Contract {
    /// The set may miss visible items; the method's docs say in which scenes.
    Approximate,
    /// The set holds every item that owns a sample, or is transparent in front of one. It may also hold hidden items.
    Conservative,
    /// Conservative for samples at any position in the pixels, so at any resolution.
    Strict,
    /// The set holds every item that owns a sample, or is transparent in front of one, and no item that is hidden at
    /// all samples.
    Exact,
}

impl Contract {
    /// Returns `true` if no visible item is ever missing from the set: for all contracts but [`Contract::Approximate`].
    pub fn never_misses(self) -> bool {
        self != Contract::Approximate
    }

    /// Returns the contract of two sectors together, where one is visible through an opening of the other.
    ///
    /// Two equal contracts give the same contract; [`Contract::Approximate`] with any other gives `Approximate`; all
    /// other pairs give [`Contract::Conservative`]. Exact and strict combine to neither: a strict parent opens a larger
    /// clip region than is visible, and an exact one opens only what pixel centres show.
    #[must_use]
    pub fn combined_with(self, other: Contract) -> Contract {
        match (self, other) {
            (Contract::Approximate, _) | (_, Contract::Approximate) => Contract::Approximate,
            (a, b) if a == b => a,
            _ => Contract::Conservative,
        }
    }
}

impl fmt::Display for Contract {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Contract::Approximate => "approximate",
            Contract::Conservative => "conservative",
            Contract::Strict => "strict",
            Contract::Exact => "exact",
        })
    }
}
