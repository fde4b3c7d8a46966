//! Measures one BSP tree over a whole scene: faces after splitting, splits, depth, time and memory.
//!
//! Scenes: an office, a hall, a classroom. More cuts than the table allows are an error, as is more memory of the tree
//! than 150 bytes for each face of the scene. Each tree is built on one core, once to warm up, then three times: the
//! median.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

mod common;

use common::{folder, in_turn, open};
use enfilade::geom::BspOptions;
use enfilade::order::{Bsp, NearToFar, Order};

const BUILDS: usize = 3;

/// Files, their faces, and how many times as many there may be at the most.
const SCENES: [(&str, u64, f64); 3] = [
    ("ifc_office_a.glb", 51_711, 1.5),
    ("sponza_crytek.glb", 262_267, 2.4),
    ("classroom.glb", 103_832, 1.9),
];

/// Bytes of a tree for each face of the scene, at the most.
const BYTES_A_FACE: f64 = 150.0;

fn main() {
    let Some(folder) = folder() else { return };
    println!(
        "{:20}{:>9}{:>9}{:>9}{:>8}{:>7}{:>10}{:>13}",
        "scene", "faces", "after", "cuts", "growth", "depth", "build ms", "bytes a face"
    );
    for (file, faces, limit) in SCENES {
        let place = open(&folder, file);
        let geometry = place.geometry();
        assert_eq!(geometry.face_count(), faces, "{file}: faces");
        let mut tree = None;
        let ms = {
            let mut build: [Box<dyn FnMut(usize)>; 1] = [Box::new(|_| {
                tree = Some(Bsp::<NearToFar>::with_options(geometry, &BspOptions::default()));
            })];
            in_turn(1, BUILDS, &mut build)[0][0]
        };
        let tree = tree.expect("it was built");
        let built = tree.build_stats(geometry);
        let growth = built.faces as f64 / faces as f64;
        let bytes = tree.bytes() as f64 / faces as f64;
        println!(
            "{file:20}{faces:9}{:9}{:9}{growth:8.2}{:7}{ms:10.0}{bytes:13.1}",
            built.faces, built.splits, built.depth
        );
        assert!(growth <= limit, "{file}: {growth:.2} times the faces");
        assert!(bytes <= BYTES_A_FACE, "{file}: {bytes:.0} bytes a face");
    }
}
