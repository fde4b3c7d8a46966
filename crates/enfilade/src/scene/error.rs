//! Why fragments and portals do not make a scene.

use crate::geom::MAX_COORDINATE;
use crate::method::{NoTerrain, NotBaked, NotConvex, TooLarge, Unsuited};
use std::fmt;
use thiserror::Error;

/// Why fragments and portals do not make a scene.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A portal or an exit names a fragment that is not there.
    #[error("{way} names fragment {fragment}, but there are only {fragments}")]
    NoSuchFragment {
        /// Which portal or exit.
        way: Way,
        /// The fragment it names.
        fragment: u32,
        /// How many there are.
        fragments: usize,
    },
    /// A portal or an exit names an opening that its fragment does not have.
    #[error("{way} uses opening {opening} of fragment `{fragment}`, which has only {openings}")]
    NoSuchOpening {
        /// Which portal or exit.
        way: Way,
        /// The fragment's name.
        fragment: String,
        /// The opening it names.
        opening: u16,
        /// How many there are.
        openings: usize,
    },
    /// A portal or an exit names an exit that the nested scene does not have.
    #[error("{way} uses exit `{exit}` of a nested scene, which has {}", self.exits_in_words())]
    NoSuchExit {
        /// Which portal or exit.
        way: Way,
        /// The exit it names.
        exit: String,
        /// Those that there are.
        exits: Vec<String>,
    },
    /// A portal or an exit leads out of a fragment, but not of an opening of it.
    #[error(
        "{0} begins anywhere in a fragment; it must lead out of an opening, or out of a nested scene's exit"
    )]
    NoOpening(Way),
    /// Content or a method is given to a fragment that is the user's own.
    #[error("fragment `{0}` is one of your own: it has neither content nor method to exchange")]
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
    #[error(
        "light {0} must have finite numbers, a position within {MAX_COORDINATE:e} units, a range above 0, and a fragment of this scene"
    )]
    BadLight(usize),
    /// Two exits have one name.
    #[error("two exits are called `{0}`: what joins one could mean either")]
    TwoExits(String),
    /// Two portals lead out of one opening.
    #[error("{first} and {second} both lead out of opening `{opening}` of fragment `{fragment}`")]
    TwoPortals {
        /// The first of the two.
        first: Way,
        /// The second of the two.
        second: Way,
        /// The opening's name.
        opening: String,
        /// The fragment's name.
        fragment: String,
    },
    /// A portal's transform flattens, shears or stretches.
    #[error("the transform of portal {0} is not rigid, uniformly scaling or reflecting")]
    NotSimilar(usize),
    /// A portal leads to where no coordinate may be: the image of its opening reaches beyond [`MAX_COORDINATE`].
    #[error(
        "the transform of portal {0} leads farther out than {MAX_COORDINATE:e} units; move what it leads to nearer to the origin"
    )]
    TooFar(usize),
    /// The box of a custom fragment has a coordinate that is NaN, or finite and beyond [`MAX_COORDINATE`].
    #[error(
        "the box of fragment `{0}` has a coordinate that is not a number, or is farther out than {MAX_COORDINATE:e} units and not infinite"
    )]
    BadBounds(String),
    /// A fragment needs more memory than allowed.
    #[error("fragment `{fragment}`: {why}")]
    TooLarge {
        /// The fragment's name.
        fragment: String,
        /// What it needs.
        why: TooLarge,
    },
    /// A fragment has not what its method goes by.
    #[error("fragment `{fragment}`: {why}")]
    NotBaked {
        /// The fragment's name.
        fragment: String,
        /// What it lacks.
        why: NotBaked,
    },
    /// A fragment is not convex, and its method sees no others.
    #[error("fragment `{fragment}`: {why}")]
    NotConvex {
        /// The fragment's name.
        fragment: String,
        /// Where it is not.
        why: Box<NotConvex>,
    },
    /// A fragment has no height field, or its blocks were changed, and its method goes by one.
    #[error("fragment `{fragment}`: {why}")]
    NoTerrain {
        /// The fragment's name.
        fragment: String,
        /// Which of the two.
        why: NoTerrain,
    },
}

/// What a broken rule is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Way {
    /// A portal, by the order in which they were added; a door is two.
    Portal(usize),
    /// A portal of a scene that stands in this one.
    PortalWithin,
    /// An exit, by its name.
    Exit(String),
    /// A call of [`SceneBuilder::open_above`](crate::SceneBuilder::open_above).
    OpenAbove,
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Way::Portal(number) => write!(f, "portal {number}"),
            Way::PortalWithin => f.write_str("a portal of a nested scene"),
            Way::Exit(name) => write!(f, "exit `{name}`"),
            Way::OpenAbove => f.write_str("open_above"),
        }
    }
}

impl SceneError {
    /// Why a fragment's method cannot see its content.
    pub(super) fn unsuited(fragment: &str, why: Unsuited) -> SceneError {
        let fragment = fragment.to_owned();
        match why {
            Unsuited::TooLarge(why) => SceneError::TooLarge { fragment, why },
            Unsuited::NotBaked(why) => SceneError::NotBaked { fragment, why },
            Unsuited::NotConvex(why) => SceneError::NotConvex { fragment, why },
            Unsuited::NoTerrain(why) => SceneError::NoTerrain { fragment, why },
        }
    }

    /// The exits that there are.
    fn exits_in_words(&self) -> String {
        match self {
            SceneError::NoSuchExit { exits, .. } if !exits.is_empty() => {
                format!("only `{}`", exits.join("`, `"))
            }
            _ => "none".to_owned(),
        }
    }
}
