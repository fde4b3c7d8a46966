//! Every method on the built-in scenes, at 1280x720: the cost of a look, and of a draw without painting.
//!
//! A wrong number of visible items is an error. Temporal coherence comes from the view before.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use enfilade::geom::{BspOptions, BspStep, BspTree, Polygons};
use enfilade::order::{Bsp, FarToNear, Order};
use enfilade::{
    Canvas, Contract, Geometry, ItemIndex, Method, Passage, PassageId, Scene, SectorId, Span, View, Viewer,
    VisibleItem, VisibleSet,
};

/// A path over cameras of a built-in scene, and the number of visible items or clusters from each, for exact methods;
/// see [`count`].
struct Path {
    scene: &'static str,
    cameras: &'static [(&'static str, usize)],
    draws: bool,
}

/// Tolerance of that number: items visible only in contested samples, where two faces are equally near.
const CONTESTED: usize = 1;

const SIZE: [u32; 2] = [1280, 720];

const PATHS: [Path; 3] = [
    Path {
        scene: "enfilade",
        cameras: &[("enfilade", 2_108), ("rotunda", 2_329), ("gallery", 4_752)],
        draws: true,
    },
    Path {
        scene: "crowd",
        cameras: &[("before the wall", 24), ("at a gap", 50), ("among them", 92)],
        draws: false,
    },
    Path {
        scene: "big-mesh",
        cameras: &[("valley", 110), ("hilltop", 127), ("from the edge", 256)],
        draws: false,
    },
];

/// Counts the visible items; a large item counts by its visible clusters.
fn count(set: &VisibleSet, scene: &Scene) -> usize {
    let clusters = |item: &VisibleItem| match set.clusters(item).len() {
        0 => {
            let geometry = scene.geometry(set.passage(item.passage).sector);
            geometry.map_or(1, |geometry| geometry.mesh_of(item.item.index).clusters().len())
        }
        some => some,
    };
    set.items().iter().map(clusters).sum()
}

/// A canvas that ignores all spans.
struct Nothing;

impl Canvas for Nothing {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}
    fn row(&mut self, _y: u16, _spans: &[Span]) {}
}

fn methods(criterion: &mut Criterion) {
    for path in &PATHS {
        let built = enfilade_scenes::built_in(path.scene).expect("a built-in scene");
        let view = |name: &str| -> View {
            let camera = built.cameras.iter().find(|camera| camera.name == name);
            camera.expect("a camera of that scene").view(SIZE)
        };
        let views: Vec<View> = path.cameras.iter().map(|(name, _)| view(name)).collect();
        let mut looks = criterion.benchmark_group(format!("look @{}", path.scene));
        for method in Method::ALL
            .into_iter()
            .filter(|&method| built.scene.suits(method) && method.contract().never_misses())
        {
            let scene = built
                .scene
                .with_method(method, Method::DEFAULT_LIMIT)
                .expect("small");
            let mut viewer = Viewer::new();
            for (&(name, expected), view) in path.cameras.iter().zip(&views) {
                let seen = count(viewer.look(&scene, view), &scene);
                let right = match method.contract() {
                    Contract::Exact => seen.abs_diff(expected) <= CONTESTED,
                    _ => seen + CONTESTED >= expected,
                };
                assert!(
                    right,
                    "{method} on @{} from `{name}`: {seen} visible, expected {expected}",
                    path.scene
                );
            }
            looks.bench_function(BenchmarkId::from_parameter(method), |bench| {
                bench.iter(|| {
                    for view in &views {
                        viewer.look(&scene, view);
                    }
                });
            });
            if path.draws {
                looks.bench_function(BenchmarkId::new("and draw", method), |bench| {
                    bench.iter(|| {
                        for view in &views {
                            viewer.draw(&scene, view, &mut Nothing);
                        }
                    });
                });
            }
        }
        looks.finish();
    }
}

/// The thesis' comparison by time: four cylinders of 60 rectangles. Its figures: 4.097 s to build a tree, 0.002 s to
/// traverse it, 0.012 s to sort faces. The thesis' traversal yields a list of polygons; `order` also projects each face
/// to the screen.
fn four_cylinders(criterion: &mut Criterion) {
    const FACES: u64 = 240;
    let built = enfilade_scenes::built_in("four-cylinders").expect("a built-in scene");
    let geometry = built.scene.geometry(SectorId(0)).expect("a geometry");
    let view = built.cameras[0].view(SIZE);
    let mut group = criterion.benchmark_group("@four-cylinders");
    let pieces = |tree: &Bsp<FarToNear>| tree.build_stats(geometry).faces;
    for (name, free_splits) in [
        (
            "build a BSP tree, every polygon scored",
            BspOptions::default().free_splits,
        ),
        ("build a BSP tree of polygon planes only", f32::INFINITY),
    ] {
        let options = BspOptions {
            candidates: u32::MAX,
            free_splits,
            ..BspOptions::default()
        };
        let build = || pieces(&Bsp::with_options(geometry, &options));
        assert_eq!(build(), FACES, "no cylinder cuts another");
        group.bench_function(name, |bench| bench.iter(build));
    }
    let tree = BspTree::build(&polygons(geometry), &BspOptions::default());
    let (eye, mut stack, mut list) = (view.eye.map(f64::from), Vec::new(), Vec::new());
    group.bench_function("list all polygons in tree order", |bench| {
        bench.iter(|| {
            list.clear();
            tree.walk(eye, false, &mut stack, &mut |step| {
                if let BspStep::Coplanar(pieces) = step {
                    list.extend(pieces.iter().map(|piece| piece.polygon));
                }
                true
            });
            assert_eq!(list.len() as u64, FACES);
        });
    });
    for method in [Method::Bsp, Method::PainterMin, Method::PainterMean] {
        let scene = built
            .scene
            .with_method(method, Method::DEFAULT_LIMIT)
            .expect("small");
        let mut viewer = Viewer::new();
        viewer.look(&scene, &view);
        assert_eq!(viewer.walk(&scene), FACES, "{method} visits every face");
        group.bench_function(BenchmarkId::new("order", method), |bench| {
            bench.iter(|| viewer.walk(&scene));
        });
        group.bench_function(BenchmarkId::new("draw", method), |bench| {
            bench.iter(|| viewer.draw(&scene, &view, &mut Nothing).items().len());
        });
    }
    group.finish();
}

/// Returns every face of every item, in sector space.
fn polygons(geometry: &Geometry) -> Polygons {
    let mut polygons = Polygons::default();
    polygons.starts.push(0);
    for item in (0..geometry.items().len() as u32).map(ItemIndex) {
        let (mesh, place) = (geometry.mesh_of(item), geometry.item(item).transform());
        for face in 0..mesh.face_count() {
            let corners = mesh.face(face).iter();
            let corners = corners.map(|&corner| place.point(mesh.positions()[corner as usize]));
            polygons.corners.extend(corners.map(|at| at.map(f64::from)));
            polygons.starts.push(polygons.corners.len() as u32);
        }
    }
    polygons
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = methods, four_cylinders
}
criterion_main!(benches);
