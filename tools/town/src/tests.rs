//! What readers of the tiles rely on, tested on the written bytes.

use crate::plan::TILE;
use crate::tile::{LIMITS, TOLERANCE, Tile, TileOptions, tile};
use serde_json::Value;
use std::collections::HashSet;

/// How far eaves, balconies and the joint below a border may reach out of a tile, in metres.
const MARGIN: f64 = 0.1;

/// Enough tiles to contain a park and all kinds of houses.
const TILES: [[u32; 2]; 5] = [[0, 0], [1, 0], [2, 3], [3, 4], [7, 7]];

fn generate(seed: u64, at: [u32; 2], triangles: u64) -> Tile {
    tile(TileOptions {
        seed,
        tile: at,
        triangles,
    })
    .expect("a tile within the limits")
}

/// The JSON and the buffer of a GLB.
struct Read<'a> {
    json: Value,
    buffer: &'a [u8],
}

impl Read<'_> {
    fn new(glb: &[u8]) -> Read<'_> {
        let number = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().expect("4 bytes")) as usize;
        assert_eq!((&glb[..4], number(8)), (&b"glTF"[..], glb.len()));
        let json = number(12);
        Read {
            json: serde_json::from_slice(&glb[20..20 + json]).expect("JSON"),
            buffer: &glb[28 + json..],
        }
    }

    fn list(&self, name: &str) -> &[Value] {
        self.json[name].as_array().expect("a list")
    }

    /// Returns the elements of an accessor as arrays of four-byte words.
    fn words<const N: usize>(&self, accessor: &Value, stride: usize) -> Vec<[[u8; 4]; N]> {
        let accessor = &self.list("accessors")[accessor.as_u64().expect("an index") as usize];
        let view = &self.list("bufferViews")[accessor["bufferView"].as_u64().expect("a view") as usize];
        let start = [&view["byteOffset"], &accessor["byteOffset"]].map(|at| at.as_u64().expect("an offset"));
        let start = start.iter().sum::<u64>() as usize;
        let end =
            view["byteOffset"].as_u64().expect("an offset") + view["byteLength"].as_u64().expect("a length");
        let count = accessor["count"].as_u64().expect("a count") as usize;
        assert!(
            start + count * stride <= end as usize,
            "an accessor is within its view"
        );
        let word = |at: usize| self.buffer[at..at + 4].try_into().expect("4 bytes");
        (0..count)
            .map(|i| std::array::from_fn(|j| word(start + i * stride + 4 * j)))
            .collect()
    }
}

#[test]
fn a_tile_alone_has_the_bytes_that_it_has_after_others() {
    let after_others: Vec<Tile> = TILES.map(|at| generate(5, at, 600_000)).into();
    let alone = generate(5, TILES[3], 600_000);
    assert!(alone.glb == after_others[3].glb);
    assert!(alone.glb != generate(6, TILES[3], 600_000).glb, "another seed");
    assert!(after_others[0].glb != after_others[1].glb, "another position");
}

#[test]
fn the_number_of_triangles_is_met() {
    let sizes = [LIMITS[0], 800_000, 2_000_000, LIMITS[1]];
    for (index, size) in sizes.into_iter().enumerate() {
        for seed in 0..3 {
            let made = generate(seed, TILES[index], size);
            let error = made.triangles as f64 / size as f64 - 1.0;
            assert!(error.abs() <= TOLERANCE, "{} instead of {size}", made.triangles);
        }
    }
}

