//! Rays: the first hit and all hits.

use super::{QUESTIONS, about, affine, geometries, triangles};
use enfilade::{Geometry, Hit, ItemIndex, Ray};
use enfilade_scenes::Random;
use glam::{DAffine3, DVec3};

/// A triangle in item space, and its item and face.
struct Face {
    item: ItemIndex,
    face: u32,
    corners: [DVec3; 3],
}

/// All triangles, and for each item the transform into item space.
struct All {
    faces: Vec<Face>,
    item_from_sector: Vec<Option<DAffine3>>,
}

impl All {
    fn of(geometry: &Geometry) -> All {
        let items = || (0..geometry.items().len() as u32).map(ItemIndex);
        let back = |item: ItemIndex| {
            let placed = affine(&geometry.item(item).transform());
            (placed.matrix3.determinant() != 0.0).then(|| placed.inverse())
        };
        let of_item = |item: ItemIndex| {
            triangles(geometry.mesh_of(item)).map(move |(face, corners)| Face { item, face, corners })
        };
        All {
            faces: items()
                .filter(|&item| back(item).is_some())
                .flat_map(of_item)
                .collect(),
            item_from_sector: items().map(back).collect(),
        }
    }

    /// Returns all hits of a ray: distance, closeness to an edge, and face.
    fn hits(&self, ray: &Ray) -> Vec<(f64, f64, ItemIndex, u32)> {
        let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
        let mut local = (ItemIndex(u32::MAX), origin, direction);
        let mut hits = Vec::new();
        for Face {
            item,
            face,
            corners: [a, b, c],
        } in &self.faces
        {
            if local.0 != *item {
                let back = self.item_from_sector[item.0 as usize].expect("it is met");
                local = (
                    *item,
                    back.transform_point3(origin),
                    back.transform_vector3(direction),
                );
            }
            let (_, origin, direction) = local;
            // By signed volumes, unlike the library.
            let [a, b, c] = [a, b, c].map(|&corner| corner - origin);
            let parts = [(b, c), (c, a), (a, b)].map(|(p, q)| direction.dot(p.cross(q)));
            let whole: f64 = parts.iter().sum();
            let size = parts.iter().map(|part| part.abs()).sum::<f64>();
            if whole.abs() <= 1e-9 * size || size == 0.0 {
                continue;
            }
            let parts = parts.map(|part| part / whole);
            let least = parts.into_iter().fold(f64::INFINITY, f64::min);
            let at = a * parts[0] + b * parts[1] + c * parts[2];
            let distance = at.dot(direction) / direction.length_squared();
            if least > -1e-6 && distance > -1e-9 {
                hits.push((distance, least, *item, *face));
            }
        }
        hits.sort_by(|a, b| a.0.total_cmp(&b.0));
        hits
    }
}

fn ray(chance: &mut Random, geometry: &Geometry) -> Ray {
    let whole = geometry.bounds();
    let mut direction = chance.point(1.0);
    match chance.below(6) {
        0 => direction[chance.below(3)] = 0.0,
        1 => {
            let axis = chance.below(3);
            direction = [0.0; 3];
            direction[axis] = 1.0;
        }
        _ => {}
    }
    Ray {
        origin: about(chance, &whole),
        direction,
    }
}

#[test]
fn a_ray_meets_first_what_is_nearest_of_all_faces() {
    let [mut met, mut missed] = [0; 2];
    for (name, geometry) in geometries() {
        let all = All::of(&geometry);
        let far = f64::from(geometry.bounds().longest_side())
            + geometry
                .bounds()
                .max
                .map(|v| f64::from(v.abs()))
                .iter()
                .sum::<f64>();
        let mut chance = Random::new(5);
        // Each ray tests everything: the larger the scene, the fewer rays.
        let questions = QUESTIONS.min(40_000_000 / all.faces.len());
        for _ in 0..questions {
            let ray = ray(&mut chance, &geometry);
            let length = DVec3::from(ray.direction.map(f64::from)).length();
            let slack = 1e-7 * far / length;
            let hits = all.hits(&ray);
            let sure = hits.iter().find(|hit| hit.1 > 1e-6 && hit.0 > slack);
            match geometry.cast(&ray) {
                Some(hit) => {
                    let known = hits
                        .iter()
                        .find(|known| (known.2, known.3) == (hit.item.index, hit.face));
                    let known = known.unwrap_or_else(|| panic!("@{name}: {ray:?} does not meet {hit:?}"));
                    assert!(
                        (known.0 - hit.distance).abs() <= slack,
                        "@{name}: {ray:?}, {hit:?}, {known:?}"
                    );
                    assert!(
                        sure.is_none_or(|sure| hit.distance <= sure.0 + slack),
                        "@{name}: {ray:?}, {hit:?}, {sure:?}"
                    );
                    met += 1;
                }
                None => {
                    assert_eq!(sure, None, "@{name}: {ray:?}");
                    missed += 1;
                }
            }
        }
    }
    assert!(
        met > QUESTIONS && missed > QUESTIONS / 10,
        "{met} met something, {missed} nothing"
    );
}

