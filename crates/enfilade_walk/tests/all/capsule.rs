//! A moving capsule, compared with its distance to every face.

use crate::{CUBE_SIDES, affine, triangles};
use enfilade::{
    Aabb, ConvexPolygon, Geometry, GeometryBuilder, Location, Material, MaterialId, Mesh, Method, OpeningId,
    PortalId, Scene, SceneBuilder, SectorId, Transform,
};
use enfilade_scenes::{Random, built_in};
use enfilade_walk::Capsule;
use glam::DVec3;

fn block() -> Mesh {
    let unit = Aabb {
        min: [0.0; 3],
        max: [1.0; 3],
    };
    let faces = CUBE_SIDES.map(|[a, b, c, d]| [a, b, c, a, c, d]);
    Mesh::triangles(&unit.corners(), faces.as_flattened(), MaterialId(0)).expect("a cube")
}

/// Blocks, each given by its minimum corner, its sides and a rotation about y.
fn blocks(blocks: &[([f32; 3], [f32; 3], f64)]) -> Geometry {
    let mut builder = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    let mesh = builder.mesh(block());
    for &(at, sides, turn) in blocks {
        let turned = Transform::translation(at) * Transform::rotation([0.0, 1.0, 0.0], turn);
        builder.item("block", mesh, turned * Transform::scaling(sides));
    }
    builder.build().expect("sound")
}

/// A closed room, 10 × 4 × 10, with obstacles: pillars, ramp-like corners, a shelf that forces one to crouch, and a
/// narrowing wedge between two walls.
fn room() -> Scene {
    let geometry = blocks(&[
        ([0.0; 3], [10.0, 4.0, 10.0], 0.0),
        ([3.0, 0.0, 3.0], [1.0, 4.0, 1.0], 0.3),
        ([6.0, 0.0, 3.0], [0.1, 4.0, 3.0], 1.1),
        ([6.2, 0.0, 3.3], [0.1, 4.0, 3.0], 1.4),
        ([2.0, 0.0, 7.0], [2.0, 0.4, 2.0], 0.7),
        ([7.0, 2.2, 7.0], [2.0, 0.2, 2.0], 0.2),
        ([8.7, 0.0, 0.4], [0.001, 3.0, 2.0], 0.9),
    ]);
    let mut scene = SceneBuilder::new();
    scene.add("room", geometry, Method::ZBuffer);
    scene.build().expect("a room")
}

/// Returns the faces of a geometry in sector space.
fn faces(geometry: &Geometry) -> Vec<[DVec3; 3]> {
    let items = (0..geometry.items().len() as u32).map(enfilade::ItemIndex);
    items
        .flat_map(|item| {
            let placed = affine(&geometry.item(item).transform());
            let place =
                move |(_, corners): (u32, [DVec3; 3])| corners.map(|corner| placed.transform_point3(corner));
            triangles(geometry.mesh_of(item)).map(place)
        })
        .collect()
}

/// Returns the distance from a point to a triangle by descent: not the library's algorithm.
fn point_off(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let inside = |at: DVec3| {
        [(a, b), (b, c), (c, a)]
            .iter()
            .all(|&(p, q)| normal.dot((q - p).cross(at - p)) >= 0.0)
    };
    let height = normal.dot(point - a);
    if normal != DVec3::ZERO && inside(point - normal * height) {
        return height.abs();
    }
    let edge = |p: DVec3, q: DVec3| {
        let along = ((point - p).dot(q - p) / (q - p).length_squared()).clamp(0.0, 1.0);
        point.distance(p + (q - p) * along)
    };
    edge(a, b).min(edge(b, c)).min(edge(c, a))
}

/// Returns the distance from a segment to a triangle by ternary search; it is convex along the segment.
fn off([from, to]: [DVec3; 2], triangle: [DVec3; 3]) -> f64 {
    let at = |part: f64| point_off(from.lerp(to, part), triangle);
    let [mut low, mut high] = [0.0, 1.0];
    for _ in 0..60 {
        let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if at(a) < at(b) { high = b } else { low = a }
    }
    at(0.5 * (low + high)).min(at(0.0)).min(at(1.0))
}

