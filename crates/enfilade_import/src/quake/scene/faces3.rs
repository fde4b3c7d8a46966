//! Reads the faces of Quake 3 maps: triangle meshes and Bézier patches, whose vertices have normals, colors and texture
//! coordinates.
//!
//! Triangles are clockwise when seen from the front. Flares are glare sprites, not surfaces, and are not drawn.

use super::axes::turned;
use super::light;
use super::looks::{Kind, Looks};
use super::patch::{STEPS, tessellate};
use super::shaders::Shaders;
use super::surfaces::{Face, Surfaces};
use crate::budget::Budget;
use crate::quake::BspError;
use crate::quake::bsp::{Map, in_range, int, number};
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, NonOccluder};
use enfilade::{MaterialId, TextureId};
use std::collections::HashSet;
use std::ops::Range;

/// Lumps that faces are made of, with record sizes in bytes.
const TEXTURES: (usize, usize) = (1, 72);
const CORNERS: (usize, usize) = (10, 44);
const TRIANGLES: (usize, usize) = (11, 4);
const FACES: (usize, usize) = (13, 104);

/// Offset of the lightmap index in a face record, in bytes.
const LIGHT: usize = 28;

/// Surface flags of a texture.
const SKY: i32 = 0x4;
const UNSEEN: i32 = 0x80 | 0x100 | 0x200;
const NOT_SOLID: i32 = 0x4000;
/// Light passes through as the texture's colors or alpha let it: stained glass, gratings.
const LIGHT_PASSES: i32 = 0x8000 | 0x1_0000;
/// Content flags of a texture.
const SOLID: i32 = 0x1;
const LAVA: i32 = 0x8;
const SLIME: i32 = 0x10;
const WATER: i32 = 0x20;
/// Translucent, or fog.
const SEEN_THROUGH: i32 = 0x2000_0000 | 0x40;

/// A vertex of a map, before the change of axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Corner {
    pub(super) position: [f32; 3],
    pub(super) texture: [f32; 2],
    /// Lightmap coordinates.
    pub(super) light: [f32; 2],
    pub(super) normal: [f32; 3],
    pub(super) color: [f32; 4],
}

/// The validated ranges of a face.
struct Shape {
    kind: i32,
    corners: Range<usize>,
    triangles: Range<usize>,
    size: [usize; 2],
}

