//! Sectors, openings and portals that come and go, and items that change rooms.

use enfilade::{
    Aabb, ConvexPolygon, EditError, GeometryBuilder, ItemIndex, ItemOptions, Location, Material, MaterialId,
    Mesh, Method, OpeningId, PortalId, Ray, RayEnd, Scene, SceneBuilder, SceneError, SectorId, Transform,
    Unsuited, View, Viewer,
};

const HALL: SectorId = SectorId(0);
const STUDY: SectorId = SectorId(1);
const FIRST: OpeningId = OpeningId(0);

/// A doorway in the plane z = -2, seen from +Z; `x` is its left end.
fn doorway(x: f32) -> ConvexPolygon {
    ConvexPolygon::rectangle([x, -1.0, -2.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]).expect("a rectangle")
}

fn vase(name: &str, z: f32) -> GeometryBuilder {
    let mut room = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    let vase = Mesh::cuboid([-0.2; 3], [0.2; 3], MaterialId(0)).expect("a box");
    let vase = room.mesh(vase);
    room.item(name, vase, Transform::translation([0.5, 0.0, z]));
    room
}

/// A hall with three doorways, the first of which leads into a study with a vase.
fn rooms() -> Scene {
    let mut hall = vase("bench", -1.0);
    for (name, x) in [("middle", 0.0), ("left", -2.0), ("right", 2.0)] {
        hall.opening(name, doorway(x));
    }
    let mut study = vase("vase", -4.0);
    study.opening("back", doorway(0.0).flipped());
    let mut scene = SceneBuilder::new();
    scene.add("hall", hall.build().expect("sound"), Method::HierarchicalZ);
    scene.add("study", study.build().expect("sound"), Method::HierarchicalZ);
    scene.door((HALL, FIRST), (STUDY, FIRST));
    scene.build().expect("two rooms")
}

/// Returns what is seen from the hall, as SECTOR/ITEM.
fn seen(viewer: &mut Viewer, scene: &Scene) -> Vec<String> {
    let mut view = View::new([0.5, 0.8, 1.0], [0.5, 0.5, -4.0], [96, 96]).expect("a valid view");
    view.sector = Some(HALL);
    let set = viewer.look(scene, &view);
    let name = |item: &enfilade::VisibleItem| {
        let sector = set.passage(item.passage).sector;
        let geometry = scene.geometry(sector).expect("ours");
        format!("{}/{}", scene.sector_name(sector), geometry.name(item.item.index))
    };
    set.items().iter().map(name).collect()
}

#[test]
fn a_room_that_is_removed_leaves_a_closed_doorway_until_another_is_added() {
    let (mut scene, mut viewer) = (rooms(), Viewer::new());
    assert_eq!(seen(&mut viewer, &scene), ["hall/bench", "study/vase"]);
    assert!(scene.remove_sector(STUDY) && !scene.remove_sector(STUDY));
    assert_eq!(seen(&mut viewer, &scene), ["hall/bench"]);
    assert!(!scene.has_sector(STUDY) && scene.has_sector(HALL));
    assert_eq!([0, 1].map(|id| scene.has_portal(PortalId(id))), [false; 2]);
    let through = scene.cast(HALL, &ray());
    assert_eq!(through.end, RayEnd::Closed(FIRST));

    let mut garden = vase("tree", -5.0);
    garden.opening("back", doorway(0.0).flipped());
    let garden = garden.build().expect("sound");
    let garden = scene.add_sector("garden", garden, Method::Masked).expect("small");
    assert_eq!(garden, SectorId(2), "ids are not reused");
    let [out, back] = scene.add_door((HALL, FIRST), (garden, FIRST)).expect("a door");
    assert_eq!([out, back], [PortalId(2), PortalId(3)]);
    assert_eq!(seen(&mut viewer, &scene), ["hall/bench", "garden/tree"]);
    assert!(scene.leads_back(out, back));
    // What was remembered of the old door does no harm.
    assert!(!scene.leads_back(PortalId(0), back) && !scene.leads_back(out, PortalId(1)));
}

