//! Edits: their effects and their errors.

use enfilade::{
    Aabb, EditError, GeometryBuilder, ItemId, ItemIndex, ItemOptions, Location, Material, MaterialId, Mesh,
    Method, Ray, Scene, SceneBuilder, SceneError, SectorId, Transform, View, Viewer,
};
use std::sync::Arc;

const HALL: SectorId = SectorId(0);
const VIEW: [u32; 2] = [96, 72];

fn leaf() -> Arc<Mesh> {
    let corners = [[-0.3, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.6, 0.0]];
    Arc::new(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("a leaf"))
}

/// A wall with three leaves in front of it.
fn hall(method: Method) -> Scene {
    let mut hall = GeometryBuilder::new([Material {
        double_sided: true,
        ..Material::opaque([0.5; 3])
    }]);
    let corners = [[-9.0, -9.0, -9.0], [9.0, -9.0, -9.0], [0.0, 9.0, -9.0]];
    let wall = hall.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("a wall"));
    hall.item("wall", wall, Transform::IDENTITY);
    let leaf = hall.mesh(leaf());
    for (name, x) in [("left", -1.0), ("middle", 0.0), ("right", 1.0)] {
        hall.item(name, leaf, Transform::translation([x, 0.0, -4.0]));
    }
    let mut scene = SceneBuilder::new();
    scene.add("hall", hall.build().expect("sound"), method);
    scene.build().expect("a hall")
}

/// Returns the id of an item that was in the hall from the beginning.
fn original(index: u32) -> ItemId {
    ItemIndex(index).into()
}

fn seen(viewer: &mut Viewer, scene: &Scene) -> Vec<String> {
    let view = View::new([0.0, 0.3, 0.0], [0.0, 0.3, -4.0], VIEW).expect("a valid view");
    let geometry = scene.geometry(HALL).expect("ours");
    let items = viewer.look(scene, &view).items().iter();
    items
        .map(|item| geometry.name(item.item.index).to_owned())
        .collect()
}

#[test]
fn what_is_removed_is_not_seen_and_its_number_goes_to_the_next_that_comes() {
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let (mut scene, mut viewer) = (hall(method), Viewer::new());
        assert_eq!(seen(&mut viewer, &scene), ["wall", "left", "middle", "right"]);
        let mut edit = scene.edit();
        edit.remove(HALL, original(1)).expect("it is there");
        edit.remove(HALL, original(2)).expect("it is there");
        assert_eq!(edit.finish().expect("little").items, 2);
        assert_eq!(seen(&mut viewer, &scene), ["wall", "right"], "{method}");
        assert_eq!(scene.item_count(), 2);
        let there = Transform::translation([0.0, 0.0, -3.0]);
        let mut edit = scene.edit();
        let [first, second, third] =
            ["a", "b", "c"].map(|name| edit.add(HALL, name, leaf(), there).expect("it fits"));
        edit.finish().expect("little");
        assert_eq!(
            [first, second, third].map(|id| (id.index.0, id.generation)),
            [(1, 1), (2, 2), (4, 3)]
        );
        assert!(seen(&mut viewer, &scene).contains(&"a".to_owned()), "{method}");
        assert_eq!(scene.item_count(), 5);
    }
}

#[test]
fn an_edit_that_is_dropped_changes_nothing() {
    let mut scene = hall(Method::HierarchicalZ);
    let before = scene.geometry(HALL).expect("ours").items().to_vec();
    let mut edit = scene.edit();
    edit.remove(HALL, original(1)).expect("it is there");
    edit.add(HALL, "new", leaf(), Transform::IDENTITY)
        .expect("it fits");
    drop(edit);
    assert_eq!(scene.geometry(HALL).expect("ours").items(), before);
}

#[test]
fn a_copy_of_a_scene_stays_as_it_was() {
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let mut scene = hall(method);
        let (copy, geometry) = (scene.clone(), scene.geometry(HALL).expect("ours").clone());
        let mut edit = scene.edit();
        edit.remove(HALL, original(1)).expect("it is there");
        edit.set_transform(HALL, original(2), Transform::translation([0.0, 50.0, 0.0]))
            .expect("it may");
        edit.finish().expect("little");
        assert_eq!(seen(&mut Viewer::new(), &scene), ["wall", "right"], "{method}");
        assert_eq!(
            seen(&mut Viewer::new(), &copy),
            ["wall", "left", "middle", "right"],
            "{method}"
        );
        assert_eq!(geometry.item_count(), 4);
    }
}

