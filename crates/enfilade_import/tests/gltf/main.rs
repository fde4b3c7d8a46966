//! What the glTF reader reads, what it warns of and what it refuses. Every file is made here, in code.

mod broken;
mod containers;
mod file;
mod hostile;
mod nodes;
mod scenes;
mod shapes;
mod unsound;
mod warnings;
