//! Questions other than drawing.

mod beam;
mod between;
mod capsule;
mod cast;
mod items;
mod large_terrain;
mod near;
mod nearest;
mod pairs;
mod place;
mod ray;
mod sees;
mod survey;

pub use beam::Reached;
pub use between::Between;
pub use capsule::{Capsule, Slid};
pub use near::{Near, Nearby};
pub use nearest::Nearest;
pub use pairs::{BoxError, PairChanges, Pairs};
pub use place::{Location, Presence, Walked};
pub use ray::{Cast, Met};
pub use sees::SightLine;
pub use survey::{Standpoint, Survey, survey, survey_hard, survey_in};
