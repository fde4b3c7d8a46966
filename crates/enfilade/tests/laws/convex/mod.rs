//! Convex cells: convex geometry has exact visibility, and non-convex geometry is rejected with the offending face.

mod refused;
mod worlds;

use crate::subject::{SIZE, drawn, limits, subjects, viewer};
use enfilade::laws::Reference;
use enfilade::{
    Camera, ConvexPolygon, GeometryBuilder, ItemIndex, MaterialId, Method, OpeningId, Owner, Scene,
    SceneBuilder, SectorId, Transform, View,
};
use enfilade_scenes::Random;
use glam::DVec3;
use proptest::prelude::*;
use worlds::{Dress, FIRST, Solid, materials, place, polygons, through};

/// Compares looks and pictures with the reference. Returns the number of certainly visible items.
pub(crate) fn keeps_its_contract(scene: &Scene, views: &[View], place: &str) -> usize {
    let reference = Reference::new(scene);
    let mut looked_at = 0;
    for (number, view) in views.iter().enumerate() {
        let truth = reference.see(scene, view, &limits());
        looked_at += truth.visible().len();
        let mut viewer = viewer();
        let picture = drawn(&mut viewer, scene, view);
        let verdict = truth.check(viewer.visible(), Some(&picture));
        let first = truth.different(&picture).next();
        let why = first.map(|at| format!("{at:?} is {:?}, not {}", picture.owner(at), truth.describe(at)));
        let told = format!("{place}, view {number} from {:?}", view.eye());
        assert_eq!(verdict.pixels_different, 0, "{told}: {why:?}");
        assert_eq!((verdict.missed, verdict.extra), (Vec::new(), 0), "{told}");
    }
    looked_at
}

pub(crate) fn view(sector: SectorId, eye: DVec3, toward: DVec3, near: f32) -> View {
    let camera = camera(sector, eye, toward, near);
    camera.view([64, 48]).expect("a valid view")
}

pub(crate) fn camera(sector: SectorId, eye: DVec3, toward: DVec3, near: f32) -> Camera {
    Camera {
        sector: Some(sector),
        fov_y: 1.3,
        z_near: Some(near),
        ..Camera::new(eye.as_vec3().to_array(), toward.as_vec3().to_array())
    }
}

/// Views from random positions inside, close to walls, in an opening's frame, and outside.
fn views(solid: &Solid, random: &mut Random, close: bool) -> Vec<View> {
    let size = solid.corners[0].distance(solid.corners[1]);
    let mut views = Vec::new();
    for look in 0..8 {
        let face = random.below(solid.faces.len());
        let near = if close {
            [0.0, 0.5, 0.9999, 1.0001][look % 4]
        } else {
            [0.0, 0.4][look % 2]
        };
        let mut eye = solid.point(random, if near > 1.0 { 0 } else { face }, near);
        if look > 5 {
            eye = eye * 3.0 - solid.point(random, face, 0.0) * 2.0;
        }
        let toward = solid.point(random, face, 0.3);
        let near = (size * [1e-3, 0.3][look / 4]) as f32;
        views.push(view(SectorId(0), eye, toward, near));
    }
    views
}

fn dress(random: &mut Random) -> Dress {
    Dress {
        double_sided: random.below(3),
        apart: random.once_in(2),
        triangles: random.once_in(2),
        openings: random.below(3),
        pictures: false,
        glass: random.once_in(2),
    }
}

/// One cell; its first opening, if any, is a mirror.
fn alone(solid: &Solid, random: &mut Random, dress: &Dress) -> Scene {
    let mut scene = SceneBuilder::new();
    let cell = scene.add("cell", solid.geometry(random, dress), Method::Cell);
    if dress.openings > 0 {
        scene.mirror(cell, FIRST);
    }
    scene.build().expect("it is convex")
}

/// Cells in a row, each seen through an opening of the one before; some with another method.
fn chain(solids: &[Solid], random: &mut Random, dress: &Dress) -> Scene {
    let mut scene = SceneBuilder::new();
    for solid in solids {
        let method = if random.once_in(4) {
            Method::HierarchicalZ
        } else {
            Method::Cell
        };
        scene.add("cell", solid.geometry(random, dress), method);
    }
    for (from, pair) in (0..).zip(solids.windows(2)) {
        let there_from_here = through(&pair[0].outline(1), &pair[1].outline(0));
        let here = (SectorId(from), enfilade::OpeningId(1));
        scene.portal(here, (SectorId(from + 1), FIRST), there_from_here);
    }
    scene.build().expect("they are convex")
}

