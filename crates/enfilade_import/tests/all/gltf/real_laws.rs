//! Every law, with every method that suits, on real scenes.

use enfilade::{Camera, Limits, Method, laws, survey};
use enfilade_import::{ReadOptions, read};
use std::path::Path;

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn the_laws_hold_in_real_buildings_and_a_city() {
    let folder = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    for name in [
        "blender_villa",
        "ifc_fzk_haus",
        "ifc_duplex",
        "classroom",
        "city_etoile",
    ] {
        let file = Path::new(&folder).join(name).with_extension("glb");
        let import = read(&file, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        let scene = import.scene(Method::HierarchicalZ, Method::DEFAULT_LIMIT);
        let scene = scene.expect("it fits");
        let views = survey(&scene, 3).views.into_iter().map(|place| {
            let camera = Camera {
                sector: Some(place.sector),
                ..Camera::new(place.eye, place.toward)
            };
            camera.view([64, 36]).expect("a valid view")
        });
        let report = laws::check(&scene, &views.collect::<Vec<_>>(), Limits::default());
        let broken: Vec<String> = report.broken.iter().map(ToString::to_string).collect();
        assert!(broken.is_empty(), "{name}:\n{}", broken.join("\n"));
        assert!(report.visible > 10, "{name}: {} visible", report.visible);
    }
}
