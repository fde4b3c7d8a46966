//! Reads the baked visibility of a map: its BSP tree, whose leafs are cells, and their PVS rows.
//!
//! In Quake, the cells are the world's leafs except the first, which is solid; a row has one bit per cell, and runs of
//! zero bytes are stored as a zero and their length. In Quake 3, the cells are clusters of leafs, with uncompressed
//! rows.
//! Source: the source code of both engines, published by id Software.
//! Cost: O(bytes of all rows, uncompressed).

use super::axes::turned_exactly;
use crate::BrokenRule;
use crate::budget::Budget;
use crate::quake::bsp::{BspError, Child, Map, Node, Tree, in_range, int};
use enfilade::{BakedCells, CellId, CellNode, CellSide, CellTree};
use std::collections::HashMap;

/// Tolerance for faces and portals in a plane, in map units: compilers snap vertices.
const SNAPPED: f64 = 0.1;

/// Returns the cells of a map; `None` if it has no PVS.
pub(super) fn read(map: &Map, tree: &Tree, budget: &mut Budget) -> Result<Option<BakedCells>, BrokenRule> {
    let lump = map.lump(map.format.visibility);
    if lump.is_empty() {
        return Ok(None);
    }
    let rows = if map.format.is_quake3 {
        Rows::of_quake3(lump, tree)?
    } else {
        Rows::of_quake(lump, tree, map.world_leafs()?)?
    };
    budget.take(
        64 * tree.nodes.len() as u64 + 16 * tree.leafs.len() as u64,
        || "its planes".to_owned(),
    )?;
    rows.afford(budget)?;
    let row = |start: &usize| rows.seen(*start).map(CellId);
    let cells = BakedCells::new(rows.planes(tree), &rows.row_of, rows.starts.iter().map(row));
    // Everything that `BakedCells::new` checks has been checked above, with error messages in terms of the map.
    cells.map(Some).map_err(|why| BrokenRule::Cells(Box::new(why)))
}

/// The PVS rows of the visibility lump.
struct Rows<'m> {
    lump: &'m [u8],
    is_packed: bool,
    /// Cell of each leaf.
    cell_of: Vec<Option<CellId>>,
    /// Row of each cell; `None` if everything is visible from it.
    row_of: Vec<Option<u32>>,
    /// Start of each row in the lump.
    starts: Vec<usize>,
}

impl<'m> Rows<'m> {
    fn of_quake(lump: &'m [u8], tree: &Tree, world_leafs: i32) -> Result<Rows<'m>, BspError> {
        let leafs = tree.leafs.len();
        let count = in_range("model", 0, "leaf", world_leafs.into(), leafs)? as usize;
        let mut rows = Rows {
            lump,
            is_packed: true,
            cell_of: vec![None; leafs],
            row_of: Vec::with_capacity(count),
            starts: Vec::new(),
        };
        let mut numbers = HashMap::new();
        for (cell, (leaf, of)) in (1..).zip(&tree.leafs[1..]).take(count).enumerate() {
            rows.cell_of[leaf] = Some(CellId(cell as u32));
            let start = match of.row {
                -1 => None,
                start => Some(in_range("leaf", leaf, "byte of rows", start.into(), lump.len())? as usize),
            };
            rows.row_of.push(start.map(|start| {
                *numbers.entry(start).or_insert_with(|| {
                    rows.starts.push(start);
                    rows.starts.len() as u32 - 1
                })
            }));
        }
        Ok(rows)
    }

    fn of_quake3(lump: &'m [u8], tree: &Tree) -> Result<Rows<'m>, BspError> {
        let cut_short = |at| BspError::RowCutShort {
            from: "cluster",
            at,
            has: lump.len(),
        };
        let head = lump.first_chunk::<8>().ok_or_else(|| cut_short(0))?;
        let [count, row_bytes] = [0, 4].map(|at| i64::from(int(head, at)));
        let fits = count >= 0
            && row_bytes >= (count + 7) / 8
            && count
                .checked_mul(row_bytes)
                .is_some_and(|bytes| bytes + 8 <= lump.len() as i64);
        if !fits {
            return Err(cut_short(count.max(1) as usize - 1));
        }
        let mut rows = Rows {
            lump,
            is_packed: false,
            cell_of: Vec::with_capacity(tree.leafs.len()),
            row_of: (0..count as u32).map(Some).collect(),
            starts: (0..count).map(|row| (8 + row * row_bytes) as usize).collect(),
        };
        for (leaf, of) in tree.leafs.iter().enumerate() {
            // Solid leafs have cluster −1.
            let cluster = match of.kind {
                ..0 => None,
                kind => Some(in_range("leaf", leaf, "cluster", kind.into(), count as usize)?),
            };
            rows.cell_of.push(cluster.map(CellId));
        }
        Ok(rows)
    }

    /// Checks that no row exceeds the lump, and reserves memory for all rows as runs of visible cells. The scanned
    /// bytes count too, so that many long overlapping rows cannot take unbounded time.
    fn afford(&self, budget: &mut Budget) -> Result<(), BrokenRule> {
        const BYTES_OF_A_RUN: u64 = 8;
        for (number, &start) in self.starts.iter().enumerate() {
            let mut left = self.row_of.len();
            let (mut bytes, mut runs, mut last) = (0, 0, 0);
            let mut row = self.lump[start..].iter();
            let cut_short = || BspError::RowCutShort {
                from: if self.is_packed { "row" } else { "cluster" },
                at: number,
                has: self.lump.len(),
            };
            while left > 0 {
                let byte = *row.next().ok_or_else(cut_short)?;
                let count = match (byte, self.is_packed) {
                    (0, true) => usize::from(*row.next().ok_or_else(cut_short)?),
                    _ => 1,
                };
                left = left.saturating_sub(8 * count);
                bytes += 2;
                runs += u64::from((byte & !(byte << 1 | last >> 7)).count_ones());
                last = byte;
            }
            budget.take(bytes + BYTES_OF_A_RUN * runs, || "its visibility data".to_owned())?;
        }
        Ok(())
    }

    /// Returns the visible cells of a row.
    fn seen(&self, start: usize) -> impl Iterator<Item = u32> + '_ {
        let count = self.row_of.len() as u32;
        let mut row = self.lump[start..].iter();
        let mut first = 0;
        let bytes = std::iter::from_fn(move || {
            while first < count {
                let byte = *row.next()?;
                if byte == 0 && self.is_packed {
                    first += 8 * u32::from(*row.next()?);
                    continue;
                }
                first += 8;
                return Some((first - 8, byte));
            }
            None
        });
        bytes.flat_map(move |(first, byte)| {
            let bits = (0..8).filter(move |bit| byte >> bit & 1 != 0);
            bits.map(move |bit| first + bit).filter(move |&cell| cell < count)
        })
    }

    /// Converts the BSP tree to the axes of the scene.
    fn planes(&self, tree: &Tree) -> CellTree {
        let side = |child: Child| match child {
            Child::Node(node) => CellSide::Node(node),
            Child::Leaf(leaf) => self.cell_of[leaf as usize].map_or(CellSide::Solid, CellSide::Cell),
        };
        let node = |node: &Node| {
            let plane = &tree.planes[node.plane as usize];
            CellNode {
                normal: turned_exactly(plane.normal),
                distance: plane.offset,
                front: side(node.children[0]),
                back: side(node.children[1]),
            }
        };
        CellTree {
            root: side(tree.root),
            nodes: tree.nodes.iter().map(node).collect(),
            tolerance: SNAPPED,
        }
    }
}