proptest! {
    #![proptest_config(crate::by_chance())]

    #[test]
    fn a_convex_room_is_seen_from_anywhere(seed in any::<u64>()) {
        let random = &mut Random::new(seed);
        let solid = match random.below(4) {
            0 => Solid::cuboid([1.0, 0.7, 2.0]),
            1 => Solid::prism(3 + random.below(9), 4.0),
            _ => Solid::by_chance(random),
        };
        let solid = solid.placed(&place(random, 30.0));
        let dress = dress(random);
        let scene = alone(&solid, random, &dress);
        keeps_its_contract(&scene, &views(&solid, random, true), &format!("seed {seed}"));
    }

    #[test]
    fn pictures_lie_flat_on_walls(seed in any::<u64>()) {
        let random = &mut Random::new(seed);
        let dress = Dress { pictures: true, ..dress(random) };
        let straight = random.once_in(2);
        let solid = if straight {
            Solid::cuboid([1.0, 0.75, 2.0])
        } else {
            Solid::by_chance(random).placed(&place(random, 3.0))
        };
        let scene = alone(&solid, random, &dress);
        keeps_its_contract(&scene, &views(&solid, random, straight), &format!("seed {seed}"));
    }

    #[test]
    fn convex_rooms_in_a_row_are_seen_through_their_doors(seed in any::<u64>()) {
        let random = &mut Random::new(seed);
        let solids: Vec<Solid> =
            (0..3).map(|_| Solid::by_chance(random).placed(&place(random, 10.0))).collect();
        let dress = Dress { openings: 2, ..dress(random) };
        let scene = chain(&solids, random, &dress);
        let mut views = views(&solids[0], random, true);
        for look in &mut views {
            // Mostly out of the door.
            if random.once_in(3) {
                continue;
            }
            let camera = Camera {
                sector: look.sector,
                fov_y: look.fov_y(),
                z_near: Some(look.z_near()),
                ..Camera::new(look.eye(), solids[0].point(random, 1, 1.0).as_vec3().as_dvec3().into())
            };
            *look = camera.view(look.size()).unwrap_or(*look);
        }
        keeps_its_contract(&scene, &views, &format!("seed {seed}"));
    }

    #[test]
    fn a_room_of_copies_of_one_square_turned_into_place_is_convex(seed in any::<u64>()) {
        let random = &mut Random::new(seed);
        let place = place(random, 30.0);
        let mut builder = GeometryBuilder::new(materials());
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].to_vec();
        let square = builder.mesh(polygons(&[corners], random.once_in(2), MaterialId(0)));
        let solid = Solid::cuboid([0.5, 1.0, 2.0]).placed(&place);
        for face in &solid.faces {
            let [a, b, d] = [face[0], face[1], face[3]].map(|at| solid.corners[at]);
            let columns = [b - a, d - a, (b - a).cross(d - a).normalize(), a];
            let there = Transform::from_columns(columns.map(|column| column.as_vec3().into()));
            builder.item("wall", square, there);
        }
        let mut scene = SceneBuilder::new();
        scene.add("room", builder.build().expect("sound"), Method::Cell);
        let scene = scene.build().map_err(|why| TestCaseError::fail(why.to_string()))?;
        keeps_its_contract(&scene, &views(&solid, random, true), &format!("seed {seed}"));
    }
}

#[test]
fn worlds_by_chance_show_something() {
    let mut looked_at = 0;
    for seed in 0..8 {
        let random = &mut Random::new(seed);
        let solids = [0; 3].map(|_| Solid::by_chance(random).placed(&place(random, 10.0)));
        let dress = Dress {
            openings: 2,
            apart: true,
            glass: true,
            ..Dress::default()
        };
        let scene = chain(&solids, random, &dress);
        let eye = solids[0].point(random, 0, 0.3);
        let door = solids[0].point(random, 1, 1.0);
        let place = format!("seed {seed}");
        looked_at += keeps_its_contract(&scene, &[view(SectorId(0), eye, door, 1e-3)], &place);
    }
    assert!(looked_at > 40, "{looked_at}");
}

