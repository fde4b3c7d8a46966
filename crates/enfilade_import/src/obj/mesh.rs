//! Builds meshes from the faces of a group: triangulates them and collects their vertices.

use super::ObjError;
use super::corner::Corner;
use super::groups::{Group, Run};
use super::materials::Placing;
use super::parse::{Faces, Tables};
use super::polygon::Cutter;
use super::smooth::SmoothNormals;
use super::survey::Piece;
use super::text::Lines;
use crate::BrokenRule;
use enfilade::{Attributes, Indices, MaterialId, Mesh, Part, Vertices};
use rayon::prelude::*;
use std::ops::AddAssign;

/// The input of all meshes.
pub(super) struct Source<'a> {
    pub(super) pieces: &'a [Piece<'a>],
    pub(super) faces: &'a [Faces<'a>],
    pub(super) tables: &'a Tables,
    /// One per material, including the default material.
    pub(super) placings: &'a [Option<Placing>],
}

/// Number of triangles, and of corners of the polygons that they come from.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Size {
    pub(super) triangles: u64,
    pub(super) corners: u64,
    /// Those of polygons of more than 16.
    pub(super) polygon_corners: u64,
}

impl AddAssign for Size {
    fn add_assign(&mut self, more: Size) {
        self.triangles += more.triangles;
        self.corners += more.corners;
        self.polygon_corners += more.polygon_corners;
    }
}

/// A mesh, and the self-intersecting faces as chunk and face indices.
pub(super) struct BuiltMesh {
    pub(super) mesh: Mesh,
    pub(super) rough: Vec<(usize, usize)>,
}

/// Faces of one material, as an indexed triangle list.
struct Triangles {
    material: usize,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    texture: Vec<[f32; 2]>,
    colors: Vec<[f32; 4]>,
    corners: Vec<u32>,
}

/// Key of a vertex: a corner, and its smoothing group if its normal is computed.
type Key = (Corner, u32);

/// Keys with their corner positions in the triangle list.
type Keys = Vec<(Key, u32)>;

