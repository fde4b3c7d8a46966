//! Materials marked as detail are never occluders in methods that select occluders.

use enfilade::{
    Contract, GeometryBuilder, Material, MaterialId, Mesh, Method, SceneBuilder, Transform, View, Viewer,
};

/// Returns the number of visible items of a wall and an item behind it.
fn seen(method: Method, detail: bool, cover_size: Option<[u32; 2]>) -> usize {
    let wall = Material {
        detail,
        ..Material::opaque([0.6; 3])
    };
    let mut geometry = GeometryBuilder::new([wall, Material::opaque([0.2; 3])]);
    let corners = [
        [-9.0, -9.0, 0.0],
        [9.0, -9.0, 0.0],
        [9.0, 9.0, 0.0],
        [-9.0, 9.0, 0.0],
    ];
    for (name, material, at, size) in [("wall", 0, [0.0; 3], 1.0), ("thing", 1, [0.0, 0.0, -5.0], 0.05)] {
        let mesh = Mesh::triangles(&corners, &[0, 1, 2, 0, 2, 3], MaterialId(material));
        let mesh = geometry.mesh(mesh.expect("a square"));
        let place = Transform::translation(at) * Transform::scaling([size; 3]);
        geometry.item(name, mesh, place);
    }
    let mut scene = SceneBuilder::new();
    scene.add("world", geometry.build().expect("sound items"), method);
    let scene = scene.build().expect("one sector");
    let mut viewer = Viewer::new();
    viewer.options.cover_size = cover_size;
    let view = View::new([0.0, 0.0, 5.0], [0.0; 3], [64, 48]).expect("a valid view");
    viewer.look(&scene, &view).items().len()
}

#[test]
fn a_wall_marked_as_detail_hides_only_where_nothing_is_chosen() {
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        match method.contract() {
            Contract::Exact => assert_eq!(
                [seen(method, true, None), seen(method, false, None)],
                [1, 1],
                "{method}"
            ),
            Contract::Approximate => {}
            _ => assert_eq!(
                [seen(method, true, None), seen(method, false, None)],
                [2, 1],
                "{method}"
            ),
        }
        if method.takes_cover_size() {
            let cells = Some([32, 24]);
            assert_eq!(
                [seen(method, true, cells), seen(method, false, cells)],
                [2, 1],
                "{method} in cells"
            );
        }
    }
}
