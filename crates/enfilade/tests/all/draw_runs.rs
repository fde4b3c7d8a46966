//! Draw data of visible sets, compared with the clusters and items that they list.

use enfilade::{DrawRun, Method, PassageId, Viewer, VisibleItem};
use enfilade_scenes::built_in;
use std::collections::BTreeSet;

const SIZE: [u32; 2] = [160, 90];

/// Calls `check` with the visible sets of several scenes, one with large meshes, one with doors, one with glass.
fn looks(mut check: impl FnMut(&enfilade::Scene, &enfilade::VisibleSet)) {
    let mut viewer = Viewer::new();
    for name in ["big-mesh", "two-rooms", "glass", "crowd"] {
        let built = built_in(name).expect("it is built in");
        let masked = built.scene.with_method(Method::Masked, Method::DEFAULT_LIMIT);
        let masked = masked.expect("it takes any geometry");
        for camera in built.cameras.iter().take(4) {
            for scene in [&built.scene, &masked] {
                check(
                    scene,
                    viewer.look(scene, &camera.view(SIZE).expect("a valid view")),
                );
            }
        }
    }
}

#[test]
fn the_runs_of_an_item_draw_its_visible_clusters_and_nothing_else() {
    let [mut merged, mut partial] = [0; 2];
    let mut runs: Vec<DrawRun> = Vec::new();
    looks(|scene, set| {
        for item in set.items() {
            let geometry = scene
                .geometry(set.passage(item.passage).sector)
                .expect("one of ours");
            let mesh = geometry.mesh_of(item.item.index);
            let some = set.clusters(item);
            let all: Vec<u32> = (0..mesh.clusters().len() as u32).collect();
            let clusters = if some.is_empty() { &all[..] } else { some };
            let mut expected = BTreeSet::new();
            for &cluster in clusters {
                let material = mesh.clusters()[cluster as usize].material;
                expected.extend(
                    mesh.cluster_indices(cluster as usize)
                        .map(|index| (material, index)),
                );
            }
            set.draw_runs(item, mesh, &mut runs);
            let drawn: Vec<_> = (runs.iter())
                .flat_map(|run| run.indices.clone().map(|index| (run.material, index)))
                .collect();
            // In order and without repeats.
            assert!(drawn.iter().eq(&expected), "{item:?}: {runs:?}");
            let are_apart = |pair: &[DrawRun]| {
                pair[0].material < pair[1].material || pair[0].indices.end < pair[1].indices.start
            };
            assert!(runs.windows(2).all(are_apart), "{item:?}: {runs:?}");
            merged += usize::from(runs.len() < clusters.len());
            partial += usize::from(clusters.len() < all.len());
            let capacity = runs.capacity();
            set.draw_runs(item, mesh, &mut runs);
            assert_eq!(runs.capacity(), capacity);
        }
    });
    assert!(merged > 10 && partial > 10, "{merged} merged, {partial} partial");
}

#[test]
fn instances_are_the_items_of_a_passage_by_mesh() {
    let mut shared = 0;
    let mut sorted: Vec<VisibleItem> = Vec::new();
    looks(|scene, set| {
        let mut total = 0;
        for (id, passage) in (0..).map(PassageId).zip(set.passages()) {
            let geometry = scene.geometry(passage.sector).expect("one of ours");
            let mut last = None;
            for (mesh, items) in set.instances(id, geometry, &mut sorted) {
                assert!(last < Some(mesh), "{mesh:?} comes twice");
                last = Some(mesh);
                assert!(!items.is_empty() && items.windows(2).all(|pair| pair[0].item < pair[1].item));
                for item in items {
                    assert_eq!((item.passage, geometry.item(item.item.index).mesh), (id, mesh));
                    assert!(set.items().contains(item));
                }
                total += items.len();
                shared += usize::from(items.len() > 1);
            }
        }
        // Each is listed once, and none is lost.
        assert_eq!(total, set.items().len());
    });
    assert!(shared > 10, "{shared} meshes have several instances");
}
