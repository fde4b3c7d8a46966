//! Walks through a town of which only a part fits into memory.

use super::*;
use enfilade::{
    Aabb, Attributes, GeometryBuilder, Indices, ItemOptions, Material, MaterialId, Method, Part, Transform,
    Vertices, View, Viewer,
};
use enfilade_import::{ReadOptions, Room, bake, bake_hints};
use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const HOUSES: u32 = 9;

/// A house whose walls are grids of squares, so that a page holds few houses.
fn house(height: f32) -> Mesh {
    const SIDE: u32 = 16;
    let (mut positions, mut corners) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for front in [false, true] {
            let first = positions.len() as u32;
            for row in 0..=SIDE {
                for column in 0..=SIDE {
                    let [u, v] = [column, row].map(|line| line as f32 / SIDE as f32);
                    let mut at = [0.0; 3];
                    (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (f32::from(u8::from(front)), u, v);
                    positions.push([at[0] * 8.0, at[1] * height, at[2] * 8.0]);
                }
            }
            for row in 0..SIDE {
                for column in 0..SIDE {
                    let [a, c] = [0, SIDE + 1].map(|next| first + row * (SIDE + 1) + column + next);
                    let square = [a, a + 1, c + 1, a, c + 1, c];
                    corners.extend(if front {
                        square
                    } else {
                        square.map(|i| a + c + 1 - i)
                    });
                }
            }
        }
    }
    let part = Part {
        positions: Vertices::Packed(&positions),
        corners: Indices::U32(&corners),
        sides: None,
        material: MaterialId(0),
        attributes: Attributes::default(),
    };
    Mesh::new(&[part]).expect("a house")
}

/// A town of houses along streets, 20 units apart, with a flat plate as its ground.
fn town() -> Import {
    let mut builder = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    let ground = builder.mesh(
        Mesh::triangles(
            &[[-99.0, 0.0, -99.0], [-99.0, 0.0, 999.0], [999.0, 0.0, -99.0]],
            &[0, 1, 2],
            MaterialId(0),
        )
        .expect("a plate"),
    );
    builder.item("ground", ground, Transform::IDENTITY);
    for number in 0..HOUSES * HOUSES {
        let mesh = builder.mesh(house(6.0 + number as f32 / 100.0));
        let [x, z] = [number % HOUSES, number / HOUSES].map(|place| 20.0 * place as f32);
        builder.item(
            &format!("house {number}"),
            mesh,
            Transform::translation([x, 0.0, z]),
        );
    }
    Import::of_rooms(vec![Room::new("town", builder.build().expect("a town"))])
}

/// The town as a file, and as a scene with everything in memory.
fn baked() -> (TempDir, PathBuf, Scene) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("town.enf");
    let town = town();
    bake(&town, File::create(&file).expect("a file")).expect("baked");
    let whole = town.scene(Method::HierarchicalZ, u64::MAX).expect("a scene");
    (folder, file, whole)
}

fn opened(file: &Path, method: Method, options: PagerOptions) -> (Scene, Pager) {
    let (import, pages) = Pages::open(file, &ReadOptions::default()).expect("pages");
    let scene = import.scene(method, u64::MAX).expect("a scene");
    (scene, Pager::new(import, pages, options))
}

/// A view from a street, at this part of a walk along it.
fn view(part: f32) -> View {
    let x = 180.0 * part - 10.0;
    let turn = part * 20.0;
    let [eye, toward] = [[x, 1.6, 34.0], [x + turn.cos(), 1.6, 34.0 + turn.sin()]];
    View::new(eye, toward, [160, 90]).expect("a view")
}

fn items(set: &VisibleSet) -> BTreeSet<u32> {
    set.items().iter().map(|visible| visible.item.index.0).collect()
}

