//! Draws the visible sets of [Enfilade](enfilade) with wgpu: sectors behind portals, mirrors and teleports in one render
//! pass, instanced, textured and lit as by [`enfilade_draw`].
//!
//! ```
//! use enfilade_wgpu::{Frame, Renderer};
//!
//! fn frame(renderer: &mut Renderer, encoder: &mut wgpu::CommandEncoder, target: &wgpu::TextureView, frame: &Frame) {
//!     // `frame` is Frame::new(&scene, &stage, &view, viewer.look(&scene, &view)).
//!     renderer.draw(encoder, target, frame);
//! }
//! ```
//!
//! The stencil buffer counts the openings between the eye and a pixel. A passage is drawn where that number is its depth in
//! the tree of passages, so it covers exactly the pixels of its openings; `plan.rs` has the steps. The picture equals that of
//! [`enfilade_draw`], but for pixels at edges, faces in one plane, and glass that intersects other glass.
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
pub use plan::{Frame, PlacedItem};
pub use renderer::{DrawStats, Renderer, RendererOptions, device_options};
