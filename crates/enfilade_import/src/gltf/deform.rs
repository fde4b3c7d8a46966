//! Deforms the vertices of a primitive: first by morph targets, then by the joints of a skin.
//!
//! All sums are in f64. A skinned vertex is in world space, whatever the transform of its node.
//! Source: glTF 2.0 Specification, sections 3.7.2.2 and 3.7.3.
//! Cost: O(vertices · (morph targets with a weight + sets of joints)).

use super::accessor::{AccessorUse, Elements, Row};
use super::attributes::VertexAttributes;
use super::buffers::Buffers;
use super::document::{Attributes, Document, Primitive, Semantic};
use super::poses::{PosedMesh, SkinMatrices, Skins};
use crate::BrokenRule;
use crate::budget::Budget;
use crate::warning::WarningKind;
use glam::{DAffine3, DMat3, DVec3};

/// What deforms a primitive, checked as far as possible without its bytes.
#[derive(Clone, Debug, Default)]
pub(super) struct DeformPlan {
    targets: Vec<TargetPlan>,
    joints: Option<JointPlan>,
}

/// A morph target with a weight other than 0.
#[derive(Clone, Debug)]
struct TargetPlan {
    weight: f64,
    positions: Option<Row>,
    normals: Option<Row>,
    texture: Option<Row>,
    colors: Option<Row>,
}

/// The joints that move each vertex.
#[derive(Clone, Debug)]
struct JointPlan {
    skin: u32,
    /// Joint indices and their weights, four of each per vertex.
    sets: Vec<[Row; 2]>,
}

/// A primitive that is to be deformed.
pub(super) struct Deformed<'a> {
    pub(super) document: &'a Document<'a>,
    pub(super) primitive: &'a Primitive,
    /// Number of its vertices.
    pub(super) positions: u64,
    /// The texture coordinate set that is read.
    pub(super) texture_set: Option<u32>,
    pub(super) posed: &'a PosedMesh,
    /// Name in messages.
    pub(super) place: &'a dyn Fn() -> String,
}

impl DeformPlan {
    /// Checks the morph targets and joints of a primitive, and reserves their memory.
    pub(super) fn new(of: &Deformed, budget: &mut Budget) -> Result<DeformPlan, BrokenRule> {
        let targets = of.targets(budget)?;
        let joints = match of.posed.skin {
            Some(skin) => Some(JointPlan {
                skin,
                sets: of.sets(budget)?,
            }),
            None => None,
        };
        Ok(DeformPlan { targets, joints })
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = &Row> {
        let targets = self.targets.iter().flat_map(|target| {
            let rows = [
                &target.positions,
                &target.normals,
                &target.texture,
                &target.colors,
            ];
            rows.into_iter().flatten()
        });
        let joints = self.joints.iter().flat_map(|joints| joints.sets.iter().flatten());
        targets.chain(joints)
    }

    /// Number of values that are added up for each vertex.
    pub(super) fn terms(&self) -> u64 {
        let sets = self.joints.as_ref().map_or(0, |joints| joints.sets.len());
        (self.targets.len() + sets) as u64
    }

    /// Whether a skin moves the vertices to world space.
    pub(super) fn is_skinned(&self) -> bool {
        self.joints.is_some()
    }

    /// Returns the morph targets' changes. `buffers` must hold the sources of all rows.
    pub(super) fn morph<'b>(&self, buffers: &'b Buffers) -> Morph<'b> {
        let deltas = |row: fn(&TargetPlan) -> &Option<Row>| {
            let targets = self.targets.iter();
            let rows = targets.filter_map(|target| Some((target.weight, row(target).as_ref()?)));
            rows.map(|(weight, row)| (weight, row.elements(buffers)))
                .collect()
        };
        Morph {
            positions: deltas(|target| &target.positions),
            normals: deltas(|target| &target.normals),
            texture: deltas(|target| &target.texture),
            colors: deltas(|target| &target.colors),
        }
    }

    /// Moves vertices by the joints of the skin, if there is one. `used` are their indices in the accessors, and `place`
    /// names the primitive.
    pub(super) fn skin(
        &self,
        used: &[u32],
        positions: &mut [DVec3],
        carried: &mut VertexAttributes,
        (skins, buffers): (&Skins, &Buffers),
        place: &dyn Fn() -> String,
    ) -> Result<Option<WarningKind>, BrokenRule> {
        let Some(JointPlan { skin, sets }) = &self.joints else {
            return Ok(None);
        };
        let skin = skins.get(*skin);
        let sets: Vec<[Elements; 2]> = sets
            .iter()
            .map(|set| set.each_ref().map(|row| row.elements(buffers)))
            .collect();
        let mut is_odd = false;
        let mut matrices = Vec::with_capacity(used.len());
        for (position, &vertex) in positions.iter_mut().zip(used) {
            let matrix = blended(vertex, &sets, skin, &mut is_odd).map_err(|joint| BrokenRule::BadSkin {
                place: place(),
                why: format!(
                    "has vertex {vertex} at joint {joint}, but {} has only {} joints",
                    skin.spoken,
                    skin.world_from_mesh.len()
                ),
            })?;
            *position = matrix.transform_point3(*position);
            matrices.push(matrix.matrix3);
        }
        carried.turn_normals(|vertex, normal| turned(&matrices[vertex], normal));
        Ok(is_odd.then_some(WarningKind::JointWeights))
    }
}