fn axis(place: &Location, capsule: &Capsule) -> [DVec3; 2] {
    let middle = DVec3::from(place.position.map(f64::from));
    let up = DVec3::from(capsule.up.map(f64::from)).normalize();
    let half = (0.5 * f64::from(capsule.height) - f64::from(capsule.radius)).max(0.0);
    [middle - up * half, middle + up * half]
}

/// Walks randomly. Returns the number of contacts and the total distance.
fn walk(
    scene: &Scene,
    from: Location,
    capsule: Capsule,
    steps: usize,
    longest: f32,
    seed: u64,
) -> (usize, f64) {
    let mut chance = Random::new(seed);
    let mut place = from;
    let mut course = chance.point(1.0);
    let (mut touched, mut length) = (0, 0.0);
    let all = faces(scene.geometry(from.sector).expect("ours"));
    for step in 0..steps {
        if step % 7 == 0 {
            course = chance.point(1.0).map(|value| value * longest);
        }
        let slid = capsule.slide(scene, place, course);
        assert!(
            slid.complete && slid.crossed.is_empty(),
            "step {step}: {course:?} from {place:?}: {slid:?}"
        );
        assert!(slid.location.position.iter().all(|value| value.is_finite()));
        let went = [0, 1, 2].map(|a| f64::from(slid.location.position[a]) - f64::from(place.position[a]));
        let went = DVec3::from(went).length();
        assert!(
            went <= f64::from(longest) * 1.74 + 1e-3,
            "step {step} went {went}"
        );
        touched += usize::from(!slid.touched.is_empty());
        length += went;
        let before = place;
        place = slid.location;
        let axis = axis(&place, &capsule);
        let reach = f64::from(capsule.radius) * 0.999;
        let [min, max] = [axis[0].min(axis[1]) - reach, axis[0].max(axis[1]) + reach];
        for &triangle in &all {
            let [a, b, c] = triangle;
            let near = a.min(b).min(c).cmple(max).all() && a.max(b).max(c).cmpge(min).all();
            assert!(
                !near || off(axis, triangle) >= reach,
                "step {step}: {course:?} from {before:?} to {place:?} ends {} from {triangle:?}",
                off(axis, triangle)
            );
        }
        let middle = place.position;
        assert!(
            (0.0..10.0).contains(&middle[0])
                && (0.0..4.0).contains(&middle[1])
                && (0.0..10.0).contains(&middle[2])
        );
    }
    (touched, length)
}

#[test]
fn a_hundred_thousand_steps_in_a_closed_room_never_lead_into_a_wall() {
    let scene = room();
    let from = Location {
        sector: SectorId(0),
        position: [5.0, 1.5, 1.5],
    };
    for (number, (capsule, longest)) in (0..).zip([
        (Capsule::new(0.3, 1.8), 0.2),
        (Capsule::new(0.3, 1.8), 5.0),
        (Capsule::new(0.1, 0.2), 0.1),
        (Capsule::new(0.1, 0.0), 30.0),
        (Capsule::new(0.5, 1.2), 1.0),
    ]) {
        let (touched, length) = walk(&scene, from, capsule, 20_000, longest, number);
        assert!(
            touched > 2000 && length > 1000.0 * f64::from(longest).min(1.0),
            "{touched} touched, {length} gone"
        );
    }
}