fn ray() -> Ray {
    Ray {
        origin: [0.5, 0.8, 1.0],
        direction: [0.0, 0.0, -1.0],
    }
}

#[test]
fn nobody_is_in_a_room_that_was_removed() {
    let mut scene = rooms();
    let eye = [0.5, 0.0, -4.0];
    assert_eq!(scene.locate(eye, [0.0; 3]), Some(STUDY));
    scene.remove_sector(STUDY);
    assert_eq!(scene.locate(eye, [0.0; 3]), Some(HALL));
    let mut view = View::new(eye, [0.5, 0.0, 0.0], [64, 64]).expect("a valid view");
    view.sector = Some(STUDY);
    assert_eq!(Viewer::new().look(&scene, &view).items(), []);
    let there = Location {
        sector: STUDY,
        position: [0.5, 0.0, -4.0],
    };
    assert_eq!(scene.near(there, 100.0).items, []);
    scene.remove_sector(HALL);
    assert_eq!(scene.locate(eye, [0.0; 3]), None);
    let empty = GeometryBuilder::new([]).build().expect("nothing");
    let empty = scene.add_sector("void", empty, Method::ZBuffer).expect("small");
    assert_eq!(scene.locate(eye, [0.0; 3]), Some(empty));
    scene.set_open_above(empty, true);
    assert!(scene.is_open_above(empty) && scene.bounds(HALL) == Aabb::EMPTY);
}

#[test]
fn what_was_removed_is_named_when_it_is_used() {
    let mut scene = rooms();
    let says = |refused: Option<SceneError>, message: &str| {
        assert_eq!(refused.expect(message).to_string(), message);
    };
    scene.remove_sector(STUDY);
    says(
        scene.set_portal(PortalId(0), Transform::IDENTITY).err(),
        "portal 0 was removed",
    );
    says(
        scene.set_method(STUDY, Method::Masked).err(),
        "sector 1 was removed",
    );
    says(
        scene.add_portal((HALL, FIRST), STUDY, Transform::IDENTITY).err(),
        "sector 1 was removed",
    );
    says(
        scene
            .add_portal((HALL, OpeningId(3)), HALL, Transform::IDENTITY)
            .err(),
        "portal 2 uses opening 3 of sector `hall`, which has only 3",
    );
    says(
        scene
            .add_portal((HALL, FIRST), SectorId(8), Transform::IDENTITY)
            .err(),
        "portal 2 names sector 8, but there are only 2",
    );
    says(
        scene
            .add_portal((HALL, FIRST), HALL, Transform::scaling([1.0, 2.0, 1.0]))
            .err(),
        "the transform of portal 2 must be rigid, uniformly scaling or reflecting",
    );
    scene.set_open(PortalId(0), true);
    assert!(!scene.portals()[0].open);
    let mut edit = scene.edit();
    let refused = edit.remove(STUDY, ItemIndex(0).into()).expect_err("it is gone");
    assert_eq!(refused, EditError::RemovedSector(1));
}

#[test]
fn a_second_portal_out_of_an_opening_is_refused_and_leaves_none_behind() {
    let mut scene = rooms();
    let message = "portal 0 and portal 2 both lead out of opening `middle` of sector `hall`";
    let refused = scene.add_portal((HALL, FIRST), HALL, Transform::IDENTITY);
    assert_eq!(refused.expect_err("one is enough").to_string(), message);
    // The first half of this door fits, the second does not.
    let refused = scene.add_door((HALL, OpeningId(1)), (STUDY, FIRST));
    assert!(matches!(refused, Err(SceneError::TwoPortals { .. })));
    assert_eq!(scene.portals().len(), 2);
    assert_eq!(scene.portal_of(HALL, OpeningId(1)), None);
}

#[test]
fn the_two_sides_of_a_door_face_opposite_ways() {
    let message = "openings `left` and `right` face the same way; the two sides of a door face opposite ways: \
                   flip one of the outlines";
    let mut scene = rooms();
    let refused = scene.add_door((HALL, OpeningId(1)), (HALL, OpeningId(2)));
    assert_eq!(refused.expect_err("both face the hall").to_string(), message);
    let mut builder = SceneBuilder::new();
    let hall = builder.add(
        "hall",
        scene.geometry(HALL).expect("ours").clone(),
        Method::ZBuffer,
    );
    builder.door((hall, OpeningId(1)), (hall, OpeningId(2)));
    let refused = builder.build().err();
    assert_eq!(refused.expect("both face the hall").to_string(), message);
}

