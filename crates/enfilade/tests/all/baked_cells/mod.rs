//! Baked cells (PVS): no false culls from any position and for any moving item.

mod bad;
mod deep;

use enfilade::laws::{OwnerPicture, Reference};
use enfilade::{
    BakedCells, Camera, ConvexPolygon, Geometry, GeometryBuilder, ItemIndex, Limits, Method, Scene,
    SceneBuilder, SectorId, Transform, View, Viewer,
};
use enfilade_scenes::{BuiltIn, Random, built_in, random_house};
use std::sync::Arc;

const SIZE: [u32; 2] = [64, 48];
const HOUSE: SectorId = SectorId(0);

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_crossings = 3;
    limits
}

fn by_cells(scene: &Scene) -> Scene {
    scene
        .with_method(Method::Pvs, Method::DEFAULT_LIMIT)
        .expect("it has cells")
}

/// Looks and draws, and compares both with the reference at `places` random positions per pixel. Returns the numbers of
/// certainly visible items and of items in the set.
fn holds(scene: &Scene, reference: &Reference, view: &View, places: u32, place: &str) -> [usize; 2] {
    let mut viewer = Viewer::new();
    viewer.options.limits = limits();
    let anywhere = reference.see_anywhere(scene, view, &limits(), places, 7);
    assert_eq!(
        anywhere.check(viewer.look(scene, view), None).missed,
        [],
        "{place}"
    );
    let counts = [anywhere.visible().len(), viewer.visible().items().len()];
    let truth = reference.see(scene, view, &limits());
    let mut picture = OwnerPicture::new(view.size());
    viewer.draw(scene, view, &mut picture);
    let verdict = truth.check(viewer.visible(), Some(&picture));
    assert_eq!((verdict.missed, verdict.pixels_different), (vec![], 0), "{place}");
    counts
}

/// Returns the names of the items in the set, in order.
fn names(scene: &Scene, view: &View) -> Vec<String> {
    let geometry = scene.geometry(HOUSE).expect("ours");
    let mut viewer = Viewer::new();
    let items = viewer.look(scene, view).items().iter();
    items
        .map(|seen| format!("{} {}", seen.item.index.0, geometry.name(seen.item.index)))
        .collect()
}

/// Returns the same geometry with other cells.
fn with_cells(geometry: &Geometry, cells: Option<Arc<BakedCells>>) -> Geometry {
    let mut builder = GeometryBuilder::new(geometry.materials());
    for (number, item) in geometry.items().iter().enumerate() {
        let mesh = builder.mesh(Arc::clone(&geometry.meshes()[item.mesh.0 as usize]));
        builder.item(geometry.name(ItemIndex(number as u32)), mesh, item.transform());
    }
    for opening in geometry.openings() {
        builder.opening(&opening.name, opening.outline.clone());
    }
    cells.into_iter().for_each(|cells| builder.cells(cells));
    builder.build().expect("as sound as it was")
}

/// Returns the same cells with everything potentially visible from each.
fn blind(cells: &BakedCells) -> Arc<BakedCells> {
    let rows: [[enfilade::CellId; 0]; 0] = [];
    let row_of = vec![None; cells.cell_count()];
    Arc::new(BakedCells::new(cells.tree().clone(), &row_of, rows).expect("as sound as they were"))
}

#[test]
fn nothing_is_missed_anywhere_in_a_pixel_in_houses_made_by_chance_and_much_is_left_out() {
    let [mut seen, mut in_set, mut in_view] = [0; 3];
    for seed in 0..24 {
        let BuiltIn { scene, cameras } = random_house(seed);
        let reference = Reference::new(&scene);
        let geometry = scene.geometry(HOUSE).expect("ours");
        let cells = geometry.cells().expect("it is baked");
        let mut all = by_cells(&scene);
        all.set_geometry(HOUSE, with_cells(geometry, Some(blind(cells))))
            .expect("it fits");
        let scene = by_cells(&scene);
        for camera in &cameras {
            let view = camera.view(SIZE).expect("a valid view");
            let place = format!("house {seed}, {camera:?}");
            let counts = holds(&scene, &reference, &view, 4, &place);
            seen += counts[0];
            in_set += counts[1];
            in_view += names(&all, &view).len();
        }
    }
    assert!(seen > 1500, "hardly anything is seen: {seen}");
    assert!(
        2 * in_set < 5 * seen && 4 * in_set < 3 * in_view,
        "{seen} seen, {in_set} in sets, {in_view} in view"
    );
}

