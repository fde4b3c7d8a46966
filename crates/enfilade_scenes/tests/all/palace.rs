//! Invariants of the palace: item counts, closed rooms, joined doors, determinism.

use enfilade::{Aabb, Geometry, ItemIndex, Method, Scene, SectorId, Transform};
use enfilade_scenes::{BuiltIn, built_in};
use std::collections::{BTreeSet, HashMap};

fn palace() -> BuiltIn {
    built_in("enfilade").expect("a built-in scene")
}

fn rooms(scene: &Scene) -> impl Iterator<Item = (SectorId, &str, &Geometry)> {
    scene.sectors().map(|id| {
        (
            id,
            scene.sector_name(id),
            &**scene.geometry(id).expect("a room with geometry"),
        )
    })
}

#[test]
fn it_has_the_rooms_doors_items_and_triangles_that_it_is_known_for() {
    let scene = palace().scene;
    let doors = scene
        .portals()
        .iter()
        .filter(|portal| portal.there_from_here == Transform::IDENTITY)
        .count()
        / 2;
    let mirrors = scene
        .portals()
        .iter()
        .filter(|portal| portal.from == portal.to)
        .count();
    assert_eq!((scene.sector_count(), doors, mirrors), (34, 59, 8));
    assert_eq!((scene.item_count(), scene.triangle_count()), (5600, 2_782_319));
}

fn room(scene: &Scene, wanted: &str) -> SectorId {
    let mut all = rooms(scene);
    all.find(|(_, name, _)| *name == wanted).expect("a room").0
}

#[test]
fn one_comes_out_of_the_secret_passage_and_out_of_the_living_picture_but_not_back() {
    let scene = palace().scene;
    for (from, to) in [("Secret Passage", "Library"), ("Picture Room", "Court")] {
        let [from, to] = [from, to].map(|name| room(&scene, name));
        let leads = |from, to| {
            let mut portals = scene.portals().iter();
            portals.any(|portal| portal.from == from && portal.to == to)
        };
        assert!(leads(from, to) && !leads(to, from));
    }
}

#[test]
fn two_mirrors_of_the_mirror_room_face_each_other() {
    let scene = palace().scene;
    let geometry = scene
        .geometry(room(&scene, "Mirror Room"))
        .expect("a sector with geometry");
    let mirrors: Vec<_> = (geometry.openings().iter())
        .filter(|opening| opening.name.contains(": mirror "))
        .map(|opening| &opening.outline)
        .collect();
    let face = mirrors.iter().any(|a| {
        mirrors.iter().any(|b| {
            let [a_box, b_box] = [a.bounds(), b.bounds()];
            let opposite = a.normal()[0] * b.normal()[0] < -0.99;
            opposite
                && [1, 2]
                    .iter()
                    .all(|&axis| (a_box.center()[axis] - b_box.center()[axis]).abs() < 1e-3)
        })
    });
    assert!(face);
}

#[test]
fn the_garden_is_seen_as_terrain_and_the_painted_gallery_as_convex_cells() {
    let scene = palace().scene;
    let seen_by = |method: Method| -> Vec<&str> {
        let all = scene.sectors().filter(|&id| scene.method(id) == Some(method));
        all.map(|id| scene.sector_name(id)).collect()
    };
    assert_eq!(seen_by(Method::FloatingHorizon), ["Garden"]);
    let cells = seen_by(Method::Cell);
    assert_eq!(cells.len(), 9, "{cells:?}");
    assert!(
        ["Painted Lobby", "Tribune", "Belvedere"]
            .iter()
            .all(|cell| cells.contains(cell))
    );
    for (_, name, geometry) in rooms(&scene) {
        assert_eq!(
            Method::FloatingHorizon.suits(geometry),
            name == "Garden",
            "{name}"
        );
        if cells.contains(&name) {
            assert!(Method::Cell.suits(geometry), "{name} is not convex");
        }
    }
}

#[test]
fn windows_look_into_the_garden_and_the_garden_into_the_windows() {
    let scene = palace().scene;
    let garden = room(&scene, "Garden");
    for (from, windows) in [
        ("Antechamber", 2),
        ("Throne Room", 3),
        ("Painted Lobby", 1),
        ("Morning Bay", 2),
        ("Tribune", 1),
        ("Evening Bay", 2),
        ("Belvedere", 1),
    ] {
        let from = room(&scene, from);
        let between = |a, b| {
            let portals = scene.portals().iter();
            portals
                .filter(|portal| portal.from == a && portal.to == b)
                .count()
        };
        assert_eq!([between(from, garden), between(garden, from)], [windows; 2]);
    }
}

#[test]
fn every_thing_has_a_name_of_its_own() {
    let scene = palace().scene;
    let names: BTreeSet<&str> = rooms(&scene)
        .flat_map(|(_, _, geometry)| (0..geometry.items().len()).map(|i| geometry.name(ItemIndex(i as u32))))
        .collect();
    assert_eq!(names.len(), scene.item_count());
}

