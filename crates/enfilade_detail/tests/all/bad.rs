//! Sources that fail: their items keep their boxes, the error is reported once, and later looks work.

use crate::world::{Ball, HALL, at, empty, settle, square, straight};
use enfilade::{Aabb, ItemIndex, MaterialId, Mesh, Method, SectorId, Transform, Viewer};
use enfilade_detail::{DetailError, DetailOptions, DetailSource, Details};
use std::error::Error;
use std::sync::Arc;

type Made = Result<Arc<Mesh>, Box<dyn Error + Send + Sync>>;

type Make = fn(u32) -> Made;

/// A source that calls the given function.
#[derive(Clone, Copy)]
struct Odd {
    bounds: [f32; 2],
    levels: u32,
    error: fn(u32) -> f32,
    make: Make,
}

const SOUND: Odd = Odd {
    bounds: [-1.0, 1.0],
    levels: 3,
    error: |level| 0.1 / (1.0 + level as f32),
    make: |_| Ok(square()),
};

impl DetailSource for Odd {
    fn bounds(&self) -> Aabb {
        let [min, max] = self.bounds;
        assert!(min.is_nan() || min < 7.0, "a source that does not know its size");
        Aabb {
            min: [min; 3],
            max: [max; 3],
        }
    }

    fn material(&self) -> MaterialId {
        MaterialId(0)
    }

    fn levels(&self) -> u32 {
        self.levels
    }

    fn error(&self, level: u32) -> f32 {
        (self.error)(level)
    }

    fn build(&self, level: u32) -> Made {
        (self.make)(level)
    }
}

fn of_gold() -> Arc<Mesh> {
    let corners = [[0.0; 3], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0]];
    Arc::new(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(7)).expect("a triangle"))
}

fn too_large() -> Arc<Mesh> {
    let corners = [[0.0; 3], [5.0, 0.0, 0.0], [0.0, 5.0, 0.0]];
    Arc::new(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("a triangle"))
}

#[test]
fn a_source_that_fails_leaves_its_item_its_box() {
    let sources: [(Make, &str); 6] = [
        (|_| Err("no luck today".into()), "no luck today"),
        (|_| panic!("dropped it"), "it panicked: dropped it"),
        (|level| panic!("dropped {level}"), "it panicked: dropped"),
        (|_| Ok(Arc::new(Mesh::new(&[])?)), "it made a mesh of no faces"),
        (
            |_| Ok(too_large()),
            "it made a mesh that reaches out of its bounds",
        ),
        (|_| Ok(of_gold()), "item `odd` (key 0) uses material 7"),
    ];
    for (make, why) in sources {
        for method in Method::ALL
            .into_iter()
            .filter(|method| method.requires().is_none())
        {
            let (mut scene, mut viewer) = (empty(method), Viewer::new());
            let mut details = Details::new(DetailOptions::default());
            let odd = Arc::new(Odd { make, ..SOUND });
            let odd = details
                .add(&mut scene, HALL, "odd", odd, at([-1.5, 0.0, -6.0]))
                .expect("it fits");
            let ball = details
                .add(&mut scene, HALL, "ball", Ball::new(), at([1.5, 0.0, -6.0]))
                .expect("it fits");
            let mut told = Vec::new();
            for _ in 0..4 {
                let set = viewer.look(&scene, &straight());
                assert_eq!(set.items().len(), 2, "{method}: {why}");
                let refined = details.refine(&mut scene, &[set]).expect("it fits");
                assert_eq!(refined.waiting, 0);
                told.extend(refined.failed);
            }
            assert_eq!(told.len(), 1, "{method}: {told:?}");
            assert!(told[0].1 == odd && told[0].2.contains(why), "{told:?}");
            let geometry = scene.geometry(HALL).expect("ours");
            assert_eq!(
                (
                    geometry.mesh_of(odd.index).face_count(),
                    geometry.item(odd.index).options.is_occluder
                ),
                (24, false)
            );
            assert!(details.level(HALL, ball).flatten().is_some());
        }
    }
}

#[test]
fn a_level_that_fails_is_stood_in_for_by_another_if_there_is_one() {
    let (mut scene, mut viewer) = (empty(Method::HierarchicalZ), Viewer::new());
    let mut details = Details::new(DetailOptions::default());
    let odd = Arc::new(Odd {
        make: |level| match level {
            2 => Err("too fine".into()),
            _ => Ok(square()),
        },
        ..SOUND
    });
    let item = details
        .add(&mut scene, HALL, "odd", odd, at([0.0, 0.0, -100.0]))
        .expect("it fits");
    settle(&mut details, &mut scene, &mut viewer, &straight());
    assert_eq!(details.level(HALL, item), Some(Some(0)));
    let mut edit = scene.edit();
    edit.set_transform(HALL, item, at([0.0, 0.0, -3.0]))
        .expect("it is there");
    edit.finish().expect("little");
    let set = viewer.look(&scene, &straight());
    let refined = details.refine(&mut scene, &[set]).expect("it fits");
    assert_eq!((refined.failed.len(), refined.waiting), (1, 0));
    assert_eq!(details.level(HALL, item), Some(Some(0)));
}

