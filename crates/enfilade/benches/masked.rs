//! The masked depth buffer at 1280x720: occluders per second by size, and box tests per second.
//!
//! A wrong number of occluders, samples or hidden boxes is an error.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use enfilade::cover::{Cover, Hides, MaskedDepth};
use enfilade::order::{BvhOrder, Order, Visit};
use enfilade::{
    Faces, Geometry, GeometryBuilder, ItemIndex, Material, MaterialId, Mesh, Method, Occluder, OccluderRoom,
    OccluderSelection, OccluderSet, Passage, Region, SceneBuilder, SectorId, Stats, Transform, View, Viewer,
    Visibility,
};

const SIZE: [u32; 2] = [1280, 720];

/// Returns the passage of the eye.
fn passage(scene: &enfilade::Scene, view: &View) -> Passage {
    Viewer::new().look(scene, view).passages()[0].clone()
}

/// Returns the best occluders of a geometry as projected in `passage`, best first, each in its own buffer.
fn occluders<'a>(
    geometry: &Geometry,
    passage: &Passage,
    budget: usize,
    rooms: &'a mut Vec<OccluderRoom>,
) -> Vec<Occluder<'a>> {
    let set = OccluderSet::build(geometry);
    let mut choice = OccluderSelection::default();
    let chosen = set.choose(geometry, passage, MaskedDepth::MEASURE, budget, &mut choice);
    rooms.resize_with(chosen.len(), OccluderRoom::default);
    let all = chosen.iter().zip(rooms);
    all.filter_map(|(chosen, room)| set.on_screen(geometry, passage, chosen, room))
        .collect()
}

fn filled(cover: &mut MaskedDepth, passage: &Passage, occluders: &[Occluder]) -> u64 {
    let mut stats = Stats::default();
    cover.clear(passage);
    for occluder in occluders {
        cover.hide(occluder, passage, &mut stats);
    }
    stats.samples
}

/// Builds triangles with two sides of the given length in pixels, all over the screen, at all depths and orientations.
fn triangles(pixels: f32, count: u32) -> Geometry {
    let view = View::new([0.0; 3], [0.0, 0.0, -1.0], SIZE);
    let focal = 0.5 * SIZE[1] as f32 / (0.5 * view.fov_y).tan();
    let mut builder = GeometryBuilder::new([Material {
        double_sided: true,
        ..Material::opaque([1.0; 3])
    }]);
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("a triangle");
    let mesh = builder.mesh(mesh);
    for i in 0..count {
        // Three low-discrepancy sequences.
        let [x, y, depth] =
            [0.754_877_7, 0.569_840_3, 0.324_717_96].map(|step: f64| (f64::from(i) * step).fract() as f32);
        let distance = 2.0 + 48.0 * depth;
        let [x, y] = [x - 0.5, 0.55 * (y - 0.5)].map(|side| 1.8 * side * distance);
        let side = pixels / focal * distance;
        let place = Transform::translation([x, y, -distance])
            * Transform::rotation([0.0, 0.0, 1.0], f64::from(i))
            * Transform::rotation([1.0, 0.0, 0.0], 0.5)
            * Transform::scaling([side; 3]);
        builder.item("triangle", mesh, place);
    }
    builder.build().expect("sound triangles")
}

fn fill(criterion: &mut Criterion) {
    const COUNT: u32 = 4000;
    let mut group = criterion.benchmark_group("masked: fill, triangles");
    group.throughput(Throughput::Elements(u64::from(COUNT)));
    for (pixels, samples) in [(10.0, SAMPLES[0]), (100.0, SAMPLES[1])] {
        let mut scene = SceneBuilder::new();
        let all = scene.add("all", triangles(pixels, COUNT), Method::ZBuffer);
        let scene = scene.build().expect("one sector");
        let geometry = scene.geometry(all).expect("a geometry");
        let passage = passage(&scene, &View::new([0.0; 3], [0.0, 0.0, -1.0], SIZE));
        let mut rooms = Vec::new();
        let occluders = occluders(geometry, &passage, COUNT as usize, &mut rooms);
        assert_eq!(occluders.len(), COUNT as usize);
        let mut cover = MaskedDepth::default();
        assert_eq!(filled(&mut cover, &passage, &occluders), samples);
        group.bench_function(BenchmarkId::from_parameter(format!("{pixels} pixels")), |bench| {
            bench.iter(|| filled(&mut cover, &passage, &occluders));
        });
    }
    group.finish();
}

/// Samples covered by the triangles, counted per triangle.
const SAMPLES: [u64; 2] = [176_710, 18_746_320];

/// All boxes that an order tests if nothing is hidden.
#[derive(Default)]
struct Boxes(Vec<Region>);

impl Visit for Boxes {
    fn enter(&mut self, region: &Region) -> Visibility {
        self.0.push(*region);
        Visibility::Partial
    }

    fn first_time(&mut self, _item: ItemIndex) -> bool {
        true
    }

    fn faces(&mut self, _faces: &Faces) {}
}

fn ask(criterion: &mut Criterion) {
    let built = enfilade_scenes::built_in("crowd").expect("a built-in scene");
    let geometry = built.scene.geometry(SectorId(0)).expect("a geometry");
    let order = BvhOrder::build(geometry, Method::DEFAULT_LIMIT).expect("a small scene");
    let mut group = criterion.benchmark_group("masked: test, boxes of @crowd");
    for (name, expected) in ASKED {
        let camera = built.cameras.iter().find(|camera| camera.name == name);
        let passage = passage(&built.scene, &camera.expect("a camera of that scene").view(SIZE));
        let mut rooms = Vec::new();
        let occluders = occluders(geometry, &passage, 16, &mut rooms);
        let mut cover = MaskedDepth::default();
        filled(&mut cover, &passage, &occluders);
        let mut boxes = Boxes::default();
        order.visit(geometry, &passage, &mut Default::default(), &mut boxes);
        let mut hidden = || {
            let each = boxes.0.iter().map(|region| cover.test(region));
            each.filter(|&sight| sight == Visibility::Hidden).count()
        };
        assert_eq!([occluders.len(), hidden()], expected, "{name}");
        group.throughput(Throughput::Elements(boxes.0.len() as u64));
        group.bench_function(BenchmarkId::from_parameter(name), |bench| bench.iter(&mut hidden));
    }
    group.finish();
}

/// Camera, number of visible occluders, number of boxes they hide.
const ASKED: [(&str, [usize; 2]); 3] = [
    ("before the wall", [16, 3318]),
    ("at a gap", [16, 2877]),
    ("among them", [16, 1634]),
];

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = fill, ask
}
criterion_main!(benches);
