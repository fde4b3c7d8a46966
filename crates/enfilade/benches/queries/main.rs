//! Cost of spatial queries: items in a box, a sphere or a frustum, the nearest items, rays, overlapping pairs,
//! visibility between boxes, a moving capsule; compared with `rstar` and `parry3d` where they do the same job.
//!
//! Results are counted and must match those of the other crate: a difference is an error. With `cargo test` it runs a
//! few queries and only counts.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

mod pairs;

use enfilade::{
    Aabb, BoxVisibility, Geometry, GeometryBuilder, ItemIndex, Location, Material, MaterialId, Mesh, Method,
    OccluderSet, Ray, Scene, SceneBuilder, SectorId, Transform, View,
};
use enfilade_scenes::{Random, built_in};
use enfilade_walk::Capsule;
use pairs::pairs;
use parry3d::math::Vector;
use parry3d::query::RayCast;
use parry3d::shape::TriMesh;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

/// Queries per round; the median of the rounds is reported.
const QUESTIONS: usize = 1000;
const ROUNDS: usize = 21;

fn cube(middle: [f32; 3], half: f32) -> Aabb {
    Aabb {
        min: middle.map(|side| side - half),
        max: middle.map(|side| side + half),
    }
}

/// Keeps a result from being optimized away.
fn hold<T>(answer: T) {
    black_box(answer);
}

