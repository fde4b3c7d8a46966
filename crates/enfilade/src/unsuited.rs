//! Errors: why a geometry does not fit a method.

#[cfg(feature = "classic")]
use crate::geometry::{Geometry, Owner};
use std::fmt;
use thiserror::Error;

/// Reasons why a geometry does not fit a method. [`UnsuitedMethod`](crate::UnsuitedMethod) adds the method.
///
/// The messages go on where "method x" ends. They name `hierarchical-z`, which takes any geometry.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Unsuited {
    /// The method needs more memory than the limit. Mostly estimated before anything is built.
    #[error("needs about {}, above the limit of {}", bytes(*.needs_bytes), bytes(*.limit))]
    TooLarge {
        /// The estimated memory needed, in bytes.
        needs_bytes: u64,
        /// The limit, in bytes.
        limit: u64,
    },
    /// The method requires a baked PVS, which the geometry lacks.
    #[error("needs a baked PVS and this sector has none; use hierarchical-z, or bake one")]
    NotBaked,
    /// The method requires convex geometry, and a face violates that.
    #[error(transparent)]
    NotConvex(#[from] Box<NotConvex>),
    /// The method requires a height field, which the geometry lacks.
    #[error("needs a height field and this sector has none; use hierarchical-z")]
    NoTerrain,
    /// The method requires an unedited height field, and a block was moved, removed or given another mesh.
    #[error("needs an unedited height field and a block of this one was edited; use hierarchical-z")]
    TerrainEdited,
}

impl Unsuited {
    /// The error of a structure that turns out to exceed the limit while it is built: reports twice the limit.
    pub(crate) fn exceeds(limit: u64) -> Unsuited {
        Unsuited::TooLarge {
            needs_bytes: limit.saturating_mul(2),
            limit,
        }
    }
}

/// A face that has others on both sides, where convex geometry is required.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "needs a convex sector, but {behind} is {} behind the plane of {wall} at ({}, {}, {}), \
     and another face is in front of it; use hierarchical-z",
    short(*.by), short(.point[0]), short(.point[1]), short(.point[2])
)]
#[non_exhaustive]
pub struct NotConvex {
    /// The face that has other faces on both sides.
    pub wall: FaceName,
    /// The face that extends farthest behind it.
    pub behind: FaceName,
    /// The farthest corner of `behind`, in the space of the sector.
    pub point: [f32; 3],
    /// Distance of `point` behind the plane of `wall`, in scene units.
    pub by: f32,
}

#[cfg(feature = "classic")]
impl NotConvex {
    /// `point`: the corner of `behind` that is farthest, `by` scene units, behind `wall`.
    pub(crate) fn new(
        geometry: &Geometry,
        [wall, behind]: [Owner; 2],
        point: [f64; 3],
        by: f64,
    ) -> NotConvex {
        NotConvex {
            wall: FaceName::new(geometry, wall),
            behind: FaceName::new(geometry, behind),
            point: point.map(|value| value as f32),
            by: by as f32,
        }
    }
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

#[cfg(feature = "classic")]
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
