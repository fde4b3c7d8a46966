//! Random edits, to test properties that must hold for every edited scene.

use crate::random::Random;
use enfilade::{EditStats, Geometry, ItemIndex, ItemOptions, Scene, SceneError, SectorId, Transform};
use std::sync::Arc;

/// Applies `count` random edits in one transaction: adds copies of items, removes, moves, rotates, mirrors, flattens,
/// swaps meshes, and changes which items are occluders. The edits depend on the scene, `at_first` and `random` only.
///
/// `at_first` holds a number of items for each sector: while a sector has more items, removals outnumber additions.
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
        let item = ItemIndex(random.below(geometry.items().len()) as u32);
        let other = ItemIndex(random.below(geometry.items().len()) as u32);
        let [mesh, other_mesh] =
            [item, other].map(|item| Arc::clone(&geometry.meshes()[geometry.item(item).mesh.0 as usize]));
        let name = geometry.name(item).to_owned();
        let there = elsewhere(geometry, item, random);
        let is_there = geometry.holds(item);
        let id = geometry.id_of(item);
        let before = at_first.get(sector.0 as usize).copied().unwrap_or(0);
        let crowded = geometry.item_count() > before;
        // Edits of removed items, and edits that leave an item without faces, return an error and change nothing.
        let _ = match random.below(10) {
            0 if crowded => edit.remove(sector, id),
            0 | 1 if is_there => edit.add(sector, &name, mesh, there).map(|_| ()),
            2 => edit.remove(sector, id),
            3 => edit.set_mesh(sector, id, other_mesh),
            4 => {
                let is_occluder = random.below(3) > 0;
                let options = ItemOptions {
                    is_occluder,
                    ..geometry.item(item).options
                };
                edit.set_options(sector, id, options)
            }
            _ => edit.set_transform(sector, id, there),
        };
    }
    edit.finish()
}

/// Returns a random transform for an item: moved a little or anywhere in and around the sector's bounds, and sometimes
/// rotated, mirrored or flattened.
fn elsewhere(geometry: &Geometry, item: ItemIndex, random: &mut Random) -> Transform {
    let bounds = geometry.bounds();
    let size = bounds.size();
    let transform = geometry.item(item).transform();
    let step = match random.below(3) {
        0 => size.map(|side| (random.unit() - 0.5) * 0.02 * side),
        _ => {
            let middle = geometry.item(item).bounds.center();
            [0, 1, 2].map(|axis| bounds.min[axis] + (1.2 * random.unit() - 0.1) * size[axis] - middle[axis])
        }
    };
    let turn = match random.below(12) {
        0 => Transform::rotation([1.0, 2.0, 3.0], f64::from(random.unit()) * 6.0),
        1 => Transform::from_columns([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]),
        2 => Transform::from_columns([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]),
        _ => Transform::IDENTITY,
    };
    // Rotates about the item's centre.
    let middle = geometry.item(item).bounds.center();
    let there = [0, 1, 2].map(|axis| middle[axis] + step[axis]);
    let back = middle.map(|value| -value);
    Transform::translation(there) * turn * Transform::translation(back) * transform
}
