//! Reads the faces of Quake maps: polygons over edges, each with texture coordinates.
//!
//! Vertices are clockwise when seen from the front, and may be collinear where an adjacent face has a vertex on an
//! edge. Liquid surfaces have two faces, one per side. If a map has no texture names, the leaf behind a face decides
//! its kind.

use super::axes::turned;
use super::light::{self, FaceLight};
use super::looks::{Kind, Looks};
use super::surfaces::{Face, Surfaces};
use crate::BrokenRule;
use crate::budget::Budget;
use crate::obj::polygon::Cutter;
use crate::quake::BspError;
use crate::quake::bsp::{Child, Map, SplitPlane, Tree, in_range, int, number, short};
use crate::warning::{WarningKind, Warnings};
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Lumps that faces are made of, with record sizes in bytes.
const TEXTURES: usize = 2;
const VERTICES: (usize, usize) = (3, 12);
const PLACINGS: (usize, usize) = (6, 40);
const FACES: usize = 7;
const EDGES: usize = 12;
const WALKS: (usize, usize) = (13, 4);
/// Sizes of a face and an edge with 16-bit and with 32-bit indices, in bytes.
const SHORT: [usize; 2] = [20, 4];
const LONG: [usize; 2] = [28, 8];

/// Name of a texture, in lower case, and its size in texels; 64×64, the most common size, if the map does not store it.
pub(in crate::quake) struct Image {
    pub(in crate::quake) name: String,
    size: [f32; 2],
}

/// Texture projection of a face: texels are `axis · position + offset`, for both texture axes.
pub(in crate::quake) struct Placing {
    axes: [[f32; 4]; 2],
    pub(in crate::quake) image: u32,
}

/// The lumps that define the vertices of faces.
pub(in crate::quake) struct Outlines<'a> {
    map: &'a Map,
    edges: std::slice::ChunksExact<'a, u8>,
    vertices: std::slice::ChunksExact<'a, u8>,
    walks: std::slice::ChunksExact<'a, u8>,
}

impl<'a> Outlines<'a> {
    pub(in crate::quake) fn of(map: &'a Map) -> Result<Outlines<'a>, BspError> {
        let [_, edge_bytes] = if map.format.is_short { SHORT } else { LONG };
        Ok(Outlines {
            map,
            edges: map.records(EDGES, edge_bytes)?,
            vertices: map.records(VERTICES.0, VERTICES.1)?,
            walks: map.records(WALKS.0, WALKS.1)?,
        })
    }

    /// Returns the range of surface edges of face number `at`.
    fn walks_around(&self, at: usize, face: &[u8]) -> Result<Range<usize>, BspError> {
        let [first, count] = match self.map.format.is_short {
            true => [int(face, 4).into(), i64::from(short(face, 8))],
            false => [8, 12].map(|place| i64::from(int(face, place))),
        };
        let end = first.checked_add(count).filter(|_| first >= 0 && count >= 0);
        let end = end.filter(|&end| end <= self.walks.len() as i64);
        match end {
            Some(end) => Ok(first as usize..end as usize),
            None => Err(BspError::NoSuch {
                what: "face",
                at,
                names: "edges up to",
                number: first.saturating_add(count),
                count: self.walks.len(),
            }),
        }
    }

    /// Replaces `outline` by the vertices of face number `at`, counter-clockwise when seen from the front.
    pub(in crate::quake) fn read(
        &self,
        at: usize,
        face: &[u8],
        outline: &mut Vec<[f32; 3]>,
    ) -> Result<(), BspError> {
        outline.clear();
        for walk in self.walks_around(at, face)?.rev() {
            outline.push(self.vertex(at, walk)?);
        }
        Ok(())
    }

    /// Returns the first vertex of a surface edge; negative edges are reversed.
    fn vertex(&self, face: usize, walk: usize) -> Result<[f32; 3], BspError> {
        let edge = i64::from(int(self.map.lump(WALKS.0), 4 * walk));
        let at = in_range("face", face, "edge", edge.abs(), self.edges.len())? as usize;
        let is_short = self.map.format.is_short;
        let [_, edge_bytes] = if is_short { SHORT } else { LONG };
        let edge_at = &self.map.lump(EDGES)[at * edge_bytes..];
        let end = usize::from(edge < 0);
        let vertex = match is_short {
            true => short(edge_at, 2 * end).into(),
            false => i64::from(int(edge_at, 4 * end) as u32),
        };
        let vertex = in_range("edge", at, "vertex", vertex, self.vertices.len())? as usize;
        let place = &self.map.lump(VERTICES.0)[vertex * 12..];
        let place = [0, 4, 8].map(|axis| number(place, axis));
        match place.iter().all(|value| value.is_finite()) {
            true => Ok(place),
            false => Err(BspError::NotFinite {
                what: "vertex",
                at: vertex,
            }),
        }
    }
}

/// Returns the records of all faces.
pub(in crate::quake) fn faces(map: &Map) -> Result<std::slice::ChunksExact<'_, u8>, BspError> {
    let [face_bytes, _] = if map.format.is_short { SHORT } else { LONG };
    map.records(FACES, face_bytes)
}

