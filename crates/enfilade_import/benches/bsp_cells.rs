//! Compares one BSP tree for an office with one per storey, one per cell of about six metres, and one per item.
//!
//! The claim: small trees split far fewer faces than one large tree, and only visible ones are traversed. Source:
//! Boreskov, Using portals to create aggregate scenes. Items are assigned by the centres of their AABBs, and none is
//! split; the storeys are those in the file of cells next to the scene. Trees are traversed front to back over the 16
//! survey views, without occlusion: counted are trees whose AABB is in the frustum, and the visited pieces. Built three
//! times in turn, and traversed likewise: medians. The faces before splitting must equal the table for every grouping,
//! and fewer must be split than in one tree.
//!
//! Trees whose boxes overlap have no order among them: parts that are to be drawn need portals or a depth each.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

mod common;

use common::{BenchScene, Lens, folder, in_turn, median_of, open};
use enfilade::geom::BspOptions;
use enfilade::order::{Bsp, NearToFar, Order, Visit};
use enfilade::{
    Alpha, FaceSource, Faces, Geometry, GeometryBuilder, ItemIndex, MeshId, Passage, Region, Viewer,
    Visibility,
};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

const FILE: &str = "ifc_office_a";
/// All its faces; those of glass are in no tree, and stay whole.
const FACES: u64 = 51_711;
const CELL_M: f32 = 6.0;
const BUILDS: usize = 3;
const WALKS: usize = 3;

/// A way to cut the scene, and the trees that it gives.
struct Cut {
    name: &'static str,
    parts: Vec<Geometry>,
    trees: Vec<Bsp<NearToFar>>,
    scratch: <Bsp<NearToFar> as Order>::Scratch,
}

/// Results of traversals: visited pieces of faces that occlude.
struct Pieces<'a> {
    geometry: &'a Geometry,
    count: u64,
}

impl Visit for Pieces<'_> {
    fn enter(&mut self, _region: &Region) -> Visibility {
        Visibility::Partial
    }

    fn first_time(&mut self, _item: ItemIndex) -> bool {
        true
    }

    fn faces(&mut self, faces: &Faces) {
        if let FaceSource::Item(item, cluster) = faces.source {
            let cluster = &self.geometry.mesh_of(item).clusters()[cluster as usize];
            self.count += u64::from(self.geometry.material(cluster).alpha == Alpha::Opaque);
        }
    }
}

fn main() {
    let Some(folder) = folder() else { return };
    let place = open(&folder, &format!("{FILE}.glb"));
    let geometry = place.geometry();
    let floors = floors(&folder.join(format!("{FILE}_cells.json")));
    let storey = |y: f32| floors.partition_point(|&floor| floor <= y).max(1) as i32;
    let along = |value: f32, axis: usize| ((value - geometry.bounds().min[axis]) / CELL_M) as i32;
    let mut cuts = [
        cut("one tree", geometry, |_, _| [0; 3]),
        cut("a storey each", geometry, |_, [_, y, _]| [storey(y), 0, 0]),
        cut("cells of 6 m", geometry, |_, [x, y, z]| {
            [storey(y), along(x, 0), along(z, 2)]
        }),
        cut("an item each", geometry, |item, _| [item.0 as i32, 0, 0]),
    ];
    let built = {
        let mut builders: Vec<Box<dyn FnMut(usize)>> = Vec::new();
        for Cut { parts, trees, .. } in &mut cuts {
            builders.push(Box::new(|_| {
                let tree = |part| Bsp::with_options(part, &BspOptions::default());
                *trees = parts.iter().map(tree).collect();
            }));
        }
        in_turn(1, BUILDS, &mut builders)
    };
    let passages = passages(&place);
    let lenses: Vec<Lens> = place.views.iter().map(Lens::of).collect();
    let walked = {
        let mut walkers: Vec<Box<dyn FnMut(usize)>> = Vec::new();
        for cut in &mut cuts {
            let (passages, lenses) = (&passages, &lenses);
            walkers.push(Box::new(|view| {
                cut.walk(&passages[view], &lenses[view]);
            }));
        }
        in_turn(place.views.len(), WALKS, &mut walkers)
    };
    println!(
        "{FILE}, {} items; trees walked and pieces handed out are means of the {} views\n\
         {:16}{:>7}{:>9}{:>9}{:>9}{:>8}{:>7}{:>10}{:>9}{:>14}{:>9}{:>9}",
        geometry.items().len(),
        place.views.len(),
        "",
        "trees",
        "faces",
        "split",
        "splits",
        "more",
        "depth",
        "build ms",
        "kB",
        "trees walked",
        "pieces",
        "walk ms"
    );
    let mut splits = Vec::new();
    for ((cut, built), walked) in cuts.iter_mut().zip(&built).zip(&walked) {
        let [before, after, cuts_made, depth, bytes] = cut.sums();
        assert_eq!(before, FACES, "{}: faces dealt out", cut.name);
        assert_eq!(after, before + cuts_made, "{}: a cut makes two of one", cut.name);
        let views = passages.len() as f64;
        let (mut trees, mut pieces) = (0, 0);
        for (passage, lens) in passages.iter().zip(&lenses) {
            let [more_trees, more_pieces] = cut.walk(passage, lens);
            trees += more_trees;
            pieces += more_pieces;
        }
        println!(
            "{:16}{:7}{before:9}{after:9}{cuts_made:9}{:7.1}%{depth:7}{:10.0}{:9.0}{:14.1}{:9.0}{:9.2}",
            cut.name,
            cut.trees.len(),
            100.0 * cuts_made as f64 / before as f64,
            built[0],
            bytes as f64 / 1e3,
            trees as f64 / views,
            pieces as f64 / views,
            median_of(walked.iter().copied()),
        );
        splits.push(cuts_made);
    }
    assert!(
        splits.is_sorted_by(|larger, smaller| larger > smaller),
        "smaller trees must cut fewer faces: {splits:?}"
    );
}

