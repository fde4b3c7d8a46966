//! Pictures held against rays: each sample of a picture is cast again by itself, and what it meets is looked up and lit in
//! f64, as the documentation has it.

mod glass;
mod samples;
mod shading;
mod stage;
mod textures;
