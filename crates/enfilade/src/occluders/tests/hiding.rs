//! Tests that everything hidden by occluders is hidden by faces, and that walls become few occluders.

use super::*;

/// Relative error of the plane of a sliver whose corners are rounded to f64: far less than the depth difference that
/// the reference counts as equal.
const SLIVER: f64 = 1e-7;

/// Returns the hit distance of a ray from the origin with a face, as a fraction of the ray. Tolerates f64 rounding.
fn met(ray: DVec3, [a, b, c]: [DVec3; 3], double_sided: bool) -> Option<f64> {
    let far = ray.length() * a.length().max(b.length()).max(c.length());
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| {
        // From the smaller end, so that no ray slips between two faces.
        let side = if from.to_array() < to.to_array() {
            from.cross(to)
        } else {
            -to.cross(from)
        };
        ray.dot(side) / (far * (to - from).length())
    });
    // All positive if the ray hits a back face.
    let front = sides.iter().all(|&side| side <= 1e-14);
    let back = double_sided && sides.iter().all(|&side| side >= -1e-14);
    let normal = (b - a).cross(c - a);
    let part = normal.dot(a) / normal.dot(ray);
    ((front || back) && part > 0.0).then_some(part)
}

/// Compares what an occluder hides from some eyes with the faces.
fn check(what: &str, wall: &Wall, double_sided: bool, dice: &mut Dice) -> usize {
    let geometry = wall.geometry(double_sided, &[Transform::IDENTITY]);
    let set = OccluderSet::build(&geometry);
    let mut held = 0;
    let [min, max] =
        [geometry.bounds().min, geometry.bounds().max].map(|corner| DVec3::from(corner.map(f64::from)));
    let (middle, size) = (0.5 * (min + max), min.distance(max));
    for place in 0..set.polygons.len() as u32 {
        let normal = set.polygons[place as usize].normal;
        for _ in 0..6 {
            // From a distance, from nearby and at a grazing angle.
            let aside = dice.point(1.0).reject_from(normal) * size;
            let height = size * 10_f64.powf(dice.between(-5.0, 1.0)) * (dice.roll() - 0.3).signum();
            let eye = (middle + aside + normal * height).as_vec3().as_dvec3();
            let passage = passage(eye.to_array(), middle.to_array());
            let chosen = SelectedOccluder::for_tests(place);
            let mut room = OccluderRoom::default();
            let Some(occluder) = set.on_screen(&geometry, &passage, &chosen, &mut room) else {
                continue;
            };
            held += 1;
            is_sound(&occluder, what);
            let screen = passage.screen_from_sector;
            let faces: Vec<[DVec3; 3]> = wall
                .triangles
                .iter()
                .map(|triangle| triangle.map(|index| screen.point(DVec3::from(wall.corners[index as usize]))))
                .collect();
            for _ in 0..40 {
                // A point behind it, in most cases close to an edge.
                let weights: Vec<f64> = occluder.corners.iter().map(|_| dice.roll().powi(8)).collect();
                let whole: f64 = weights.iter().sum();
                let ray: DVec3 = occluder
                    .corners
                    .iter()
                    .zip(&weights)
                    .map(|(&corner, &weight)| corner * (weight / whole))
                    .sum();
                let (normal, distance) = occluder.plane;
                let behind = ray * (distance / normal.dot(ray)) * (1.0 + 1e-12);
                let hides = |&face: &[DVec3; 3]| {
                    met(behind, face, double_sided).is_some_and(|part| part <= 1.0 + SLIVER)
                };
                assert!(
                    faces.iter().any(hides),
                    "{what}: from {eye} occluder {place} of {} hides {behind}, but no face does",
                    set.polygons.len()
                );
            }
        }
    }
    held
}

#[test]
fn what_an_occluder_hides_is_hidden_by_faces() {
    let mut dice = Dice::new(1);
    let mut held = 0;
    for round in 0..60 {
        for (what, wall) in walls(&mut dice) {
            // Unchanged, rotated about an axis so that planes stay exact, and transformed arbitrarily.
            let to = match round % 3 {
                0 => Transform::IDENTITY,
                1 => {
                    Transform::translation([3.3, 0.7, 0.1])
                        * Transform::rotation([0.0, 0.0, 1.0], dice.roll())
                }
                _ => anywhere(&mut dice),
            };
            held += check(what, &wall.moved(&to), round % 2 == 0, &mut dice);
        }
    }
    assert!(held > 2000, "only {held} views had an occluder");
}

