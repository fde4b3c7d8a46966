//! Questions other than looking, each held against going through everything, on random questions to several scenes.

mod chance;
mod items;
mod pairs;
mod rays;

use chance::Chance;
use enfilade::{Content, Mesh, Transform};
use enfilade_scenes::built_in;
use glam::{DAffine3, DMat3, DVec3};
use std::sync::Arc;

/// Questions of each kind asked of each scene.
const QUESTIONS: usize = 10_000;

/// A palace, things by chance, thousands of things, large meshes, things scaled flat, and numbers large and small.
const SCENES: [&str; 7] = [
    "enfilade",
    "random",
    "crowd",
    "big-mesh",
    "degenerate",
    "far-away",
    "tiny",
];

/// The content with the most items of each scene, by name.
fn contents() -> impl Iterator<Item = (&'static str, Arc<Content>)> {
    SCENES.into_iter().map(|name| {
        let scene = built_in(name).expect("it is built in").scene;
        let contents = scene.fragments().filter_map(|id| scene.content(id));
        let largest = contents.max_by_key(|content| content.items().len());
        (name, Arc::clone(largest.expect("it has rooms")))
    })
}

/// What a test needs to know of an item's place, without the library's own arithmetic.
fn affine(transform: &Transform) -> DAffine3 {
    let [x, y, z, at] = transform
        .columns()
        .map(|column| DVec3::from(column.map(f64::from)));
    DAffine3 {
        matrix3: DMat3::from_cols(x, y, z),
        translation: at,
    }
}

/// The triangles of a mesh, each with its face.
fn triangles(mesh: &Mesh) -> impl Iterator<Item = (u32, [DVec3; 3])> {
    (0..mesh.face_count()).flat_map(move |face| {
        let corners = mesh.face(face);
        let corner = |i: usize| DVec3::from(mesh.positions()[corners[i] as usize].map(f64::from));
        (2..corners.len()).map(move |last| (face, [corner(0), corner(last - 1), corner(last)]))
    })
}
