//! The same as `tobj` reads, where that reads all there is.

use super::file::{names, places, reads, triangles};
use std::fmt::Write;
use std::io::Cursor;
use std::path::Path;

/// Models of tobj as places and corners, one line each.
fn by_tobj(text: &str) -> Vec<(String, Vec<String>)> {
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: true,
        ..tobj::LoadOptions::default()
    };
    let no_files = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(text), &options, no_files).expect("sound");
    models
        .iter()
        .map(|model| {
            let mesh = &model.mesh;
            let mut lines: Vec<String> = mesh
                .indices
                .chunks(3)
                .map(|corners| {
                    let mut corners: Vec<(String, String)> = corners
                        .iter()
                        .map(|&index| {
                            let part = |list: &[f32]| match list.get(3 * index as usize..) {
                                Some([x, y, z, ..]) => format!("{x},{y},{z}"),
                                _ => String::new(),
                            };
                            (part(&mesh.positions), part(&mesh.normals))
                        })
                        .collect();
                    let least = (0..3).min_by_key(|&n| corners[n].clone()).expect("three");
                    corners.rotate_left(least);
                    format!("{corners:?}")
                })
                .collect();
            lines.sort();
            (model.name.clone(), lines)
        })
        .collect()
}

fn by_us(text: &str) -> Vec<(String, Vec<String>)> {
    let import = reads(text);
    let spoken = |value: Option<[f32; 3]>| value.map_or(String::new(), |[x, y, z]| format!("{x},{y},{z}"));
    let names: Vec<String> = names(&import).into_iter().map(str::to_owned).collect();
    (0..)
        .zip(names)
        .map(|(item, name)| {
            let mut lines: Vec<String> = triangles(&import, item)
                .iter()
                .map(|(corners, _)| {
                    let mut corners: Vec<(String, String)> = corners
                        .iter()
                        .map(|c| (spoken(Some(c.position)), spoken(c.normal)))
                        .collect();
                    let least = (0..3).min_by_key(|&n| corners[n].clone()).expect("three");
                    corners.rotate_left(least);
                    format!("{corners:?}")
                })
                .collect();
            lines.sort();
            (name, lines)
        })
        .collect()
}

#[test]
fn a_town_of_boxes_is_read_as_another_reader_reads_it() {
    let mut number = super::file::numbers(17);
    let mut text = "# a town\n".to_owned();
    for house in 0..200 {
        let [x, y, z] = [0; 3].map(|_| number(1000) as f32 / 7.0);
        writeln!(text, "o house {house}").expect("into a string");
        for corner in 0..8 {
            let at = |bit: u32| (corner >> bit & 1) as f32;
            writeln!(text, "v {} {} {}", x + at(0), y + at(1), z + 3.5 * at(2)).expect("into a string");
        }
        for axis in 0..3 {
            let normal = [0, 1, 2].map(|n| if n == axis { "1" } else { "0" }).join(" ");
            writeln!(text, "vn {normal}").expect("into a string");
        }
        for (axis, sides) in [(3, [1, 3, 7, 5]), (2, [1, 2, 6, 5]), (1, [1, 2, 4, 3])] {
            let corner = |n: i32| {
                if house % 2 == 0 {
                    format!("{}//-{axis}", n - 9)
                } else {
                    format!("{}//{}", 8 * house + n, 3 * house + 4 - axis)
                }
            };
            writeln!(text, "f {}", sides.map(corner).join(" ")).expect("into a string");
        }
    }
    let ours = by_us(&text);
    assert_eq!((ours.len(), ours[7].0.as_str()), (200, "house 7"));
    assert_eq!(ours, by_tobj(&text));
}

#[test]
fn what_another_reader_gets_wrong_is_read_as_it_is_written() {
    // It makes a triangle of a line of three points, and panics at a color of one number.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\nf 1 2 3";
    assert_eq!((by_tobj(text)[0].1.len(), places(&reads(text), 0).len()), (2, 1));
}
