//! Terrain: nodes that show a mesh which is a grid of heights.
//!
//! Cost: O(corners · log) for each such mesh.

use super::document::Document;
use super::mesh::MeshPlan;
use super::plan::Plan;
use super::{BYTES_PER_NODE, Meshes};
use crate::budget::Budget;
use crate::terrain::grid;
use crate::{AuthoringError, BrokenRule};
use enfilade::HeightField;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

/// The nodes that are terrain, with their meshes, checked as far as it can be without the bytes.
pub(super) struct TerrainPlan(Vec<(u32, u32)>);

/// The height fields that nodes show, by the numbers of the nodes.
pub(super) struct Terrains(BTreeMap<u32, Arc<HeightField>>);

/// About what a block takes besides its triangles: an item and a mesh.
const BYTES_PER_BLOCK: u64 = 2 * BYTES_PER_NODE;

/// A block has at least so many triangles, but for the last ones of a terrain.
const TRIANGLES_PER_BLOCK: u64 = 64;

impl TerrainPlan {
    /// Checks the nodes, and sets aside the memory that their fields and blocks will take. `plans` are those of all meshes that
    /// nodes show, by number.
    pub(super) fn new(
        document: &Document,
        plan: &Plan,
        plans: &[MeshPlan],
        budget: &mut Budget,
    ) -> Result<TerrainPlan, BrokenRule> {
        let mut terrains = Vec::new();
        for number in plan.terrains() {
            let node = &document.nodes[number as usize];
            let spoken = || document.node_name(number);
            let planned = node.mesh.and_then(|mesh| {
                let place = plans.binary_search_by_key(&mesh, MeshPlan::number).ok()?;
                Some(&plans[place]).filter(|plan| plan.triangles() > 0)
            });
            let Some(planned) = planned else {
                return Err(AuthoringError::TerrainWithoutMesh { node: spoken() }.into());
            };
            let primitives = &document.meshes[planned.number() as usize].primitives;
            let moves = [
                ("a skeleton", node.skin.is_some()),
                (
                    "morph targets",
                    primitives.iter().any(|primitive| !primitive.targets.is_empty()),
                ),
            ];
            if let Some((what, _)) = moves.into_iter().find(|(_, moves)| *moves) {
                return Err(AuthoringError::TerrainMoves { node: spoken(), what }.into());
            }
            let has_instances = node.instancing().is_some_and(|instances| {
                let lists = [instances.translation, instances.rotation, instances.scale];
                lists.iter().any(Option::is_some)
            });
            if has_instances {
                return Err(AuthoringError::TerrainInstanced { node: spoken() }.into());
            }
            if let Some(primitives) = planned.of_two_materials() {
                return Err(AuthoringError::TerrainMaterials {
                    node: spoken(),
                    primitives,
                }
                .into());
            }
            let triangles = planned.triangles();
            let blocks = triangles / TRIANGLES_PER_BLOCK + 1;
            let bytes = [
                // The field and the blocks, each at most as large as the mesh.
                planned.bytes_kept().saturating_mul(2),
                triangles.saturating_mul(grid::BYTES_AT_WORK),
                blocks.saturating_mul(BYTES_PER_BLOCK + node.name.len() as u64),
            ];
            budget.take(bytes.into_iter().fold(0, u64::saturating_add), || {
                format!("{}, which is terrain", spoken())
            })?;
            terrains.push((number, planned.number()));
        }
        Ok(TerrainPlan(terrains))
    }

    /// Recognises the grids, those of nodes that share a mesh once.
    pub(super) fn read(&self, document: &Document, meshes: &Meshes) -> Result<Terrains, AuthoringError> {
        let mut fields = BTreeMap::new();
        let mut terrains = BTreeMap::new();
        for &(node, mesh) in &self.0 {
            let field = match fields.entry(mesh) {
                Entry::Occupied(field) => Arc::clone(field.get()),
                Entry::Vacant(place) => {
                    let field = grid::field_of(meshes.get(mesh)).map_err(|why| AuthoringError::NoGrid {
                        node: document.node_name(node),
                        why,
                    })?;
                    Arc::clone(place.insert(Arc::new(field)))
                }
            };
            terrains.insert(node, field);
        }
        Ok(Terrains(terrains))
    }
}

impl Terrains {
    /// The field that a node shows; `None` where it is no terrain.
    pub(super) fn of(&self, node: u32) -> Option<&Arc<HeightField>> {
        self.0.get(&node)
    }
}
