//! Meshes: planned from the document alone, then built from the buffers.
//!
//! A part copies only the positions that its triangles use. So a large accessor shared by a thousand primitives is not
//! copied or searched a thousand times, and invalid positions that no triangle uses are harmless.
//! Cost: O(triangles), or O(triangles · log triangles) if the positions of a part are scattered; memory O(triangles).

use super::accessor::{AccessorUse, Row};
use super::attributes::{AttributePlan, VertexAttributes};
use super::buffers::Buffers;
use super::deform::{DeformPlan, Deformed};
use super::document::{Document, Primitive, Semantic, find};
use super::materials::{Surface, default_material};
use super::poses::{PosedMesh, Skins};
use super::topology::Topology;
use crate::BrokenRule;
use crate::budget::{BYTES_PER_MESH, Budget};
use crate::warning::{WarningKind, Warnings};
use enfilade::{Indices, MaterialId, Mesh, Part, Vertices};
use glam::DVec3;

/// A mesh of the document in a pose, checked as far as possible without its bytes.
#[derive(Debug)]
pub(super) struct MeshPlan {
    posed: PosedMesh,
    parts: Vec<PartPlan>,
    triangles: u64,
    /// Bytes per triangle to deform it.
    deform_bytes: u64,
    /// Attribute bytes per vertex.
    carried_bytes: u64,
}

/// A mesh and the warnings from its bytes.
pub(super) struct BuiltMesh {
    pub(super) mesh: Mesh,
    /// The point in the world that the positions of a skinned mesh are relative to.
    pub(super) origin: Option<[f32; 3]>,
    /// Kind and primitive of each warning, in order.
    pub(super) oddities: Vec<(WarningKind, String)>,
}

/// A primitive with triangles.
#[derive(Debug)]
struct PartPlan {
    primitive: usize,
    positions: Row,
    indices: Option<Row>,
    topology: Topology,
    material: MaterialId,
    attributes: AttributePlan,
    deform: DeformPlan,
}

/// Maximum bytes per triangle of a mesh, if it shares no vertex, without attributes.
const BYTES_KEPT: u64 = 52;
/// Additional bytes per triangle while a mesh is built.
const BYTES_AT_WORK: u64 = 132;
/// Maximum number of triangles of meshes that are built at the same time, unless a single mesh has more. So memory use
/// does not grow with the number of threads.
const BATCH_TRIANGLES: u64 = 1_000_000;
/// Additional bytes per triangle while a mesh is deformed: positions in f64, and for a skin a matrix per vertex.
const BYTES_TO_MORPH: u64 = 3 * size_of::<DVec3>() as u64;
const BYTES_TO_SKIN: u64 = BYTES_TO_MORPH + 3 * size_of::<glam::DMat3>() as u64;
/// Maximum number of values that are added up to deform one mesh, which takes some ten seconds.
const MAX_TERMS: u64 = 1_000_000_000;

/// Splits the meshes into batches that are built in parallel.
pub(super) fn batches(plans: &[MeshPlan]) -> impl Iterator<Item = &[MeshPlan]> {
    let mut rest = plans;
    std::iter::from_fn(move || {
        let mut triangles = 0;
        let full = rest.iter().position(|plan| {
            triangles += plan.triangles;
            triangles > BATCH_TRIANGLES
        });
        let (batch, later) = rest.split_at(full.map_or(rest.len(), |first_too_many| first_too_many.max(1)));
        rest = later;
        (!batch.is_empty()).then_some(batch)
    })
}

/// Returns the memory to build the largest batch, in bytes, without the finished meshes.
pub(super) fn bytes_to_build(plans: &[MeshPlan]) -> u64 {
    let bytes = |plan: &MeshPlan| {
        plan.triangles
            .saturating_mul(BYTES_AT_WORK + 3 * plan.carried_bytes + plan.deform_bytes)
    };
    let together = |batch: &[MeshPlan]| batch.iter().map(bytes).fold(0, u64::saturating_add);
    batches(plans).map(together).max().unwrap_or(0)
}

