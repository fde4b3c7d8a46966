//! Which files are taken for OBJ.

use super::file::{names, read_among, refusal};
use enfilade_import::{BrokenRule, ReadOptions};

#[test]
fn bytes_that_begin_like_obj_are_obj_whatever_the_file_is_called() {
    for text in [
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
        "# by hand\n\no a\ng b\nmtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
        "vt 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
    ] {
        assert_eq!(refusal(text.as_bytes()), None, "{text}");
        let options = ReadOptions::default();
        for name in ["a.obj", "a.OBJ", "a.glb", "a"] {
            let import = read_among(&[(name, text.as_bytes())], &options).expect("OBJ");
            assert_eq!(import.rooms[0].name, "a");
            assert_eq!(names(&import).len(), 1);
        }
    }
}

#[test]
fn gltf_is_gltf_though_it_is_called_obj() {
    let json = br#"{ "asset": { "version": "2.0" } }"#;
    let import = read_among(&[("a.obj", json)], &ReadOptions::default()).expect("glTF");
    assert_eq!(names(&import), [""; 0]);
    let error = read_among(&[("a.obj", b"glTF\x02\0")], &ReadOptions::default()).expect_err("cut short");
    assert!(matches!(error.rule, BrokenRule::Truncated { .. }), "{error}");
}

#[test]
fn what_has_no_line_of_obj_is_not_obj_though_it_is_called_so() {
    for (text, begins) in [
        (&b""[..], "is empty"),
        (b"once upon a time", "begins with `once upon a `"),
        (b"\x89PNG\r\n\x1a\n", "begins with `\\x89PNG\\r\\n\\x1a\\n`"),
    ] {
        let error = read_among(&[("a.obj", text)], &ReadOptions::default()).expect_err("no OBJ");
        assert!(
            error.to_string().contains(&format!(
                "a.obj: is neither glTF nor OBJ, nor a map of Quake, terrain or a baked scene: it {begins}; name a scene"
            )),
            "{error}"
        );
    }
    // With nothing in it but a comment, its name is what counts.
    let import = read_among(&[("a.obj", b"# nothing yet\n")], &ReadOptions::default()).expect("OBJ");
    assert_eq!(import.warnings.len(), 1);
}

#[test]
fn text_that_only_looks_like_obj_is_not_taken_for_it() {
    for text in [
        "o brother\nwhere art thou",
        "v\n",
        "v one two",
        "g\n",
        "s off",
        "f 1 2 3",
        "mtllib\n",
    ] {
        let said = refusal(text.as_bytes()).expect("no OBJ");
        assert!(said.contains("neither glTF nor OBJ"), "{text}: {said}");
    }
}
