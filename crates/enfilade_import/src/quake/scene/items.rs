//! Groups faces into items: world faces by the leafs that they are visible from, and the faces of each brush entity.
//!
//! A method with baked cells accepts or culls whole items. So world items are as small as possible: all faces of an
//! item are in the same set of leafs. With one item per leaf there would be fewer, but an item would also be visited
//! from where only its neighbour is visible.

use super::axes::placed;
use super::entities::Entity;
use super::surfaces::Surfaces;
use crate::budget::{BYTES_PER_MESH, Budget};
use crate::quake::bsp::{BspError, Map, Tree, in_range, int, word};
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, NonOccluder};
use enfilade::{GeometryBuilder, ItemIndex, ItemOptions, MeshId, Transform};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// The lumps of leaf faces.
const MARKS: usize = 11;
const MARKS_OF_QUAKE_3: usize = 5;
/// Offsets of the first face and face count in a model record, in bytes.
const FACES_OF_A_MODEL: usize = 56;
const FACES_OF_A_MODEL_OF_QUAKE_3: usize = 24;

/// Returns the face range of each model; the first model is the world.
pub(super) fn models(map: &Map, faces: usize) -> Result<Vec<Range<u32>>, BspError> {
    let place = match map.format.is_quake3 {
        true => FACES_OF_A_MODEL_OF_QUAKE_3,
        false => FACES_OF_A_MODEL,
    };
    let models = map.records(map.format.models, map.format.model_bytes)?;
    let read = |(at, model): (usize, &[u8])| {
        let [first, count] = [place, place + 4].map(|place| i64::from(int(model, place)));
        if first >= 0 && count >= 0 && first + count <= faces as i64 {
            return Ok(first as u32..(first + count) as u32);
        }
        Err(BspError::NoSuch {
            what: "model",
            at,
            names: "faces up to",
            number: first + count,
            count: faces,
        })
    };
    models.enumerate().map(read).collect()
}

/// Adds an item for each set of leafs that list the same world faces: `leaf 12`, after the first leaf of the set, or
/// `cluster 12` in Quake 3, whose leafs share visibility by cluster; `leaf 12.2` if that name is taken.
pub(super) fn add_world_items(
    map: &Map,
    tree: &Tree,
    surfaces: &Surfaces,
    world: Range<u32>,
    geometry: &mut GeometryBuilder,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<(), BrokenRule> {
    let what = if map.format.is_quake3 { "cluster" } else { "leaf" };
    let marks = marks(map, tree, surfaces.faces.len(), budget)?;
    let mut of_faces: Vec<(&[[u32; 2]], u32)> = marks
        .chunk_by(|a, b| a[0] == b[0])
        .map(|of_one| (of_one, of_one[0][0]))
        .collect();
    let mut is_marked = vec![false; surfaces.faces.len()];
    of_faces
        .iter()
        .for_each(|(_, face)| is_marked[*face as usize] = true);
    for face in world {
        if !is_marked[face as usize] && surfaces.faces[face as usize].is_some() {
            warnings.name(WarningKind::UnmarkedFaces, || format!("face {face}"));
        }
    }
    let places = |marks: &[[u32; 2]]| marks.iter().map(|mark| mark[1]).collect::<Vec<_>>();
    of_faces.sort_by_cached_key(|(marks, face)| (places(marks), *face));
    let mut last = None;
    let mut number = 0;
    let same = |a: &[[u32; 2]], b: &[[u32; 2]]| a.iter().map(|m| m[1]).eq(b.iter().map(|m| m[1]));
    for of_one in of_faces.chunk_by(|a, b| same(a.0, b.0)) {
        let faces: Vec<u32> = of_one.iter().map(|&(_, face)| face).collect();
        if surfaces.triangle_count(&faces) == 0 {
            continue;
        }
        let first = of_one[0].0[0][1];
        number = if last == Some(first) { number + 1 } else { 1 };
        last = Some(first);
        let name = match number {
            1 => format!("{what} {first}"),
            _ => format!("{what} {first}.{number}"),
        };
        let mesh = surfaces.mesh(&faces).map_err(|why| BrokenRule::Mesh {
            place: name.clone(),
            why,
        })?;
        let mesh = geometry.mesh(mesh);
        let item = geometry.item(&name, mesh, Transform::IDENTITY);
        if surfaces.any_moves(&faces) {
            // Its box does not bound it.
            let options = ItemOptions {
                never_cull: true,
                ..ItemOptions::default()
            };
            geometry.set_options(item, options);
        }
    }
    Ok(())
}

/// The target names of the entities that others remove.
fn killed<'t>(entities: &[Entity<'t>]) -> HashSet<&'t str> {
    let pairs = entities.iter().flat_map(Entity::pairs);
    // Mods number them: `killtarget2`.
    let names = pairs.filter_map(|(key, value)| key.starts_with("killtarget").then_some(value));
    names.filter(|name| !name.is_empty()).collect()
}