/// Heights at which storeys begin, but for the lowest, which has no floor to be below.
fn floors(cells: &Path) -> Vec<f32> {
    let text = std::fs::read_to_string(cells).unwrap_or_else(|error| panic!("{}: {error}", cells.display()));
    let cells: serde_json::Value = serde_json::from_str(&text).expect("a file of cells");
    let mut lowest: BTreeMap<&str, f32> = BTreeMap::new();
    for cell in cells["cells"].as_array().expect("cells") {
        let storey = cell["storey"].as_str().expect("a storey's name");
        let floor = cell["aabbMin"][1].as_f64().expect("a height") as f32;
        let known = lowest.entry(storey).or_insert(floor);
        *known = known.min(floor);
    }
    let mut floors: Vec<f32> = lowest.into_values().collect();
    floors.sort_by(f32::total_cmp);
    floors
}

/// Deals the items out: those with the same key go together.
fn cut(name: &'static str, geometry: &Geometry, key: impl Fn(ItemIndex, [f32; 3]) -> [i32; 3]) -> Cut {
    let mut dealt: BTreeMap<[i32; 3], Vec<ItemIndex>> = BTreeMap::new();
    for id in (0..geometry.items().len() as u32).map(ItemIndex) {
        let center = geometry.item(id).bounds.center();
        dealt.entry(key(id, center)).or_default().push(id);
    }
    let parts = dealt.values().map(|items| part(geometry, items)).collect();
    Cut {
        name,
        parts,
        trees: Vec::new(),
        scratch: Default::default(),
    }
}

/// Returns some items of a geometry as a separate geometry; meshes are shared.
fn part(geometry: &Geometry, items: &[ItemIndex]) -> Geometry {
    let mut builder = GeometryBuilder::new(geometry.materials().to_vec());
    let mut taken: BTreeMap<u32, MeshId> = BTreeMap::new();
    for &id in items {
        let item = geometry.item(id);
        let mesh = *taken
            .entry(item.mesh.0)
            .or_insert_with(|| builder.mesh(Arc::clone(&geometry.meshes()[item.mesh.0 as usize])));
        builder.item(geometry.name(id), mesh, item.transform());
    }
    builder.build().expect("part of a sound geometry")
}

/// The way into the one sector, at each view.
fn passages(place: &BenchScene) -> Vec<Passage> {
    let mut viewer = Viewer::new();
    let passage = |view| viewer.look(&place.scene, view).passages()[0].clone();
    place.views.iter().map(passage).collect()
}

impl Cut {
    /// Trees whose box is in the picture, and pieces that they hand out.
    fn walk(&mut self, passage: &Passage, lens: &Lens) -> [u64; 2] {
        let mut counts = [0; 2];
        for (geometry, tree) in self.parts.iter().zip(&self.trees) {
            if lens.may_show(&lens.screen_from_sector, &geometry.bounds()) {
                let mut pieces = Pieces { geometry, count: 0 };
                tree.visit(geometry, passage, &mut self.scratch, &mut pieces);
                counts[0] += 1;
                counts[1] += pieces.count;
            }
        }
        counts
    }

    /// Faces before and after, cuts, the depth of the deepest tree, and the bytes of all.
    fn sums(&self) -> [u64; 5] {
        let mut sums = [0; 5];
        for (geometry, tree) in self.parts.iter().zip(&self.trees) {
            let built = tree.build_stats(geometry);
            sums[0] += geometry.face_count();
            sums[1] += built.faces;
            sums[2] += built.splits;
            sums[3] = sums[3].max(u64::from(built.depth));
            sums[4] += tree.bytes();
        }
        sums
    }
}
