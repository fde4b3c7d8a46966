//! Draws the visible sets of [Enfilade](enfilade) with wgpu: sectors behind portals, mirrors and teleports in one render
//! pass, instanced, textured and lit as by [`enfilade_draw`].
#![forbid(unsafe_code)]

#[cfg(feature = "headless")]
mod headless;
mod lens;
mod materials;
mod meshes;
mod openings;
mod pipelines;
mod plan;
mod renderer;

#[cfg(feature = "headless")]
pub use headless::{Headless, HeadlessDevice, HeadlessError, read};
pub use plan::PlacedItem;
pub use renderer::{DrawStats, Renderer, RendererOptions, device_options};
