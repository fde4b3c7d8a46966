//! Compares pictures with ray casts: each sample is cast separately, and its surface is textured and lit in f64 as the
//! documentation specifies.

mod glass;
mod lamplight;
mod samples;
mod shading;
mod stage;
mod textures;
