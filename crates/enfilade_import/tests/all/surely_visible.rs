//! On real files: what is visible without all that is in doubt is in the set of the whole scene.
//!
//! The reference of a scene believes its reader. Here it sees only what surely is opaque, drawn and in place, so that nothing in
//! doubt can hide anything from it.

use enfilade::laws::Reference;
use enfilade::{
    GeometryBuilder, Indices, ItemIndex, ItemOptions, MaterialId, Mesh, Method, Part, Scene, Vertices, View,
    Viewer, survey,
};
use enfilade_import::{Import, ReadOptions, Room, read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Views of each scene, and the size of their screens.
const VIEWS: usize = 64;
const SIZE: [u32; 2] = [160, 90];

/// Returns a room with the same items, of which only faces that hide what is behind them are left.
fn sure(room: &Room) -> Room {
    let geometry = &room.geometry;
    let mut builder = GeometryBuilder::new(geometry.materials().to_vec());
    for opening in geometry.openings() {
        builder.opening(&opening.name, opening.outline.clone());
    }
    for item in (0..geometry.items().len() as u32).map(ItemIndex) {
        let mesh = geometry.mesh_of(item);
        let whole = room.non_occluders.of_whole_item(geometry, item).is_some();
        let is_sure = |material| !whole && room.non_occluders.of_material(geometry, material).is_none();
        let sure = sure_mesh(mesh, is_sure);
        let is_drawn = sure.is_some();
        let mesh = builder.mesh(sure.unwrap_or_else(|| mesh.clone()));
        let placed = builder.item(geometry.name(item), mesh, geometry.item(item).transform());
        let options = ItemOptions {
            is_drawn,
            is_occluder: is_drawn,
            ..ItemOptions::default()
        };
        builder.set_options(placed, options);
    }
    Room {
        geometry: Arc::new(builder.build().expect("a room")),
        ..room.clone()
    }
}

/// Returns the faces of some materials; `None` if there are none.
fn sure_mesh(mesh: &Mesh, is_sure: impl Fn(MaterialId) -> bool) -> Option<Mesh> {
    let clusters = mesh.clusters().iter().filter(|cluster| is_sure(cluster.material));
    let faces: Vec<_> = clusters
        .map(|cluster| {
            let faces = cluster.faces.clone().map(|face| mesh.face(face));
            let sides: Vec<u32> = faces.clone().map(|face| face.len() as u32).collect();
            let corners: Vec<u32> = faces.flatten().copied().collect();
            (cluster.material, sides, corners)
        })
        .collect();
    let parts: Vec<Part> = faces
        .iter()
        .map(|(material, sides, corners)| Part {
            positions: Vertices::Packed(mesh.positions()),
            corners: Indices::U32(corners),
            sides: Some(sides),
            material: *material,
            attributes: Default::default(),
        })
        .collect();
    (!parts.is_empty()).then(|| Mesh::new(&parts).expect("a mesh"))
}

/// Returns what a method misses of what is surely visible, and how many items those are.
fn missed(import: &Import, views: &[View]) -> (usize, Vec<String>) {
    let sure = Import {
        portals: import.portals.clone(),
        ..Import::of_rooms(import.rooms.iter().map(sure).collect())
    };
    let scene = |import: &Import, method| import.scene(method, 1 << 32).expect("a scene");
    let sure: Scene = scene(&sure, Method::ZBuffer);
    let reference = Reference::new(&sure);
    let (mut seen, mut missed) = (0, Vec::new());
    for method in [Method::ZBuffer, Method::Masked] {
        let scene = scene(import, method);
        let mut viewer = Viewer::new();
        for view in views {
            let truth = reference.see(&sure, view, &viewer.options.limits);
            let verdict = truth.check(viewer.look(&scene, view), None);
            seen += verdict.reference_visible;
            missed.extend(verdict.missed.iter().map(|&(sector, item)| {
                let geometry = scene.geometry(sector).expect("a geometry");
                format!("{method}: {} from {:?}", geometry.name(item), view.eye())
            }));
        }
    }
    (seen, missed)
}

/// Returns the files below a folder with one of some extensions.
fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in folder.read_dir().expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            files.extend(self::files(&path, endings));
        } else if path
            .extension()
            .is_some_and(|ending| endings.iter().any(|wanted| ending == *wanted))
        {
            files.push(path);
        }
    }
    files.sort();
    files
}

#[test]
#[allow(clippy::print_stdout, reason = "a table")]
#[ignore = "minutes; needs ENFILADE_SCENES and ENFILADE_MAPS, folders of scenes and of maps"]
fn nothing_in_doubt_hides_anything_in_any_scene_or_map() {
    let mut all = Vec::new();
    for (variable, endings) in [
        ("ENFILADE_SCENES", ["glb", "gltf"]),
        ("ENFILADE_MAPS", ["bsp", "bsp2"]),
    ] {
        let folder = std::env::var_os(variable).unwrap_or_else(|| panic!("{variable} is not set"));
        all.extend(files(Path::new(&folder), &endings));
    }
    let mut failed = Vec::new();
    for file in all {
        let options = ReadOptions {
            textures: false,
            limit_bytes: 8 << 30,
            ..ReadOptions::default()
        };
        let import = read(&file, &options).expect("a scene");
        let scene = import.scene(Method::ZBuffer, 1 << 32).expect("a scene");
        let places = survey(&scene, VIEWS).views;
        let view = |place: &enfilade::SurveyView| {
            let view = View::new(place.eye, place.toward, SIZE).expect("a view");
            view.in_sector(place.sector)
        };
        let views: Vec<View> = places.iter().map(view).collect();
        let (seen, missed) = missed(&import, &views);
        println!(
            "{}: {} views, {seen} surely visible, {} missed",
            file.display(),
            views.len(),
            missed.len()
        );
        failed.extend(
            missed
                .iter()
                .map(|missed| format!("{}: {missed}", file.display())),
        );
    }
    assert!(failed.is_empty(), "{failed:#?}");
}