impl MeshPlan {
    /// Checks an existing mesh and reserves the memory that it will keep.
    pub(super) fn new(
        document: &Document,
        surfaces: &[Surface],
        posed: PosedMesh,
        lenient: bool,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<MeshPlan, BrokenRule> {
        let mut parts = Vec::new();
        let (mut triangles, mut terms) = (0_u64, 0_u64);
        for number in 0..document.meshes[posed.mesh as usize].primitives.len() {
            let part = match PartPlan::new(document, surfaces, &posed, number, budget, warnings) {
                Err(why) if lenient && is_unsupported(&why) => {
                    warnings.name(WarningKind::LeftOut, || place(posed.mesh, number));
                    None
                }
                part => part?,
            };
            if let Some(part) = part {
                triangles = triangles.saturating_add(part.triangles());
                terms = terms.saturating_add(part.terms());
                parts.push(part);
            }
        }
        let place = || format!("meshes[{}]", posed.mesh);
        if terms > MAX_TERMS {
            return Err(BrokenRule::PoseTooCostly {
                place: place(),
                terms,
                most: MAX_TERMS,
            });
        }
        let carried_bytes = AttributePlan::bytes_of_each(parts.iter().map(|part| &part.attributes));
        let bytes = triangles.saturating_mul(BYTES_KEPT + 3 * carried_bytes);
        budget.take(bytes.saturating_add(BYTES_PER_MESH), place)?;
        if triangles >= u64::from(u32::MAX / 3) {
            return Err(BrokenRule::TooManyCorners { place: place() });
        }
        let deform_bytes = parts.iter().map(PartPlan::deform_bytes).max();
        Ok(MeshPlan {
            posed,
            parts,
            triangles,
            deform_bytes: deform_bytes.unwrap_or(0),
            carried_bytes,
        })
    }

    /// Returns the mesh and its pose.
    pub(super) fn posed(&self) -> PosedMesh {
        self.posed
    }

    pub(super) fn triangles(&self) -> u64 {
        self.triangles
    }

    /// Returns the memory of the finished mesh, in bytes.
    pub(super) fn bytes_kept(&self) -> u64 {
        self.triangles.saturating_mul(BYTES_KEPT + 3 * self.carried_bytes)
    }

    /// Returns two primitives with different materials, if there are any.
    pub(super) fn of_two_materials(&self) -> Option<[usize; 2]> {
        let (first, rest) = self.parts.split_first()?;
        let other = rest.iter().find(|part| part.material != first.material)?;
        Some([first.primitive, other.primitive])
    }

    /// Returns the accessors that the mesh is built from; some may repeat.
    pub(super) fn rows(&self) -> impl Iterator<Item = &Row> {
        self.parts.iter().flat_map(|part| {
            let shape = [Some(&part.positions), part.indices.as_ref()];
            let shape = shape.into_iter().flatten();
            shape.chain(part.attributes.rows()).chain(part.deform.rows())
        })
    }

    /// Returns the materials of the mesh; some may repeat.
    pub(super) fn materials(&self) -> impl Iterator<Item = u32> {
        self.parts.iter().map(|part| part.material.0)
    }

    /// Reads the triangles, deforms them and builds the mesh.
    pub(super) fn build(&self, buffers: &Buffers, skins: &Skins) -> Result<BuiltMesh, BrokenRule> {
        let mut read: Vec<Triangles> = self
            .parts
            .iter()
            .map(|part| part.read(self.posed.mesh, buffers, skins))
            .collect::<Result<_, _>>()?;
        let is_skinned = self.parts.iter().any(|part| part.deform.is_skinned());
        let origin = is_skinned.then(|| origin(&read));
        for triangles in &mut read {
            triangles.move_to(origin.unwrap_or_default());
        }
        let parts: Vec<Part> = read
            .iter()
            .zip(&self.parts)
            .map(|(triangles, plan)| Part {
                positions: Vertices::Packed(&triangles.positions),
                corners: Indices::U32(&triangles.corners),
                sides: None,
                material: plan.material,
                attributes: triangles.carried.attributes(),
            })
            .collect();
        let mesh = Mesh::new(&parts).map_err(|why| BrokenRule::Mesh {
            place: format!("meshes[{}]", self.posed.mesh),
            why,
        })?;
        let odd = |(triangles, plan): (&Triangles, &PartPlan)| {
            let place = place(self.posed.mesh, plan.primitive);
            let kinds: Vec<WarningKind> = triangles.carried.oddities().chain(triangles.odd).collect();
            kinds.into_iter().map(move |kind| (kind, place.clone()))
        };
        let oddities = read.iter().zip(&self.parts).flat_map(odd).collect();
        Ok(BuiltMesh {
            mesh,
            origin,
            oddities,
        })
    }
}

/// Returns `true` if an error may be due to an unread extension.
fn is_unsupported(why: &BrokenRule) -> bool {
    matches!(
        why,
        BrokenRule::NotReadYet { .. } | BrokenRule::BadCompression { .. } | BrokenRule::WrongType { .. }
    )
}

/// Returns the point that the positions of a skinned mesh are stored relative to: the world's origin, or the middle of
/// the mesh if it is so far away that f32 would round its shape.
fn origin(parts: &[Triangles]) -> [f32; 3] {
    const FAR: f64 = 1024.0;
    let positions = || parts.iter().flat_map(|part| &part.deformed);
    let least = positions().fold(DVec3::INFINITY, |least, position| least.min(*position));
    let most = positions().fold(DVec3::NEG_INFINITY, |most, position| most.max(*position));
    let middle = (least + most) / 2.0;
    if middle.is_finite() && middle.length() > FAR * (most - least).length() {
        middle.as_vec3().into()
    } else {
        [0.0; 3]
    }
}

impl PartPlan {
    /// Checks a primitive; returns `None` if it has no triangles.
    fn new(
        document: &Document,
        surfaces: &[Surface],
        posed: &PosedMesh,
        number: usize,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<Option<PartPlan>, BrokenRule> {
        let primitive: &Primitive = &document.meshes[posed.mesh as usize].primitives[number];
        let place = || place(posed.mesh, number);
        let topology = match primitive.mode.unwrap_or(4) {
            0 => {
                warnings.name(WarningKind::Points, place);
                return Ok(None);
            }
            1..=3 => {
                warnings.name(WarningKind::Lines, place);
                return Ok(None);
            }
            4 => Topology::List,
            5 => Topology::Strip,
            6 => Topology::Fan,
            mode => return Err(BrokenRule::BadMode { place: place(), mode }),
        };
        let Some(positions) = primitive.attributes.get(Semantic::Position) else {
            warnings.name(WarningKind::NoPositions, place);
            return Ok(None);
        };
        let positions = Row::new(document, positions, AccessorUse::Positions, place)?;
        let indices = match primitive.indices {
            Some(indices) => Some(Row::new(document, indices, AccessorUse::Indices, place)?),
            None => None,
        };
        if primitive.extensions.draco.is_some() && positions.is_zeros() {
            let (what, remedy) = (
                "compressed (KHR_draco_mesh_compression)",
                "export it again without compression",
            );
            return Err(BrokenRule::NotReadYet {
                place: place(),
                what,
                remedy,
            });
        }
        let material = match primitive.material {
            Some(material) => {
                find(&document.materials, material, "material", place)?;
                MaterialId(material)
            }
            None => default_material(document),
        };
        let attributes = AttributePlan::new(
            document,
            primitive,
            positions.count,
            surfaces[material.0 as usize].coordinates,
            &place,
            warnings,
        )?;
        let deformed = Deformed {
            document,
            primitive,
            positions: positions.count,
            texture_set: attributes.texture_set(),
            posed,
            place: &place,
        };
        let deform = DeformPlan::new(&deformed, budget)?;
        let part = PartPlan {
            primitive: number,
            positions,
            indices,
            topology,
            material,
            attributes,
            deform,
        };
        if topology == Topology::List && !part.corners().is_multiple_of(3) {
            warnings.name(WarningKind::CornersLeft, place);
        }
        Ok((part.triangles() > 0).then_some(part))
    }

    /// Returns the number of indices, or of vertices if the primitive is not indexed.
    fn corners(&self) -> u64 {
        self.indices.as_ref().unwrap_or(&self.positions).count
    }

    fn triangles(&self) -> u64 {
        self.topology.triangles(self.corners())
    }

    /// Returns the number of values that are added up to deform it.
    fn terms(&self) -> u64 {
        let vertices = self.corners().min(self.positions.count);
        vertices.saturating_mul(self.deform.terms())
    }

    /// Returns the bytes per triangle to deform it.
    fn deform_bytes(&self) -> u64 {
        match self.deform.is_skinned() {
            true => BYTES_TO_SKIN,
            false if self.deform.terms() > 0 => BYTES_TO_MORPH,
            false => 0,
        }
    }

    /// Reads the triangles and the positions and attributes that they use, and deforms them.
    fn read(&self, mesh: u32, buffers: &Buffers, skins: &Skins) -> Result<Triangles, BrokenRule> {
        let place = || place(mesh, self.primitive);
        let row = match &self.indices {
            Some(indices) => indices.indices(buffers),
            None => (0..self.positions.count as u32).collect(),
        };
        let positions = self.positions.count;
        if let Some(corner) = row.iter().position(|&index| u64::from(index) >= positions) {
            return Err(BrokenRule::IndexOutOfRange {
                place: place(),
                corner,
                index: row[corner],
                positions,
            });
        }
        let mut corners = self.topology.list(row);
        let used = gather(&mut corners);
        let elements = self.positions.elements(buffers);
        let sound = |&position: &u32| {
            let place_of_it: [f32; 3] = elements.floats(position as usize);
            if place_of_it.iter().all(|value| value.is_finite()) {
                Ok(place_of_it)
            } else {
                Err(BrokenRule::PositionNotFinite {
                    place: place(),
                    position,
                })
            }
        };
        let mut positions: Vec<[f32; 3]> = used.iter().map(sound).collect::<Result<_, _>>()?;
        let morph = self.deform.morph(buffers);
        let mut carried = self.attributes.read(&used, buffers, &morph);
        let (mut deformed, mut odd) = (Vec::new(), None);
        if self.deform.terms() > 0 || self.deform.is_skinned() {
            let read = positions.drain(..).zip(&used);
            deformed = read
                .map(|(position, &vertex)| morph.position(vertex, position))
                .collect();
            odd = self
                .deform
                .skin(&used, &mut deformed, &mut carried, (skins, buffers), &place)?;
            let is_lost = |position: &DVec3| !position.as_vec3().is_finite();
            if let Some(lost) = deformed.iter().position(is_lost) {
                return Err(BrokenRule::PositionNotFinite {
                    place: format!("{}, in its pose,", place()),
                    position: used[lost],
                });
            }
        }
        Ok(Triangles {
            positions,
            deformed,
            corners,
            carried,
            odd,
        })
    }
}

fn place(mesh: u32, primitive: usize) -> String {
    format!("meshes[{mesh}].primitives[{primitive}]")
}

/// Triangles, and the vertices that they use.
struct Triangles {
    positions: Vec<[f32; 3]>,
    /// The positions if they are deformed, until it is known what they are to be relative to; `positions` is then empty.
    deformed: Vec<DVec3>,
    corners: Vec<u32>,
    carried: VertexAttributes,
    /// A warning about its joints.
    odd: Option<WarningKind>,
}

impl Triangles {
    /// Rounds deformed positions, relative to a point.
    fn move_to(&mut self, origin: [f32; 3]) {
        let origin = DVec3::from(origin.map(f64::from));
        let deformed = std::mem::take(&mut self.deformed).into_iter();
        self.positions
            .extend(deformed.map(|position| <[f32; 3]>::from((position - origin).as_vec3())));
    }
}

/// Returns the positions that `corners` reference, each once, and renumbers the corners to match.
fn gather(corners: &mut [u32]) -> Vec<u32> {
    let (Some(&least), Some(&most)) = (corners.iter().min(), corners.iter().max()) else {
        return Vec::new();
    };
    let reach = (most - least) as usize + 1;
    if reach <= 2 * corners.len() {
        let mut used = Vec::new();
        // Index among the used positions plus one; 0 if the position is not used yet.
        let mut taken = vec![0_u32; reach];
        for corner in corners {
            let slot = &mut taken[(*corner - least) as usize];
            if *slot == 0 {
                used.push(*corner);
                *slot = used.len() as u32;
            }
            *corner = *slot - 1;
        }
        used
    } else {
        let mut used = corners.to_vec();
        used.sort_unstable();
        used.dedup();
        for corner in corners {
            *corner = used.partition_point(|before| before < corner) as u32;
        }
        used
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::poses::Weights;

    #[test]
    fn meshes_are_built_in_crowds_that_are_not_too_large() {
        let plan = |triangles| MeshPlan {
            posed: PosedMesh {
                mesh: 0,
                skin: None,
                weights: Weights::Zero,
            },
            parts: Vec::new(),
            triangles,
            deform_bytes: 0,
            carried_bytes: 0,
        };
        for (triangles, batch_sizes) in [
            (&[][..], vec![]),
            (&[1, 2, 3], vec![3]),
            (&[BATCH_TRIANGLES, 1], vec![1, 1]),
            (&[BATCH_TRIANGLES - 1, 1, 0, 1], vec![3, 1]),
            (&[1, 5 * BATCH_TRIANGLES, 1, 1], vec![1, 1, 2]),
        ] {
            let plans: Vec<MeshPlan> = triangles.iter().map(|&triangles| plan(triangles)).collect();
            let sizes: Vec<usize> = batches(&plans).map(<[MeshPlan]>::len).collect();
            assert_eq!(sizes, batch_sizes, "{triangles:?}");
        }
        assert_eq!(
            bytes_to_build(&[plan(3), plan(5 * BATCH_TRIANGLES), plan(9)]),
            5 * BATCH_TRIANGLES * BYTES_AT_WORK
        );
    }
}
