//! Nodes: validates the hierarchy, then traverses it without recursion and accumulates transforms in f64.
//!
//! Source: glTF 2.0 Specification, section 3.5.
//! Cost: O(nodes), however deep they are nested.

use super::document::{Document, Node, find};
use crate::BrokenRule;
use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use enfilade::Transform;
use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};
use std::collections::{BTreeSet, HashMap};

/// A node of the scene and its world transform.
#[derive(Clone, Copy, Debug)]
pub(super) struct SceneNode {
    pub(super) node: u32,
    pub(super) world: Transform,
    /// The nearest room node at or above it.
    pub(super) room: Option<u32>,
    /// Whether it and all above it are drawn.
    pub(super) is_visible: bool,
}

/// Returns the nodes of the default scene that have a mesh, a camera or a light, or that `wanted` accepts, by node
/// index.
pub(super) fn place(
    document: &Document,
    is_room: impl Fn(u32) -> bool,
    wanted: impl Fn(u32) -> bool,
    warnings: &mut Warnings,
) -> Result<Vec<SceneNode>, BrokenRule> {
    let parents = parents(document)?;
    for (number, node) in (0_u32..).zip(&document.nodes) {
        if node.children.len() < 2 {
            continue;
        }
        let mut children = node.children.clone();
        children.sort_unstable();
        for pair in children.windows(2).filter(|pair| pair[0] == pair[1]) {
            warnings.name(WarningKind::Repaired, || {
                let [parent, child] = [number, pair[0]].map(|node| document.node_name(node));
                format!("{parent} lists {child} twice")
            });
        }
    }
    if let Some(node) = on_a_cycle(&parents) {
        return Err(BrokenRule::NodeCycle(name_the_cycle(document, &parents, node)));
    }
    let mut placed = Vec::new();
    let mut entered = vec![false; document.nodes.len()];
    let roots = roots(document, &parents, warnings)?;
    let mut roots = roots.iter();
    // A stack: the node to be visited first is pushed last.
    let mut waiting: Vec<(u32, DAffine3, Option<u32>, bool)> = Vec::new();
    loop {
        let next = waiting.pop();
        let Some((number, world_from_parent, outer_room, is_shown)) =
            next.or_else(|| Some((*roots.next()?, DAffine3::IDENTITY, None, true)))
        else {
            break;
        };
        // A scene may list a node twice; it is visited once.
        if std::mem::replace(&mut entered[number as usize], true) {
            continue;
        }
        let node = &document.nodes[number as usize];
        let world_from_node = world_from_parent * parent_from_node(document, number, node, warnings)?;
        let room = if is_room(number) { Some(number) } else { outer_room };
        let is_visible = is_shown && node.is_visible();
        let shows = node.mesh.is_some() || node.camera.is_some() || node.light().is_some();
        if shows || wanted(number) {
            let world = rounded(&world_from_node);
            if !world.is_finite() {
                return Err(BrokenRule::NodeNotFinite(document.node_name(number)));
            }
            placed.push(SceneNode {
                node: number,
                world,
                room,
                is_visible,
            });
        }
        waiting.extend(
            node.children
                .iter()
                .rev()
                .map(|&child| (child, world_from_node, room, is_visible)),
        );
    }
    placed.sort_unstable_by_key(|placed| placed.node);
    Ok(placed)
}

/// World transforms of nodes, also of those that are not drawn.
pub(super) struct Worlds<'d> {
    document: &'d Document<'d>,
    parents: Vec<Option<u32>>,
    roots: BTreeSet<u32>,
    known: HashMap<u32, DAffine3>,
}

/// Memory of a known world transform, in a table that grows by doubling.
const BYTES_PER_WORLD: u64 = 4 * size_of::<(u32, DAffine3)>() as u64;