/// A box-shaped room whose walls are double-sided, each an item.
fn double_sided_box() -> (Solid, Scene) {
    let solid = Solid::cuboid([1.0, 1.0, 1.0]);
    let dress = Dress {
        double_sided: 1,
        apart: true,
        ..Dress::default()
    };
    let scene = alone(&solid, &mut Random::new(0), &dress);
    (solid, scene)
}

#[test]
fn from_outside_a_double_sided_box_shows_the_sides_that_are_near() {
    let (_, scene) = double_sided_box();
    let outside = view(SectorId(0), DVec3::new(3.0, 4.0, 5.0), DVec3::ZERO, 0.1);
    let mut viewer = viewer();
    let items: Vec<ItemIndex> = viewer
        .look(&scene, &outside)
        .items()
        .iter()
        .map(|seen| seen.item.index)
        .collect();
    // The sides at +x, +y and +z, and no side that they hide.
    assert_eq!(items, [0, 2, 4].map(ItemIndex));
    assert_eq!(keeps_its_contract(&scene, &[outside], "outside"), 3);
    let inside = view(
        SectorId(0),
        DVec3::new(0.0, 0.0, 0.9),
        DVec3::new(0.3, 0.2, -1.0),
        0.01,
    );
    assert!(keeps_its_contract(&scene, &[inside], "inside") >= 3);
}

#[test]
fn a_block_seen_from_outside_is_as_convex_as_a_room() {
    let mut block = Solid::cuboid([1.0, 1.0, 1.0]);
    block.faces.iter_mut().for_each(|face| face.reverse());
    let dress = Dress {
        apart: true,
        ..Dress::default()
    };
    let scene = alone(&block, &mut Random::new(0), &dress);
    let outside = view(SectorId(0), DVec3::new(3.0, 4.0, 5.0), DVec3::ZERO, 0.1);
    assert_eq!(keeps_its_contract(&scene, &[outside], "outside"), 3);
    let inside = view(SectorId(0), DVec3::ZERO, DVec3::X, 0.01);
    assert_eq!(keeps_its_contract(&scene, &[inside], "inside"), 0);
}

/// Distance between f32 coordinates around 100.
const STEP: f32 = 1.0 / (1 << 17) as f32;

