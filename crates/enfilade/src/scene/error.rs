//! Errors of building or changing a scene.

use crate::geom::MAX_COORDINATE;
use crate::method::UnsuitedMethod;
use std::fmt;
use thiserror::Error;

/// An error of building or changing a [`Scene`](crate::Scene): which rule is broken, and where.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A portal, an exit or [`SceneBuilder::open_above`](crate::SceneBuilder::open_above) refers to a sector that does
    /// not exist.
    #[error("{subject} names sector {sector}, but there are only {sectors}")]
    NoSuchSector {
        /// The portal or exit.
        subject: ErrorSubject,
        /// The index of the sector.
        sector: u32,
        /// The number of sectors.
        sectors: usize,
    },
    /// A portal or an exit refers to an opening that its sector does not have.
    #[error("{subject} uses opening {opening} of sector `{sector}`, which has only {openings}")]
    NoSuchOpening {
        /// The portal or exit.
        subject: ErrorSubject,
        /// The sector's name.
        sector: String,
        /// The index of the opening.
        opening: u16,
        /// The number of openings.
        openings: usize,
    },
    /// A portal or an exit refers to an exit that the nested scene does not have.
    #[error("{subject} uses exit `{exit}` of a nested scene, which has {}", self.list_exits())]
    NoSuchExit {
        /// The portal or exit.
        subject: ErrorSubject,
        /// The name of the exit.
        exit: String,
        /// The names of the exits that the nested scene has.
        exits: Vec<String>,
    },
    /// A portal or an exit starts at a sector but at none of its openings.
    #[error(
        "{0} starts at a sector, not at an opening; start it at an opening or at an exit of a nested scene"
    )]
    NoOpening(ErrorSubject),
    /// The sector was removed.
    #[error("sector {0} was removed")]
    RemovedSector(u32),
    /// The portal was removed.
    #[error("portal {0} was removed")]
    RemovedPortal(u32),
    /// The openings of a door, by name, face the same way, so it could be seen through from one side only, and led there
    /// to the wrong side of the wall.
    #[error(
        "openings `{0}` and `{1}` face the same way; the two sides of a door face opposite ways: flip one of the outlines"
    )]
    DoorFacesOneWay(String, String),
    /// The sector is custom, so its geometry and its method cannot be replaced.
    #[error("sector `{0}` is custom; its geometry and method cannot be replaced")]
    CustomSector(String),
    /// Replacement geometry has another number of openings than the geometry before.
    #[error("sector `{sector}` has {had} openings, but its new geometry has {has}; keep their number")]
    Openings {
        /// The sector's name.
        sector: String,
        /// The number of openings before.
        had: usize,
        /// The number of openings of the replacement.
        has: usize,
    },
    /// A light has a number that is not finite (its range may be infinite), a position beyond [`MAX_COORDINATE`], a
    /// range that is not above 0, a zero direction, spot angles out of range, or a sector that does not exist. The
    /// value is its index.
    #[error(
        "light {0} is invalid: it needs finite numbers, a position within {MAX_COORDINATE:e} units, a range above 0, \
         a nonzero direction, angles with 0 <= inner < outer <= pi/2, and a sector of this scene"
    )]
    BadLight(usize),
    /// Two exits have the same name.
    #[error("duplicate exit name `{0}`")]
    TwoExits(String),
    /// Two portals lead out of the same opening.
    #[error("{first} and {second} both lead out of opening `{opening}` of sector `{sector}`")]
    TwoPortals {
        /// The first portal.
        first: ErrorSubject,
        /// The second portal.
        second: ErrorSubject,
        /// The opening's name.
        opening: String,
        /// The sector's name.
        sector: String,
    },
    /// A portal's transform flattens, shears or scales non-uniformly. The value is the portal's index.
    #[error("the transform of portal {0} must be rigid, uniformly scaling or reflecting")]
    NotSimilar(usize),
    /// A portal's transform maps its opening beyond [`MAX_COORDINATE`]. The value is the portal's index.
    #[error(
        "the transform of portal {0} maps its opening beyond {MAX_COORDINATE:e} units; move the target sector closer to the origin"
    )]
    TooFar(usize),
    /// The bounds of a custom sector have a coordinate that is NaN, or finite and beyond [`MAX_COORDINATE`].
    #[error(
        "the bounds of custom sector `{0}` have a coordinate that is NaN, or finite and beyond {MAX_COORDINATE:e} units"
    )]
    BadBounds(String),
    /// The geometry of a sector does not fit its method.
    #[error("sector `{sector}`: {why}")]
    Unsuited {
        /// The sector's name.
        sector: String,
        /// The method, and the reason.
        why: UnsuitedMethod,
    },
}

/// The element that breaks a rule, as named in a [`SceneError`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ErrorSubject {
    /// A portal: its index in the order of addition. A door adds two.
    Portal(usize),
    /// A portal of a nested scene.
    PortalWithin,
    /// An exit, by name.
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
    /// Wraps the error of building a method with the name of the sector.
    pub(super) fn unsuited(sector: &str, why: UnsuitedMethod) -> SceneError {
        let sector = sector.to_owned();
        SceneError::Unsuited { sector, why }
    }

    /// Lists the exits that exist, for the message.
    fn list_exits(&self) -> String {
        match self {
            SceneError::NoSuchExit { exits, .. } if !exits.is_empty() => {
                format!("only `{}`", exits.join("`, `"))
            }
            _ => "none".to_owned(),
        }
    }
}
