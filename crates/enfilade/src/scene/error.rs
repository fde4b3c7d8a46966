//! Why sectors and portals do not make a scene.

use crate::geom::MAX_COORDINATE;
use crate::method::{NotBaked, NotConvex, TerrainUnusable, TooLarge, Unsuited};
use std::fmt;
use thiserror::Error;

/// Why sectors and portals do not make a scene.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A portal or an exit names a sector that is not there.
    #[error("{subject} names sector {sector}, but there are only {sectors}")]
    NoSuchSector {
        /// Which portal or exit.
        subject: ErrorSubject,
        /// The sector it names.
        sector: u32,
        /// How many there are.
        sectors: usize,
    },
    /// A portal or an exit names an opening that its sector does not have.
    #[error("{subject} uses opening {opening} of sector `{sector}`, which has only {openings}")]
    NoSuchOpening {
        /// Which portal or exit.
        subject: ErrorSubject,
        /// The sector's name.
        sector: String,
        /// The opening it names.
        opening: u16,
        /// How many there are.
        openings: usize,
    },
    /// A portal or an exit names an exit that the nested scene does not have.
    #[error("{subject} uses exit `{exit}` of a nested scene, which has {}", self.exits_in_words())]
    NoSuchExit {
        /// Which portal or exit.
        subject: ErrorSubject,
        /// The exit it names.
        exit: String,
        /// Those that there are.
        exits: Vec<String>,
    },
    /// A portal or an exit leads out of a sector, but not of an opening of it.
    #[error(
        "{0} begins anywhere in a sector; it must lead out of an opening, or out of a nested scene's exit"
    )]
    NoOpening(ErrorSubject),
    /// Geometry or a method is given to a sector that is the user's own.
    #[error("sector `{0}` is one of your own: it has neither geometry nor method to exchange")]
    NotOurs(String),
    /// Geometry that is to replace another has more or fewer openings.
    #[error("sector `{sector}` has {had} openings, but the geometry that is to replace its own has {has}")]
    Openings {
        /// The sector's name.
        sector: String,
        /// How many there were.
        had: usize,
        /// How many there would be.
        has: usize,
    },
    /// A light has a number that is not finite, a range of nothing, or a sector that is not there.
    #[error(
        "light {0} must have finite numbers, a position within {MAX_COORDINATE:e} units, a range above 0, and a sector of this scene"
    )]
    BadLight(usize),
    /// Two exits have one name.
    #[error("two exits are called `{0}`: what joins one could mean either")]
    TwoExits(String),
    /// Two portals lead out of one opening.
    #[error("{first} and {second} both lead out of opening `{opening}` of sector `{sector}`")]
    TwoPortals {
        /// The first of the two.
        first: ErrorSubject,
        /// The second of the two.
        second: ErrorSubject,
        /// The opening's name.
        opening: String,
        /// The sector's name.
        sector: String,
    },
    /// A portal's transform flattens, shears or stretches.
    #[error("the transform of portal {0} is not rigid, uniformly scaling or reflecting")]
    NotSimilar(usize),
    /// A portal leads to where no coordinate may be: the image of its opening reaches beyond [`MAX_COORDINATE`].
    #[error(
        "the transform of portal {0} leads farther out than {MAX_COORDINATE:e} units; move what it leads to nearer to the origin"
    )]
    TooFar(usize),
    /// The box of a custom sector has a coordinate that is NaN, or finite and beyond [`MAX_COORDINATE`].
    #[error(
        "the box of sector `{0}` has a coordinate that is not a number, or is farther out than {MAX_COORDINATE:e} units and not infinite"
    )]
    BadBounds(String),
    /// A sector needs more memory than allowed.
    #[error("sector `{sector}`: {why}")]
    TooLarge {
        /// The sector's name.
        sector: String,
        /// What it needs.
        why: TooLarge,
    },
    /// A sector has not what its method goes by.
    #[error("sector `{sector}`: {why}")]
    NotBaked {
        /// The sector's name.
        sector: String,
        /// What it lacks.
        why: NotBaked,
    },
    /// A sector is not convex, and its method sees no others.
    #[error("sector `{sector}`: {why}")]
    NotConvex {
        /// The sector's name.
        sector: String,
        /// Where it is not.
        why: Box<NotConvex>,
    },
    /// A sector has no height field, or its blocks were changed, and its method goes by one.
    #[error("sector `{sector}`: {why}")]
    TerrainUnusable {
        /// The sector's name.
        sector: String,
        /// Which of the two.
        why: TerrainUnusable,
    },
}

/// What a broken rule is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ErrorSubject {
    /// A portal, by the order in which they were added; a door is two.
    Portal(usize),
    /// A portal of a scene that stands in this one.
    PortalWithin,
    /// An exit, by its name.
    Exit(String),
    /// A call of [`SceneBuilder::open_above`](crate::SceneBuilder::open_above).
    OpenAbove,
}

impl fmt::Display for ErrorSubject {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            ErrorSubject::Portal(number) => write!(f, "portal {number}"),
            ErrorSubject::PortalWithin => f.write_str("a portal of a nested scene"),
            ErrorSubject::Exit(name) => write!(f, "exit `{name}`"),
            ErrorSubject::OpenAbove => f.write_str("open_above"),
        }
    }
}

impl SceneError {
    /// Why a sector's method cannot see its geometry.
    pub(super) fn unsuited(sector: &str, why: Unsuited) -> SceneError {
        let sector = sector.to_owned();
        match why {
            Unsuited::TooLarge(why) => SceneError::TooLarge { sector, why },
            Unsuited::NotBaked(why) => SceneError::NotBaked { sector, why },
            Unsuited::NotConvex(why) => SceneError::NotConvex { sector, why },
            Unsuited::TerrainUnusable(why) => SceneError::TerrainUnusable { sector, why },
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
