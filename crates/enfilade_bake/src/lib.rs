//! Computes ahead what can be seen from where.
//!
//! ```
//! use enfilade_bake::{Cells, PairsOptions, Portal, VisiblePairs};
//!
//! // Three rooms in a row, a door of 2 × 2 between each two.
//! let door = |x: f64, cells| Portal {
//!     corners: vec![[x, -1.0, 0.0], [x, 1.0, 0.0], [x, 1.0, 2.0], [x, -1.0, 2.0]],
//!     cells,
//! };
//! let rooms = Cells::new(3, vec![door(10.0, [0, 1]), door(20.0, [1, 2])])?;
//! let pairs = VisiblePairs::compute(&rooms, &PairsOptions::default())?;
//! assert!(pairs.sees(0, 2));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Cells`] are convex rooms joined by convex portals. [`VisiblePairs`] says which of them see each other from anywhere
//! inside: an upper bound, never less than what is seen; [`PairsWork`] finds it out in steps, can be stopped, and goes on.
//! [`find_missing`] shoots random lines through the
//! cells, without any of the code that computes the pairs, and finds a [`Witness`] where one is missing.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod aim;
mod between;
mod bits;
mod cells;
mod first_bound;
mod flow;
mod known;
mod line;
mod pairs;
mod passages;
mod random;
mod saved;
mod separators;
mod ways;
mod winding;
mod work;

pub use cells::{Cells, CellsError, Portal};

pub use line::{Witness, find_missing};
pub use pairs::{PairsOptions, VisiblePairs};
pub use saved::ResumeError;
pub use work::{PairsWork, Stage, TooLarge};
