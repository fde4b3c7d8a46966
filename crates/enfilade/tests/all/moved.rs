//! A camera that moves slightly costs as much as a still one plus the geometry that has appeared.

use enfilade::{ItemIndex, Method, Scene, Viewer};
use enfilade_scenes::built_in;
use std::collections::BTreeMap;

/// Number of triangles of each cluster visible in the last look.
fn clusters(viewer: &Viewer, scene: &Scene) -> BTreeMap<(u32, ItemIndex, u32), u64> {
    let set = viewer.visible();
    let mut all = BTreeMap::new();
    for item in set.items() {
        let sector = set.passage(item.passage).sector;
        let mesh = scene.geometry(sector).expect("of ours").mesh_of(item.item.index);
        let only = [0];
        let seen = set.clusters(item);
        for &cluster in if seen.is_empty() { &only[..] } else { seen } {
            let faces = mesh.clusters()[cluster as usize].faces.clone();
            all.insert(
                (sector.0, item.item.index, cluster),
                u64::from(faces.end - faces.start),
            );
        }
    }
    all
}

#[test]
fn a_moved_camera_costs_no_more_than_a_still_one_and_what_appeared() {
    let built = built_in("enfilade").expect("the palace");
    for method in [Method::HierarchicalZ, Method::HierarchicalS] {
        let scene = built
            .scene
            .with_method(method, Method::DEFAULT_LIMIT)
            .expect("it fits");
        let (mut still, mut moved, mut appeared) = (0, 0, 0);
        for camera in built.cameras.iter().take(6) {
            let at = camera.view([320, 180]);
            let step = |number: u8| {
                let far = 0.02 * f32::from(number);
                let on = |[x, y, z]: [f32; 3]| [x + far, y, z + 0.5 * far];
                let mut view = at;
                [view.eye, view.toward] = [on(at.eye), on(at.toward)];
                view
            };
            let mut viewer = Viewer::new();
            for number in 0..8 {
                viewer.look(&scene, &step(number));
                viewer.look(&scene, &step(number));
                still += viewer.stats().triangles;
                let before = clusters(&viewer, &scene);
                viewer.look(&scene, &step(number + 1));
                moved += viewer.stats().triangles;
                let now = clusters(&viewer, &scene);
                let new = now.iter().filter(|(cluster, _)| !before.contains_key(cluster));
                appeared += new.map(|(_, triangles)| triangles).sum::<u64>();
            }
        }
        assert!(appeared > 0, "{method}: nothing appeared");
        assert!(
            moved <= still + still / 50 + appeared,
            "{method}: {moved} after {still}, and {appeared} appeared"
        );
    }
}
