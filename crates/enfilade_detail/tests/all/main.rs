//! Levels of detail: hidden items build nothing, visible ones get the level their screen size needs, and no item is
//! missed.

mod bad;
mod pictures;
mod world;

use enfilade::laws::{OwnerPicture, Reference};
use enfilade::{
    Camera, Contract, ConvexPolygon, GeometryBuilder, Limits, Method, Scene, SceneBuilder, SectorId,
    Transform, View, Viewer,
};
use enfilade_detail::{DetailOptions, Details};
use std::sync::Arc;
use world::{Ball, HALL, at, hall, names, settle, square, straight, wall_at};

/// The methods that guarantee no false culls.
fn surely() -> impl Iterator<Item = Method> {
    let all = Method::ALL.into_iter();
    all.filter(|method| method.contract().never_misses() && method.requires().is_none())
}

#[test]
fn what_is_hidden_builds_nothing_until_it_is_seen() {
    for method in surely() {
        let (mut scene, mut viewer) = (hall(method), Viewer::new());
        let mut details = Details::new(DetailOptions::default());
        let [seen, hidden] = [Ball::new(), Ball::new()];
        details
            .add(&mut scene, HALL, "seen", seen.clone(), at([-1.0, 0.0, -4.0]))
            .expect("it fits");
        let behind = details
            .add(&mut scene, HALL, "hidden", hidden.clone(), at([1.5, 0.0, -7.0]))
            .expect("it fits");
        settle(&mut details, &mut scene, &mut viewer, &straight());
        assert_eq!((seen.builds(), hidden.builds()), (1, 0), "{method}");
        assert_eq!(details.level(HALL, behind), Some(None));
        // It comes into view from the side.
        let view = View::new([6.0, 0.0, -6.0], [0.0, 0.0, -8.0], [96, 72]).expect("a valid view");
        settle(&mut details, &mut scene, &mut viewer, &view);
        assert_eq!(hidden.builds(), 1, "{method}");
    }
}

/// A hall with a door to an empty study, and a mirror beside the door.
fn rooms(method: Method) -> (Scene, SectorId) {
    let [mut hall, mut study] = [world::materials(), world::materials()].map(GeometryBuilder::new);
    let door = ConvexPolygon::rectangle([-0.5, -1.0, -4.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]).expect("flat");
    let glass = ConvexPolygon::rectangle([1.0, -1.0, -4.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]).expect("flat");
    let [out, mirror] = [hall.opening("out", door.clone()), hall.opening("mirror", glass)];
    let back = study.opening("back", door.flipped());
    let mut scene = SceneBuilder::new();
    let hall = scene.add("hall", hall.build().expect("sound"), method);
    let study = scene.add("study", study.build().expect("sound"), method);
    scene.door((hall, out), (study, back));
    scene.mirror(hall, mirror);
    (scene.build().expect("two rooms"), study)
}

#[test]
fn what_is_seen_through_a_door_or_in_a_mirror_is_seen() {
    for method in surely() {
        let (mut scene, study) = rooms(method);
        let mut viewer = Viewer::new();
        let mut details = Details::new(DetailOptions::default());
        let balls = [(); 4].map(|()| Ball::new());
        let places = [
            ("in line with the door", study, [0.0, 0.0, -8.0], 1),
            ("beside the door", study, [6.0, 0.0, -5.0], 0),
            // An item at z = 2 appears at −10 in the mirror, which shows x from 2.5 to 5.
            ("in the mirror", HALL, [3.7, 0.0, 2.0], 1),
            ("beside the mirror", HALL, [9.0, 0.0, 2.0], 0),
        ];
        for (ball, (name, sector, place, _)) in balls.iter().zip(places) {
            details
                .add(&mut scene, sector, name, ball.clone(), at(place))
                .expect("it fits");
        }
        settle(&mut details, &mut scene, &mut viewer, &straight());
        for (ball, (name, _, _, builds)) in balls.iter().zip(places) {
            assert_eq!(ball.builds(), builds, "{name}, {method}");
        }
    }
}

#[test]
fn what_the_eye_or_a_door_stands_in_is_seen_though_no_side_of_its_box_is() {
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let (mut scene, study) = rooms(method);
        let mut details = Details::new(DetailOptions::default());
        let mut viewer = Viewer::new();
        // A wall hides every side of the box around the eye.
        let wall = wall_at(-2.0);
        let mut edit = scene.edit();
        let first = edit
            .add(HALL, "wall", wall, Transform::IDENTITY)
            .expect("it fits");
        edit.finish().expect("little");
        let [around, below] = [Ball::new(), Ball::new()];
        let large = Transform::scaling([8.0; 3]);
        let around_eye = details
            .add(&mut scene, HALL, "around", around.clone(), large)
            .expect("it fits");
        settle(&mut details, &mut scene, &mut viewer, &straight());
        assert!(details.level(HALL, around_eye).flatten().is_some(), "{method}");
        // The same for a box in the study that extends through the door.
        let mut edit = scene.edit();
        let wall = edit
            .add(study, "wall", wall_at(-5.0), Transform::IDENTITY)
            .expect("it fits");
        edit.remove(HALL, first).expect("it is there");
        edit.remove(HALL, around_eye).expect("it is there");
        edit.finish().expect("little");
        details
            .add(
                &mut scene,
                study,
                "below",
                below.clone(),
                at([0.0, 0.0, -4.0]) * large,
            )
            .expect("it fits");
        settle(&mut details, &mut scene, &mut viewer, &straight());
        assert_eq!(below.builds(), 1, "{method}");
        assert!(scene.geometry(study).expect("ours").holds(wall.index));
    }
}