#[test]
fn what_is_absent_and_what_is_seen_are_never_less_than_the_truth() {
    let (_folder, file, whole) = baked();
    for method in [
        Method::HierarchicalZ,
        Method::Masked,
        Method::Svbsp,
        Method::Mobsp,
        Method::ZBuffer,
    ] {
        let options = PagerOptions {
            bytes: 2_500_000,
            ..PagerOptions::default()
        };
        let (mut scene, mut pager) = opened(&file, method, options);
        let [mut viewer, mut truth] = [Viewer::new(), Viewer::new()];
        let (mut absent, mut dropped, mut loaded) = (0, 0, 0);
        for frame in 0..120 {
            let view = view(frame as f32 / 120.0);
            let seen = viewer.look(&scene, &view);
            let lost: Vec<u32> = items(truth.look(&whole, &view))
                .difference(&items(seen))
                .copied()
                .collect();
            assert!(lost.is_empty(), "{method}, frame {frame}: {lost:?}");
            let stats = pager.step(&mut scene, &[seen]).expect("a step");
            assert!(stats.bytes <= 2_500_000, "{stats:?}");
            assert!(stats.failed.is_empty() && stats.loaded <= 8, "{stats:?}");
            absent += stats.absent;
            dropped += stats.dropped;
            loaded += stats.loaded;
            if frame % 3 == 0 {
                pager.wait(Duration::from_secs(5));
            }
        }
        assert!(
            absent > 0 && loaded > 10 && dropped > 5,
            "{method}: {absent} {loaded} {dropped}"
        );
        let geometry = scene.geometry(SectorId(0)).expect("the town");
        assert!(
            geometry.meshes().len() < 3 * geometry.items().len(),
            "meshes are reused"
        );
    }
}

/// Looks and loads until nothing more comes.
fn settle(scene: &mut Scene, pager: &mut Pager, view: &View) -> (BTreeSet<u32>, PagerStats) {
    let mut viewer = Viewer::new();
    for _ in 0..200 {
        let seen = viewer.look(scene, view);
        let stats = pager.step(scene, &[seen]).expect("a step");
        if stats.loaded == 0 && stats.loading == 0 {
            return (items(viewer.look(scene, view)), stats);
        }
        pager.wait(Duration::from_secs(5));
    }
    panic!("pages come for ever");
}

#[test]
fn once_nothing_visible_is_absent_the_set_is_that_of_the_whole_town() {
    let (_folder, file, whole) = baked();
    let options = PagerOptions {
        pages_per_step: 1,
        ..PagerOptions::default()
    };
    let (mut scene, mut pager) = opened(&file, Method::HierarchicalZ, options);
    let mut absent = Vec::new();
    for part in [0.05, 0.4, 0.8] {
        let (seen, stats) = settle(&mut scene, &mut pager, &view(part));
        assert_eq!((stats.absent, stats.over_budget), (0, 0));
        assert_eq!(seen, items(Viewer::new().look(&whole, &view(part))));
        let houses = 1..=HOUSES * HOUSES;
        absent.push(
            houses
                .filter(|&house| pager.is_absent(SectorId(0), ItemIndex(house).into()))
                .count(),
        );
    }
    assert!(absent[0] > 8 && absent.is_sorted_by(|a, b| a >= b), "{absent:?}");
}

#[test]
fn with_a_budget_for_nothing_all_that_is_visible_is_a_box() {
    let (_folder, file, whole) = baked();
    let options = PagerOptions {
        bytes: 0,
        threads: 0,
        pages_per_step: 0,
        ..PagerOptions::default()
    };
    let (mut scene, mut pager) = opened(&file, Method::Masked, options);
    let (seen, stats) = settle(&mut scene, &mut pager, &view(0.5));
    assert!(
        stats.over_budget > 0 && stats.absent as usize == seen.len(),
        "{stats:?}"
    );
    assert!(seen.is_superset(&items(Viewer::new().look(&whole, &view(0.5)))));
}

#[test]
fn a_damaged_page_is_reported_once_and_its_houses_stay_boxes() {
    let (folder, file, _) = baked();
    let mut bytes = std::fs::read(&file).expect("bytes");
    // In the first page, which begins after the header.
    bytes[5000] ^= 1;
    let damaged = folder.path().join("damaged.enf");
    std::fs::write(&damaged, bytes).expect("written");
    let (mut scene, mut pager) = opened(&damaged, Method::HierarchicalZ, PagerOptions::default());
    let mut failed = Vec::new();
    let mut viewer = Viewer::new();
    let above = View::new([90.0, 200.0, 90.1], [90.0, 0.0, 90.0], [320, 180]).expect("a view");
    let mut last = PagerStats::default();
    for _ in 0..60 {
        let seen = viewer.look(&scene, &above);
        last = pager.step(&mut scene, &[seen]).expect("a step");
        failed.append(&mut last.failed);
        pager.wait(Duration::from_secs(5));
    }
    let [(0, why)] = &failed[..] else {
        panic!("{failed:?}")
    };
    assert!(why.contains("damaged.enf") && why.contains("`page 0`"), "{why}");
    assert!(last.absent > 0 && last.loading == 0, "{last:?}");
}

