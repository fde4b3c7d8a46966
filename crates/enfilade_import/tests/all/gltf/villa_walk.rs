//! A person walks through the rooms of a real villa, and never gets into a wall.

use enfilade::{Aabb, Location, MaterialId, Mesh, Method, Ray, RayEnd, Scene, SectorId, Transform};
use enfilade_import::{ReadOptions, read};
use enfilade_scenes::Random;
use enfilade_walk::Capsule;
use std::collections::BTreeSet;
use std::path::Path;

/// From each start.
const STEPS: usize = 1_500;

/// Number of steps between changes of course.
const STEPS_OF_A_COURSE: usize = 25;

const DIRECTIONS: u8 = 16;

/// Start of the walk: room and position.
const STARTS: [(&str, [f32; 3]); 6] = [
    ("Living-room", [5.0, 1.1, -2.3]),
    ("Corridor-room", [7.0, 1.1, -3.0]),
    ("Kitchen-room", [9.5, 1.1, -5.0]),
    ("Stairwell-room", [7.0, 1.1, -6.8]),
    ("Master-room", [4.0, 4.1, -5.0]),
    ("Guest-room", [8.0, 4.1, -5.0]),
];

fn villa(file: &Path) -> Scene {
    let import = read(file, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let scene = import.scene(Method::ZBuffer, Method::DEFAULT_LIMIT);
    let mut scene = scene.expect("a villa");
    // The hatch leads from the kitchen to the corridor alone: there it is a hole in the wall, and nothing behind it.
    let hatch = [
        [7.9, 0.0, -1.9],
        [7.9, 0.0, -3.4],
        [7.9, 2.5, -3.4],
        [7.9, 2.5, -1.9],
    ];
    let board = Mesh::triangles(&hatch, &[0, 1, 2, 0, 2, 3], MaterialId(0)).expect("flat");
    let corridor = room(&scene, "Corridor-room");
    let mut edit = scene.edit();
    let added = edit.add(corridor, "board", board, Transform::IDENTITY);
    added.expect("a material of the villa's");
    edit.finish().expect("one item more");
    scene
}

fn room(scene: &Scene, name: &str) -> SectorId {
    let mut all = scene.sectors();
    let found = all.find(|&id| scene.sector_name(id) == name);
    found.expect("a room of the villa")
}

fn apart(a: [f32; 3], b: [f32; 3]) -> f64 {
    let squares = [0, 1, 2].map(|axis| f64::from(a[axis] - b[axis]).powi(2));
    squares.iter().sum::<f64>().sqrt()
}

/// Returns the minimum distance of level rays from the axis of a person, at the height of feet, waist and head, and the
/// ray.
fn nearest_wall(scene: &Scene, place: Location, person: &Capsule) -> (f64, String) {
    let half = 0.5 * person.height - person.radius;
    let mut nearest = (f64::INFINITY, String::new());
    for up in [-half, 0.0, half] {
        let at = scene.walk(place, person.up.map(|side| up * side)).location;
        for turn in 0..DIRECTIONS {
            let angle = std::f32::consts::TAU * f32::from(turn) / f32::from(DIRECTIONS);
            let ray = Ray {
                origin: at.position,
                direction: [angle.cos(), 0.0, angle.sin()],
            };
            let cast = scene.cast(at.sector, &ray);
            if cast.distance < nearest.0 && cast.end != RayEnd::Nothing {
                nearest = (cast.distance, format!("{ray:?} meets {cast:?}"));
            }
        }
    }
    nearest
}

/// Some way to go, pulled down all the while. In the garden, which has an end, rather back to the house.
fn any_course(scene: &Scene, place: &Location, chance: &mut Random) -> [f32; 3] {
    const DOOR: [f32; 3] = [7.0, 1.0, -1.0];
    let is_out = scene.sector_name(place.sector) == "Garden-room" && !chance.once_in(3);
    let angle = if is_out {
        (DOOR[2] - place.position[2]).atan2(DOOR[0] - place.position[0]) + chance.between(-0.3, 0.3)
    } else {
        std::f32::consts::TAU * chance.unit()
    };
    let speed = chance.between(0.02, 0.2);
    [speed * angle.cos(), -0.05, speed * angle.sin()]
}

/// Returns `true` if a position is in the AABB of its room, enlarged by a margin.
fn is_in_its_room(scene: &Scene, place: &Location, slack: f32) -> bool {
    let Aabb { min, max } = scene.sector(place.sector).bounds();
    (0..3).all(|axis| (min[axis] - slack..=max[axis] + slack).contains(&place.position[axis]))
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn a_person_walks_through_a_villa_for_thousands_of_steps_and_never_into_a_wall() {
    let folder = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    let scene = villa(&Path::new(&folder).join("blender_villa.glb"));
    let mut visited: BTreeSet<&str> = BTreeSet::new();
    let (mut crossings, mut touched, mut length) = (0, 0, 0.0);
    for (seed, (start, position)) in (0..).zip(STARTS) {
        let mut place = Location {
            sector: room(&scene, start),
            position,
        };
        let mut person = Capsule::new(0.25, 1.7);
        person.climb = 0.35;
        let mut chance = Random::new(seed);
        let mut course = [0.0; 3];
        for step in 0..STEPS {
            if step % STEPS_OF_A_COURSE == 0 {
                course = any_course(&scene, &place, &mut chance);
            }
            let slid = person.slide(&scene, place, course);
            let what = || format!("from {start}, step {step}, {place:?} by {course:?} to {slid:?}");
            assert!(slid.complete, "{}", what());
            assert!(is_in_its_room(&scene, &slid.location, 0.5), "{}: left", what());
            let (nearest, ray) = nearest_wall(&scene, slid.location, &slid.capsule);
            assert!(
                nearest >= 0.99 * f64::from(slid.capsule.radius),
                "{}: {nearest} away: {ray}",
                what()
            );
            length += apart(slid.there_from_here.point(place.position), slid.location.position);
            crossings += slid.crossed.len();
            touched += usize::from(!slid.touched.is_empty());
            course = slid.there_from_here.direction(course);
            (place, person) = (slid.location, slid.capsule);
            visited.insert(scene.sector_name(place.sector));
        }
    }
    assert!(
        visited.len() == 8 && crossings > 20 && touched > STEPS && length > 300.0,
        "{visited:?}, {crossings} crossings, {touched} touched, {length} gone"
    );
}
