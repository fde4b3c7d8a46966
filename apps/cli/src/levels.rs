//! `draw --levels`: renders large items with levels of detail.

use crate::measure;
use crate::out;
use crate::prepare::PreparedScene;
use crate::text::count;
use anyhow::Result;
use enfilade::{ItemIndex, Scene, SectorId, View, Viewer};
use enfilade_detail::{DetailOptions, Details};
use enfilade_import::details_of;

/// LODs of a scene's large items, and the scene at full detail.
pub(crate) struct Leveled {
    details: Details,
    full: Scene,
}

/// Items with fewer triangles get no LODs.
const LARGE: u64 = 1000;

/// Maximum number of refinement steps per view; each step builds some LODs.
const MAX_STEPS: usize = 1000;

impl Leveled {
    /// Prepares LODs of the large items of a scene, with a geometric error of at most `pixels` pixels.
    pub(crate) fn new(prepared: &mut PreparedScene, pixels: f32) -> Result<Leveled> {
        let full = prepared.scene.clone();
        let mut options = DetailOptions::default();
        options.tolerance_px = pixels;
        let details = details_of(&mut prepared.scene, LARGE, options)?;
        Ok(Leveled { details, full })
    }

    /// Looks, and builds the LODs that the view needs, until none is pending. Returns a summary for the output line.
    pub(crate) fn settle(
        &mut self,
        prepared: &mut PreparedScene,
        viewer: &mut Viewer,
        view: &View,
    ) -> Result<String> {
        for _ in 0..MAX_STEPS {
            let set = viewer.look(&prepared.scene, view);
            let refined = self.details.refine(&mut prepared.scene, &[set])?;
            for (sector, item, why) in &refined.failed {
                let geometry = self.full.geometry(*sector);
                let name = geometry.map_or("", |geometry| geometry.name(item.index));
                out::warn(format_args!("no LODs for `{name}`: {why}"));
            }
            if refined.changed == 0 && refined.waiting == 0 {
                break;
            }
        }
        viewer.look(&prepared.scene, view);
        let seen = measure::distinct(viewer.visible());
        let triangles = |scene: &Scene| -> u64 {
            let of = |&(sector, item): &(SectorId, ItemIndex)| {
                scene
                    .geometry(sector)
                    .map_or(0, |geometry| geometry.mesh_of(item).triangle_count())
            };
            seen.iter().map(of).sum()
        };
        let [full, now] = [&self.full, &prepared.scene].map(triangles);
        let items = seen.iter().filter(|(sector, item)| {
            let level = self.details.level(*sector, (*item).into()).flatten();
            level.is_some() && !is_occluder(&prepared.scene, *sector, *item)
        });
        Ok(format!(
            "; {} of them with LODs: {} triangles instead of {}",
            items.count(),
            count(now),
            count(full)
        ))
    }
}

/// Whether an item is an occluder, which it is at full detail only: LODs occlude nothing.
fn is_occluder(scene: &Scene, sector: SectorId, item: ItemIndex) -> bool {
    let geometry = scene.geometry(sector);
    geometry.is_some_and(|geometry| geometry.item(item).options.is_occluder)
}
