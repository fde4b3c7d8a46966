//! A world that changes, mirrored, against a scene that is built anew from what is in the world.

use enfilade::*;
use enfilade_sync::{Changes, Entity, EntityMap, Representation, Spawn};
use fastrand::Rng;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

const HALL: SectorId = SectorId(0);
const STUDY: SectorId = SectorId(1);
const SIZE: [u32; 2] = [128, 72];

/// The engine's keys of two meshes, of one that comes later, of one that never does, and of one that no scene accepts.
const MESHES: [u64; 5] = [10, 11, LATE, ABSENT, UNFIT];
const LATE: u64 = 12;
const ABSENT: u64 = 13;
const UNFIT: u64 = 14;
const BOUNDS: Aabb = Aabb {
    min: [-0.25, 0.0, -0.25],
    max: [0.25, 1.5, 0.25],
};

fn mesh(key: u64) -> Arc<Mesh> {
    let Aabb { min, max } = match key {
        11 => Aabb {
            min: [-0.1, 0.5, -0.1],
            max: [0.1, 1.0, 0.1],
        },
        _ => BOUNDS,
    };
    let material = MaterialId(if key == UNFIT { 9 } else { 0 });
    Arc::new(Mesh::cuboid(min, max, material).expect("a box"))
}

/// Returns two rooms, joined by a doorway in the wall z = 0, with items of the given keys.
fn rooms(items: &[(&Spawn, Arc<Mesh>)]) -> Scene {
    let doorway =
        ConvexPolygon::rectangle([-0.5, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]).expect("a door");
    let mut scene = SceneBuilder::new();
    let [hall, study] = [(HALL, doorway.clone()), (STUDY, doorway.flipped())].map(|(sector, doorway)| {
        let mut room = GeometryBuilder::new([Material::opaque([0.6; 3])]);
        for (spawn, mesh) in items.iter().filter(|(spawn, _)| spawn.entity.sector == sector) {
            let mesh = room.mesh(Arc::clone(mesh));
            let item = room.item("", mesh, spawn.transform);
            room.set_key(item, spawn.entity.key);
            room.set_options(item, spawn.options);
        }
        room.opening("doorway", doorway);
        scene.add("room", room.build().expect("a room"), Method::HierarchicalZ)
    });
    scene.door((hall, OpeningId(0)), (study, OpeningId(0)));
    scene.build().expect("two rooms")
}

fn between(random: &mut Rng, low: f32, high: f32) -> f32 {
    low + (high - low) * random.f32()
}

fn a_place(random: &mut Rng, sector: SectorId) -> Transform {
    let z = between(random, 0.4, 5.0);
    let z = if sector == HALL { z } else { -z };
    let turn = Transform::rotation([0.0, 1.0, 0.0], f64::from(between(random, 0.0, 3.0)));
    Transform::translation([between(random, -3.0, 3.0), 0.0, z]) * turn
}

fn a_spawn(random: &mut Rng, key: u64, mesh: u64) -> Spawn {
    let sector = [HALL, STUDY][random.usize(..2)];
    Spawn {
        entity: Entity { key, sector },
        mesh,
        bounds: BOUNDS,
        transform: a_place(random, sector),
        options: occluder(random.u8(..4) > 0),
    }
}

fn occluder(is_occluder: bool) -> ItemOptions {
    ItemOptions {
        is_occluder,
        ..ItemOptions::default()
    }
}

fn keys_of(set: &VisibleSet) -> BTreeSet<u64> {
    set.items().iter().map(|item| item.key).collect()
}