impl<'d> Worlds<'d> {
    /// The nodes must have no cycle.
    pub(super) fn new(document: &'d Document) -> Result<Worlds<'d>, BrokenRule> {
        let parents = parents(document)?;
        Ok(Worlds {
            document,
            roots: roots(document, &parents, &mut Warnings::default())?
                .into_iter()
                .collect(),
            parents,
            known: HashMap::new(),
        })
    }

    /// Returns the world transform of an existing node.
    pub(super) fn of(&mut self, node: u32, budget: &mut Budget) -> Result<DAffine3, BrokenRule> {
        // From the node up to the first one that is known.
        let mut unknown = Vec::new();
        let mut next = Some(node);
        let mut world = DAffine3::IDENTITY;
        while let Some(number) = next {
            if let Some(known) = self.known.get(&number) {
                world = *known;
                break;
            }
            budget.take(BYTES_PER_WORLD, || self.document.node_name(number))?;
            unknown.push(number);
            let parent = self.parents[number as usize];
            next = parent.filter(|_| !self.roots.contains(&number));
        }
        for &number in unknown.iter().rev() {
            let node = &self.document.nodes[number as usize];
            // Nodes of the scene were warned of when they were placed.
            let parent_from_node = parent_from_node(self.document, number, node, &mut Warnings::default())?;
            world *= parent_from_node;
            self.known.insert(number, world);
        }
        Ok(world)
    }
}

/// Returns the root nodes of the scene. The nodes must have no cycle.
pub(super) fn scene_roots(document: &Document) -> Result<Vec<u32>, BrokenRule> {
    roots(document, &parents(document)?, &mut Warnings::default())
}

/// Returns the root nodes of the default scene, or of the first scene, or all nodes without a parent if there are no
/// scenes.
///
/// A scene may list a node that is a child, against the specification: below another node that it lists, the node is only a
/// child; otherwise it is a root, and its parent is in no scene.
fn roots(
    document: &Document,
    parents: &[Option<u32>],
    warnings: &mut Warnings,
) -> Result<Vec<u32>, BrokenRule> {
    let Some(number) = document.scene_number() else {
        return Ok((0_u32..)
            .zip(parents)
            .filter(|(_, parent)| parent.is_none())
            .map(|(root, _)| root)
            .collect());
    };
    let scene = find(&document.scenes, number, "scene", || "the document".to_owned())?;
    let place = || format!("scene {number}");
    for &root in &scene.nodes {
        find(&document.nodes, root, "node", place)?;
        if let Some(parent) = parents[root as usize] {
            warnings.name(WarningKind::Repaired, || {
                let [node, parent] = [root, parent].map(|node| document.node_name(node));
                format!("{} lists {node}, a child of {parent}", place())
            });
        }
    }
    let mut is_listed_above = ListedAbove::new(parents, &scene.nodes);
    let roots = scene.nodes.iter().copied();
    Ok(roots.filter(|&root| !is_listed_above.of(root)).collect())
}

/// Whether a scene lists a node above another.
struct ListedAbove<'p> {
    parents: &'p [Option<u32>],
    is_listed: Vec<bool>,
    /// For each node, if it is known, whether it or one above it is listed.
    known: Vec<Option<bool>>,
}