/// Returns why a brush entity hides nothing; `None` if it is certainly drawn, opaque, where the map has it. Doors and lifts move,
/// engines draw others as transparent as their keys say, or leave them out by the skill and the kind of game.
fn why_no_occluder(entity: &Entity, is_quake3: bool, killed: &HashSet<&str>) -> Option<NonOccluder> {
    const AT_REST_IN_QUAKE_3: [&str; 2] = ["func_group", "func_static"];
    const AT_REST: [&str; 7] = [
        "func_detail",
        "func_detail_illusionary",
        "func_detail_wall",
        "func_group",
        "func_illusionary",
        "func_static",
        "func_wall",
    ];
    let is_plain = |(key, plain): (&str, f32)| match entity.get(key) {
        "" => true,
        value => value.trim().parse() == Ok(plain),
    };
    let plain = [
        ("alpha", 1.0),
        ("renderamt", 255.0),
        ("rendermode", 0.0),
        ("renderfx", 0.0),
    ];
    if !plain.into_iter().all(is_plain) {
        return Some(NonOccluder::TranslucentBrush);
    }
    let at_rest: &[&str] = if is_quake3 { &AT_REST_IN_QUAKE_3 } else { &AT_REST };
    // Bits of `spawnflags` say in which games a brush is left out; those of mods may say anything.
    let stays = [
        ("spawnflags", 0.0),
        ("notsingle", 0.0),
        ("notteam", 0.0),
        ("notfree", 0.0),
        ("notta", 0.0),
        ("effects", 0.0),
        ("scale", 1.0),
    ];
    let has_place = entity.get("origin").is_empty() || entity.three("origin").is_some();
    let is_sure = at_rest.contains(&entity.class())
        && stays.into_iter().all(is_plain)
        && ["gametype", "avelocity"]
            .iter()
            .all(|key| entity.get(key).is_empty())
        && !killed.contains(entity.get("targetname"))
        && has_place;
    (!is_sure).then_some(NonOccluder::MovingBrush)
}

