//! The painter's algorithms of the thesis fail exactly where it says.
//!
//! They are reimplemented here in a few lines, with a ray per sample as the reference, so that the figures are verified
//! independently of the methods. Then the methods are tested against the same table.

use enfilade::{
    Canvas, Geometry, ItemIndex, Method, Owner, Passage, PassageId, Scene, SectorId, Span, Viewer,
};
use enfilade_scenes::{BuiltIn, Camera, Group, figures};
use glam::{DMat3, DVec3};

/// Figure, camera, and whether sorting by minimal and by mean z is right.
const TABLE: [(&str, &str, bool, bool); 19] = [
    ("tetrahedron", "front", false, true),
    ("parallel-triangles", "front", true, true),
    ("parallel-rectangles", "front", true, true),
    ("crossing-triangles", "front", false, false),
    ("cycle", "front", false, false),
    ("overlap", "mean right", false, true),
    ("overlap", "mean wrong", false, false),
    ("triangle-through-cube", "corner", false, false),
    ("wrong-winding", "front", false, true),
    ("cylinders-8", "front", true, true),
    ("cylinders-16", "front", true, true),
    ("cylinders-32", "front", true, true),
    ("cones-8", "base seen", true, true),
    ("cones-8", "base hidden", false, true),
    ("cones-16", "base seen", true, true),
    ("cones-16", "base hidden", false, true),
    ("cones-32", "base seen", true, true),
    ("cones-32", "base hidden", false, true),
    ("four-cylinders", "from above", true, true),
];

const SIZE: [u32; 2] = [320, 240];
const SAMPLES: usize = (SIZE[0] * SIZE[1]) as usize;

/// A picture is wrong if at least this part of the painted samples shows another polygon than the nearest, and right if
/// none does; nothing is in between.
const WRONG: f64 = 0.01;

/// Relative distance within which two polygons have equal depth: along a shared edge either is right.
const EQUAL: f64 = 1e-6;

#[derive(Clone, Copy, Debug)]
enum Key {
    Min,
    Mean,
}

/// A polygon in camera space.
struct Polygon {
    /// Right, down and W, relative to the eye.
    corners: Vec<DVec3>,
    /// W at each sample; infinite outside the polygon.
    distances: Vec<f64>,
}

impl Polygon {
    fn new(corners: Vec<DVec3>, rays: &[DVec3]) -> Polygon {
        assert!(
            corners.iter().all(|corner| corner.z > 0.1),
            "nothing must be cut at the eye"
        );
        let normal = normal(&corners);
        let offset = normal.dot(corners[0]);
        let edges: Vec<DVec3> = edges(&corners)
            .map(|[a, b]| a.cross(b) * offset.signum())
            .collect();
        let distance = |ray: &DVec3| {
            let inside = edges.iter().all(|edge| edge.dot(*ray) >= 0.0);
            if inside {
                offset / normal.dot(*ray)
            } else {
                f64::INFINITY
            }
        };
        Polygon {
            distances: rays.iter().map(distance).collect(),
            corners,
        }
    }

    /// In f32, so that keys that are equal for a method are equal here.
    fn key(&self, key: Key) -> f32 {
        let distances = self.corners.iter().map(|corner| corner.z);
        let key = match key {
            Key::Min => distances.fold(f64::INFINITY, f64::min),
            Key::Mean => distances.sum::<f64>() / self.corners.len() as f64,
        };
        key as f32
    }
}

fn normal(corners: &[DVec3]) -> DVec3 {
    (1..corners.len() - 1)
        .map(|i| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]))
        .sum()
}

fn edges(corners: &[DVec3]) -> impl Iterator<Item = [DVec3; 2]> {
    (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]])
}

fn geometry(figure: &BuiltIn) -> &Geometry {
    figure
        .scene
        .geometry(SectorId(0))
        .expect("a figure with geometry")
}

/// Returns the polygons of a figure, item after item.
fn polygons(figure: &BuiltIn) -> Vec<Vec<DVec3>> {
    let geometry = geometry(figure);
    let polygons_of = |item| {
        let (mesh, place) = (geometry.mesh_of(item), geometry.item(item).transform());
        (0..mesh.face_count()).map(move |face| {
            let corners = mesh.face(face).iter();
            let corners = corners.map(|&corner| place.point(mesh.positions()[corner as usize]));
            corners.map(|at| DVec3::from(at.map(f64::from))).collect()
        })
    };
    (0..geometry.items().len() as u32)
        .map(ItemIndex)
        .flat_map(polygons_of)
        .collect()
}

