//! Errors: why a method cannot be built for a geometry, and what to use instead.

use super::Method;
use crate::geometry::{Geometry, Owner};
use crate::order::{NonConvexity, Refusal};
use std::fmt;
use thiserror::Error;

/// An error of building a [`Method`] for a geometry.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Unsuited {
    /// The method needs more memory than the limit.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// The method requires a baked PVS; the geometry has none.
    #[error(transparent)]
    NotBaked(#[from] NotBaked),
    /// The method requires convex geometry; a face violates that.
    #[error(transparent)]
    NotConvex(#[from] Box<NotConvex>),
    /// The method requires a height field; the geometry has none, or its blocks were edited.
    #[error(transparent)]
    TerrainUnusable(#[from] TerrainUnusable),
}

impl Unsuited {
    /// Converts the error of an order into that of its method.
    pub(super) fn of(method: Method, geometry: &Geometry, refusal: Refusal, limit: u64) -> Unsuited {
        let instead = Method::HierarchicalZ;
        match refusal {
            // The order only knows that the limit is exceeded: report twice the limit.
            Refusal::TooLarge => TooLarge::new(method, limit.saturating_mul(2), limit).into(),
            Refusal::NotBaked => NotBaked { method, instead }.into(),
            Refusal::NoTerrain => TerrainUnusable::Missing { method, instead }.into(),
            Refusal::TerrainChanged => TerrainUnusable::Edited { method, instead }.into(),
            Refusal::NotConvex(dent) => Box::new(NotConvex::new(method, geometry, &dent, instead)).into(),
        }
    }
}

/// A method requires a baked PVS that the geometry lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("method {method} needs a baked PVS and this sector has none; use {instead}, or bake one")]
#[non_exhaustive]
pub struct NotBaked {
    /// The requested method.
    pub method: Method,
    /// A method that needs no baked PVS.
    pub instead: Method,
}

/// A method requires a height field that the geometry lacks, or whose blocks were edited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TerrainUnusable {
    /// The geometry has no height field.
    #[error("method {method} needs a height field and this sector has none; use {instead}")]
    Missing {
        /// The requested method.
        method: Method,
        /// A method that takes any geometry.
        instead: Method,
    },
    /// A block of the height field was moved, removed or given another mesh.
    #[error(
        "method {method} needs an unedited height field and a block of this one was edited; use {instead}"
    )]
    Edited {
        /// The requested method.
        method: Method,
        /// A method that takes any geometry.
        instead: Method,
    },
}

/// A method requires convex geometry, in which all faces are on one side of each face; here one face has others on both
/// sides.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "method {method} needs a convex sector, but {behind} is {} behind the plane of {wall} at ({}, {}, {}), \
     and another face is in front of it; use {instead}",
    short(*.by), short(.point[0]), short(.point[1]), short(.point[2])
)]
#[non_exhaustive]
pub struct NotConvex {
    /// The requested method.
    pub method: Method,
    /// The face that has other faces on both sides.
    pub wall: FaceName,
    /// The face that extends farthest behind it.
    pub behind: FaceName,
    /// The farthest corner of `behind`, in the space of the sector.
    pub point: [f32; 3],
    /// Distance of `point` behind the plane of `wall`, in scene units.
    pub by: f32,
    /// A method that takes any geometry.
    pub instead: Method,
}

/// A face of an item, or an opening, identified by name and number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FaceName {
    /// A face of an item's mesh.
    OfItem {
        /// The item's name.
        item: String,
        /// Its number.
        number: u32,
        /// The index of the face in its mesh.
        face: u32,
    },
    /// An opening.
    Opening {
        /// The opening's name.
        name: String,
        /// Its number.
        number: u16,
    },
}

impl FaceName {
    fn new(geometry: &Geometry, owner: Owner) -> FaceName {
        match owner {
            Owner::Face(item, face) => FaceName::OfItem {
                item: geometry.name(item).to_owned(),
                number: item.0,
                face,
            },
            Owner::Opening(opening) => FaceName::Opening {
                name: geometry.openings()[usize::from(opening.0)].name.clone(),
                number: opening.0,
            },
        }
    }
}

impl fmt::Display for FaceName {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            FaceName::OfItem { item, number, face } if item.is_empty() => {
                write!(f, "face {face} of item {number}")
            }
            FaceName::OfItem { item, number, face } => write!(f, "face {face} of item {number} `{item}`"),
            FaceName::Opening { name, .. } => write!(f, "opening `{name}`"),
        }
    }
}

impl NotConvex {
    fn new(method: Method, geometry: &Geometry, dent: &NonConvexity, instead: Method) -> NotConvex {
        NotConvex {
            method,
            wall: FaceName::new(geometry, dent.wall),
            behind: FaceName::new(geometry, dent.behind),
            point: dent.point.map(|value| value as f32),
            by: dent.by as f32,
            instead,
        }
    }
}

/// A method needs more memory than the limit. Mostly estimated before anything is built.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{method} needs about {}, above the limit of {}{}", bytes(*.needs_bytes), bytes(*.limit), self.advice())]
#[non_exhaustive]
pub struct TooLarge {
    /// The requested method.
    pub method: Method,
    /// The estimated memory needed, in bytes.
    pub needs_bytes: u64,
    /// The limit, in bytes.
    pub limit: u64,
    /// A method that needs less memory; `None` if there is none.
    pub instead: Option<Method>,
}

impl TooLarge {
    pub(super) fn new(method: Method, needs_bytes: u64, limit: u64) -> TooLarge {
        let instead = (method != Method::ZBuffer).then_some(Method::ZBuffer);
        TooLarge {
            method,
            needs_bytes,
            limit,
            instead,
        }
    }

    fn advice(&self) -> String {
        self.instead
            .map_or_else(String::new, |method| format!("; {method} needs less"))
    }
}

/// Formats a number of bytes with a decimal unit, as in `12.3 MB`.
fn bytes(number: u64) -> String {
    let (unit, name) = match number {
        1 => (1.0, "byte"),
        0..1_000 => (1.0, "bytes"),
        1_000..1_000_000 => (1e3, "kB"),
        1_000_000..1_000_000_000 => (1e6, "MB"),
        _ => (1e9, "GB"),
    };
    format!("{} {name}", short((number as f64 / unit) as f32))
}

/// Rounds a number to four significant digits.
fn short(number: f32) -> f32 {
    format!("{number:.3e}").parse().unwrap_or(number)
}
