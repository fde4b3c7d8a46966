//! Reads instances: nodes that show their mesh several times.
//!
//! Source: EXT_mesh_gpu_instancing.
//! Cost: O(instances).

use super::BYTES_PER_NODE;
use super::accessor::{AccessorUse, Row};
use super::buffers::Buffers;
use super::document::Document;
use super::plan::Plan;
use super::poses::Poses;
use crate::BrokenRule;
use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use enfilade::Transform;
use glam::{DAffine3, DQuat, DVec3, DVec4};
use std::collections::BTreeMap;

/// The instance attributes of nodes, checked as far as possible without their bytes.
pub(super) struct InstancePlan(BTreeMap<u32, Rows>);

/// The instance attributes of one node: at least one row, and all of the same length.
struct Rows {
    places: Option<Row>,
    turns: Option<Row>,
    scales: Option<Row>,
    count: u64,
}

/// The transforms of instances, by node index.
pub(super) struct Instances(BTreeMap<u32, Vec<Transform>>);

impl InstancePlan {
    /// Checks the instances of all items and reserves their memory.
    pub(super) fn new(
        document: &Document,
        plan: &Plan,
        poses: &Poses,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<InstancePlan, BrokenRule> {
        let mut nodes = BTreeMap::new();
        for placed in plan.shown() {
            let node = &document.nodes[placed.node as usize];
            let (Some(attributes), Some(_)) = (node.instancing(), node.mesh) else {
                continue;
            };
            let name = || document.node_name(placed.node);
            if !plan.is_item(placed) {
                warnings.name(WarningKind::InstancedOpenings, name);
                continue;
            }
            // Transforms of instances are relative to the node, whose transform a skin ignores.
            if poses.of(placed.node).is_some_and(|posed| posed.skin.is_some()) {
                warnings.name(WarningKind::InstancedSkins, name);
                continue;
            }
            let row = |accessor: Option<u32>, wanted| {
                accessor
                    .map(|accessor| Row::new(document, accessor, wanted, name))
                    .transpose()
            };
            let places = row(attributes.translation, AccessorUse::Translations)?;
            let turns = row(attributes.rotation, AccessorUse::Rotations)?;
            let scales = row(attributes.scale, AccessorUse::Scales)?;
            let named = [
                ("translations (TRANSLATION)", &places),
                ("rotations (ROTATION)", &turns),
                ("scales (SCALE)", &scales),
            ];
            let mut counts = named
                .iter()
                .filter_map(|(what, row)| Some((*what, row.as_ref()?.count)));
            // Without attributes the number of instances is unknown, so the node is a single item.
            let Some((first_what, count)) = counts.next() else {
                continue;
            };
            if let Some((second_what, second)) = counts.find(|(_, other)| *other != count) {
                return Err(BrokenRule::InstanceCount {
                    node: name(),
                    first: count,
                    first_what,
                    second,
                    second_what,
                });
            }
            let each = BYTES_PER_NODE + node.name.len() as u64;
            budget.take(count.saturating_mul(each), || {
                format!("{}, its instances", name())
            })?;
            let rows = Rows {
                places,
                turns,
                scales,
                count,
            };
            nodes.insert(placed.node, rows);
        }
        Ok(InstancePlan(nodes))
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = &Row> {
        self.0
            .values()
            .flat_map(|rows| [&rows.places, &rows.turns, &rows.scales])
            .flatten()
    }

    /// Reads the transforms of the instances.
    pub(super) fn read(&self, document: &Document, buffers: &Buffers) -> Result<Instances, BrokenRule> {
        let read = |(&node, rows): (&u32, &Rows)| Ok((node, rows.read(document, node, buffers)?));
        Ok(Instances(
            self.0.iter().map(read).collect::<Result<_, BrokenRule>>()?,
        ))
    }
}

impl Rows {
    fn read(&self, document: &Document, node: u32, buffers: &Buffers) -> Result<Vec<Transform>, BrokenRule> {
        let [places, turns, scales] = [&self.places, &self.turns, &self.scales]
            .map(|row| row.as_ref().map(|row| row.elements(buffers)));
        let mut transforms = Vec::with_capacity(self.count as usize);
        for number in 0..self.count as usize {
            let name = || format!("{}, instance {number}", document.node_name(node));
            let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
            let place = places
                .as_ref()
                .map_or(DVec3::ZERO, |places| vector(places.floats(number)));
            let scale = scales
                .as_ref()
                .map_or(DVec3::ONE, |scales| vector(scales.floats(number)));
            let turn = turns
                .as_ref()
                .map_or(DVec4::W, |turns| DVec4::from(turns.floats(number).map(f64::from)));
            if !(place.is_finite() && scale.is_finite() && turn.is_finite()) {
                return Err(BrokenRule::NodeNotFinite(name()));
            }
            let turn = turn
                .try_normalize()
                .ok_or_else(|| BrokenRule::NoRotation(name()))?;
            let affine = DAffine3::from_scale_rotation_translation(scale, DQuat::from_vec4(turn), place);
            transforms.push(Transform::from_columns(
                affine
                    .to_cols_array_2d()
                    .map(|column| column.map(|value| value as f32)),
            ));
        }
        Ok(transforms)
    }
}

impl Instances {
    /// Returns the transforms of a node's instances relative to the node; `None` if it has none and is a single item.
    pub(super) fn of(&self, node: u32) -> Option<&[Transform]> {
        self.0.get(&node).map(Vec::as_slice)
    }
}
