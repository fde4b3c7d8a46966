//! The interactive viewer of Enfilade: walk through a scene, freeze its visible set, and see why things are hidden.
#![forbid(unsafe_code)]

pub mod app;
#[cfg(not(target_arch = "wasm32"))]
pub mod args;
mod counts;
pub mod explain;
mod floor_plan;
mod history;
pub mod loading;
mod occluders;
#[cfg(not(target_arch = "wasm32"))]
pub mod offscreen;
pub mod overlay;
pub mod path;
pub mod picture;
pub mod places;
#[cfg(not(target_arch = "wasm32"))]
pub mod serve;
pub mod session;
pub mod steps;
pub mod walker;
#[cfg(target_arch = "wasm32")]
pub mod web;
pub mod window;
pub mod world;