#[test]
fn building_is_bounded_by_the_budget_and_nothing_is_dropped_meanwhile() {
    let view = straight();
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let (mut scene, mut viewer) = (world::empty(method), Viewer::new());
        let mut options = DetailOptions::default();
        options.faces_per_step = 300;
        let mut details = Details::new(options);
        for i in 0..9_u16 {
            let place = at([f32::from(i % 3) * 1.5 - 1.5, f32::from(i / 3) * 1.5 - 1.5, -5.0]);
            details
                .add(&mut scene, HALL, &format!("ball {i}"), Ball::new(), place)
                .expect("it fits");
        }
        let (mut waited, mut steps) = (Vec::new(), 0);
        loop {
            let truth = Reference::new(&scene).see(&scene, &view, &Limits::default());
            let mut picture = OwnerPicture::new(view.size());
            viewer.draw(&scene, &view, &mut picture);
            assert_eq!(viewer.visible().items().len(), 9, "{method}, step {steps}");
            let verdict = truth.check(viewer.visible(), Some(&picture));
            assert_eq!(verdict.reference_visible, 9);
            if method.contract().never_misses() {
                assert_eq!(
                    (verdict.missed.len(), verdict.pixels_different),
                    (0, 0),
                    "{method}"
                );
            }
            if steps > 0 && waited.last() == Some(&0) {
                break;
            }
            let refined = details.refine(&mut scene, &[viewer.visible()]).expect("it fits");
            assert!(refined.built <= 1 || refined.faces < 300 + 4 * 1024);
            assert_eq!(refined.changed, refined.built);
            waited.push(refined.waiting);
            steps += 1;
        }
        assert!(
            waited.len() > 2 && waited.is_sorted_by(|a, b| a > b),
            "{method}: {waited:?}"
        );
    }
}

#[test]
fn items_of_one_source_share_what_is_built() {
    let (mut scene, mut viewer) = (world::empty(Method::HierarchicalZ), Viewer::new());
    let mut details = Details::new(DetailOptions::default());
    let ball = Ball::new();
    for x in [-1.5, 0.0, 1.5] {
        details
            .add(&mut scene, HALL, "ball", ball.clone(), at([x, 0.0, -5.0]))
            .expect("it fits");
    }
    settle(&mut details, &mut scene, &mut viewer, &straight());
    assert_eq!(ball.builds(), 1);
}

#[test]
fn only_the_exact_level_hides_what_is_behind_it() {
    for method in Method::ALL
        .into_iter()
        .filter(|m| m.contract() == Contract::Exact && m.requires().is_none())
    {
        let (mut scene, mut viewer) = (world::empty(method), Viewer::new());
        let mut details = Details::new(DetailOptions::default());
        let ball = details
            .add(&mut scene, HALL, "ball", Ball::new(), at([0.0, 0.0, -4.0]))
            .expect("it fits");
        let mut edit = scene.edit();
        let there = at([0.0, 0.0, -9.0]) * Transform::scaling([0.1; 3]);
        edit.add(HALL, "thing", square(), there).expect("it fits");
        edit.finish().expect("little");
        let far = straight();
        let set = viewer.look(&scene, &far);
        assert_eq!(names(&scene, set), ["ball", "thing"], "{method}: a volume");
        settle(&mut details, &mut scene, &mut viewer, &far);
        assert_eq!(
            names(&scene, viewer.visible()),
            ["ball", "thing"],
            "{method}: a coarse level"
        );
        let camera = Camera {
            fov_y: 1.5,
            ..Camera::new([0.0, 0.0, -2.9], [0.0, 0.0, -4.0])
        };
        let near = camera.view([960, 720]).expect("a valid view");
        settle(&mut details, &mut scene, &mut viewer, &near);
        assert_eq!(details.level(HALL, ball), Some(Some(Ball::FINEST)));
        assert_eq!(
            names(&scene, viewer.visible()),
            ["ball"],
            "{method}: the ball itself"
        );
    }
}

#[test]
fn two_cameras_are_both_given_what_they_want() {
    let (mut scene, mut viewers) = (
        world::empty(Method::HierarchicalZ),
        [Viewer::new(), Viewer::new()],
    );
    let mut details = Details::new(DetailOptions::default());
    let item = details
        .add(&mut scene, HALL, "ball", Ball::new(), at([0.0, 0.0, -5.0]))
        .expect("it fits");
    let far = View::new([0.0, 0.0, 40.0], [0.0, 0.0, -5.0], [96, 72]).expect("a valid view");
    let mut levels = Vec::new();
    for views in [[far, far], [far, straight()], [straight(), far]] {
        for _ in 0..4 {
            let [a, b] = &mut viewers;
            let sets = [a.look(&scene, &views[0]), b.look(&scene, &views[1])];
            details.refine(&mut scene, &sets).expect("it fits");
        }
        levels.push(details.level(HALL, item).flatten().expect("it is seen"));
    }
    assert!(levels[0] < levels[1] && levels[1] == levels[2], "{levels:?}");
}

