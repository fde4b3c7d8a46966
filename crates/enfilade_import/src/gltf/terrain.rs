//! Terrain nodes: nodes whose mesh is a grid of heights.
//!
//! Cost: O(corners · log corners) for each such mesh.

use super::below::named;
use super::document::Document;
use super::mesh::MeshPlan;
use super::plan::Plan;
use super::poses::{PosedMesh, Poses};
use super::{BYTES_PER_NODE, Meshes};
use crate::budget::Budget;
use crate::faults::{Faults, Subject};
use crate::terrain::grid;
use crate::warning::Warnings;
use crate::{AuthoringError, BrokenRule, GridError};
use enfilade::HeightField;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The terrain nodes and their meshes, checked as far as possible without their bytes.
pub(super) struct TerrainPlan(Vec<PlannedTerrain>);

struct PlannedTerrain {
    /// The marked node.
    terrain: u32,
    /// The node that has its mesh: itself, or one below it.
    holder: u32,
    mesh: PosedMesh,
}

/// Height fields, by index of the node that has the mesh.
pub(super) struct Terrains(BTreeMap<u32, Arc<HeightField>>);

/// Approximate memory of a block without its triangles: an item and a mesh.
const BYTES_PER_BLOCK: u64 = 2 * BYTES_PER_NODE;

/// Minimum number of triangles of a block, except for the last blocks of a terrain.
const TRIANGLES_PER_BLOCK: u64 = 64;

impl TerrainPlan {
    /// Checks the nodes and reserves the memory of their height fields and blocks. `meshes` holds the plans of all used
    /// meshes, in order.
    pub(super) fn new(
        document: &Document,
        plan: &Plan,
        meshes: (&Poses, &[MeshPlan]),
        budget: &mut Budget,
        faults: &mut Faults,
        warnings: &mut Warnings,
    ) -> Result<TerrainPlan, BrokenRule> {
        let mut terrains = Vec::new();
        for number in plan.terrains() {
            let node = &document.nodes[number as usize];
            let spoken = || document.node_name(number);
            let (holder, planned) = match mesh_of_terrain(document, number, plan, meshes) {
                Ok(found) => found,
                Err(why) => {
                    faults.report(Subject::Terrain, why, warnings);
                    continue;
                }
            };
            let triangles = planned.triangles();
            let blocks = triangles / TRIANGLES_PER_BLOCK + 1;
            let bytes = [
                // The height field and the blocks; each is at most as large as the mesh.
                planned.bytes_kept().saturating_mul(2),
                triangles.saturating_mul(grid::BYTES_AT_WORK),
                blocks.saturating_mul(BYTES_PER_BLOCK + node.name.len() as u64),
            ];
            budget.take(bytes.into_iter().fold(0, u64::saturating_add), || {
                format!("{}, which is terrain", spoken())
            })?;
            terrains.push(PlannedTerrain {
                terrain: number,
                holder,
                mesh: planned.posed(),
            });
        }
        Ok(TerrainPlan(terrains))
    }

    /// Recognises the grids; a mesh that several nodes share is converted once.
    pub(super) fn read(
        &self,
        document: &Document,
        meshes: &Meshes,
        faults: &mut Faults,
        warnings: &mut Warnings,
    ) -> Terrains {
        let mut fields: BTreeMap<PosedMesh, Result<Arc<HeightField>, GridError>> = BTreeMap::new();
        let mut terrains = BTreeMap::new();
        for planned in &self.0 {
            let field = fields
                .entry(planned.mesh)
                .or_insert_with(|| grid::field_of(&meshes.get(planned.mesh).mesh).map(Arc::new));
            match field {
                Ok(field) => {
                    terrains.insert(planned.holder, Arc::clone(field));
                }
                Err(why) => {
                    let (node, why) = (document.node_name(planned.terrain), why.clone());
                    faults.report(Subject::Terrain, AuthoringError::NoGrid { node, why }, warnings);
                }
            }
        }
        Terrains(terrains)
    }
}

/// Returns the node that has the mesh of a terrain node, and the mesh, checked as far as possible without its bytes.
fn mesh_of_terrain<'p>(
    document: &Document,
    number: u32,
    plan: &Plan,
    (poses, plans): (&Poses, &'p [MeshPlan]),
) -> Result<(u32, &'p MeshPlan), AuthoringError> {
    let spoken = || document.node_name(number);
    let without_mesh = || AuthoringError::TerrainWithoutMesh {
        node: spoken(),
        found: plan.found_below(number),
    };
    let holder = match plan.terrain_meshes(&number) {
        [only] => *only,
        [] => return Err(without_mesh()),
        several => {
            return Err(AuthoringError::TerrainOfSeveral {
                node: spoken(),
                meshes: named(document, several),
            });
        }
    };
    let node = &document.nodes[holder as usize];
    let planned = poses.of(holder).and_then(|posed| {
        let place = plans.binary_search_by_key(&posed, MeshPlan::posed).ok()?;
        Some(&plans[place]).filter(|plan| plan.triangles() > 0)
    });
    let planned = planned.ok_or_else(without_mesh)?;
    let primitives = &document.meshes[planned.posed().mesh as usize].primitives;
    let moves = [
        ("a skeleton", node.skin.is_some()),
        (
            "morph targets",
            primitives.iter().any(|primitive| !primitive.targets.is_empty()),
        ),
    ];
    if let Some((what, _)) = moves.into_iter().find(|(_, moves)| *moves) {
        return Err(AuthoringError::TerrainMoves { node: spoken(), what });
    }
    let has_instances = node.instancing().is_some_and(|instances| {
        let lists = [instances.translation, instances.rotation, instances.scale];
        lists.iter().any(Option::is_some)
    });
    if has_instances {
        return Err(AuthoringError::TerrainInstanced { node: spoken() });
    }
    if let Some(primitives) = planned.of_two_materials() {
        return Err(AuthoringError::TerrainMaterials {
            node: spoken(),
            primitives,
        });
    }
    Ok((holder, planned))
}

impl Terrains {
    /// Returns the height field of a node; `None` if the node is not terrain.
    pub(super) fn of(&self, node: u32) -> Option<&Arc<HeightField>> {
        self.0.get(&node)
    }
}
