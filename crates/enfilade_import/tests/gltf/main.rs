//! What the glTF reader reads, what it warns of and what it refuses. Every file is made here, in code.

mod authoring;
mod broken;
mod cameras;
#[cfg(feature = "meshopt")]
mod compressed;
#[cfg(feature = "meshopt")]
mod compressed_damage;
mod containers;
mod file;
mod fixtures;
mod grid;
mod hostile;
mod hostile_images;
mod hostile_look;
mod instances;
mod lights;
mod link;
mod nodes;
mod pinned;
mod queries;
mod rooms;
mod scenes;
mod shapes;
mod sky;
mod stored;
mod surfaces;
mod terrain;
mod terrain_refused;
mod textures;
mod unsound;
mod villa;
mod villa_doors;
mod villa_pixels;
mod villa_walk;
mod warnings;
