//! Compiled maps as scenes: what is drawn, what shines, where one starts, and what is visible from where.
//!
//! *surfaces* are the faces of a map, which *faces* reads of Quake, and *faces3* and *patch* of Quake 3; *items* says which
//! of them belong together. *looks* and *pattern* make up what they look like, for the images lie in the files of the game, and *light* has their lightmaps.
//! *cells* are what is visible from where. *entities* are text, of which *lights* and *starts* are made. *axes* turns all that so that y is up.
//! Source: the sources of both engines, as published by id Software, and the files themselves.
//! Hostile: every number is checked before it is used, and memory set aside before anything is stored.

mod axes;
mod cells;
mod entities;
mod faces;
mod faces3;
mod items;
mod light;
mod lights;
mod looks;
mod patch;
mod pattern;
mod starts;
mod surfaces;

pub(super) use faces::{Image, Outlines, behind, faces, front, images, placings, plane_side_placing};
pub(super) use looks::Kind;

use super::bsp::{Map, Tree};
use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, Import, ReadOptions, Room, SourceNodes};
use enfilade::GeometryBuilder;
use looks::Looks;
use std::sync::Arc;

/// What a compiled map says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MapSummary {
    /// `BSP29`, `BSP2` or `IBSP46`.
    pub format: &'static str,
    /// Leafs that one can be in: all but those that are solid.
    pub leafs: usize,
    /// Clusters of leafs, in Quake 3; a map of Quake does not say which leafs see the same.
    pub clusters: Option<usize>,
    /// All faces, also those that are not drawn.
    pub faces: usize,
    /// The world, and what moves in it.
    pub models: usize,
    /// The world, lights, doors, monsters, and all else that its author has put there.
    pub entities: usize,
    /// How long what is visible from where is; 0 where nobody has computed it.
    pub visibility_bytes: usize,
}

/// Do bytes begin as maps do that are read here?
pub(crate) fn begins_like_map(bytes: &[u8]) -> bool {
    let begins = [&b"BSP2"[..], b"IBSP", &29u32.to_le_bytes()];
    begins.iter().any(|magic| bytes.starts_with(magic))
}

/// Reads the bytes of a map called `name`.
pub(crate) fn import(
    bytes: &[u8],
    name: &str,
    options: &ReadOptions,
    mut budget: Budget,
) -> Result<Import, BrokenRule> {
    // The map keeps a copy of them, and its tree takes at most three times as much as its planes, nodes and leafs.
    budget.take(4 * bytes.len() as u64, || "the map".to_owned())?;
    let map = Map::read(bytes)?;
    let is_quake3 = map.format.is_quake3;
    let tree = Tree::read(&map)?;
    let text = map.lump(map.format.entities);
    budget.take(text.len() as u64 * (3 + entities::TIMES_ITS_LENGTH), || {
        "its entities".to_owned()
    })?;
    let text = String::from_utf8_lossy(text);
    let entities = entities::parse(&text)?;

    let mut warnings = Warnings::default();
    let mut looks = Looks::new(options.textures);
    let surfaces = if is_quake3 {
        faces3::read(&map, &mut looks, &mut budget, &mut warnings)?
    } else {
        faces::read(&map, &tree, &mut looks, &mut budget, &mut warnings)?
    };
    let models = items::models(&map, surfaces.faces.len())?;
    let textures = looks.textures(&mut budget)?;
    let mut geometry = GeometryBuilder::new(looks.materials);
    geometry.textures(textures);
    let world = models.first().cloned().unwrap_or_default();
    items::of_the_world(
        &map,
        &tree,
        &surfaces,
        world,
        &mut geometry,
        &mut budget,
        &mut warnings,
    )?;
    items::of_entities(
        &entities,
        &models,
        &surfaces,
        &mut geometry,
        &mut budget,
        &mut warnings,
    )?;
    if let Some(cells) = cells::read(&map, &tree, &mut budget)? {
        geometry.cells(cells);
    }
    let geometry = geometry.build().map_err(BrokenRule::Geometry)?;

    let summary = MapSummary {
        format: map.format.name(),
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
    Ok(Import {
        rooms: vec![Room {
            name: name.to_owned(),
            geometry: Arc::new(geometry),
            nodes: SourceNodes::default(),
            method: None,
            open_above: false,
            large: None,
        }],
        portals: Vec::new(),
        cameras: starts::cameras(&entities, is_quake3),
        lights: lights::lights(&entities, is_quake3),
        map: Some(summary),
        warnings: warnings.into_list(),
        files: Vec::new(),
    })
}
