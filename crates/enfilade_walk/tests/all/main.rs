//! Moving capsules and overlapping boxes, compared with brute force.

mod capsule;
mod pairs;

use enfilade::{Mesh, Transform};
use glam::{DAffine3, DMat3, DVec3};

/// Corners of the sides of a box, counter-clockwise from outside; bit 0 of a corner's index selects its x, and so on.
const CUBE_SIDES: [[u32; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

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
