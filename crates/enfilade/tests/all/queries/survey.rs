//! Survey cameras are in rooms and streets, never in walls.

use super::CUBE_SIDES;
use enfilade::{
    GeometryBuilder, Material, MaterialId, Mesh, Method, Scene, SceneBuilder, Survey, SurveyView, Transform,
    View, Viewer, survey, survey_hard,
};
use enfilade_scenes::{NAMES, built_in};

/// A box given by its minimum and maximum corner; with `inward` its faces face inwards.
struct Block {
    min: [f32; 3],
    max: [f32; 3],
    inward: bool,
}

fn solid(min: [f32; 3], max: [f32; 3]) -> Block {
    Block {
        min,
        max,
        inward: false,
    }
}

fn room(min: [f32; 3], max: [f32; 3]) -> Block {
    Block {
        min,
        max,
        inward: true,
    }
}

/// A scene of boxes, scaled by `scale`, with reversed winding if `inverted`, double-sided.
fn scene(blocks: &[Block], scale: f32, inverted: bool) -> Scene {
    let mut material = Material::opaque([1.0; 3]);
    material.double_sided = true;
    let mut builder = GeometryBuilder::new([material]);
    for block in blocks {
        let corner = |at: usize| {
            [0, 1, 2].map(|axis| {
                let end = if at >> axis & 1 == 0 { block.min } else { block.max };
                scale * end[axis]
            })
        };
        let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
        let mut faces = Vec::new();
        for [a, b, c, d] in CUBE_SIDES {
            let triangles = if block.inward == inverted {
                [a, b, c, a, c, d]
            } else {
                [c, b, a, d, c, a]
            };
            faces.extend(triangles);
        }
        let mesh = Mesh::triangles(&corners, &faces, MaterialId(0)).expect("twelve triangles");
        let mesh = builder.mesh(mesh);
        builder.item("block", mesh, Transform::IDENTITY);
    }
    let mut scene = SceneBuilder::new();
    scene.add("all", builder.build().expect("sound"), Method::ZBuffer);
    scene.build().expect("one sector")
}

/// Two adjacent rooms; the wall between them is a cavity wider than the minimum clearance.
fn two_rooms() -> [Block; 2] {
    [
        room([0.0, 0.0, 0.0], [5.0, 2.8, 4.0]),
        room([6.5, 0.0, 0.0], [9.5, 2.8, 4.0]),
    ]
}

fn is_within(place: &SurveyView, block: &Block, margin: f32, scale: f32) -> bool {
    (0..3).all(|axis| {
        let at = place.eye[axis] / scale;
        at >= block.min[axis] + margin && at <= block.max[axis] - margin
    })
}

fn places(found: &Survey) -> Vec<[f32; 3]> {
    found.views.iter().map(|place| place.eye).collect()
}

#[test]
fn a_survey_stands_in_all_rooms_and_away_from_their_walls() {
    for scale in [1.0, 39.4] {
        let rooms = two_rooms();
        let found = survey(&scene(&rooms, scale, false), 8);
        assert_eq!((found.views.len(), found.rooms), (8, 2), "scale {scale}");
        assert!(!found.seems_inverted);
        for room in &rooms {
            let here = found
                .views
                .iter()
                .filter(|place| is_within(place, room, 0.249, scale));
            assert!(here.count() >= 3, "scale {scale}: {:?}", places(&found));
        }
        let all = found.views.iter();
        assert!(
            all.clone()
                .all(|place| rooms.iter().any(|room| is_within(place, room, 0.249, scale)))
        );
    }
}

/// A house of two rooms on a foundation of `depth` metres, of boxes that touch.
fn house(depth: f32) -> Vec<Block> {
    vec![
        solid([0.0, -depth, 0.0], [12.0, 0.0, 10.0]),
        solid([0.0, 0.0, 0.0], [12.0, 2.7, 0.2]),
        solid([0.0, 0.0, 9.8], [12.0, 2.7, 10.0]),
        solid([0.0, 0.0, 0.0], [0.2, 2.7, 10.0]),
        solid([11.8, 0.0, 0.0], [12.0, 2.7, 10.0]),
        solid([6.0, 0.0, 0.0], [6.2, 2.7, 4.0]),
        solid([6.0, 0.0, 5.0], [6.2, 2.7, 10.0]),
        solid([0.0, 2.7, 0.0], [12.0, 3.0, 10.0]),
    ]
}

/// Four houses without rooms on a slab of `depth` metres.
fn slab(depth: f32) -> Vec<Block> {
    let mut blocks = vec![solid([-30.0, -depth, -30.0], [30.0, 0.0, 30.0])];
    for [x, z] in [[-25.0, -25.0], [5.0, -25.0], [-25.0, 5.0], [5.0, 5.0]] {
        blocks.push(solid([x, 0.0, z], [x + 20.0, 9.0, z + 20.0]));
    }
    blocks
}