#[test]
fn houses_that_others_change_are_left_alone() {
    let (_folder, file, _) = baked();
    let (mut scene, mut pager) = opened(&file, Method::HierarchicalZ, PagerOptions::default());
    let town = SectorId(0);
    let [rebuilt, torn_down, hidden] = [20, 21, 22].map(|house| ItemId::from(ItemIndex(house)));
    let church = Arc::new(house(30.0));
    let mut edit = scene.edit();
    edit.set_mesh(town, rebuilt, Arc::clone(&church))
        .expect("rebuilt");
    edit.remove(town, torn_down).expect("torn down");
    let never_drawn = ItemOptions {
        layers: 0,
        ..ItemOptions::default()
    };
    edit.set_options(town, hidden, never_drawn).expect("hidden");
    edit.finish().expect("edited");
    let above = View::new([90.0, 200.0, 90.1], [90.0, 0.0, 90.0], [320, 180]).expect("a view");
    settle(&mut scene, &mut pager, &above);
    let geometry = scene.geometry(town).expect("the town");
    assert!(Arc::ptr_eq(
        &geometry.meshes()[geometry.item(rebuilt.index).mesh.0 as usize],
        &church
    ));
    assert!(!geometry.holds(torn_down.index));
    assert_eq!(geometry.item(hidden.index).options, never_drawn);
    assert!(!pager.is_absent(town, rebuilt) && !pager.is_absent(town, torn_down));
}

#[test]
fn rooms_that_need_all_their_meshes_are_read_whole() {
    let (folder, _, _) = baked();
    let file = folder.path().join("bsp.enf");
    let mut town = town();
    town.rooms[0].method = Some(Method::Bsp);
    bake(&town, File::create(&file).expect("a file")).expect("baked");
    let (import, pages) = Pages::open(&file, &ReadOptions::default()).expect("pages");
    assert!((0..pages.count()).all(|page| pages.is_resident(page)));
    assert_eq!(
        import.rooms[0].geometry.face_count(),
        town.rooms[0].geometry.face_count()
    );
    let pager = Pager::new(import, pages, PagerOptions::default());
    assert!(!pager.is_absent(SectorId(0), ItemIndex(5).into()));
}

/// Samples hints into the file of the town.
fn with_hints(file: &Path, change: impl Fn(&mut Hint)) -> Vec<Hint> {
    let options = HintOptions {
        size: 128,
        ..HintOptions::default()
    };
    let mut sampler = HintSampler::open(file, options).expect("a town");
    let mut hints: Vec<Hint> = (0..sampler.region_count())
        .map(|region| sampler.sample(region).expect("sampled"))
        .collect();
    drop(sampler);
    hints.iter_mut().for_each(change);
    let hinted = file.with_extension("new");
    bake_hints(file, &hints, File::create(&hinted).expect("a file")).expect("baked");
    std::fs::rename(hinted, file).expect("renamed");
    hints
}

#[test]
fn hints_name_what_is_seen_whatever_the_budget_and_most_of_what_further_views_see() {
    let (_folder, file, _) = baked();
    let hints = with_hints(&file, |_| {});
    let [hint] = &hints[..] else {
        panic!("a town of one region: {hints:?}")
    };
    assert!(hint.items.len() > 60, "{} items", hint.items.len());
    let mut options = HintOptions {
        size: 128,
        bytes: 12_000_000,
        ..HintOptions::default()
    };
    let mut sampler = HintSampler::open(&file, options).expect("a town");
    assert_eq!(&sampler.sample(0).expect("sampled"), hint);
    let check = sampler.check(0, hint, 20).expect("checked");
    assert!(
        check.views == 20 && 10 * check.covered >= 9 * check.views && check.visible > 50,
        "{check:?}"
    );
    assert!(hint.items.len() as u64 <= check.seen);
    options.bytes = 1000;
    let why = HintSampler::open(&file, options).expect("a town").sample(0);
    assert!(matches!(why, Err(HintError::Memory(1000))), "{why:?}");
}

