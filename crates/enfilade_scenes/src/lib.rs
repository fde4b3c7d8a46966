//! The scenes that come with Enfilade: a palace made by code, the small worlds that its laws are tested on, and the
//! figures of a thesis that compares painters with BSP trees.
//!
//! ```
//! let palace = enfilade_scenes::built_in("enfilade").expect("it is built in");
//! assert_eq!(palace.cameras[0].name, "enfilade");
//! assert!(palace.scene.item_count() > 500);
//! ```
//!
//! Everything is made of numbers, images too: no files, no randomness but from fixed seeds. All scenes are y up, in
//! metres.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod camera;
mod catalog;
mod envelope;
mod fuzz_scene;
mod laws;
mod palace;
mod random;
mod random_edits;
mod random_scene;
mod shape;
mod thesis;

pub use camera::Camera;
pub use catalog::{BuiltIn, Group, NAMES, Named, SCENES, built_in, figures, law_scenes};
pub use fuzz_scene::{FuzzScene, fuzz_scene};
pub use laws::random_house;
pub use palace::{FOUNTAIN_SECONDS, fountain, person};
pub use random::Random;
pub use random_edits::random_edits;
pub use random_scene::random_scene;
