//! Poses: which skin and which morph weights deform the mesh of a node, and the matrices of the joints.
//!
//! The pose is the one that the file stores: the transforms of the joints' nodes, and the weights of the node or else of
//! its mesh. Animations are not applied.
//! Source: glTF 2.0 Specification, sections 3.7.2.2 (morph targets) and 3.7.3 (skins).
//! Cost: O(joints + nodes above them).

use super::accessor::{AccessorUse, Row};
use super::buffers::Buffers;
use super::document::{Document, Semantic, Skin, find};
use super::nodes;
use crate::BrokenRule;
use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use glam::{DAffine3, DMat4, DVec4};
use std::collections::{BTreeMap, BTreeSet};

/// A mesh and what deforms it. Nodes with equal values share geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PosedMesh {
    /// Index in the document.
    pub(super) mesh: u32,
    pub(super) skin: Option<u32>,
    pub(super) weights: Weights,
}

/// The origin of the weights of morph targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Weights {
    /// All are 0.
    Zero,
    OfMesh,
    OfNode(u32),
}

/// The deformed and plain meshes of nodes.
pub(super) struct Poses {
    /// By node index.
    posed: BTreeMap<u32, PosedMesh>,
}

impl Poses {
    /// Finds what deforms the meshes of the nodes.
    pub(super) fn new(
        document: &Document,
        nodes: impl Iterator<Item = u32>,
        warnings: &mut Warnings,
    ) -> Result<Poses, BrokenRule> {
        let mut of_meshes: BTreeMap<u32, MeshDeformers> = BTreeMap::new();
        let mut posed = BTreeMap::new();
        for number in nodes {
            let node = &document.nodes[number as usize];
            let Some(mesh) = node.mesh else { continue };
            let name = || document.node_name(number);
            find(&document.meshes, mesh, "mesh", name)?;
            let of_mesh = of_meshes
                .entry(mesh)
                .or_insert_with(|| MeshDeformers::of(document, mesh, warnings));
            let weights = match node.weights() {
                Some(own) => {
                    if own.len() != of_mesh.targets && of_mesh.targets > 0 {
                        warnings.name(WarningKind::MorphWeights, name);
                    }
                    has_weight(own).then_some(Weights::OfNode(number))
                }
                None => of_mesh.has_weight.then_some(Weights::OfMesh),
            };
            if let Some(skin) = node.skin {
                find(&document.skins, skin, "skin", name)?;
                if !of_mesh.has_joints {
                    warnings.name(WarningKind::JointWeights, || {
                        format!("{}, whose mesh has no joints", name())
                    });
                }
            }
            let mesh = PosedMesh {
                mesh,
                // Without joints no vertex follows a skin.
                skin: node.skin.filter(|_| of_mesh.has_joints),
                weights: weights.filter(|_| of_mesh.targets > 0).unwrap_or(Weights::Zero),
            };
            posed.insert(number, mesh);
        }
        Ok(Poses { posed })
    }

    /// Returns the mesh of a node in its pose.
    pub(super) fn of(&self, node: u32) -> Option<PosedMesh> {
        self.posed.get(&node).copied()
    }

    /// Returns all different meshes and poses, increasing.
    pub(super) fn used(&self) -> Vec<PosedMesh> {
        let used: BTreeSet<PosedMesh> = self.posed.values().copied().collect();
        used.into_iter().collect()
    }
}

impl PosedMesh {
    /// Returns the weights of the morph targets; missing ones are 0.
    pub(super) fn weights<'d>(&self, document: &'d Document) -> &'d [f64] {
        match self.weights {
            Weights::Zero => &[],
            Weights::OfMesh => document.meshes[self.mesh as usize]
                .weights
                .as_deref()
                .unwrap_or_default(),
            Weights::OfNode(node) => document.nodes[node as usize].weights().unwrap_or_default(),
        }
    }
}

/// What of a mesh may deform it.
struct MeshDeformers {
    targets: usize,
    has_weight: bool,
    has_joints: bool,
}

impl MeshDeformers {
    fn of(document: &Document, number: u32, warnings: &mut Warnings) -> MeshDeformers {
        let mesh = &document.meshes[number as usize];
        let primitives = mesh.primitives.iter();
        let targets = primitives.clone().map(|primitive| primitive.targets.len());
        let targets = targets.max().unwrap_or(0);
        if targets > 0
            && mesh
                .weights
                .as_ref()
                .is_some_and(|weights| weights.len() != targets)
        {
            warnings.name(WarningKind::MorphWeights, || format!("meshes[{number}]"));
        }
        MeshDeformers {
            targets,
            has_weight: mesh.weights.as_deref().is_some_and(has_weight),
            has_joints: primitives.clone().any(|primitive| {
                let attributes = &primitive.attributes;
                let mut sets = attributes.joint_sets();
                sets.any(|set| attributes.get(Semantic::Weights(set)).is_some())
            }),
        }
    }
}

fn has_weight(weights: &[f64]) -> bool {
    weights.iter().any(|&weight| weight != 0.0)
}

