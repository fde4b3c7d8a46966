//! Choice of methods by measurement: which methods are tried, what is measured, and that the choice changes nothing
//! else.

use enfilade::laws::OwnerPicture;
use enfilade::{
    ChoiceGoal, ChoiceOptions, Contract, GeometryBuilder, Material, MaterialId, Mesh, Method, MethodChoice,
    Scene, SceneBuilder, SkipReason, Transform, View, Viewer, choose_methods, survey_in,
};
use enfilade_scenes::built_in;
use std::cell::Cell;
use std::time::{Duration, Instant};

const SIZE: [u32; 2] = [160, 90];

fn two_rooms() -> Scene {
    built_in("two-rooms").expect("it is built in").scene
}

fn views(scene: &Scene) -> Vec<View> {
    let places = scene
        .sectors()
        .flat_map(|sector| survey_in(scene, sector, 4).views);
    let views: Vec<View> = places
        .map(|place| View::new(place.eye, place.toward, SIZE).expect("a valid view"))
        .collect();
    assert!(views.len() >= 2 * scene.sector_count(), "there is open space");
    views
}

fn choices(scene: &Scene, terms: &ChoiceOptions) -> Vec<MethodChoice> {
    let start = Instant::now();
    choose_methods(scene, &views(scene), terms, &|| start.elapsed())
}

fn outcome(choice: &MethodChoice, method: Method) -> Result<enfilade::Cost, SkipReason> {
    let trial = choice.trials.iter().find(|trial| trial.method == method);
    trial.expect("all methods are there").outcome.clone()
}

#[test]
fn whatever_is_chosen_the_set_and_the_picture_are_those_of_before() {
    let before = two_rooms();
    let mut after = before.clone();
    for choice in choices(&before, &ChoiceOptions::default()) {
        after
            .set_method(choice.sector, choice.method)
            .expect("it was tried");
    }
    let seen = |scene: &Scene, view: &View| {
        let (mut viewer, mut picture) = (Viewer::new(), OwnerPicture::new(view.size()));
        let set = viewer.draw(scene, view, &mut picture);
        let items = set.items().iter();
        let mut items: Vec<_> = items
            .map(|seen| (set.passage(seen.passage).sector, seen.item))
            .collect();
        items.sort_unstable();
        items.dedup();
        (items, picture)
    };
    for view in views(&before) {
        let [(items, picture), (items_after, picture_after)] =
            [&before, &after].map(|scene| seen(scene, &view));
        assert_eq!(items, items_after, "{view:?}");
        assert!(picture.same(&picture_after), "{view:?}");
    }
}

#[test]
fn only_methods_that_promise_what_is_wanted_are_tried() {
    for exact in [true, false] {
        let mut terms = ChoiceOptions::default();
        terms.exact = exact;
        for choice in choices(&two_rooms(), &terms) {
            assert_eq!(choice.trials.len(), Method::ALL.len());
            for trial in &choice.trials {
                let contract = trial.method.contract();
                let may_be = contract == Contract::Exact || (!exact && contract != Contract::Approximate);
                let promise = matches!(trial.outcome, Err(SkipReason::Contract(_)));
                assert_eq!(promise, !may_be, "{}", trial.method);
            }
            assert!(outcome(&choice, choice.method).is_ok(), "{}", choice.method);
        }
    }
}

#[test]
fn what_counts_is_the_aim_and_the_share_of_building() {
    for (aim, frames) in [(ChoiceGoal::Look, 1), (ChoiceGoal::Draw, 100)] {
        let mut terms = ChoiceOptions::default();
        (terms.aim, terms.frames) = (aim, frames);
        for choice in choices(&two_rooms(), &terms) {
            let tried = choice
                .trials
                .iter()
                .filter_map(|trial| trial.outcome.as_ref().ok());
            let costs: Vec<_> = tried.collect();
            assert!(costs.len() > 4, "several are tried");
            for cost in &costs {
                let of_aim = if aim == ChoiceGoal::Look {
                    cost.look
                } else {
                    cost.draw
                };
                assert_eq!(cost.frame, of_aim + cost.build / frames);
                assert!(cost.look > Duration::ZERO && cost.draw > Duration::ZERO);
            }
            let best = costs.iter().map(|cost| cost.frame).min().expect("some");
            let chosen = outcome(&choice, choice.method).expect("it was tried");
            assert!(
                !choice.sure || chosen.frame <= best.mul_f64(1.12),
                "{chosen:?}, but the fastest method takes {best:?}"
            );
        }
    }
}

/// With a clock by which all methods are equally fast.
#[test]
fn of_methods_that_are_as_fast_a_sector_keeps_its_own() {
    let scene = two_rooms();
    let ticks = Cell::new(0);
    let clock = || {
        ticks.set(ticks.get() + 1);
        Duration::from_millis(ticks.get())
    };
    for own in [Method::ZBuffer, Method::SBuffer] {
        let scene = scene.with_method(own, Method::DEFAULT_LIMIT).expect("small");
        let mut tried = 0;
        // One view at a time: of several, those with little work would count as disturbed, as all take the same time.
        for view in views(&scene) {
            for choice in choose_methods(&scene, &[view], &ChoiceOptions::default(), &clock) {
                assert_eq!(choice.method, own);
                assert_eq!(choice.sure, choice.views > 0);
                tried += choice.views;
            }
        }
        assert!(tried >= views(&scene).len());
    }
}