#[test]
fn it_slides_along_a_wall_into_a_corner_and_stands_on_the_floor() {
    let scene = room();
    let from = Location {
        sector: SectorId(0),
        position: [1.0, 1.5, 5.0],
    };
    let capsule = Capsule::new(0.3, 1.8);
    let slid = capsule.slide(&scene, from, [-3.0, -3.0, 1.0]);
    let [x, y, z] = slid.location.position;
    assert!(
        (x - 0.3).abs() < 1e-3 && (y - 0.9).abs() < 1e-3 && (z - 6.0).abs() < 1e-3,
        "{slid:?}"
    );
    assert!(slid.on_ground);
    let mut normals = slid.touched;
    normals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let normals: Vec<_> = normals
        .iter()
        .map(|normal| normal.map(|part| part.round()))
        .collect();
    assert_eq!(normals, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
    let slid = capsule.slide(&scene, slid.location, [-3.0, 1.0, -30.0]);
    let [x, y, z] = slid.location.position;
    assert!(
        (x - 0.3).abs() < 2e-3 && (y - 1.9).abs() < 1e-3 && (z - 0.3).abs() < 1e-3,
        "{slid:?}"
    );
    assert!(!slid.on_ground);
}

#[test]
fn it_climbs_steps_that_are_low_enough_and_no_higher_ones() {
    for (rise, climb, up) in [(0.2, 0.3, true), (0.4, 0.3, false), (0.35, 0.0, false)] {
        let stairs: Vec<([f32; 3], [f32; 3], f64)> = (0..6_u8)
            .map(|step| {
                (
                    [2.0 + 0.4 * f32::from(step), 0.0, -2.0],
                    [0.4, 0.01 + rise * f32::from(step + 1), 4.0],
                    0.0,
                )
            })
            .chain([([-5.0, -1.0, -5.0], [20.0, 1.0, 10.0], 0.0)])
            .collect();
        let mut scene = SceneBuilder::new();
        scene.add("stairs", blocks(&stairs), Method::ZBuffer);
        let scene = scene.build().expect("stairs");
        let mut capsule = Capsule::new(0.3, 1.8);
        capsule.climb = climb;
        let mut place = Location {
            sector: SectorId(0),
            position: [0.0, 0.95, 0.0],
        };
        for _ in 0..40 {
            place = capsule.slide(&scene, place, [0.1, -0.02, 0.01]).location;
        }
        let risen = place.position[1] - 0.9;
        assert_eq!(
            risen > 4.0 * rise,
            up,
            "climbing {climb} up steps of {rise} leads to {place:?}"
        );
        assert!(up || place.position[0] < 2.0);
    }
}

#[test]
fn it_walks_through_the_doors_of_a_palace_and_nowhere_else() {
    let built = built_in("enfilade").expect("it is built in");
    let scene = built.scene;
    let mut crossings = 0;
    for (camera, seed) in built.cameras.iter().zip(0..) {
        let sector = scene.locate(camera.eye, camera.toward).expect("a room");
        let mut place = Location {
            sector,
            position: camera.eye,
        };
        let mut capsule = Capsule::new(0.2, 0.5);
        let mut chance = Random::new(seed);
        let mut course = [0.0; 3];
        for step in 0..400 {
            if step % 20 == 0 {
                course = chance.point(1.0).map(|value| 0.3 * value);
                course[1] *= 0.1;
            }
            let slid = capsule.slide(&scene, place, course);
            crossings += slid.crossed.len();
            course = slid.there_from_here.direction(course);
            // Like a ray from centre to centre: no wall is between them.
            let walked = scene.walk(
                place,
                [0, 1, 2].map(|a| slid.location.position[a] - place.position[a]),
            );
            if slid.crossed.is_empty() {
                assert!(
                    walked.crossed.is_empty() || slid.touched.len() > 1,
                    "step {step} from {place:?}: {slid:?}"
                );
            }
            (place, capsule) = (slid.location, slid.capsule);
            assert!(place.position.iter().all(|value| value.is_finite()));
        }
    }
    assert!(crossings > 30, "only {crossings} doors were gone through");
}

#[test]
fn what_is_no_step_or_no_capsule_goes_nowhere() {
    let scene = room();
    let from = Location {
        sector: SectorId(0),
        position: [5.0, 1.5, 1.5],
    };
    let sound = Capsule::new(0.3, 1.8);
    let mut lying = sound;
    lying.up = [0.0; 3];
    for (capsule, step) in [
        (sound, [f32::NAN, 0.0, 0.0]),
        (sound, [f32::INFINITY, 0.0, 0.0]),
        (Capsule::new(0.0, 1.0), [1.0; 3]),
        (Capsule::new(-1.0, 1.0), [1.0; 3]),
        (Capsule::new(f32::NAN, 1.0), [1.0; 3]),
        (lying, [1.0; 3]),
    ] {
        let slid = capsule.slide(&scene, from, step);
        assert_eq!((slid.location, slid.touched.len()), (from, 0));
    }
    let still = sound.slide(&scene, from, [0.0; 3]);
    assert_eq!(still.location, from);
    // If it starts in a wall, it is pushed out.
    let inside = Location {
        position: [0.1, 1.5, 5.0],
        ..from
    };
    let pushed = sound.slide(&scene, inside, [0.0; 3]).location.position;
    assert!((pushed[0] - 0.3).abs() < 1e-3, "{pushed:?}");
    // A step longer than the maximum: it is reported, or a wall stops it.
    let far = sound.slide(&scene, from, [3e30, 0.0, 0.0]);
    assert!(far.location.position[0] < 9.8);
}

/// Two rooms joined by a door at z = 0, x = -1 to 1: the room on this side, with `here` in it, and the one beyond.
fn two_rooms(here: [f32; 3], there: [f32; 3]) -> Scene {
    let door = ConvexPolygon::rectangle([-1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.5, 0.0]).expect("a door");
    let room = |thing: [f32; 3], outline: ConvexPolygon| {
        let mut builder = GeometryBuilder::new([Material::opaque([0.5; 3])]);
        let mesh = builder.mesh(block());
        let mut add = |at: [f32; 3], sides: [f32; 3]| {
            builder.item(
                "block",
                mesh,
                Transform::translation(at) * Transform::scaling(sides),
            );
        };
        add([-6.0, 0.0, 0.0], [5.0, 3.0, 0.0]);
        add([1.0, 0.0, 0.0], [5.0, 3.0, 0.0]);
        add([-6.0, -1.0, -6.0], [12.0, 1.0, 12.0]);
        add(thing, [0.5; 3]);
        builder.opening("door", outline);
        builder.build().expect("sound")
    };
    let mut scene = SceneBuilder::new();
    let here = scene.add("here", room(here, door.clone()), Method::ZBuffer);
    let there = scene.add("there", room(there, door.flipped()), Method::ZBuffer);
    scene.door((here, OpeningId(0)), (there, OpeningId(0)));
    scene.build().expect("two rooms")
}

#[test]
fn in_a_doorway_it_is_stopped_by_what_stands_beyond_and_not_by_what_lies_there_in_its_own_room() {
    const AWAY: [f32; 3] = [4.0, 0.0, 5.0];
    let from = Location {
        sector: SectorId(0),
        position: [0.0, 0.95, 1.0],
    };
    let capsule = Capsule::new(0.3, 1.8);
    // An obstacle of this room behind its own door is not in the room beyond.
    for behind in [[-0.2, 0.0, -1.0], [-0.2, 0.0, -0.6]] {
        let slid = capsule.slide(&two_rooms(behind, AWAY), from, [0.0, 0.0, -3.0]);
        assert_eq!((slid.location.sector, slid.crossed.len()), (SectorId(1), 1));
        assert!(
            (slid.location.position[2] + 2.0).abs() < 1e-3 && slid.touched.is_empty(),
            "{slid:?}"
        );
        // An obstacle in the other room counts, before and after the capsule's centre has passed the door.
        let slid = capsule.slide(&two_rooms(AWAY, behind), from, [0.0, 0.0, -3.0]);
        let stopped = behind[2] + 0.5 + 0.3;
        assert!((slid.location.position[2] - stopped).abs() < 1e-3, "{slid:?}");
        assert_eq!(slid.location.sector.0, u32::from(stopped < 0.0));
    }
    // The door posts block from both sides.
    for (x, through) in [(0.6, true), (0.8, false)] {
        let scene = two_rooms(AWAY, AWAY);
        let position = [x, 0.95, 1.0];
        let course = [0.0, 0.0, -1.0];
        let slid = capsule.slide(&scene, Location { position, ..from }, course);
        assert_eq!(slid.touched.is_empty(), through, "{slid:?}");
    }
    let mut scene = two_rooms(AWAY, AWAY);
    scene.set_open(PortalId(0), false);
    let slid = capsule.slide(&scene, from, [0.0, 0.0, -3.0]);
    assert!((slid.location.position[2] - 0.3).abs() < 1e-3 && slid.crossed.is_empty());
}
