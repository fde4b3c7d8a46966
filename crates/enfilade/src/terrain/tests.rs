//! Height fields: rejected input, and the meshes of blocks.

use super::*;
use crate::geom::Transform;
use crate::geometry::{Geometry, GeometryBuilder, Material};
use crate::ids::ItemIndex;
use crate::mesh::Attributes;
use crate::sector::Ray;

fn field(size: [u32; 2], height: impl Fn(u32, u32) -> f32) -> HeightField {
    let mut heights = Vec::new();
    for row in 0..size[1] {
        for column in 0..size[0] {
            heights.push(height(column, row));
        }
    }
    HeightField::new(size, [2.0, 3.0], heights).expect("a sound field")
}

fn geometry(field: &HeightField) -> Geometry {
    let mut builder = GeometryBuilder::new([Material::opaque([0.3, 0.5, 0.2])]);
    let blocks = builder
        .terrain("ground", field.clone(), MaterialId(0), Transform::IDENTITY)
        .expect("few faces");
    assert_eq!(
        blocks.end.0 - blocks.start.0,
        field.blocks().iter().product::<u32>()
    );
    builder.build().expect("sound blocks")
}

#[test]
fn what_has_no_cell_no_length_or_a_hole_is_refused_by_its_place() {
    let new = |size: [u32; 2], cell, heights: &[f32]| HeightField::new(size, cell, heights).map(|_| ());
    let flat = [0.0; 6];
    assert_eq!(new([3, 2], [1.0, 1.0], &flat), Ok(()));
    assert_eq!(
        new([6, 1], [1.0, 1.0], &flat),
        Err(HeightFieldError::Size([6, 1]))
    );
    assert_eq!(
        new([2, MAX_SAMPLES + 1], [1.0, 1.0], &flat),
        Err(HeightFieldError::Size([2, MAX_SAMPLES + 1]))
    );
    for cell in [
        [0.0, 1.0],
        [1.0, -1.0],
        [f64::NAN, 1.0],
        [1.0, 2e38],
        [1e-60, 1.0],
    ] {
        let refused = new([3, 2], cell, &flat).expect_err("no length");
        assert!(
            matches!(refused, HeightFieldError::Cell(_)),
            "{cell:?}: {refused}"
        );
    }
    assert_eq!(
        new([3, 3], [1.0, 1.0], &flat),
        Err(HeightFieldError::Count { needs: 9, has: 6 })
    );
    for hole in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut heights = flat;
        heights[5] = hole;
        let refused = new([3, 2], [1.0, 1.0], &heights).expect_err("a hole");
        assert!(
            refused
                .to_string()
                .starts_with("the height at column 2, row 1 is "),
            "{refused}"
        );
    }
}

#[test]
fn blocks_cover_the_field_once_and_share_their_edges() {
    for size in [[2, 2], [33, 33], [34, 2], [65, 40], [7, 100]] {
        let field = field(size, |column, row| ((column * 7 + row * 3) % 5) as f32);
        let geometry = geometry(&field);
        let cells = u64::from(size[0] - 1) * u64::from(size[1] - 1);
        assert_eq!(geometry.triangle_count(), 2 * cells);
        let bounds = geometry.bounds();
        assert_eq!([bounds.min[0], bounds.min[2]], [0.0, 0.0]);
        let last = field.position(size[0] - 1, size[1] - 1);
        assert_eq!([bounds.max[0], bounds.max[2]], [last[0], last[2]]);
        // A ray from above hits the ground at any position, and its front.
        for number in 0..200 {
            let place = |step: f64, end: f32| ((f64::from(number) * step).fract() as f32) * end;
            let origin = [place(0.754_877_7, last[0]), 50.0, place(0.569_840_3, last[2])];
            let ray = Ray {
                origin,
                direction: [0.0, -1.0, 0.0],
            };
            let hit = geometry.cast(&ray).expect("ground below");
            assert!(!hit.from_behind, "at {origin:?} of {size:?}");
        }
    }
}

#[test]
fn the_diagonal_of_a_cell_goes_from_north_east_to_south_west() {
    // A ridge along the diagonal; the other diagonal would make it a valley.
    let field = field([2, 2], |column, row| if column == row { 0.0 } else { 1.0 });
    let geometry = geometry(&field);
    let down = Ray {
        origin: [1.0, 9.0, 1.5],
        direction: [0.0, -1.0, 0.0],
    };
    let hit = geometry.cast(&down).expect("ground below");
    assert!((hit.distance - 8.0).abs() < 1e-6, "{}", hit.distance);
}

