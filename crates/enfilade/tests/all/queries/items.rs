//! Items in boxes, spheres and frusta, and the nearest items.

use super::{QUESTIONS, about, affine, geometries, length};
use enfilade::{Aabb, Camera, Geometry, ItemIndex, NearestItem, View, Viewer};
use enfilade_scenes::{Random, built_in};
use glam::DVec3;

fn all(geometry: &Geometry) -> impl Iterator<Item = ItemIndex> {
    (0..geometry.items().len() as u32).map(ItemIndex)
}

/// Returns the ids of the items that a query finds, and checks that there are no duplicates.
fn found(ask: impl FnOnce(&mut dyn FnMut(ItemIndex))) -> Vec<ItemIndex> {
    let mut items = Vec::new();
    ask(&mut |item| items.push(item));
    items.sort_unstable();
    assert!(items.windows(2).all(|pair| pair[0] < pair[1]));
    items
}

/// Returns the distance of a point from a box; infinite for an empty box.
fn distance(bounds: &Aabb, point: [f32; 3]) -> f64 {
    let off = |axis: usize| {
        let [min, max, at] = [bounds.min, bounds.max, point].map(|corner| f64::from(corner[axis]));
        (min - at).max(at - max).max(0.0)
    };
    (0..3).map(|axis| off(axis) * off(axis)).sum::<f64>().sqrt()
}

#[test]
fn the_items_in_a_box_are_those_whose_boxes_meet_it() {
    let mut some = 0;
    for (name, geometry) in geometries() {
        let mut chance = Random::new(1);
        let whole = geometry.bounds();
        for question in 0..QUESTIONS {
            let middle = about(&mut chance, &whole);
            let half: [f32; 3] = [(); 3].map(|()| length(&mut chance, whole.longest_side()));
            let mut bounds = Aabb {
                min: [0, 1, 2].map(|axis| middle[axis] - half[axis]),
                max: [0, 1, 2].map(|axis| middle[axis] + half[axis]),
            };
            if question % 5 == 0 {
                // Touching an item's box from outside.
                let touched = geometry.items()[chance.below(geometry.items().len())].bounds;
                if !touched.is_empty() {
                    bounds.min[0] = touched.max[0];
                    bounds.max[0] = touched.max[0] + half[0];
                }
            }
            let expected: Vec<ItemIndex> = all(&geometry)
                .filter(|&item| geometry.item(item).bounds.meets(&bounds))
                .collect();
            let items = found(|visit| geometry.items_in_box(&bounds, visit));
            assert_eq!(items, expected, "@{name}, {bounds:?}");
            some += usize::from(!items.is_empty());
        }
    }
    assert!(some > 3 * QUESTIONS, "only {some} boxes held anything");
}

#[test]
fn the_items_in_a_sphere_are_those_whose_boxes_are_within_its_radius() {
    let mut some = 0;
    for (name, geometry) in geometries() {
        let mut chance = Random::new(2);
        let whole = geometry.bounds();
        for _ in 0..QUESTIONS {
            let center = about(&mut chance, &whole);
            let radius = length(&mut chance, whole.longest_side());
            let square = f64::from(radius) * f64::from(radius);
            let within = |&item: &ItemIndex| {
                let off = distance(&geometry.item(item).bounds, center);
                off < f64::INFINITY && off * off <= square
            };
            // If the rounding of the square root decides, either result is correct.
            let close = |&item: &ItemIndex| {
                (distance(&geometry.item(item).bounds, center) - f64::from(radius)).abs()
                    <= 1e-12 * f64::from(radius)
            };
            let expected: Vec<ItemIndex> = all(&geometry).filter(within).collect();
            let items = found(|visit| geometry.items_in_sphere(center, radius, visit));
            let differs = |item: &&ItemIndex| items.contains(item) != expected.contains(item);
            let wrong: Vec<_> = all(&geometry).collect();
            let wrong = if items == expected {
                Vec::new()
            } else {
                wrong.iter().filter(differs).filter(|item| !close(item)).collect()
            };
            assert!(wrong.is_empty(), "@{name}, {center:?}, {radius}: {wrong:?}");
            some += usize::from(!items.is_empty());
        }
    }
    assert!(some > 3 * QUESTIONS, "only {some} spheres held anything");
}

#[test]
fn the_nearest_items_are_the_first_of_all_by_distance() {
    for (name, geometry) in geometries() {
        let mut chance = Random::new(3);
        let whole = geometry.bounds();
        let mut nearest = Vec::new();
        for _ in 0..QUESTIONS {
            let point = about(&mut chance, &whole);
            let count = [1, 3, 10, usize::MAX][chance.below(4)];
            let radius = [length(&mut chance, whole.longest_side()), f32::INFINITY][chance.below(2)];
            let mut expected: Vec<(f64, ItemIndex)> = all(&geometry)
                .map(|item| (distance(&geometry.item(item).bounds, point), item))
                .filter(|&(distance, _)| distance < f64::INFINITY && distance <= f64::from(radius))
                .collect();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            expected.truncate(count);
            geometry.nearest_items(point, count, radius, &mut nearest);
            let found: Vec<_> = nearest
                .iter()
                .map(|near| (near.distance, near.item.index))
                .collect();
            assert_eq!(found, expected, "@{name}, {count} within {radius} of {point:?}");
        }
    }
}

