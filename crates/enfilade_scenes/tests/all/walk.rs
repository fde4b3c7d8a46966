//! Random walks through the built-in scenes: no body leaks through an edge or a corner, and its sector stays correct.

use enfilade::{Location, Ray, Scene, SectorId, Transform};
use enfilade_scenes::{BuiltIn, Random, built_in};

/// Returns the sectors whose bounds contain a position, within a small tolerance, without using portals.
fn holders(scene: &Scene, position: [f32; 3]) -> Vec<SectorId> {
    const HAIR: f32 = 1e-3;
    let holds = |&id: &SectorId| {
        let bounds = scene.bounds(id);
        (0..3).all(|a| bounds.min[a] - HAIR <= position[a] && position[a] <= bounds.max[a] + HAIR)
    };
    scene.sectors().filter(holds).collect()
}

/// Walks randomly in the free space found by ray casts; returns the number of portals crossed.
fn wander(
    scene: &Scene,
    from: Location,
    steps: usize,
    seed: u64,
    check: impl Fn(&Location, &Location),
) -> usize {
    let mut random = Random::new(seed);
    let (mut place, mut crossings) = (from, 0);
    for step in 0..steps {
        let mut direction: [f32; 3] = random.point(1.0);
        // Courts have no roof: come down again from this height.
        if place.position[1] > 4.0 {
            direction[1] = -direction[1].abs();
        }
        let ray = Ray {
            origin: place.position,
            direction,
        };
        let cast = scene.cast(place.sector, &ray);
        // Keep a distance from walls, so that the next ray does not start in one.
        const AWAY: f32 = 0.05;
        let length = direction.map(|value| value * value).iter().sum::<f32>().sqrt();
        let far = (cast.distance as f32 - AWAY / length).clamp(0.0, 2.0);
        let walked = scene.walk(place, direction.map(|value| value * far));
        assert!(walked.complete);
        // Must move as far as a ray in the same direction.
        assert!(
            cast.crossed.starts_with(&walked.crossed),
            "step {step} from {place:?}: {:?}, but the ray {:?}",
            walked.crossed,
            cast.crossed
        );
        let end: [f32; 3] = std::array::from_fn(|axis| place.position[axis] + direction[axis] * far);
        let image = walked.there_from_here.point(end);
        let off = (0..3).map(|axis| (image[axis] - walked.location.position[axis]).abs());
        assert!(
            off.fold(0.0, f32::max) < 1e-3,
            "{image:?} is not {:?}",
            walked.location
        );
        check(&place, &walked.location);
        crossings += walked.crossed.len();
        place = walked.location;
    }
    crossings
}

#[test]
fn a_hundred_thousand_steps_through_the_palace_never_leak() {
    let BuiltIn { scene, cameras } = built_in("enfilade").expect("a built-in scene");
    let mut crossings = 0;
    for (camera, seed) in cameras.iter().zip(0..) {
        let sector = scene
            .locate(camera.eye, camera.toward)
            .expect("a position inside a room");
        let place = Location {
            sector,
            position: camera.eye.map(|value| value as f32),
        };
        crossings += wander(
            &scene,
            place,
            100_000 / cameras.len() + 1,
            seed,
            |before, after| {
                let holders = holders(&scene, after.position);
                assert!(
                    holders.contains(&after.sector),
                    "{before:?} to {after:?}, but there are {holders:?}"
                );
            },
        );
    }
    assert!(crossings > 500, "only {crossings} doors were crossed");
}

#[test]
fn steps_through_teleports_mirrors_and_other_scales_go_where_rays_go() {
    let mut crossings = 0;
    for name in ["teleport", "impossible", "mirrors", "nested", "free-doorway"] {
        let BuiltIn { scene, cameras } = built_in(name).expect("a built-in scene");
        for (camera, seed) in cameras.iter().zip(0..) {
            let sector = scene
                .locate(camera.eye, camera.toward)
                .expect("a position inside a sector");
            let place = Location {
                sector,
                position: camera.eye.map(|value| value as f32),
            };
            crossings += wander(&scene, place, 2000, seed, |_, _| {});
        }
    }
    assert!(crossings > 400, "only {crossings} portals were crossed");
}