#[test]
fn sources_that_do_not_know_their_size_are_refused() {
    let (mut scene, mut viewer) = (empty(Method::Masked), Viewer::new());
    let mut details = Details::new(DetailOptions::default());
    let mut add = |bounds: [f32; 2], sector| {
        let odd = Arc::new(Odd { bounds, ..SOUND });
        details.add(&mut scene, sector, "odd", odd, Transform::IDENTITY)
    };
    for bounds in [[f32::NAN, 1.0], [0.0, f32::INFINITY], [0.0, 1e20], [1.0, 0.0]] {
        assert_eq!(add(bounds, HALL), Err(DetailError::NoBounds), "{bounds:?}");
    }
    let panicked = add([8.0, 9.0], HALL).expect_err("it panics").to_string();
    assert_eq!(
        panicked,
        "the source panicked: a source that does not know its size"
    );
    assert!(matches!(add([0.0, 1.0], SectorId(9)), Err(DetailError::Edit(_))));
    let source: Arc<dyn DetailSource> = Arc::new(SOUND);
    for nowhere in [(SectorId(9), ItemIndex(0)), (HALL, ItemIndex(5))] {
        let adopted = details.adopt(&mut scene, [(nowhere.0, nowhere.1.into(), source.clone())]);
        assert!(matches!(adopted, Err(DetailError::Edit(_))));
    }
    assert_eq!(scene.item_count(), 0);
    settle(&mut details, &mut scene, &mut viewer, &straight());
}

#[test]
fn errors_that_make_no_sense_lead_to_the_finest_level_and_hide_nothing() {
    let errors: [fn(u32) -> f32; 4] = [|_| f32::NAN, |_| -1.0, |_| f32::INFINITY, |level| level as f32];
    for error in errors {
        let (mut scene, mut viewer) = (empty(Method::HierarchicalZ), Viewer::new());
        let mut details = Details::new(DetailOptions::default());
        let levels = 1_000_000_000;
        let odd = Arc::new(Odd {
            error,
            levels,
            ..SOUND
        });
        let item = details
            .add(&mut scene, HALL, "odd", odd, at([0.0, 0.0, -3.0]))
            .expect("it fits");
        settle(&mut details, &mut scene, &mut viewer, &straight());
        assert_eq!(details.level(HALL, item), Some(Some(63)));
        assert!(
            !scene
                .geometry(HALL)
                .expect("ours")
                .item(item.index)
                .options
                .is_occluder
        );
    }
}

#[test]
fn what_somebody_else_removes_or_changes_is_theirs() {
    let (mut scene, mut viewer) = (empty(Method::HierarchicalZ), Viewer::new());
    let mut details = Details::new(DetailOptions::default());
    let items = [-2.0, 0.0, 2.0].map(|x| {
        details
            .add(&mut scene, HALL, "ball", Ball::new(), at([x, 0.0, -6.0]))
            .expect("it fits")
    });
    // One item is removed and its id reused, one gets another mesh; both after they were visible.
    let set = viewer.look(&scene, &straight());
    let mut edit = scene.edit();
    edit.remove(HALL, items[0]).expect("it is there");
    edit.set_mesh(HALL, items[1], square()).expect("it is there");
    edit.finish().expect("little");
    let mut edit = scene.edit();
    let other = edit
        .add(HALL, "square", square(), at([-2.0, 0.0, -6.0]))
        .expect("it fits");
    edit.finish().expect("little");
    assert!(other.index == items[0].index && other != items[0]);
    details.refine(&mut scene, &[set]).expect("it fits");
    settle(&mut details, &mut scene, &mut viewer, &straight());
    let geometry = scene.geometry(HALL).expect("ours");
    let faces = items.map(|item| geometry.mesh_of(item.index).face_count());
    assert!(faces[0] == 2 && faces[1] == 2 && faces[2] > 24, "{faces:?}");
    // A forgotten item keeps its level.
    details.forget(HALL, items[2]);
    assert_eq!(details.level(HALL, items[2]), None);
    settle(&mut details, &mut scene, &mut viewer, &straight());
    assert_eq!(
        scene
            .geometry(HALL)
            .expect("ours")
            .mesh_of(items[2].index)
            .face_count(),
        faces[2]
    );
}

#[test]
fn a_scene_that_would_grow_too_large_stays_as_it_was() {
    let mut builder = enfilade::SceneBuilder::new();
    builder.limit_bytes(60_000);
    let geometry = enfilade::GeometryBuilder::new(crate::world::materials());
    builder.add("hall", geometry.build().expect("nothing"), Method::Bsp);
    let mut scene = builder.build().expect("small");
    let mut details = Details::new(DetailOptions::default());
    let ball = details
        .add(&mut scene, HALL, "ball", Ball::new(), at([0.0, 0.0, -1.5]))
        .expect("a box fits");
    let mut viewer = Viewer::new();
    let view = enfilade::View::new([0.0; 3], [0.0, 0.0, -5.0], [1280, 720]).expect("a valid view");
    for _ in 0..3 {
        let set = viewer.look(&scene, &view);
        assert_eq!(set.items().len(), 1);
        details
            .refine(&mut scene, &[set])
            .expect_err("a tree of thousands of faces");
        assert_eq!(details.level(HALL, ball), Some(None));
    }
}
