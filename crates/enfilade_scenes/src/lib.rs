//! built-in scenes
#![forbid(unsafe_code)]
mod camera;
mod palace;
mod random;
mod shape;
pub use camera::Camera;
/// s
pub struct BuiltIn { /// s
 pub scene: enfilade::Scene, /// c
 pub cameras: Vec<Camera> }
/// x
pub fn built_in(_:&str)->Option<BuiltIn>{ Some(palace::palace(palace::SEED)) }
