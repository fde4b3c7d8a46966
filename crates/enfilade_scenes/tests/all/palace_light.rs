//! Textures and lights of the palace: every face with a texture has texture coordinates, lamps hang in their rooms, and
//! sunlight enters through the windows.

use enfilade::{Geometry, LightId, LightShape, Limits, Scene, SectorId};
use enfilade_scenes::built_in;
use std::collections::{BTreeMap, BTreeSet};

fn palace() -> Scene {
    built_in("enfilade").expect("a built-in scene").scene
}

fn geometry(scene: &Scene, room: SectorId) -> &Geometry {
    scene.geometry(room).expect("a room with geometry")
}

#[test]
fn every_face_with_a_texture_has_a_part_of_it() {
    let scene = palace();
    let mut faces = 0;
    let mut seen = BTreeSet::new();
    for room in scene.sectors() {
        let geometry = geometry(&scene, room);
        for mesh in geometry.meshes() {
            for cluster in mesh.clusters() {
                let Some(texture) = geometry.material(cluster).texture else {
                    continue;
                };
                seen.insert(texture.0);
                assert!((texture.0 as usize) < geometry.textures().len());
                for face in cluster.faces.clone() {
                    let places: Vec<[f32; 2]> = (mesh.face(face).iter())
                        .map(|&corner| mesh.texture()[corner as usize])
                        .collect();
                    assert!(places.iter().flatten().all(|value| value.is_finite()));
                    let differ = places.iter().any(|place| *place != places[0]);
                    assert!(
                        differ,
                        "a face in {} shows one point of its texture",
                        scene.sector_name(room)
                    );
                    faces += 1;
                }
            }
        }
    }
    assert!(faces > 100_000, "{faces} faces with textures");
    assert!(seen.len() > 30, "{} textures are used", seen.len());
}

#[test]
fn lamps_hang_in_their_rooms_and_are_not_too_many() {
    let scene = palace();
    let mut rooms: BTreeMap<u32, usize> = BTreeMap::new();
    for light in scene.lights() {
        let name = scene.sector_name(light.sector);
        *rooms.entry(light.sector.0).or_default() += 1;
        if matches!(light.shape, LightShape::Sun { .. }) {
            continue;
        }
        let bounds = scene.bounds(light.sector);
        let inside = (0..3)
            .all(|axis| (bounds.min[axis] + 0.1..bounds.max[axis] - 0.1).contains(&light.position[axis]));
        assert!(inside, "a lamp of {name} hangs at {:?}", light.position);
    }
    let dark: Vec<&str> = (scene.sectors())
        .filter(|room| !rooms.contains_key(&room.0))
        .map(|room| scene.sector_name(room))
        .collect();
    assert!(dark.is_empty(), "no light in {dark:?}");
    assert!(rooms.values().all(|&count| count <= 7), "{rooms:?}");
}

#[test]
fn the_sun_comes_in_through_the_windows() {
    let scene = palace();
    let mut lit: BTreeSet<&str> = BTreeSet::new();
    for (number, light) in scene.lights().iter().enumerate() {
        if !matches!(light.shape, LightShape::Sun { .. }) {
            continue;
        }
        for reached in scene.light_reach(LightId(number as u32), &Limits::default()) {
            if reached.parent.is_some() {
                lit.insert(scene.sector_name(reached.sector));
            }
        }
    }
    for room in ["Vestibule", "Guard Room", "Gallery", "Antechamber", "Throne Room"] {
        assert!(lit.contains(room), "no sun in the {room}; it is in {lit:?}");
    }
}