fn look(figure: &BuiltIn, camera: &Camera) -> Vec<Polygon> {
    let [eye, toward, up] = [camera.eye, camera.toward, camera.up].map(|v| DVec3::from(v.map(f64::from)));
    let ahead = (toward - eye).normalize();
    let right = ahead.cross(up).normalize();
    let eye_from_figure = DMat3::from_cols(right, ahead.cross(right), ahead).transpose();
    let [width, height] = SIZE.map(f64::from);
    let focal = 0.5 * height / (0.5 * f64::from(camera.fov_y)).tan();
    let ray = |sample: usize| {
        let [x, y] = [sample as u32 % SIZE[0], sample as u32 / SIZE[0]].map(|at| f64::from(at) + 0.5);
        DVec3::new((x - 0.5 * width) / focal, (y - 0.5 * height) / focal, 1.0)
    };
    let rays: Vec<DVec3> = (0..SAMPLES).map(ray).collect();
    let seen = |corners: Vec<DVec3>| {
        let corners = corners.into_iter().map(|corner| eye_from_figure * (corner - eye));
        Polygon::new(corners.collect(), &rays)
    };
    polygons(figure).into_iter().map(seen).collect()
}

/// Returns the part of the painted samples that shows a polygon other than the nearest, if polygons are painted in this
/// order.
fn wrong_part(order: &[&Polygon]) -> f64 {
    let [mut wrong, mut painted] = [0_usize; 2];
    for sample in 0..SAMPLES {
        let mut distances = order.iter().rev().map(|polygon| polygon.distances[sample]);
        if let Some(shown) = distances.find(|distance| distance.is_finite()) {
            let nearest = distances.fold(shown, f64::min);
            painted += 1;
            wrong += usize::from(shown > nearest * (1.0 + EQUAL));
        }
    }
    assert!(painted > SAMPLES / 6, "the figure is small");
    wrong as f64 / painted as f64
}

/// Returns whether a sort is right. Tests both orders of equal keys, which must agree.
fn is_right(polygons: &[Polygon], key: Key) -> bool {
    let right = |mut order: Vec<&Polygon>| {
        order.sort_by(|a, b| b.key(key).total_cmp(&a.key(key)));
        judged(wrong_part(&order))
    };
    let [forth, back] = [polygons.iter().collect(), polygons.iter().rev().collect()].map(right);
    assert_eq!(forth, back, "equal keys decide");
    forth
}

fn judged(wrong: f64) -> bool {
    assert!(
        wrong == 0.0 || wrong >= WRONG,
        "{wrong} is neither right nor wrong"
    );
    wrong == 0.0
}

/// Returns every figure from each of its cameras, in the order of the catalogue.
fn looks() -> Vec<(&'static str, BuiltIn, Camera)> {
    let looks: Vec<_> = figures()
        .flat_map(|named| {
            let figure = named.build();
            let cameras = figure.cameras.clone();
            cameras
                .into_iter()
                .map(move |camera| (named.name, figure.clone(), camera))
        })
        .collect();
    let expected: Vec<_> = TABLE
        .iter()
        .map(|&(figure, camera, ..)| (figure, camera))
        .collect();
    let met: Vec<_> = looks
        .iter()
        .map(|(figure, _, camera)| (*figure, &*camera.name))
        .collect();
    assert_eq!(met, expected);
    looks
}

#[test]
fn painters_are_right_and_wrong_where_the_thesis_says() {
    for ((name, figure, camera), (.., min, mean)) in looks().into_iter().zip(TABLE) {
        let polygons = look(&figure, &camera);
        let right = [Key::Min, Key::Mean].map(|key| is_right(&polygons, key));
        assert_eq!(
            right,
            [min, mean],
            "@{name} from `{}`, by minimal and mean z",
            camera.name
        );
    }
}

/// Returns the owner of each sample.
struct Owners(Vec<Option<Owner>>);

impl Canvas for Owners {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}

    fn row(&mut self, y: u16, spans: &[Span]) {
        let start = usize::from(y) * SIZE[0] as usize;
        for span in spans {
            self.0[start + usize::from(span.x0)..start + usize::from(span.x1)].fill(Some(span.owner));
        }
    }
}