/// Returns the number of views inside a block with outward faces.
fn inside(found: &Survey, blocks: &[Block]) -> usize {
    let solids = || blocks.iter().filter(|block| !block.inward);
    let views = found.views.iter();
    views
        .filter(|view| solids().any(|block| is_within(view, block, 0.0, 1.0)))
        .count()
}

#[test]
fn where_the_winding_is_inverted_a_survey_stands_in_the_same_places_and_says_so() {
    let [right, inverted] = [false, true].map(|inverted| survey(&scene(&house(0.3), 1.0, inverted), 8));
    assert_eq!(places(&right), places(&inverted));
    assert_eq!(inside(&right, &house(0.3)), 0);
    assert!(inverted.seems_inverted && !right.seems_inverted);
}

#[test]
fn where_solids_outweigh_rooms_a_survey_stays_out_of_the_solids() {
    let block = || vec![solid([0.0, 0.0, 0.0], [10.0, 4.0, 10.0])];
    let tower = || vec![solid([0.0, 0.0, 0.0], [10.0, 200.0, 10.0])];
    for blocks in [house(3.0), house(100.0), slab(2.0), slab(20.0), block(), tower()] {
        let found = survey(&scene(&blocks, 1.0, false), 16);
        assert_eq!(found.views.len(), 16);
        assert_eq!(inside(&found, &blocks), 0, "{:?}", places(&found));
        assert!(!found.seems_inverted);
    }
}

#[test]
fn on_a_thick_slab_a_survey_stands_between_the_houses_and_a_little_on_their_roofs() {
    let found = survey(&scene(&slab(2.0), 1.0, false), 16);
    assert_eq!(inside(&found, &slab(2.0)), 0, "{:?}", places(&found));
    let on_roofs = found.views.iter().filter(|place| place.on_roof).count();
    assert!(on_roofs <= 2, "{on_roofs} on roofs");
    assert!(
        found
            .views
            .iter()
            .all(|place| place.on_roof == (place.eye[1] > 9.0)),
        "{:?}",
        places(&found)
    );
}

#[test]
fn a_thing_with_inverted_winding_in_a_yard_is_no_room() {
    let container = room([2.0, 0.0, 2.0], [8.0, 2.6, 5.0]);
    let yard = [
        solid([-10.0, -0.5, -10.0], [20.0, 0.0, 20.0]),
        solid([12.0, 0.0, 0.0], [12.3, 3.0, 12.0]),
        container,
    ];
    let found = survey(&scene(&yard, 1.0, false), 16);
    assert_eq!(found.views.len(), 16);
    assert!(!found.seems_inverted);
    let in_it = found
        .views
        .iter()
        .filter(|place| is_within(place, &yard[2], 0.0, 1.0));
    assert_eq!(in_it.count(), 0, "{:?}", places(&found));
}

#[test]
fn a_room_of_inward_faces_with_furniture_is_a_room_and_the_furniture_is_not() {
    let [one, other] = two_rooms();
    let furnished = [one, other, solid([3.5, 0.0, 1.0], [4.9, 2.2, 3.0])];
    let found = survey(&scene(&furnished, 1.0, false), 16);
    assert_eq!(found.views.len(), 16);
    assert!(!found.seems_inverted);
    assert_eq!(inside(&found, &furnished), 0, "{:?}", places(&found));
    for room in &furnished[..2] {
        assert!(
            found.views.iter().any(|place| is_within(place, room, 0.2, 1.0)),
            "{:?}",
            places(&found)
        );
    }
}

#[test]
fn a_room_with_its_fronts_outside_is_a_room_if_everything_else_is_in_it() {
    let living_room = [
        solid([0.0, 0.0, 0.0], [6.0, 2.8, 5.0]),
        solid([0.5, 0.0, 0.5], [2.5, 0.8, 1.4]),
        solid([3.0, 0.0, 3.0], [4.0, 0.7, 4.0]),
    ];
    let found = survey(&scene(&living_room, 1.0, false), 8);
    assert!(!found.seems_inverted);
    let within = found
        .views
        .iter()
        .filter(|place| is_within(place, &living_room[0], 0.2, 1.0));
    assert!(within.count() >= 7, "{:?}", places(&found));
    assert_eq!(inside(&found, &living_room[1..]), 0, "{:?}", places(&found));
}

