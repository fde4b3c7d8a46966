//! A baked PVS as the source of a camera's visible set.

use crate::components::PvsCells;
use bevy_ecs::prelude::*;
use bevy_math::DVec3;
use bevy_platform::collections::HashMap;
use enfilade::{Aabb, BakedCells, CellId, CellSide};

/// Of boxes in `f32`, relative to the size of their coordinates.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// The cells that entities reach into, for one camera.
#[derive(Default)]
pub(crate) struct EntityCells {
    of: HashMap<Entity, (u64, Vec<CellId>)>,
}

/// Returns the cell that a camera is in; `None` outside of all.
pub(crate) fn cell_of(pvs: &PvsCells, eye: DVec3) -> Option<CellId> {
    let eye = pvs.cells_from_world.transform_point3(eye.as_vec3()).as_dvec3();
    pvs.cells.cell_at(eye.to_array())
}

impl EntityCells {
    /// Returns whether an entity with this box, changed `version` times, may be seen from a cell.
    pub(crate) fn may_be_seen(
        &mut self,
        pvs: &PvsCells,
        from: CellId,
        entity: Entity,
        (bounds, version): (Aabb, u64),
    ) -> bool {
        let known = self.of.entry(entity).or_insert((u64::MAX, Vec::new()));
        if known.0 != version {
            *known = (version, cells_in(pvs, &bounds));
        }
        // What is in no cell is in walls or outside the map: it is not known to be hidden.
        known.1.is_empty() || known.1.iter().any(|&cell| pvs.cells.may_see(from, cell))
    }
}

/// Returns the cells that a box of the world reaches into.
fn cells_in(pvs: &PvsCells, bounds: &Aabb) -> Vec<CellId> {
    let corners = bounds
        .corners()
        .map(|corner| pvs.cells_from_world.transform_point3(corner.into()).to_array());
    let mut found = Vec::new();
    collect(&pvs.cells, &Aabb::of(corners), pvs.cells.tree().root, &mut found);
    found.sort_unstable();
    found.dedup();
    found
}

fn collect(cells: &BakedCells, bounds: &Aabb, side: CellSide, found: &mut Vec<CellId>) {
    let mut pending = vec![side];
    while let Some(side) = pending.pop() {
        match side {
            CellSide::Cell(cell) => found.push(cell),
            CellSide::Solid => {}
            CellSide::Node(node) => {
                let node = &cells.tree().nodes[node as usize];
                let [mut nearest, mut farthest, mut reach] = [0.0; 3];
                for axis in 0..3 {
                    let ends =
                        [bounds.min[axis], bounds.max[axis]].map(|end| node.normal[axis] * f64::from(end));
                    nearest += ends[0].min(ends[1]);
                    farthest += ends[0].max(ends[1]);
                    reach += ends[0].abs().max(ends[1].abs());
                }
                let length = DVec3::from(node.normal).length();
                let slack = length * cells.tree().tolerance + ROUNDING * (reach + node.distance.abs());
                // What lies in the plane is on both sides.
                if farthest + slack >= node.distance {
                    pending.push(node.front);
                }
                if nearest - slack <= node.distance {
                    pending.push(node.back);
                }
            }
        }
    }
}