#[test]
fn eyes_on_walls_in_doorways_in_rock_and_outside_miss_nothing() {
    let mut seen = 0;
    for seed in 100..108 {
        let BuiltIn { scene, .. } = random_house(seed);
        let reference = Reference::new(&scene);
        let bounds = scene.bounds(HOUSE);
        let scene = by_cells(&scene);
        let mut random = Random::new(seed);
        for number in 0..24 {
            let mut anywhere = |out: f32| -> [f32; 3] {
                [0, 1, 2].map(|axis| {
                    let size = bounds.max[axis] - bounds.min[axis];
                    bounds.min[axis] + size * ((1.0 + 2.0 * out) * random.unit() - out)
                })
            };
            let [mut eye, toward] = [anywhere(0.1), anywhere(0.0)];
            // All planes of the house are at integer coordinates.
            match number % 4 {
                0 => eye[0] = eye[0].round(),
                1 => eye[2] = eye[2].round().next_up(),
                2 => eye = [eye[0].round(), eye[1].round(), eye[2].round()],
                _ => {}
            }
            let camera = Camera {
                // 0.75 is so far away that walls are in front of it.
                z_near: (number % 3 == 0).then_some(0.75),
                ..Camera::new(eye, toward)
            };
            let view = camera.view(SIZE).expect("a valid view");
            seen += holds(&scene, &reference, &view, 3, &format!("house {seed}, {view:?}"))[0];
        }
    }
    assert!(seen > 1000, "{seen}");
}

#[test]
fn openings_cut_anywhere_into_a_baked_house_miss_nothing() {
    let mut seen = 0;
    for seed in 200..212 {
        let BuiltIn { scene, cameras } = random_house(seed);
        let mut scene = by_cells(&scene);
        let (mut random, bounds) = (Random::new(seed), scene.bounds(HOUSE));
        for number in 0..3 {
            let corner = random.point_in(&bounds);
            let turn = Transform::rotation(random.point(1.0), f64::from(random.between(0.0, 6.0)));
            let [along, up] = [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]].map(|side| turn.direction(side));
            let outline = ConvexPolygon::rectangle(corner, along, up).expect("a square");
            let there = match number {
                0 => Transform::reflection(corner, outline.normal()),
                1 => turn,
                _ => Transform::IDENTITY,
            };
            let mut edit = scene.edit();
            let opening = edit.add_opening(HOUSE, "new", outline).expect("few");
            assert_eq!(edit.finish().expect("small").rebuilt, 1);
            scene
                .add_portal((HOUSE, opening), HOUSE, there)
                .expect("a portal");
        }
        let reference = Reference::new(&scene);
        for camera in &cameras {
            let view = camera.view(SIZE).expect("a valid view");
            seen += holds(&scene, &reference, &view, 3, &format!("house {seed}, {camera:?}"))[0];
        }
    }
    assert!(seen > 500, "{seen}");
}

#[test]
fn what_is_seen_through_doors_mirrors_and_gates_begins_at_their_openings() {
    let BuiltIn { scene, cameras } = built_in("house").expect("a scene");
    let reference = Reference::new(&scene);
    for scene in [by_cells(&scene), by_cells(&scene).without_portals()] {
        let reference = if scene.portals().is_empty() {
            &reference
        } else {
            &Reference::new(&scene)
        };
        let mut passages = 0;
        for camera in &cameras {
            let view = camera.view(SIZE).expect("a valid view");
            holds(&scene, reference, &view, 8, &format!("{camera:?}"));
            let mut viewer = Viewer::new();
            passages += viewer.look(&scene, &view).passages().len();
        }
        assert!(passages >= cameras.len(), "{passages}");
    }
}

