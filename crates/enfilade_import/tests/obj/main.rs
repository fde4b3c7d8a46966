//! What the OBJ reader reads, what it warns of and what it refuses. Every file is made here, in code.

mod broken;
mod corners;
mod file;
mod formats;
mod groups;
mod hostile;
mod images;
mod materials;
mod peer;
mod polygons;
mod simple;
