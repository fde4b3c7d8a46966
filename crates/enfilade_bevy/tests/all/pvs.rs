use crate::world::*;
use bevy_math::{Affine3A, Mat3A, Vec3, Vec3A};
use bevy_mesh::Mesh3d;
use bevy_transform::prelude::Transform;
use enfilade::{BakedCells, CellId, CellNode, CellSide, CellTree};
use enfilade_bevy::*;
use std::sync::Arc;

/// Three cells in a row along x, bounded at 0 and 10, in a world with z up: the outer ones see the middle one only.
fn three_cells() -> BakedCells {
    let node = |distance, front, back| CellNode {
        normal: [1.0, 0.0, 0.0],
        distance,
        front,
        back,
    };
    let tree = CellTree {
        root: CellSide::Node(0),
        nodes: vec![
            node(0.0, CellSide::Node(1), CellSide::Cell(CellId(0))),
            node(10.0, CellSide::Node(2), CellSide::Cell(CellId(1))),
            node(20.0, CellSide::Solid, CellSide::Cell(CellId(2))),
        ],
        tolerance: 0.0,
    };
    let rows = [vec![0, 1], vec![0, 1, 2], vec![1, 2]].map(|row| row.into_iter().map(CellId));
    BakedCells::new(tree, &[Some(0), Some(1), Some(2)], rows).expect("three cells")
}

#[test]
fn entities_are_seen_by_the_cells_that_their_boxes_reach_into() {
    let mut app = an_app();
    let ahead = Transform::from_xyz(-5.0, 0.0, 0.0).looking_to(Vec3::X, Vec3::Y);
    let camera = add_camera(&mut app, ahead);
    let small = add_mesh(&mut app, a_box(Vec3::splat(0.5)));
    let [own, next, between, far, in_a_wall] = [-2.0, 5.0, 10.2, 15.0, 25.0].map(|x| {
        let place = Transform::from_xyz(x, 0.0, 0.0);
        app.world_mut().spawn((Mesh3d(small.clone()), place)).id()
    });
    // Y up to Z up: x stays.
    let turn = Mat3A::from_cols(Vec3A::X, Vec3A::Z, Vec3A::NEG_Y);
    let cells_from_world = Affine3A::from_mat3_translation(turn.into(), Vec3::ZERO);
    let pvs = PvsCells {
        cells: Arc::new(three_cells()),
        cells_from_world,
    };
    app.world_mut().entity_mut(camera).insert(pvs);
    let sees = |app: &mut bevy_app::App| {
        app.update();
        let seen = visible(app, camera);
        [own, next, between, far, in_a_wall].map(|entity| seen.contains(&entity))
    };
    // What is in a wall is not known to be hidden.
    assert_eq!(sees(&mut app), [true, true, true, false, true]);
    assert!(
        app.world()
            .resource::<EnfiladeCameras>()
            .visible_set(camera)
            .is_none()
    );
    assert_eq!(app.world().resource::<EnfiladeCameras>().hidden(camera), [far]);
    // It comes into the next cell, and is looked up again.
    let nearer = Transform::from_xyz(9.0, 0.0, 0.0);
    app.world_mut().entity_mut(far).insert(nearer);
    assert_eq!(sees(&mut app), [true; 5]);
    app.world_mut()
        .entity_mut(far)
        .insert(Transform::from_xyz(15.0, 0.0, 0.0));
    assert_eq!(sees(&mut app), [true, true, true, false, true]);
    // The middle cell sees all, and so does what is in no cell.
    for (x, toward, expected) in [
        (-0.1, Vec3::X, false),
        (5.0, Vec3::X, true),
        (30.0, Vec3::NEG_X, true),
    ] {
        let at = Transform::from_xyz(x, 0.0, 0.0).looking_to(toward, Vec3::Y);
        app.world_mut().entity_mut(camera).insert(at);
        app.update();
        assert_eq!(visible(&app, camera).contains(&far), expected, "from {x}");
    }
}
