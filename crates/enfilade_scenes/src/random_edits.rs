//! Edits at random, for properties that must hold of a scene however it was changed.

use crate::random::Random;
use enfilade::{EditStats, Geometry, ItemId, Scene, SceneError, SectorId, Transform};
use std::sync::Arc;

/// So many edits at random, all done at once: things go, come as copies of others, move near and far, turn, are mirrored and
/// flattened, become copies of other meshes, and hide or do not. The same for the same scene and numbers. Where a sector
/// has more items than `at_first`, by sector, more go than come.
///
/// # Errors
/// As [`Edit::finish`](enfilade::Edit::finish).
pub fn random_edits(
    scene: &mut Scene,
    count: usize,
    at_first: &[usize],
    random: &mut Random,
) -> Result<EditStats, SceneError> {
    let has_items = |id: &SectorId| {
        scene
            .geometry(*id)
            .is_some_and(|geometry| !geometry.items().is_empty())
    };
    let sectors: Vec<SectorId> = scene.sectors().filter(has_items).collect();
    let mut edit = scene.edit();
    for _ in 0..count {
        let sector = random.pick(&sectors);
        let Some(geometry) = edit.scene().geometry(sector) else {
            continue;
        };
        let item = ItemId(random.below(geometry.items().len()) as u32);
        let other = ItemId(random.below(geometry.items().len()) as u32);
        let [mesh, other_mesh] =
            [item, other].map(|item| Arc::clone(&geometry.meshes()[geometry.item(item).mesh.0 as usize]));
        let name = geometry.name(item).to_owned();
        let there = elsewhere(geometry, item, random);
        let is_there = geometry.holds(item);
        let crowded = geometry.item_count() > at_first[sector.0 as usize];
        // Some cannot be: of what has gone already, or would have no faces. Then nothing is asked for.
        let _ = match random.below(10) {
            0 if crowded => edit.remove(sector, item),
            0 | 1 if is_there => edit.add(sector, &name, mesh, there).map(|_| ()),
            2 => edit.remove(sector, item),
            3 => edit.set_mesh(sector, item, other_mesh),
            4 => edit.set_occluder(sector, item, random.below(3) > 0),
            _ => edit.set_transform(sector, item, there),
        };
    }
    edit.finish()
}

/// Where something may be moved to: near, anywhere in the sector or a little outside, turned, mirrored, flattened.
fn elsewhere(geometry: &Geometry, item: ItemId, random: &mut Random) -> Transform {
    let held = geometry.bounds();
    let size = held.size();
    let place = geometry.item(item).transform();
    let step = match random.below(3) {
        0 => size.map(|side| (random.unit() - 0.5) * 0.02 * side),
        _ => {
            let middle = geometry.item(item).bounds.center();
            [0, 1, 2].map(|axis| held.min[axis] + (1.2 * random.unit() - 0.1) * size[axis] - middle[axis])
        }
    };
    let turn = match random.below(12) {
        0 => Transform::rotation([1.0, 2.0, 3.0], f64::from(random.unit()) * 6.0),
        1 => Transform::from_columns([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]),
        2 => Transform::from_columns([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]),
        _ => Transform::IDENTITY,
    };
    // Turned where it stands.
    let middle = geometry.item(item).bounds.center();
    let there = [0, 1, 2].map(|axis| middle[axis] + step[axis]);
    let back = middle.map(|value| -value);
    Transform::translation(there) * turn * Transform::translation(back) * place
}