#[test]
fn all_hits_of_a_ray_begin_with_the_first_and_are_in_order() {
    let mut many = 0;
    for (name, geometry) in geometries() {
        let mut chance = Random::new(6);
        let mut hits: Vec<Hit> = Vec::new();
        let mut shorter: Vec<Hit> = Vec::new();
        for _ in 0..QUESTIONS {
            let ray = ray(&mut chance, &geometry);
            geometry.cast_all(&ray, f64::INFINITY, &mut hits);
            assert_eq!(hits.first().copied(), geometry.cast(&ray), "@{name}: {ray:?}");
            let place = |hit: &Hit| (hit.distance, hit.item, hit.face);
            assert!(
                hits.windows(2).all(|pair| place(&pair[0]) < place(&pair[1])),
                "@{name}: {ray:?}"
            );
            if let Some(middle) = hits.get(hits.len() / 2) {
                geometry.cast_all(&ray, middle.distance, &mut shorter);
                let within = hits.iter().take_while(|hit| hit.distance <= middle.distance);
                assert!(shorter.iter().eq(within), "@{name}: {ray:?}");
            }
            many += usize::from(hits.len() > 4);
        }
    }
    assert!(many > QUESTIONS / 10, "only {many} rays met more than four faces");
}

#[test]
fn all_hits_are_all_that_any_face_meets() {
    let mut sum = 0;
    for (name, geometry) in geometries() {
        let all = All::of(&geometry);
        let far = f64::from(geometry.bounds().longest_side())
            + geometry
                .bounds()
                .max
                .map(|v| f64::from(v.abs()))
                .iter()
                .sum::<f64>();
        let mut chance = Random::new(7);
        let mut found = Vec::new();
        for _ in 0..QUESTIONS.min(10_000_000 / all.faces.len()) {
            let ray = ray(&mut chance, &geometry);
            let slack = 1e-7 * far / DVec3::from(ray.direction.map(f64::from)).length();
            geometry.cast_all(&ray, f64::INFINITY, &mut found);
            let hits = all.hits(&ray);
            for hit in hits.iter().filter(|hit| hit.1 > 1e-6 && hit.0 > slack) {
                assert!(
                    found
                        .iter()
                        .any(|known| (known.item, known.face) == (hit.2.into(), hit.3)),
                    "@{name}: {ray:?} misses {hit:?}"
                );
            }
            for known in &found {
                assert!(
                    hits.iter()
                        .any(|hit| (known.item, known.face) == (hit.2.into(), hit.3)),
                    "@{name}: {ray:?} meets {known:?}"
                );
            }
            sum += found.len();
        }
    }
    assert!(sum > QUESTIONS, "only {sum} hits");
}

#[test]
fn rays_that_go_nowhere_meet_nothing() {
    let geometry = geometries().next().expect("a palace").1;
    let at = geometry.bounds().center();
    let mut hits = Vec::new();
    for (origin, direction) in [
        (at, [0.0; 3]),
        (at, [f32::NAN, 1.0, 0.0]),
        (at, [f32::INFINITY, 0.0, 0.0]),
        ([f32::NAN; 3], [1.0, 0.0, 0.0]),
    ] {
        let ray = Ray { origin, direction };
        assert_eq!(geometry.cast(&ray), None);
        geometry.cast_all(&ray, f64::INFINITY, &mut hits);
        assert_eq!(hits, []);
    }
    let down = Ray {
        origin: at,
        direction: [0.0, -1.0, 0.0],
    };
    for (limit, some) in [(f64::NAN, false), (-1.0, false), (f64::INFINITY, true)] {
        geometry.cast_all(&down, limit, &mut hits);
        assert_eq!(!hits.is_empty(), some);
    }
}
