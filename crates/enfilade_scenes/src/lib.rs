//! The scenes that come with Enfilade: a palace made by code, and the small worlds that its laws are tested on.
//!
//! ```
//! let palace = enfilade_scenes::built_in("enfilade").expect("it is built in");
//! assert_eq!(palace.cameras[0].name, "enfilade");
//! assert!(palace.scene.item_count() > 500);
//! ```
//!
//! Everything is made of numbers: no files, no textures, no randomness but from fixed seeds. All scenes are y up, in
//! metres.
#![forbid(unsafe_code)]

mod camera;
mod catalog;
mod envelope;
mod laws;
mod palace;
mod random;
mod random_scene;
mod shape;

pub use camera::Camera;
pub use catalog::{BuiltIn, Group, NAMES, Named, SCENES, built_in, law_scenes};
pub use random_scene::random_scene;
