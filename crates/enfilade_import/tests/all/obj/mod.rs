//! Tests the OBJ reader: results, warnings and errors. Every file is generated in code.

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