/// Returns `true` if a box is inside all planes of a frustum, computed from the view alone. `None` if it is too close
/// to call.
fn in_frustum(view: &View, corners: &[DVec3; 8]) -> Option<bool> {
    let [eye, toward, up] = [view.eye(), view.toward(), view.up()].map(DVec3::from);
    let ahead = (toward - eye).normalize();
    let right = ahead.cross(up).normalize();
    let up = right.cross(ahead);
    let tangent = (0.5 * f64::from(view.fov_y())).tan();
    let across = tangent * f64::from(view.size()[0]) / f64::from(view.size()[1]);
    let pixel = 2.0 * tangent / f64::from(view.size()[1]);
    let [dx, dy] = View::GENERIC_OFFSET.map(|offset| offset * pixel);
    let heights = |point: DVec3| {
        let off = point - eye;
        let [x, y, w] = [right, up, ahead].map(|axis| axis.dot(off));
        let [x, y] = [x - w * dx, y + w * dy];
        [
            w * across - x,
            w * across + x,
            w * tangent - y,
            w * tangent + y,
            w - f64::from(view.z_near()),
        ]
    };
    let highest = corners
        .iter()
        .map(|&corner| heights(corner))
        .fold([f64::NEG_INFINITY; 5], |most, next| {
            std::array::from_fn(|plane| most[plane].max(next[plane]))
        });
    let far = corners
        .iter()
        .map(|corner| corner.distance(eye) + eye.length())
        .fold(0.0, f64::max);
    let least = highest.into_iter().fold(f64::INFINITY, f64::min);
    // The view's tangent is rounded to f32.
    (least.abs() > 1e-6 * far).then_some(least > 0.0)
}

#[test]
fn the_items_in_a_frustum_are_those_not_wholly_behind_one_of_its_planes() {
    let [mut some, mut close] = [0; 2];
    for (name, geometry) in geometries() {
        let mut chance = Random::new(4);
        let whole = geometry.bounds();
        // The item's box, and the box of its transformed mesh.
        let boxes: Vec<Option<[[DVec3; 8]; 2]>> = all(&geometry)
            .map(|item| {
                let [own, held] = [geometry.item(item).bounds, geometry.mesh_of(item).bounds()];
                let placed = affine(&geometry.item(item).transform());
                let point = |corner: [f32; 3]| DVec3::from(corner.map(f64::from));
                let corner = |corner| placed.transform_point3(point(corner));
                (!held.is_empty()).then(|| [own.corners().map(point), held.corners().map(corner)])
            })
            .collect();
        for _ in 0..QUESTIONS {
            let camera = Camera {
                fov_y: 0.1 + 2.5 * chance.unit(),
                ..Camera::new(about(&mut chance, &whole), about(&mut chance, &whole))
            };
            let view = camera
                .view([64 + chance.below(64) as u32, 64])
                .expect("a valid view");
            let items = found(|visit| geometry.items_in_frustum(&view, visit));
            for (item, corners) in all(&geometry).zip(&boxes) {
                let Some(corners) = corners else {
                    assert!(!items.contains(&item));
                    continue;
                };
                let [own, held] = corners.map(|corners| in_frustum(&view, &corners));
                match own.zip(held).map(|(own, held)| own && held) {
                    Some(expected) => {
                        assert_eq!(
                            items.binary_search(&item).is_ok(),
                            expected,
                            "@{name}, {item:?}, {view:?}"
                        );
                        some += usize::from(expected);
                    }
                    None => close += 1,
                }
            }
        }
    }
    assert!(
        some > 10 * QUESTIONS && close < some / 20,
        "{some} in, {close} too close to call"
    );
}

#[test]
fn a_visible_set_counts_what_is_in_its_frustum_by_the_same_rule() {
    for name in ["random", "crowd", "big-mesh"] {
        let built = built_in(name).expect("it is built in");
        let scene = built.scene.without_portals();
        for camera in &built.cameras {
            let view = camera.view([96, 54]).expect("a valid view");
            let mut viewer = Viewer::new();
            let set = viewer.look(&scene, &view);
            let [passage] = set.passages() else {
                panic!("openings are holes");
            };
            let geometry = scene.geometry(passage.sector).expect("ours");
            let items = found(|visit| geometry.items_in_frustum(&view, visit));
            assert_eq!(set.in_frustum(&scene).0, items.len(), "@{name}");
            assert!(set.items().iter().all(|seen| items.contains(&seen.item.index)));
        }
    }
}

#[test]
fn questions_that_make_no_sense_find_nothing() {
    let geometry = geometries().next().expect("a palace").1;
    const NAN: f32 = f32::NAN;
    let whole = geometry.bounds();
    let nothing = |items: Vec<ItemIndex>| assert_eq!(items, []);
    let inside_out = Aabb {
        min: whole.max,
        max: whole.min,
    };
    let mut not_a_box = whole;
    not_a_box.min[1] = NAN;
    for bounds in [Aabb::EMPTY, inside_out, not_a_box] {
        nothing(found(|visit| geometry.items_in_box(&bounds, visit)));
    }
    let mut nearest: Vec<NearestItem> = Vec::new();
    geometry.nearest_items([0.0; 3], 3, f32::INFINITY, &mut nearest);
    assert_eq!(nearest.len(), 3);
    for (center, radius) in [
        ([NAN; 3], 1.0),
        ([0.0; 3], NAN),
        ([0.0; 3], -1.0),
        ([f32::INFINITY; 3], 1.0),
    ] {
        nothing(found(|visit| geometry.items_in_sphere(center, radius, visit)));
        geometry.nearest_items(center, 3, radius, &mut nearest);
        assert_eq!(nearest, []);
    }
    geometry.nearest_items([0.0; 3], 0, 9.0, &mut nearest);
    assert_eq!(nearest, []);
}
