//! Files that break a rule: each is refused with the line and the rule.

use super::file::{read_among, refusal};
use enfilade_import::{BrokenRule, ObjError, ReadOptions};

/// Two positions in lines 1 and 2, one of each other kind, then some lines, the first of which is 5.
#[track_caller]
fn refuses(lines: &str, expected: &str) {
    let text = format!("v 0 0 0\nv 1 0 0\nvt 0 0\nvn 0 0 1\n{lines}");
    let said = refusal(text.as_bytes()).unwrap_or_else(|| panic!("{lines:?} is read without complaint"));
    assert!(
        said.starts_with(&format!("the bytes given: {expected}")),
        "{lines:?}: {said}"
    );
    assert!(said.contains("; "), "it says what to do: {said}");
}

#[test]
fn numbers_that_name_nothing() {
    refuses("f 1 2 3", "line 5: `3` names position 3, but the file has only 2");
    refuses(
        "\n\nf 1 2 \\\n0",
        "line 7: `0` names position 0, but they are counted from 1, or backwards from -1",
    );
    refuses(
        "f 1 2 99999999999",
        "line 5: `99999999999` names position 99999999999, but the file has only 2",
    );
    refuses(
        "f 1 2 -3",
        "line 5: `-3` names position -3, but only 2 come before that line",
    );
    refuses(
        "f -2 -1 -3\nv 0 1 0",
        "line 5: `-3` names position -3, but only 2 come before that line",
    );
    refuses(
        "f 1/2 2/1 1/1",
        "line 5: `1/2` names texture coordinates 2, but the file has only 1",
    );
    refuses(
        "f 1/0 2/1 1/1",
        "line 5: `1/0` names texture coordinates 0, but they are counted from 1, or backwards from -1",
    );
    refuses(
        "f 1//7 2//1 1//1",
        "line 5: `1//7` names normal 7, but the file has only 1",
    );
    refuses(
        "f 1//-2 2//1 1//1",
        "line 5: `1//-2` names normal -2, but only 1 come before that line",
    );
}

#[test]
fn words_that_are_no_corners() {
    for word in ["two", "1/1/1/1", "/1", "//1", "1.5", "1-2", "0x1"] {
        refuses(
            &format!("f 1 2 {word}"),
            &format!(
                "line 5: `{word}` is not a face corner, which is POSITION, POSITION/TEXTURE, POSITION/TEXTURE/NORMAL or \
                 POSITION//NORMAL, each an integer"
            ),
        );
    }
    refuses("f", "line 5 is a face without corners");
    refuses("f # 1 2 3", "line 5 is a face without corners");
}

#[test]
fn numbers_that_are_none_or_too_few() {
    refuses("v 0 1,5 0", "line 5: `1,5` is not a number");
    refuses("v 0 0 0 1 zero 0", "line 5: `zero` is not a number");
    refuses("v 1 2", "line 5: `v` needs 3 numbers, but has 2");
    refuses("v", "line 5: `v` needs 3 numbers, but has 0");
    refuses("vn 1 # 2 3", "line 5: `vn` needs 3 numbers, but has 1");
    refuses("vt", "line 5: `vt` needs 1 numbers, but has 0");
    refuses("vt a", "line 5: `a` is not a number");
    let long = "9".repeat(50) + "x";
    refuses(
        &format!("v 0 0 {long}"),
        &format!("line 5: `{}…` is not a number", &long[..40]),
    );
}

#[test]
fn positions_that_are_not_finite_where_a_face_is() {
    for nan in ["nan", "inf", "1e39", "-1.#IND00"] {
        refuses(
            &format!("v 0 {nan} 0\nf 1 2 3\n"),
            "line 6 is a face with a corner at position 3, which is not finite; repair the mesh and export it again",
        );
    }
    refuses(
        "f 1 2\nf 1 2 1\nv nan 0 0\nl 1 2\nf 1 2 \\\n -1 1",
        "line 9 is a face with a corner at position 3, which is not finite; repair the mesh and export it again",
    );
}

#[test]
fn what_is_no_text() {
    let zero =
        "line 6 has a byte 0 in it, so this is not text; export it again, or give it its proper extension";
    refuses("f 1 2 1\n\0\n", zero);
    // As editors on Windows may write text.
    let wide: Vec<u8> = "v 0 0 0\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let error = read_among(&[("a.obj", &wide)], &ReadOptions::default()).expect_err("UTF-16");
    assert!(
        error.to_string().contains("a.obj: line 1 has a byte 0 in it"),
        "{error}"
    );
    assert!(
        matches!(&error.rule, BrokenRule::Obj(why) if **why == ObjError::NotText { line: 1 }),
        "{error:?}"
    );
}

#[test]
fn of_several_broken_lines_the_first_is_named() {
    let mut text = "v 0 0 0\n".repeat(300_000);
    for line in [250_000, 100, 299_999] {
        text.replace_range(8 * line..8 * line + 7, "v 0 0 x");
    }
    for _ in 0..5 {
        let said = refusal(text.as_bytes()).expect("a broken line");
        assert!(said.contains("line 101: `x` is not a number;"), "{said}");
    }
}
