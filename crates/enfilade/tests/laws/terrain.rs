//! Terrain: exact visibility from any position; geometry that is no terrain, or no longer terrain, is rejected.

use crate::convex::{keeps_its_contract, view};
use enfilade::{
    Alpha, ConvexPolygon, Geometry, GeometryBuilder, HeightField, ItemIndex, Material, MaterialId, Mesh,
    Method, Scene, SceneBuilder, SceneError, SectorId, Transform, Unsuited, View,
};
use enfilade_scenes::Random;
use glam::DVec3;
use proptest::prelude::*;
use std::sync::Arc;

/// Hills, spikes, cliffs, plateaus, and strips of two samples.
fn field(random: &mut Random) -> HeightField {
    let size = match random.below(4) {
        0 => [2, 2 + random.below(90) as u32],
        1 => [2 + random.below(90) as u32, 2],
        _ => [2 + random.below(70) as u32, 2 + random.below(70) as u32],
    };
    let kind = random.below(5);
    let [long, wide] = [random.between(0.1, 0.8), random.between(0.1, 0.8)];
    let mut heights = Vec::new();
    for row in 0..size[1] {
        for column in 0..size[0] {
            let hill = (column as f32 * long).sin() + (row as f32 * wide).cos();
            heights.push(match kind {
                0 => hill,
                1 if random.below(9) == 0 => random.between(2.0, 9.0),
                2 => 6.0 * hill.round(),
                3 => hill.max(0.0),
                4 => random.between(-1.0, 1.0),
                _ => 0.0,
            });
        }
    }
    let cell = [
        f64::from(random.between(0.3, 2.0)),
        f64::from(random.between(0.3, 2.0)),
    ];
    HeightField::new(size, cell, heights).expect("a sound field")
}

/// A field and boxes on, in and above it; some are glass.
fn geometry(random: &mut Random, field: &HeightField, place: Transform, openings: bool) -> Geometry {
    let ground = Material {
        double_sided: random.below(2) == 0,
        ..Material::opaque([0.3, 0.4, 0.2])
    };
    let glass = Material {
        alpha: Alpha::Blend,
        ..Material::opaque([0.5; 3])
    };
    let mut builder = GeometryBuilder::new([ground, Material::opaque([0.8, 0.2, 0.2]), glass]);
    let things = random.below(5);
    for number in 0..things {
        // Some have lower ids than the terrain, some higher.
        if number == things / 2 {
            builder
                .terrain("ground", field.clone(), MaterialId(0), place)
                .expect("few faces");
        }
        let material = MaterialId(1 + random.below(2) as u32);
        let corners = [0, 1, 2, 3].map(|_| {
            let at = field.position(
                random.below(field.size()[0] as usize) as u32,
                random.below(field.size()[1] as usize) as u32,
            );
            [at[0], at[1] + random.between(-1.0, 4.0), at[2]]
        });
        let faces = [0, 1, 2, 0, 2, 1, 0, 1, 3, 0, 3, 1, 1, 2, 3, 1, 3, 2];
        let mesh = builder.mesh(Mesh::triangles(&corners, &faces, material).expect("triangles"));
        builder.item("thing", mesh, place);
    }
    if things == 0 {
        builder
            .terrain("ground", field.clone(), MaterialId(0), place)
            .expect("few faces");
    }
    if openings {
        let middle = DVec3::from(place.point(field.position(0, 0)).map(f64::from));
        let corners = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [0.0, 4.0]]
            .map(|[x, y]| (middle + DVec3::new(x, y, 1.0)).as_vec3().to_array());
        builder.opening("pool", ConvexPolygon::new(&corners).expect("a rectangle"));
    }
    builder.build().expect("sound things")
}

/// Views from above, on and under the ground, level and straight up and down, upright and rolled; the last ones along
/// plateaus exactly at eye level.
fn views(random: &mut Random, field: &HeightField, place: &Transform) -> Vec<View> {
    let mut views = Vec::new();
    for look in 0..9 {
        let mut anywhere = |above: f32| {
            let [column, row] = [0, 1].map(|axis| random.below(field.size()[axis] as usize) as u32);
            let at = field.position(column, row);
            DVec3::from(
                place
                    .point([at[0] + 0.1, at[1] + above, at[2] + 0.07])
                    .map(f64::from),
            )
        };
        let eye = anywhere([0.3, 1.7, 30.0, 0.001, -0.2, -9.0, 2.0, -2.0, 0.0][look]);
        let toward = match look {
            6 => DVec3::from(place.direction([0.0, -1.0, 0.0]).map(f64::from)) + eye,
            7 => DVec3::from(place.direction([0.0, 1.0, 0.0]).map(f64::from)) + eye,
            8 => anywhere(0.0),
            _ => anywhere(1.0),
        };
        if eye.distance(toward) < 1e-3 {
            continue;
        }
        let mut seen = view(SectorId(0), eye, toward, [0.01, 0.5][look % 2]);
        if look > 2 {
            seen.up = [
                random.between(-1.0, 1.0),
                random.between(-1.0, 1.0),
                random.between(-1.0, 1.0),
            ];
        }
        views.push(seen);
    }
    views
}

