//! Generates a town of any size, and writes it as tiles of 64 × 64 m, each a binary glTF file.
//!
//! `town OUT_FOLDER --tiles 8x8 --triangles-per-tile 800000` writes `tile-00-00.glb` and so on. Every mesh has its own
//! vertices, so a town is as large in memory as it looks. A tile depends on the seed, its position and the number of
//! triangles alone; `--only 3,4` writes one with the same bytes. Read together, the tiles join without gaps.

mod arguments;
mod glb;
mod house;
mod material;
mod mesh;
mod plan;
mod random;
mod street;
#[cfg(test)]
mod tests;
mod tile;
mod vector;

use anyhow::{Context, Result};
use arguments::{Arguments, USE};
use std::fs;
use tile::{TileOptions, tile};

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments
        .iter()
        .any(|argument| argument == "--help" || argument == "-h")
    {
        println!("{USE}");
        return Ok(());
    }
    let arguments = Arguments::parse(&arguments)?;
    let folder = &arguments.folder;
    fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let mut total = [0, 0, 0, 0];
    for [x, y] in arguments.positions() {
        let tile = tile(TileOptions {
            seed: arguments.seed,
            tile: [x, y],
            triangles: arguments.triangles,
        })?;
        let path = folder.join(format!("tile-{x:02}-{y:02}.glb"));
        fs::write(&path, &tile.glb).with_context(|| format!("cannot write {}", path.display()))?;
        let counts = [1, tile.nodes as u64, tile.triangles, tile.glb.len() as u64];
        let [_, nodes, triangles, bytes] = counts;
        println!(
            "{}: {nodes} nodes, {triangles} triangles, {bytes} bytes",
            path.display()
        );
        total = [0, 1, 2, 3].map(|i| total[i] + counts[i]);
    }
    let [tiles, nodes, triangles, bytes] = total;
    println!("total: {tiles} tiles, {nodes} nodes, {triangles} triangles, {bytes} bytes");
    Ok(())
}
