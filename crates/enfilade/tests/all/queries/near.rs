//! Items near a location, through portals.

use enfilade::laws::chains;
use enfilade::{
    ConvexPolygon, Geometry, GeometryBuilder, ItemIndex, Location, Material, MaterialId, Mesh, Method,
    NearItems, PortalId, Scene, SceneBuilder, SectorId, Transform,
};
use enfilade_scenes::{Random, built_in, random_scene};
use glam::DVec3;
use std::collections::BTreeMap;

/// Portals in a row that are searched by brute force.
const MAX_CROSSED: usize = 3;

/// Number of parts per side of an opening.
const PARTS: u32 = 8;

fn point(point: [f32; 3]) -> DVec3 {
    DVec3::from(point.map(f64::from))
}

/// Returns points all over an opening, corners and edges included.
fn samples(outline: &ConvexPolygon) -> Vec<DVec3> {
    let corners: Vec<DVec3> = outline.corners().iter().map(|&corner| point(corner)).collect();
    let mut samples = Vec::new();
    for last in 2..corners.len() {
        for i in 0..=PARTS {
            for j in 0..=PARTS - i {
                let [along, up] = [i, j].map(|part| f64::from(part) / f64::from(PARTS));
                let [first, right, left] = [corners[0], corners[last - 1], corners[last]];
                samples.push(first + along * (right - first) + up * (left - first));
            }
        }
    }
    samples
}

/// Compares with the shortest paths to items over samples of all openings, by all chains of a few portals: a sampled
/// path is never shorter than the shortest, and hardly longer.
fn sampled(scene: &Scene, place: Location) -> BTreeMap<(SectorId, ItemIndex), f64> {
    let mut all = BTreeMap::new();
    for (chain, to) in chains(scene, place.sector, MAX_CROSSED) {
        let Some(geometry) = scene.geometry(to) else {
            continue;
        };
        // Points in the current space, and the path lengths to them.
        let mut reached = vec![(point(place.position), 0.0)];
        let mut scale = 1.0;
        for id in chain {
            let portal = &scene.portals()[id.0 as usize];
            let opening = &scene.sector(portal.from).openings()[usize::from(portal.opening.0)];
            let beyond = |at: DVec3| {
                let lengths = reached
                    .iter()
                    .map(|(from, length)| length + from.distance(at) / scale);
                let there = portal.there_from_here.columns().map(point);
                (
                    there[0] * at.x + there[1] * at.y + there[2] * at.z + there[3],
                    lengths.fold(f64::INFINITY, f64::min),
                )
            };
            reached = samples(&opening.outline).into_iter().map(beyond).collect();
            scale *= portal.there_from_here.scale();
        }
        for item in (0..geometry.items().len() as u32).map(ItemIndex) {
            let bounds = geometry.item(item).bounds;
            let [min, max] = [bounds.min, bounds.max].map(point);
            let lengths = (reached.iter())
                .map(|(from, length)| length + from.max(min).min(max).distance(*from) / scale);
            let length = lengths.fold(f64::INFINITY, f64::min);
            let known = all.entry((to, item)).or_insert(f64::INFINITY);
            *known = length.min(*known);
        }
    }
    all
}

/// Compares the items near a location with those that sampled paths reach. Returns how many are behind portals.
fn agrees(name: &str, scene: &Scene, place: Location, radius: f32) -> usize {
    let near = scene.near(place, radius);
    assert!(
        near.complete && near.searched == f64::from(radius),
        "@{name} from {place:?}"
    );
    assert!(
        near.items
            .windows(2)
            .all(|pair| pair[0].distance <= pair[1].distance)
    );
    let mut found = BTreeMap::new();
    for item in &near.items {
        let before = found.insert((item.sector, item.item.index), item);
        assert!(before.is_none(), "@{name}: {item:?} is listed twice");
    }
    let sampled = sampled(scene, place);
    for (of, &length) in &sampled {
        let what = || {
            format!(
                "@{name} from {place:?}: {of:?}, {length} away, is {:?}",
                found.get(of)
            )
        };
        match found.get(of) {
            Some(found) => {
                assert!(found.distance <= length * (1.0 + 1e-3) + 1e-4, "{}", what());
                let is_shorter = found.distance < 0.97 * length - 0.15;
                assert!(!is_shorter || found.crossed.len() > MAX_CROSSED, "{}", what());
            }
            None => assert!(length > f64::from(radius) - 1e-4, "{}", what()),
        }
    }
    assert!(
        found
            .iter()
            .all(|(of, item)| item.crossed.len() > MAX_CROSSED || sampled.contains_key(of))
    );
    (near.items.iter())
        .filter(|item| !item.crossed.is_empty())
        .count()
}