#[test]
fn a_world_that_changes_shows_what_a_scene_built_anew_shows() {
    let mut random = Rng::with_seed(1);
    let (mut scene, mut entities) = (rooms(&[]), EntityMap::new());
    for key in MESHES.into_iter().filter(|&key| key != LATE && key != ABSENT) {
        entities.set_mesh(key, Some(mesh(key)));
    }
    let mut world: BTreeMap<u64, Spawn> = BTreeMap::new();
    let (mut viewer, mut keys, mut kept) = (Viewer::new(), VisibleKeys::default(), BTreeSet::new());
    let [mut seen, mut boxed, mut refused] = [0; 3];
    for frame in 0..40 {
        if frame == 20 {
            entities.set_mesh(LATE, Some(mesh(LATE)));
        }
        let (mut spawned, mut moved, mut despawned) = (vec![], vec![], vec![]);
        let mut touched = BTreeSet::new();
        while touched.len() < 50 {
            let living: Vec<u64> = world.keys().copied().collect();
            let key = match living.is_empty() || random.u8(..3) == 0 {
                true => random.u64(..),
                false => living[random.usize(..living.len())],
            };
            if !touched.insert(key) {
                continue;
            }
            match world.get_mut(&key) {
                None => {
                    let mesh = MESHES[random.usize(..MESHES.len())];
                    let spawn = a_spawn(&mut random, key, mesh);
                    spawned.push(spawn);
                    world.insert(key, spawn);
                }
                Some(spawn) if random.bool() => {
                    spawn.transform = a_place(&mut random, spawn.entity.sector);
                    moved.push((spawn.entity, spawn.transform));
                }
                Some(spawn) => {
                    despawned.push(spawn.entity);
                    world.remove(&key);
                }
            }
        }
        let changes = Changes {
            despawned: &despawned,
            spawned: &spawned,
            moved: &moved,
        };
        let synced = entities.sync(&mut scene, &changes).expect("a small edit");
        assert_eq!(synced.unknown, []);
        refused += synced.refused.len();

        let has_mesh =
            |spawn: &&Spawn| ![ABSENT, UNFIT].contains(&spawn.mesh) && (spawn.mesh != LATE || frame >= 20);
        let items: Vec<_> = world
            .values()
            .filter(has_mesh)
            .map(|spawn| (spawn, mesh(spawn.mesh)))
            .collect();
        let built_anew = rooms(&items);
        let view = View::new(
            [between(&mut random, -2.5, 2.5), 1.0, 3.0],
            [0.0, 1.0, -1.0],
            SIZE,
        )
        .expect("a valid view");
        let expected = keys_of(Viewer::new().look(&built_anew, &view));
        seen += expected.len();

        let set = viewer.look(&scene, &view);
        keys.update_with(set, entities.always_visible());
        let now: BTreeSet<u64> = keys.all().iter().copied().collect();
        let is_item = |key: &u64| has_mesh(&&world[key]);
        let shown: BTreeSet<u64> = now.iter().copied().filter(is_item).collect();
        assert_eq!(shown, expected, "frame {frame}");

        // Boxes that hide nothing are listed at least where they own a sample.
        let boxes = world.values().filter(|spawn| !has_mesh(spawn));
        let boxes: Vec<Spawn> = boxes
            .map(|spawn| Spawn {
                options: occluder(false),
                ..*spawn
            })
            .collect();
        let boxes = boxes.iter().map(|spawn| (spawn, mesh(10)));
        let with_boxes: Vec<_> = items.iter().cloned().chain(boxes).collect();
        let at_least = keys_of(Viewer::new().look(&rooms(&with_boxes), &view));
        assert!(at_least.is_subset(&now), "frame {frame}");
        boxed += at_least.len() - expected.len();

        for &key in keys.left() {
            assert!(kept.remove(&key), "frame {frame}: {key} left twice");
        }
        for &key in keys.entered() {
            assert!(kept.insert(key), "frame {frame}: {key} entered twice");
        }
        assert_eq!(kept, now, "frame {frame}");
    }
    assert!(
        seen > 200 && boxed > 50 && refused > 50,
        "{seen} {boxed} {refused}"
    );
}

#[test]
fn a_box_is_listed_while_the_eye_is_inside_it_or_looks_at_it_through_a_door() {
    let (mut scene, mut entities) = (rooms(&[]), EntityMap::new());
    let around = |key, sector, z| Spawn {
        entity: Entity { key, sector },
        mesh: ABSENT,
        bounds: BOUNDS,
        transform: Transform::translation([0.0, 0.0, z]),
        options: occluder(true),
    };
    let spawned = [around(1, HALL, 3.0), around(2, STUDY, -3.0), around(3, HALL, 4.0)];
    let changes = Changes {
        spawned: &spawned,
        ..Changes::default()
    };
    entities.sync(&mut scene, &changes).expect("three boxes");
    let (mut viewer, mut keys) = (Viewer::new(), VisibleKeys::default());
    let eye = [0.0, 1.0, 3.0];
    let view = View::new(eye, [0.0, 1.0, 0.0], SIZE).expect("a valid view");
    let set = viewer.look(&scene, &view);
    keys.update_with(set, entities.always_visible());
    assert_eq!(keys.all(), [1, 2]);
    let view = View::new(eye, [9.0, 1.0, 3.0], SIZE).expect("a valid view");
    let set = viewer.look(&scene, &view);
    keys.update_with(set, entities.always_visible());
    assert_eq!((keys.all(), keys.left()), (&[1][..], &[2][..]));
}

