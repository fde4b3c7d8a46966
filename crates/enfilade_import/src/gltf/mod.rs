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
mod materials;
mod mesh;
mod names;
mod nodes;
mod topology;

use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, Import};
use buffers::Buffers;
use container::Container;
use document::Document;
use enfilade::{ContentBuilder, ContentError, MeshId};
use mesh::MeshPlan;
use nodes::Placed;
use rayon::prelude::*;
use std::path::Path;

/// Reads the bytes of a `.glb` or `.gltf` file; `folder` is where its buffers lie.
pub(crate) fn import(bytes: &[u8], folder: Option<&Path>, mut budget: Budget) -> Result<Import, BrokenRule> {
    let mut warnings = Warnings::default();
    let container = Container::split(bytes)?;
    let document = Document::parse(container.json, &mut budget)?;
    extensions::check(&document, &mut warnings)?;
    warn_of_the_unread(&document, &mut warnings);
    let placed = nodes::place(&document, &mut warnings)?;
    let materials = materials::read(&document)?;

    let used = used_meshes(&document, &placed)?;
    let mut plans = Vec::with_capacity(used.len());
    for &mesh in &used {
        plans.push(MeshPlan::new(&document, mesh, &mut budget, &mut warnings)?);
    }
    let named_buffers = plans.iter().flat_map(MeshPlan::buffers);
    let buffers = Buffers::load(&document, named_buffers, container.binary, folder, &mut budget)?;
    let built: Vec<_> = plans.par_iter().map(|plan| plan.build(&buffers)).collect();

    let mut content = ContentBuilder::new(materials);
    // In order, so that of several broken meshes the first is named, whichever thread was done first.
    for mesh in built {
        content.mesh(mesh?);
    }
    let names = names::unique(&document, |node| node.mesh.is_some());
    for Placed { node, world } in &placed {
        if let Some(mesh) = document.nodes[*node as usize].mesh {
            let mesh = MeshId(used.partition_point(|&before| before < mesh) as u32);
            content.item(&names[node], mesh, *world);
        }
    }
    let content = content.build().map_err(|why| match &why {
        ContentError::NotFinite(name) => {
            let node = placed.iter().find(|Placed { node, .. }| names.get(node) == Some(name));
            node.map_or(BrokenRule::Content(why), |node| BrokenRule::NodeNotFinite(document.node_name(node.node)))
        }
        _ => BrokenRule::Content(why),
    })?;
    warnings.state(WarningKind::EmptyScene, content.triangle_count() == 0);
    let cameras = camera::read(&document, &placed, &mut warnings)?;
    Ok(Import { content, cameras, warnings: warnings.into_list() })
}

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