#[test]
fn a_leaf_that_is_seen_past_hides_nothing() {
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let (mut scene, mut viewer) = (hall(method), Viewer::new());
        let mut edit = scene.edit();
        // In front of the eye: first a leaf that hides everything, then the same leaf as a non-occluder.
        let near = Transform::from_columns([
            [20.0, 0.0, 0.0],
            [0.0, 20.0, 0.0],
            [0.0, 0.0, 20.0],
            [0.0, -4.0, -1.0],
        ]);
        let leaf = edit.add(HALL, "near", leaf(), near).expect("it fits");
        edit.finish().expect("little");
        let hidden = seen(&mut viewer, &scene);
        if method.contract().never_misses() {
            assert_eq!(hidden, ["near"], "{method}");
        }
        let mut edit = scene.edit();
        edit.set_options(
            HALL,
            leaf,
            ItemOptions {
                is_occluder: false,
                ..ItemOptions::default()
            },
        )
        .expect("it is there");
        edit.finish().expect("little");
        let names = ["wall", "left", "middle", "right", "near"];
        assert_eq!(seen(&mut viewer, &scene), names, "{method}");
    }
}

#[test]
fn meshes_live_as_long_as_an_item_is_a_copy_of_them() {
    let mut scene = hall(Method::Masked);
    let first = scene.geometry(HALL).expect("ours").bytes();
    for round in 0..100 {
        let mut edit = scene.edit();
        let there = Transform::translation([0.0, round as f32 * 0.01, -3.0]);
        for item in 1..4 {
            edit.set_mesh(HALL, original(item), leaf()).expect("it fits");
            edit.set_transform(HALL, original(item), there).expect("it may");
        }
        edit.finish().expect("little");
    }
    let geometry = scene.geometry(HALL).expect("ours");
    assert!(geometry.meshes().len() < 10, "{}", geometry.meshes().len());
    assert!(geometry.bytes() < 3 * first + 1000);
    assert_eq!(seen(&mut Viewer::new(), &scene).len(), 4);
}

#[test]
fn what_cannot_be_is_refused_and_the_item_stays_as_it_was() {
    let mut scene = hall(Method::HierarchicalZ);
    let before = scene.geometry(HALL).expect("ours").items().to_vec();
    let mut edit = scene.edit();
    edit.set_key(HALL, original(2), 77).expect("it is there");
    let item = original(2);
    let at = |x: f32| Transform::translation([x, 0.0, 0.0]);
    let says = |refused: Result<(), EditError>, message: &str| {
        assert_eq!(refused.expect_err(message).to_string(), message);
    };
    says(
        edit.set_transform(HALL, item, at(f32::NAN)),
        "the transform of item `middle` (key 77) contains NaN",
    );
    for far in [1e30, -1e30, f32::INFINITY] {
        says(
            edit.set_transform(HALL, item, at(far)),
            "item `middle` (key 77) would reach beyond 1e12 units; move it closer to the origin",
        );
    }
    says(
        edit.set_mesh(HALL, item, Mesh::new(&[]).expect("nothing")),
        "the mesh of item `middle` (key 77) has no faces; remove the item instead",
    );
    let of_gold = Mesh::triangles(
        &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        &[0, 1, 2],
        MaterialId(7),
    )
    .expect("a triangle");
    says(
        edit.add(HALL, "coin", of_gold, at(0.0)).map(|_| ()),
        "the mesh of item `coin` (key 4) uses material 7, but the number of materials in its sector is 1",
    );
    says(
        edit.add(HALL, "ghost", leaf(), at(f32::NAN)).map(|_| ()),
        "the transform of item `ghost` (key 4) contains NaN",
    );
    says(
        edit.remove(HALL, original(9)),
        "sector `hall` has no item 9 of generation 0; it was removed or never existed",
    );
    says(
        edit.remove(SectorId(3), item),
        "sector 3 does not exist; the scene has only 1",
    );
    edit.finish().expect("nothing to do");
    assert_eq!(scene.geometry(HALL).expect("ours").items(), before);

    let mut edit = scene.edit();
    edit.remove(HALL, item).expect("once");
    let twice = "sector `hall` has no item 2 of generation 0; it was removed or never existed";
    says(edit.remove(HALL, item), twice);
    edit.finish().expect("little");
    let mut edit = scene.edit();
    says(edit.remove(HALL, item), twice);
    says(edit.set_transform(HALL, item, at(0.0)), twice);
    edit.finish().expect("nothing to do");
}

