//! What an app without a window sees, compared with rays.

mod culling;
mod edges;
#[cfg(feature = "gltf")]
mod gltf;
mod lights;
mod pvs;
mod rooms;
mod world;
