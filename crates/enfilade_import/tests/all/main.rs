//! Tests of the readers, a folder for each format.

mod gltf;
mod golden;
mod hides;
mod mixed;
mod obj;
mod others;
mod quake;
mod surely_visible;
mod terrain;
mod tiles;
mod upright;