fn place(random: &mut Random) -> Transform {
    match random.below(4) {
        0 => Transform::IDENTITY,
        1 => Transform::rotation([0.0, 1.0, 0.0], f64::from(random.between(0.0, 6.0))),
        2 => Transform::rotation([0.3, 0.2, 1.0], f64::from(random.between(0.0, 6.0))),
        _ => Transform::translation([100.0, -20.0, 3.0]) * Transform::scaling([1.0, 2.0, -1.0]),
    }
}

fn seen_by(geometry: Geometry, mirror: bool) -> Scene {
    let mut scene = SceneBuilder::new();
    let ground = scene.add("ground", geometry, Method::FloatingHorizon);
    if mirror {
        scene.mirror(ground, enfilade::OpeningId(0));
    }
    scene.build().expect("it has a height field")
}

proptest! {
    #![proptest_config(crate::by_chance())]

    #[test]
    fn ground_and_what_stands_on_it_is_seen_from_anywhere(seed in any::<u64>()) {
        let random = &mut Random::new(seed);
        let field = field(random);
        let place = place(random);
        let mirror = random.below(3) == 0;
        let scene = seen_by(geometry(random, &field, place, mirror), mirror);
        keeps_its_contract(&scene, &views(random, &field, &place), &format!("seed {seed}"));
    }
}

#[test]
fn a_valley_is_seen_and_most_of_what_is_beyond_is_not_even_asked_for() {
    // A trench along x in a plain of many blocks.
    let size = [600, 600];
    let heights: Vec<f32> = (0..size[1])
        .flat_map(|row| (0..size[0]).map(move |_| if (290..310_u32).contains(&row) { 0.0 } else { 30.0 }))
        .collect();
    let field = HeightField::new(size, [1.0, 1.0], heights).expect("a sound field");
    let mut builder = GeometryBuilder::new([Material::opaque([0.3; 3])]);
    builder
        .terrain("ground", field, MaterialId(0), Transform::IDENTITY)
        .expect("few faces");
    let scene = seen_by(builder.build().expect("blocks"), false);
    let across = view(
        SectorId(0),
        DVec3::new(300.0, 2.0, 305.0),
        DVec3::new(300.0, 2.0, 0.0),
        0.1,
    );
    assert!(keeps_its_contract(&scene, &[across], "the trench") > 0);
    let mut viewer = enfilade::Viewer::new();
    viewer.look(&scene, &across);
    let triangles = viewer.stats().triangles;
    assert!(triangles < 72_000, "{triangles} of 717,602");
}

#[test]
fn what_has_no_ground_and_ground_that_was_moved_are_refused() {
    let random = &mut Random::new(7);
    let bare = GeometryBuilder::new([]).build().expect("nothing");
    assert!(!Method::FloatingHorizon.suits(&bare));
    let refused = Method::FloatingHorizon.build(Arc::new(bare), u64::MAX);
    let why = refused.map(|_| ()).expect_err("there is no ground");
    assert_eq!(why.reason, Unsuited::NoTerrain);
    assert!(why.to_string().contains("and this sector has none"), "{why}");

    let ground = field(random);
    let mut builder = GeometryBuilder::new([Material::opaque([0.3; 3])]);
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = builder.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("a triangle"));
    let thing = builder.item("thing", mesh, Transform::IDENTITY);
    builder
        .terrain("ground", ground, MaterialId(0), Transform::IDENTITY)
        .expect("few faces");
    let mut scene = seen_by(builder.build().expect("sound things"), false);
    let mut edit = scene.edit();
    edit.set_transform(SectorId(0), thing, Transform::translation([3.0, 1.0, 0.0]))
        .expect("it is there");
    edit.finish().expect("what stands on the ground may move");
    let mut edit = scene.edit();
    edit.set_transform(
        SectorId(0),
        ItemIndex(1).into(),
        Transform::translation([3.0, 1.0, 0.0]),
    )
    .expect("it is there");
    let refused = edit.finish().expect_err("the ground stays");
    assert!(matches!(refused, SceneError::Unsuited { .. }), "{refused}");
    assert!(refused.to_string().contains("was edited"), "{refused}");
}