impl Source<'_> {
    /// Returns the size of a group, or an upper bound.
    pub(super) fn size(&self, group: &Group) -> Size {
        let mut size = Size::default();
        group.runs.iter().for_each(|run| size += self.size_of(run));
        size
    }

    fn size_of(&self, run: &Run) -> Size {
        let faces = &self.faces[run.piece];
        let mut size = Size::default();
        for face in run.faces.clone() {
            let corners = faces.face(face).len() as u64;
            size += Size {
                triangles: corners - 2,
                corners,
                polygon_corners: if corners > 16 { corners } else { 0 },
            };
        }
        size
    }

    /// Builds the mesh of a group.
    pub(super) fn build(&self, group: &Group) -> Result<BuiltMesh, BrokenRule> {
        let plain = self.placings.len() - 1;
        let mut runs: Vec<(usize, &Run)> = group
            .runs
            .iter()
            .map(|run| (run.material.unwrap_or(plain), run))
            .collect();
        runs.sort_by_key(|&(material, _)| material);
        let smooth = SmoothNormals::of(group, self.faces, self.tables);
        let mut cutter = Cutter::default();
        let mut rough = Vec::new();
        let mut read = Vec::new();
        for of_one in runs.chunk_by(|(a, _), (b, _)| a == b) {
            let material = of_one[0].0;
            let triangles = of_one
                .iter()
                .map(|(_, run)| self.size_of(run).triangles)
                .sum::<u64>();
            let mut keys = Keys::with_capacity(3 * triangles as usize);
            for (_, run) in of_one {
                self.cut(run, &mut cutter, &mut keys, &mut rough)?;
            }
            read.push(self.gather(material, keys, &smooth));
        }
        let parts: Vec<Part> = read.iter().map(Triangles::part).collect();
        let mesh = Mesh::new(&parts).map_err(|why| BrokenRule::Mesh {
            place: format!("group {:?}", group.name),
            why,
        })?;
        Ok(BuiltMesh { mesh, rough })
    }

    /// Triangulates the faces of a run.
    fn cut(
        &self,
        run: &Run,
        cutter: &mut Cutter,
        keys: &mut Keys,
        rough: &mut Vec<(usize, usize)>,
    ) -> Result<(), BrokenRule> {
        let faces = &self.faces[run.piece];
        let number = run.smooth.map_or(0, std::num::NonZeroU32::get);
        let has_image = self.placings[run.material.unwrap_or(self.placings.len() - 1)].is_some();
        let key = |corner: Corner| {
            let texture = corner.texture.filter(|_| has_image);
            let group = if corner.normal.is_none() { number } else { 0 };
            (Corner { texture, ..corner }, group)
        };
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for face in run.faces.clone() {
            let corners = faces.face(face);
            positions.clear();
            positions.extend(
                corners
                    .iter()
                    .map(|corner| self.tables.positions[corner.position as usize]),
            );
            if let Some(bad) = positions
                .iter()
                .position(|p| p.iter().any(|value| !value.is_finite()))
            {
                return Err(ObjError::PositionNotFinite {
                    line: self.line(run.piece, face),
                    position: corners[bad].position as usize + 1,
                }
                .into());
            }
            if let [a, b, c] = *corners {
                push(keys, [a, b, c].into_iter().map(key));
                continue;
            }
            triangles.clear();
            if !cutter.cut(&positions, &mut triangles) {
                rough.push((run.piece, face));
            }
            let corners = triangles.iter().flatten().map(|&place| corners[place as usize]);
            push(keys, corners.map(key));
        }
        Ok(())
    }

    /// Returns the line of a face. Searches the text, because only messages need it.
    pub(super) fn line(&self, piece: usize, face: usize) -> usize {
        let piece = &self.pieces[piece];
        Lines::of(piece.text, piece.before.lines)
            .filter(|line| matches!(line.keyword(), b"f" | b"fo") && line.words().nth(2).is_some())
            .nth(face)
            .map_or(0, |line| line.number)
    }

    /// Merges equal keys into vertices.
    fn gather(&self, material: usize, mut keys: Keys, smooth: &SmoothNormals) -> Triangles {
        // Sorted instead of hashed, so that no file can make this slow.
        keys.par_sort_unstable();
        let runs = || keys.chunk_by(|(a, _), (b, _)| a == b);
        let mut different: Vec<Key> = Vec::with_capacity(runs().count());
        let mut corners = vec![0; keys.len()];
        for run in runs() {
            run.iter()
                .for_each(|(_, place)| corners[*place as usize] = different.len() as u32);
            different.push(run[0].0);
        }
        drop(keys);
        let tables = self.tables;
        let all = || different.iter().map(|(corner, _)| corner);
        let positions = all()
            .map(|corner| tables.positions[corner.position as usize])
            .collect();
        let normal = |(corner, group): &Key| match corner.normal {
            Some(number) => tables.normals[number.get() as usize - 1],
            None => smooth.at(corner.position, *group),
        };
        let any_normal = different
            .iter()
            .any(|(corner, group)| corner.normal.is_some() || *group > 0);
        let placing = self.placings[material].filter(|_| all().any(|corner| corner.texture.is_some()));
        let place = |placing: &Placing, corner: &Corner| match corner.texture {
            Some(number) => placing.place(tables.texture[number.get() as usize - 1]),
            None => [0.0; 2],
        };
        let color = |corner: &Corner| tables.colors[corner.position as usize];
        let any_color = !tables.colors.is_empty() && all().any(|corner| color(corner) != [1.0; 3]);
        Triangles {
            material,
            positions,
            normals: if any_normal {
                different.iter().map(normal).collect()
            } else {
                Vec::new()
            },
            texture: placing.map_or(Vec::new(), |placing| {
                all().map(|corner| place(&placing, corner)).collect()
            }),
            colors: if any_color {
                all().map(|corner| linear(color(corner))).collect()
            } else {
                Vec::new()
            },
            corners,
        }
    }
}

fn push(keys: &mut Keys, more: impl Iterator<Item = Key>) {
    let first = keys.len() as u32;
    keys.extend(more.zip(first..));
}

impl Triangles {
    fn part(&self) -> Part<'_> {
        Part {
            positions: Vertices::Packed(&self.positions),
            corners: Indices::U32(&self.corners),
            sides: None,
            material: MaterialId(self.material as u32),
            attributes: Attributes {
                normals: Vertices::Packed(&self.normals),
                texture: Vertices::Packed(&self.texture),
                colors: Vertices::Packed(&self.colors),
            },
        }
    }
}

/// Converts vertex colors from sRGB to linear; Blender and scanners write them as sRGB.
fn linear(color: [f32; 3]) -> [f32; 4] {
    let [r, g, b] = color.map(|value| {
        let value = value.clamp(0.0, 1.0);
        if value <= 0.04045 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        }
    });
    [r, g, b, 1.0]
}