/// A wall, and before it two that face away from it, which `outer` adds. They count as in one plane, that of the first.
fn between_outer_walls(outer: impl Fn(&mut GeometryBuilder, &ConvexPolygon)) -> GeometryBuilder {
    let mut builder = GeometryBuilder::new(materials());
    let wall = [[99.0, 99.0], [99.0, 102.0], [102.0, 102.0], [102.0, 99.0]].map(|[y, z]| [101.0, y, z]);
    let mesh = builder.mesh(polygons(&[wall.to_vec()], false, MaterialId(0)));
    builder.item("wall", mesh, Transform::IDENTITY);
    for [x, z] in [[100.0 - 2.0 * STEP, 99.0], [100.0, 100.0]] {
        let outline = ConvexPolygon::rectangle([x, 100.0, z], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
        outer(&mut builder, &outline.expect("flat"));
    }
    builder
}

/// Looks at the second of them, from behind the first.
fn look_at_outer_wall() -> View {
    let eye = DVec3::new(f64::from(100.0 - STEP), 100.5, 100.5);
    view(SectorId(0), eye, eye + DVec3::X, 1e-6)
}

#[test]
fn an_eye_closer_to_a_mirror_than_two_steps_of_the_coordinates_sees_nothing_behind_it() {
    let builder = between_outer_walls(|builder, outline| {
        builder.opening("opening", outline.clone());
    });
    let mut scene = SceneBuilder::new();
    let cell = scene.add("cell", builder.build().expect("sound"), Method::Cell);
    scene.mirror(cell, OpeningId(1));
    let scene = scene.build().expect("it is convex");
    assert_eq!(
        keeps_its_contract(&scene, &[look_at_outer_wall()], "before a mirror"),
        0
    );
}

#[test]
fn an_eye_closer_to_a_wall_than_two_steps_of_the_coordinates_sees_nothing_behind_it() {
    let builder = between_outer_walls(|builder, outline| {
        let mesh = builder.mesh(polygons(&[outline.corners().to_vec()], false, MaterialId(0)));
        builder.item("outer wall", mesh, Transform::IDENTITY);
    });
    let mut scene = SceneBuilder::new();
    scene.add("cell", builder.build().expect("sound"), Method::Cell);
    let scene = scene.build().expect("it is convex");
    let picture = drawn(&mut viewer(), &scene, &look_at_outer_wall());
    assert_eq!(picture.owner([32, 24]), Some(Owner::Face(ItemIndex(2), 0)));
    keeps_its_contract(&scene, &[look_at_outer_wall()], "before a wall");
}

#[test]
fn a_wall_hides_the_one_behind_it_although_the_eye_is_within_a_step_of_that_ones_plane() {
    let mut builder = GeometryBuilder::new(materials());
    let beside = [[99.0, 100.0], [99.0, 102.0], [102.0, 102.0], [102.0, 100.0]].map(|[y, z]| [100.0, y, z]);
    let before = [[100.0, 99.0], [102.0, 99.0], [102.0, 102.0], [100.0, 102.0]].map(|[x, y]| [x, y, 100.0]);
    for wall in [beside, before] {
        let mesh = builder.mesh(polygons(&[wall.to_vec()], false, MaterialId(1)));
        builder.item("wall", mesh, Transform::IDENTITY);
    }
    let mut scene = SceneBuilder::new();
    scene.add("corner", builder.build().expect("sound"), Method::Cell);
    let scene = scene.build().expect("it is convex");
    let eye = DVec3::new(f64::from(100.0 + STEP), 100.5, f64::from(100.0 - 4.0 * STEP));
    let view = view(SectorId(0), eye, eye + DVec3::Z, 1e-6);
    // The wall whose plane is one step away is behind the other at this pixel.
    let picture = drawn(&mut viewer(), &scene, &view);
    assert_eq!(picture.owner([35, 24]), Some(Owner::Face(ItemIndex(1), 0)));
    keeps_its_contract(&scene, &[view], "at a corner");
}

/// A square wall at z = −2 with this half side, facing the eye at the origin.
fn square(half: f32) -> Vec<[f32; 3]> {
    [[-half, -half], [half, -half], [half, half], [-half, half]]
        .map(|[x, y]| [x, y, -2.0])
        .to_vec()
}

#[test]
fn of_faces_in_one_plane_the_lowest_is_seen_in_one_mesh_and_over_items() {
    let middle = |builder: GeometryBuilder| {
        let mut scene = SceneBuilder::new();
        scene.add("wall", builder.build().expect("sound"), Method::Cell);
        let scene = scene.build().expect("flat is convex");
        let ahead = view(SectorId(0), DVec3::ZERO, -DVec3::Z, 0.1);
        drawn(&mut viewer(), &scene, &ahead).owner([32, 24])
    };
    for sizes in [[0.5, 3.0], [3.0, 0.5]] {
        let mut builder = GeometryBuilder::new(materials());
        for size in sizes {
            let mesh = builder.mesh(polygons(&[square(size)], false, MaterialId(0)));
            builder.item("square", mesh, Transform::IDENTITY);
        }
        assert_eq!(middle(builder), Some(Owner::Face(ItemIndex(0), 0)), "{sizes:?}");
        let mut builder = GeometryBuilder::new(materials());
        let mesh = builder.mesh(polygons(&sizes.map(square), false, MaterialId(0)));
        builder.item("squares", mesh, Transform::IDENTITY);
        assert_eq!(middle(builder), Some(Owner::Face(ItemIndex(0), 0)), "{sizes:?}");
    }
}

#[test]
fn built_in_scenes_that_are_convex_are_seen_as_such() {
    let mut suited = Vec::new();
    for subject in subjects() {
        let Some((_, scene)) = subject.seen.iter().find(|(method, _)| *method == Method::Cell) else {
            continue;
        };
        let cameras = subject.built.cameras.iter();
        let views: Vec<View> = cameras
            .map(|camera| camera.view(SIZE).expect("a valid view"))
            .collect();
        let looked_at = keeps_its_contract(scene, &views, subject.name);
        suited.push((subject.name, looked_at > 0));
    }
    // Solids seen from outside, as far as they are convex.
    let solids = [
        "tetrahedron",
        "wrong-winding",
        "cylinders-8",
        "cylinders-16",
        "cylinders-32",
    ];
    let cones = ["cones-8", "cones-16", "cones-32"];
    let all = solids.into_iter().chain(cones).map(|name| (name, true));
    assert_eq!(suited, all.collect::<Vec<_>>());
}
