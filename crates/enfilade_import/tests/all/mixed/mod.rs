//! A house in a valley, where `ENFILADE_SCENES` names the folder of real scenes: land and house each by its own method.

#[path = "../../../benches/common/land.rs"]
mod land;

use enfilade::laws::{OwnerPicture, Reference};
use enfilade::{Method, Viewer};
use land::{INSIDE, OUTSIDE, house_in_a_valley};
use std::path::Path;

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn from_its_windows_the_hills_are_seen_and_from_the_hills_its_rooms() {
    let folder = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    let methods = [Method::FloatingHorizon, Method::HierarchicalZ];
    let (mixed, views) = house_in_a_valley(Path::new(&folder), methods, [160, 90]);
    let alone = mixed
        .with_method(Method::ZBuffer, Method::DEFAULT_LIMIT)
        .expect("it takes any geometry");
    let reference = Reference::new(&mixed);
    let [mut viewer, mut viewer_alone] = [(); 2].map(|()| Viewer::new());
    let mut through = [0; 2];
    for view in &views {
        let truth = reference.see(&mixed, view, &viewer.options.limits);
        let mut pictures = [(); 2].map(|()| OwnerPicture::new(view.size()));
        for (place, (viewer, scene)) in [(&mut viewer, &mixed), (&mut viewer_alone, &alone)]
            .into_iter()
            .enumerate()
        {
            viewer.draw(scene, view, &mut pictures[place]);
            let verdict = truth.check(viewer.visible(), Some(&pictures[place]));
            assert_eq!(verdict.missed, [], "{view:?}");
            assert_eq!(verdict.pixels_different, 0, "{view:?}");
        }
        let passages = viewer.visible().passages();
        let crosses = |to| {
            passages
                .iter()
                .any(|passage| passage.crossings > 0 && passage.sector == to)
        };
        through[0] += usize::from(crosses(INSIDE));
        through[1] += usize::from(crosses(OUTSIDE));
    }
    let openings = views.len() / 2;
    assert!(
        through.iter().all(|&views| views >= openings / 2),
        "of {openings} openings, looked through: {through:?}"
    );
}
