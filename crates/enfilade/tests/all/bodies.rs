//! Bodies and cameras that move through portals: bodies are drawn whole in doorways, and no camera loses its sector.

use enfilade::laws::{OwnerPicture, Reference};
use enfilade::{
    ConvexPolygon, Geometry, GeometryBuilder, Limits, Location, Material, MaterialId, Mesh, Method,
    OpeningId, Scene, SceneBuilder, SectorId, Transform, View, Viewer,
};

/// Transform to the space of the other room, which has another origin and is rotated.
fn there_from_here() -> Transform {
    Transform::translation([40.0, 0.0, 7.0]) * Transform::rotation([0.0, 1.0, 0.0], 2.2)
}

const RADIUS: f32 = 0.4;

/// Builds a room: a floor and a back wall, the opening in front of them, and the bodies inside.
fn room(outline: &ConvexPolygon, here_from_first: Transform, depth: f32, bodies: &[[f32; 3]]) -> Geometry {
    let mut builder = GeometryBuilder::new([Material {
        double_sided: true,
        ..Material::opaque([0.6; 3])
    }]);
    let far = -4.0 + depth;
    let walls = [
        [-3.0, 0.0, -4.0],
        [3.0, 0.0, -4.0],
        [3.0, 0.0, far],
        [-3.0, 0.0, far],
        [-3.0, 3.0, far],
        [3.0, 3.0, far],
    ];
    let walls = Mesh::triangles(&walls, &[0, 1, 2, 0, 2, 3, 3, 2, 5, 3, 5, 4], MaterialId(0));
    let walls = builder.mesh(walls.expect("a floor and a wall"));
    builder.item("walls", walls, here_from_first);
    let [x, y, z] = [[RADIUS, 0.0, 0.0], [0.0, RADIUS, 0.0], [0.0, 0.0, RADIUS]];
    let minus = |point: [f32; 3]| point.map(|value| -value);
    let corners = [x, minus(x), y, minus(y), z, minus(z)];
    let faces = [
        0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5,
    ];
    let body = builder.mesh(Mesh::triangles(&corners, &faces, MaterialId(0)).expect("an octahedron"));
    for &at in bodies {
        builder.item("body", body, Transform::translation(at));
    }
    builder.opening("door", outline.clone());
    builder.build().expect("sound")
}

/// Two rooms joined by a door at z = -4, and a body placed in the sectors that [`Scene::body_sectors`] returns.
fn rooms(bodies: [&[[f32; 3]]; 2]) -> Scene {
    let door = ConvexPolygon::rectangle([-1.0, 0.0, -4.0], [2.0, 0.0, 0.0], [0.0, 2.5, 0.0]).expect("a door");
    let there = there_from_here();
    let corners: Vec<[f32; 3]> = door.flipped().corners().iter().map(|&c| there.point(c)).collect();
    let other = ConvexPolygon::new(&corners).expect("the same door, turned");
    let mut scene = SceneBuilder::new();
    let here = scene.add(
        "here",
        room(&door, Transform::IDENTITY, 6.0, bodies[0]),
        Method::HierarchicalZ,
    );
    let beyond = scene.add(
        "there",
        room(&other, there, -6.0, bodies[1]),
        Method::HierarchicalZ,
    );
    let door = OpeningId(0);
    scene.portal((here, door), (beyond, door), there).portal(
        (beyond, door),
        (here, door),
        there.inverse().expect("it is rigid"),
    );
    scene.build().expect("two rooms")
}