#[test]
fn a_field_may_be_cut_along_the_other_diagonal() {
    let field = field([40, 34], |column, row| ((column * 7 + row * 3) % 5) as f32);
    let cut = |diagonal| geometry(&field.clone().cut_along(diagonal));
    assert_eq!(
        cut(Diagonal::NorthEast).triangle_count(),
        cut(Diagonal::NorthWest).triangle_count()
    );
    let middle_of = |geometry: &Geometry, [column, row]: [u32; 2]| {
        let ray = Ray {
            origin: [2.0 * column as f32 + 1.0, 50.0, 3.0 * row as f32 + 1.5],
            direction: [0.0, -1.0, 0.0],
        };
        50.0 - geometry.cast(&ray).expect("ground below").distance
    };
    for diagonal in [Diagonal::NorthEast, Diagonal::NorthWest] {
        let geometry = cut(diagonal);
        for (column, row) in [(0, 0), (31, 5), (32, 32), (38, 31)] {
            let ends = match diagonal {
                Diagonal::NorthEast => [(column + 1, row), (column, row + 1)],
                Diagonal::NorthWest => [(column, row), (column + 1, row + 1)],
            };
            let [one, other] = ends.map(|(column, row)| f64::from(field.position(column, row)[1]));
            let off = middle_of(&geometry, [column, row]) - (one + other) / 2.0;
            assert!(off.abs() < 1e-5, "{off} at {column}, {row} with {diagonal:?}");
        }
    }
}

#[test]
fn columns_and_rows_stand_where_they_are_said_to() {
    let field = HeightField::on_lines([-7.5, 0.1, 0.3], [-1.0, 1e6], [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    let field = field.expect("increasing lines");
    assert_eq!((field.size(), field.position(1, 1)), ([3, 2], [0.1, 4.0, 1e6]));
    assert_eq!(geometry(&field).bounds().min, [-7.5, 0.0, -1.0]);
    let refused = |columns: &[f32], rows: &[f32]| {
        let refused = HeightField::on_lines(columns, rows, [0.0; 6]);
        refused.expect_err("lines do not increase").to_string()
    };
    let words = "positions must increase";
    for (columns, said) in [
        ([0.0, 0.0, 1.0], "column 1 of a height field is at 0; "),
        ([0.0, 2.0, 1.0], "column 2 of a height field is at 1; "),
        ([f32::NAN, 2.0, 1.0], "column 0 of a height field is at NaN; "),
        (
            [0.0, 2.0, f32::INFINITY],
            "column 2 of a height field is at inf; ",
        ),
    ] {
        let text = refused(&columns, &[0.0, 1.0]);
        assert!(text.contains(said) && text.contains(words), "{text}");
    }
    assert!(refused(&[0.0, 1.0, 2.0], &[1.0, 0.0]).starts_with("row 1 of a height field"));
    assert!(refused(&[0.0], &[0.0, 1.0]).contains("has 1 x 2"));
    assert!(refused(&[0.0, 1.0], &[0.0, 1.0]).contains("4 heights are needed, but there are 6"));
}

#[test]
fn what_places_carry_comes_to_the_corners_of_their_blocks() {
    let field = field([40, 35], |column, row| ((column * 7 + row * 3) % 5) as f32);
    let smooth = geometry(&field);
    assert!(smooth.meshes().iter().all(|mesh| !mesh.normals().is_empty()));
    let places: Vec<[f32; 2]> = (0..35)
        .flat_map(|row| (0..40).map(move |column| [column as f32, row as f32]))
        .collect();
    let carrying = |texture: &[[f32; 2]]| {
        field.clone().carrying(Attributes {
            texture,
            ..Attributes::default()
        })
    };
    let geometry = geometry(&carrying(&places).expect("one per sample"));
    for mesh in geometry.meshes() {
        // Without given normals, faces are flat-shaded.
        assert!(mesh.normals().is_empty() && mesh.colors().is_empty());
        let pairs = mesh.positions().iter().zip(mesh.texture());
        for (position, place) in pairs {
            assert_eq!([position[0], position[2]], [2.0 * place[0], 3.0 * place[1]]);
        }
        assert_eq!(mesh.texture().len(), mesh.positions().len());
    }
    let few = carrying(&places[1..]).expect_err("too few").to_string();
    assert_eq!(
        few,
        "1400 texture coordinates are needed, or none, but there are 1399"
    );
    let mut odd = places.clone();
    odd[7] = [f32::NAN, 0.0];
    let odd = carrying(&odd).expect_err("NaN").to_string();
    assert_eq!(odd, "texture coordinates of a height field are not all finite");
}

#[test]
fn blocks_are_called_by_their_row_and_column() {
    let geometry = geometry(&field([70, 40], |_, _| 0.0));
    let names: Vec<&str> = (0..6).map(|item| geometry.name(ItemIndex(item))).collect();
    let expected = [
        "ground 0 0",
        "ground 0 1",
        "ground 0 2",
        "ground 1 0",
        "ground 1 1",
        "ground 1 2",
    ];
    assert_eq!(names, expected);
}