impl Deformed<'_> {
    /// Checks the morph targets that have a weight.
    fn targets(&self, budget: &mut Budget) -> Result<Vec<TargetPlan>, BrokenRule> {
        let mut planned = Vec::new();
        let weights = self.posed.weights(self.document);
        for (number, (target, &weight)) in self.primitive.targets.iter().zip(weights).enumerate() {
            if weight == 0.0 {
                continue;
            }
            let place = || format!("{}.targets[{number}]", (self.place)());
            // Once here, and once as elements while they are read.
            budget.take(2 * size_of::<TargetPlan>() as u64, place)?;
            planned.push(self.target(target, weight, &place)?);
        }
        Ok(planned)
    }

    fn target(
        &self,
        target: &Attributes,
        weight: f64,
        place: &dyn Fn() -> String,
    ) -> Result<TargetPlan, BrokenRule> {
        let row = |semantic, wanted, what| {
            let accessor = target.get(semantic);
            accessor
                .map(|accessor| self.row(accessor, wanted, what, place))
                .transpose()
        };
        let set = self.texture_set.map(Semantic::TextureCoordinates);
        Ok(TargetPlan {
            weight,
            positions: row(Semantic::Position, AccessorUse::Positions, "changes of positions")?,
            normals: row(Semantic::Normal, AccessorUse::Normals, "changes of normals")?,
            texture: match set {
                Some(set) => row(
                    set,
                    AccessorUse::TextureCoordinates,
                    "changes of texture coordinates",
                )?,
                None => None,
            },
            colors: row(Semantic::Color, AccessorUse::ColorDeltas, "changes of colors")?,
        })
    }

    /// Checks the sets of joints that have weights.
    fn sets(&self, budget: &mut Budget) -> Result<Vec<[Row; 2]>, BrokenRule> {
        let attributes = &self.primitive.attributes;
        let mut sets = Vec::new();
        for set in attributes.joint_sets() {
            let accessors = [Semantic::Joints(set), Semantic::Weights(set)].map(|key| attributes.get(key));
            // Joints without weights move nothing.
            let [Some(joints), Some(weights)] = accessors else {
                continue;
            };
            budget.take(4 * size_of::<Row>() as u64, || {
                format!("{}, its JOINTS_{set}", (self.place)())
            })?;
            sets.push([
                self.row(joints, AccessorUse::Joints, "sets of joints", self.place)?,
                self.row(
                    weights,
                    AccessorUse::JointWeights,
                    "sets of joint weights",
                    self.place,
                )?,
            ]);
        }
        Ok(sets)
    }

    /// Checks an accessor with one element per vertex.
    fn row(
        &self,
        accessor: u32,
        wanted: AccessorUse,
        what: &'static str,
        place: &dyn Fn() -> String,
    ) -> Result<Row, BrokenRule> {
        let row = Row::new(self.document, accessor, wanted, place)?;
        if row.count != self.positions {
            return Err(BrokenRule::AttributeCount {
                place: place(),
                what,
                count: row.count,
                positions: self.positions,
            });
        }
        Ok(row)
    }
}