/// Returns pairs of a face and a leaf (or cluster) that lists it, sorted and unique.
fn marks(map: &Map, tree: &Tree, faces: usize, budget: &mut Budget) -> Result<Vec<[u32; 2]>, BrokenRule> {
    let is_quake3 = map.format.is_quake3;
    let (lump, bytes) = match (is_quake3, map.format.is_short) {
        (true, _) => (MARKS_OF_QUAKE_3, 4),
        (false, is_short) => (MARKS, if is_short { 2 } else { 4 }),
    };
    let listed = map.records(lump, bytes)?.len();
    let leafs = if is_quake3 {
        0..tree.leafs.len()
    } else {
        1..(map.world_leafs()?.max(0) as usize + 1).min(tree.leafs.len())
    };
    let mut total = 0;
    for at in leafs.clone() {
        let [first, count] = tree.leafs[at].faces.map(u64::from);
        if first + count > listed as u64 {
            return Err(BrokenRule::from(BspError::NoSuch {
                what: "leaf",
                at,
                names: "marks of faces up to",
                number: (first + count) as i64,
                count: listed,
            }));
        }
        total += count;
    }
    // A pair, and its share of a leaf set to compare.
    budget.take(total.saturating_mul(8 + 32), || "its leafs' faces".to_owned())?;
    let mut marks = Vec::with_capacity(total as usize);
    for at in leafs {
        let leaf = &tree.leafs[at];
        let place = match is_quake3 {
            false => at as u32,
            // The camera is never outside all clusters, so nothing is visible from there.
            true if leaf.kind < 0 => continue,
            true => leaf.kind as u32,
        };
        let [first, count] = leaf.faces.map(|number| number as usize);
        for mark in map.lump(lump)[first * bytes..][..count * bytes].chunks_exact(bytes) {
            let face = match bytes {
                2 => i64::from(u16::from_le_bytes([mark[0], mark[1]])),
                _ => word(mark, 0).unwrap_or(-1).into(),
            };
            marks.push([in_range("leaf", at, "face", face, faces)?, place]);
        }
    }
    marks.sort_unstable();
    marks.dedup();
    Ok(marks)
}

/// Adds an item for each entity with a brush model: `func_door gate#12`. Triggers are invisible and are skipped. Returns the items
/// that hide nothing.
pub(super) fn add_entity_items(
    entities: &[Entity],
    is_quake3: bool,
    models: &[Range<u32>],
    surfaces: &Surfaces,
    geometry: &mut GeometryBuilder,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Vec<(ItemIndex, NonOccluder)>, BrokenRule> {
    let mut non_occluders = Vec::new();
    // Each with whether a face of it moves.
    let mut meshes: HashMap<u32, Option<(MeshId, bool)>> = HashMap::new();
    let mut files = HashSet::new();
    let killed = killed(entities);
    for entity in &entities[entities.len().min(1)..] {
        let named = entity.get("model");
        let Some(number) = named.strip_prefix('*') else {
            if !named.is_empty() && files.insert(named) {
                warnings.name(WarningKind::ModelFiles, || named.to_owned());
            }
            continue;
        };
        let number = number.parse().unwrap_or(-1);
        let model = in_range("entity", entity.number, "model", number, models.len())?;
        if model == 0 || entity.class().starts_with("trigger_") {
            continue;
        }
        let mesh = match meshes.get(&model) {
            Some(mesh) => *mesh,
            None => {
                // Models of a valid map do not share faces, so the memory reserved for all faces suffices; an invalid
                // map may share them.
                let range = models[model as usize].clone();
                budget.take(8 * range.len() as u64, || entity.name())?;
                let faces: Vec<u32> = range.collect();
                let triangles = surfaces.triangle_count(&faces);
                budget.take(300 * triangles as u64 + BYTES_PER_MESH, || entity.name())?;
                let mesh = (triangles > 0)
                    .then(|| surfaces.mesh(&faces))
                    .transpose()
                    .map_err(|why| BrokenRule::Mesh {
                        place: entity.name(),
                        why,
                    })?
                    .map(|mesh| (geometry.mesh(mesh), surfaces.any_moves(&faces)));
                meshes.insert(model, mesh);
                mesh
            }
        };
        if let Some((mesh, moves)) = mesh {
            let origin = entity.three("origin").unwrap_or_default();
            let item = geometry.item(&entity.name(), mesh, placed(origin));
            let why = why_no_occluder(entity, is_quake3, &killed);
            let options = ItemOptions {
                is_occluder: why.is_none(),
                never_cull: moves,
                ..ItemOptions::default()
            };
            geometry.set_options(item, options);
            non_occluders.extend(why.map(|why| (item.index, why)));
        }
    }
    Ok(non_occluders)
}
