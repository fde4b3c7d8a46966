//! Generates one tile: its items, as many triangles as wanted, its file.

use crate::glb::Document;
use crate::house::house;
use crate::mesh::Mesh;
use crate::plan::{Plan, TILE};
use crate::random::Random;
use crate::street::street;
use anyhow::{Result, ensure};

/// How far the number of triangles may be from the wanted one.
pub(crate) const TOLERANCE: f64 = 0.05;

/// Numbers of triangles that tiles can have.
pub(crate) const LIMITS: [u64; 2] = [450_000, 6_000_000];

/// Levels between which tiles are searched for the wanted number of triangles.
const LEVELS: [f64; 2] = [0.02, 30.0];

/// What a tile depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileOptions {
    pub(crate) seed: u64,
    pub(crate) tile: [u32; 2],
    pub(crate) triangles: u64,
}

/// A generated tile.
pub(crate) struct Tile {
    pub(crate) glb: Vec<u8>,
    pub(crate) nodes: usize,
    pub(crate) triangles: u64,
}

/// Receives the items of a tile, each a node with a mesh of its own.
pub(crate) struct Items {
    wanted: TileOptions,
    level: f64,
    /// `None` if triangles are only counted.
    document: Option<Document>,
    nodes: usize,
    triangles: u64,
}

impl Items {
    fn new(wanted: TileOptions, level: f64, document: Option<Document>) -> Items {
        Items {
            wanted,
            level,
            document,
            nodes: 0,
            triangles: 0,
        }
    }

    /// Returns the density of triangles that describe small details; 1 is that of a tile of about two million.
    pub(crate) fn level(&self) -> f64 {
        self.level
    }

    /// Returns the name of an item in the whole town.
    fn name(&self, name: &str) -> String {
        let [x, y] = self.wanted.tile;
        format!("{x:02}-{y:02} {name}")
    }

    /// Returns random numbers that depend on the seed, the tile and a name alone.
    pub(crate) fn random(&self, name: &str) -> Random {
        Random::new(self.wanted.seed, &self.name(name))
    }

    /// Adds an item; `build` gets an empty mesh.
    pub(crate) fn add(&mut self, name: &str, build: impl FnOnce(&mut Mesh)) {
        let mut mesh = Mesh::new(self.random(name), self.level, self.document.is_none());
        build(&mut mesh);
        if mesh.triangles() == 0 {
            return;
        }
        self.nodes += 1;
        self.triangles += mesh.triangles() as u64;
        let name = self.name(name);
        if let Some(document) = &mut self.document {
            document.item(&name, mesh, self.wanted.tile.map(|at| at * TILE));
        }
    }

    fn fill(&mut self, plan: &Plan) {
        street(self, plan);
        let lots = plan.blocks.iter().flat_map(|block| &block.lots);
        for (number, lot) in lots.enumerate() {
            house(self, lot, number);
        }
    }
}

/// Generates a tile.
pub(crate) fn tile(wanted: TileOptions) -> Result<Tile> {
    let plan = Plan::new(wanted.seed, wanted.tile);
    let level = level(wanted, &plan)?;
    let mut items = Items::new(wanted, level, Some(Document::default()));
    items.fill(&plan);
    let name = items.name("street");
    let mut document = items.document.unwrap_or_default();
    // In the middle street, just beyond the crossing at the border.
    let [x, z] = wanted.tile.map(|at| f64::from(at * TILE));
    document.camera(&name, [x + f64::from(TILE) / 2.0, 1.6, z + 7.0]);
    Ok(Tile {
        glb: document.into_glb(),
        nodes: items.nodes + 1,
        triangles: items.triangles,
    })
}

/// Searches the level at which a tile has the wanted number of triangles.
fn level(wanted: TileOptions, plan: &Plan) -> Result<f64> {
    let count = |level: f64| {
        let mut items = Items::new(wanted, level, None);
        items.fill(plan);
        items.triangles
    };
    let error = |triangles: u64| (triangles as f64 / wanted.triangles as f64 - 1.0).abs();
    let mut low = (LEVELS[0], count(LEVELS[0]));
    let mut high = low;
    while high.1 < wanted.triangles && high.0 < LEVELS[1] {
        low = high;
        high = (2.0 * low.0, count(2.0 * low.0));
    }
    let mut best = if error(low.1) < error(high.1) { low } else { high };
    // Between two levels, triangles are about proportional to the level.
    for _ in 0..16 {
        if error(best.1) < 0.1 * TOLERANCE || low.0 == high.0 {
            break;
        }
        let share = (wanted.triangles as f64 - low.1 as f64) / (high.1 as f64 - low.1 as f64);
        let level = low.0 + (high.0 - low.0) * share.clamp(0.05, 0.95);
        let between = (level, count(level));
        if error(between.1) < error(best.1) {
            best = between;
        }
        if between.1 < wanted.triangles {
            low = between;
        } else {
            high = between;
        }
    }
    let [x, y] = wanted.tile;
    ensure!(
        error(best.1) <= TOLERANCE,
        "tile {x},{y} can have {} triangles, but not {} with seed {}: change --triangles-per-tile",
        best.1,
        wanted.triangles,
        wanted.seed
    );
    Ok(best.0)
}