#[test]
fn every_vertex_is_within_its_tile_and_every_index_in_range() {
    for at in TILES {
        let made = generate(1, at, 800_000);
        let read = Read::new(&made.glb);
        let mut triangles = 0;
        let mut used = HashSet::new();
        for node in read
            .list("nodes")
            .iter()
            .filter(|node| node.get("mesh").is_some())
        {
            let name = node["name"].as_str().expect("a name");
            let mesh = node["mesh"].as_u64().expect("an index");
            assert!(used.insert(mesh), "{name} shares a mesh");
            let origin: [f64; 3] =
                std::array::from_fn(|axis| node["translation"][axis].as_f64().expect("a number"));
            for primitive in read.list("meshes")[mesh as usize]["primitives"]
                .as_array()
                .expect("a list")
            {
                let positions = read.words::<3>(&primitive["attributes"]["POSITION"], 12);
                let normals = read.words::<1>(&primitive["attributes"]["NORMAL"], 4);
                assert_eq!(positions.len(), normals.len());
                let placed: Vec<[f64; 3]> = (positions.iter())
                    .map(|words| {
                        std::array::from_fn(|axis| origin[axis] + f64::from(f32::from_le_bytes(words[axis])))
                    })
                    .collect();
                for position in &placed {
                    for (axis, tile) in [(0, at[0]), (2, at[1])] {
                        let inside = position[axis] - f64::from(tile * TILE);
                        let range = -MARGIN..=f64::from(TILE) + MARGIN;
                        assert!(range.contains(&inside), "{name} reaches {position:?}");
                    }
                    assert!((-0.6..45.0).contains(&position[1]), "{name} reaches {position:?}");
                }
                let indices = read.words::<1>(&primitive["indices"], 4);
                let indices: Vec<usize> = (indices.iter())
                    .map(|word| u32::from_le_bytes(word[0]) as usize)
                    .collect();
                assert!(indices.iter().all(|&index| index < placed.len()), "{name}");
                triangles += indices.len() / 3;
            }
        }
        assert_eq!((triangles as u64, used.len() + 1), (made.triangles, made.nodes));
    }
}

#[test]
fn names_are_unique_in_the_whole_town() {
    let mut names = HashSet::new();
    for at in TILES {
        let made = generate(1, at, 800_000);
        let read = Read::new(&made.glb);
        assert!((600..1500).contains(&read.list("nodes").len()));
        for node in read.list("nodes") {
            let name = node["name"].as_str().expect("a name");
            assert!(names.insert(name.to_owned()), "{name} is used twice");
        }
    }
    assert!(names.contains("03-04 street"));
}

#[test]
fn triangles_have_an_area_and_normals_are_on_their_side() {
    let made = generate(1, [2, 3], 800_000);
    let read = Read::new(&made.glb);
    let [mut flat, mut turned, mut all] = [0, 0, 0];
    for node in read
        .list("nodes")
        .iter()
        .filter(|node| node.get("mesh").is_some())
    {
        let mesh = &read.list("meshes")[node["mesh"].as_u64().expect("an index") as usize];
        for primitive in mesh["primitives"].as_array().expect("a list") {
            let positions = read.words::<3>(&primitive["attributes"]["POSITION"], 12);
            let normals = read.words::<1>(&primitive["attributes"]["NORMAL"], 4);
            let indices = read.words::<1>(&primitive["indices"], 4);
            for corners in indices.chunks_exact(3) {
                let corners = [0, 1, 2].map(|i| u32::from_le_bytes(corners[i][0]) as usize);
                let [a, b, c] =
                    corners.map(|index| positions[index].map(|word| f64::from(f32::from_le_bytes(word))));
                let [p, q] = [b, c].map(|end| [0, 1, 2].map(|axis| end[axis] - a[axis]));
                let cross =
                    [0, 1, 2].map(|i| p[(i + 1) % 3] * q[(i + 2) % 3] - p[(i + 2) % 3] * q[(i + 1) % 3]);
                let sum = corners
                    .iter()
                    .flat_map(|&index| (0..3).map(move |axis| (index, axis)));
                let side: f64 = sum
                    .map(|(index, axis)| cross[axis] * f64::from(normals[index][0][axis] as i8))
                    .sum();
                all += 1;
                flat += usize::from(cross.iter().all(|part| part.abs() < 1e-9));
                turned += usize::from(side < -1e-9);
            }
        }
    }
    assert!(flat * 1000 < all, "{flat} of {all} triangles have no area");
    assert!(
        turned * 1000 < all,
        "{turned} of {all} triangles face away from their normals"
    );
}
