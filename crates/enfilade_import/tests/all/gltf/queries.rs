//! Compares queries on real scenes with brute force.

use enfilade::{Aabb, Geometry, Hit, ItemIndex, Method, Ray, survey};
use enfilade_import::{ReadOptions, read};
use enfilade_scenes::Random;
use glam::{DAffine3, DMat3, DVec3};
use std::path::Path;
use std::sync::Arc;

const QUESTIONS: usize = 10_000;

/// Of these every triangle is gone through for each.
const RAYS: usize = 300;

fn all(geometry: &Geometry) -> impl Iterator<Item = ItemIndex> {
    (0..geometry.items().len() as u32).map(ItemIndex)
}

fn distance(bounds: &Aabb, point: [f32; 3]) -> f64 {
    let off = |axis: usize| {
        let [min, max, at] = [bounds.min, bounds.max, point].map(|corner| f64::from(corner[axis]));
        (min - at).max(at - max).max(0.0)
    };
    (0..3).map(|axis| off(axis) * off(axis)).sum::<f64>().sqrt()
}

fn boxes_and_nearest(file: &str, geometry: &Geometry) {
    let (whole, mut chance) = (geometry.bounds(), Random::new(1));
    let mut nearest = Vec::new();
    for _ in 0..QUESTIONS {
        let middle = chance.point_in(&whole);
        let half = 0.2 * chance.unit() * whole.longest_side();
        let bounds = Aabb {
            min: middle.map(|side| side - half),
            max: middle.map(|side| side + half),
        };
        let mut found = Vec::new();
        geometry.items_in_box(&bounds, |item| found.push(item));
        found.sort_unstable();
        let expected = all(geometry).filter(|&item| geometry.item(item).bounds.meets(&bounds));
        assert!(expected.eq(found), "{file}, {bounds:?}");

        geometry.nearest_items(middle, 8, f32::INFINITY, &mut nearest);
        let mut expected: Vec<(f64, ItemIndex)> = all(geometry)
            .filter(|&item| !geometry.item(item).bounds.is_empty())
            .map(|item| (distance(&geometry.item(item).bounds, middle), item))
            .collect();
        expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        expected.truncate(8);
        let found = nearest.iter().map(|near| (near.distance, near.item.index));
        assert!(found.eq(expected), "{file}, {middle:?}");
    }
}

/// Every triangle where it stands, with its item.
fn triangles(geometry: &Geometry) -> Vec<(ItemIndex, [DVec3; 3])> {
    let mut triangles = Vec::new();
    for item in all(geometry) {
        let columns = geometry.item(item).sector_from_item;
        let [x, y, z, at] = columns.map(|column| DVec3::from(column.map(f64::from)));
        let placed = DAffine3 {
            matrix3: DMat3::from_cols(x, y, z),
            translation: at,
        };
        if placed.matrix3.determinant() == 0.0 {
            continue;
        }
        let mesh = geometry.mesh_of(item);
        for face in 0..mesh.face_count() {
            let corners = mesh.face(face);
            let corner = |i: usize| {
                let position = mesh.positions()[corners[i] as usize].map(f64::from);
                placed.transform_point3(DVec3::from(position))
            };
            triangles
                .extend((2..corners.len()).map(|last| (item, [corner(0), corner(last - 1), corner(last)])));
        }
    }
    triangles
}

/// Returns the nearest definite hit of a ray, well within a triangle's edges, and the nearest possible one.
fn first(triangles: &[(ItemIndex, [DVec3; 3])], ray: &Ray) -> [f64; 2] {
    let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
    let mut nearest = [f64::INFINITY; 2];
    for (_, corners) in triangles {
        let [a, b, c] = corners.map(|corner| corner - origin);
        let parts = [(b, c), (c, a), (a, b)].map(|(p, q)| direction.dot(p.cross(q)));
        let whole: f64 = parts.iter().sum();
        if whole.abs() <= 1e-9 * parts.iter().map(|part| part.abs()).sum::<f64>() {
            continue;
        }
        let parts = parts.map(|part| part / whole);
        let least = parts.into_iter().fold(f64::INFINITY, f64::min);
        let at = a * parts[0] + b * parts[1] + c * parts[2];
        let distance = at.dot(direction) / direction.length_squared();
        for (nearest, edge) in nearest.iter_mut().zip([1e-6, -1e-6]) {
            if least > edge && distance > 0.0 {
                *nearest = nearest.min(distance);
            }
        }
    }
    nearest
}

fn rays(file: &str, geometry: &Geometry, eyes: &[[f32; 3]]) {
    let triangles = triangles(geometry);
    let far = f64::from(geometry.bounds().longest_side());
    let mut chance = Random::new(2);
    let (mut met, mut hits) = (0, Vec::<Hit>::new());
    for question in 0..QUESTIONS {
        let ray = Ray {
            origin: eyes[question % eyes.len()],
            direction: [(); 3].map(|()| 2.0 * chance.unit() - 1.0),
        };
        let hit = geometry.cast(&ray);
        geometry.cast_all(&ray, f64::INFINITY, &mut hits);
        assert_eq!(hits.first().copied(), hit, "{file}, {ray:?}");
        if question % (QUESTIONS / RAYS) != 0 {
            continue;
        }
        let [sure, possible] = first(&triangles, &ray);
        let length = DVec3::from(ray.direction.map(f64::from)).length();
        let slack = 1e-6 * far / length;
        let distance = hit.map_or(f64::INFINITY, |hit| hit.distance);
        assert!(
            distance <= sure + slack && distance >= possible - slack,
            "{file}, {ray:?}: {distance}, not {possible} to {sure}"
        );
        met += usize::from(hit.is_some());
    }
    assert!(met > RAYS / 3, "{file}: only {met} rays meet anything");
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn questions_to_real_scenes_find_what_going_through_everything_finds() {
    let folder = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    for file in ["classroom.glb", "ifc_duplex.glb"] {
        let options = ReadOptions {
            flat: true,
            ..ReadOptions::default()
        };
        let import = read(&Path::new(&folder).join(file), &options).unwrap_or_else(|error| panic!("{error}"));
        let scene = import
            .scene(Method::ZBuffer, Method::DEFAULT_LIMIT)
            .expect("one sector");
        let sector = scene.sectors().next().expect("one sector");
        let geometry = Arc::clone(scene.geometry(sector).expect("ours"));
        boxes_and_nearest(file, &geometry);
        let eyes: Vec<[f32; 3]> = survey(&scene, 50).views.iter().map(|at| at.eye).collect();
        rays(file, &geometry, &eyes);
    }
}