#[test]
fn in_a_city_a_survey_stands_in_streets_and_a_little_on_roofs() {
    let mut city = vec![solid([-40.0, -1.0, -40.0], [40.0, 0.0, 40.0])];
    for x in 0..4 {
        for z in 0..4 {
            let [x, z] = [x, z].map(|street| -32.0 + 18.0 * street as f32);
            city.push(solid([x, 0.0, z], [x + 10.0, 12.0, z + 10.0]));
        }
    }
    let found = survey(&scene(&city, 1.0, false), 32);
    assert_eq!(found.views.len(), 32);
    for place in &found.views {
        assert!(
            !city.iter().any(|block| is_within(place, block, 0.0, 1.0)),
            "{place:?}"
        );
        assert_eq!(place.on_roof, place.eye[1] > 12.0, "{place:?}");
    }
    let on_roofs = found.views.iter().filter(|place| place.on_roof).count();
    assert!((1..=4).contains(&on_roofs), "{on_roofs} on roofs");
}

/// A hall without a floor on ground that continues below it. Three of its walls have inward winding, as in some city
/// models.
#[test]
fn where_the_ground_goes_on_below_a_hall_a_survey_stays_outside() {
    let [min, max] = [[-30.0, 0.0, -20.0], [30.0, 9.0, 20.0_f32]];
    let corner = |at: usize| [0, 1, 2].map(|axis| if at >> axis & 1 == 0 { min[axis] } else { max[axis] });
    let ground = [
        [-80.0, 0.0, -60.0],
        [80.0, 0.0, -60.0],
        [80.0, 0.0, 60.0],
        [-80.0, 0.0, 60.0],
    ];
    let corners: Vec<[f32; 3]> = (0..8).map(corner).chain(ground).collect();
    let mut faces = vec![8, 10, 9, 8, 11, 10];
    let is_at =
        |side: &[u32; 4], axis: usize, end: f32| side.iter().all(|&at| corners[at as usize][axis] == end);
    for side in CUBE_SIDES.iter().filter(|side| !is_at(side, 1, 0.0)) {
        let [a, b, c, d] = *side;
        let is_outwards = is_at(side, 1, 9.0) || is_at(side, 2, 20.0);
        faces.extend(if is_outwards {
            [a, b, c, a, c, d]
        } else {
            [c, b, a, d, c, a]
        });
    }
    let mut builder = GeometryBuilder::new([Material::opaque([1.0; 3])]);
    let mesh = builder.mesh(Mesh::triangles(&corners, &faces, MaterialId(0)).expect("twelve triangles"));
    builder.item("hall", mesh, Transform::IDENTITY);
    let mut scene = SceneBuilder::new();
    scene.add("all", builder.build().expect("sound"), Method::ZBuffer);
    let found = survey(&scene.build().expect("one sector"), 24);
    assert_eq!(found.views.len(), 24);
    let hall = solid(min, max);
    assert!(
        !found.views.iter().any(|place| is_within(place, &hall, 0.0, 1.0)),
        "{:?}",
        places(&found)
    );
}

#[test]
fn a_survey_of_an_object_is_around_it() {
    let chair = [
        solid([0.0, 0.0, 0.0], [0.5, 0.45, 0.5]),
        solid([0.0, 0.45, 0.0], [0.5, 0.9, 0.1]),
    ];
    let found = survey(&scene(&chair, 1.0, false), 16);
    assert_eq!((found.views.len(), found.rooms), (16, 0));
    let around = solid([0.0; 3], [0.5, 0.9, 0.5]);
    assert!(
        !found
            .views
            .iter()
            .any(|place| is_within(place, &around, 0.0, 1.0))
    );
    for end in [false, true] {
        let side = found.views.iter().filter(|place| (place.eye[0] > 0.25) == end);
        assert!(side.count() >= 3, "{:?}", places(&found));
    }
}

#[test]
fn every_view_of_a_survey_sees_something() {
    let mut viewer = Viewer::new();
    for name in NAMES.into_iter().filter(|&name| name != "enfilade") {
        let scene = built_in(name).expect("it is built in").scene;
        for place in survey(&scene, 6).views {
            let view = View::new(place.eye, place.toward, [64, 36]).expect("a valid view");
            assert!(
                !viewer.look(&scene, &view).items().is_empty(),
                "@{name} from {place:?}"
            );
        }
    }
}

#[test]
fn a_survey_is_the_same_every_time() {
    let scene = built_in("enfilade").expect("it is built in").scene;
    let found = survey(&scene, 12);
    assert_eq!(found.views, survey(&scene, 12).views);
    assert_eq!(found.views.len(), 12);
    assert!(found.rooms >= 4, "{}", found.rooms);
}

#[test]
fn a_hard_survey_stands_in_openings_and_at_faces() {
    let scene = built_in("two-rooms").expect("it is built in").scene;
    let found = survey_hard(&scene, 40);
    assert_eq!(found.len(), 40);
    assert_eq!(found, survey_hard(&scene, 40));
    // Its doorway is in the plane x = 0.
    let in_the_plane = found.iter().filter(|place| place.eye[0] == 0.0);
    assert!(in_the_plane.count() > 0, "{found:?}");
}
