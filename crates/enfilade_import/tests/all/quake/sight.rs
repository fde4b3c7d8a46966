//! Real maps drawn through what is visible from each leaf, against the same drawn without: sample by sample.

use super::maps::{maps, pairs_of, read as read_prt};
use super::rooms::imported;
use enfilade::{
    Camera, Canvas, CellSide, Geometry, ItemIndex, Method, Owner, Passage, PassageId, Scene, SectorId, Span,
    View, Viewer, survey,
};
use enfilade_import::{Import, ReadOptions, read, with_visibility};
use glam::DVec3;
use std::path::Path;

const SIZE: [u32; 2] = [320, 200];
/// Distance by which compilers move vertices: a line that passes through less solid than this may not have hit it.
const SNAPPED: f64 = 0.1;
/// Places in open space to look from, besides those where players start.
const PLACES: usize = 24;
/// The same where time does not matter.
const MANY_PLACES: usize = 300;

/// The owner of each sample, and the way into the map.
struct Samples(Vec<Option<(ItemIndex, u32)>>, Option<Passage>);

impl Canvas for Samples {
    fn enter(&mut self, _id: PassageId, passage: &Passage) {
        self.1 = Some(passage.clone());
    }

    fn row(&mut self, y: u16, spans: &[Span]) {
        for span in spans {
            if let Owner::Face(item, face) = span.owner {
                let row = usize::from(y) * SIZE[0] as usize;
                self.0[row + usize::from(span.x0)..row + usize::from(span.x1)].fill(Some((item, face)));
            }
        }
    }
}

fn drawn(viewer: &mut Viewer, scene: &Scene, view: &View) -> Samples {
    let mut samples = Samples(vec![None; (SIZE[0] * SIZE[1]) as usize], None);
    viewer.draw(scene, view, &mut samples);
    samples
}

impl Samples {
    /// Length of solid space along the line of sight of a sample, up to the face that owns it. Undrawn walls, and
    /// cracks between others, do not stop a line, but the PVS compiler treats them as walls.
    fn in_solid(&self, at: usize, geometry: &Geometry) -> f64 {
        let (Some(passage), Some((item, face))) = (&self.1, self.0[at]) else {
            return 0.0;
        };
        let place = [at % SIZE[0] as usize, at / SIZE[0] as usize].map(|place| place as f64 + 0.5);
        let [eye, way] = passage.ray(place).map(DVec3::from);
        let mesh = geometry.mesh_of(item);
        let transform = geometry.item(item).transform();
        let corner = |side: usize| {
            let corner = transform.point(mesh.positions()[mesh.face(face)[side] as usize]);
            DVec3::from(corner.map(f64::from))
        };
        let normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
        let far = normal.dot(corner(0) - eye) / normal.dot(way);
        let tree = geometry.cells().expect("a map that is baked").tree();
        let mut length = 0.0;
        let mut waiting = vec![(tree.root, 0.0, far)];
        while let Some((side, from, to)) = waiting.pop() {
            match side {
                CellSide::Solid => length += (to - from) * way.length(),
                CellSide::Cell(_) => {}
                CellSide::Node(node) => {
                    let node = &tree.nodes[node as usize];
                    let normal = DVec3::from(node.normal);
                    let [near, end] = [from, to].map(|t| normal.dot(eye + t * way) - node.distance);
                    let sides = |is_front: bool| if is_front { node.front } else { node.back };
                    if (near >= 0.0) == (end >= 0.0) {
                        waiting.push((sides(near >= 0.0), from, to));
                    } else {
                        let middle = from + (to - from) * near / (near - end);
                        waiting.push((sides(near >= 0.0), from, middle));
                        waiting.push((sides(end >= 0.0), middle, to));
                    }
                }
            }
        }
        length
    }
}

