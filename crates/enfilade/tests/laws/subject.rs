//! The scenes under test, and the viewer options.

use enfilade::laws::OwnerPicture;
use enfilade::{Limits, Method, Scene, View, Viewer, VisibleSet};
use enfilade_scenes::{BuiltIn, CatalogEntry, SCENES};
use std::collections::BTreeSet;
use std::sync::LazyLock;

pub(crate) const SIZE: [u32; 2] = [128, 72];
pub(crate) const LIMIT: u64 = Method::DEFAULT_LIMIT;

/// Maximum number of crossings for all methods and the reference: two facing mirrors would recurse forever.
pub(crate) fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_crossings = 6;
    limits
}

pub(crate) fn viewer() -> Viewer {
    let mut viewer = Viewer::new();
    viewer.options.limits = limits();
    viewer
}

fn seen_by(method: Method, scene: &Scene) -> Scene {
    scene
        .with_method(method, LIMIT)
        .expect("the scenes of the laws are small")
}

/// A scene under test.
pub(crate) struct Subject {
    pub(crate) name: &'static str,
    pub(crate) built: BuiltIn,
    /// The scene with each method that suits it.
    pub(crate) seen: Vec<(Method, Scene)>,
}

impl Subject {
    pub(crate) fn new(name: &'static str, built: BuiltIn) -> Subject {
        let suits = |method: &Method| built.scene.suits(*method);
        let seen = Method::ALL.into_iter().filter(suits);
        let seen = seen
            .map(|method| (method, seen_by(method, &built.scene)))
            .collect();
        Subject { name, built, seen }
    }

    pub(crate) fn seen_by(&self, wanted: Method) -> &Scene {
        let mut all = self.seen.iter();
        let (_, scene) = all
            .find(|(method, _)| *method == wanted)
            .expect("a method that suits it");
        scene
    }

    pub(crate) fn camera(&self, name: &str) -> View {
        let mut cameras = self.built.cameras.iter();
        let camera = cameras.find(|camera| camera.name == name);
        let camera = camera.expect("a camera of that scene");
        camera.view(SIZE).expect("a valid view")
    }
}

/// All built-in scenes. Built once, as some take a second.
pub(crate) fn subjects() -> &'static [Subject] {
    static SUBJECTS: LazyLock<Vec<Subject>> = LazyLock::new(|| {
        let build = |named: &CatalogEntry| Subject::new(named.name, named.build());
        SCENES.iter().map(build).collect()
    });
    &SUBJECTS
}

pub(crate) fn subject(name: &str) -> &'static Subject {
    let mut all = subjects().iter();
    all.find(|subject| subject.name == name)
        .expect("a built-in scene")
}

pub(crate) fn drawn(viewer: &mut Viewer, scene: &Scene, view: &View) -> OwnerPicture {
    let mut picture = OwnerPicture::new(view.size());
    viewer.draw(scene, view, &mut picture);
    picture
}

/// Returns the set as names, for comparison: SECTOR/ITEM.
pub(crate) fn names(scene: &Scene, set: &VisibleSet) -> BTreeSet<String> {
    let name = |item: &enfilade::VisibleItem| {
        let sector = set.passage(item.passage).sector;
        let geometry = scene
            .geometry(sector)
            .expect("built-in scenes have no custom sectors");
        format!("{}/{}", scene.sector_name(sector), geometry.name(item.item.index))
    };
    set.items().iter().map(name).collect()
}
