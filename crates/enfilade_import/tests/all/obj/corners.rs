//! Tests corners: indices, normals, texture coordinates, colors.

use super::file::{Corner, corner, places, reads, reads_among, triangles, warnings};

const LEAF: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn lines_end_indent_and_go_on_as_programs_write_them() {
    let expected = ["0,0,0 1,0,0 0,1,0"];
    for text in [
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
        "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",
        "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
        "\u{feff}v 0 0 0\n  v\t1  0 0 \nv 0 1 \\\r\n 0 # up\nf 1 \\\n2\\\n 3\n",
        "v 0 0 0 1.0\nv 1.0e0 -0 +0 1\nv .0 1. 0\nf 1 2 3 # 4\n# C:\\\n",
    ] {
        let import = reads(text);
        assert_eq!(places(&import, 0), expected, "{text:?}");
        assert!(import.warnings.is_empty(), "{text:?}: {:?}", import.warnings);
    }
}

#[test]
fn numbers_count_back_from_the_line_or_forward_to_what_comes_later() {
    let text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 0 0\nf -4 4 -2\nf 5 6 7\nv 0 0 1\nv 1 0 1\nv 0 1 1";
    assert_eq!(
        places(&reads(text), 0),
        ["0,0,0 1,0,0 0,1,0", "0,0,0 5,0,0 0,1,0", "0,0,1 1,0,1 0,1,1"]
    );
}

#[test]
fn numbers_count_back_over_millions_of_lines() {
    let mut text = String::new();
    for n in 0..150_000 {
        text += &format!("v {n} 0 0\nv {n} 1 0\nv {n} 0 1\nf -3 -2 -1\n");
    }
    assert!(text.len() > 4 << 20);
    let import = reads(&text);
    let all = triangles(&import, 0);
    assert_eq!(all.len(), 150_000);
    let upright = |corners: &[Corner; 3]| {
        let x = corners[0].position[0];
        corners.map(|corner| corner.position) == [[x, 0.0, 0.0], [x, 0.0, 1.0], [x, 1.0, 0.0]]
            || corners.map(|corner| corner.position) == [[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]]
    };
    assert!(all.iter().all(|(corners, _)| upright(corners)));
}

#[test]
fn normals_stand_at_the_corners_that_name_them() {
    let text = format!("{LEAF}vn 0 0 2\nvn 1 0 0\nf 1//1 2//-1 3\n");
    let import = reads(&text);
    assert_eq!(corner(&import, [0.0, 0.0, 0.0]).normal, Some([0.0, 0.0, 2.0]));
    assert_eq!(corner(&import, [1.0, 0.0, 0.0]).normal, Some([1.0, 0.0, 0.0]));
    // The face's own.
    assert_eq!(corner(&import, [0.0, 1.0, 0.0]).normal, Some([0.0; 3]));
    assert_eq!(corner(&reads(&format!("{LEAF}f 1 2 3")), [0.0; 3]).normal, None);
}

/// A roof: two faces that meet at a ridge from (0, 1, 0) to (0, 1, 1).
const ROOF: &str = "v -1 0 0\nv 0 1 0\nv 1 0 0\nv -1 0 1\nv 0 1 1\nv 1 0 1\n";

#[test]
fn faces_of_one_smoothing_group_are_smooth_where_they_meet() {
    let faces = "f 1 4 5 2\nf 2 5 6 3\n";
    let ridge = |lines: &str| {
        let import = reads(&format!("{ROOF}{lines}"));
        let all = triangles(&import, 0);
        let mut found: Vec<Option<[f32; 3]>> = all
            .iter()
            .flat_map(|(corners, _)| corners)
            .filter(|corner| corner.position == [0.0, 1.0, 0.0])
            .map(|corner| corner.normal)
            .collect();
        found.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
        found.dedup();
        found
    };
    assert_eq!(ridge(&format!("s 1\n{faces}")), [Some([0.0, 1.0, 0.0])]);
    assert_eq!(ridge(faces), [None]);
    assert_eq!(ridge(&format!("s 1\ns off\n{faces}")), [None]);
    assert_eq!(ridge(&format!("s 3\ns 0\n{faces}")), [None]);
    let half = 0.5_f32.sqrt();
    let apart = ridge("s 1\nf 1 4 5 2\ns 2\nf 2 5 6 3\n");
    assert_eq!(apart.len(), 2);
    for (normal, expected) in apart.iter().zip([[-half, half, 0.0], [half, half, 0.0]]) {
        let normal = normal.expect("one of its own");
        assert!(
            (0..3).all(|axis| (normal[axis] - expected[axis]).abs() < 1e-6),
            "{normal:?}"
        );
    }
    // One that is written goes before one that is made.
    assert_eq!(
        ridge("vn 1 0 0\ns 1\nf 1 4 5//1 2//1\nf 2//1 5 6 3\n"),
        [Some([1.0, 0.0, 0.0])]
    );
}

