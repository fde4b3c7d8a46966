//! C interface of [Enfilade](enfilade). Its documentation is the header, `include/enfilade.h`, which `cargo xtask header`
//! writes from this crate.
//!
//! # Safety
//! All functions that take pointers are `unsafe`, for one reason: a pointer must be null, or what its documentation says, for the
//! length of the call. Handles are exempt: they are numbers, which nothing follows, so any value is safe.
// `deny`, not `forbid`: each function allows it, to promise what C promises.
#![deny(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn)]
#![allow(
    clippy::missing_safety_doc,
    reason = "it is the same for all functions: see above"
)]
#![allow(clippy::too_many_arguments, reason = "C has no slices, options and results")]

mod handle;
mod ids;
mod items;
mod lent;
mod mesh;
mod occlusion;
mod portals;
mod query;
mod rooms;
mod scene;
mod status;
mod threads;
mod version;
mod view;
mod viewer;

pub use ids::*;
pub use items::*;
pub use mesh::*;
pub use occlusion::*;
pub use portals::*;
pub use query::*;
pub use rooms::*;
pub use scene::*;
pub use status::*;
pub use threads::*;
pub use version::*;
pub use view::*;
pub use viewer::*;
