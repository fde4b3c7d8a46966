//! Tests materials.

use super::file::{material, read_among, reads, reads_among, triangles, warnings};
use enfilade::{Alpha, Material};
use enfilade_import::{Import, ReadOptions};

const LEAF: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// A leaf made of the material `a` of a file with these lines.
#[track_caller]
fn made_of(lines: &str) -> Import {
    let text = format!("mtllib a.mtl\n{LEAF}usemtl a\nf 1 2 3");
    reads_among(&[
        ("a.obj", text.as_bytes()),
        ("a.mtl", format!("newmtl a\n{lines}").as_bytes()),
    ])
}

/// The same gives no warning.
#[track_caller]
fn quietly(lines: &str) -> Material {
    let import = made_of(lines);
    assert_eq!(warnings(&import), [""; 0], "{lines}");
    material(&import)
}

fn both_sides(color: [f32; 3]) -> Material {
    Material {
        double_sided: true,
        ..Material::opaque(color)
    }
}

#[test]
fn colors_are_linear_and_seen_from_both_sides() {
    let shining = Material {
        emission: [0.0, 3.0, 0.5],
        ..both_sides([0.25, 0.5, 1.0])
    };
    assert_eq!(
        quietly("Ka 1 1 1\nKd 0.25 .5 7\nKs 0 0 0\nNs 5\nillum 2\nKe 0 3 0.5\nNi 1.5\nTf 1 1 1"),
        shining
    );
    assert_eq!(quietly("Kd 0.5"), both_sides([0.5; 3]));
    assert_eq!(quietly(""), both_sides([1.0; 3]));
    assert_eq!(quietly("Kd 0 0 0"), both_sides([0.0; 3]));
    assert_eq!(material(&reads(&format!("{LEAF}f 1 2 3"))), both_sides([1.0; 3]));
}

#[test]
fn d_and_tr_make_glass() {
    for (lines, coverage) in [
        ("d 0.25", 0.25),
        ("Tr 0.75", 0.25),
        ("d 0.25\nTr 0.75", 0.25),
        ("Tr 0.75\nd 0.25", 0.25),
        ("d 0", 0.0),
    ] {
        let glass = quietly(lines);
        assert_eq!(
            (glass.alpha, glass.base_color),
            (Alpha::Blend, [1.0, 1.0, 1.0, coverage]),
            "{lines}"
        );
    }
    for lines in ["d 1", "Tr 0", "d 1.0\nTr 0.0"] {
        assert_eq!(quietly(lines), both_sides([1.0; 3]), "{lines}");
    }
    // Some write 1 for both.
    let odd = made_of("d 1\nTr 1");
    assert_eq!(material(&odd).alpha, Alpha::Opaque);
    assert_eq!(
        warnings(&odd),
        ["unknown statements in material files are ignored (a: Tr contradicts d, which is used)"]
    );
}

#[test]
fn faces_of_several_materials_are_one_item() {
    let text = format!(
        "mtllib a.mtl\n{LEAF}v 1 1 0\nf 1 2 4\nusemtl red\nf 1 2 3\nusemtl blue\nf 2 4 3\nusemtl red\nf 1 3 4"
    );
    let import = reads_among(&[
        ("a.obj", text.as_bytes()),
        (
            "a.mtl",
            b"newmtl unused\nKd 9 9 9\nnewmtl blue\nKd 0 0 1\nnewmtl red\nKd 1 0 0",
        ),
    ]);
    let mut colors: Vec<[f32; 4]> = triangles(&import, 0).iter().map(|(_, m)| m.base_color).collect();
    colors.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    let [blue, red, white] = [[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 0.0, 1.0], [1.0; 4]];
    assert_eq!(colors, [blue, red, red, white]);
    // What is not used is not kept: two of the file, and the one of faces that name none.
    assert_eq!(import.rooms[0].geometry.materials().len(), 3);
}