/// With a clock by which each method is slow in half of the views, alternating between methods.
#[test]
fn where_the_halves_of_the_views_disagree_a_sector_keeps_its_own() {
    let scene = two_rooms();
    let views = views(&scene);
    let (calls, time) = (Cell::new(0_u64), Cell::new(0_u64));
    let clock = || {
        // Two readings per look; looks are slow alternately.
        let call = calls.get();
        calls.set(call + 1);
        let random = (call / 2 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 60;
        time.set(time.get() + if call % 2 == 1 { 1 + random * random } else { 0 });
        Duration::from_micros(time.get())
    };
    let mut terms = ChoiceOptions::default();
    terms.rounds = 1;
    let choices = choose_methods(&scene, &views, &terms, &clock);
    let unsure: Vec<_> = choices.iter().filter(|choice| !choice.sure).collect();
    assert!(!unsure.is_empty());
    for choice in unsure {
        assert_eq!(Some(choice.method), scene.method(choice.sector));
    }
}

#[test]
fn where_something_moves_a_tree_that_must_be_built_anew_pays_for_it() {
    let scene = two_rooms();
    let mut terms = ChoiceOptions::default();
    let still = choices(&scene, &terms);
    terms.moving = scene.sectors().take(1).collect();
    let moving = choices(&scene, &terms);
    for method in [Method::Bsp, Method::HierarchicalZ] {
        assert_eq!(outcome(&still[0], method).expect("tried").edit, Duration::ZERO);
        assert!(outcome(&moving[0], method).expect("tried").edit > Duration::ZERO);
        assert_eq!(outcome(&moving[1], method).expect("tried").edit, Duration::ZERO);
    }
    let [tree, octree] = [Method::Bsp, Method::HierarchicalZ].map(|method| outcome(&moving[0], method));
    assert!(tree.expect("tried").edit > octree.expect("tried").edit);
}

/// Six walls seen from inside, each an item: moving any of them puts it behind another.
#[test]
fn a_convex_room_whose_walls_move_is_no_cell() {
    let mut room = GeometryBuilder::new([Material::opaque([1.0; 3])]);
    let corner = |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 2.0 } else { -2.0 });
    let walls = [
        [0, 2, 6, 4],
        [1, 5, 7, 3],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 1, 3, 2],
        [4, 6, 7, 5],
    ];
    for wall in walls {
        let mesh = Mesh::triangles(&wall.map(corner), &[0, 1, 2, 0, 2, 3], MaterialId(0));
        let mesh = room.mesh(mesh.expect("a wall"));
        room.item("wall", mesh, Transform::IDENTITY);
    }
    let mut scene = SceneBuilder::new();
    let id = scene.add("room", room.build().expect("walls"), Method::ZBuffer);
    let scene = scene.build().expect("a sector");
    let view = View::new([0.0; 3], [1.0, 0.2, 0.3], SIZE).expect("a valid view");
    let start = Instant::now();
    let mut terms = ChoiceOptions::default();
    for moves in [false, true] {
        terms.moving = if moves { vec![id] } else { Vec::new() };
        let choices = choose_methods(&scene, &[view], &terms, &|| start.elapsed());
        let cell = outcome(&choices[0], Method::Cell);
        assert_eq!(cell.err(), moves.then_some(SkipReason::Moves));
        assert!(outcome(&choices[0], Method::ZBuffer).is_ok());
    }
}

#[test]
fn a_sector_that_no_view_sees_keeps_its_method() {
    let scene = two_rooms();
    let start = Instant::now();
    for choice in choose_methods(&scene, &[], &ChoiceOptions::default(), &|| start.elapsed()) {
        assert_eq!(
            (choice.views, Some(choice.method)),
            (0, scene.method(choice.sector))
        );
        assert_eq!(outcome(&choice, Method::ZBuffer), Err(SkipReason::NotSeen));
    }
}

#[test]
fn what_takes_too_long_to_sort_is_not_tried() {
    let mut heap = GeometryBuilder::new([Material::opaque([1.0; 3])]);
    let leaf = Mesh::triangles(
        &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        &[0, 1, 2],
        MaterialId(0),
    );
    let leaf = heap.mesh(leaf.expect("a triangle"));
    for number in 0..2_000_u32 {
        let at = [number % 100, number / 100 % 100, number / 10_000].map(|step| step as f32 * 1.5);
        heap.item("leaf", leaf, Transform::translation(at));
    }
    let mut scene = SceneBuilder::new();
    scene.add("heap", heap.build().expect("leaves"), Method::HierarchicalZ);
    let scene = scene.build().expect("a sector");
    let start = Instant::now();
    let view = View::new([70.0, 70.0, 90.0], [70.0, 70.0, 0.0], [64, 36]).expect("a valid view");
    for max_build_time in [Duration::from_millis(1), Duration::from_secs(20)] {
        let mut terms = ChoiceOptions::default();
        terms.max_build_time = max_build_time;
        let choices = choose_methods(&scene, &[view], &terms, &|| start.elapsed());
        let is_tried = !matches!(
            outcome(&choices[0], Method::BspFront),
            Err(SkipReason::BuildsTooLong(_))
        );
        assert_eq!(is_tried, max_build_time > Duration::from_secs(1));
        assert!(outcome(&choices[0], Method::ZBuffer).is_ok());
    }
}

/// Twelve views are in the only sector; it is tried with the allowed number of them, spread over the twelve.
#[test]
fn as_many_views_as_are_allowed_are_taken_from_all_that_see() {
    let scene = two_rooms();
    let view = views(&scene)[0];
    let start = Instant::now();
    for (most, taken) in [(1, 1), (5, 5), (12, 12), (100, 12)] {
        let mut terms = ChoiceOptions::default();
        (terms.max_views, terms.rounds) = (most, 1);
        let choices = choose_methods(&scene, &[view; 12], &terms, &|| start.elapsed());
        let here = scene.sector_of(&view).expect("a sector");
        assert_eq!(choices[here.0 as usize].views, taken);
    }
}
