//! Rooms with many mirrors.

use enfilade::{
    ConvexPolygon, GeometryBuilder, Material, MaterialId, Mesh, Method, Scene, SceneBuilder, Transform,
};

/// A wall of a hundred mirrors in front of the eye, and items visible in them.
pub(crate) fn hundred_mirrors() -> Scene {
    let mut stone = Material::opaque([0.6; 3]);
    stone.double_sided = true;
    let mut room = GeometryBuilder::new([stone]);
    let corners = [[-0.3, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.6, 0.0]];
    let leaf = room.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("a triangle"));
    for (x, y, z) in grid().map(|(x, y)| (x, y, 2.0 + 0.3 * (x + y))) {
        room.item("leaf", leaf, Transform::translation([x, y, z]));
    }
    let mirrors: Vec<_> = grid()
        .map(|(x, y)| {
            let glass = ConvexPolygon::rectangle([x - 0.45, y, -4.0], [0.9, 0.0, 0.0], [0.0, 0.4, 0.0]);
            room.opening("mirror", glass.expect("a rectangle"))
        })
        .collect();
    let mut scene = SceneBuilder::new();
    let room = scene.add("room", room.build().expect("a room"), Method::ZBuffer);
    for mirror in mirrors {
        scene.mirror(room, mirror);
    }
    scene.build().expect("a hall of mirrors")
}

/// Returns 10 × 10 positions (x, y), one metre apart in x and half a metre in y.
fn grid() -> impl Iterator<Item = (f32, f32)> {
    (0..100_u8).map(|i| (f32::from(i % 10) - 4.5, 0.5 * f32::from(i / 10) - 2.5))
}