#[test]
fn a_body_in_a_doorway_is_seen_in_both_rooms() {
    let empty = rooms([&[], &[]]);
    let mut halves = 0;
    for z in [-3.2_f32, -3.7, -4.0, -4.3, -4.8] {
        let start = Location {
            sector: SectorId(0),
            position: [0.1, 1.2, -2.0],
        };
        let body = empty.walk(start, [0.0, 0.0, z + 2.0]).location;
        assert_eq!(body.sector.0, u32::from(z < -4.0));
        let present = empty.body_sectors(body, RADIUS);
        let in_doorway = (z + 4.0).abs() < RADIUS;
        assert_eq!(present.len(), 1 + usize::from(in_doorway), "at {z}");
        let mut bodies = [Vec::new(), Vec::new()];
        for presence in &present {
            bodies[presence.location.sector.0 as usize].push(presence.location.position);
        }
        let scene = rooms([&bodies[0], &bodies[1]]);
        let there = there_from_here();
        let [eye, toward] = [[0.4, 1.5, -8.5], [0.0, 1.2, -4.0]].map(|point| there.point(point));
        for (eye, toward) in [([0.4, 1.5, 1.2], [0.0, 1.2, -4.0]), (eye, toward)] {
            let mut view = View::new(eye, toward, [160, 120]);
            view.sector = Some(SectorId(u32::from(eye[0] > 20.0)));
            for method in Method::ALL
                .into_iter()
                .filter(|method| scene.suits(*method) && method.contract().never_misses())
            {
                let seen = scene.with_method(method, Method::DEFAULT_LIMIT).expect("small");
                let truth = Reference::new(&seen).see(&seen, &view, &Limits::default());
                let mut picture = OwnerPicture::new(view.size);
                let mut viewer = Viewer::new();
                viewer.draw(&seen, &view, &mut picture);
                let verdict = truth.check(viewer.visible(), Some(&picture));
                assert_eq!(
                    (verdict.missed.len(), verdict.pixels_different),
                    (0, 0),
                    "{method} at {z}"
                );
                let items = viewer.visible().items();
                let seen_in = |sector: u32| {
                    items.iter().any(|item| {
                        let at = viewer.visible().passage(item.passage).sector;
                        at.0 == sector && item.item.index.0 == 1
                    })
                };
                if in_doorway {
                    // Each room shows the half of the body on its side; the other half may be hidden.
                    let own = u32::from(eye[0] > 20.0);
                    assert!(
                        seen_in(own),
                        "{method}: nothing of the body is seen from {own}, at {z}"
                    );
                    halves += 1;
                } else {
                    assert!(seen_in(body.sector.0), "{method} at {z}");
                }
            }
        }
    }
    assert!(halves > 20);
}

#[test]
fn a_camera_on_a_boom_follows_its_player_through_a_portal() {
    let scene = rooms([&[], &[]]);
    let there = there_from_here();
    // Positions in the space of the first room; walls do not matter, only the door.
    let carried = |place: &Location| match place.sector.0 {
        0 => place.position,
        _ => there.inverse().expect("rigid").point(place.position),
    };
    let mut player = Location {
        sector: SectorId(0),
        position: [0.3, 1.2, 1.0],
    };
    let mut facing = [0.0, 0.0, -1.0_f32];
    let mut apart = 0;
    for frame in 0..140 {
        let step = scene.walk(player, facing.map(|value| 0.05 * value));
        player = step.location;
        facing = step.there_from_here.direction(facing);
        // The boom goes back and up from the player, also through the door behind the player.
        let boom = [-1.5 * facing[0], 0.4, -1.5 * facing[2]];
        let swung = scene.walk(player, boom);
        let camera = swung.location;
        let gaze = swung.there_from_here.direction(boom.map(|value| -value));
        // Brute force: the distance covered determines the room.
        let gone = 0.05 * (frame + 1) as f32;
        let expected = [1.0 - gone, 1.0 - gone + 1.5].map(|z| u32::from(z < -4.0));
        if [1.0 - gone, 2.5 - gone].iter().all(|z| (z + 4.0).abs() > 1e-3) {
            assert_eq!([player.sector.0, camera.sector.0], expected, "frame {frame}");
        }
        // The AABBs of the rooms are disjoint and determine it as well.
        for place in [player, camera] {
            let [x, y, z] = carried(&place);
            if (-2.9..2.9).contains(&x) && (0.1..2.9).contains(&y) && (z + 4.0).abs() > 1e-3 {
                let ahead = scene.locate(place.position, place.position.map(|value| value + 1.0));
                assert_eq!(ahead, Some(place.sector), "frame {frame}");
            }
        }
        apart += usize::from(player.sector != camera.sector);
        let [at, behind] = [carried(&player), carried(&camera)];
        let off = [
            at[0] - 0.3,
            at[1] - 1.2,
            at[2] - (1.0 - gone),
            behind[1] - 1.6,
            behind[2] - (2.5 - gone),
        ];
        assert!(
            off.iter().all(|value| value.abs() < 1e-4),
            "frame {frame}: {off:?}"
        );
        // Compare the camera's view with the reference.
        if frame % 20 == 0 || player.sector != camera.sector && frame % 5 == 0 {
            let toward = std::array::from_fn(|axis| camera.position[axis] + gaze[axis]);
            let mut view = View::new(camera.position, toward, [96, 72]);
            view.sector = Some(camera.sector);
            let truth = Reference::new(&scene).see(&scene, &view, &Limits::default());
            let mut picture = OwnerPicture::new(view.size);
            let mut viewer = Viewer::new();
            viewer.draw(&scene, &view, &mut picture);
            let verdict = truth.check(viewer.visible(), Some(&picture));
            assert!(verdict.reference_visible > 0);
            assert_eq!(
                (verdict.missed.len(), verdict.pixels_different),
                (0, 0),
                "frame {frame}"
            );
        }
    }
    assert!(
        apart > 25,
        "camera and player were in different rooms in only {apart} frames"
    );
}