#[test]
fn a_file_of_materials_that_is_not_there_is_a_warning_and_grey() {
    let text = format!("mtllib house.mtl\nusemtl oak\n{LEAF}f 1 2 3");
    let import = reads_among(&[("a.obj", text.as_bytes())]);
    let grey = Material {
        alpha: Alpha::Mask,
        cutoff: 0.0,
        ..both_sides([0.215_860_5; 3])
    };
    assert_eq!(material(&import), grey);
    let said = warnings(&import);
    assert!(
        said[0].starts_with("material files cannot be read (house.mtl: cannot be read: "),
        "{said:?}"
    );
    assert_eq!(said[1], "undefined materials are grey, and hide nothing (oak)");
    let said = warnings(&reads(&text));
    assert_eq!(
        said[0],
        "material files cannot be read (house.mtl: no folder was given to look for it)"
    );
    let options = ReadOptions::default();
    for name in ["", ".", "sub"] {
        let text = format!("mtllib {name}\n{LEAF}f 1 2 3");
        let import = read_among(&[("a.obj", text.as_bytes()), ("sub/b.mtl", b"")], &options).expect("sound");
        assert_eq!(import.warnings.len(), 1, "`{name}`: {:?}", warnings(&import));
    }
}

#[test]
fn materials_that_are_not_defined_are_named() {
    let text =
        format!("mtllib a.mtl\n{LEAF}usemtl oak\nf 1 2 3\nusemtl\nf 1 2 3\nusemtl ash\nusemtl oak\nf 1 2 3");
    let import = reads_among(&[("a.obj", text.as_bytes()), ("a.mtl", b"newmtl Oak\n")]);
    assert_eq!(
        warnings(&import),
        ["undefined materials are grey, and hide nothing (oak, (no name))"]
    );
}

#[test]
fn files_of_materials_may_be_several_and_have_spaces_in_their_names() {
    let first = b"newmtl oak\nKd 1 0 0";
    let second = b"newmtl oak\nKd 0 1 0\nnewmtl ash\nKd 0 0 1";
    for statements in [
        "mtllib my first.mtl\nmtllib sub/second.mtl",
        "mtllib my first.mtl sub/second.mtl",
        "mtllib \"my first.mtl\"\nmtllib sub\\second.mtl\nmtllib my first.mtl",
        "mtllib C:\\art\\my first.mtl\nmtllib ./sub/../sub/second.mtl",
    ] {
        let text = format!("{statements}\n{LEAF}usemtl oak\nf 1 2 3\nusemtl ash\nf 1 2 3");
        let import = reads_among(&[
            ("a.obj", text.as_bytes()),
            ("my first.mtl", first),
            ("sub/second.mtl", second),
        ]);
        assert_eq!(warnings(&import), [""; 0], "{statements}");
        let colors = import.rooms[0].geometry.materials()[..2]
            .iter()
            .map(|m| m.base_color);
        // Of two that share a name the first counts.
        assert_eq!(
            colors.collect::<Vec<_>>(),
            [[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]],
            "{statements}"
        );
    }
}

#[test]
fn what_is_not_read_of_a_material_is_named() {
    let import = made_of("Kd red\nmap_Bump -bm 1 bumps.png\nrefl -type sphere sky.png\nd -halo 0.5");
    assert_eq!(
        warnings(&import),
        [
            "unknown statements in material files are ignored (a.mtl line 2: Kd red, a.mtl line 3: map_Bump -bm 1 bumps.png, \
             a.mtl line 4: refl -type sphere sky.png, a.mtl line 5: d -halo 0.5)"
        ]
    );
}

#[test]
fn memory_for_materials_is_asked_for() {
    let text = format!("mtllib a.mtl\n{LEAF}usemtl a\nf 1 2 3");
    let large = "newmtl a\n".repeat(10_000);
    let options = ReadOptions {
        limit_bytes: 1 << 20,
        ..ReadOptions::default()
    };
    let files = [("a.obj", text.as_bytes()), ("a.mtl", large.as_bytes())];
    let said = warnings(&read_among(&files, &options).expect("sound without"));
    assert!(
        said[0].contains("a.mtl would raise the memory needed to"),
        "{said:?}"
    );
}
