//! Looks of many views at once.

use enfilade::{Method, View, Viewer, ViewerOptions, Viewers, VisibleSet};
use enfilade_scenes::{BuiltIn, Random, built_in, parallel_view};

type Seen = (Vec<(u32, Option<u32>)>, Vec<(u32, u64, Vec<u32>)>);

/// Passages by sector and parent, and items by passage and key with their clusters.
fn seen(set: &VisibleSet) -> Seen {
    let passages = set.passages().iter();
    let items = set.items().iter();
    (
        passages
            .map(|passage| (passage.sector.0, passage.parent.map(|parent| parent.0)))
            .collect(),
        items
            .map(|item| (item.passage.0, item.key, set.clusters(item).to_vec()))
            .collect(),
    )
}

#[test]
fn views_at_once_see_what_each_sees_alone() {
    let mut random = Random::new(310);
    for name in ["two-rooms", "mirrors", "teleport", "enfilade"] {
        let BuiltIn { scene, cameras } = built_in(name).expect("a built-in scene");
        let views: Vec<View> = cameras
            .iter()
            .flat_map(|camera| {
                let parallel = parallel_view(camera, [64, 36], &mut random);
                [camera.view([96, 54]).expect("a valid view"), parallel]
            })
            .collect();
        for method in [Method::Masked, Method::HierarchicalZ, Method::Svbsp] {
            let scene = scene.with_method(method, u64::MAX).expect("a small scene");
            let mut alone: Vec<Viewer> = views.iter().map(|_| Viewer::new()).collect();
            let mut together = Viewers::new();
            // With temporal coherence, then without: the cameras change places.
            for views in [
                views.clone(),
                views.clone(),
                views.iter().rev().copied().collect(),
            ] {
                let sets = together.look_many(&scene, &views);
                for ((viewer, view), set) in alone.iter_mut().zip(&views).zip(sets) {
                    let single = viewer.look(&scene, view);
                    assert_eq!(seen(single), seen(set), "@{name} by {method}, {view:?}");
                    assert_eq!(single.complete(), set.complete());
                }
            }
        }
    }
}

#[test]
fn a_server_knows_whom_a_player_sees_through_the_open_door() {
    let BuiltIn { mut scene, cameras } = built_in("two-rooms").expect("a built-in scene");
    let options = ViewerOptions {
        margin_px: 0.5,
        ..ViewerOptions::default()
    };
    let view = cameras[0].view([256, 144]).expect("a valid view");
    let home = scene.sector_of(&view).expect("an eye in a room");
    let mut players = Viewers::with_options(options);
    let beyond = |set: &VisibleSet| {
        let items = set.items().iter();
        let others = items.filter(|item| set.passage(item.passage).sector != home);
        others
            .map(|item| (set.passage(item.passage).sector, item.item))
            .collect::<Vec<_>>()
    };
    let seen = beyond(&players.look_many(&scene, &[view, view])[1]);
    assert!(!seen.is_empty(), "nothing is seen through the door");
    let set = &players.visible()[0];
    assert!(seen.iter().all(|&(sector, item)| set.sees(sector, item)));
    let portals: Vec<_> = (0..scene.portals().len() as u32)
        .map(enfilade::PortalId)
        .collect();
    for portal in portals {
        scene.set_open(portal, false);
    }
    let set = &players.look_many(&scene, &[view])[0];
    assert!(!set.items().is_empty() && seen.iter().all(|&(sector, item)| !set.sees(sector, item)));
}
