//! Why a method cannot see a geometry, and what to do about it.

use super::Method;
use crate::geometry::{Geometry, Owner};
use crate::order::{Dent, Refusal};
use std::fmt;
use thiserror::Error;

/// Why a method cannot see a geometry.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Unsuited {
    /// It would need too much memory.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// It goes by what was computed ahead, and nothing was.
    #[error(transparent)]
    NotBaked(#[from] NotBaked),
    /// It sees convex geometries alone, and this is none.
    #[error(transparent)]
    NotConvex(#[from] Box<NotConvex>),
    /// The method needs a height field; the geometry has none, or its blocks were edited.
    #[error(transparent)]
    TerrainUnusable(#[from] TerrainUnusable),
}

impl Unsuited {
    /// What an order refused, in the words of the method that it is of.
    pub(super) fn of(method: Method, geometry: &Geometry, refusal: Refusal, limit: u64) -> Unsuited {
        let instead = Method::HierarchicalZ;
        match refusal {
            // What turns out to be more than estimated is twice the limit, as far as is known.
            Refusal::TooLarge => TooLarge::new(method, limit.saturating_mul(2), limit).into(),
            Refusal::NotBaked => NotBaked { method, instead }.into(),
            Refusal::NoTerrain => TerrainUnusable::Missing { method, instead }.into(),
            Refusal::TerrainChanged => TerrainUnusable::Edited { method, instead }.into(),
            Refusal::NotConvex(dent) => Box::new(NotConvex::new(method, geometry, &dent, instead)).into(),
        }
    }
}

/// A method goes by cells that were computed ahead, but a geometry has none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("not baked: {method} needs a precomputed PVS, and there is none; {instead} needs none")]
#[non_exhaustive]
pub struct NotBaked {
    /// The method that was asked for.
    pub method: Method,
    /// A method that needs no cells.
    pub instead: Method,
}

/// A method needs a height field that the geometry lacks, or whose blocks were edited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TerrainUnusable {
    /// The geometry has no height field.
    #[error(
        "no terrain: {method} needs a height field, and this sector has none; {instead} takes any geometry"
    )]
    Missing {
        /// The requested method.
        method: Method,
        /// A method that takes any geometry.
        instead: Method,
    },
    /// A block of the height field was moved, removed or given another mesh.
    #[error(
        "terrain edited: {method} needs an unchanged height field, and a block of this one was edited; \
         {instead} takes any geometry"
    )]
    Edited {
        /// The requested method.
        method: Method,
        /// A method that takes any geometry.
        instead: Method,
    },
}

/// A method sees geometries in which every face has all others on one side, but in this one a face has some on both.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "not convex: {method} needs every face to have all others on one side, but {wall} has {behind} behind it, \
     {} deep at ({}, {}, {}), and others before it; {instead} takes any geometry",
    short(*.by), short(.point[0]), short(.point[1]), short(.point[2])
)]
#[non_exhaustive]
pub struct NotConvex {
    /// The method that was asked for.
    pub method: Method,
    /// The face that has others on both sides.
    pub wall: FaceName,
    /// What reaches farthest behind it.
    pub behind: FaceName,
    /// The corner that does, in the space of the sector.
    pub point: [f32; 3],
    /// How far that is behind the plane of `wall`, in scene units.
    pub by: f32,
    /// A method that takes any geometry.
    pub instead: Method,
}

/// A face of an item, or an opening, by name and number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FaceName {
    /// A face of an item's mesh.
    OfItem {
        /// The item's name.
        item: String,
        /// Its number.
        number: u32,
        /// The face of its mesh.
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
    fn new(method: Method, geometry: &Geometry, dent: &Dent, instead: Method) -> NotConvex {
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

/// A method would need too much memory; told by an estimate, before anything is built.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{method} needs about {}, above the limit of {}{}", bytes(*.needs_bytes), bytes(*.limit), self.advice())]
#[non_exhaustive]
pub struct TooLarge {
    /// The method that was asked for.
    pub method: Method,
    /// What it would need.
    pub needs_bytes: u64,
    /// What is allowed.
    pub limit: u64,
    /// A method that needs less, if there is one.
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

/// `12.3 MB`, in powers of a thousand.
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