#[test]
fn one_can_walk_from_the_first_room_to_every_other() {
    let scene = palace().scene;
    let mut reached = BTreeSet::from([SectorId(0)]);
    let mut waiting = vec![SectorId(0)];
    while let Some(room) = waiting.pop() {
        for portal in scene.portals().iter().filter(|portal| portal.from == room) {
            if reached.insert(portal.to) {
                waiting.push(portal.to);
            }
        }
    }
    assert_eq!(reached.len(), scene.sector_count());
}

#[test]
fn a_camera_that_is_named_for_a_room_stands_in_it() {
    let BuiltIn { scene, cameras } = palace();
    let located = |camera: &enfilade_scenes::Camera| {
        let room = scene
            .locate(camera.eye, camera.toward)
            .expect("a position inside a room");
        scene.sector_name(room).to_lowercase()
    };
    let names: BTreeSet<String> = rooms(&scene).map(|(_, name, _)| name.to_lowercase()).collect();
    let named: Vec<_> = cameras
        .iter()
        .filter(|camera| names.contains(&camera.name))
        .collect();
    assert!(named.len() >= 8);
    for camera in named {
        assert_eq!(located(camera), camera.name);
    }
    assert_eq!(located(&cameras[0]), "vestibule");
}

#[test]
fn rooms_meet_at_their_doors_and_nowhere_overlap() {
    let scene = palace().scene;
    for a in scene.sectors() {
        for b in scene.sectors().filter(|b| b.0 > a.0) {
            let [a_box, b_box] = [scene.bounds(a), scene.bounds(b)];
            let shared = a_box.intersection(&b_box);
            let overlap = if shared.is_empty() { 0.0 } else { shared.volume() };
            let [a, b] = [a, b].map(|id| scene.sector_name(id));
            assert!(overlap < 1e-2, "{a} and {b} share {overlap} cubic metres");
        }
    }
    for portal in scene
        .portals()
        .iter()
        .filter(|portal| portal.there_from_here == Transform::IDENTITY)
    {
        let geometry = scene.geometry(portal.from).expect("a room with geometry");
        let opening = &geometry.openings()[usize::from(portal.opening.0)];
        let Aabb { min, max } = opening.outline.bounds();
        let axis = (0..3)
            .find(|&axis| min[axis] == max[axis])
            .expect("an axis-aligned door");
        let bounds = geometry.bounds();
        let end = if opening.outline.normal()[axis] > 0.0 {
            bounds.min[axis]
        } else {
            bounds.max[axis]
        };
        let room = scene.sector_name(portal.from);
        assert_eq!(
            end, min[axis],
            "{room} does not end at the plane of `{}`",
            opening.name
        );
    }
}

/// Asserts that every edge of a room's floor, walls and ceiling has an opposite edge or is an edge of one of its
/// openings, so rays leave through openings only. The court, the terrace and the garden are open to the sky; the
/// garden's walls extend into the ground and end in hills.
#[test]
fn every_room_is_closed_but_for_its_openings() {
    let scene = palace().scene;
    for (_, name, geometry) in rooms(&scene) {
        let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
        let mut add = |corners: &[[f32; 3]]| {
            for i in 0..corners.len() {
                let [a, b] = [corners[i], corners[(i + 1) % corners.len()]].map(|at| at.map(f32::to_bits));
                *edges.entry([a, b]).or_default() += 1;
                *edges.entry([b, a]).or_default() -= 1;
            }
        };
        let mut pieces = 0;
        for number in 0..geometry.items().len() as u32 {
            if !geometry.name(ItemIndex(number)).contains("shell") {
                continue;
            }
            pieces += 1;
            assert_eq!(geometry.item(ItemIndex(number)).transform(), Transform::IDENTITY);
            let mesh = geometry.mesh_of(ItemIndex(number));
            for face in 0..mesh.face_count() {
                let corners: Vec<[f32; 3]> = mesh
                    .face(face)
                    .iter()
                    .map(|&corner| mesh.positions()[corner as usize])
                    .collect();
                add(&corners);
            }
        }
        assert!(pieces > 0, "{name} has no shell");
        for opening in geometry
            .openings()
            .iter()
            .filter(|opening| opening.name != "doll's house")
        {
            add(opening.outline.corners());
        }
        let sky = match name {
            "Court" => Some(9.0_f32),
            "Terrace" => Some(6.4),
            "Garden" => Some(9.0),
            _ => None,
        };
        let to_the_sky =
            |edge: &[[u32; 3]; 2]| sky.is_some_and(|top| edge.iter().all(|at| at[1] == top.to_bits()));
        let in_the_ground = |edge: &[[u32; 3]; 2]| {
            let [a, b] = edge.map(|at| at.map(f32::from_bits));
            let ends = [[-7.45, -162.0], [-66.0, -92.45]];
            let is_end = a[0] == b[0] && a[2] == b[2] && ends.contains(&[a[0], a[2]]);
            name == "Garden" && (is_end || a[1] == 0.0 && b[1] == 0.0)
        };
        let open: Vec<_> = edges
            .iter()
            .filter(|(edge, excess)| **excess != 0 && !to_the_sky(edge) && !in_the_ground(edge))
            .collect();
        assert!(
            open.is_empty(),
            "{name} has {} open edges, such as {:?}",
            open.len(),
            open[0].0.map(|at| at.map(f32::from_bits))
        );
    }
}
