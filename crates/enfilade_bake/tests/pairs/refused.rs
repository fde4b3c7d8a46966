//! Invalid portals and their errors.

use enfilade_bake::{Cells, Portal};

const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.0, 8.0, 0.0], [0.0, 8.0, 8.0], [0.0, 0.0, 8.0]];

fn refusal(corners: &[[f64; 3]], cells: [u32; 2]) -> String {
    let good = Portal {
        corners: SQUARE.to_vec(),
        cells: [0, 1],
    };
    let portal = Portal {
        corners: corners.to_vec(),
        cells,
    };
    let error = Cells::new(2, vec![good, portal]).expect_err("an invalid portal");
    assert_eq!(error.portal(), 1);
    error.to_string()
}

#[test]
fn a_portal_is_refused_by_number_and_rule() {
    let [a, b, c, d] = SQUARE;
    assert_eq!(
        refusal(&[a, b], [0, 1]),
        "portal 1 has 2 corners; at least 3 are needed"
    );
    assert_eq!(
        refusal(&SQUARE, [0, 2]),
        "portal 1 leads to cell 2, but there are only 2"
    );
    assert_eq!(refusal(&SQUARE, [1, 1]), "portal 1 leads from cell 1 to itself");
    assert_eq!(refusal(&[a, b, [0.0, 16.0, 0.0]], [0, 1]), "portal 1 has no area");
    assert_eq!(
        refusal(&[a, b, [2.0, 8.0, 8.0], d], [0, 1]),
        "portal 1 is not flat: a corner is 0.492 units off its plane"
    );
    assert_eq!(
        refusal(&[a, b, [0.0, 1.0, 1.0], d], [0, 1]),
        "portal 1 is not convex at its corner 2"
    );
    assert_eq!(
        refusal(&[a, a, b, c], [0, 1]),
        "portal 1 is not convex at its corner 0"
    );
    for at in [f64::NAN, f64::INFINITY, -1e30] {
        assert!(refusal(&[a, b, [0.0, 8.0, at]], [0, 1]).contains("coordinates must be within ±10,000,000"));
    }
}

#[test]
fn corners_snapped_by_a_twentieth_of_a_unit_are_taken() {
    let [a, b, c, d] = SQUARE;
    let snapped = Portal {
        corners: vec![a, b, [0.05, c[1], c[2]], d],
        cells: [0, 1],
    };
    assert_eq!(
        Cells::new(2, vec![snapped]).expect("flat enough").portals().len(),
        1
    );
}
