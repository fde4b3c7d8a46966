//! glTF 2.0: from bytes to items, in steps that each check what the next one relies on.
//!
//! Container, document, extensions, nodes and the plan of every mesh are checked first, and memory is set aside by
//! an estimate; only then are buffers loaded and meshes built, side by side. Nothing that no item uses is looked at.
//! Source: The Khronos Group, glTF 2.0 Specification, 2.0.1.
//! Cost: O(bytes of the file + triangles + nodes), but for `Mesh::new`, which sorts.

mod accessor;
mod buffers;
mod camera;
mod container;
mod document;
mod extensions;
mod hints;
pub(crate) mod link;
mod materials;
mod mesh;
mod names;
mod nodes;
mod plan;
mod topology;

pub(crate) use container::{beginning, begins_like_gltf};
pub(crate) use hints::is_called_like_an_opening_or_a_room;

use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, Import};
use buffers::Buffers;
use container::Container;
use document::Document;
use enfilade::{ContentError, Mesh};
use mesh::MeshPlan;
use names::Names;
use nodes::Placed;
use plan::Plan;
use rayon::prelude::*;
use std::path::Path;
use std::sync::Arc;

/// Reads the bytes of a `.glb` or `.gltf` file called `name`; `folder` is where its buffers lie.
pub(crate) fn import(
    bytes: &[u8],
    folder: Option<&Path>,
    name: &str,
    flat: bool,
    mut budget: Budget,
) -> Result<Import, BrokenRule> {
    let mut warnings = Warnings::default();
    let container = Container::split(bytes)?;
    let document = Document::parse(container.json, &mut budget)?;
    extensions::check(&document, &mut warnings)?;
    warn_of_the_unread(&document, &mut warnings);
    let plan = Plan::new(&document, flat, &mut warnings)?;
    let shown = plan.shown();
    budget.take(shown.len() as u64 * BYTES_PER_NODE, || "the nodes".to_owned())?;
    let materials = materials::read(&document)?;

    let used = used_meshes(&document, shown)?;
    let mut plans = Vec::with_capacity(used.len());
    for &mesh in &used {
        plans.push(MeshPlan::new(&document, mesh, &mut budget, &mut warnings)?);
    }
    budget.take(mesh::bytes_to_build(&plans), || {
        "the building of meshes".to_owned()
    })?;
    let named_buffers = plans.iter().flat_map(MeshPlan::buffers);
    let buffers = Buffers::load(&document, named_buffers, container.binary, folder, &mut budget)?;

    let mut meshes: Vec<Arc<Mesh>> = Vec::with_capacity(used.len());
    for crowd in mesh::crowds(&plans) {
        let built: Vec<_> = crowd.par_iter().map(|plan| plan.build(&buffers)).collect();
        // In order, so that of several broken meshes the first is named, whichever thread was done first.
        for mesh in built {
            meshes.push(Arc::new(mesh?));
        }
    }
    let meshes = Meshes { used, built: meshes };
    let names = Names::of(&document, |node| node.mesh.is_some());
    let cameras = camera::read(&document, shown, &mut warnings)?;
    let (rooms, portals) = plan
        .rooms(name, &meshes, &materials.into(), &names, &mut warnings)
        .map_err(|why| name_the_node(why, &document, plan.shown(), &names))?;
    let triangles = rooms
        .iter()
        .map(|room| room.content.triangle_count())
        .sum::<u64>();
    warnings.state(WarningKind::EmptyScene, triangles == 0);
    Ok(Import {
        rooms,
        portals,
        cameras,
        lights: Vec::new(),
        warnings: warnings.into_list(),
    })
}

/// The meshes of the document that something uses.
struct Meshes {
    /// Their numbers, in order.
    used: Vec<u32>,
    built: Vec<Arc<Mesh>>,
}

impl Meshes {
    /// A mesh by its number, which is one of those used.
    fn get(&self, mesh: u32) -> &Arc<Mesh> {
        &self.built[self.used.partition_point(|&before| before < mesh)]
    }
}

/// About what a node that shows something takes while it becomes an item.
const BYTES_PER_NODE: u64 = 400;

/// The meshes that items are copies of, each once, in order.
fn used_meshes(document: &Document, placed: &[Placed]) -> Result<Vec<u32>, BrokenRule> {
    let mut used = Vec::new();
    for Placed { node, .. } in placed {
        if let Some(mesh) = document.nodes[*node as usize].mesh {
            document::find(&document.meshes, mesh, "mesh", || document.node_name(*node))?;
            used.push(mesh);
        }
    }
    used.sort_unstable();
    used.dedup();
    Ok(used)
}

/// Warns of what stands at the top of the document and is left there.
fn warn_of_the_unread(document: &Document, warnings: &mut Warnings) {
    warnings.count(WarningKind::OtherScenes, document.scenes.len().saturating_sub(1));
    warnings.count(WarningKind::Textures, document.textures.len());
    warnings.count(WarningKind::Skins, document.skins.len());
    warnings.count(WarningKind::Animations, document.animations.len());
}

/// Says which node is meant where the content knows only the item.
fn name_the_node(why: BrokenRule, document: &Document, placed: &[Placed], names: &Names) -> BrokenRule {
    if let BrokenRule::Content(ContentError::NotFinite(name)) = &why {
        let is_meant = |number: u32| names.name(number, &document.nodes[number as usize]) == *name;
        if let Some(placed) = placed.iter().find(|placed| is_meant(placed.node)) {
            return BrokenRule::NodeNotFinite(document.node_name(placed.node));
        }
    }
    why
}
