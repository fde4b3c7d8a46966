//! Which faces make which item, and how it is called.

use super::file::{names, places, reads, warnings};
use enfilade_import::{ReadOptions, read_bytes};

/// Four positions, then some lines.
fn square(lines: &str) -> String {
    format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n{lines}\n")
}

#[track_caller]
fn called(lines: &str, expected: &[&str]) {
    assert_eq!(names(&reads(&square(lines))), expected, "{lines}");
}

#[test]
fn objects_and_groups_are_items_of_their_names() {
    called(
        "o hall\nf 1 2 3\ng tall oak door \nf 1 3 4",
        &["hall", "tall oak door"],
    );
    called("f 1 2 3", &["default"]);
    called("o\nf 1 2 3", &["default"]);
    called("f 1 2 3\no hall\nf 1 2 3", &["default", "hall"]);
    called("o h\u{e4}lle\nf 1 2 3\n", &["h\u{e4}lle"]);
}

#[test]
fn groups_without_faces_are_no_items() {
    called("g a\ng b\nf 1 2 3\ng c\nusemtl d\ng", &["b"]);
    called("g a\nl 1 2\np 1\nf 1 2\ng b\nf 1 2 3", &["b"]);
}

#[test]
fn a_name_that_returns_gets_the_number_of_its_item() {
    called("g a\nf 1 2 3\ng b\nf 1 2 3\ng a\nf 1 3 4", &["a#0", "b", "a#2"]);
    called(
        "g a\nf 1 2 3\ng b\nf 1 2 3\ng a\nf 1 3 4\ng a#0\nf 1 2 4",
        &["a#0#0", "b", "a#2", "a#0"],
    );
    called("f 1 2 3\ng default\nf 1 2 3", &["default#0", "default#1"]);
}

#[test]
fn a_name_repeated_with_every_material_is_one_item() {
    let text = square("o a\nusemtl x\nf 1 2 3\no a\nusemtl y\nf 1 3 4");
    let import = reads(&text);
    assert_eq!(names(&import), ["a"]);
    assert_eq!(places(&import, 0).len(), 2);
}

#[test]
fn names_that_are_not_utf8_are_read_as_far_as_they_are() {
    let mut text = square("").into_bytes();
    text.extend(b"o caf\xe9\nf 1 2 3");
    let import = read_bytes(&text, None, &ReadOptions::default()).expect("a name in Latin-1");
    assert_eq!(names(&import), ["caf\u{fffd}"]);
}

#[test]
fn all_is_one_room_also_where_objects_are_called_like_rooms() {
    let text = square("o Hall-room\nf 1 2 3\no Door-portal.001\nf 1 3 4\no Chair\nf 1 2 4");
    let import = reads(&text);
    assert_eq!((import.rooms.len(), import.portals.len()), (1, 0));
    assert_eq!(import.rooms[0].name, "scene");
    assert_eq!(names(&import), ["Hall-room", "Door-portal.001", "Chair"]);
    assert_eq!(
        warnings(&import),
        [
            "objects are named like rooms, portals or mirrors, but OBJ has no hierarchy to mark rooms: everything is one room \
             (Hall-room, Door-portal.001)"
        ]
    );
    let flat = ReadOptions {
        flat: true,
        ..ReadOptions::default()
    };
    let import = read_bytes(text.as_bytes(), None, &flat).expect("sound");
    assert_eq!(warnings(&import), [""; 0]);
}

#[test]
fn a_file_without_faces_is_called_empty() {
    let empty = "the scene is empty: it has no triangle";
    assert_eq!(warnings(&reads("o a\nv 0 0 0\ng b")), [empty]);
    assert_eq!(warnings(&reads("v 0 0 0\n")), [empty]);
}

#[test]
fn points_and_lines_are_named() {
    let import = reads(&square("f 1 2 3\np 1 2\nl 1 2 3\nf 1\nf 2 3\nl -1 -2\n"));
    assert_eq!(
        warnings(&import),
        [
            "points are not drawn (line 6, line 8)",
            "lines are not drawn (line 7, line 9, line 10)"
        ]
    );
    assert_eq!(places(&import, 0), ["0,0,0 1,0,0 1,1,0"]);
}

#[test]
fn curves_and_unknown_statements_are_named_once_each() {
    let import = reads(&square("f 1 2 3\nvp 1 2\ncstype bezier\nvp 2 3\nend\nwhatever 1"));
    assert_eq!(
        warnings(&import),
        ["unknown statements are ignored (cstype, end, vp, whatever)"]
    );
}
