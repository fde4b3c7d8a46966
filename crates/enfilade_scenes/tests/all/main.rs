//! Tests of the built-in scenes.

mod palace;
mod palace_light;
mod reach;
mod scenes;
mod thesis;
mod walk;
