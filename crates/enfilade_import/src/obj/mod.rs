//! Reads OBJ and MTL files, in two passes.
//!
//! The first pass counts, so that memory is reserved before anything is stored; the second parses numbers, in parallel
//! chunks. Then the state statements between faces are applied in order, materials and images are read, and the meshes
//! of the groups are built in parallel. OBJ has no transforms: all items have the identity transform.
//! The crate `tobj` 4 is not used, only compared with in tests. It panics on `Kd 0.5`, overflows on large relative
//! indices, reads a polyline of three points as a triangle, stops at names in Latin-1, lacks continued lines and several
//! material files, mixes up vertex colors if only some vertices have one, loses missing materials' names and boundaries
//! between groups of one name, triangulates concave polygons as fans, and names no line in its errors. To filter all that
//! out beforehand, the whole file would have to be parsed.
//! Source: Wavefront Technologies. Advanced Visualizer Manual, Appendix B1 (object files) and B2 (material files),
//! 1995, the parts about polygons; where it leaves a case open, the behaviour of Blender.
//! Cost: O(bytes + corners · log corners), except for polygons that are hard to triangulate.

mod corner;
mod error;
mod files;
mod groups;
mod materials;
mod mesh;
mod mtl;
mod parse;
pub(crate) mod polygon;
mod ring;
mod smooth;
mod survey;
mod text;

pub use error::ObjError;

use crate::budget::{BYTES_PER_MESH, Budget};
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, Import, NonOccluders, ReadOptions, Room, gltf};
use enfilade::{GeometryBuilder, Transform};
use groups::{Group, Groups};
use materials::Materials;
use mesh::{BuiltMesh, Size, Source};
use parse::Tables;
use rayon::prelude::*;
use std::path::Path;
use survey::{Counts, survey};
use text::{Lines, has_old_line_ends, number, with_line_ends, without_mark};

impl From<ObjError> for BrokenRule {
    fn from(why: ObjError) -> BrokenRule {
        BrokenRule::Obj(Box::new(why))
    }
}

/// Returns `true` if a text begins like an OBJ file: after comments and names, with a position, texture coordinate or
/// normal, or with the name of a material file.
pub(crate) fn begins_like_obj(bytes: &[u8]) -> bool {
    const ENOUGH: usize = 1 << 16;
    let begin = with_line_ends(without_mark(&bytes[..bytes.len().min(ENOUGH)]));
    let mut lines = Lines::of(&begin, 0);
    let first = lines.find(|line| !matches!(line.keyword(), b"o" | b"g" | b"s" | b"usemtl"));
    first.is_some_and(|line| match line.keyword() {
        b"mtllib" => !line.rest().is_empty(),
        b"v" | b"vt" | b"vn" => line.words().count() >= 2 && line.words().all(|word| number(word).is_some()),
        _ => false,
    })
}

/// Reads the bytes of an OBJ file called `name`; its material files and images are looked for in `folder`. `None` if no
/// line is a known OBJ statement.
pub(crate) fn import(
    bytes: &[u8],
    folder: Option<&Path>,
    name: &str,
    options: &ReadOptions,
    mut budget: Budget,
) -> Result<Option<Import>, BrokenRule> {
    // Text with continued lines or carriage-return line ends is copied.
    if bytes.contains(&b'\\') || has_old_line_ends(bytes) {
        budget.take(bytes.len() as u64, || "the text".to_owned())?;
    }
    let text = with_line_ends(without_mark(bytes));
    let (pieces, all) = survey(&text)?;
    if all.unknown > 0 && !all.any_known() {
        return Ok(None);
    }
    read(&pieces, &all, folder, name, options, budget).map(Some)
}

