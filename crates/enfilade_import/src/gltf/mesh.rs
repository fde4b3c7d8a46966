//! Meshes: planned from the document alone, then built from the buffers.
//!
//! A part takes only those positions that its own triangles use, so a large accessor that a thousand primitives
//! share is neither copied nor searched a thousand times, and what no triangle uses cannot do harm.
//! Cost: O(triangles), or O(triangles · log) where a part's positions are scattered; memory O(triangles).

use super::accessor::{Row, Wanted};
use super::buffers::Buffers;
use super::document::{Document, Primitive, find};
use super::materials::default_material;
use super::topology::Topology;
use crate::BrokenRule;
use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use enfilade::{Attributes, MaterialId, Mesh, Part};

/// A mesh of the document, everything about it checked that can be without its bytes.
#[derive(Debug)]
pub(super) struct MeshPlan {
    mesh: u32,
    parts: Vec<PartPlan>,
    triangles: u64,
}

/// A primitive that has triangles.
#[derive(Debug)]
struct PartPlan {
    primitive: usize,
    positions: Row,
    indices: Option<Row>,
    topology: Topology,
    material: MaterialId,
}

/// What a triangle takes in a mesh, at most: where it shares no corner with another.
const BYTES_KEPT: u64 = 52;
/// What it takes besides, while its mesh is built.
const BYTES_AT_WORK: u64 = 120;
/// Triangles of meshes that are built at once, if it is not one mesh that has more. So memory does not grow with the
/// number of threads, and there is still enough for each.
const CROWD: u64 = 1_000_000;

/// Runs of meshes that are built at once.
pub(super) fn crowds(plans: &[MeshPlan]) -> impl Iterator<Item = &[MeshPlan]> {
    let mut rest = plans;
    std::iter::from_fn(move || {
        let mut triangles = 0;
        let crowded = rest.iter().position(|plan| {
            triangles += plan.triangles;
            triangles > CROWD
        });
        let (crowd, later) =
            rest.split_at(crowded.map_or(rest.len(), |first_too_many| first_too_many.max(1)));
        rest = later;
        (!crowd.is_empty()).then_some(crowd)
    })
}

/// What it takes, besides the meshes, to build the largest crowd of them.
pub(super) fn bytes_to_build(plans: &[MeshPlan]) -> u64 {
    let triangles = |crowd: &[MeshPlan]| crowd.iter().map(|plan| plan.triangles).sum::<u64>();
    crowds(plans)
        .map(triangles)
        .max()
        .unwrap_or(0)
        .saturating_mul(BYTES_AT_WORK)
}