#[test]
fn a_wall_is_opened_and_bricked_up_again() {
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let (mut scene, mut viewer) = (rooms(), Viewer::new());
        scene.set_method(HALL, method).expect("small");
        scene.remove_portal(PortalId(0));
        assert_eq!(seen(&mut viewer, &scene), ["hall/bench"], "{method}");
        let mut edit = scene.edit();
        let window = doorway(0.0);
        assert_eq!(edit.remove_opening(HALL, FIRST), Ok(Some(OpeningId(2))));
        let added = edit.add_opening(HALL, "window", window).expect("few");
        edit.finish().expect("small");
        assert_eq!(added, OpeningId(2));
        scene
            .add_portal((HALL, added), STUDY, Transform::IDENTITY)
            .expect("a portal");
        assert_eq!(
            seen(&mut viewer, &scene),
            ["hall/bench", "study/vase"],
            "{method}"
        );
        // `right` took the id of `middle`.
        let names: Vec<_> = scene
            .sector(HALL)
            .openings()
            .iter()
            .map(|o| o.name.as_str())
            .collect();
        assert_eq!(names, ["right", "left", "window"], "{method}");

        let mut edit = scene.edit();
        assert_eq!(edit.remove_opening(HALL, OpeningId(0)), Ok(Some(OpeningId(2))));
        edit.finish().expect("small");
        let portal = scene
            .portal_of(HALL, OpeningId(0))
            .expect("it has moved with its opening");
        assert_eq!(scene.portals()[portal.0 as usize].opening, OpeningId(0));
        assert_eq!(
            seen(&mut viewer, &scene),
            ["hall/bench", "study/vase"],
            "{method}"
        );

        let mut edit = scene.edit();
        edit.remove_opening(HALL, OpeningId(0)).expect("it is there");
        edit.finish().expect("small");
        assert!(!scene.has_portal(portal) && !scene.portals()[portal.0 as usize].open);
        assert_eq!(seen(&mut viewer, &scene), ["hall/bench"], "{method}");
        assert_eq!(
            scene.portal_of(STUDY, FIRST),
            Some(PortalId(1)),
            "the way back stays"
        );
    }
}

#[test]
fn an_edit_of_openings_that_is_dropped_or_refused_changes_nothing() {
    let (mut scene, mut viewer) = (rooms(), Viewer::new());
    let before = scene.sector(HALL).openings().to_vec();
    let mut edit = scene.edit();
    edit.remove_opening(HALL, FIRST).expect("it is there");
    edit.add_opening(HALL, "new", doorway(5.0)).expect("few");
    let refused = edit.remove_opening(HALL, OpeningId(9));
    let message = "sector `hall` has no opening 9, only 3";
    assert_eq!(refused.expect_err("there are three").to_string(), message);
    drop(edit);
    assert_eq!(scene.sector(HALL).openings(), before);

    let mut narrow = SceneBuilder::new();
    narrow.limit_bytes(20_000);
    let hall = narrow.add(
        "hall",
        scene.geometry(HALL).expect("ours").clone(),
        Method::HierarchicalZ,
    );
    let study = narrow.add("study", scene.geometry(STUDY).expect("ours").clone(), Method::Bsp);
    narrow.door((hall, FIRST), (study, FIRST));
    let mut narrow = narrow.build().expect("small enough");
    let bench = narrow.geometry(hall).expect("ours").meshes()[0].clone();
    let mut edit = narrow.edit();
    edit.remove_opening(hall, FIRST).expect("it is there");
    for _ in 0..1000 {
        edit.add(study, "more", bench.clone(), Transform::IDENTITY)
            .expect("one by one they fit");
    }
    edit.finish().expect_err("a BSP tree of a thousand boxes");
    assert_eq!(narrow.sector(hall).openings(), before);
    assert_eq!(seen(&mut viewer, &narrow), ["hall/bench", "study/vase"]);
}

