//! Small scenes on which the conformance suite tests every method. Each has known visible items, by which its pictures
//! can be checked.

mod bottles;
mod house;
mod impossible;
mod neighbours;
mod openings;
mod rooms;
mod sizes;
pub(crate) mod stage;
mod surfaces;
mod teleports;

pub(crate) use bottles::bottles;
pub(crate) use house::house;
pub use house::random_house;
pub(crate) use impossible::impossible;
pub(crate) use neighbours::{seams, wings};
pub(crate) use openings::{free_doorway, mirror, mirrors, nested};
pub(crate) use rooms::{eye_in_things, pillar, slits, two_rooms};
pub(crate) use sizes::{big_mesh, crowd, far_away, huge, tiny};
pub(crate) use stage::Stage;
pub(crate) use surfaces::{coplanar, crossing, degenerate, glass, one_sided, polygons};
pub(crate) use teleports::teleport;