impl MeshPlan {
    /// Checks a mesh that is there, and sets aside the memory that it will keep.
    pub(super) fn new(
        document: &Document,
        mesh: u32,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<MeshPlan, BrokenRule> {
        let mut parts = Vec::new();
        let mut triangles = 0_u64;
        for (number, primitive) in document.meshes[mesh as usize].primitives.iter().enumerate() {
            if let Some(part) = PartPlan::new(document, mesh, number, primitive, warnings)? {
                triangles = triangles.saturating_add(part.triangles());
                parts.push(part);
            }
        }
        let place = || format!("meshes[{mesh}]");
        budget.take(triangles.saturating_mul(BYTES_KEPT), place)?;
        if triangles >= u64::from(u32::MAX / 3) {
            return Err(BrokenRule::TooManyCorners { place: place() });
        }
        Ok(MeshPlan {
            mesh,
            parts,
            triangles,
        })
    }

    /// The buffers that it is built from; some are named more than once.
    pub(super) fn buffers(&self) -> impl Iterator<Item = u32> {
        let rows = self
            .parts
            .iter()
            .flat_map(|part| [Some(&part.positions), part.indices.as_ref()]);
        rows.flatten().filter_map(Row::buffer)
    }

    /// Reads the triangles and builds the mesh.
    pub(super) fn build(&self, buffers: &Buffers) -> Result<Mesh, BrokenRule> {
        let read: Vec<Triangles> = self
            .parts
            .iter()
            .map(|part| part.read(self.mesh, buffers))
            .collect::<Result<_, _>>()?;
        let parts: Vec<Part> = read
            .iter()
            .zip(&self.parts)
            .map(|(Triangles { positions, corners }, plan)| Part {
                positions,
                corners,
                sides: None,
                material: plan.material,
                attributes: Attributes::default(),
            })
            .collect();
        Mesh::new(&parts).map_err(|why| BrokenRule::Mesh {
            place: format!("meshes[{}]", self.mesh),
            why,
        })
    }
}

impl PartPlan {
    /// Checks a primitive; `None` where it has no triangle.
    fn new(
        document: &Document,
        mesh: u32,
        number: usize,
        primitive: &Primitive,
        warnings: &mut Warnings,
    ) -> Result<Option<PartPlan>, BrokenRule> {
        let place = || place(mesh, number);
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
        let Some(positions) = primitive.attributes.position else {
            warnings.name(WarningKind::NoPositions, place);
            return Ok(None);
        };
        let positions = Row::new(document, positions, Wanted::Positions, place)?;
        let indices = match primitive.indices {
            Some(indices) => Some(Row::new(document, indices, Wanted::Indices, place)?),
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
        if !primitive.targets.is_empty() {
            warnings.name(WarningKind::MorphTargets, place);
        }
        warnings.count(
            WarningKind::Normals,
            usize::from(primitive.attributes.normal.is_some()),
        );
        warnings.count(
            WarningKind::VertexColors,
            usize::from(primitive.attributes.color_0.is_some()),
        );

        let part = PartPlan {
            primitive: number,
            positions,
            indices,
            topology,
            material,
        };
        if topology == Topology::List && !part.corners().is_multiple_of(3) {
            warnings.name(WarningKind::CornersLeft, place);
        }
        Ok((part.triangles() > 0).then_some(part))
    }

    /// Corners that its triangles are made from.
    fn corners(&self) -> u64 {
        self.indices.as_ref().unwrap_or(&self.positions).count
    }

    fn triangles(&self) -> u64 {
        self.topology.triangles(self.corners())
    }

    fn read(&self, mesh: u32, buffers: &Buffers) -> Result<Triangles, BrokenRule> {
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
        let positions = gather(&mut corners, &self.positions, buffers).map_err(|NotFinite(position)| {
            BrokenRule::PositionNotFinite {
                place: place(),
                position,
            }
        })?;
        Ok(Triangles { positions, corners })
    }
}

fn place(mesh: u32, primitive: usize) -> String {
    format!("meshes[{mesh}].primitives[{primitive}]")
}

/// Triangles over their own positions.
struct Triangles {
    positions: Vec<[f32; 3]>,
    corners: Vec<u32>,
}

/// A position with a NaN or an infinity in it.
struct NotFinite(u32);

/// Takes the positions that `corners` name out of `row`, and names them anew.
fn gather(corners: &mut [u32], row: &Row, buffers: &Buffers) -> Result<Vec<[f32; 3]>, NotFinite> {
    let elements = row.elements(buffers);
    let sound = |index: u32| {
        let position = elements.position(index);
        if position.iter().all(|value| value.is_finite()) {
            Ok(position)
        } else {
            Err(NotFinite(index))
        }
    };
    let (Some(&least), Some(&most)) = (corners.iter().min(), corners.iter().max()) else {
        return Ok(Vec::new());
    };
    let mut positions = Vec::new();
    let reach = (most - least) as usize + 1;
    if reach <= 2 * corners.len() {
        // Where each stands among the positions taken, plus one; 0 where it is not yet taken.
        let mut taken = vec![0_u32; reach];
        for corner in corners {
            let slot = &mut taken[(*corner - least) as usize];
            if *slot == 0 {
                positions.push(sound(*corner)?);
                *slot = positions.len() as u32;
            }
            *corner = *slot - 1;
        }
    } else {
        let mut used = corners.to_vec();
        used.sort_unstable();
        used.dedup();
        for &index in &used {
            positions.push(sound(index)?);
        }
        for corner in corners {
            *corner = used.partition_point(|before| before < corner) as u32;
        }
    }
    Ok(positions)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_built_in_crowds_that_are_not_too_large() {
        let plan = |triangles| MeshPlan {
            mesh: 0,
            parts: Vec::new(),
            triangles,
        };
        for (triangles, crowd_sizes) in [
            (&[][..], vec![]),
            (&[1, 2, 3], vec![3]),
            (&[CROWD, 1], vec![1, 1]),
            (&[CROWD - 1, 1, 0, 1], vec![3, 1]),
            (&[1, 5 * CROWD, 1, 1], vec![1, 1, 2]),
        ] {
            let plans: Vec<MeshPlan> = triangles.iter().map(|&triangles| plan(triangles)).collect();
            let sizes: Vec<usize> = crowds(&plans).map(<[MeshPlan]>::len).collect();
            assert_eq!(sizes, crowd_sizes, "{triangles:?}");
        }
        assert_eq!(
            bytes_to_build(&[plan(3), plan(5 * CROWD), plan(9)]),
            5 * CROWD * BYTES_AT_WORK
        );
    }
}
