//! What unread extensions may change, so that it hides nothing.
//!
//! An extension may change whatever carries it: a node with all below it, a mesh, a material. If nothing carries it, or
//! something else that may shape what is drawn does, it may change everything.
//! Cost: O(bytes of the JSON), only if the file names such an extension.

use super::document::{Document, PathStep, extensions_in};
use super::extensions;
use super::plan::with_all_below;
use std::collections::BTreeSet;

/// The elements that extensions may change, by index.
#[derive(Debug, Default)]
pub(super) struct Affected {
    is_all: bool,
    nodes: BTreeSet<u32>,
    meshes: BTreeSet<u32>,
    materials: BTreeSet<u32>,
}

impl Affected {
    /// Finds what the unread extensions may change that the file names.
    pub(super) fn by_unread(document: &Document, json: &[u8]) -> Affected {
        let named = document.extensions_used.union(&document.extensions_required);
        let unread = named.filter(|name| extensions::changes_shapes(name)).count();
        let mut affected = Affected::default();
        if unread == 0 {
            return affected;
        }
        let lists = [&document.extensions_used, &document.extensions_required];
        let mut carried: BTreeSet<&str> = BTreeSet::new();
        extensions_in(json, |path| {
            if let Some(PathStep::Key(name)) = path.last()
                && let Some(name) = lists.iter().find_map(|list| list.get(name))
                && extensions::changes_shapes(name)
            {
                carried.insert(name);
                affected.carry(path);
            }
        });
        affected.is_all |= carried.len() < unread;
        affected.nodes = with_all_below(document, affected.nodes.into_iter().collect());
        affected
    }

    /// Adds the element that carries the extension at a path.
    fn carry(&mut self, path: &[PathStep]) {
        let (list, number) = match path {
            [PathStep::Key(list), PathStep::Index(number), ..] => (&**list, *number as u32),
            _ => ("", 0),
        };
        match list {
            "nodes" => drop(self.nodes.insert(number)),
            "meshes" => drop(self.meshes.insert(number)),
            "materials" => drop(self.materials.insert(number)),
            // Their pixels change no shape, and only a material says that they are see-through.
            "textures" | "images" | "samplers" | "cameras" => {}
            _ => self.is_all = true,
        }
    }

    /// Returns `true` if an extension may change a node or its mesh.
    pub(super) fn has(&self, node: u32, mesh: u32) -> bool {
        self.is_all || self.nodes.contains(&node) || self.meshes.contains(&mesh)
    }

    pub(super) fn has_material(&self, material: u32) -> bool {
        self.materials.contains(&material)
    }

    /// Returns `true` if an extension may change anything.
    pub(super) fn is_any(&self) -> bool {
        self.is_all || !(self.nodes.is_empty() && self.meshes.is_empty() && self.materials.is_empty())
    }
}
