//! The occluders of a look: polygons that its method selected, or boxes of the items whose faces its cover took.

use crate::places::root_from_sector;
use crate::session::{LookKey, Session};
use enfilade::{
    Aabb, Alpha, Canvas, Geometry, ItemIndex, LookStep, Passage, PassageId, Scene, SectorId, Span, Transform,
    Viewer,
};
use std::collections::BTreeSet;

/// Most boxes that are drawn: those of the nearest items.
const MAX_BOXES: usize = 2000;

/// One occluder.
pub(crate) struct Occluder {
    /// The passage whose cover it is in.
    pub(crate) passage: PassageId,
    /// Maps the space of the outline to that of the camera's sector.
    pub(crate) root_from_sector: Transform,
    pub(crate) outline: Outline,
}

pub(crate) enum Outline {
    Polygon(Vec<[f32; 3]>),
    Box(Aabb),
}

/// The occluders of the last look, found again when the look has changed.
#[derive(Default)]
pub(crate) struct Occluders {
    of: Option<LookKey>,
    viewer: Viewer,
    all: Vec<Occluder>,
}

impl Occluders {
    /// Returns the occluders of the last look of a session.
    pub(crate) fn of(&mut self, session: &Session) -> &[Occluder] {
        if self.of != Some(session.key()) {
            self.of = Some(session.key());
            self.viewer.options = session.viewer.options;
            let scene = &session.world.scene;
            let steps = self
                .viewer
                .look_steps(scene, &session.view, usize::MAX, &mut Nothing);
            self.all = self.found(session, scene, &steps);
        }
        &self.all
    }

    fn found(&self, session: &Session, scene: &Scene, steps: &[LookStep]) -> Vec<Occluder> {
        let passages = self.viewer.visible().passages();
        let mut boxes: BTreeSet<(PassageId, ItemIndex)> = BTreeSet::new();
        let mut all = Vec::new();
        for step in steps {
            let passage = &passages[step.passage().0 as usize];
            let outline = match step {
                LookStep::Occluder { corners, .. } => Outline::Polygon(corners.clone()),
                LookStep::Cluster { item, .. } if takes_faces(scene, passage.sector) => {
                    let Some(geometry) = scene.geometry(passage.sector) else {
                        continue;
                    };
                    let is_new = boxes.len() < MAX_BOXES
                        && hides(geometry, *item)
                        && boxes.insert((step.passage(), *item));
                    if !is_new {
                        continue;
                    }
                    Outline::Box(geometry.item(*item).bounds)
                }
                _ => continue,
            };
            all.push(Occluder {
                passage: step.passage(),
                root_from_sector: root_from_sector(&session.view, passage),
                outline,
            });
        }
        all
    }
}

/// Whether the cover of a sector's method takes the faces that a look finds.
fn takes_faces(scene: &Scene, sector: SectorId) -> bool {
    let method = scene.method(sector);
    method.is_some_and(|method| !method.cover().is_empty() && method.occluders().unwrap_or(0) == 0)
}

/// Whether an item has faces that hide.
fn hides(geometry: &Geometry, item: ItemIndex) -> bool {
    let mut clusters = geometry.mesh_of(item).clusters().iter();
    geometry.item(item).options.is_occluder
        && clusters.any(|cluster| geometry.material_of(item, cluster).alpha == Alpha::Opaque)
}

/// A canvas for looks whose picture is not wanted.
struct Nothing;

impl Canvas for Nothing {
    fn enter(&mut self, _: PassageId, _: &Passage) {}

    fn row(&mut self, _: u16, _: &[Span]) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::World;
    use enfilade::Method;

    #[test]
    fn polygons_where_the_method_selects_them_and_boxes_where_it_takes_faces() {
        let mut session = Session::new(World::open("@enfilade").expect("a built-in scene"));
        session.look([320, 240]);
        let mut occluders = Occluders::default();
        for (method, are_polygons) in [(Method::Masked, false), (Method::Svbsp, true)] {
            session.set_method(method, None).expect("it suits the palace");
            let all = occluders.of(&session);
            assert!(all.len() > 10, "{method}: {}", all.len());
            for occluder in all {
                let is_polygon = matches!(&occluder.outline, Outline::Polygon(corners) if corners.len() > 2);
                assert_eq!(is_polygon, are_polygons, "{method}");
            }
        }
    }
}