#[test]
fn occluders_kept_with_any_wall_are_those_found_in_it() {
    let mut dice = Dice::new(34);
    let [mut vertices, mut between] = [0; 2];
    for round in 0..30 {
        for (what, wall) in walls(&mut dice) {
            let wall = if round % 3 == 0 {
                wall
            } else {
                wall.moved(&anywhere(&mut dice))
            };
            let plain = wall.geometry(round % 2 == 0, &[Transform::IDENTITY]);
            let kept = plain.meshes()[0].with_occluders(plain.materials());
            let mut builder = GeometryBuilder::new(plain.materials());
            let mesh = builder.mesh(kept);
            builder.item("wall", mesh, Transform::IDENTITY);
            let kept = builder.build().expect("as before");
            let [found, read] = [&plain, &kept].map(OccluderSet::build);
            assert_eq!(format!("{read:?}"), format!("{found:?}"), "{what}, round {round}");
            assert!(
                stored::read(&kept.meshes()[0], kept.materials()).is_some(),
                "{what}"
            );
            for corner in &found.corners {
                let is_vertex = plain.meshes()[0].positions().contains(&corner.as_vec3().into());
                *(if is_vertex { &mut vertices } else { &mut between }) += 1;
            }
        }
    }
    assert!(vertices > 1000 && between > 100, "{vertices}, {between}");
}

#[test]
fn a_plain_wall_becomes_one_rectangle() {
    let mut dice = Dice::new(2);
    for round in 0..40 {
        let (columns, rows) = (1 + dice.below(20), 1 + dice.below(12));
        let to = if round % 2 == 0 {
            Transform::IDENTITY
        } else {
            anywhere(&mut dice)
        };
        let wall = Wall::of_squares(columns, rows, |_, _| true).moved(&to);
        let set = OccluderSet::build(&wall.geometry(false, &[Transform::IDENTITY]));
        let area: f64 = set.polygons.iter().map(|polygon| polygon.area).sum();
        assert_eq!(set.polygons.len(), 1, "{columns} by {rows} at {to:?}");
        assert!(
            (area / wall.area() - 1.0).abs() < 0.01,
            "{columns} by {rows} at {to:?}"
        );
        if round % 2 == 0 {
            assert_eq!(set.polygons[0].corners, 4);
        }
    }
}

#[test]
fn a_wall_with_a_window_is_covered_around_it() {
    let mut dice = Dice::new(3);
    for round in 0..40 {
        let to = if round % 2 == 0 {
            Transform::IDENTITY
        } else {
            anywhere(&mut dice)
        };
        let window = |x: usize, y: usize| (3..5).contains(&x) && (2..4).contains(&y);
        let wall = Wall::of_squares(9, 6, |x, y| !window(x, y)).moved(&to);
        let set = OccluderSet::build(&wall.geometry(false, &[Transform::IDENTITY]));
        let added: f64 = set.polygons.iter().map(|polygon| polygon.added).sum();
        assert!(added > 0.95 * wall.area(), "{added} of {}", wall.area());
        assert!(set.polygons.len() <= 4, "{} pieces", set.polygons.len());
        let largest = set
            .polygons
            .iter()
            .map(|polygon| polygon.area)
            .fold(0.0, f64::max);
        assert!(largest > 0.35 * wall.area());
    }
}

#[test]
fn many_bad_faces_take_bounded_time() {
    // 180,000 triangles in one plane with every tenth square missing; a checkerboard; and many faces at one position.
    let mut dice = Dice::new(4);
    let holes: Vec<bool> = (0..90_000).map(|_| dice.roll() < 0.1).collect();
    let holed = Wall::of_squares(300, 300, |x, y| !holes[y * 300 + x]);
    let checkered = Wall::of_squares(300, 300, |x, y| (x + y) % 2 == 0);
    let mut heap = Wall::of_squares(2, 2, |_, _| true);
    for _ in 0..14 {
        heap.triangles.extend_from_within(..);
    }
    for wall in [holed, checkered, heap] {
        let geometry = wall.geometry(true, &[Transform::IDENTITY]);
        let set = OccluderSet::build(&geometry);
        let summary = set.summary(&geometry);
        assert!(summary.area <= 1.001 * summary.opaque_area, "{summary:?}");
    }
    let geometry = Wall::default().geometry(false, &[Transform::IDENTITY]);
    assert_eq!(OccluderSet::build(&geometry).summary(&geometry).polygons, 0);
}

#[test]
fn faces_that_turn_their_backs_or_differ_in_sides_are_not_merged() {
    let mut wall = Wall::of_squares(2, 1, |_, _| true);
    for triangle in &mut wall.triangles[2..] {
        triangle.swap(0, 1);
    }
    assert_eq!(
        OccluderSet::build(&wall.geometry(false, &[Transform::IDENTITY]))
            .polygons
            .len(),
        2
    );
    assert_eq!(
        OccluderSet::build(&wall.geometry(true, &[Transform::IDENTITY]))
            .polygons
            .len(),
        1
    );
}
