//! Trees as deep as their number of nodes, very large coordinates, and items in every cell.

use super::{HOUSE, SIZE, names};
use enfilade::{
    BakedCells, CellId, CellNode, CellSide, CellTree, GeometryBuilder, MAX_COORDINATE, Material, MaterialId,
    Mesh, Method, Scene, SceneBuilder, Transform, View,
};

/// Planes across x, one below the other in the tree; behind each is a cell, and in front the next plane.
fn chain(count: u32, distance: impl Fn(u32) -> f64, tolerance: f64) -> BakedCells {
    let node = |number: u32| CellNode {
        normal: [1.0, 0.0, 0.0],
        distance: distance(number),
        front: if number + 1 < count {
            CellSide::Node(number + 1)
        } else {
            CellSide::Cell(CellId(count))
        },
        back: CellSide::Cell(CellId(number)),
    };
    let tree = CellTree {
        root: CellSide::Node(0),
        nodes: (0..count).map(node).collect(),
        tolerance,
    };
    // An empty row: from each cell only the cell itself is potentially visible.
    let row_of = vec![Some(0); count as usize + 1];
    BakedCells::new(tree, &row_of, [[]]).expect("a chain is a tree")
}

/// A sheet perpendicular to the view direction with this extent along x, and small ones at 10.5, 500.5 and 9,000.5.
fn scene(cells: BakedCells, reach: [f32; 2]) -> Scene {
    let material = Material {
        double_sided: true,
        ..Material::opaque([0.5; 3])
    };
    let mut geometry = GeometryBuilder::new([material]);
    let mut add = |name: &str, [low, high]: [f32; 2]| {
        let corners = [
            [low, -1.0, -4.0],
            [high, -1.0, -4.0],
            [high, 1.0, -4.0],
            [low, 1.0, -4.0],
        ];
        let mesh = Mesh::triangles(&corners, &[0, 1, 2, 0, 2, 3], MaterialId(0)).expect("a sheet");
        let mesh = geometry.mesh(mesh);
        geometry.item(name, mesh, Transform::IDENTITY);
    };
    add("long", reach);
    for at in [10.5_f32, 500.5, 9_000.5] {
        add(&format!("at {at}"), [at - 0.25, at + 0.25]);
    }
    geometry.cells(cells);
    let mut scene = SceneBuilder::new();
    scene.add("hall", geometry.build().expect("sound"), Method::Pvs);
    scene.build().expect("small")
}

fn seen(scene: &Scene, x: f32) -> Vec<String> {
    names(
        scene,
        &View::new([x, 0.0, 0.0], [x, 0.0, -4.0], SIZE).expect("a valid view"),
    )
}

#[test]
fn a_tree_of_a_hundred_thousand_planes_in_a_row_is_walked_without_recursion() {
    let scene = scene(chain(100_000, f64::from, 0.0), [-10.0, 20_000.0]);
    for (x, name) in [
        (10.5, "1 at 10.5"),
        (500.5, "2 at 500.5"),
        (9_000.5, "3 at 9000.5"),
    ] {
        assert_eq!(seen(&scene, x), ["0 long", name]);
    }
    // On the plane in front of the sheet both cells count. From another cell nothing else is potentially visible,
    // though it is in the frustum.
    assert_eq!(seen(&scene, 10.0), ["0 long", "1 at 10.5"]);
    assert_eq!(seen(&scene, 11.5), ["0 long"]);
    assert_eq!(scene.build_stats().depth, 100_000);
}

#[test]
fn a_hundred_thousand_times_the_same_plane_ends_too() {
    let scene = scene(chain(100_000, |_| 0.0, 0.0), [-10.0, 20_000.0]);
    assert_eq!(seen(&scene, 500.5), ["0 long", "2 at 500.5"]);
    assert_eq!(seen(&scene, 0.0).len(), 1);
    // All planes are within the tolerance of everything, so each query touches all cells.
    let scene = self::scene(chain(100_000, |_| 0.0, 1e9), [-10.0, 20_000.0]);
    assert_eq!(seen(&scene, 10.5), ["0 long", "1 at 10.5"]);
}

#[test]
fn planes_as_far_out_as_there_are_numbers_do_no_harm() {
    for far in [1e6_f32, 1e12, 1e30, 3e38] {
        let reach = far.min(MAX_COORDINATE);
        let scene = scene(
            chain(2000, |number| f64::from(number) * f64::from(far), 0.0),
            [-reach, reach],
        );
        assert_eq!(seen(&scene, 500.5), ["0 long", "2 at 500.5"], "{far}");
        let scene = self::scene(chain(2000, f64::from, 0.0), [-reach, reach]);
        assert_eq!(seen(&scene, 500.5), ["0 long", "2 at 500.5"], "{far}");
    }
    let geometry_of = |scene: &Scene| {
        scene
            .geometry(HOUSE)
            .expect("ours")
            .cells()
            .expect("baked")
            .cell_count()
    };
    assert_eq!(geometry_of(&scene(chain(5, f64::from, 0.0), [0.0, 1.0])), 6);
}
