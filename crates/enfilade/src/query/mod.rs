//! Questions other than drawing.

mod cast;
mod survey;

pub use survey::{Standpoint, survey};
