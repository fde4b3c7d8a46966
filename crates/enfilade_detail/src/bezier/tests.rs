//! Tessellation of closed surfaces, uneven curvature and degenerate edges; error bounds of their meshes.

use super::*;
use std::collections::HashMap;

const CLAY: MaterialId = MaterialId(0);

/// Returns a patch of revolution around the y axis: one of four quarters, and a profile of radius and height.
fn turned(profile: [[f32; 2]; 4], quarter: usize) -> BezierPatch {
    // The usual cubic approximation of a quarter circle.
    const K: f32 = 0.552_284_8;
    let circle = [[1.0, 0.0], [1.0, K], [K, 1.0], [0.0, 1.0]];
    let mut patch = [[0.0; 3]; 16];
    for (v, [radius, height]) in profile.into_iter().enumerate() {
        for (u, [mut x, mut z]) in circle.into_iter().enumerate() {
            for _ in 0..quarter {
                [x, z] = [-z, x];
            }
            // Counter-clockwise from outside, seen from above.
            patch[4 * v + u] = [radius * x, height, -radius * z];
        }
    }
    patch
}

/// A lamp: a bulb of low curvature on a foot of high curvature; both end in degenerate edges on the axis.
fn lamp() -> Vec<BezierPatch> {
    let profiles = [
        [[0.0, 0.0], [0.2, 0.0], [0.2, 0.02], [0.05, 0.05]],
        [[0.05, 0.05], [0.02, 0.07], [0.3, 0.07], [0.05, 0.1]],
        [[0.05, 0.1], [2.0, 0.8], [2.0, 4.0], [0.0, 4.0]],
    ];
    let all = profiles
        .into_iter()
        .flat_map(|profile| (0..4).map(move |quarter| turned(profile, quarter)));
    all.collect()
}

/// A torus of 4 × 4 patches, thick on one side.
fn ring() -> Vec<BezierPatch> {
    const K: f32 = 0.552_284_8;
    let circle = [[1.0, 0.0], [1.0, K], [K, 1.0], [0.0, 1.0]];
    let mut patches = Vec::new();
    for part in 0..4 {
        let thick = if part == 0 { 3.0 } else { 1.0 };
        let profile = circle.map(|[mut x, mut y]| {
            for _ in 0..part {
                [x, y] = [-y, x];
            }
            [5.0 + x, y * thick]
        });
        // The thick part ends where the next patch begins.
        let profile = match part {
            0 => [profile[0], profile[1], [5.0 + K, 1.0], [5.0, 1.0]],
            _ => profile,
        };
        patches.extend((0..4).map(|quarter| turned(profile, quarter)));
    }
    patches
}

fn corner_bits(mesh: &Mesh) -> Vec<[[u32; 3]; 3]> {
    let bits = |index: u32| mesh.positions()[index as usize].map(f32::to_bits);
    (0..mesh.face_count())
        .map(|face| [0, 1, 2].map(|corner| bits(mesh.face(face)[corner])))
        .collect()
}

/// Counts edges that do not have equally many triangles on both sides.
fn open_edges(mesh: &Mesh) -> usize {
    let mut sides: HashMap<_, i32> = HashMap::new();
    for [a, b, c] in corner_bits(mesh) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *sides.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
        }
    }
    sides.values().filter(|&&count| count != 0).count()
}

#[test]
fn closed_surfaces_have_no_cracks_at_any_level() {
    for (name, patches) in [("lamp", lamp()), ("ring", ring())] {
        let surface = BezierSurface::new(&patches, CLAY).expect("finite");
        let mut faces = Vec::new();
        for level in 0..surface.levels().min(10) {
            let mesh = surface.build(level).expect("it has faces");
            assert_eq!(open_edges(&mesh), 0, "{name}, level {level}");
            faces.push(mesh.face_count());
        }
        assert!(faces.is_sorted(), "{name}: {faces:?}");
        assert!(
            faces[0] < 400 && faces[faces.len() - 1] > 5000,
            "{name}: {faces:?}"
        );
    }
}