/// Reads all faces.
pub(super) fn read(
    map: &Map,
    shaders: &Shaders,
    looks: &mut Looks,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Surfaces, BrokenRule> {
    let corners = map.records(CORNERS.0, CORNERS.1)?.len();
    let indices = map.records(TRIANGLES.0, TRIANGLES.1)?;
    let faces = map.records(FACES.0, FACES.1)?;
    let texture_count = map.records(TEXTURES.0, TEXTURES.1)?.len();
    let shape = |at: usize, face: &[u8]| shape(at, face, corners, indices.len());
    let (mut all_corners, mut all_triangles) = (0, 0);
    for (at, face) in faces.clone().enumerate() {
        let shape = shape(at, face)?;
        let (corners, triangles) = match shape.kind {
            PATCH => {
                let [columns, rows] = shape.size.map(|size| (size as u64 - 1) / 2 * STEPS as u64);
                ((columns + 1) * (rows + 1), 2 * columns * rows)
            }
            _ => (shape.corners.len() as u64, shape.triangles.len() as u64 / 3),
        };
        all_corners += corners;
        all_triangles += triangles;
    }
    Surfaces::afford(budget, faces.len() as u64, all_corners, all_triangles)?;

    if looks.has_images() {
        looks.light = light::pages(map, budget)?;
    }
    let mut surfaces = Surfaces::default();
    let mut patch = Vec::new();
    for (at, face) in faces.enumerate() {
        let texture = in_range("face", at, "texture", int(face, 0).into(), texture_count)?;
        let shape = shape(at, face)?;
        let flat_or_mesh = matches!(shape.kind, POLYGON | MESH);
        if !flat_or_mesh && shape.kind != PATCH {
            warnings.name(WarningKind::Flares, || format!("face {at}"));
        }
        let page = usize::try_from(int(face, LIGHT)).ok();
        let page = page.filter(|&page| page < looks.light.len()).map(light::number);
        let drawn = (flat_or_mesh || shape.kind == PATCH)
            .then(|| material(map, texture, page, shaders, looks))
            .flatten();
        let Some(drawn) = drawn else {
            surfaces.faces.push(None);
            continue;
        };
        let first = surfaces.positions.len() as u32;
        let start = surfaces.triangles.len();
        if shape.kind == PATCH {
            patch.clear();
            for number in shape.corners.clone() {
                patch.push(corner(map, number)?);
            }
            let grid = tessellate(&patch, shape.size);
            grid.corners
                .iter()
                .for_each(|corner| surfaces.push(corner, drawn.is_lit));
            let triangles = grid.triangles.iter();
            surfaces
                .triangles
                .extend(triangles.map(|corners| corners.map(|corner| first + corner)));
        } else {
            for number in shape.corners.clone() {
                surfaces.push(&corner(map, number)?, drawn.is_lit);
            }
            for place in shape.triangles.clone().step_by(3) {
                // From clockwise to counter-clockwise.
                let mut triangle = [0; 3];
                for (end, back) in triangle.iter_mut().zip([0, 2, 1]) {
                    let number = int(map.lump(TRIANGLES.0), 4 * (place + back));
                    let number = in_range("face", at, "corner", number.into(), shape.corners.len())?;
                    *end = first + number;
                }
                surfaces.triangles.push(triangle);
            }
        }
        surfaces.faces.push(Some(Face {
            triangles: start..surfaces.triangles.len(),
            material: drawn.material,
            moves: drawn.moves,
        }));
    }
    surfaces.even_out_colors();
    Ok(surfaces)
}

const POLYGON: i32 = 1;
const PATCH: i32 = 2;
const MESH: i32 = 3;

fn shape(at: usize, face: &[u8], corners: usize, triangles: usize) -> Result<Shape, BspError> {
    let range = |place: usize, names: &'static str, of: usize| {
        let [first, count] = [place, place + 4].map(|place| i64::from(int(face, place)));
        if first >= 0 && count >= 0 && first + count <= of as i64 {
            return Ok(first as usize..(first + count) as usize);
        }
        Err(BspError::NoSuch {
            what: "face",
            at,
            names,
            number: first + count,
            count: of,
        })
    };
    let kind = int(face, 8);
    let mut shape = Shape {
        kind,
        corners: range(12, "corners up to", corners)?,
        triangles: 0..0,
        size: [0; 2],
    };
    if kind == PATCH {
        let size = [96, 100].map(|place| int(face, place));
        let are_odd = size.iter().all(|&side| side >= 3 && side % 2 == 1);
        let count = i64::from(size[0]) * i64::from(size[1]);
        if !are_odd || count != shape.corners.len() as i64 {
            return Err(BspError::BadPatch { face: at, size });
        }
        shape.size = size.map(|side| side as usize);
    } else {
        let range = range(20, "corners of triangles up to", triangles)?;
        shape.triangles = range.start..range.end - range.len() % 3;
    }
    Ok(shape)
}

fn corner(map: &Map, at: usize) -> Result<Corner, BspError> {
    let bytes = &map.lump(CORNERS.0)[at * CORNERS.1..][..CORNERS.1];
    let position = [0, 4, 8].map(|place| number(bytes, place));
    if position.iter().any(|value| !value.is_finite()) {
        return Err(BspError::NotFinite { what: "corner", at });
    }
    let or_zero = |place| {
        Some(number(bytes, place))
            .filter(|value| value.is_finite())
            .unwrap_or(0.0)
    };
    // Vertex colors are stored gamma-encoded.
    let color = [40, 41, 42].map(|place: usize| (f32::from(bytes[place]) / 255.0).powi(2));
    Ok(Corner {
        position,
        texture: [12, 16].map(or_zero),
        light: [20, 24].map(or_zero),
        normal: [28, 32, 36].map(or_zero),
        color: [color[0], color[1], color[2], 1.0],
    })
}

/// Returns the names of the textures, in lower case.
pub(super) fn names(map: &Map) -> Result<HashSet<String>, BspError> {
    Ok(map.records(TEXTURES.0, TEXTURES.1)?.map(name).collect())
}