#[test]
fn a_vase_is_carried_into_the_next_room_with_all_that_it_is() {
    let (mut scene, mut viewer) = (rooms(), Viewer::new());
    let vase = scene.geometry(STUDY).expect("ours").id_of(ItemIndex(0));
    let options = ItemOptions {
        is_occluder: false,
        ..ItemOptions::default()
    };
    let mut edit = scene.edit();
    edit.set_key(STUDY, vase, 77).expect("it is there");
    edit.set_options(STUDY, vase, options).expect("it is there");
    let there = Transform::translation([0.5, 0.0, -1.5]);
    let refused = edit.move_to(STUDY, vase, SectorId(7), there);
    assert!(matches!(refused, Err(EditError::NoSuchSector { sector: 7, .. })));
    let carried = edit.move_to(STUDY, vase, HALL, there).expect("it fits");
    let again = edit.move_to(STUDY, vase, HALL, there);
    assert!(matches!(again, Err(EditError::NoSuchItem { .. })));
    edit.finish().expect("small");
    let hall = scene.geometry(HALL).expect("ours");
    let index = hall.index_of(carried).expect("it is there");
    assert_eq!((hall.key(index), hall.name(index)), (77, "vase"));
    assert_eq!(hall.item(index).options, options);
    assert_eq!(scene.geometry(STUDY).expect("ours").item_count(), 0);
    assert_eq!(seen(&mut viewer, &scene), ["hall/bench", "hall/vase"]);
}

#[test]
fn an_exit_follows_its_opening_and_goes_with_it() {
    let mut inner = SceneBuilder::new();
    let hall = inner.add(
        "hall",
        rooms().geometry(HALL).expect("ours").clone(),
        Method::ZBuffer,
    );
    inner
        .exit("right", (hall, OpeningId(2)))
        .exit("left", (hall, OpeningId(1)));
    let mut inner = inner.build().expect("a hall");
    let mut edit = inner.edit();
    edit.remove_opening(hall, OpeningId(1)).expect("it is there");
    edit.finish().expect("small");
    let nest = |exit: &str| {
        let mut outer = SceneBuilder::new();
        let nested = outer.nest(&inner);
        let yard = outer.add(
            "yard",
            vase("tree", -5.0).build().expect("sound"),
            Method::ZBuffer,
        );
        outer.portal((nested, exit), yard, Transform::IDENTITY);
        outer.build()
    };
    let outer = nest("right").expect("it moved to 1");
    assert_eq!(outer.portals()[0].opening, OpeningId(1));
    assert!(matches!(nest("left"), Err(SceneError::NoSuchExit { .. })));
}

#[test]
fn a_baked_pvs_does_not_outlast_an_opening_that_ended_its_lines_of_sight() {
    let baked = enfilade_scenes::built_in("house").expect("a scene");
    let mut scene = baked
        .scene
        .with_method(Method::Pvs, u64::MAX)
        .expect("it is baked");
    let with_opening = |id: &SectorId| !scene.sector(*id).openings().is_empty();
    let room = scene.sectors().find(with_opening).expect("an opening");
    let mut edit = scene.edit();
    let outline = doorway(0.0);
    edit.add_opening(room, "another", outline).expect("few");
    edit.finish()
        .expect("an opening more hides nothing that it does not show");
    let mut edit = scene.edit();
    edit.remove_opening(room, FIRST).expect("it is there");
    let refused = edit.finish().expect_err("the rows are void");
    let SceneError::Unsuited { why, .. } = refused else {
        panic!("{refused}");
    };
    assert_eq!(why.reason, Unsuited::NotBaked);
    assert!(scene.geometry(room).expect("ours").cells().is_some(), "undone");
    scene.set_method(room, Method::HierarchicalZ).expect("small");
    let mut edit = scene.edit();
    edit.remove_opening(room, FIRST).expect("it is there");
    edit.finish().expect("this method needs no rows");
    assert!(scene.geometry(room).expect("ours").cells().is_none());
}