#[test]
fn a_room_behind_a_door_shows_what_is_seen_through_it_and_not_what_its_eye_would() {
    let BuiltIn { scene, cameras } = built_in("house").expect("a scene");
    let scene = by_cells(&scene);
    let camera = cameras.iter().find(|camera| camera.name == "before the gate");
    let view = camera.expect("a camera").view(SIZE).expect("a valid view");
    let mut viewer = Viewer::new();
    let set = viewer.look(&scene, &view);
    let behind = set.passages().iter().position(|passage| passage.sector == HOUSE);
    let behind = behind.expect("the gate leads there");
    let geometry = scene.geometry(HOUSE).expect("ours");
    let items = set
        .items()
        .iter()
        .filter(|seen| seen.passage.0 as usize == behind);
    let names: Vec<&str> = items.map(|seen| geometry.name(seen.item.index)).collect();
    assert!(names.iter().any(|name| name.starts_with("d ")), "{names:?}");
    assert!(!names.iter().any(|name| name.starts_with("f ")), "{names:?}");
}

/// Moves, adds and removes free-standing items, also into walls and out of the house.
fn edit_what_stands_free(scene: &mut Scene, count: usize, random: &mut Random) -> u64 {
    let geometry = Arc::clone(scene.geometry(HOUSE).expect("ours"));
    let is_free = |item: &ItemIndex| {
        let name = geometry.name(*item);
        geometry.holds(*item) && ["box", "ball", "pillar"].iter().any(|free| name.ends_with(free))
    };
    let free: Vec<ItemIndex> = (0..geometry.items().len() as u32)
        .map(ItemIndex)
        .filter(is_free)
        .collect();
    let bounds = geometry.bounds();
    let mut edit = scene.edit();
    for _ in 0..count {
        let item = random.pick(&free);
        let there = [0, 1, 2].map(|axis| {
            let size = bounds.max[axis] - bounds.min[axis];
            bounds.min[axis] + size * (1.2 * random.unit() - 0.1)
        });
        let middle = geometry.item(item).bounds.center().map(|value| -value);
        let stretch = [0, 1, 2].map(|_| if random.below(8) == 0 { 8.0 } else { 1.0 });
        let place = Transform::translation(there)
            * Transform::scaling(stretch)
            * Transform::rotation([1.0, 2.0, 3.0], f64::from(random.unit()))
            * Transform::translation(middle)
            * geometry.item(item).transform();
        let mesh = &geometry.meshes()[geometry.item(item).mesh.0 as usize];
        let _ = match random.below(6) {
            0 => edit
                .add(HOUSE, geometry.name(item), Arc::clone(mesh), place)
                .map(|_| ()),
            1 if free.len() > 12 => edit.remove(HOUSE, geometry.id_of(item)),
            _ => edit.set_transform(HOUSE, geometry.id_of(item), place),
        };
    }
    let done = edit.finish().expect("little");
    assert_eq!(done.rebuilt, 0, "cells are followed in place");
    done.nodes
}

#[test]
fn what_moves_is_seen_where_it_is_and_the_set_is_that_of_the_scene_built_afresh() {
    for seed in 200..206 {
        let BuiltIn { scene, cameras } = random_house(seed);
        let mut scene = by_cells(&scene);
        let mut random = Random::new(seed);
        for round in 0..4 {
            let nodes = edit_what_stands_free(&mut scene, 12, &mut random);
            assert!(nodes > 0 && nodes < 12 * 200, "{nodes}");
            let reference = Reference::new(&scene);
            let fresh = by_cells(&scene);
            for camera in cameras.iter().skip(round % 2).step_by(2) {
                let view = camera.view(SIZE).expect("a valid view");
                let place = format!("house {seed}, round {round}, {camera:?}");
                holds(&scene, &reference, &view, 2, &place);
                assert_eq!(names(&scene, &view), names(&fresh, &view), "{place}");
            }
        }
    }
}