#[test]
fn wrong_hints_change_the_order_of_loading_and_not_what_is_seen() {
    let (_folder, file, whole) = baked();
    with_hints(&file, |hint| {
        // The houses at the far end only, and the region is not where the eye is.
        hint.items = (0..20)
            .map(|house| (SectorId(0), ItemIndex(81 - house)))
            .collect();
        hint.bounds = Aabb {
            min: [5e3; 3],
            max: [6e3; 3],
        };
    });
    let options = PagerOptions {
        bytes: 7_000_000,
        ..PagerOptions::default()
    };
    let (mut scene, mut pager) = opened(&file, Method::HierarchicalZ, options);
    let [mut viewer, mut truth] = [Viewer::new(), Viewer::new()];
    for frame in 0..60 {
        let view = view(frame as f32 / 60.0);
        let seen = viewer.look(&scene, &view);
        let all = items(truth.look(&whole, &view));
        assert!(all.is_subset(&items(seen)), "frame {frame}");
        let stats = pager.step(&mut scene, &[seen]).expect("a step");
        assert!(stats.bytes <= 7_000_000, "{stats:?}");
        pager.wait(Duration::from_millis(20));
    }
    // Nothing that is visible waits for what hints name.
    let (seen, stats) = settle(&mut scene, &mut pager, &view(0.05));
    assert_eq!((stats.absent, stats.over_budget), (0, 0));
    assert_eq!(seen, items(truth.look(&whole, &view(0.05))));
}

#[test]
fn what_hints_name_is_there_before_the_eye_turns_to_it() {
    let (_folder, file, whole) = baked();
    with_hints(&file, |_| {});
    let (mut scene, mut pager) = opened(&file, Method::HierarchicalZ, PagerOptions::default());
    settle(&mut scene, &mut pager, &view(0.3));
    let mut viewer = Viewer::new();
    for turn in 0..16_u8 {
        let angle = f32::from(turn) * std::f32::consts::FRAC_PI_8;
        let eye = [44.0, 1.6, 34.0];
        let toward = [eye[0] + angle.cos(), 1.6, eye[2] + angle.sin()];
        let view = View::new(eye, toward, [160, 90]).expect("a view");
        let seen = viewer.look(&scene, &view);
        assert_eq!(
            items(seen),
            items(Viewer::new().look(&whole, &view)),
            "turn {turn}"
        );
        assert_eq!(
            pager.step(&mut scene, &[seen]).expect("a step").absent,
            0,
            "turn {turn}"
        );
    }
}

#[test]
fn coarser_meshes_are_there_before_the_houses_and_leave_for_them() {
    let (_folder, file, whole) = baked();
    let options = PagerOptions {
        pages_per_step: 1,
        ..PagerOptions::default()
    };
    let (mut scene, mut pager) = opened(&file, Method::HierarchicalZ, options);
    let above = View::new([90.0, 200.0, 90.1], [90.0, 0.0, 90.0], [320, 180]).expect("a view");
    let mut viewer = Viewer::new();
    let (mut coarse, mut absent) = (0, 0);
    for _ in 0..400 {
        let seen = viewer.look(&scene, &above);
        let stats = pager.step(&mut scene, &[seen]).expect("a step");
        (coarse, absent) = (coarse + stats.coarse, absent + stats.absent);
        assert!(stats.coarse <= stats.absent);
        for house in 1..=HOUSES * HOUSES {
            let item = ItemIndex(house).into();
            let Some(level) = pager.level(SectorId(0), item) else {
                continue;
            };
            assert!(pager.is_absent(SectorId(0), item));
            let mesh = whole
                .geometry(SectorId(0))
                .expect("the town")
                .mesh_of(ItemIndex(house));
            assert_eq!(level.bounds().union(&mesh.bounds()), mesh.bounds());
            assert!(8 * level.triangle_count() <= mesh.triangle_count());
        }
        if stats.absent == 0 && stats.loading == 0 {
            break;
        }
        pager.wait(Duration::from_secs(5));
    }
    assert!(2 * coarse > absent && absent > 0, "{coarse} of {absent}");
    assert!((1..=HOUSES * HOUSES).all(|house| pager.level(SectorId(0), ItemIndex(house).into()).is_none()));
}