impl<'p> ListedAbove<'p> {
    fn new(parents: &'p [Option<u32>], listed: &[u32]) -> ListedAbove<'p> {
        let mut is_listed = vec![false; parents.len()];
        for &node in listed {
            is_listed[node as usize] = true;
        }
        ListedAbove {
            parents,
            is_listed,
            known: vec![None; parents.len()],
        }
    }

    fn of(&mut self, node: u32) -> bool {
        let mut next = self.parents[node as usize];
        // Each climb stops at a node that an earlier one visited, so all together visit a node at most once.
        let mut visited = Vec::new();
        let mut found = false;
        while let Some(above) = next {
            let known = self.known[above as usize];
            found = known.unwrap_or(self.is_listed[above as usize]);
            if found || known.is_some() {
                break;
            }
            visited.push(above);
            next = self.parents[above as usize];
        }
        for node in visited {
            self.known[node as usize] = Some(found);
        }
        found
    }
}

/// Returns the parent of each node.
fn parents(document: &Document) -> Result<Vec<Option<u32>>, BrokenRule> {
    let mut parents: Vec<Option<u32>> = vec![None; document.nodes.len()];
    for (parent, node) in (0_u32..).zip(&document.nodes) {
        for &child in &node.children {
            find(&document.nodes, child, "node", || document.node_name(parent))?;
            // Listed twice by one node, it is its child once.
            if let Some(first) = parents[child as usize].replace(parent)
                && first != parent
            {
                let [node, first, second] = [child, first, parent].map(|number| document.node_name(number));
                return Err(BrokenRule::TwoParents { node, first, second });
            }
        }
    }
    Ok(parents)
}

/// Returns a node that is its own ancestor, if there is one.
fn on_a_cycle(parents: &[Option<u32>]) -> Option<u32> {
    // Each climb stops at a node that an earlier climb visited, so all climbs together visit a node at most twice.
    let mut met_from: Vec<Option<u32>> = vec![None; parents.len()];
    for start in 0..parents.len() as u32 {
        let mut next = Some(start);
        while let Some(node) = next {
            match met_from[node as usize].replace(start) {
                Some(earlier) if earlier == start => return Some(node),
                Some(_) => break,
                None => next = parents[node as usize],
            }
        }
    }
    None
}

/// Returns the names of the nodes of a cycle, each parent before its child, with the first repeated at the end.
fn name_the_cycle(document: &Document, parents: &[Option<u32>], node: u32) -> String {
    const MOST: usize = 6;
    let upward = std::iter::successors(parents[node as usize], |&at| parents[at as usize]);
    let mut cycle: Vec<u32> = upward.take_while(|&at| at != node).collect();
    cycle.push(node);
    cycle.reverse();
    let mut names: Vec<String> = cycle
        .iter()
        .take(MOST)
        .map(|&at| document.node_name(at))
        .collect();
    if cycle.len() > MOST {
        names.push(format!("and {} more", cycle.len() - MOST));
    }
    names.push(document.node_name(node));
    names.join(", ")
}

/// Returns the local transform of a node.
fn parent_from_node(
    document: &Document,
    number: u32,
    node: &Node,
    warnings: &mut Warnings,
) -> Result<DAffine3, BrokenRule> {
    let name = || document.node_name(number);
    if let Some(matrix) = &node.matrix {
        let matrix = DMat4::from_cols_array(matrix);
        if !matrix.row(3).abs_diff_eq(DVec4::W, 1e-6) {
            return Err(BrokenRule::NotAffine(name()));
        }
        let affine = DAffine3::from_mat4(matrix);
        if shears(&affine) {
            warnings.name(WarningKind::Sheared, name);
        }
        return Ok(affine);
    }
    let translation = node
        .translation
        .as_deref()
        .map_or(DVec3::ZERO, |&t| DVec3::from(t));
    let scale = node.scale.as_deref().map_or(DVec3::ONE, |&s| DVec3::from(s));
    let rotation = match node.rotation.as_deref() {
        None => DQuat::IDENTITY,
        Some(&[x, y, z, w]) => {
            // Divided by the largest component first, because squares of extreme JSON numbers underflow or overflow.
            let largest = [x, y, z, w]
                .into_iter()
                .fold(0.0_f64, |most, part| most.max(part.abs()));
            if largest == 0.0 {
                warnings.name(WarningKind::Repaired, || {
                    format!("{} has a rotation of length zero", name())
                });
                DQuat::IDENTITY
            } else {
                DQuat::from_vec4((DVec4::new(x, y, z, w) / largest).normalize())
            }
        }
    };
    Ok(DAffine3::from_scale_rotation_translation(
        scale,
        rotation,
        translation,
    ))
}

/// Returns `true` if the axes are not perpendicular, beyond the rounding error of 32-bit floats.
fn shears(affine: &DAffine3) -> bool {
    let [x, y, z] = [
        affine.matrix3.x_axis,
        affine.matrix3.y_axis,
        affine.matrix3.z_axis,
    ];
    [(x, y), (y, z), (z, x)]
        .into_iter()
        .any(|(a, b)| a.dot(b).abs() > 1e-4 * a.length() * b.length())
}

/// Rounds a transform to f32, once, after all multiplications.
fn rounded(affine: &DAffine3) -> Transform {
    Transform::from_columns(
        affine
            .to_cols_array_2d()
            .map(|column| column.map(|value| value as f32)),
    )
}
