//! What an app without a window sees, compared with rays.

mod culling;
mod edges;
mod rooms;
mod world;
