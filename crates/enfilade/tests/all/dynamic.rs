//! Moving items in a separate sector; other sectors stay unchanged.

use enfilade::laws::{OwnerPicture, Reference};
use enfilade::{
    ConvexPolygon, Geometry, GeometryBuilder, Limits, Material, MaterialId, Mesh, Method, Scene,
    SceneBuilder, SceneError, SectorId, Transform, View, Viewer,
};

const DOOR: [f32; 3] = [-1.0, 0.0, -4.0];

fn door() -> ConvexPolygon {
    ConvexPolygon::rectangle(DOOR, [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]).expect("a door")
}

fn leaves(builder: &mut GeometryBuilder, places: impl IntoIterator<Item = [f32; 3]>) {
    let corners = [[-0.3, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.6, 0.0]];
    let leaf = builder.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("a leaf"));
    for place in places {
        builder.item("leaf", leaf, Transform::translation(place));
    }
}

fn geometry(opening: ConvexPolygon, places: impl IntoIterator<Item = [f32; 3]>) -> Geometry {
    let mut builder = GeometryBuilder::new([Material {
        double_sided: true,
        ..Material::opaque([0.5; 3])
    }]);
    leaves(&mut builder, places);
    builder.opening("door", opening);
    builder.build().expect("sound")
}

/// Leaves behind the door, at other positions in every frame.
fn swarm(moment: u32, count: u32) -> Geometry {
    let place = |i: u32| {
        let phase = (i * 7 + moment) as f32 * 0.37;
        [1.5 * phase.sin(), 1.0 + phase.cos(), -5.0 - 0.1 * i as f32]
    };
    geometry(door().flipped(), (0..count).map(place))
}

fn garden(method: Method) -> (Scene, [SectorId; 2]) {
    let mut scene = SceneBuilder::new();
    let room = scene.add(
        "room",
        geometry(door(), [[0.5, 0.5, -2.0]]),
        Method::HierarchicalZ,
    );
    let swarm = scene.add("swarm", swarm(0, 30), method);
    let opening = enfilade::OpeningId(0);
    scene.door((room, opening), (swarm, opening));
    (scene.build().expect("a garden"), [room, swarm])
}

#[test]
fn a_swarm_moves_every_frame_and_nothing_else_is_built() {
    let view = View::new([0.2, 1.0, 0.0], [0.0, 1.0, -4.0], [96, 72]).expect("a valid view");
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let (mut scene, [room, moving]) = garden(method);
        let mut viewer = Viewer::new();
        let mut seen = 0;
        for moment in 1..=20 {
            // Sometimes only few remain: items remembered from the last look must not be accessed.
            let count = if moment % 3 == 0 { 2 } else { 30 };
            scene.set_geometry(moving, swarm(moment, count)).expect("it fits");
            let truth = Reference::new(&scene).see(&scene, &view, &Limits::default());
            viewer.look(&scene, &view);
            let looked = truth.check(viewer.visible(), None);
            let mut picture = OwnerPicture::new(view.size());
            viewer.draw(&scene, &view, &mut picture);
            let drawn = truth.check(viewer.visible(), Some(&picture));
            seen += drawn.reference_visible;
            if method.contract().never_misses() {
                assert_eq!(
                    (looked.missed, drawn.missed),
                    (Vec::new(), Vec::new()),
                    "{method}"
                );
                assert_eq!(drawn.pixels_different, 0, "{method}");
            }
        }
        assert!(seen > 100, "{method}: only {seen} are seen");
        assert_eq!([scene.builds(room), scene.builds(moving)], [1, 21], "{method}");
    }
}

#[test]
fn what_cannot_replace_a_geometry_is_refused_and_leaves_it_as_it_was() {
    let (mut scene, [_, moving]) = garden(Method::ZBuffer);
    let before = scene.geometry(moving).expect("ours").clone();
    let closed = GeometryBuilder::new([Material::opaque([1.0; 3])])
        .build()
        .expect("nothing");
    let refused = scene.set_geometry(moving, closed).expect_err("it has no opening");
    assert!(
        matches!(refused, SceneError::Openings { had: 1, has: 0, .. }),
        "{refused}"
    );
    assert!(std::sync::Arc::ptr_eq(
        &before,
        scene.geometry(moving).expect("ours")
    ));
    let sheared = Transform::from_columns([[1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]);
    let refused = scene
        .set_portal(enfilade::PortalId(0), sheared)
        .expect_err("it shears");
    assert!(matches!(refused, SceneError::NotSimilar(0)), "{refused}");
    assert_eq!(scene.portals()[0].there_from_here, Transform::IDENTITY);
}

#[test]
fn a_carriage_moves_as_a_whole_where_its_portals_are_moved() {
    let (mut scene, [_, moving]) = garden(Method::SBuffer);
    let view = View::new([0.2, 1.0, 0.0], [0.0, 1.0, -4.0], [96, 72]).expect("a valid view");
    for shift in [0.0, 0.4, -1.3] {
        let there = Transform::translation([shift, 0.0, 0.1 * shift]);
        for (number, way) in [(0, Some(there)), (1, there.inverse())] {
            let way = way.expect("a shift can be undone");
            scene.set_portal(enfilade::PortalId(number), way).expect("rigid");
        }
        let truth = Reference::new(&scene).see(&scene, &view, &Limits::default());
        let mut picture = OwnerPicture::new(view.size());
        let mut viewer = Viewer::new();
        viewer.draw(&scene, &view, &mut picture);
        let verdict = truth.check(viewer.visible(), Some(&picture));
        assert!(verdict.reference_visible > 1);
        assert_eq!((verdict.missed.len(), verdict.pixels_different), (0, 0));
    }
    assert_eq!(scene.builds(moving), 1);
}

#[test]
fn a_view_that_names_its_sector_stands_in_that_one() {
    let (scene, [room, moving]) = garden(Method::ZBuffer);
    let mut view = View::new([0.2, 1.0, -4.5], [0.0, 1.0, -9.0], [96, 72]).expect("a valid view");
    let mut viewer = Viewer::new();
    for id in [room, moving] {
        view.sector = Some(id);
        assert_eq!(viewer.look(&scene, &view).passages()[0].sector, id);
    }
    view.sector = Some(SectorId(9));
    assert!(viewer.look(&scene, &view).passages().is_empty());
}