fn read(
    pieces: &[survey::Piece],
    all: &Counts,
    folder: Option<&Path>,
    name: &str,
    options: &ReadOptions,
    mut budget: Budget,
) -> Result<Import, BrokenRule> {
    let mut warnings = Warnings::default();
    budget.take(bytes_of_tables(all), || "the text".to_owned())?;
    // Indices are 32-bit, and triangulation makes up to three triangle corners per polygon corner.
    if all.corners.max(all.positions) >= u32::MAX as usize / 3 {
        return Err(BrokenRule::TooManyCorners {
            place: "the file".to_owned(),
        });
    }
    let (tables, faces) = parse::parse(pieces, all, &mut warnings)?;
    let found = Groups::of(&faces, &mut budget)?;
    let materials = Materials::read(&found, folder, options.textures, &mut budget, &mut warnings);
    let source = Source {
        pieces,
        faces: &faces,
        tables: &tables,
        placings: &materials.placings,
    };

    let non_occluders = NonOccluders::of_materials(materials.non_occluders.into());
    let mut geometry = GeometryBuilder::new(materials.materials);
    geometry.textures(materials.textures);
    let batches = batches(&found.groups, &source);
    let carried = bytes_carried(&tables, found.any_smooth());
    let mut kept = 0;
    let mut at_work = 0;
    for (_, size) in &batches {
        kept += size.triangles * BYTES_KEPT + size.corners * (12 + carried);
        let polygons = size.polygon_corners * BYTES_PER_POLYGON_CORNER;
        at_work = at_work.max(size.triangles * BYTES_AT_WORK + size.corners * (40 + carried) + polygons);
    }
    kept += found.groups.len() as u64 * BYTES_PER_MESH;
    budget.take(kept + at_work, || "the triangles".to_owned())?;
    for (batch, _) in batches {
        let built: Vec<_> = batch.par_iter().map(|group| source.build(group)).collect();
        // In order, so that of several broken groups the first is named, whichever thread finishes first.
        for (group, built) in batch.iter().zip(built) {
            let BuiltMesh { mesh, rough } = built?;
            for (piece, face) in rough {
                warnings.name(WarningKind::RoughPolygons, || {
                    format!("line {}", source.line(piece, face))
                });
            }
            let mesh = geometry.mesh(mesh);
            geometry.item(&group.name, mesh, Transform::IDENTITY);
            if !options.flat && gltf::marks_opening_or_room(&group.name) {
                warnings.name(WarningKind::NoRoomsInObj, || group.name.clone());
            }
        }
    }
    let geometry = geometry.build().map_err(BrokenRule::Geometry)?;
    warnings.state(WarningKind::EmptyScene, geometry.triangle_count() == 0);
    Ok(Import {
        scenes: Vec::new(),
        warnings: warnings.into_list(),
        files: materials.files,
        ..Import::of_rooms(vec![Room {
            non_occluders,
            ..Room::new(name, geometry)
        }])
    })
}

/// Returns the maximum size of the parsed tables; any position may have a color.
fn bytes_of_tables(all: &Counts) -> u64 {
    let bytes = all.positions * 24 + all.texture * 8 + all.normals * 12;
    (bytes + all.corners * 12 + all.faces * 4 + all.marks * 64) as u64
}

/// Bytes per triangle of a mesh, without its vertices, of which no two may be shared.
const BYTES_KEPT: u64 = 16;
/// Additional bytes per triangle while a mesh is built.
const BYTES_AT_WORK: u64 = 120;

/// Additional bytes per corner of a large polygon while it is cut into triangles.
const BYTES_PER_POLYGON_CORNER: u64 = 400;

/// Returns the maximum size of the attributes of a vertex, in bytes.
fn bytes_carried(tables: &Tables, any_smooth: bool) -> u64 {
    let bytes = |is_there: bool, bytes| if is_there { bytes } else { 0 };
    bytes(!tables.normals.is_empty(), 12)
        + bytes(any_smooth, 60)
        + bytes(!tables.texture.is_empty(), 8)
        + bytes(!tables.colors.is_empty(), 16)
}

/// Maximum number of triangles of groups that are built at the same time, unless a single group has more. So memory use
/// does not grow with the number of threads.
const BATCH_TRIANGLES: u64 = 1_000_000;

/// Splits the groups into batches that are built in parallel; returns the size of each.
fn batches<'g>(groups: &'g [Group], source: &Source) -> Vec<(&'g [Group], Size)> {
    let mut batches = Vec::new();
    let mut start = 0;
    let mut batch = Size::default();
    for (end, group) in groups.iter().enumerate() {
        let size = source.size(group);
        if batch.triangles > 0 && batch.triangles + size.triangles > BATCH_TRIANGLES {
            batches.push((&groups[start..end], batch));
            (start, batch) = (end, Size::default());
        }
        batch += size;
    }
    if start < groups.len() {
        batches.push((&groups[start..], batch));
    }
    batches
}
