//! Questions other than drawing.

mod beam;
mod cast;
mod near;
mod place;
mod ray;
mod sees;
mod survey;

pub use beam::Reached;
pub use near::Near;
pub use place::{Place, Presence, Walked};
pub use ray::{Cast, Met};
pub use sees::SightLine;
pub use survey::{Standpoint, survey};
