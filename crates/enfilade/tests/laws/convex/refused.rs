//! Non-convex cells are rejected, and the error names the offending face.

use super::worlds::{Dress, Solid, materials, place, polygons};
use super::{alone, keeps_its_contract, view};
use enfilade::{
    ConvexPolygon, FaceName, Geometry, GeometryBuilder, ItemIndex, ItemOptions, MaterialId, Mesh, Method,
    NotConvex, SceneBuilder, SceneError, SectorId, Transform, Unsuited, UnsuitedMethod,
};
use enfilade_scenes::Random;
use glam::DVec3;
use proptest::prelude::*;
use std::sync::Arc;

fn refusal(geometry: &Arc<Geometry>) -> NotConvex {
    match Method::Cell.build(Arc::clone(geometry), u64::MAX) {
        Err(UnsuitedMethod {
            reason: Unsuited::NotConvex(why),
            ..
        }) => *why,
        Err(why) => panic!("{why}"),
        Ok(_) => panic!("it is taken for convex"),
    }
}

fn corners_of(geometry: &Geometry, name: &FaceName) -> Vec<DVec3> {
    let FaceName::OfItem { number, face, .. } = name else {
        panic!("{name} is an opening");
    };
    let item = geometry.item(ItemIndex(*number));
    let mesh = geometry.mesh_of(ItemIndex(*number));
    let corners = mesh
        .face(*face)
        .iter()
        .map(|&at| item.transform().point(mesh.positions()[at as usize]));
    corners.map(|corner| DVec3::from(corner.map(f64::from))).collect()
}

/// Returns `true` if the error's claim is correct.
fn is_true(geometry: &Geometry, why: &NotConvex) {
    let wall = corners_of(geometry, &why.wall);
    let normal = (wall[1] - wall[0]).cross(wall[2] - wall[0]).normalize();
    let point = DVec3::from(why.point.map(f64::from));
    let by = -normal.dot(point - wall[0]);
    assert!((by - f64::from(why.by)).abs() < 1e-3 * by, "{why}: {by}");
    let behind = corners_of(geometry, &why.behind);
    assert!(behind.iter().any(|corner| corner.distance(point) < 1e-5), "{why}");
}

proptest! {
    #![proptest_config(crate::by_chance())]

    #[test]
    fn a_corner_that_is_pulled_in_is_refused_by_a_face_at_it_or_behind_which_it_is(seed in any::<u64>()) {
        let random = &mut Random::new(seed);
        let mut solid = Solid::by_chance(random);
        let pulled = random.below(solid.corners.len());
        solid.corners[pulled] *= 0.2;
        let dress = Dress { triangles: true, apart: random.once_in(2), ..Dress::default() };
        let geometry = Arc::new(solid.geometry(random, &dress));
        let why = refusal(&geometry);
        is_true(&geometry, &why);
        let dent = solid.corners[pulled].as_vec3();
        let is_at_it = |name| corners_of(&geometry, name).iter().any(|at| at.as_vec3() == dent);
        prop_assert!(is_at_it(&why.wall) || is_at_it(&why.behind), "{}", why);
    }

    #[test]
    fn a_chest_in_a_room_is_refused_by_name(seed in any::<u64>()) {
        let random = &mut Random::new(seed);
        let room = Solid::by_chance(random);
        let mut chest = Solid::cuboid([0.1, 0.15, 0.2]);
        chest.faces.iter_mut().for_each(|face| face.reverse());
        let mut builder = GeometryBuilder::new(materials());
        for (name, solid) in [("walls", &room), ("chest", &chest)] {
            let faces = solid.faces.iter();
            let faces: Vec<_> = faces.map(|face| face.iter().map(|&at| solid.corner(at)).collect()).collect();
            let mesh = builder.mesh(polygons(&faces, random.once_in(2), MaterialId(0)));
            let there = Transform::translation(random.point(0.3));
            builder.item(name, mesh, if name == "chest" { there } else { Transform::IDENTITY });
        }
        let geometry = Arc::new(builder.build().expect("sound"));
        let why = refusal(&geometry);
        is_true(&geometry, &why);
        prop_assert!(matches!(&why.wall, FaceName::OfItem { item, .. } if item == "chest"), "{}", why);
    }

    #[test]
    fn a_wall_of_many_small_faces_is_flat_though_each_of_them_is_tilted(seed in any::<u64>()) {
        let random = &mut Random::new(seed);
        let place = place(random, 30.0);
        let at = |u: usize, v: usize| place.transform_point3(DVec3::new(u as f64 / 60.0, 0.3, v as f64 / 60.0));
        let mut builder = GeometryBuilder::new(materials());
        let mut tiles = Vec::new();
        for u in 0..60 {
            for v in 0..60 {
                let tile = [at(u, v), at(u, v + 1), at(u + 1, v + 1), at(u + 1, v)];
                tiles.push(tile.map(|corner| corner.as_vec3().into()).to_vec());
            }
        }
        let mesh = builder.mesh(polygons(&tiles, true, MaterialId(0)));
        builder.item("tiles", mesh, Transform::IDENTITY);
        // An item at the wall shows which of its sides is inside.
        let foot = [at(0, 0), at(60, 0), place.transform_point3(DVec3::new(0.5, 0.8, 0.0))];
        let foot = foot.map(|corner| corner.as_vec3().into());
        let mesh = builder.mesh(Mesh::triangles(&foot, &[0, 1, 2], MaterialId(0)).expect("a triangle"));
        builder.item("side", mesh, Transform::IDENTITY);
        let geometry = Arc::new(builder.build().expect("sound"));
        let built = Method::Cell.build(geometry, u64::MAX);
        prop_assert!(built.is_ok(), "{:?}", built.err());
    }
}

