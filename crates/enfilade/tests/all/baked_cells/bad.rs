//! Invalid planes and visibility rows of baked cells.

use enfilade::{BakedCells, BakedCellsError, CellId, CellNode, CellSide, CellTree};

fn node(front: CellSide, back: CellSide) -> CellNode {
    CellNode {
        normal: [1.0, 0.0, 0.0],
        distance: 0.0,
        front,
        back,
    }
}

const HERE: CellSide = CellSide::Cell(CellId(0));

fn refused(tree: CellTree, row_of: &[Option<u32>], rows: &[&[u32]]) -> String {
    let rows = rows.iter().map(|row| row.iter().copied().map(CellId));
    let why: BakedCellsError = BakedCells::new(tree, row_of, rows).expect_err("it is not sound");
    why.to_string()
}

fn tree(nodes: Vec<CellNode>) -> CellTree {
    CellTree {
        root: CellSide::Node(0),
        nodes,
        tolerance: 0.0,
    }
}

#[test]
fn each_broken_rule_is_told_by_its_number() {
    let mut bent = tree(vec![node(HERE, CellSide::Solid)]);
    for normal in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::INFINITY, 0.0, 0.0]] {
        bent.nodes[0].normal = normal;
        let why = refused(bent.clone(), &[None], &[]);
        assert_eq!(
            why,
            "the plane of node 0 must have finite numbers, and a normal that is not zero"
        );
    }
    let mut far = tree(vec![node(HERE, CellSide::Solid)]);
    far.nodes[0].distance = f64::NAN;
    assert!(refused(far, &[None], &[]).starts_with("the plane of node 0"));
    for tolerance in [-1.0, f64::NAN, f64::INFINITY] {
        let mut vague = tree(vec![node(HERE, CellSide::Solid)]);
        vague.tolerance = tolerance;
        assert!(refused(vague, &[None], &[]).starts_with("a tolerance of"));
    }
    let cases = [
        (vec![], "the root is node 0, but there are only 0"),
        (
            vec![node(CellSide::Node(4), HERE)],
            "in front of node 0 is node 4, but there are only 1",
        ),
        (
            vec![node(HERE, CellSide::Cell(CellId(9)))],
            "behind node 0 is cell 9, but there are only 1",
        ),
        (
            vec![node(HERE, CellSide::Node(0))],
            "node 0 is reached by two paths",
        ),
        (
            vec![node(CellSide::Node(1), CellSide::Node(1)), node(HERE, HERE)],
            "node 1 is reached by two paths",
        ),
        (
            vec![node(CellSide::Node(1), HERE), node(HERE, CellSide::Node(0))],
            "node 0 is reached by two paths",
        ),
    ];
    for (nodes, expected) in cases {
        let why = refused(tree(nodes), &[None], &[]);
        assert!(why.starts_with(expected), "{why}");
    }
    let all = CellTree {
        root: HERE,
        nodes: vec![],
        tolerance: 0.0,
    };
    assert_eq!(
        refused(all.clone(), &[Some(1)], &[&[0]]),
        "cell 0 has row 1, but there are only 1"
    );
    assert_eq!(
        refused(all.clone(), &[Some(0)], &[&[0, 1]]),
        "row 0 names cell 1, but there are only 1"
    );
    assert_eq!(refused(all, &[], &[]), "the root is cell 0, but there are only 0");
}

#[test]
fn rows_are_shared_and_a_cell_without_one_sees_everything() {
    let cells = [0, 1, 2, 3].map(CellId);
    let mut nodes: Vec<CellNode> = (0..3)
        .map(|i| node(CellSide::Node(i + 1), CellSide::Cell(cells[i as usize])))
        .collect();
    nodes[2].front = CellSide::Cell(cells[3]);
    for (at, node) in nodes.iter_mut().enumerate() {
        // Of any length.
        node.normal = [3e200, 0.0, 0.0];
        node.distance = 3e200 * at as f64;
    }
    let rows = [vec![cells[3], cells[1], cells[1]], vec![]];
    let baked = BakedCells::new(tree(nodes), &[Some(0), Some(0), Some(1), None], rows).expect("sound");
    assert_eq!((baked.cell_count(), baked.depth()), (4, 3));
    let seen = cells.map(|from| cells.map(|to| baked.may_see(from, to)));
    assert_eq!(seen[0], [true, true, false, true]);
    assert_eq!(seen[1], [false, true, false, true]);
    assert_eq!(seen[2], [false, false, true, false]);
    assert_eq!(seen[3], [true; 4]);
    let at = [-0.5, 0.0, 1.5, 2.0].map(|x| baked.cell_at([x, 0.0, 0.0]));
    assert_eq!(at, [0, 1, 2, 3].map(|cell| Some(CellId(cell))));
}