/// Ten thousand blocks along a hundred streets, on a ground slab.
fn city() -> Geometry {
    const SIDES: [[u32; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let corners = cube([0.5; 3], 0.5).corners();
    let faces = SIDES.map(|[a, b, c, d]| [a, b, c, a, c, d]);
    let block = Mesh::triangles(&corners, faces.as_flattened(), MaterialId(0)).expect("a cube");
    let mut builder = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    let block = builder.mesh(block);
    let ground = Transform::translation([-10.0, -1.0, -10.0]) * Transform::scaling([1020.0, 1.0, 1020.0]);
    builder.item("ground", block, ground);
    let mut chance = Random::new(3);
    for number in 0..10_000_u16 {
        let [x, z] = [number % 100, number / 100].map(|street| 10.0 * f32::from(street));
        let [width, height, depth] = [(); 3].map(|()| 1.0 + 8.0 * chance.unit());
        let at = Transform::translation([x, 0.0, z]) * Transform::scaling([width, 3.0 * height, depth]);
        builder.item("block", block, at);
    }
    builder.build().expect("a city")
}

fn largest(name: &str) -> Arc<Geometry> {
    let scene = built_in(name).expect("it is built in").scene;
    let geometries = scene.sectors().filter_map(|id| scene.geometry(id));
    let largest = geometries.max_by_key(|geometry| geometry.items().len());
    Arc::clone(largest.expect("it has sectors"))
}

/// Prints rows of the table: nanoseconds per query, for this crate and the other one.
struct Bench {
    times: bool,
    questions: usize,
}

impl Bench {
    /// Returns nanoseconds per call: the median of several rounds with one call per query.
    fn ns(&self, mut ask: impl FnMut(usize)) -> f64 {
        let mut round = || {
            let start = Instant::now();
            (0..self.questions).for_each(&mut ask);
            start.elapsed().as_secs_f64() * 1e9 / self.questions as f64
        };
        let rounds = if self.times { ROUNDS } else { 1 };
        let mut all: Vec<f64> = (0..rounds).map(|_| round()).collect();
        all.sort_by(f64::total_cmp);
        all[rounds / 2]
    }

    fn tell(&self, place: &str, question: &str, ours: f64, other: Option<(&str, f64)>, found: f64) {
        if self.times {
            let other = other.map_or(String::new(), |(name, ns)| {
                format!("{name:>10} {ns:9.0} {:6.2}", ns / ours)
            });
            println!("{place:14}{question:34}{ours:9.0} {found:9.2} {other}");
        }
    }
}

type Boxed = GeomWithData<Rectangle<[f32; 3]>, u32>;

fn items(bench: &Bench, place: &str, geometry: &Geometry) {
    let boxed = |(number, item): (u32, &enfilade::Item)| {
        let Aabb { min, max } = item.bounds;
        (!item.bounds.is_empty()).then(|| Boxed::new(Rectangle::from_corners(min, max), number))
    };
    let tree = RTree::bulk_load((0..).zip(geometry.items()).filter_map(boxed).collect());
    let (whole, mut chance) = (geometry.bounds(), Random::new(1));
    let half = 0.02 * whole.longest_side();
    let points: Vec<[f32; 3]> = (0..bench.questions).map(|_| chance.point_in(&whole)).collect();
    let each = bench.questions as f64;

    let mut found = 0_u64;
    for &point in &points {
        let bounds = cube(point, half);
        let (mut ours, mut theirs) = (Vec::new(), Vec::new());
        geometry.items_in_box(&bounds, |item| ours.push(item.0));
        let envelope = AABB::from_corners(bounds.min, bounds.max);
        theirs.extend(
            tree.locate_in_envelope_intersecting(envelope)
                .map(|held| held.data),
        );
        ours.sort_unstable();
        theirs.sort_unstable();
        assert_eq!(ours, theirs, "{place}, {bounds:?}");
        found += ours.len() as u64;
    }
    let ours = bench.ns(|i| geometry.items_in_box(&cube(points[i], half), hold));
    let theirs = bench.ns(|i| {
        let Aabb { min, max } = cube(points[i], half);
        for held in tree.locate_in_envelope_intersecting(AABB::from_corners(min, max)) {
            black_box(held.data);
        }
    });
    bench.tell(
        place,
        "items in a box",
        ours,
        Some(("rstar", theirs)),
        found as f64 / each,
    );

    let mut found = 0_u64;
    let ours = bench.ns(|i| {
        geometry.items_in_sphere(points[i], half, |item| {
            found += 1;
            black_box(item);
        })
    });
    let rounds = if bench.times { ROUNDS as f64 } else { 1.0 };
    bench.tell(
        place,
        "items in a sphere",
        ours,
        None,
        found as f64 / each / rounds,
    );

    let mut found = 0_u64;
    let ours = bench.ns(|i| {
        let mut view = View::new(points[i], points[(i + 1) % points.len()], [1280, 720]);
        view.fov_y = 1.0;
        geometry.items_in_frustum(&view, |item| {
            found += 1;
            black_box(item);
        });
    });
    bench.tell(
        place,
        "items in a frustum",
        ours,
        None,
        found as f64 / each / rounds,
    );

    let mut nearest = Vec::new();
    for &point in &points {
        geometry.nearest_items(point, 10, f32::INFINITY, &mut nearest);
        let theirs = tree.nearest_neighbor_iter_with_distance_2(point).take(10);
        let last = theirs
            .map(|(_, square)| f64::from(square).sqrt())
            .last()
            .unwrap_or(0.0);
        let ours = nearest.last().map_or(0.0, |last| last.distance);
        assert!(
            (ours - last).abs() <= 1e-4 * f64::from(whole.longest_side()),
            "{place}: {ours}, {last}"
        );
    }
    let ours = bench.ns(|i| {
        geometry.nearest_items(points[i], 10, f32::INFINITY, &mut nearest);
        black_box(&nearest);
    });
    let theirs = bench.ns(|i| {
        for held in tree.nearest_neighbor_iter(points[i]).take(10) {
            black_box(held.data);
        }
    });
    bench.tell(place, "the 10 nearest items", ours, Some(("rstar", theirs)), 10.0);
}

/// Builds one mesh from all triangles of a geometry.
fn soup(geometry: &Geometry) -> TriMesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for item in (0..geometry.items().len() as u32).map(ItemIndex) {
        let (mesh, placed) = (geometry.mesh_of(item), geometry.item(item).transform());
        let first = positions.len() as u32;
        positions.extend(mesh.positions().iter().map(|&p| Vector::from(placed.point(p))));
        for face in 0..mesh.face_count() {
            let corners = mesh.face(face);
            let fan = (2..corners.len()).map(|last| [corners[0], corners[last - 1], corners[last]]);
            triangles.extend(fan.map(|used| used.map(|corner| first + corner)));
        }
    }
    TriMesh::new(positions, triangles).expect("triangles")
}

fn rays(bench: &Bench, place: &str, geometry: &Geometry) {
    let soup = soup(geometry);
    let (whole, mut chance) = (geometry.bounds(), Random::new(2));
    let rays: Vec<Ray> = (0..bench.questions)
        .map(|_| Ray {
            origin: chance.point_in(&whole),
            direction: chance.point(1.0),
        })
        .collect();
    let theirs = |ray: &Ray| {
        let ray = parry3d::query::Ray::new(ray.origin.into(), ray.direction.into());
        soup.cast_local_ray(&ray, f32::MAX, false)
    };
    let mut differ = 0;
    let mut found = 0;
    for ray in &rays {
        let hit = geometry.cast(ray);
        found += u32::from(hit.is_some());
        let agree = match (hit, theirs(ray)) {
            (Some(hit), Some(distance)) => {
                (hit.distance - f64::from(distance)).abs() < 1e-3 * (1.0 + hit.distance)
            }
            (hit, distance) => hit.is_none() && distance.is_none(),
        };
        differ += usize::from(!agree);
    }
    // `parry3d` computes in f32 and sometimes misses at edges.
    assert!(
        differ <= bench.questions / 200,
        "{place}: {differ} rays have different hits"
    );
    let each = bench.questions as f64;
    let ours = bench.ns(|i| hold(geometry.cast(&rays[i])));
    let other = bench.ns(|i| hold(theirs(&rays[i])));
    bench.tell(
        place,
        "first hit of a ray",
        ours,
        Some(("parry3d", other)),
        f64::from(found) / each,
    );
    let mut hits = Vec::new();
    let mut found = 0;
    for ray in &rays {
        geometry.cast_all(ray, f64::INFINITY, &mut hits);
        found += hits.len();
    }
    let ours = bench.ns(|i| geometry.cast_all(&rays[i], f64::INFINITY, &mut hits));
    bench.tell(place, "all hits of a ray", ours, None, found as f64 / each);
}

fn between(bench: &Bench, place: &str, geometry: &Geometry) {
    let occluders = OccluderSet::build(geometry);
    let mut chance = Random::new(5);
    let mut item = || geometry.items()[(chance.unit() * geometry.items().len() as f32) as usize].bounds;
    let boxes: Vec<[Aabb; 2]> = (0..bench.questions).map(|_| [item(), item()]).collect();
    let answers: Vec<BoxVisibility> = boxes
        .iter()
        .map(|[a, b]| geometry.between(a, b, &occluders))
        .collect();
    let known = answers
        .iter()
        .filter(|&&answer| answer != BoxVisibility::Unknown)
        .count();
    assert!(known > 0, "all visibility is unknown in {place}");
    let ours = bench.ns(|i| hold(geometry.between(&boxes[i][0], &boxes[i][1], &occluders)));
    bench.tell(
        place,
        "visibility between two boxes",
        ours,
        None,
        known as f64 / bench.questions as f64,
    );
}

fn capsule(bench: &Bench, place: &str, scene: &Scene, from: Location) {
    let mut chance = Random::new(6);
    let mut capsule = Capsule::new(0.25, 1.2);
    let (mut place_now, mut course, mut touched) = (from, [0.0; 3], 0_u64);
    let mut step = |i: usize| {
        if i.is_multiple_of(50) {
            course = chance.point(1.0).map(|part| 0.05 * part);
            course[1] = -0.02;
        }
        let slid = capsule.slide(scene, place_now, course);
        course = slid.there_from_here.direction(course);
        touched += u64::from(!slid.touched.is_empty());
        (place_now, capsule) = (slid.location, slid.capsule);
    };
    let ours = bench.ns(&mut step);
    let rounds = if bench.times { ROUNDS } else { 1 };
    assert!(touched > 0, "the capsule touched nothing in {place}");
    bench.tell(
        place,
        "a step of a capsule",
        ours,
        None,
        touched as f64 / (bench.questions * rounds) as f64,
    );
}

fn main() {
    let times = std::env::args().any(|argument| argument == "--bench");
    let bench = Bench {
        times,
        questions: if times { QUESTIONS } else { 100 },
    };
    if times {
        println!(
            "{:14}{:34}{:>9} {:>9} {:>10} {:>9} {:>6}",
            "scene", "query", "ns", "found", "peer", "ns", "ratio"
        );
    }
    let city = Arc::new(city());
    let places = [
        ("city", Arc::clone(&city)),
        ("crowd", largest("crowd")),
        ("palace", largest("enfilade")),
    ];
    for (place, geometry) in &places {
        items(&bench, place, geometry);
    }
    for (place, geometry) in places.iter().chain([&("hills", largest("big-mesh"))]) {
        rays(&bench, place, geometry);
    }
    for (place, sides) in [
        ("in space", [60.0; 3]),
        ("in a plane", [200.0, 0.0, 200.0]),
        ("in a line", [20_000.0, 0.0, 0.0]),
    ] {
        pairs(&bench, place, sides);
    }
    for (place, geometry) in &places {
        between(&bench, place, geometry);
    }
    let palace = built_in("enfilade").expect("it is built in");
    let camera = &palace.cameras[0];
    let sector = palace.scene.locate(camera.eye, camera.toward).expect("a hall");
    let place = Location {
        sector,
        position: camera.eye,
    };
    capsule(&bench, "palace", &palace.scene, place);
    let mut streets = SceneBuilder::new();
    streets.add("city", city, Method::ZBuffer);
    let streets = streets.build().expect("one sector");
    let corner = Location {
        sector: SectorId(0),
        position: [499.5, 1.0, 499.5],
    };
    capsule(&bench, "city", &streets, corner);
}