#[test]
fn steps_through_edges_and_corners_of_neighbouring_openings_never_leak() {
    // A block of 3 × 3 × 3 rooms with openings on all sides: every inner edge is shared by four openings, every corner
    // by eight rooms.
    let scene = honeycomb();
    let mut random = Random::new(7);
    let mut place = Location {
        sector: SectorId(13),
        position: [1.5; 3],
    };
    let mut at_edges = 0;
    for _ in 0..100_000 {
        // Multiples of a quarter hit planes, edges and corners exactly.
        let mut end = place
            .position
            .map(|value| value + (random.between(-1.0, 1.0) * 8.0).round() * 0.25);
        for value in &mut end {
            *value = value.clamp(0.25, 2.75);
        }
        let step = std::array::from_fn(|axis| end[axis] - place.position[axis]);
        let walked = scene.walk(place, step);
        assert_eq!(walked.location.position, end);
        at_edges += usize::from(end.iter().filter(|value| value.fract() == 0.0).count() > 1);
        let room = walked.location.sector.0;
        for (axis, value) in end.iter().enumerate() {
            let low = (room / 3_u32.pow(axis as u32) % 3) as f32;
            assert!(
                (low..=low + 1.0).contains(value),
                "{place:?} to {end:?} ends in room {room}"
            );
        }
        place = walked.location;
    }
    assert!(at_edges > 4000, "only {at_edges}");
}

/// Builds rooms of 1 × 1 × 1, each open to its neighbours on all sides.
fn honeycomb() -> Scene {
    use enfilade::{ConvexPolygon, GeometryBuilder, Material, Method, SceneBuilder};
    const N: u32 = 3;
    let number = |[x, y, z]: [u32; 3]| x + N * (y + N * z);
    let mut scene = SceneBuilder::new();
    let mut doors: Vec<Vec<(SectorId, enfilade::OpeningId)>> = vec![Vec::new(); 3 * (N * N * N) as usize];
    for room in 0..N * N * N {
        let at = [room % N, room / N % N, room / N / N];
        let mut geometry = GeometryBuilder::new([Material::opaque([1.0; 3])]);
        let mut openings = Vec::new();
        for axis in 0..3 {
            for up in [false, true] {
                let beside = at[axis].checked_add_signed(if up { 1 } else { -1 });
                let Some(_) = beside.filter(|&beside| beside < N) else {
                    continue;
                };
                let mut corner = at.map(|value| value as f32);
                corner[axis] += f32::from(u8::from(up));
                let [mut along, mut across] = [[0.0; 3]; 2];
                along[(axis + 1) % 3] = 1.0;
                across[(axis + 2) % 3] = 1.0;
                // Its front faces the room: upwards for a wall below.
                let outline = ConvexPolygon::rectangle(corner, along, across).expect("a square");
                let outline = if up { outline.flipped() } else { outline };
                let mut lower = at;
                lower[axis] -= u32::from(!up);
                openings.push((
                    3 * number(lower) as usize + axis,
                    geometry.opening("wall", outline),
                ));
            }
        }
        let geometry = geometry.build().expect("six openings at most");
        let id = scene.add("room", geometry, Method::ZBuffer);
        for (door, opening) in openings {
            doors[door].push((id, opening));
        }
    }
    for ends in doors.into_iter().filter(|ends| !ends.is_empty()) {
        let [a, b] = ends.try_into().expect("a wall has two sides");
        scene.door(a, b);
    }
    scene.build().expect("a honeycomb")
}

#[test]
fn who_walks_through_a_mirror_stands_before_it_again_turned_over() {
    let BuiltIn { scene, .. } = built_in("mirror").expect("a built-in scene");
    let before = Location {
        sector: SectorId(0),
        position: [0.3, 1.5, -2.0],
    };
    let walked = scene.walk(before, [0.0, 0.0, -2.0]);
    assert_eq!(walked.crossed.len(), 1);
    assert!(walked.there_from_here.mirrors());
    let [x, y, z] = walked.location.position;
    assert!(
        (x - 0.3).abs() < 1e-6 && (y - 1.5).abs() < 1e-6 && (z + 2.1).abs() < 1e-5,
        "{z}"
    );
}

#[test]
fn a_ball_in_a_doorway_stands_in_both_rooms_and_one_in_a_room_in_that_alone() {
    let BuiltIn { scene, cameras } = built_in("two-rooms").expect("a built-in scene");
    let portal = &scene.portals()[0];
    let door = &scene.sector(portal.from).openings()[usize::from(portal.opening.0)].outline;
    let middle: [f32; 3] = door.bounds().center();
    let normal = door.normal();
    let at = |off: f32| Location {
        sector: portal.from,
        position: std::array::from_fn(|axis| middle[axis] + normal[axis] * off),
    };
    for (off, radius, expected) in [(0.2, 0.3, 2), (0.4, 0.3, 1), (0.0, 0.3, 2)] {
        let present = scene.body_sectors(at(off), radius);
        assert_eq!(present.len(), expected, "{off} before the door");
        assert_eq!(present[0].location, at(off));
        assert_eq!(present[0].there_from_here, Transform::IDENTITY);
        if let Some(other) = present.get(1) {
            assert_eq!(other.location.sector, portal.to);
        }
    }
    let sector = scene
        .locate(cameras[0].eye, cameras[0].toward)
        .expect("a position inside a sector");
    let far = Location {
        sector,
        position: cameras[0].eye.map(|value| value as f32),
    };
    assert_eq!(scene.body_sectors(far, 0.1).len(), 1);
}