#[test]
fn items_near_a_place_are_those_that_the_shortest_way_through_openings_leads_to() {
    let mut chance = Random::new(9);
    let mut through = 0;
    let named = [
        "two-rooms",
        "mirror",
        "mirrors",
        "teleport",
        "nested",
        "impossible",
        "free-doorway",
    ];
    let named = named.map(|name| (name, built_in(name).expect("it is built in")));
    let random = (0..40).map(|seed| ("random", random_scene(seed)));
    for (name, built) in named.into_iter().chain(random) {
        let scene = &built.scene;
        for camera in built.cameras.iter().take(4) {
            let Some(sector) = scene.locate(camera.eye, camera.toward) else {
                continue;
            };
            let at = |position| Location { sector, position };
            through += agrees(name, scene, at(camera.eye), 1.0 + 11.0 * chance.unit());
            let bounds = scene.bounds(sector);
            let position = super::about(&mut chance, &bounds);
            through += agrees(name, scene, at(position), 1.0 + 5.0 * chance.unit());
        }
    }
    assert!(through > 400, "only {through} through portals");
}

#[test]
fn mirrors_and_teleports_do_not_multiply_the_ways_to_an_item() {
    // A search is complete only if it follows no more than `MAX_CHAINS` chains.
    for (name, radius) in [
        ("enfilade", 16.0),
        ("enfilade", 64.0),
        ("mirrors", 1e4),
        ("house", 100.0),
    ] {
        let built = built_in(name).expect("it is built in");
        for camera in &built.cameras {
            let sector = built.scene.locate(camera.eye, camera.toward).expect("a room");
            let place = Location {
                sector,
                position: camera.eye,
            };
            let near = built.scene.near(place, radius);
            assert!(
                near.complete && !near.items.is_empty(),
                "@{name} from `{}`",
                camera.name
            );
        }
    }
}

/// A room with a stone and two openings, each of which leads back into the room, slightly shifted and larger.
fn loops(scale: f32) -> Scene {
    let mut room = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    let stone = [[0.0, 0.0, -6.0], [0.5, 0.0, -6.0], [0.0, 0.5, -6.0]];
    let stone = room.mesh(Mesh::triangles(&stone, &[0, 1, 2], MaterialId(0)).expect("a triangle"));
    room.item("stone", stone, Transform::IDENTITY);
    let openings = [-4.0, 3.0].map(|x| {
        let outline = ConvexPolygon::rectangle([x, -1.0, -5.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
        room.opening("out", outline.expect("a rectangle"))
    });
    let mut scene = SceneBuilder::new();
    let geometry: Geometry = room.build().expect("sound");
    let room = scene.add("room", geometry, Method::HierarchicalZ);
    for (opening, aside) in openings.into_iter().zip([[0.3, 0.0, 5.0], [-0.4, 0.2, 4.5]]) {
        let there = Transform::translation(aside) * Transform::scaling([scale; 3]);
        scene.portal((room, opening), room, there);
    }
    scene.build().expect("one room")
}

const START: Location = Location {
    sector: SectorId(0),
    position: [0.0; 3],
};

#[test]
fn a_search_through_loops_that_shrink_or_enlarge_ends_and_reports_how_far_it_is_right() {
    for scale in [1e-6, 1e-3, 0.9, 1.0, 1.1, 1e3, 1e6] {
        for radius in [8.0, 1e3, 1e30, f32::INFINITY] {
            let near = loops(scale).near(START, radius);
            assert_eq!(near.items.len(), 1, "scale {scale}, radius {radius}");
            let [stone] = &near.items[..] else {
                unreachable!();
            };
            assert!(stone.distance.is_finite() && stone.distance <= 6.0);
            assert_eq!(near.complete, near.searched == f64::from(radius));
            assert!(near.searched >= 4.0);
        }
    }
}

#[test]
fn nothing_is_near_a_place_that_is_none_or_within_a_radius_that_is_none() {
    let scene = loops(1e6);
    let at = |position| Location { position, ..START };
    for (place, radius) in [
        (at([f32::NAN; 3]), 1.0),
        (at([0.0, f32::INFINITY, 0.0]), 1e9),
        (START, f32::NAN),
        (START, -1.0),
    ] {
        let near: NearItems = scene.near(place, radius);
        assert_eq!(
            (near.items.len(), near.complete),
            (0, true),
            "{place:?}, {radius}"
        );
    }
    assert_eq!(scene.near(START, 7.0).items[0].crossed, [] as [PortalId; 0]);
}
