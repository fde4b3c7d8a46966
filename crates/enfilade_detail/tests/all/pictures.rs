//! The picture of the chosen level matches that of the finest one, except for a pixel along silhouettes.

use crate::world::{Ball, HALL, at, empty, settle};
use enfilade::{
    Camera, Canvas, Geometry, GeometryBuilder, ItemIndex, Material, MaterialId, Method, Passage, PassageId,
    Scene, SceneBuilder, Span, Transform, View, Viewer,
};
use enfilade_detail::{BezierPatch, BezierSurface, DetailOptions, DetailSource, Details};
use std::sync::Arc;

/// Resolution of the compared pictures relative to the view, per axis.
const FINER: u32 = 4;

const SIZE: [u32; 2] = [128, 96];

/// Which samples are covered.
struct Covered(Vec<Vec<bool>>);

impl Canvas for Covered {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}

    fn row(&mut self, y: u16, spans: &[Span]) {
        for span in spans {
            self.0[usize::from(y)][usize::from(span.x0)..usize::from(span.x1)].fill(true);
        }
    }
}

/// Renders coverage at a higher resolution than that of the views.
fn covers(scene: &Scene, camera: &Camera) -> Vec<Vec<bool>> {
    let view = camera.view(SIZE.map(|side| FINER * side)).expect("a valid view");
    let [width, height] = view.size().map(|side| side as usize);
    let mut covered = Covered(vec![vec![false; width]; height]);
    Viewer::new().draw(scene, &view, &mut covered);
    covered.0
}

/// Returns the maximum distance of a covered sample of one picture from the other's covered samples, in pixels of the
/// view.
fn farthest(from: &[Vec<bool>], to: &[Vec<bool>]) -> f64 {
    let (height, width) = (from.len() as i32, from[0].len() as i32);
    let mut farthest = 0.0_f64;
    for y in 0..height {
        for x in 0..width {
            if !from[y as usize][x as usize] || to[y as usize][x as usize] {
                continue;
            }
            let reach = 3 * FINER as i32;
            let around = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| [dx, dy]));
            let nearest = around
                .filter(|[dx, dy]| {
                    let [x, y] = [x + dx, y + dy];
                    (0..width).contains(&x) && (0..height).contains(&y) && to[y as usize][x as usize]
                })
                .map(|[dx, dy]| f64::from(dx * dx + dy * dy).sqrt())
                .fold(f64::INFINITY, f64::min);
            farthest = farthest.max(nearest / f64::from(FINER));
        }
    }
    farthest
}

/// Compares the refined picture with that of the finest level, at many distances. Returns the levels used.
fn silhouettes_agree(scene: &Scene, source: &Arc<dyn DetailSource>, place: Transform) -> Vec<u32> {
    let mut finest = scene.clone();
    let mut edit = finest.edit();
    let mesh = source.build(source.levels() - 1).expect("the finest");
    edit.add(HALL, "finest", mesh, place).expect("it fits");
    edit.finish().expect("little");
    let mut scene = scene.clone();
    let mut details = Details::new(DetailOptions::default());
    let item = details
        .add(&mut scene, HALL, "item", source.clone(), place)
        .expect("it fits");
    let (mut viewer, mut levels) = (Viewer::new(), Vec::new());
    let mut worst = 0.0_f64;
    for step in 0..24 {
        let distance = 40.0 * 0.85_f32.powi(step);
        let angle = step as f32;
        let eye = [distance * angle.sin(), 0.4 * distance, distance * angle.cos()];
        let camera = Camera::new(eye, [0.1, 0.0, 0.0]);
        let view = camera.view(SIZE).expect("a valid view");
        settle(&mut details, &mut scene, &mut viewer, &view);
        levels.push(details.level(HALL, item).flatten().expect("it is seen"));
        let [chosen, full] = [covers(&scene, &camera), covers(&finest, &camera)];
        // The position of a silhouette is known only to half a sample diagonal, in either picture.
        let known = 2_f64.sqrt() / f64::from(FINER);
        for off in [farthest(&chosen, &full), farthest(&full, &chosen)] {
            assert!(
                off <= 1.0 + known,
                "{off} pixels at {distance}, level {:?}",
                levels.last()
            );
            worst = worst.max(off);
        }
    }
    assert!(worst > 0.0, "the pictures are equal, so nothing was tested");
    levels.sort_unstable();
    levels.dedup();
    levels
}

#[test]
fn the_silhouette_of_a_ball_is_never_off_by_more_than_a_pixel() {
    let ball: Arc<dyn DetailSource> = Ball::new();
    let place = Transform::rotation([1.0, 2.0, 0.0], 0.7) * Transform::scaling([2.0, 1.0, 3.0]);
    let levels = silhouettes_agree(&empty(Method::ZBuffer), &ball, place);
    assert!(levels.len() >= 3, "{levels:?}");
}

/// Nine wavy patches of double-sided clay.
fn waves() -> (Scene, Arc<dyn DetailSource>) {
    let mut scene = SceneBuilder::new();
    let clay = Material {
        double_sided: true,
        ..Material::opaque([0.5; 3])
    };
    let geometry: Geometry = GeometryBuilder::new([clay]).build().expect("nothing yet");
    scene.add("hall", geometry, Method::ZBuffer);
    let height = |x: usize, y: usize| [0.0, 0.9, -0.7, 0.3][(3 * x + 5 * y) % 4];
    let patches: Vec<BezierPatch> = (0..9)
        .map(|place| {
            std::array::from_fn(|number| {
                let [x, y] = [3 * (place % 3) + number % 4, 3 * (place / 3) + number / 4];
                [0.25 * x as f32 - 1.1, height(x, y), 0.25 * y as f32 - 1.1]
            })
        })
        .collect();
    let surface = BezierSurface::new(&patches, MaterialId(0)).expect("finite");
    (scene.build().expect("a hall"), Arc::new(surface))
}

#[test]
fn the_silhouette_of_a_bezier_surface_is_never_off_by_more_than_a_pixel() {
    let (scene, waves) = waves();
    let levels = silhouettes_agree(&scene, &waves, at([0.0, 0.2, 0.0]));
    assert!(levels.len() >= 4, "{levels:?}");
}

#[test]
fn a_bezier_surface_hides_nothing_and_is_seen_at_every_level() {
    let (mut scene, waves) = waves();
    let mut details = Details::new(DetailOptions::default());
    details
        .add(&mut scene, HALL, "waves", waves, Transform::IDENTITY)
        .expect("it fits");
    let mut viewer = Viewer::new();
    for distance in [100.0, 20.0, 5.0, 2.0] {
        let view = View::new([0.0, distance, 0.1 * distance], [0.0; 3], [128, 96]).expect("a valid view");
        let refined = settle(&mut details, &mut scene, &mut viewer, &view);
        assert_eq!((viewer.visible().items().len(), refined.waiting), (1, 0));
        assert!(
            !scene
                .geometry(HALL)
                .expect("ours")
                .item(ItemIndex(0))
                .options
                .is_occluder
        );
    }
}
