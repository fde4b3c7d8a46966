//! Spatial queries, each compared with brute force for random queries on several scenes.

mod between;
mod chance;
mod items;
mod near;
mod rays;
mod survey;

use chance::{about, length};
use enfilade::{Aabb, Geometry, GeometryBuilder, Material, MaterialId, Mesh, Transform};
use enfilade_scenes::{Random, built_in};
use glam::{DAffine3, DMat3, DVec3};
use std::sync::Arc;

/// Number of queries of each kind per scene.
const QUESTIONS: usize = 10_000;

/// A palace, random items, thousands of items, large meshes, items flattened by scaling, and very large and small
/// coordinates.
const SCENES: [&str; 7] = [
    "enfilade",
    "random",
    "crowd",
    "big-mesh",
    "degenerate",
    "far-away",
    "tiny",
];

/// Corners of the sides of a box, counter-clockwise from outside; bit 0 of a corner's index selects its x, and so on.
const CUBE_SIDES: [[u32; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// Returns the geometry with the most items of each scene, by name.
fn geometries() -> impl Iterator<Item = (&'static str, Arc<Geometry>)> {
    SCENES.into_iter().map(|name| {
        let scene = built_in(name).expect("it is built in").scene;
        let geometries = scene.sectors().filter_map(|id| scene.geometry(id));
        let largest = geometries.max_by_key(|geometry| geometry.items().len());
        (name, Arc::clone(largest.expect("it has rooms")))
    })
}

/// Blocks of several sizes, one per street square: walls that occlude.
fn city() -> Option<(&'static str, Arc<Geometry>)> {
    let unit = Aabb {
        min: [0.0; 3],
        max: [1.0; 3],
    };
    let faces = CUBE_SIDES.map(|[a, b, c, d]| [a, b, c, a, c, d]);
    let block = Mesh::triangles(&unit.corners(), faces.as_flattened(), MaterialId(0)).expect("a cube");
    let mut builder = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    let block = builder.mesh(block);
    let mut chance = Random::new(11);
    for place in 0..400_u16 {
        let [x, z] = [place % 20, place / 20].map(|street| 10.0 * f32::from(street));
        let [width, height, depth] = [(); 3].map(|()| 1.0 + 8.0 * chance.unit());
        let at = Transform::translation([x, 0.0, z]) * Transform::rotation([0.0, 1.0, 0.0], f64::from(place));
        builder.item(
            "block",
            block,
            at * Transform::scaling([width, 4.0 * height, depth]),
        );
    }
    Some(("city", Arc::new(builder.build().expect("sound"))))
}

/// Returns an item's transform in f64, without the library's arithmetic.
fn affine(transform: &Transform) -> DAffine3 {
    let [x, y, z, at] = transform
        .columns()
        .map(|column| DVec3::from(column.map(f64::from)));
    DAffine3 {
        matrix3: DMat3::from_cols(x, y, z),
        translation: at,
    }
}

/// Returns the triangles of a mesh, each with its face.
fn triangles(mesh: &Mesh) -> impl Iterator<Item = (u32, [DVec3; 3])> {
    (0..mesh.face_count()).flat_map(move |face| {
        let corners = mesh.face(face);
        let corner = |i: usize| DVec3::from(mesh.positions()[corners[i] as usize].map(f64::from));
        (2..corners.len()).map(move |last| (face, [corner(0), corner(last - 1), corner(last)]))
    })
}