/// The used skins, checked as far as possible without their bytes.
pub(super) struct SkinPlan(BTreeMap<u32, PlannedSkin>);

struct PlannedSkin {
    /// Name in messages.
    spoken: String,
    /// World transforms of the joints.
    joints: Vec<DAffine3>,
    inverse_bind_matrices: Option<Row>,
}

/// The matrices of the joints of used skins: from the space of a mesh to the world.
pub(super) struct Skins(BTreeMap<u32, SkinMatrices>);

pub(super) struct SkinMatrices {
    /// Name in messages.
    pub(super) spoken: String,
    pub(super) world_from_mesh: Vec<DAffine3>,
}

/// Memory of a joint: its index, and its transform before and after it is multiplied.
const BYTES_PER_JOINT: u64 = 4 + 2 * size_of::<DAffine3>() as u64;

impl SkinPlan {
    /// Checks the skins of used meshes, reserves their memory and computes the transforms of their joints.
    pub(super) fn new(
        document: &Document,
        used: &[PosedMesh],
        budget: &mut Budget,
    ) -> Result<SkinPlan, BrokenRule> {
        let numbers: BTreeSet<u32> = used.iter().filter_map(|posed| posed.skin).collect();
        let mut skins = BTreeMap::new();
        if numbers.is_empty() {
            return Ok(SkinPlan(skins));
        }
        let mut worlds = nodes::Worlds::new(document)?;
        for number in numbers {
            let skin = document.skin(number)?;
            budget.take(skin.joints.len() as u64 * BYTES_PER_JOINT, || skin.spoken(number))?;
            skins.insert(
                number,
                PlannedSkin::new(document, number, &skin, &mut worlds, budget)?,
            );
        }
        Ok(SkinPlan(skins))
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = &Row> {
        self.0
            .values()
            .filter_map(|skin| skin.inverse_bind_matrices.as_ref())
    }

    /// Reads the inverse bind matrices and multiplies them.
    pub(super) fn read(self, buffers: &Buffers) -> Result<Skins, BrokenRule> {
        let read = |(number, skin): (u32, PlannedSkin)| Ok((number, skin.read(buffers)?));
        let skins = self.0.into_iter().map(read);
        Ok(Skins(skins.collect::<Result<_, BrokenRule>>()?))
    }
}

impl Skins {
    /// Returns the matrices of a used skin.
    pub(super) fn get(&self, skin: u32) -> &SkinMatrices {
        &self.0[&skin]
    }
}

impl PlannedSkin {
    fn new(
        document: &Document,
        number: u32,
        skin: &Skin,
        worlds: &mut nodes::Worlds,
        budget: &mut Budget,
    ) -> Result<PlannedSkin, BrokenRule> {
        let spoken = skin.spoken(number);
        let bad = |why: String| BrokenRule::BadSkin {
            place: spoken.clone(),
            why,
        };
        if skin.joints.is_empty() {
            return Err(bad("has no joints".to_owned()));
        }
        let mut joints = Vec::with_capacity(skin.joints.len());
        for &joint in &skin.joints {
            find(&document.nodes, joint, "node", || {
                format!("{spoken}, among its joints,")
            })?;
            joints.push(worlds.of(joint, budget)?);
        }
        let accessor = skin.inverse_bind_matrices;
        let row = accessor
            .map(|accessor| {
                Row::new(document, accessor, AccessorUse::InverseBindMatrices, || {
                    spoken.clone()
                })
            })
            .transpose()?;
        if let (Some(row), Some(accessor)) = (&row, accessor)
            && row.count < joints.len() as u64
        {
            return Err(bad(format!(
                "has {} joints, but accessor {accessor} only {} inverse bind matrices",
                joints.len(),
                row.count
            )));
        }
        Ok(PlannedSkin {
            spoken,
            joints,
            inverse_bind_matrices: row,
        })
    }

    fn read(self, buffers: &Buffers) -> Result<SkinMatrices, BrokenRule> {
        let PlannedSkin {
            spoken,
            joints: mut matrices,
            inverse_bind_matrices,
        } = self;
        let elements = inverse_bind_matrices.as_ref().map(|row| row.elements(buffers));
        for (number, matrix) in matrices.iter_mut().enumerate() {
            let bad = |what: &str| BrokenRule::BadSkin {
                place: spoken.clone(),
                why: format!("has {what} at joint {number}"),
            };
            if let Some(elements) = &elements {
                let bind = DMat4::from_cols_array(&elements.floats(number).map(f64::from));
                if !bind.is_finite() {
                    return Err(bad("an inverse bind matrix that is not finite"));
                }
                if !bind.row(3).abs_diff_eq(DVec4::W, 1e-4) {
                    return Err(bad("an inverse bind matrix whose last row is not 0, 0, 0, 1"));
                }
                *matrix *= DAffine3::from_mat4(bind);
            }
            if !matrix.is_finite() {
                return Err(bad("a transform that is not finite"));
            }
        }
        Ok(SkinMatrices {
            spoken,
            world_from_mesh: matrices,
        })
    }
}