fn scene(import: &Import, method: Method) -> Scene {
    import
        .scene(method, Method::DEFAULT_LIMIT)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// From where players start, and from all over the map.
fn views(import: &Import, scene: &Scene, places: usize) -> Vec<View> {
    let cameras = import.cameras.iter().map(|camera| {
        let camera = Camera {
            fov_y: camera.fov_y,
            z_near: camera.z_near,
            ..Camera::new(camera.eye, camera.toward)
        };
        camera.view(SIZE).expect("a valid view")
    });
    let found = survey(scene, places).views;
    assert!(found.len() > places / 2, "the map has open space");
    let places = found
        .iter()
        .map(|place| View::new(place.eye, place.toward, SIZE).expect("a valid view"));
    cameras.chain(places).collect()
}

/// Counts for a map, with its baked cells and without.
#[derive(Debug)]
struct Compared {
    views: usize,
    /// Samples of all views.
    samples: usize,
    /// Samples with other owners, whose lines of sight go through nothing solid.
    different: usize,
    /// The same of lines that do: where walls are not drawn, or have cracks between them.
    through_walls: usize,
    /// Items in all sets together, and as many as there are for each view.
    items: [usize; 2],
}

fn compare(import: &Import, name: &str, places: usize) -> Compared {
    let [all, baked] = [Method::ZBuffer, Method::Pvs].map(|method| scene(import, method));
    let geometry = baked.geometry(SectorId(0)).expect("one room");
    let (mut with, mut without) = (Viewer::new(), Viewer::new());
    let mut compared = Compared {
        views: 0,
        samples: 0,
        different: 0,
        through_walls: 0,
        items: [0, 0],
    };
    for view in views(import, &all, places) {
        let [few, many] = [drawn(&mut with, &baked, &view), drawn(&mut without, &all, &view)];
        for at in (0..many.0.len()).filter(|&at| few.0[at] != many.0[at]) {
            if many.in_solid(at, geometry) > SNAPPED {
                compared.through_walls += 1;
                continue;
            }
            compared.different += 1;
            if let (1..=9, Some((item, _))) = (compared.different, many.0[at]) {
                let place = [at % SIZE[0] as usize, at / SIZE[0] as usize];
                let name_of = geometry.name(item);
                report(&format!(
                    "{name}: from {:?} to {:?} at {place:?}: {name_of} is left out",
                    view.eye(),
                    view.toward()
                ));
            }
        }
        compared.views += 1;
        compared.samples += many.0.iter().filter(|owner| owner.is_some()).count();
        compared.items[0] += with.look(&baked, &view).items().len();
        compared.items[1] += all.item_count();
    }
    report(&format!("{name}: {} items, {compared:?}", all.item_count()));
    compared
}

#[allow(
    clippy::print_stderr,
    reason = "the figures of a map are what one wants to know of a failure"
)]
fn report(line: &str) {
    eprintln!("{line}");
}

