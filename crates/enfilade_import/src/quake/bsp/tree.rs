//! The BSP tree of a map: planes that split its space into leafs.
//!
//! A child index is a node, or, if negative, a leaf: −1 is leaf 0. In BSP29, children are 16-bit; values beyond the
//! last node are leafs, counted down from 0xFFFF.
//! Hostile input: every index is checked, and each node is reached at most once, so traversals terminate.

use super::BspError;
use super::lumps::{Map, word};

/// The planes, nodes and leafs of a map.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub(crate) planes: Vec<SplitPlane>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) leafs: Vec<Leaf>,
    /// Root of the world model.
    pub(crate) root: Child,
}

/// A plane: points with `normal · point = offset`, in the map's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SplitPlane {
    pub(crate) normal: [f64; 3],
    pub(crate) offset: f64,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub(crate) plane: u32,
    /// In front of the plane, behind it.
    pub(crate) children: [Child; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Child {
    Node(u32),
    Leaf(u32),
}

/// The leaf data that both games have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf {
    /// Quake: contents; −1 air, −2 solid, −3 to −5 liquids, −6 sky. Quake 3: cluster, −1 for none.
    pub(crate) kind: i32,
    /// Quake: offset of the PVS row in the visibility lump, −1 for a leaf from which everything is visible. Quake 3:
    /// area.
    pub(crate) row: i32,
    /// First entry in the leaf-face lump, and number of entries.
    pub(crate) faces: [u32; 2],
}

impl Tree {
    /// Reads the tree and finds the root of the world. Nodes and leafs of brush models such as doors are in the same
    /// lists, but not below this root.
    pub(crate) fn read(map: &Map) -> Result<Tree, BspError> {
        let format = map.format;
        let planes: Vec<SplitPlane> = map
            .records(format.planes, format.plane_bytes)?
            .map(|plane| SplitPlane {
                normal: [0, 4, 8].map(|at| number(plane, at).into()),
                offset: number(plane, 12).into(),
            })
            .collect();
        let no_place = |plane: &SplitPlane| {
            let length: f64 = plane.normal.iter().map(|at| at * at).sum();
            !plane.offset.is_finite() || !(0.5..2.0).contains(&length)
        };
        if let Some(at) = planes.iter().position(no_place) {
            return Err(BspError::NoPlane { plane: at });
        }
        let leafs: Vec<Leaf> = map
            .records(format.leafs, format.leaf_bytes)?
            .map(|leaf| Leaf {
                kind: int(leaf, 0),
                row: int(leaf, 4),
                faces: match (format.is_quake3, format.is_short) {
                    (true, _) => [32, 36].map(|at| int(leaf, at) as u32),
                    (_, true) => [20, 22].map(|at| short(leaf, at).into()),
                    (_, false) => [32, 36].map(|at| int(leaf, at) as u32),
                },
            })
            .collect();
        let nodes = map.records(format.nodes, format.node_bytes)?;
        let count = nodes.len();
        let read = nodes.enumerate().map(|(at, node)| {
            let plane = in_range("node", at, "plane", int(node, 0).into(), planes.len())?;
            let child = |side: usize| {
                let number = if format.is_short {
                    let short = short(node, 4 + 2 * side);
                    if usize::from(short) < count {
                        i32::from(short)
                    } else {
                        i32::from(short) - 0x1_0000
                    }
                } else {
                    int(node, 4 + 4 * side)
                };
                child("node", at, number, count, leafs.len())
            };
            let children = [child(0)?, child(1)?];
            Ok(Node { plane, children })
        });
        let nodes: Vec<Node> = read.collect::<Result<_, BspError>>()?;
        let first = if format.is_quake3 {
            if nodes.is_empty() { -1 } else { 0 }
        } else {
            let world = map.records(format.models, format.model_bytes)?.next();
            let first = world.and_then(|world| word(world, HEAD_NODE));
            first.ok_or(BspError::OddLump {
                lump: format.models,
                bytes: 0,
                of: format.model_bytes,
            })?
        };
        let root = child("model", 0, first, nodes.len(), leafs.len())?;
        let tree = Tree {
            planes,
            nodes,
            leafs,
            root,
        };
        tree.is_a_tree()?;
        Ok(tree)
    }

    /// Checks that no node is reached twice.
    fn is_a_tree(&self) -> Result<(), BspError> {
        let mut met = vec![false; self.nodes.len()];
        let mut waiting = vec![self.root];
        while let Some(child) = waiting.pop() {
            let Child::Node(node) = child else { continue };
            if std::mem::replace(&mut met[node as usize], true) {
                return Err(BspError::Loop { node });
            }
            waiting.extend(self.nodes[node as usize].children);
        }
        Ok(())
    }
}

/// Offset of the first node in a Quake model record, in bytes.
const HEAD_NODE: usize = 36;

fn child(what: &'static str, at: usize, number: i32, nodes: usize, leafs: usize) -> Result<Child, BspError> {
    if number >= 0 {
        in_range(what, at, "node", number.into(), nodes).map(Child::Node)
    } else {
        in_range(what, at, "leaf", -1 - i64::from(number), leafs).map(Child::Leaf)
    }
}

/// Checks that `number` is a valid index into `count` records.
pub(crate) fn in_range(
    what: &'static str,
    at: usize,
    names: &'static str,
    number: i64,
    count: usize,
) -> Result<u32, BspError> {
    if (0..count as i64).contains(&number) {
        Ok(number as u32)
    } else {
        Err(BspError::NoSuch {
            what,
            at,
            names,
            number,
            count,
        })
    }
}

/// Reads a little-endian `i32` of a record.
pub(crate) fn int(bytes: &[u8], at: usize) -> i32 {
    i32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

pub(crate) fn short(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

pub(crate) fn number(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}