/// Returns the name of a texture, in lower case, and as the engine does without the ending of an image.
fn name(texture: &[u8]) -> String {
    let name = texture[..64].split(|&byte| byte == 0).next().unwrap_or(&[]);
    let name = String::from_utf8_lossy(name).to_lowercase();
    let image = [".tga", ".jpg", ".png"]
        .iter()
        .find_map(|end| name.strip_suffix(end));
    image.map(str::to_owned).unwrap_or(name)
}

/// How a face is drawn.
struct Drawn {
    material: MaterialId,
    /// Whether its lightmap is used.
    is_lit: bool,
    /// Whether engines draw it elsewhere than where the map has it.
    moves: bool,
}

/// Returns how a face is drawn; `None` if engines do not draw it.
fn material(
    map: &Map,
    texture: u32,
    page: Option<TextureId>,
    shaders: &Shaders,
    looks: &mut Looks,
) -> Option<Drawn> {
    const TOOLS: [&str; 12] = [
        "caulk",
        "clip",
        "hint",
        "hintskip",
        "skip",
        "trigger",
        "nodraw",
        "areaportal",
        "weapclip",
        "origin",
        "lightgrid",
        "antiportal",
    ];
    let bytes = &map.lump(TEXTURES.0)[texture as usize * TEXTURES.1..][..TEXTURES.1];
    let name = name(bytes);
    let [surface, content] = [64, 68].map(|place| int(bytes, place));
    let mut path = name.rsplit('/');
    let end = path.next().unwrap_or("");
    // Maps compiled without the game's shader scripts lack the flags of tool textures, so these are recognised by name.
    let is_tool = path.next() == Some("common") && TOOLS.contains(&end);
    if surface & UNSEEN != 0 || is_tool {
        return None;
    }
    let kind = [(LAVA, Kind::Lava), (SLIME, Kind::Slime), (WATER, Kind::Water)]
        .into_iter()
        .find_map(|(bit, kind)| (content & bit != 0).then_some(kind));
    let kind = match kind {
        _ if surface & SKY != 0 => Kind::Sky,
        Some(kind) => kind,
        None if end.contains("tele") && end.contains('#') => Kind::Gate,
        None if content & SEEN_THROUGH != 0 && end.contains("glass") => Kind::Glass,
        None => Kind::Wall,
    };
    // Liquids have a single face that is also visible from below.
    let shader = shaders.of(&name);
    let double_sided =
        shader.double_sided || matches!(kind, Kind::Water | Kind::Slime | Kind::Lava | Kind::Glass);
    let light = page.filter(|_| kind == Kind::Wall);
    let by_flags = [
        (surface & SKY != 0, NonOccluder::Sky),
        (
            content & SEEN_THROUGH != 0 || surface & LIGHT_PASSES != 0,
            NonOccluder::Translucent,
        ),
        (
            content & SOLID == 0 || surface & NOT_SOLID != 0,
            NonOccluder::NotSolid,
        ),
    ];
    let by_flags = by_flags.iter().find(|(holds, _)| *holds).map(|&(_, why)| why);
    let why = kind.non_occluder().or(by_flags).or(shader.non_occluder);
    let material = looks.material(texture, &name, kind, double_sided, why, light);
    Some(Drawn {
        material,
        is_lit: light.is_some(),
        moves: shader.moves,
    })
}

impl Surfaces {
    /// Adds a vertex; for a face with a lightmap, with its lightmap coordinates and without its color.
    fn push(&mut self, corner: &Corner, is_lit: bool) {
        let (texture, color) = if is_lit {
            (corner.light, [1.0; 4])
        } else {
            (corner.texture, corner.color)
        };
        self.positions.push(turned(corner.position));
        self.texture.push(texture);
        self.normals.push(turned(corner.normal));
        self.colors.push(color);
    }

    /// Scales vertex colors, which hold the computed light. If all are equal, no light was computed, and they are
    /// dropped. The game shows half intensity as white. A constant ambient part keeps vertices from being black.
    fn even_out_colors(&mut self) {
        const EVERYWHERE: f32 = 0.4;
        if self.colors.iter().all(|color| *color == self.colors[0]) {
            self.colors.clear();
        }
        for color in &mut self.colors {
            let [r, g, b, _] = color.map(|part| EVERYWHERE + (1.0 - EVERYWHERE) * (2.0 * part).min(1.0));
            *color = [r, g, b, 1.0];
        }
    }
}
