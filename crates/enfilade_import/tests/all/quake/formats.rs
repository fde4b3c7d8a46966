//! One small world in each of the formats.

use super::reads;
use enfilade_bake::{PairsOptions, VisiblePairs};
use enfilade_import::{PortalFile, PrtKind};

const DOORS: [&str; 2] = [
    "(10 -1 0) (10 1 0) (10 1 2) (10 -1 2)",
    "(20.5 -1 0)(20.5 1 0)(20.5 1 2e0)( 20.5 -1 2 ) ",
];

fn three_rooms_in_a_row(file: &PortalFile) {
    assert_eq!(file.cells.count(), 3);
    assert_eq!(file.cells.portals().len(), 2);
    assert_eq!(file.cells.portals()[1].corners[2], [20.5, 1.0, 2.0]);
    assert_eq!(file.cells.portals()[1].cells, [1, 2]);
    let pairs = VisiblePairs::compute(&file.cells, &PairsOptions::default()).expect("little memory");
    assert_eq!(pairs.count(), 6);
}

#[test]
fn prt1_is_clusters_and_portals() {
    let file = reads(&format!("PRT1\n3\n2\n4 0 1 {}\n4 1 2 {}\n", DOORS[0], DOORS[1]));
    assert_eq!(file.kind, PrtKind::Prt1);
    assert_eq!(file.cluster_of_leaf, None);
    three_rooms_in_a_row(&file);
}

#[test]
fn prt2_says_which_leafs_a_cluster_has() {
    let text = format!(
        "PRT2\r\n4\r\n3\r\n2\r\n4 0 1 {}\r\n4 1 2 {}\r\n1 -1\r\n3 0 -1\r\n2 -1\r\n",
        DOORS[0], DOORS[1]
    );
    let file = reads(&text);
    assert_eq!(file.kind, PrtKind::Prt2);
    assert_eq!(file.cluster_of_leaf.as_deref(), Some([1, 0, 2, 1].as_slice()));
    three_rooms_in_a_row(&file);
}

#[test]
fn quake_3_marks_hints_and_adds_solid_faces() {
    let text = format!(
        "PRT1\n3\n2\n1\n4 0 1 0 {}\n4 1 2 1 {}\n3 2 (0 0 0 ) (1 0 0 ) (0 1 0 )",
        DOORS[0], DOORS[1]
    );
    let file = reads(&text);
    assert_eq!(file.kind, PrtKind::Quake3);
    three_rooms_in_a_row(&file);
}

#[test]
fn a_map_of_one_room_has_no_portals() {
    assert_eq!(reads("PRT1\n1\n0\n").cells.count(), 1);
    assert_eq!(reads("PRT2\n2\n1\n0\n0 1 -1\n").cluster_of_leaf, Some(vec![0, 0]));
}