fn painted(scene: &Scene, method: Method, camera: &Camera) -> Owners {
    let scene = scene
        .with_method(method, Method::DEFAULT_LIMIT)
        .expect("within the memory limit");
    let mut owners = Owners(vec![None; SAMPLES]);
    Viewer::new().draw(&scene, &camera.view(SIZE), &mut owners);
    owners
}

#[test]
fn the_methods_are_right_and_wrong_where_the_thesis_says() {
    for ((name, figure, camera), (.., min, mean)) in looks().into_iter().zip(TABLE) {
        let truth = painted(&figure.scene, Method::ZBuffer, &camera).0;
        let all = truth.iter().flatten().count();
        for (method, expected) in [(Method::PainterMin, min), (Method::PainterMean, mean)] {
            let picture = painted(&figure.scene, method, &camera).0;
            let different = (0..SAMPLES)
                .filter(|&sample| picture[sample] != truth[sample])
                .count();
            let right = judged(different as f64 / all as f64);
            assert_eq!(right, expected, "{method} on @{name} from `{}`", camera.name);
        }
    }
}

#[test]
fn no_order_paints_what_crosses_or_overlaps_in_a_cycle() {
    for name in ["crossing-triangles", "cycle"] {
        let (_, figure, camera) = looks().into_iter().find(|look| look.0 == name).expect("a figure");
        let polygons = look(&figure, &camera);
        let mut order: Vec<&Polygon> = polygons.iter().collect();
        assert!(
            order.len() <= 3,
            "rotations and reversals cover all orders of three only"
        );
        for _ in 0..order.len() {
            order.rotate_left(1);
            assert!(wrong_part(&order) >= WRONG);
            assert!(wrong_part(&order.iter().rev().copied().collect::<Vec<_>>()) >= WRONG);
        }
    }
}

/// Returns `true` if an edge of `a` passes through the interior of `b`; touching does not count.
fn pierces(a: &[DVec3], b: &[DVec3]) -> bool {
    const TOUCHING: f64 = 1e-4;
    let normal = normal(b).normalize();
    edges(a).any(|[from, to]| {
        let [before, behind] = [from, to].map(|end| normal.dot(end - b[0]));
        if before.abs().min(behind.abs()) < TOUCHING || before * behind > 0.0 {
            return false;
        }
        let meets = from.lerp(to, before / (before - behind));
        edges(b).all(|[left, right]| normal.cross(right - left).normalize().dot(meets - left) > TOUCHING)
    })
}

#[test]
fn polygons_go_through_each_other_only_where_the_catalogue_says() {
    for named in figures() {
        let polygons = polygons(&named.build());
        let crossing = (polygons.iter()).any(|a| polygons.iter().any(|b| pierces(a, b)));
        assert_eq!(crossing, named.is(Group::Intersections), "{}", named.name);
    }
}

#[test]
fn every_polygon_is_seen_from_both_sides_and_is_an_item_of_its_own() {
    for named in figures() {
        let figure = named.build();
        let geometry = geometry(&figure);
        assert!(geometry.materials().iter().all(|material| material.double_sided));
        let [items, faces] = [geometry.items().len(), polygons(&figure).len()];
        let expected = match named.name {
            "four-cylinders" => [4, 240],
            "crossing-triangles" | "overlap" => [2, 2],
            "parallel-triangles" | "parallel-rectangles" | "cycle" => [3, 3],
            "tetrahedron" | "wrong-winding" => [4, 4],
            "triangle-through-cube" => [7, 7],
            _ => {
                let (kind, sides) = named
                    .name
                    .split_once('-')
                    .expect("a name that ends in the number of sides");
                let ends = if kind == "cylinders" { 2 } else { 1 };
                [sides.parse::<usize>().expect("a number") + ends; 2]
            }
        };
        assert_eq!([items, faces], expected, "{}", named.name);
    }
}

#[test]
fn corners_run_counter_clockwise_but_where_they_are_in_no_order() {
    for named in figures() {
        let solid = ["tetrahedron", "wrong-winding", "cylinders-8", "cones-32"];
        if !solid.contains(&named.name) {
            continue;
        }
        let polygons = polygons(&named.build());
        // All of these solids contain the origin.
        let outwards = polygons
            .iter()
            .filter(|corners| normal(corners).dot(corners[0]) > 0.0);
        let expected = if named.name == "wrong-winding" {
            2
        } else {
            polygons.len()
        };
        assert_eq!(outwards.count(), expected, "{}", named.name);
    }
}