#[test]
fn an_edit_that_needs_too_much_memory_is_undone_in_every_sector() {
    let room = |scene: &Scene| (**scene.geometry(HALL).expect("ours")).clone();
    let source = hall(Method::ZBuffer);
    let mut builder = SceneBuilder::new();
    builder.limit_bytes(40_000);
    let open = builder.add("open", room(&source), Method::HierarchicalZ);
    let tree = builder.add("tree", room(&source), Method::Bsp);
    let mut scene = builder.build().expect("small enough");
    let before = [open, tree].map(|id| scene.geometry(id).expect("ours").items().to_vec());
    let mut edit = scene.edit();
    edit.remove(open, original(1)).expect("it is there");
    let mut last = None;
    for i in 0..2000_u16 {
        let there = Transform::translation([f32::from(i), 0.0, 0.0]);
        last = Some(
            edit.add(tree, "more", leaf(), there)
                .expect("one by one they fit"),
        );
    }
    let refused = edit.finish().expect_err("a BSP tree of two thousand leaves");
    assert!(
        matches!(&refused, SceneError::Unsuited { sector, .. } if sector == "tree"),
        "{refused}"
    );
    let after = [open, tree].map(|id| scene.geometry(id).expect("ours"));
    assert_eq!(after[0].items(), before[0]);
    assert_eq!(after[1].item_count(), before[1].len());
    assert_eq!(after[1].items()[..4], before[1]);
    assert!(
        after[1].items()[4..]
            .iter()
            .all(|item| item.bounds == Aabb::EMPTY)
    );
    assert_eq!(seen(&mut Viewer::new(), &scene).len(), 4);
    let mut edit = scene.edit();
    let added = edit
        .add(tree, "one", leaf(), Transform::IDENTITY)
        .expect("it fits");
    assert!(last.is_some_and(|refused| refused.generation < added.generation));
    edit.finish().expect("little");
}

#[test]
fn a_mesh_too_large_for_its_occluders_to_be_found_is_refused() {
    let source = hall(Method::ZBuffer);
    for method in [Method::Masked, Method::Svbsp, Method::Mobsp] {
        let mut builder = SceneBuilder::new();
        builder.limit_bytes(100_000);
        let geometry = (**source.geometry(HALL).expect("ours")).clone();
        builder.add("hall", geometry, method);
        let mut scene = builder.build().expect("small enough");
        let side = 40_u32;
        let positions: Vec<[f32; 3]> = (0..side * side)
            .map(|i| [(i % side) as f32, (i / side) as f32, -3.0])
            .collect();
        let triangles = (0..side * (side - 1)).filter(|i| i % side != side - 1);
        let corners: Vec<u32> = triangles.flat_map(|i| [i, i + 1, i + side]).collect();
        let sheet = Mesh::triangles(&positions, &corners, MaterialId(0)).expect("a sheet");
        let mut edit = scene.edit();
        edit.set_mesh(HALL, original(2), sheet).expect("it may be");
        let refused = edit.finish().expect_err("the limit is small");
        assert!(
            matches!(refused, SceneError::Unsuited { .. }),
            "{method}: {refused}"
        );
        assert_eq!(seen(&mut Viewer::new(), &scene).len(), 4, "{method}");
    }
}