#[test]
fn neighbours_that_bend_differently_share_the_finer_edge() {
    // Nine patches, flat except the middle one, which is curved inside; all their edges are straight.
    let mut patches = Vec::new();
    for place in 0..9 {
        let mut patch = [[0.0; 3]; 16];
        for (number, point) in patch.iter_mut().enumerate() {
            let [u, v] = [number % 4, number / 4];
            let inner = (1..3).contains(&u) && (1..3).contains(&v) && place == 4;
            *point = [
                (3 * (place % 3) + u) as f32,
                (3 * (place / 3) + v) as f32,
                if inner { 9.0 } else { 0.0 },
            ];
        }
        patches.push(patch);
    }
    let surface = BezierSurface::new(&patches, CLAY).expect("finite");
    let mesh = surface.build(6).expect("faces");
    let rim = |[a, b]: [[u32; 3]; 2], axis: usize| {
        let at = |point: [u32; 3]| f32::from_bits(point[axis]);
        at(a) == at(b) && [0.0, 9.0].contains(&at(a))
    };
    let mut sides: HashMap<_, i32> = HashMap::new();
    for [a, b, c] in corner_bits(&mesh) {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            if !rim([from, to], 0) && !rim([from, to], 1) {
                *sides.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
            }
        }
    }
    assert!(sides.values().all(|&count| count == 0));
    // The middle patch has many triangles, the corner patches two each.
    assert!(mesh.face_count() > 1000);
    let in_a_corner = |triangle: &[[u32; 3]; 3]| {
        triangle
            .iter()
            .all(|point| f32::from_bits(point[0]) <= 3.0 && f32::from_bits(point[1]) <= 3.0)
    };
    let corners = corner_bits(&mesh);
    assert_eq!(corners.iter().filter(|triangle| in_a_corner(triangle)).count(), 2);
}