#[test]
fn a_thing_that_stands_nowhere_is_always_looked_at_and_one_that_is_gone_never() {
    let BuiltIn { scene, .. } = random_house(1);
    let mut scene = by_cells(&scene);
    let geometry = Arc::clone(scene.geometry(HOUSE).expect("ours"));
    let ball = (0..geometry.items().len() as u32).map(ItemIndex);
    let ball = ball
        .into_iter()
        .find(|&item| geometry.name(item) == "room 0 ball")
        .expect("it has one");
    let middle = geometry.item(ball).bounds.center();
    let above = Transform::translation([0.0, 8.0, 0.0]) * geometry.item(ball).transform();
    let mut edit = scene.edit();
    edit.set_transform(HOUSE, ball.into(), above)
        .expect("it is there");
    edit.finish().expect("little");
    let eye = [middle[0] + 1.0, 9.0, middle[2]];
    // Also from inside the house, limited only by boxes: rows say nothing about items outside all cells.
    for eye in [eye, [middle[0], 1.5, middle[2]]] {
        let camera = Camera {
            up: [0.0, 0.0, 1.0],
            ..Camera::new(eye, [middle[0] + 0.001, middle[1] + 8.0, middle[2]])
        };
        let view = camera.view(SIZE).expect("a valid view");
        let name = format!("{} room 0 ball", ball.0);
        assert!(names(&scene, &view).contains(&name), "from {eye:?}");
    }
    let mut edit = scene.edit();
    edit.remove(HOUSE, ball.into()).expect("it is there");
    edit.finish().expect("little");
    let view = View::new(eye, middle, SIZE).expect("a valid view");
    assert!(
        !names(&scene, &view)
            .iter()
            .any(|name| name.ends_with("room 0 ball"))
    );
}

#[test]
fn what_has_no_cells_is_told_to_be_not_baked() {
    let scene = built_in("two-rooms").expect("a scene").scene;
    assert!(!scene.suits(Method::Pvs) && scene.suits(Method::Masked));
    let why = scene
        .with_method(Method::Pvs, u64::MAX)
        .err()
        .expect("it has no cells")
        .to_string();
    assert_eq!(
        why,
        "method pvs needs a baked PVS and this sector has none; use hierarchical-z, or bake one"
    );
    let mut builder = SceneBuilder::new();
    let geometry = Arc::clone(scene.geometry(HOUSE).expect("ours"));
    builder.add("hall", geometry, Method::Pvs);
    let why = builder.build().err().expect("it has no cells").to_string();
    assert!(
        why.starts_with("sector `hall`: method pvs needs a baked PVS"),
        "{why}"
    );
    let mut house = by_cells(&random_house(3).scene);
    let without = with_cells(house.geometry(HOUSE).expect("ours"), None);
    let why = house
        .set_geometry(HOUSE, without)
        .expect_err("it has no cells")
        .to_string();
    assert!(why.contains("needs a baked PVS"), "{why}");
    assert!(
        house.geometry(HOUSE).expect("ours").cells().is_some(),
        "it stays as it was"
    );
}

#[test]
fn what_takes_more_memory_than_allowed_is_refused() {
    let scene = random_house(4).scene;
    let geometry = scene.geometry(HOUSE).expect("ours");
    let taken = by_cells(&scene).bytes() - geometry.bytes();
    assert!(geometry.cells().expect("it is baked").bytes() < geometry.bytes());
    for limit in [0, 100, taken / 4] {
        let why = scene
            .with_method(Method::Pvs, limit)
            .err()
            .expect("it is too little")
            .to_string();
        assert!(
            why.starts_with("method pvs needs about") && why.contains(", above the limit of "),
            "{why}"
        );
    }
    assert!(scene.with_method(Method::Pvs, 4 * taken).is_ok(), "{taken} bytes");
}