#[test]
fn texture_coordinates_count_upwards_in_the_file_and_downwards_here() {
    let text = format!("mtllib a.mtl\nusemtl a\n{LEAF}vt 0.25 0.75\nvt 2 -1 5\nvt 0.5\nf 1/1 2/-2 3/3\n");
    let import = reads_among(&[("a.obj", text.as_bytes()), ("a.mtl", b"newmtl a\nmap_Kd a.png")]);
    assert_eq!(corner(&import, [0.0, 0.0, 0.0]).texture, Some([0.25, 0.25]));
    assert_eq!(corner(&import, [1.0, 0.0, 0.0]).texture, Some([2.0, 2.0]));
    assert_eq!(corner(&import, [0.0, 1.0, 0.0]).texture, Some([0.5, 1.0]));
    // Without an image, texture coordinates are not needed.
    let plain = reads(&format!("{LEAF}vt 0 0\nf 1/1 2/1 3/1"));
    assert_eq!(corner(&plain, [0.0; 3]).texture, None);
}

#[test]
fn colors_of_positions_are_as_on_a_screen_and_white_where_there_are_none() {
    let text = "v 0 0 0 1 0 0.5\nv 1 0 0\nv 0 1 0 0.02 2 -1\nf 1 2 3\no b\nv 0 0 5\nf 1 2 4";
    let import = reads(text);
    let first = corner(&import, [0.0, 0.0, 0.0]).color.expect("a color");
    assert_eq!([first[0], first[1], first[3]], [1.0, 0.0, 1.0]);
    assert!((first[2] - 0.214_041).abs() < 1e-5, "{first:?}");
    assert_eq!(corner(&import, [1.0, 0.0, 0.0]).color, Some([1.0; 4]));
    assert_eq!(
        corner(&import, [0.0, 1.0, 0.0]).color,
        Some([0.02 / 12.92, 1.0, 0.0, 1.0])
    );
    let plain = reads("v 0 0 0 1 1 1\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\nf 1 2 3");
    assert_eq!(corner(&plain, [0.0; 3]).color, None);
}

#[test]
fn what_is_not_finite_and_only_of_the_look_is_left_out() {
    let text = "mtllib a.mtl\nusemtl a\nv 0 0 0 nan 0 0\nv 1 0 0 1 0 0\nv 0 1 0\nvn nan 0 1\nvt 0 1.#QNAN0\nvt inf 0\n\
                vt 1e38 0\nf 1/1/1 2/2/1 3/3/1";
    let import = reads_among(&[
        ("a.obj", text.as_bytes()),
        ("a.mtl", b"newmtl a\nmap_Kd -s 1e38 1 a.png"),
    ]);
    assert!(
        warnings(&import).contains(
            &"normals, texture coordinates or colors that are not finite are ignored (4)".to_owned()
        ),
        "{:?}",
        warnings(&import)
    );
    let white = corner(&import, [0.0, 0.0, 0.0]);
    assert_eq!(
        (white.color, white.normal, white.texture),
        (Some([1.0; 4]), Some([0.0; 3]), Some([0.0, 1.0]))
    );
    assert_eq!(corner(&import, [0.0, 1.0, 0.0]).texture, Some([0.0; 2]));
}

#[test]
fn positions_that_no_face_uses_may_be_anything() {
    let text = format!("v nan 0 0\n{LEAF}v inf -nan(ind) 1e99\nf 2 3 4");
    assert_eq!(places(&reads(&text), 0), ["0,0,0 1,0,0 0,1,0"]);
}