#[test]
fn a_way_there_and_back_changes_levels_once_each_way_and_a_trembling_eye_changes_none() {
    let (mut scene, mut viewer) = (world::empty(Method::HierarchicalZ), Viewer::new());
    let mut details = Details::new(DetailOptions::default());
    let item = details
        .add(&mut scene, HALL, "ball", Ball::new(), at([0.0, 0.0, 0.0]))
        .expect("it fits");
    let mut level_at = |distance: f32, tremble: f32| {
        let eye = [tremble, 0.5 * tremble, distance + tremble];
        let view = View::new(eye, [0.0; 3], [320, 240]).expect("a valid view");
        let set = viewer.look(&scene, &view);
        details.refine(&mut scene, &[set]).expect("it fits");
        details.level(HALL, item).flatten().expect("it is seen")
    };
    let there: Vec<f32> = (0..200).map(|i| (60.0 * 0.97_f32.powi(i)).max(0.6)).collect();
    let mut levels = Vec::new();
    for &distance in there.iter().chain(there.iter().rev()) {
        // The eye jitters by a hundredth of the distance.
        let trembling = [0.0, 0.01, -0.01, 0.01, -0.01].map(|tremble| level_at(distance, tremble * distance));
        let changes = trembling.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(changes <= 1, "{trembling:?} at {distance}");
        levels.extend(trembling);
    }
    levels.dedup();
    let turn = levels
        .iter()
        .position(|&level| level == Ball::FINEST)
        .expect("it comes near");
    assert!(
        levels[..=turn].is_sorted() && levels[turn..].is_sorted_by(|a, b| a > b),
        "{levels:?}"
    );
    assert!(levels.len() >= 7, "{levels:?}");
}

#[test]
fn memory_is_given_up_by_what_is_unseen_longest() {
    let (mut scene, mut viewer) = (world::empty(Method::HierarchicalZ), Viewer::new());
    let mut options = DetailOptions::default();
    options.bytes = 30_000;
    let mut details = Details::new(options);
    let places: Vec<[f32; 3]> = (0..8_u8).map(|i| [10.0 * f32::from(i), 0.0, -4.0]).collect();
    let balls: Vec<_> = places
        .iter()
        .map(|&place| details.add(&mut scene, HALL, "ball", Ball::new(), at(place)))
        .collect::<Result<_, _>>()
        .expect("they fit");
    let mut most = 0;
    for place in &places {
        let view = View::new([place[0], 0.0, 0.0], *place, [96, 72]).expect("a valid view");
        for _ in 0..2 {
            let set = viewer.look(&scene, &view);
            most = most.max(details.refine(&mut scene, &[set]).expect("it fits").bytes);
        }
    }
    assert!(most <= 30_000, "{most}");
    let kept: Vec<bool> = balls
        .iter()
        .map(|&ball| details.level(HALL, ball).flatten().is_some())
        .collect();
    assert!(!kept[0] && kept[7] && kept.is_sorted(), "{kept:?}");
    assert!(kept.iter().filter(|&&kept| kept).count() > 1, "{kept:?}");
}

#[test]
fn an_adopted_item_is_what_it_was_again_when_it_is_near() {
    let (mut scene, mut viewer) = (world::empty(Method::HierarchicalZ), Viewer::new());
    let mut edit = scene.edit();
    let far_off = at([0.0, 0.0, -5.0]);
    let items = ["proud", "shy"].map(|name| edit.add(HALL, name, square(), far_off).expect("it fits"));
    edit.set_options(
        HALL,
        items[1],
        enfilade::ItemOptions {
            is_occluder: false,
            ..enfilade::ItemOptions::default()
        },
    )
    .expect("it is there");
    edit.finish().expect("little");
    let mut details = Details::new(DetailOptions::default());
    let [a, b]: [Arc<dyn enfilade_detail::DetailSource>; 2] = [Ball::new(), Ball::new()];
    details
        .adopt(&mut scene, [(HALL, items[0], a), (HALL, items[1], b)])
        .expect("they are there");
    let near = View::new([0.0, 0.0, -3.8], [0.0, 0.0, -5.0], [1920, 1080]).expect("a valid view");
    settle(&mut details, &mut scene, &mut viewer, &near);
    let geometry = scene.geometry(HALL).expect("ours");
    assert_eq!(
        items.map(|item| details.level(HALL, item)),
        [Some(Some(Ball::FINEST)); 2]
    );
    // An item that was no occluder before is none now.
    assert_eq!(
        items.map(|item| geometry.item(item.index).options.is_occluder),
        [true, false]
    );
}
