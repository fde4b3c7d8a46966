//! What the glTF reader reads, what it warns of and what it refuses. Every file is made here, in code.

mod authoring;
mod broken;
mod containers;
mod file;
mod hostile;
mod link;
mod nodes;
mod queries;
mod rooms;
mod scenes;
mod shapes;
mod unsound;
mod villa;
mod villa_doors;
mod villa_pixels;
mod villa_walk;
mod warnings;
