//! Imports compiled maps: drawn faces, lights, player starts, and baked visibility.
//!
//! `surfaces` holds the faces, which `faces` reads for Quake, and `faces3` and `patch` for Quake 3; `items` groups them
//! into items. `looks` and `pattern` make up materials, because the images are in other game files; `light` reads the
//! lightmaps. `cells` reads the PVS. `entities` parses the entity text, from which `lights` and `starts` are created.
//! `axes` converts from z up to y up.
//! Source: the source code of both engines, published by id Software, and the files themselves.
//! Hostile input: every number is checked before it is used, and memory is reserved before anything is stored.

mod axes;
mod cells;
pub(super) mod entities;
mod faces;
mod faces3;
mod items;
mod light;
mod lights;
mod looks;
mod patch;
mod pattern;
mod shaders;
mod starts;
mod surfaces;

pub(super) use faces::{Image, Outlines, behind, faces, front, images, placings, plane_side_placing};
pub(super) use looks::Kind;

use super::bsp::{Map, Tree};
use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, Import, NonOccluders, ReadOptions, Room};
use enfilade::GeometryBuilder;
use looks::Looks;
use serde::{Deserialize, Serialize};
use shaders::Shaders;
use std::path::Path;

/// Statistics of a compiled map.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MapSummary {
    /// `BSP29`, `BSP2` or `IBSP46`.
    pub format: String,
    /// Number of leafs that can contain the camera: all except solid ones.
    pub leafs: usize,
    /// Number of clusters of leafs (Quake 3); `None` for Quake, whose maps do not store clusters.
    pub clusters: Option<usize>,
    /// Number of faces, including those that are not drawn.
    pub faces: usize,
    /// Number of models: the world and the brush models.
    pub models: usize,
    /// Number of entities: the world, lights, doors, monsters and all others.
    pub entities: usize,
    /// Size of the visibility lump, in bytes; 0 if no PVS has been computed.
    pub visibility_bytes: usize,
}

/// Returns `true` if the bytes begin like a supported map.
pub(crate) fn begins_like_map(bytes: &[u8]) -> bool {
    let begins = [&b"BSP2"[..], b"IBSP", &29u32.to_le_bytes()];
    begins.iter().any(|magic| bytes.starts_with(magic))
}

/// Reads the bytes of a map called `name`; the shader files of Quake 3 are looked for around its folder.
pub(crate) fn import(
    bytes: &[u8],
    folder: Option<&Path>,
    name: &str,
    options: &ReadOptions,
    mut budget: Budget,
) -> Result<Import, BrokenRule> {
    // `Map` keeps a copy of the bytes, and `Tree` takes at most three times the size of the plane, node and leaf lumps.
    budget.take(4 * bytes.len() as u64, || "the map".to_owned())?;
    let map = Map::read(bytes)?;
    let is_quake3 = map.format.is_quake3;
    let tree = Tree::read(&map)?;
    let text = entities::text(&map, &mut budget)?;
    let entities = entities::parse(&text)?;

    let mut warnings = Warnings::default();
    let mut looks = Looks::new(options.textures);
    let mut files = Vec::new();
    let surfaces = if is_quake3 {
        let shaders = match folder {
            Some(folder) => Shaders::read(folder, &faces3::names(&map)?, &mut budget, &mut warnings),
            None => Shaders::default(),
        };
        let surfaces = faces3::read(&map, &shaders, &mut looks, &mut budget, &mut warnings)?;
        files = shaders.files;
        surfaces
    } else {
        faces::read(&map, &tree, &mut looks, &mut budget, &mut warnings)?
    };
    let models = items::models(&map, surfaces.faces.len())?;
    let textures = looks.textures(&mut budget)?;
    let mut non_occluders = NonOccluders::of_materials(looks.non_occluders.into());
    let mut geometry = GeometryBuilder::new(looks.materials);
    geometry.textures(textures);
    let world = models.first().cloned().unwrap_or_default();
    items::add_world_items(
        &map,
        &tree,
        &surfaces,
        world,
        &mut geometry,
        &mut budget,
        &mut warnings,
    )?;
    let of_entities = items::add_entity_items(
        &entities,
        is_quake3,
        &models,
        &surfaces,
        &mut geometry,
        &mut budget,
        &mut warnings,
    )?;
    for (item, why) in of_entities {
        non_occluders.add(item, why);
    }
    if let Some(cells) = cells::read(&map, &tree, &mut budget)? {
        geometry.cells(cells);
    }
    let geometry = geometry.build().map_err(BrokenRule::Geometry)?;

    let summary = MapSummary {
        format: map.format.name().to_owned(),
        leafs: match is_quake3 {
            true => tree.leafs.iter().filter(|leaf| leaf.kind >= 0).count(),
            false => map.world_leafs()?.max(0) as usize,
        },
        clusters: is_quake3.then(|| {
            tree.leafs
                .iter()
                .map(|leaf| leaf.kind + 1)
                .max()
                .unwrap_or(0)
                .max(0) as usize
        }),
        faces: surfaces.faces.len(),
        models: models.len(),
        entities: entities.len(),
        visibility_bytes: map.lump(map.format.visibility).len(),
    };
    warnings.state(WarningKind::EmptyScene, geometry.triangle_count() == 0);
    let cameras = starts::cameras(&entities, is_quake3);
    Ok(Import {
        orthographic_heights: vec![None; cameras.len()],
        cameras,
        lights: lights::lights(&entities, is_quake3),
        map: Some(summary),
        scenes: Vec::new(),
        warnings: warnings.into_list(),
        files,
        ..Import::of_rooms(vec![Room {
            non_occluders,
            ..Room::new(name, geometry)
        }])
    })
}