fn distance(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let within = [(a, b), (b, c), (c, a)]
        .into_iter()
        .all(|(from, to)| (to - from).cross(point - from).dot(normal) >= 0.0);
    if within && normal != DVec3::ZERO {
        return (point - a).dot(normal.normalize()).abs();
    }
    let to_edge = |from: DVec3, to: DVec3| {
        let along = to - from;
        let t = ((point - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        point.distance(from + t * along)
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

fn on_patch(patch: &BezierPatch, [u, v]: [f64; 2]) -> DVec3 {
    let weights = |t: f64| {
        let s = 1.0 - t;
        [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
    };
    let (wu, wv) = (weights(u), weights(v));
    (0..16)
        .map(|i| DVec3::from(patch[i].map(f64::from)) * wu[i % 4] * wv[i / 4])
        .sum()
}

#[test]
fn no_point_of_a_surface_is_farther_from_its_mesh_than_the_error_says() {
    let mut random = fastrand::Rng::with_seed(5);
    let mut tight = 0.0_f64;
    for round in 0..12 {
        // Two patches that share an edge; the second has more curvature.
        let mut first = [[0.0; 3]; 16];
        for (number, point) in first.iter_mut().enumerate() {
            let around = [(number % 4) as f32, (number / 4) as f32, 0.0];
            *point = around.map(|value| value + random.f32() - 0.5);
        }
        let mut second = first;
        for (number, point) in second.iter_mut().enumerate() {
            let [u, v] = [number % 4, number / 4];
            *point = if u == 0 {
                first[4 * v + 3]
            } else {
                [3.0 + u as f32, v as f32, 0.0].map(|value| value + 4.0 * (random.f32() - 0.5))
            };
        }
        let patches = [first, second];
        let surface = BezierSurface::new(&patches, CLAY).expect("finite");
        for level in [0, 2, 4] {
            let mesh = surface.build(level).expect("faces");
            let triangles: Vec<[DVec3; 3]> = corner_bits(&mesh)
                .into_iter()
                .map(|triangle| triangle.map(|p| DVec3::from(p.map(|bits| f64::from(f32::from_bits(bits))))))
                .collect();
            let mut worst = 0.0_f64;
            for _ in 0..200 {
                let patch = &patches[usize::from(random.f32() < 0.5)];
                let point = on_patch(patch, [random.f64(), random.f64()]);
                let off = triangles
                    .iter()
                    .map(|&triangle| distance(point, triangle))
                    .fold(f64::INFINITY, f64::min);
                worst = worst.max(off);
            }
            let error = f64::from(surface.error(level));
            assert!(worst <= error, "round {round}, level {level}: {worst} > {error}");
            tight = tight.max(worst / error);
        }
    }
    // A bound far above the real error would waste triangles.
    assert!(tight > 0.2, "at most {tight} of what is allowed");
}

#[test]
fn what_is_flat_is_exact_at_its_only_level() {
    let mut patch = [[0.0; 3]; 16];
    for (number, point) in patch.iter_mut().enumerate() {
        *point = [(number % 4) as f32, (number / 4) as f32, -0.0];
    }
    let surface = BezierSurface::new(&[patch], CLAY).expect("finite");
    assert_eq!((surface.levels(), surface.error(0)), (1, 0.0));
    let mesh = surface.build(0).expect("two faces");
    assert_eq!(mesh.face_count(), 2);
    // The front is where the turn from u to v is counter-clockwise: up.
    for [a, b, c] in corner_bits(&mesh)
        .into_iter()
        .map(|t| t.map(|p| p.map(f32::from_bits)))
    {
        let [b, c] = [b, c].map(|to| [to[0] - a[0], to[1] - a[1]]);
        assert!(b[0] * c[1] - b[1] * c[0] > 0.0);
    }
}

#[test]
fn triangles_face_the_front_of_their_patches() {
    for (patches, inside) in [(lamp(), [0.0, 2.0, 0.0]), (ring()[8..12].to_vec(), [0.0; 3])] {
        let bulb = patches.len() - 4;
        let surface = BezierSurface::new(&patches[bulb..], CLAY).expect("finite");
        let mesh = surface.build(4).expect("faces");
        let outward = |[a, b, c]: [[u32; 3]; 3]| {
            let [a, b, c] = [a, b, c].map(|p| DVec3::from(p.map(|bits| f64::from(f32::from_bits(bits)))));
            (b - a).cross(c - a).dot(a - DVec3::from(inside))
        };
        // The front of the bulb faces outwards; that of the torus's inner half faces the axis.
        let sign = if inside[1] > 0.0 { 1.0 } else { -1.0 };
        assert!(corner_bits(&mesh).into_iter().all(|t| sign * outward(t) > 0.0));
    }
}

#[test]
fn what_is_no_surface_is_refused_and_what_is_a_point_has_no_faces() {
    assert_eq!(BezierSurface::new(&[], CLAY).unwrap_err(), BezierError::NoPatches);
    let mut patch = [[1.0; 3]; 16];
    let point = BezierSurface::new(&[patch], CLAY).expect("finite");
    assert_eq!(point.build(0).expect("nothing is wrong").face_count(), 0);
    patch[7][1] = f32::NAN;
    let refused = BezierSurface::new(&[[[0.0; 3]; 16], patch], CLAY).unwrap_err();
    assert_eq!(refused.to_string(), "control point 7 of patch 1 is not finite");
    // Values near the limit of f32 must not panic; the mesh exceeds the maximum coordinate.
    for (number, point) in patch.iter_mut().enumerate() {
        *point = [f32::MAX, -f32::MAX, 0.0].map(|value| value * (0.5 * (number % 3) as f32));
    }
    let huge = BezierSurface::new(&[patch], CLAY).expect("finite");
    assert!(huge.build(0).is_err() && huge.error(0) > 0.0);
}
