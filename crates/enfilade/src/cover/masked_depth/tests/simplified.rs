//! Compares simplified occluder meshes with the meshes they were made from, by rays.

use super::*;

/// A mesh as plain arrays.
#[derive(Clone, Default)]
struct Soup {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl Soup {
    /// Adds a wall of unit squares in the plane of two axes, as seen from the side that their cross product points to;
    /// a letter o leaves a square out.
    fn wall(&mut self, at: [f32; 3], [across, up]: [usize; 2], rows: &[&str]) {
        let first = self.positions.len() as u32;
        let columns = rows[0].len();
        for row in 0..=rows.len() {
            for column in 0..=columns {
                let mut corner = at;
                corner[across] += column as f32;
                corner[up] += row as f32;
                self.positions.push(corner);
            }
        }
        for (row, letters) in rows.iter().enumerate() {
            for (column, letter) in letters.chars().enumerate() {
                let corner = |x: usize, y: usize| first + ((row + y) * (columns + 1) + column + x) as u32;
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if letter != 'o' {
                    self.indices.extend([a, b, c, a, c, d]);
                }
            }
        }
    }

    fn moved(mut self, by: &Transform) -> Soup {
        self.positions.iter_mut().for_each(|at| *at = by.point(*at));
        self
    }

    fn mesh(&self) -> OccluderMesh {
        OccluderMesh::triangles(&self.positions, &self.indices).expect("a sound mesh")
    }

    fn triangles(&self) -> Vec<[DVec3; 3]> {
        let at = |corner: u32| DVec3::from(self.positions[corner as usize].map(f64::from));
        self.indices
            .as_chunks::<3>()
            .0
            .iter()
            .map(|face| face.map(at))
            .collect()
    }
}

/// A room with a door, a window and a table, seen from outside and inside; some random triangles; a ball.
fn house() -> Soup {
    let mut soup = Soup::default();
    let window = ["######", "##oo##", "##oo##", "######"];
    let door = ["##o###", "##o###", "##o###", "######"];
    let whole = ["######", "######", "######", "######"];
    soup.wall([0.0, 0.0, 0.0], [1, 0], &["####"; 6]);
    soup.wall([0.0, 0.0, 0.0], [0, 1], &window);
    soup.wall([0.0, 0.0, 6.0], [0, 1], &door);
    soup.wall([0.0, 0.0, 0.0], [2, 1], &whole);
    soup.wall([6.0, 0.0, 0.0], [1, 2], &["####"; 6]);
    soup.wall([1.0, 1.0, 1.0], [2, 0], &["##", "##"]);
    soup
}

fn ball(center: DVec3) -> Soup {
    let mut soup = Soup::default();
    for ring in 0..=6 {
        for step in 0..=10 {
            let [polar, turn] =
                [f64::from(ring) / 6.0, f64::from(step) / 5.0].map(|part| part * std::f64::consts::PI);
            let on = DVec3::new(polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin());
            soup.positions.push((center + on).as_vec3().into());
        }
    }
    for ring in 0..6 {
        for step in 0..10 {
            let a = ring * 11 + step;
            soup.indices.extend([a, a + 1, a + 12, a, a + 12, a + 11]);
        }
    }
    soup
}

fn random_soup(dice: &mut Dice) -> Soup {
    let positions: Vec<[f32; 3]> = (0..60).map(|_| dice.point(3.0).as_vec3().into()).collect();
    let indices = (0..180).map(|_| dice.below(60) as u32).collect();
    Soup { positions, indices }
}

/// Returns the triangles of a mesh, read back from its parts.
fn triangles_of(mesh: &OccluderMesh) -> Vec<[DVec3; 3]> {
    let mut all = Vec::new();
    mesh.for_each_triangle(|corners| all.push(corners.map(|corner| DVec3::from(corner.map(f64::from)))));
    all
}

/// Whether the eye sees the front of a triangle.
fn is_front([a, b, c]: &[DVec3; 3], eye: DVec3) -> bool {
    (b - a).cross(c - a).dot(eye - a) > 0.0
}

/// Whether a triangle hides a point: it is crossed by the segment from the eye, or has the point on it.
fn hides([a, b, c]: &[DVec3; 3], eye: DVec3, point: DVec3) -> bool {
    const TOLERANCE: f64 = 1e-9;
    let (way, [u, v]) = (point - eye, [b - a, c - a]);
    let across = way.cross(v);
    let determinant = u.dot(across);
    let from = eye - a;
    let x = from.dot(across) / determinant;
    let y = way.dot(from.cross(u)) / determinant;
    let t = v.dot(from.cross(u)) / determinant;
    x >= -TOLERANCE && y >= -TOLERANCE && x + y <= 1.0 + TOLERANCE && (0.0..=1.0 + TOLERANCE).contains(&t)
}

#[test]
fn a_simplified_mesh_hides_only_what_its_mesh_hides_from_any_eye() {
    let turn = Transform::rotation([1.0, 2.0, 3.0], 0.7);
    let mut asked = 0;
    for seed in 0..60 {
        let mut dice = Dice::new(seed + 500);
        let soup = match seed % 4 {
            0 => house(),
            1 => house().moved(&turn),
            2 => ball(dice.point(2.0)),
            _ => random_soup(&mut dice),
        };
        let mut mesh = soup.mesh();
        mesh.double_sided = seed % 3 == 0;
        let max_triangles = 1 + dice.below(60);
        let proxy = mesh.simplified(max_triangles);
        assert!(proxy.triangle_count() <= max_triangles && proxy.triangle_count() > 0);
        let (faces, of_proxy) = (soup.triangles(), triangles_of(&proxy));
        for _ in 0..1500 {
            let eye = DVec3::splat(2.0) + dice.direction() * dice.by_ratio(0.1, 30.0);
            let face = &of_proxy[dice.below(of_proxy.len())];
            let [x, y] = [dice.between(0.001, 0.998), dice.between(0.001, 0.998)];
            if x + y >= 0.999 || !(mesh.double_sided || is_front(face, eye)) {
                continue;
            }
            let [a, b, c] = *face;
            let point = a + (b - a) * x + (c - a) * y;
            let is_hidden = faces
                .iter()
                .any(|face| (mesh.double_sided || is_front(face, eye)) && hides(face, eye, point));
            assert!(is_hidden, "{point} from {eye}, scene {seed}");
            asked += 1;
        }
    }
    assert!(asked > 15_000, "{asked}");
}

fn area(triangles: &[[DVec3; 3]]) -> f64 {
    triangles
        .iter()
        .map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length())
        .sum()
}

