//! Why fragments and portals do not make a scene.

use crate::method::TooLarge;
use thiserror::Error;

/// Why fragments and portals do not make a scene.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A portal names a fragment that is not there.
    #[error("portal {portal} leads to fragment {fragment}, but there are only {fragments}")]
    NoSuchFragment {
        /// Which portal, by the order in which they were added; a door is two.
        portal: usize,
        /// The fragment it names.
        fragment: u32,
        /// How many there are.
        fragments: usize,
    },
    /// A portal names an opening that its fragment does not have.
    #[error("portal {portal} uses opening {opening} of fragment `{fragment}`, which has only {openings}")]
    NoSuchOpening {
        /// Which portal.
        portal: usize,
        /// The fragment's name.
        fragment: String,
        /// The opening it names.
        opening: u16,
        /// How many there are.
        openings: usize,
    },
    /// A portal names an exit that the nested scene does not have.
    #[error("portal {portal} uses exit `{exit}` of a nested scene, which has only: {exits}")]
    NoSuchExit {
        /// Which portal.
        portal: usize,
        /// The exit it names.
        exit: String,
        /// Those that there are.
        exits: String,
    },
    /// A portal or an exit leads out of a fragment, but not of an opening of it.
    #[error("portal {0} begins anywhere in a fragment; a portal leads out of an opening, or out of an exit")]
    NoOpening(usize),
    /// Content is given to a fragment that is the user's own.
    #[error("fragment `{0}` is one of your own: it has no content to exchange")]
    NotOurs(String),
    /// Content that is to replace another has more or fewer openings.
    #[error("fragment `{fragment}` has {had} openings, but the content that is to replace its own has {has}")]
    Openings {
        /// The fragment's name.
        fragment: String,
        /// How many there were.
        had: usize,
        /// How many there would be.
        has: usize,
    },
    /// A light has a number that is not finite, a range of nothing, or a fragment that is not there.
    #[error("light {0} must have finite numbers, a range above 0, and a fragment of this scene")]
    BadLight(usize),
    /// Two portals lead out of one opening.
    #[error("portals {first} and {second} both lead out of opening `{opening}` of fragment `{fragment}`")]
    TwoPortals {
        /// The first of the two.
        first: usize,
        /// The second of the two.
        second: usize,
        /// The opening's name.
        opening: String,
        /// The fragment's name.
        fragment: String,
    },
    /// A portal's transform flattens, shears or stretches.
    #[error("the transform of portal {0} is not rigid, uniformly scaling or reflecting")]
    NotSimilar(usize),
    /// A fragment needs more memory than allowed.
    #[error("fragment `{fragment}`: {why}")]
    TooLarge {
        /// The fragment's name.
        fragment: String,
        /// What it needs.
        why: TooLarge,
    },
}
