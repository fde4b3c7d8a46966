//! A city of an engine, mirrored: which of its entities are visible, by the engine's ids and matrices, frame by frame.
//!
//! Run with `cargo run --release --example 02_mirror_your_entities -p enfilade_sync`.
#![expect(clippy::print_stdout, reason = "examples print")]

use enfilade::*;
use enfilade_sync::{Changes, Entity, EntityMap, Spawn};

const HOUSE: u64 = 1; // the engine's own number of a mesh

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let empty = GeometryBuilder::new([Material::opaque([0.7; 3])]).build()?;
    let mut scene = Scene::single(empty, Method::Masked)?;
    let mut entities = EntityMap::new();
    let [min, max] = [[-4.0, 0.0, -4.0], [4.0, 12.0, 4.0]];
    entities.set_mesh(HOUSE, Some(Mesh::cuboid(min, max, MaterialId(0))?.into()));

    let spawn = |key: u64| Spawn {
        entity: Entity::new(key, SectorId(0)), // the engine's own id
        mesh: HOUSE,
        bounds: Aabb { min, max },
        transform: Transform::translation([(key % 50) as f32 * 14.0, 0.0, (key / 50) as f32 * -14.0]),
        options: ItemOptions::default(),
    };
    let spawned: Vec<Spawn> = (0..2500).map(spawn).collect();
    let changes = Changes {
        spawned: &spawned,
        ..Changes::default()
    };
    entities.sync(&mut scene, &changes)?;

    // 90 degrees, reversed infinite depth, near plane at 0.1: columns as in Bevy. The eye is at (357, 1.7, 3), in the
    // middle of a street, and looks along it.
    let across = [0.5625, 0.0, 0.0, 0.0];
    let clip_from_eye = [across, [0., 1., 0., 0.], [0., 0., 0., -1.], [0., 0., 0.1, 0.]];
    let at = [-357.0, -1.7, -3.0, 1.0];
    let eye_from_world = [[1., 0., 0., 0.], [0., 1., 0., 0.], [0., 0., 1., 0.], at];
    let view = View::from_matrices(eye_from_world, clip_from_eye, ClipDepth::OneToZero, [1280, 720])?;

    let (mut viewer, mut keys) = (Viewer::new(), VisibleKeys::default());
    for frame in 0..4_u8 {
        // Some of the houses walk away.
        let step = Transform::translation([0.0, 0.0, -9.0 * f32::from(frame)]);
        let walkers = spawned.iter().step_by(3);
        let moved: Vec<_> = walkers
            .map(|house| (house.entity, step * house.transform))
            .collect();
        let changes = Changes {
            moved: &moved,
            ..Changes::default()
        };
        entities.sync(&mut scene, &changes)?;
        let set = viewer.look(&scene, &view);
        keys.update_with(set, entities.always_visible());
        let [all, entered, left] = [keys.all(), keys.entered(), keys.left()].map(<[u64]>::len);
        println!("frame {frame}: {all} of 2500 visible, {entered} entered, {left} left");
    }
    Ok(())
}