#[test]
fn a_refusal_says_what_is_where_and_what_to_do() {
    let mut builder = GeometryBuilder::new(materials());
    for (name, corners) in [
        ("floor", [[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0]]),
        ("cellar", [[1.0, -0.5, 1.0], [1.0, -0.5, 2.0], [2.0, -0.5, 1.0]]),
        ("lamp", [[1.0, 2.0, 1.0], [2.0, 2.0, 1.0], [1.0, 2.0, 2.0]]),
    ] {
        let mesh = builder.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("a triangle"));
        builder.item(name, mesh, Transform::IDENTITY);
    }
    let geometry = Arc::new(builder.build().expect("sound"));
    let told = "needs a convex sector, but face 0 of item 1 `cellar` is 0.5 behind the plane of face 0 of item 0 \
                `floor` at (1, -0.5, 1), and another face is in front of it; use hierarchical-z";
    assert_eq!(refusal(&geometry).to_string(), told);
    let mut scene = SceneBuilder::new();
    scene.add("house", geometry, Method::Cell);
    let error = scene.build().err().expect("it is not convex");
    assert!(matches!(&error, SceneError::Unsuited { sector, .. } if sector == "house"));
    assert_eq!(error.to_string(), format!("sector `house`: method cell {told}"));
}

#[test]
fn nothing_and_what_has_no_area_is_convex() {
    let mut builder = GeometryBuilder::new(materials());
    assert!(Method::Cell.suits(&builder.clone().build().expect("nothing")));
    let room = Solid::cuboid([1.0; 3]);
    let faces: Vec<_> = (room.faces.iter())
        .map(|face| face.iter().map(|&at| room.corner(at)).collect())
        .collect();
    let mesh = builder.mesh(polygons(&faces, true, MaterialId(0)));
    builder.item("walls", mesh, Transform::IDENTITY);
    for corners in [[[5.0; 3]; 3], [[0.0; 3], [3.0, 0.0, 0.0], [9.0, 0.0, 0.0]]] {
        let mesh = builder.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("no area"));
        builder.item("thread", mesh, Transform::IDENTITY);
    }
    assert!(Method::Cell.suits(&builder.build().expect("sound")));
}

#[test]
fn an_edit_that_dents_a_cell_is_refused_and_leaves_it_as_it_was() {
    let solid = Solid::cuboid([1.0; 3]);
    let dress = Dress {
        apart: true,
        ..Dress::default()
    };
    let mut scene = alone(&solid, &mut Random::new(0), &dress);
    let ahead = view(SectorId(0), DVec3::ZERO, DVec3::X, 0.01);
    let sheet = [[0.0, -0.5, -0.5], [0.0, 0.5, -0.5], [0.0, 0.0, 0.5]];
    let sheet = Arc::new(Mesh::triangles(&sheet, &[0, 1, 2], MaterialId(1)).expect("a triangle"));
    let mut edit = scene.edit();
    edit.add(SectorId(0), "screen", Arc::clone(&sheet), Transform::IDENTITY)
        .expect("it fits");
    let why = edit.finish().expect_err("a screen in the middle");
    assert!(why.to_string().contains("`screen`"), "{why}");
    assert_eq!(scene.item_count(), 6);
    let seen = keeps_its_contract(&scene, &[ahead], "as before");
    let mut edit = scene.edit();
    let frame = ConvexPolygon::rectangle([0.0; 3], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]).expect("a square");
    edit.add_opening(SectorId(0), "gate", frame).expect("few");
    let why = edit.finish().expect_err("a gate in the middle");
    assert!(why.to_string().contains("`gate`"), "{why}");
    assert_eq!(scene.sector(SectorId(0)).openings(), []);
    // Items that are no occluders may be added and removed without a rebuild.
    let mut edit = scene.edit();
    let ghost = edit.add(
        SectorId(0),
        "ghost",
        sheet,
        Transform::translation([0.5, 0.0, 0.0]),
    );
    let ghost = ghost.expect("it fits");
    edit.set_options(
        SectorId(0),
        ghost,
        ItemOptions {
            is_occluder: false,
            ..ItemOptions::default()
        },
    )
    .expect("it is there");
    assert_eq!(edit.finish().expect("it hides nothing").rebuilt, 0);
    assert_eq!(keeps_its_contract(&scene, &[ahead], "with a ghost"), seen + 1);
    // The cell stays convex if a wall is removed, or moved within its plane.
    let mut edit = scene.edit();
    edit.remove(SectorId(0), ItemIndex(5).into())
        .expect("it is there");
    edit.set_transform(
        SectorId(0),
        ItemIndex(4).into(),
        Transform::scaling([0.5, 0.5, 1.0]),
    )
    .expect("it is there");
    assert_eq!(edit.finish().expect("still convex").rebuilt, 1);
    keeps_its_contract(&scene, &[ahead], "without a wall");
}