#[test]
fn a_set_of_the_scene_before_can_still_be_asked() {
    let (mut scene, mut viewer) = (hall(Method::HierarchicalZ), Viewer::new());
    seen(&mut viewer, &scene);
    let before = viewer.visible().triangle_count(&scene);
    let mut edit = scene.edit();
    edit.remove(HALL, original(0)).expect("it is there");
    edit.remove(HALL, original(3)).expect("it is there");
    edit.finish().expect("little");
    assert_eq!(viewer.visible().triangle_count(&scene), before - 2);
    assert_eq!(viewer.visible().blend_order(&scene), []);
}

#[test]
fn an_eye_above_an_open_hall_is_in_it_also_after_edits_and_within_another_scene() {
    let geometry = |height: f32| {
        let mut geometry = GeometryBuilder::new([Material::opaque([0.5; 3])]);
        let leaf = geometry.mesh(leaf());
        geometry.item("leaf", leaf, Transform::translation([0.0, height, 0.0]));
        geometry.item("leaf 2", leaf, Transform::translation([1.0, height, 1.0]));
        geometry.build().expect("sound")
    };
    let eye = [0.5, 90.0, 0.5];
    let name = |scene: &Scene| {
        let sector = scene.locate(eye, [0.0; 3]).expect("a sector");
        scene.sector_name(sector).to_owned()
    };
    let mut builder = SceneBuilder::new();
    let hall = builder.add("hall", geometry(0.0), Method::ZBuffer);
    builder.add("balloon", geometry(60.0), Method::ZBuffer);
    assert_eq!(name(&builder.build().expect("sound")), "balloon");

    let mut builder = SceneBuilder::new();
    builder.add("hall", geometry(0.0), Method::ZBuffer);
    builder.add("balloon", geometry(60.0), Method::ZBuffer);
    builder.open_above(hall);
    let mut scene = builder.build().expect("sound");
    assert!(scene.is_open_above(hall));
    assert_eq!(name(&scene), "hall");
    let mut edit = scene.edit();
    let there = Transform::translation([0.0, 1.0, 0.0]);
    edit.add(hall, "third", leaf(), there).expect("it fits");
    edit.finish().expect("little");
    assert_eq!(name(&scene), "hall");
    scene
        .set_geometry(hall, geometry(-5.0))
        .expect("it has as many openings");
    assert_eq!(name(&scene), "hall");

    let mut outer = SceneBuilder::new();
    outer.add("cloud", geometry(80.0), Method::ZBuffer);
    outer.nest(&scene);
    assert_eq!(name(&outer.build().expect("sound")), "hall");
}

#[test]
fn an_id_never_names_another_item() {
    let there = Transform::translation([0.0, 0.0, -3.0]);
    for method in [Method::ZBuffer, Method::Masked, Method::BspFront] {
        let (mut scene, mut viewer) = (hall(method), Viewer::new());
        let first = original(2);
        let mut edit = scene.edit();
        edit.remove(HALL, first).expect("it is there");
        edit.finish().expect("little");
        let discarded = scene
            .edit()
            .add(HALL, "discarded", leaf(), there)
            .expect("it fits");
        let mut edit = scene.edit();
        let guest = edit.add(HALL, "guest", leaf(), there).expect("it fits");
        edit.finish().expect("little");
        assert_eq!([discarded.index, guest.index], [first.index; 2]);

        for mut scene in [scene.clone(), scene] {
            for stale in [first, discarded] {
                assert_eq!(scene.geometry(HALL).expect("ours").index_of(stale), None);
                let refused = scene.edit().set_transform(HALL, stale, there);
                assert!(matches!(refused, Err(EditError::NoSuchItem { item, .. }) if item == stale));
            }
            seen(&mut viewer, &scene);
            let ids = viewer.visible().items().iter().map(|seen| seen.item);
            let ids: Vec<ItemId> = ids.collect();
            assert_eq!(ids, [original(0), original(1), guest, original(3)], "{method}");
            let mut edit = scene.edit();
            ids.into_iter()
                .for_each(|id| edit.remove(HALL, id).expect("it is there"));
            edit.finish().expect("little");
            assert_eq!(scene.item_count(), 0);
        }
    }
}

