//! Limits of one look or query: they match the docs and are reported when reached.

use enfilade::laws::{OwnerPicture, Reference};
use enfilade::{
    ConvexPolygon, GeometryBuilder, GeometryError, HeightField, HeightFieldError, ItemLabel, Light, Limits,
    Location, MAX_COORDINATE, Material, MaterialId, Mesh, MeshError, Method, MoveResult, PortalId, Ray,
    RayCast, RayEnd, Scene, SceneBuilder, SceneError, SectorId, Transform, View, ViewError, Viewer,
    geom::PolygonError,
};
use enfilade_walk::Capsule;

/// A room whose opening fills the view and shows the room itself from the same eye, slightly smaller, so the opening
/// behind it fills the view too, at any recursion depth.
fn endless() -> Scene {
    let mut room = GeometryBuilder::new([Material {
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
    view.sector = Some(SectorId(0));
    view.near = 1e-6;
    let scene = endless();
    let truth = Reference::new(&scene).see(&scene, &view, &limits);
    for method in [Method::HierarchicalZ, Method::Masked] {
        let scene = scene.with_method(method, Method::DEFAULT_LIMIT).expect("small");
        let mut viewer = Viewer::new();
        viewer.options.limits = limits;
        viewer.look(&scene, &view);
        let mut picture = OwnerPicture::new(view.size);
        let set = viewer.draw(&scene, &view, &mut picture);
        let deepest = set.passages().last().map(|passage| passage.crossings);
        assert_eq!(deepest, Some(u16::MAX), "{method}");
        assert!(!set.complete());
        let verdict = truth.check(set, Some(&picture));
        assert_eq!(
            (verdict.missed.len(), verdict.pixels_different),
            (0, 0),
            "{method}"
        );
    }
}

#[test]
fn the_set_of_a_view_that_cannot_be_looked_at_is_empty_and_not_complete() {
    let room = GeometryBuilder::new([]).build().expect("sound");
    let scene = Scene::single(room, Method::ZBuffer).expect("small");
    let sound = View::new([0.0; 3], [0.0, 0.0, -1.0], [8, 6]);
    let mut wide = sound;
    wide.fov_y = 4.0;
    let mut elsewhere = sound;
    elsewhere.sector = Some(SectorId(1));
    let mut viewer = Viewer::new();
    assert!(!viewer.visible().complete(), "before the first look");
    for (view, complete) in [(sound, true), (wide, false), (elsewhere, false), (sound, true)] {
        let mut picture = OwnerPicture::new(view.size);
        for draws in [false, true] {
            let set = if draws {
                viewer.draw(&scene, &view, &mut picture)
            } else {
                viewer.look(&scene, &view)
            };
            assert_eq!(
                (set.complete(), set.passages().len()),
                (complete, usize::from(complete)),
                "{view:?}"
            );
        }
    }
}

/// A room without walls whose only opening leads from x = 10 back to x = -10, scaled.
fn loop_of(scale: f32) -> Scene {
    let mut room = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    let outline = [
        [10.0, -5.0, 5.0],
        [10.0, -5.0, -5.0],
        [10.0, 5.0, -5.0],
        [10.0, 5.0, 5.0],
    ];
    let outline = outline
        .map(|corner: [f32; 3]| corner.map(|value| value * if value.abs() < 10.0 { 1e3 } else { 1.0 }));
    let opening = room.opening("out", ConvexPolygon::new(&outline).expect("a square").flipped());
    let mut scene = SceneBuilder::new();
    let room = scene.add("room", room.build().expect("sound"), Method::HierarchicalZ);
    let about = Transform::translation([-10.0, 0.0, 0.0]);
    let there = about * Transform::scaling([scale; 3]) * about;
    scene.portal((room, opening), room, there);
    scene.build().expect("one room")
}

const START: Location = Location {
    sector: SectorId(0),
    position: [0.0; 3],
};

#[test]
fn a_walk_through_a_teleport_that_enlarges_ends_at_a_place_and_reports_that_it_was_cut_short() {
    // Each round starts at -10 or closer to the opening, and is `scale` times as long as the one before.
    for scale in [1.1, 2.0, 1e3, 1e6] {
        let scene = loop_of(scale);
        let walked = scene.walk(START, [1e5, 0.0, 0.0]);
        let is_place = |at: [f32; 3]| at.iter().all(|value| value.abs() <= MAX_COORDINATE);
        assert!(
            is_place(walked.location.position),
            "scale {scale}: {:?}",
            walked.location
        );
        assert!(!walked.complete, "scale {scale}");
        assert!(!walked.crossed.is_empty() && walked.crossed.len() <= MoveResult::MAX_CROSSED);
        let slid = Capsule::new(0.3, 1.8).slide(&scene, START, [1e5, 0.0, 0.0]);
        assert!(
            is_place(slid.location.position),
            "scale {scale}: {:?}",
            slid.location
        );
        for presence in scene.body_sectors(
            Location {
                position: [9.9, 0.0, 0.0],
                ..START
            },
            1e4,
        ) {
            assert!(is_place(presence.location.position));
        }
    }
}

#[test]
fn a_ray_through_a_teleport_that_scales_again_and_again_ends_at_a_limit() {
    for scale in [1e-6, 1e-2, 1.0, 1e2, 1e6] {
        let ray = Ray {
            origin: [0.0; 3],
            direction: [1.0, 0.0, 0.0],
        };
        let cast = loop_of(scale).cast(SectorId(0), &ray);
        assert!(
            matches!(cast.end, RayEnd::Limit(_)),
            "scale {scale}: {:?}",
            cast.end
        );
        assert!(!cast.crossed.is_empty() && cast.crossed.len() <= RayCast::MAX_CROSSED);
        assert!(cast.there_from_here.is_finite());
    }
}

#[test]
fn what_a_lamp_reaches_has_numbers_however_portals_scale() {
    for scale in [1e-6, 1e6] {
        let scene = loop_of(scale);
        let mut limits = Limits::default();
        limits.max_crossings = 1000;
        for reached in scene.reach(START, f32::INFINITY, &limits) {
            assert!(reached.there_from_here.is_finite());
            assert!(reached.origin.iter().all(|value| value.is_finite()));
        }
        let nowhere = Location {
            position: [f32::NAN; 3],
            ..START
        };
        assert_eq!(scene.reach(nowhere, 1.0, &limits).len(), 1);
        assert_eq!(scene.sees(nowhere, START), None);
        assert_eq!(scene.sees(START, nowhere), None);
    }
}

#[test]
fn coordinates_beyond_the_bound_are_refused_wherever_they_come_in() {
    let far = 2.0 * MAX_COORDINATE;
    let triangle = |x: f32| {
        Mesh::triangles(
            &[[0.0; 3], [x, 0.0, 0.0], [0.0, 1.0, 0.0]],
            &[0, 1, 2],
            MaterialId(0),
        )
    };
    let position = MeshError::TooFar { part: 0, position: 1 };
    assert_eq!(triangle(far).err(), Some(position));
    assert_eq!(
        ConvexPolygon::rectangle([far, 0.0, 0.0], [1e9, 0.0, 0.0], [0.0, 1e9, 0.0]).err(),
        Some(PolygonError::TooFar(0))
    );

    // An item whose transform alone, or only together with its mesh, exceeds the range.
    for (x, at) in [
        (1.0, Transform::translation([0.0, -far, 0.0])),
        (
            0.8 * MAX_COORDINATE,
            Transform::translation([0.4 * MAX_COORDINATE, 0.0, 0.0]),
        ),
        (1e7, Transform::scaling([1e7; 3])),
    ] {
        let mut room = GeometryBuilder::new([Material::opaque([0.5; 3])]);
        let mesh = room.mesh(triangle(x).expect("in range"));
        room.item("beacon", mesh, at);
        let label = ItemLabel {
            name: "beacon".to_owned(),
            key: 0,
        };
        assert_eq!(room.build().err(), Some(GeometryError::TooFar(label)));
    }

    let mut scene = loop_of(2.0);
    let leads =
        |scale: f32, shift: f32| Transform::translation([shift, 0.0, 0.0]) * Transform::scaling([scale; 3]);
    for map in [leads(1.0, far), leads(1e12, 0.0)] {
        assert_eq!(scene.set_portal(PortalId(0), map), Err(SceneError::TooFar(0)));
    }
    let mut builder = SceneBuilder::new();
    let nested = builder.nest(&scene);
    assert!(builder.build().is_ok(), "{nested:?}");
    let light = Light::point(SectorId(0), [0.0, far, 0.0], [1.0; 3], 1.0);
    assert_eq!(scene.add_light(light), Err(SceneError::BadLight(0)));

    let view = View::new([far, 0.0, 0.0], [0.0; 3], [8, 8]);
    assert_eq!(view.check(), Err(ViewError::TooFar("the eye")));
    let view = View::new([0.0; 3], [far, 0.0, 0.0], [8, 8]);
    assert_eq!(view.check(), Err(ViewError::TooFar("the target point")));

    let high = HeightField::new([2, 2], [1.0; 2], [0.0, 0.0, far, 0.0]);
    let height = HeightFieldError::TooFar {
        column: 0,
        row: 1,
        height: far,
    };
    assert_eq!(high.err(), Some(height));
    let wide = HeightField::new([3, 2], [0.6e12, 1.0], [0.0; 6]);
    assert_eq!(wide.err(), Some(HeightFieldError::Cell([0.6e12, 1.0])));
    let lines = HeightField::on_lines([0.0, far], [0.0, 1.0], [0.0; 4]);
    assert!(matches!(
        lines.err(),
        Some(HeightFieldError::Line { number: 1, .. })
    ));
}
