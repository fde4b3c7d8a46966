//! Files that break a rule: each is refused by line, rule and remedy, and none of them for long.

use super::refusal;
use enfilade_import::{PortalFile, ReadOptions, read_portals};

const DOOR: &str = "(10 -1 0) (10 1 0) (10 1 2) (10 -1 2)";

#[track_caller]
fn says(text: &str, wanted: &str) {
    let said = refusal(text).to_string();
    assert!(said.starts_with(wanted), "{said}");
    assert!(said.contains("compile"), "what to do about it: {said}");
}

#[test]
fn what_is_no_prt_is_said_so() {
    says(
        "",
        "is not a .prt file: it is empty, but a .prt begins with PRT1 or PRT2",
    );
    says(
        "PRT3\n1\n0\n",
        "is not a .prt file: it begins with `PRT3\\n1\\n0\\n`, but a .prt begins",
    );
    says("\u{1}\u{2}\u{0}IBSP", "is not a .prt");
}

#[test]
fn a_file_that_is_cut_short_ends_before_something() {
    says("PRT1", "ends before the number of clusters");
    says(
        "PRT1\n3\n2\n4 0 1 (10 -1 0) (10 1 0) (10 1 2) (10 -1 2)\n",
        "ends before portal 1 of 2",
    );
    says("PRT2\n2\n2\n0\n0 -1\n", "ends before the leafs of cluster 1 of 2");
    says("PRT1\n3\n0\n7\n", "ends before solid face 0 of 7");
    says("PRT2\n2\n1\n0\n0 -1\n", "ends before the cluster of leaf 1 of 2");
}

#[test]
fn a_word_that_is_no_number_is_shown() {
    says("PRT1\nmany\n0\n", "line 2: `many` is not the number of clusters");
    says("PRT1\n-1\n0\n", "line 2: `-1` is not the number of clusters");
    says(
        "PRT1\n2\n1\n4 0 x (1 2 3)\n",
        "line 4: `x` is not the number of a cluster",
    );
    says("PRT1\n2\n1\n4 0 1 (1 2)\n", "line 4: `)` is not a coordinate");
    says(
        "PRT1\n2\n1\n4 0 1 (1 2 3\n",
        "line 4: the end of the line is not `)`",
    );
    says("PRT1\n2\n1\n4 0 1 1 2 3\n", "line 4: `1` is not `(`");
    says(
        "PRT2\n1\n1\n0\n0\n",
        "line 5: the end of the line is not the number of a leaf",
    );
}

#[test]
fn a_portal_that_is_none_is_named_by_its_line() {
    let one = |line: &str| format!("PRT1\n2\n1\n\n{line}\n");
    says(
        &one(&format!("5 0 1 {DOOR}")),
        "line 5 promises 5 corners, but has 4",
    );
    says(
        &one(&format!("4 0 2 {DOOR}")),
        "line 5: portal 0 leads to cell 2, but there are only 2",
    );
    says(
        &one(&format!("4 1 1 {DOOR}")),
        "line 5: portal 0 leads from cell 1 to itself",
    );
    says(&one("2 0 1 (0 0 0) (1 0 0)"), "line 5: portal 0 has 2 corners");
    says(
        &one("4 0 1 (0 0 0) (8 0 0) (8 8 4) (0 8 0)"),
        "line 5: portal 0 is not flat",
    );
    says(
        &one("4 0 1 (0 0 0) (8 0 0) (1 1 0) (0 8 0)"),
        "line 5: portal 0 is not convex at its corner 2",
    );
    says(
        &one("3 0 1 (0 0 0) (8 0 0) (nan 8 0)"),
        "line 5: portal 0 has a corner coordinate of NaN",
    );
}

#[test]
fn more_than_is_promised_is_refused() {
    says(
        &format!("PRT1\n2\n0\n4 0 1 {DOOR}\n"),
        "line 4: the header promises only 2 clusters and 0 portals",
    );
}

#[test]
fn every_leaf_is_in_one_cluster() {
    says(
        "PRT2\n2\n2\n0\n0 -1\n2 -1\n",
        "line 6: leaf 2 does not exist, and there are 2",
    );
    says(
        "PRT2\n2\n2\n0\n0 1 -1\n1 -1\n",
        "line 6: leaf 1 is in two clusters",
    );
    says(
        "PRT2\n3\n1\n0\n0 2 -1\n",
        "line 5: leaf 2 comes after one that is in no cluster",
    );
}

#[test]
fn a_header_that_promises_billions_takes_no_memory() {
    says(
        "PRT1\n4294967295\n4294967295\n",
        "ends before portal 0 of 4294967295",
    );
    says(
        "PRT2\n4294967295\n1\n0\n0 -1\n",
        "ends before the cluster of leaf 1 of 4294967295",
    );
}

#[test]
fn any_byte_changed_is_read_or_refused_in_words() {
    let text = format!("PRT2\n3\n2\n1\n4 0 1 {DOOR}\n0 2 -1\n1 -1\n");
    let mut refused = 0;
    for at in 0..text.len() {
        for byte in [0, b'-', b'9', b'(', b' ', b'\n', 0xff] {
            let mut bytes = text.clone().into_bytes();
            bytes[at] = byte;
            refused += usize::from(PortalFile::parse(&bytes).is_err());
            refused += usize::from(PortalFile::parse(&bytes[..at]).is_err());
        }
    }
    assert!(refused > text.len());
}

#[test]
fn a_file_that_is_not_there_or_too_large_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("dm9.prt");
    let options = ReadOptions::default();
    let said = |options: &ReadOptions| read_portals(&path, options).expect_err("a refusal").to_string();
    assert!(said(&options).contains("dm9.prt: cannot be read"));
    std::fs::write(&path, "PRT1\n1\n0\n").expect("it is ours");
    assert_eq!(read_portals(&path, &options).expect("a map").cells.count(), 1);
    let small = ReadOptions {
        limit_bytes: 20,
        ..options
    };
    assert!(
        said(&small).contains("its portals would raise the memory needed to 81 bytes"),
        "{}",
        said(&small)
    );
}
