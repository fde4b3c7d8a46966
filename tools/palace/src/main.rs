//! Generates the palace, the built-in scene, and writes it as glTF.
//!
//! `palace FILE` writes; `palace FILE --plain` writes for readers without the extensions that compress it;
//! `palace FILE --check 100` compares a file with the generated scene: first what it contains,
//! then what is visible from the cameras and from 100 views of the survey.

mod check;
mod document;
mod envelope;
mod export;
mod meshes;
mod palace;
mod shape;
mod textures;
mod water;

use anyhow::{Context, Result, bail};
use enfilade_scenes::BuiltIn;
use export::Encoding;
use std::time::Instant;

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let start = Instant::now();
    let palace = palace::palace(palace::SEED);
    println!("generated in {:.2?}", start.elapsed());
    match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [file] => write(&palace, file, Encoding::Compressed),
        [file, "--plain"] => write(&palace, file, Encoding::Plain),
        [file, "--check", views] => check::check(&palace, file, views.parse()?),
        _ => bail!("use: palace FILE [--plain | --check VIEWS]"),
    }
}

fn write(palace: &BuiltIn, file: &str, encoding: Encoding) -> Result<()> {
    let bytes = export::glb(palace, encoding)?;
    std::fs::write(file, &bytes).with_context(|| file.to_owned())?;
    println!("{file}: {} bytes", bytes.len());
    Ok(())
}