#[test]
fn the_key_of_an_item_comes_with_every_answer_about_it() {
    let mut builder = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    let mesh = builder.mesh(leaf());
    let ids = [0.0, 1.0].map(|x| builder.item("leaf", mesh, Transform::translation([x, 0.0, -4.0])));
    builder.set_key(ids[1], 1 << 40);
    let geometry = builder.build().expect("sound");
    let mut scene = Scene::single(geometry, Method::HierarchicalZ).expect("small");
    let mut edit = scene.edit();
    let there = Transform::translation([-1.0, 0.0, -4.0]);
    let added = edit.add(HALL, "added", leaf(), there).expect("it fits");
    edit.set_key(HALL, added, 7).expect("it is there");
    let unmoved = edit.set_transform(HALL, added, Transform::translation([f32::NAN; 3]));
    assert!(matches!(unmoved, Err(EditError::NotFinite(label)) if label.key == 7));
    edit.finish().expect("little");

    let known = [(ids[0], 0), (ids[1], 1 << 40), (added, 7)];
    let mut viewer = Viewer::new();
    seen(&mut viewer, &scene);
    let visible = viewer.visible().items().iter().map(|seen| (seen.item, seen.key));
    assert!(visible.eq(known));
    let geometry = scene.geometry(HALL).expect("ours");
    let mut nearest = Vec::new();
    for ((id, key), x) in known.into_iter().zip([0.0, 1.0, -1.0]) {
        let ray = Ray {
            origin: [x, 0.1, 0.0],
            direction: [0.0, 0.0, -1.0],
        };
        assert_eq!(
            geometry.cast(&ray).map(|hit| (hit.item, hit.key)),
            Some((id, key))
        );
        let position = [x, 0.0, -4.0];
        geometry.nearest_items(position, 1, 1.0, &mut nearest);
        assert_eq!((nearest[0].item, nearest[0].key), (id, key));
        let location = Location {
            sector: HALL,
            position,
        };
        let near = scene.near(location, 0.1).items;
        assert_eq!((near[0].item, near[0].key), (id, key));
    }
}

#[test]
fn of_many_moves_those_that_cannot_be_are_reported_and_the_others_made() {
    for method in [Method::ZBuffer, Method::Masked, Method::Svbsp] {
        let (mut scene, mut viewer) = (hall(method), Viewer::new());
        let mut edit = scene.edit();
        edit.remove(HALL, original(3)).expect("it is there");
        edit.finish().expect("little");
        let before = scene.geometry(HALL).expect("ours").items().to_vec();
        let at = |x: f32| Transform::translation([x, 0.0, -4.0]);
        let moves = [
            (original(1), at(f32::NAN)),
            (original(2), at(0.5)),
            (original(3), at(0.0)),
            (original(1), at(1e30)),
            (original(7), at(0.0)),
        ];
        let mut refused = vec![(99, EditError::CustomSector("stale".to_owned()))];
        let mut edit = scene.edit();
        edit.set_transforms(HALL, moves, &mut refused)
            .expect("a sector of ours");
        let why: Vec<(usize, String)> = refused.iter().map(|(at, why)| (*at, why.to_string())).collect();
        let expected = [
            (0, "the transform of item `left` (key 1) contains NaN"),
            (
                2,
                "sector `hall` has no item 3 of generation 0; it was removed or never existed",
            ),
            (
                3,
                "item `left` (key 1) would reach beyond 1e12 units; move it closer to the origin",
            ),
            (
                4,
                "sector `hall` has no item 7 of generation 0; it was removed or never existed",
            ),
        ];
        assert_eq!(why, expected.map(|(at, why)| (at, why.to_owned())), "{method}");
        assert_eq!(edit.finish().expect("little").items, 1);
        let after = scene.geometry(HALL).expect("ours").items();
        assert_eq!((after[0], after[1], after[3]), (before[0], before[1], before[3]));
        assert_eq!(after[2].transform(), at(0.5));
        assert_eq!(seen(&mut viewer, &scene), ["wall", "left", "middle"], "{method}");
        let nowhere = scene.edit().set_transforms(SectorId(5), [], &mut refused);
        assert!(matches!(nowhere, Err(EditError::NoSuchSector { .. })) && refused.is_empty());
    }
}
