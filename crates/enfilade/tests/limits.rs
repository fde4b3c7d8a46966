//! Limits of what one look or one query does: as large as the docs say, and reported where they are reached.

use enfilade::laws::{OwnerPicture, Reference};
use enfilade::{
    ContentBuilder, ConvexPolygon, FragmentId, Limits, Material, MaterialId, Mesh, Method, Scene,
    SceneBuilder, Transform, View, Viewer,
};

/// A room whose opening fills the view, and shows the room itself from the same eye, a little smaller: so the opening
/// behind the opening fills the view too, however many are followed.
fn endless() -> Scene {
    let mut room = ContentBuilder::new([Material {
        double_sided: true,
        ..Material::opaque([0.5; 3])
    }]);
    let leaf = [
        [-0.3, -0.1, -0.99995],
        [0.3, -0.1, -0.99995],
        [0.0, 0.3, -0.99995],
    ];
    let leaf = room.mesh(Mesh::triangles(&leaf, &[0, 1, 2], MaterialId(0)).expect("a triangle"));
    room.item("leaf", leaf, Transform::IDENTITY);
    let outline = ConvexPolygon::rectangle([-4.0, -4.0, -1.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]);
    let opening = room.opening("out", outline.expect("a square"));
    let mut scene = SceneBuilder::new();
    let room = scene.add("room", room.build().expect("sound"), Method::HierarchicalZ);
    scene.portal((room, opening), room, Transform::scaling([0.9999; 3]));
    scene.build().expect("one room")
}

#[test]
fn as_many_portals_in_a_row_are_followed_as_the_limits_allow() {
    let mut limits = Limits::default();
    limits.max_crossings = u16::MAX;
    let mut view = View::new([0.0; 3], [0.0, 0.0, -1.0], [8, 6]);
    view.fragment = Some(FragmentId(0));
    view.near = 1e-6;
    let scene = endless();
    for method in [Method::HierarchicalZ, Method::Masked] {
        let scene = scene.with_method(method, Method::DEFAULT_LIMIT).expect("small");
        let mut viewer = Viewer::new();
        viewer.set_limits(limits);
        viewer.look(&scene, &view);
        let mut picture = OwnerPicture::new(view.size);
        let set = viewer.draw(&scene, &view, &mut picture);
        let deepest = set.passages().last().map(|passage| passage.crossings);
        assert_eq!(deepest, Some(u16::MAX), "{method}");
        assert!(!set.complete());
    }
    let truth = Reference::new(&scene).see(&scene, &view, &limits);
    assert!(!truth.visible().is_empty());
}