#[test]
fn a_box_behind_a_wall_is_listed_once_the_wall_is_gone() {
    const WALL: u64 = 20;
    let (mut scene, mut entities) = (rooms(&[]), EntityMap::new());
    let wall = Mesh::cuboid([-9.0, -9.0, -0.1], [9.0, 9.0, 0.1], MaterialId(0)).expect("a box");
    entities.set_mesh(WALL, Some(Arc::new(wall)));
    let at = |key, mesh, z| Spawn {
        entity: Entity { key, sector: HALL },
        mesh,
        bounds: BOUNDS,
        transform: Transform::translation([0.0, 0.0, z]),
        options: occluder(true),
    };
    let [wall, smoke] = [at(1, WALL, 2.0), at(2, ABSENT, 1.0)];
    let spawned = [wall, smoke];
    let changes = Changes {
        spawned: &spawned,
        ..Changes::default()
    };
    entities.sync(&mut scene, &changes).expect("a wall and a box");
    assert!(matches!(
        entities.representation(smoke.entity),
        Some(Representation::Box(_))
    ));
    let (mut viewer, mut keys) = (Viewer::new(), VisibleKeys::default());
    let view = View::new([0.0, 1.0, 4.0], [0.0, 1.0, 0.0], SIZE).expect("a valid view");
    keys.update_with(viewer.look(&scene, &view), entities.always_visible());
    assert_eq!(keys.all(), [1]);
    let changes = Changes {
        despawned: &[wall.entity],
        ..Changes::default()
    };
    entities.sync(&mut scene, &changes).expect("a box");
    keys.update_with(viewer.look(&scene, &view), entities.always_visible());
    assert_eq!(keys.all(), [2]);
}

#[test]
fn what_the_scene_refuses_is_listed_everywhere_until_it_is_sound_again() {
    let (mut scene, mut entities) = (rooms(&[]), EntityMap::new());
    entities.set_mesh(10, Some(mesh(10)));
    let spawn = |key, sector| Spawn {
        entity: Entity { key, sector },
        mesh: 10,
        bounds: BOUNDS,
        transform: Transform::translation([0.0, 0.0, 4.0]),
        options: occluder(true),
    };
    let [lost, stray] = [spawn(1, HALL), spawn(2, SectorId(7))];
    let changes = Changes {
        spawned: &[lost, stray],
        ..Changes::default()
    };
    let synced = entities.sync(&mut scene, &changes).expect("an edit");
    let no_such_sector = EditError::NoSuchSector {
        sector: 7,
        sectors: 2,
    };
    assert_eq!(synced.refused, [(stray.entity, no_such_sector)]);
    let representation = |entities: &EntityMap, spawn: &Spawn| entities.representation(spawn.entity);
    assert!(matches!(
        representation(&entities, &lost),
        Some(Representation::Mesh(_))
    ));
    assert_eq!(
        representation(&entities, &stray),
        Some(Representation::AlwaysVisible)
    );

    let nowhere = Transform::translation([f32::NAN; 3]);
    let changes = Changes {
        moved: &[(lost.entity, nowhere)],
        ..Changes::default()
    };
    let synced = entities.sync(&mut scene, &changes).expect("an edit");
    assert!(matches!(synced.refused[..], [(entity, EditError::NotFinite(_))] if entity == lost.entity));
    assert_eq!(scene.item_count(), 0);
    let (mut viewer, mut keys) = (Viewer::new(), VisibleKeys::default());
    let away = View::new([0.0, 1.0, 3.0], [9.0, 1.0, 3.0], SIZE).expect("a valid view");
    let set = viewer.look(&scene, &away);
    keys.update_with(set, entities.always_visible());
    assert_eq!(keys.all(), [1, 2]);

    let changes = Changes {
        moved: &[(lost.entity, lost.transform)],
        despawned: &[stray.entity, spawn(3, HALL).entity],
        ..Changes::default()
    };
    let synced = entities.sync(&mut scene, &changes).expect("an edit");
    assert_eq!(
        (synced.refused, synced.unknown),
        (vec![], vec![spawn(3, HALL).entity])
    );
    let set = viewer.look(&scene, &away);
    keys.update_with(set, entities.always_visible());
    assert_eq!((keys.all(), keys.left()), (&[][..], &[1, 2][..]));
}
