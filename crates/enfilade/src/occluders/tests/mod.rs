//! Test support: walls that occluders are built from.

mod choosing;
mod hiding;

use super::*;
use crate::chance::Dice;
use crate::geom::Transform;
use crate::geometry::{GeometryBuilder, Material};
use crate::ids::{MaterialId, SectorId};
use crate::view::View;
use crate::view::passage::Passage;

/// A triangle mesh as plain arrays: positions and corners.
#[derive(Clone, Default)]
struct Wall {
    corners: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Wall {
    /// Builds a wall of squares in the plane z = 0, front faces toward z > 0; `there` selects the squares.
    fn of_squares(columns: usize, rows: usize, there: impl Fn(usize, usize) -> bool) -> Wall {
        let mut wall = Wall::default();
        for row in 0..=rows {
            for column in 0..=columns {
                wall.corners.push([column as f64, row as f64, 0.0]);
            }
        }
        let at = |column: usize, row: usize| (row * (columns + 1) + column) as u32;
        for row in 0..rows {
            for column in 0..columns {
                if there(column, row) {
                    let [a, b] = [at(column, row), at(column + 1, row)];
                    let [c, d] = [at(column + 1, row + 1), at(column, row + 1)];
                    if (row + column) % 3 == 0 {
                        wall.triangles.extend([[a, b, c], [a, c, d]]);
                    } else {
                        wall.triangles.extend([[a, b, d], [b, c, d]]);
                    }
                }
            }
        }
        wall
    }

    /// Builds a disk of `sides` triangles.
    fn fan(sides: usize) -> Wall {
        let rim = (0..sides).map(|side| {
            let angle = std::f64::consts::TAU * side as f64 / sides as f64;
            [3.0 * angle.cos(), 3.0 * angle.sin(), 0.0]
        });
        let count = sides as u32;
        Wall {
            corners: std::iter::once([0.0; 3]).chain(rim).collect(),
            triangles: (0..count)
                .map(|side| [0, side + 1, (side + 1) % count + 1])
                .collect(),
        }
    }

    /// Builds squares under one long face whose lower edge has none of their corners (T-junctions).
    fn with_t_junctions(columns: usize) -> Wall {
        let mut wall = Wall::of_squares(columns, 1, |_, _| true);
        let [left, right] = [columns as u32 + 1, 2 * columns as u32 + 1];
        let first = wall.corners.len() as u32;
        wall.corners.extend([[0.0, 4.0, 0.0], [columns as f64, 4.0, 0.0]]);
        wall.triangles
            .extend([[left, right, first + 1], [left, first + 1, first]]);
        wall
    }

    fn area(&self) -> f64 {
        let corner = |index: u32| DVec3::from(self.corners[index as usize]);
        let doubled = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a)).length();
        self.triangles
            .iter()
            .map(|triangle| 0.5 * doubled(triangle))
            .sum()
    }

    /// Returns a transformed copy, with corners rounded as they would be in a file.
    fn moved(mut self, to: &Transform) -> Wall {
        for corner in &mut self.corners {
            let moved = to.0.transform_point3(DVec3::from(*corner));
            *corner = moved.to_array().map(|value| f64::from(value as f32));
        }
        self
    }

    fn geometry(&self, double_sided: bool, places: &[Transform]) -> Geometry {
        let mut geometry = GeometryBuilder::new([Material {
            double_sided,
            ..Material::opaque([0.5; 3])
        }]);
        let positions: Vec<[f32; 3]> = self
            .corners
            .iter()
            .map(|corner| corner.map(|value| value as f32))
            .collect();
        let mesh = Mesh::triangles(&positions, self.triangles.as_flattened(), MaterialId(0))
            .expect("the corners are finite");
        let mesh = geometry.mesh(mesh);
        for place in places {
            geometry.item("wall", mesh, *place);
        }
        geometry.build().expect("the wall is valid")
    }
}

fn anywhere(dice: &mut Dice) -> Transform {
    let axis = dice.point(1.0).as_vec3().into();
    Transform::translation(dice.point(50.0).as_vec3().into())
        * Transform::rotation(axis, dice.between(0.0, 6.0))
        * Transform::scaling([dice.between(0.01, 30.0) as f32; 3])
}

fn passage(eye: [f64; 3], toward: [f64; 3]) -> Passage {
    let [eye, toward] = [eye, toward].map(|point| point.map(|value| value as f32));
    Passage::at_the_eye(
        &View::new(eye, toward, [640, 360]).expect("a valid view"),
        SectorId(0),
        false,
    )
}

/// Returns the walls of all test cases.
fn walls(dice: &mut Dice) -> Vec<(&'static str, Wall)> {
    let (columns, rows) = (2 + dice.below(9), 2 + dice.below(7));
    let holes: Vec<bool> = (0..columns * rows).map(|_| dice.roll() < 0.2).collect();
    let mut twice = Wall::of_squares(3, 2, |_, _| true);
    twice.triangles.extend_from_within(..5);
    let mut slivers = Wall::of_squares(4, 3, |column, row| column != 1 || row != 1);
    for corner in &mut slivers.corners {
        corner[0] += 1e-6 * dice.between(-1.0, 1.0) * corner[1];
    }
    slivers.triangles.extend([[0, 1, 2], [0, 0, 6], [1, 2, 3]]);
    vec![
        ("a plain wall", Wall::of_squares(columns, rows, |_, _| true)),
        (
            "a wall with windows",
            Wall::of_squares(columns, rows, |x, y| !holes[y * columns + x]),
        ),
        ("an L", Wall::of_squares(columns, rows, |x, y| x == 0 || y == 0)),
        ("a fan", Wall::fan(3 + dice.below(60))),
        ("T-junctions", Wall::with_t_junctions(columns)),
        ("duplicate faces", twice),
        ("slivers", slivers),
    ]
}

/// Checks the documented invariants of an occluder.
fn is_sound(occluder: &Occluder, what: &str) {
    let corners = occluder.corners;
    let (normal, distance) = occluder.plane;
    assert!(distance > 0.0 && (normal.length() - 1.0).abs() < 1e-9, "{what}");
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    for (place, &from) in corners.iter().enumerate() {
        let to = corners[(place + 1) % corners.len()];
        assert!(
            to.cross(from).dot(middle) > 0.0,
            "{what}: {corners:?} is not counter-clockwise"
        );
        assert!(
            normal.dot(from) <= distance,
            "{what}: a corner is behind its plane"
        );
    }
}
