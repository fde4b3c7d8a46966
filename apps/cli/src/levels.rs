//! Levels of detail in a picture.

use crate::measure;
use crate::out;
use crate::prepare::Prepared;
use crate::text::count;
use anyhow::Result;
use enfilade::{DetailOptions, Details, ItemId, Scene, SectorId, View, Viewer};
use enfilade_import::details_of;

/// A scene's large items, by levels, and what they were.
pub(crate) struct Leveled {
    details: Details,
    full: Scene,
}

/// Items of fewer triangles are drawn as they are.
const LARGE: u64 = 1000;

/// Steps until a view has all it wants, at most; each builds something.
const MAX_STEPS: usize = 1000;

impl Leveled {
    /// Has the large items of a scene drawn by levels that are off by so many pixels at most.
    pub(crate) fn new(prepared: &mut Prepared, pixels: f32) -> Result<Leveled> {
        let full = prepared.scene.clone();
        let mut options = DetailOptions::default();
        options.tolerance_px = pixels;
        let details = details_of(&mut prepared.scene, LARGE, options)?;
        Ok(Leveled { details, full })
    }

    /// Looks, and has what is wanted made, until nothing waits. Says what came of it.
    pub(crate) fn settle(
        &mut self,
        prepared: &mut Prepared,
        viewer: &mut Viewer,
        view: &View,
    ) -> Result<String> {
        for _ in 0..MAX_STEPS {
            let set = viewer.look(&prepared.scene, view);
            let refined = self.details.refine(&mut prepared.scene, &[set])?;
            for (sector, item, why) in &refined.failed {
                let geometry = self.full.geometry(*sector);
                let name = geometry.map_or("", |geometry| geometry.name(*item));
                out::warn(format_args!("no coarser levels of detail for `{name}`: {why}"));
            }
            if refined.changed == 0 && refined.waiting == 0 {
                break;
            }
        }
        viewer.look(&prepared.scene, view);
        let seen = measure::distinct(viewer.visible());
        let triangles = |scene: &Scene| -> u64 {
            let of = |&(sector, item): &(SectorId, ItemId)| {
                scene
                    .geometry(sector)
                    .map_or(0, |geometry| geometry.mesh_of(item).triangle_count())
            };
            seen.iter().map(of).sum()
        };
        let [full, now] = [&self.full, &prepared.scene].map(triangles);
        let items = seen.iter().filter(|(sector, item)| {
            let level = self.details.level(*sector, *item).flatten();
            level.is_some() && !hides(&prepared.scene, *sector, *item)
        });
        Ok(format!(
            "; {} of them by coarser levels: {} triangles in place of {}",
            items.count(),
            count(now),
            count(full)
        ))
    }
}

/// Is an item drawn as it is? Coarser levels hide nothing.
fn hides(scene: &Scene, sector: SectorId, item: ItemId) -> bool {
    let geometry = scene.geometry(sector);
    geometry.is_some_and(|geometry| geometry.item(item).is_occluder)
}