/// The weighted changes of vertex attributes by morph targets.
pub(super) struct Morph<'b> {
    positions: Vec<(f64, Elements<'b>)>,
    normals: Vec<(f64, Elements<'b>)>,
    texture: Vec<(f64, Elements<'b>)>,
    colors: Vec<(f64, Elements<'b>)>,
}

impl Morph<'_> {
    pub(super) fn position(&self, vertex: u32, base: [f32; 3]) -> DVec3 {
        changed(&self.positions, vertex, base).into()
    }

    pub(super) fn normal(&self, vertex: u32, base: [f32; 3]) -> [f32; 3] {
        if self.normals.is_empty() {
            return base;
        }
        unit(changed(&self.normals, vertex, base).into(), base)
    }

    pub(super) fn texture(&self, vertex: u32, base: [f32; 2]) -> [f32; 2] {
        changed(&self.texture, vertex, base).map(|value| value as f32)
    }

    pub(super) fn color(&self, vertex: u32, base: [f32; 4]) -> [f32; 4] {
        changed(&self.colors, vertex, base).map(|value| value as f32)
    }
}

/// Adds the weighted changes to the value of a vertex.
fn changed<const N: usize>(deltas: &[(f64, Elements)], vertex: u32, base: [f32; N]) -> [f64; N] {
    let mut sum = base.map(f64::from);
    for (weight, elements) in deltas {
        let delta: [f32; N] = elements.floats(vertex as usize);
        for (sum, delta) in sum.iter_mut().zip(delta) {
            *sum += weight * f64::from(delta);
        }
    }
    sum
}

/// Returns a direction of length 1, or `otherwise` if it has none.
fn unit(direction: DVec3, otherwise: [f32; 3]) -> [f32; 3] {
    let unit = direction.try_normalize();
    unit.map_or(otherwise, |unit| unit.as_vec3().into())
}

/// Turns a normal by the inverse transpose of a matrix, which keeps it perpendicular to the surface.
fn turned(matrix: &DMat3, normal: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    // The cofactors: the inverse transpose times the determinant, of which only the sign matters. They also exist if the
    // matrix flattens.
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let turned = cofactors * DVec3::from(normal.map(f64::from)) * matrix.determinant().signum();
    unit(turned, normal)
}

/// Returns the weighted mean of the matrices of a vertex's joints, or the index of a joint that the skin does not have.
/// As viewers do, weights are divided by their sum; a vertex without weights follows its first joint, which sets
/// `is_odd`.
fn blended(
    vertex: u32,
    sets: &[[Elements; 2]],
    skin: &SkinMatrices,
    is_odd: &mut bool,
) -> Result<DAffine3, u32> {
    let matrix = |joint: u32| skin.world_from_mesh.get(joint as usize).ok_or(joint);
    let (mut columns, mut total) = ([DVec3::ZERO; 4], 0.0);
    for [joints, weights] in sets {
        let weights: [f32; 4] = weights.floats(vertex as usize);
        for (joint, weight) in joints.joints(vertex as usize).into_iter().zip(weights) {
            // Also false for NaN.
            let is_weight = weight > 0.0 && weight.is_finite();
            *is_odd |= !is_weight && weight != 0.0;
            if !is_weight {
                continue;
            }
            let (matrix, weight) = (matrix(joint)?, f64::from(weight));
            let axes = [
                matrix.matrix3.x_axis,
                matrix.matrix3.y_axis,
                matrix.matrix3.z_axis,
                matrix.translation,
            ];
            columns = std::array::from_fn(|axis| columns[axis] + axes[axis] * weight);
            total += weight;
        }
    }
    if total == 0.0 {
        *is_odd = true;
        let first = sets
            .first()
            .map_or(0, |[joints, _]| joints.joints(vertex as usize)[0]);
        return matrix(first).copied();
    }
    let [x, y, z, moved] = columns.map(|column| column / total);
    Ok(DAffine3 {
        matrix3: DMat3::from_cols(x, y, z),
        translation: moved,
    })
}