#[test]
fn a_wall_of_many_triangles_becomes_two_and_one_with_a_window_four_rectangles() {
    let mut wall = Soup::default();
    wall.wall([0.0; 3], [0, 1], &["#".repeat(20).as_str(); 20]);
    let proxy = wall.mesh().simplified(2);
    assert_eq!((proxy.triangle_count(), area(&triangles_of(&proxy))), (2, 400.0));
    let mut wall = Soup::default();
    wall.wall(
        [0.0; 3],
        [2, 1],
        &["########", "##oooo##", "##oooo##", "########"],
    );
    let proxy = wall.mesh().simplified(8);
    assert!(proxy.triangle_count() <= 8);
    assert!(
        area(&triangles_of(&proxy)) >= 24.0,
        "{}",
        area(&triangles_of(&proxy))
    );
    // A house: five walls, two of them with holes, and a table.
    let [all, few] = [house().mesh(), house().mesh().simplified(30)];
    let covered = area(&triangles_of(&few)) / area(&triangles_of(&all));
    assert!(all.triangle_count() > 200 && covered > 0.95, "{covered}");
}

#[test]
fn of_a_wall_that_is_flat_up_to_rounding_the_largest_triangles_are_kept() {
    let mut wall = Soup::default();
    wall.wall([0.1, 0.2, 0.3], [0, 1], &["####"; 4]);
    let wall = wall.moved(&Transform::rotation([1.0, 2.0, 3.0], 0.7));
    assert_eq!(wall.mesh().simplified(5).triangle_count(), 5);
    assert_eq!(wall.mesh().simplified(0).triangle_count(), 0);
    assert_eq!(
        OccluderMesh::triangles(&[], &[])
            .expect("nothing")
            .simplified(9)
            .triangle_count(),
        0
    );
}