/// A map with its pairs in it, read from a file as any other.
fn baked(folder: &Path, map: &[u8], prt: &str) -> Import {
    let portals = read_prt(folder, prt);
    let map = with_visibility(map, &portals, &pairs_of(&portals)).unwrap_or_else(|error| panic!("{error}"));
    let place = tempfile::tempdir().expect("a folder");
    let path = place.path().join("baked.bsp");
    std::fs::write(&path, map).expect("it is ours");
    read(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// That the picture is the same, and that the cells leave out most of the map.
fn is_the_same_with_fewer_items(import: &Import, name: &str, places: usize, most: f64) {
    let compared = compare(import, name, places);
    assert!(
        compared.samples * 10 > compared.views * 64_000 * 9,
        "views are full of walls: {compared:?}"
    );
    assert_eq!(compared.different, 0, "{name}: {compared:?}");
    assert!(
        compared.through_walls * 100 < compared.samples,
        "{name}: {compared:?}"
    );
    let [few, all] = compared.items.map(|items| items as f64);
    assert!(few < most * all, "{name}: {compared:?}");
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn a_map_looks_the_same_through_its_cells() {
    let folder = maps();
    for (name, prt, most) in [
        ("quake/dm1.bsp", "quake/dm1.prt", 0.2),
        ("quake/e1m1.bsp", "quake/e1m1.prt", 0.12),
        ("quake3/darkzone.novis.bsp", "quake3/darkzone.prt", 0.18),
    ] {
        let map = std::fs::read(folder.join(name)).expect("a map");
        is_the_same_with_fewer_items(&baked(&folder, &map, prt), name, PLACES, most);
    }
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn a_map_looks_the_same_through_the_cells_of_its_author() {
    let folder = maps();
    let name = "quake3/darkzone.shipped.bsp";
    let import = read(&folder.join(name), &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    is_the_same_with_fewer_items(&import, name, PLACES, 0.18);
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn a_map_whose_rows_say_too_little_looks_otherwise() {
    let folder = maps();
    let mut map = std::fs::read(folder.join("quake3/darkzone.shipped.bsp")).expect("a map");
    let [start, length] = [0, 4].map(|at| {
        let at = 8 + 8 * 16 + at;
        u32::from_le_bytes(map[at..at + 4].try_into().expect("four")) as usize
    });
    map[start + 8..start + length].fill(0);
    let compared = compare(&imported(&map), "without rows", 4);
    assert!(compared.different > compared.samples / 10, "{compared:?}");
}

#[test]
#[ignore = "takes minutes: the pairs of larger maps, and hundreds of places in each"]
fn every_map_looks_the_same_through_its_cells() {
    let folder = maps();
    for (map, prt) in [
        ("quake/dm1.bsp", "quake/dm1.prt"),
        ("quake/end.bsp", "quake/end.prt"),
        ("quake/lq_e0m1.bsp", "quake/lq_e0m1.prt"),
        ("quake/e1m1.bsp", "quake/e1m1.prt"),
        ("quake/start.bsp", "quake/start.prt"),
        ("quake/lq_e1m5.bsp", "quake/lq_e1m5.prt"),
        ("quake3/darkzone.novis.bsp", "quake3/darkzone.prt"),
        ("quake3/stormkeep.novis.bsp", "quake3/stormkeep.prt"),
        ("quake3/aneurysm.novis.bsp", "quake3/aneurysm.prt"),
    ] {
        let bytes = std::fs::read(folder.join(map)).expect("a map");
        is_the_same_with_fewer_items(&baked(&folder, &bytes, prt), map, MANY_PLACES, 0.4);
    }
}

#[test]
#[ignore = "needs ENFILADE_MAPS"]
fn a_map_of_16_bits_is_the_same_as_one_of_32() {
    let folder = maps();
    let wide = std::fs::read(folder.join("quake/dm1.bsp")).expect("a map");
    let narrow = narrowed(&wide);
    let [wide, plain] = [&wide, &narrow].map(|map| imported(map));
    assert_eq!(plain.cameras, wide.cameras);
    assert_eq!(plain.lights, wide.lights);
    let [wide, plain] = [wide, plain].map(|import| std::sync::Arc::clone(&import.rooms[0].geometry));
    assert_eq!(wide.items().len(), plain.items().len());
    for item in (0..wide.items().len() as u32).map(ItemIndex) {
        assert_eq!(wide.name(item), plain.name(item));
        assert_eq!(wide.mesh_of(item).positions(), plain.mesh_of(item).positions());
    }
    is_the_same_with_fewer_items(
        &baked(&folder, &narrow, "quake/dm1.prt"),
        "dm1 of 16 bits",
        PLACES,
        0.2,
    );
}

/// A BSP2 file as BSP29: what has 32 bits there and 16 here, lump by lump.
fn narrowed(map: &[u8]) -> Vec<u8> {
    /// How a number becomes another.
    #[derive(Clone, Copy)]
    enum As {
        Same,
        Short,
        /// From f32 to a whole number.
        Whole,
    }
    use As::{Same, Short, Whole};
    let node = [&[Same, Short, Short][..], &[Whole; 6], &[Short; 2]].concat();
    let leaf = [&[Same, Same][..], &[Whole; 6], &[Short, Short, Same]].concat();
    let face = vec![Short, Short, Same, Short, Short, Same, Same];
    let kinds = [
        (5, node),
        (7, face),
        (9, vec![Same, Short, Short]),
        (10, leaf),
        (11, vec![Short]),
        (12, vec![Short]),
    ];
    let word = |at: usize| i32::from_le_bytes(map[at..at + 4].try_into().expect("four"));
    let mut narrow = 29u32.to_le_bytes().to_vec();
    narrow.resize(4 + 15 * 8, 0);
    for lump in 0..15 {
        let [start, length] = [0, 4].map(|at| word(4 + 8 * lump + at) as usize);
        let bytes = &map[start..start + length];
        let begins = narrow.len();
        match kinds.iter().find(|kind| kind.0 == lump) {
            None => narrow.extend_from_slice(bytes),
            Some((_, numbers)) => {
                for (four, kind) in bytes.chunks_exact(4).zip(numbers.iter().cycle()) {
                    let number = i32::from_le_bytes(four.try_into().expect("four"));
                    match kind {
                        Same => narrow.extend_from_slice(four),
                        Short => narrow.extend((number as u16).to_le_bytes()),
                        Whole => narrow.extend((f32::from_bits(number as u32) as i16).to_le_bytes()),
                    }
                }
            }
        }
        let entry = [begins as u32, (narrow.len() - begins) as u32]
            .map(u32::to_le_bytes)
            .concat();
        narrow[4 + 8 * lump..][..8].copy_from_slice(&entry);
        narrow.resize(narrow.len().next_multiple_of(4), 0);
    }
    narrow
}