/// Returns the plane, plane side and texture projection of a face.
pub(in crate::quake) fn plane_side_placing(map: &Map, face: &[u8]) -> [i64; 3] {
    match map.format.is_short {
        true => [0, 2, 10].map(|place| i64::from(short(face, place))),
        false => [0, 4, 16].map(|place| i64::from(int(face, place))),
    }
}

/// Returns the normal of a face on this side of a plane.
pub(in crate::quake) fn front(plane: &SplitPlane, side: i64) -> DVec3 {
    DVec3::from(plane.normal) * if side == 0 { 1.0 } else { -1.0 }
}

/// Reads all faces.
pub(super) fn read(
    map: &Map,
    tree: &Tree,
    looks: &mut Looks,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Surfaces, BrokenRule> {
    let lump = map.lump(TEXTURES);
    let textures = lump.first_chunk().map_or(0, |four| u32::from_le_bytes(*four));
    let textures = u64::from(textures).min(lump.len() as u64 / 4);
    budget.take(textures * BYTES_PER_IMAGE, || "its textures".to_owned())?;
    let images = images(map)?;
    let outlines = Outlines::of(map)?;
    let faces = faces(map)?;
    let mut corners = 0;
    for (at, face) in faces.clone().enumerate() {
        corners += outlines.walks_around(at, face)?.len() as u64;
    }
    Surfaces::afford(budget, faces.len() as u64, corners, corners)?;

    let placings = placings(map, images.len())?;
    let mut light = FaceLight::of(map).filter(|_| looks.has_images());
    let mut lit_corners: Vec<Range<usize>> = Vec::new();
    let mut surfaces = Surfaces::default();
    let mut cutter = Cutter::default();
    let (mut outline, mut triangles) = (Vec::new(), Vec::new());
    for (at, face) in faces.enumerate() {
        let [plane, side, placing] = plane_side_placing(map, face);
        let plane = in_range("face", at, "plane", plane, tree.planes.len())?;
        let placing = &placings[in_range("face", at, "texture placing", placing, placings.len())? as usize];
        outlines.read(at, face, &mut outline)?;
        let plane = tree.planes[plane as usize];
        let front = front(&plane, side);
        let Some(kind) = kind(placing, &images, || behind(tree, &outline, front)) else {
            surfaces.faces.push(None);
            continue;
        };
        let lit = match &mut light {
            Some(light) if matches!(kind, Kind::Wall | Kind::Fence) => {
                let (styles, offset) = styles_and_offset(map, face);
                let corners: Vec<_> = outline.iter().map(|&place| placing.texels(place)).collect();
                let lit = light.add(&corners, offset, styles, budget)?;
                if lit.is_none() {
                    warnings.name(WarningKind::Lightmaps, || format!("face {at}"));
                }
                lit
            }
            _ => None,
        };
        let name = images.get(placing.image as usize).map_or("", |image| &image.name);
        let page = lit.as_ref().map(|_| light::number(0));
        let material = looks.material(placing.image, name, kind, false, kind.non_occluder(), page);
        let size = images
            .get(placing.image as usize)
            .map_or([64.0; 2], |image| image.size);
        let first = surfaces.positions.len() as u32;
        surfaces
            .positions
            .extend(outline.iter().map(|&place| turned(place)));
        match lit {
            Some(lit) => {
                lit_corners.push(first as usize..surfaces.positions.len());
                let places = outline.iter().map(|&place| lit.at(placing.texels(place)));
                surfaces.texture.extend(places);
            }
            None => {
                let places = outline.iter().map(|&place| placing.at(place, size));
                surfaces.texture.extend(places);
            }
        }
        triangles.clear();
        cutter.cut(&surfaces.positions[first as usize..], &mut triangles);
        let start = surfaces.triangles.len();
        surfaces.triangles.extend(
            triangles
                .iter()
                .map(|corners| corners.map(|corner| first + corner)),
        );
        surfaces.faces.push(Some(Face {
            triangles: start..surfaces.triangles.len(),
            material,
            moves: false,
        }));
    }
    if let Some((texture, size)) = light.and_then(FaceLight::texture) {
        looks.light.push(texture);
        for place in lit_corners.into_iter().flatten() {
            let [u, v] = surfaces.texture[place];
            surfaces.texture[place] = [u / size[0], v / size[1]];
        }
    }
    Ok(surfaces)
}

/// Returns the light styles of a face, and the offset of its samples in the light lump; negative if it has none.
fn styles_and_offset(map: &Map, face: &[u8]) -> ([u8; 4], i64) {
    let styles = if map.format.is_short { 12 } else { 20 };
    let bytes = [0, 1, 2, 3].map(|at| face[styles + at]);
    (bytes, int(face, styles + 4).into())
}

impl Placing {
    /// Projects a position to texels.
    fn texels(&self, place: [f32; 3]) -> [f64; 2] {
        [0, 1].map(|way| {
            let [x, y, z, offset] = self.axes[way].map(f64::from);
            DVec3::new(x, y, z).dot(DVec3::from(place.map(f64::from))) + offset
        })
    }

    /// Projects a position to texture coordinates of an image of `size` texels; 0 if they are not finite.
    fn at(&self, place: [f32; 3], size: [f32; 2]) -> [f32; 2] {
        let [u, v] = [0, 1].map(|way| {
            let [x, y, z, offset] = self.axes[way];
            (Vec3::new(x, y, z).dot(Vec3::from(place)) + offset) / size[way]
        });
        if u.is_finite() && v.is_finite() {
            [u, v]
        } else {
            [0.0; 2]
        }
    }
}

/// Reads the texture projections.
pub(in crate::quake) fn placings(map: &Map, images: usize) -> Result<Vec<Placing>, BspError> {
    let read = |(at, placing): (usize, &[u8])| {
        let image = i64::from(int(placing, 32));
        // Compilers that find no texture file write a map without textures.
        let image = if images == 0 { 0 } else { image };
        Ok(Placing {
            axes: [0, 16].map(|way| [0, 4, 8, 12].map(|part| number(placing, way + part))),
            image: in_range("texture placing", at, "texture", image, images.max(1))?,
        })
    };
    map.records(PLACINGS.0, PLACINGS.1)?
        .enumerate()
        .map(read)
        .collect()
}

/// Memory of the name of a texture, and of the material that it becomes, in bytes.
const BYTES_PER_IMAGE: u64 = 100;

/// Reads the names and sizes of the textures.
pub(in crate::quake) fn images(map: &Map) -> Result<Vec<Image>, BspError> {
    let lump = map.lump(TEXTURES);
    if lump.is_empty() {
        return Ok(Vec::new());
    }
    let cut_short = |at: usize| BspError::CutShort {
        part: format!("texture {at}"),
        has: lump.len(),
    };
    let count = lump.first_chunk().map_or(-1, |four| i32::from_le_bytes(*four));
    let starts = usize::try_from(count).ok().and_then(|count| {
        let bytes = count.checked_mul(4)?.checked_add(4)?;
        lump.get(4..bytes)
    });
    let starts = starts.ok_or_else(|| cut_short(0))?;
    let read = |(at, start): (usize, &[u8])| {
        let start = int(start, 0);
        if start == -1 {
            return Ok(Image {
                name: String::new(),
                size: [64.0; 2],
            });
        }
        let image = usize::try_from(start)
            .ok()
            .and_then(|start| lump.get(start..)?.get(..24));
        let image = image.ok_or_else(|| cut_short(at))?;
        let name = image[..16].split(|&byte| byte == 0).next().unwrap_or(&[]);
        let side = |place: usize| match int(image, place) {
            side @ 1..=0x1_0000 => side as f32,
            _ => 64.0,
        };
        Ok(Image {
            name: String::from_utf8_lossy(name).to_lowercase(),
            size: [side(16), side(20)],
        })
    };
    starts.chunks_exact(4).enumerate().map(read).collect()
}

/// Returns the kind of a face; `None` if engines do not draw it.
fn kind(placing: &Placing, images: &[Image], behind: impl FnOnce() -> Kind) -> Option<Kind> {
    const UNSEEN: [&str; 6] = ["trigger", "clip", "skip", "hint", "hintskip", "origin"];
    let name = images.get(placing.image as usize).map_or("", |image| &image.name);
    if UNSEEN.contains(&name) {
        return None;
    }
    Some(match name.as_bytes() {
        [] => behind(),
        [b's', b'k', b'y', ..] => Kind::Sky,
        [b'*' | b'!', ..] => [("lava", Kind::Lava), ("slime", Kind::Slime), ("tele", Kind::Gate)]
            .into_iter()
            .find_map(|(word, kind)| name.contains(word).then_some(kind))
            .unwrap_or(Kind::Water),
        [b'{', ..] => Kind::Fence,
        _ => Kind::Wall,
    })
}

/// Returns the kind of a face by the contents in front of it and behind it: a wall, unless exactly one side is sky or
/// liquid.
pub(in crate::quake) fn behind(tree: &Tree, outline: &[[f32; 3]], front: DVec3) -> Kind {
    let sum: DVec3 = outline
        .iter()
        .map(|place| DVec3::from(place.map(f64::from)))
        .sum();
    let middle = sum / outline.len().max(1) as f64;
    let [before, behind] = [1.0, -1.0].map(|way| tree.kind_at(middle + way * front));
    let kind = |kind: i32| match kind {
        -3 => Some(Kind::Water),
        -4 => Some(Kind::Slime),
        -5 => Some(Kind::Lava),
        -6 => Some(Kind::Sky),
        _ => None,
    };
    const SOLID: i32 = -2;
    if before == behind || behind == SOLID {
        return Kind::Wall;
    }
    kind(behind).or(kind(before)).unwrap_or(Kind::Wall)
}

impl Tree {
    /// Returns the contents of the leaf that contains a point.
    fn kind_at(&self, point: DVec3) -> i32 {
        let mut child = self.root;
        loop {
            match child {
                Child::Leaf(leaf) => return self.leafs[leaf as usize].kind,
                Child::Node(node) => {
                    let node = &self.nodes[node as usize];
                    let plane = &self.planes[node.plane as usize];
                    let is_behind = DVec3::from(plane.normal).dot(point) < plane.offset;
                    child = node.children[usize::from(is_behind)];
                }
            }
        }
    }
}
