//! Terrain front to back, interleaved with other items: a quadtree of height-field blocks, culled by minimum and
//! maximum height.
//!
//! Vertical planes separate the squares of a height field. The square below or above the eye comes before its
//! neighbours, and these before the square beyond both. So no ground comes after ground that it occludes, for any
//! position and orientation of the eye.
//! Source: Boreskov, Using portals to create aggregate scenes (floating horizon); Anderson, Hidden Line Elimination in
//!     Projected Grid Surfaces, ACM Transactions on Graphics 1982; the quadtree as in Samet, The Quadtree and Related
//!     Hierarchical Data Structures, ACM Computing Surveys 1984.
//! Cost: building O(samples); a traversal O(squares tested), plus that of [`OctreeOrder`](super::OctreeOrder) for all
//!     other items.
//! Guarantees nodes front to back; single faces may come in any order.

use super::{NodesNearToFar, Order, Visit};
use crate::geom::Aabb;
use crate::geometry::Terrain;
use crate::geometry::{Geometry, MovedItem};
use crate::ids::ItemIndex;
use crate::sector::Requirement;
use crate::traversal::{Queue, begin, go_on};
use crate::traversal::{emit_item, emit_openings};
use crate::unsuited::Unsuited;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use crate::view::screen_map::ScreenMap;

/// Front-to-back traversal of terrain blocks by a quadtree, interleaved with the geometry's octree over the other
/// items.
pub struct TerrainRows {
    grounds: Vec<Ground>,
}

/// Quadtree over the blocks of one height field.
struct Ground {
    terrain: Terrain,
    /// Blocks first, then squares of 2×2 of the level before.
    levels: Vec<Level>,
}

struct Level {
    size: [u32; 2],
    bounds: Vec<Aabb>,
}

impl Order for TerrainRows {
    type Gives = NodesNearToFar;
    type Scratch = Queue;

    const NAME: &'static str = "TerrainRows";
    const REQUIRES: Option<Requirement> = Some(Requirement::Terrain);

    fn build(geometry: &Geometry, _limit_bytes: u64) -> Result<TerrainRows, Unsuited> {
        let terrains = geometry.terrains();
        if terrains.is_empty() {
            return Err(Unsuited::NoTerrain);
        }
        if !terrains.iter().all(|terrain| terrain.is_whole(geometry)) {
            return Err(Unsuited::TerrainEdited);
        }
        geometry.item_tree();
        Ok(TerrainRows {
            grounds: terrains
                .iter()
                .map(|terrain| Ground::new(terrain, geometry))
                .collect(),
        })
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        let blocks = geometry
            .terrains()
            .iter()
            .map(|terrain| terrain.blocks.len() as u64);
        blocks.sum::<u64>() * 2 * size_of::<Aabb>() as u64 + geometry.items().len() as u64 * 2 * 64
    }

    fn bytes(&self) -> u64 {
        let levels = self.grounds.iter().flat_map(|ground| &ground.levels);
        levels.map(|level| size_of_val(&*level.bounds) as u64).sum()
    }

    fn follow(&mut self, _geometry: &Geometry, moved: &[MovedItem], _touched: &mut Vec<u32>) -> bool {
        // The geometry owns the tree over all other items and has updated it already.
        let is_ground = |item: u32| {
            let mut grounds = self.grounds.iter();
            grounds.any(|ground| ground.terrain.blocks.contains(&item))
        };
        !moved.iter().any(|moved| is_ground(moved.item.0))
    }

    fn visit(&self, geometry: &Geometry, passage: &Passage, queue: &mut Queue, visit: &mut impl Visit) {
        let others = OtherItems {
            grounds: &self.grounds,
            geometry,
            passage,
        };
        if others.is_empty() {
            emit_openings(geometry, passage, visit);
        } else {
            begin(geometry.item_tree(), geometry, passage, queue, visit);
        }
        for ground in &self.grounds {
            let screen_from_field = passage.screen_from(&ground.terrain.sector_from_field);
            let traversal = Traversal {
                others: &others,
                screen_from_field,
                eye: screen_from_field.eye().into(),
            };
            let top = ground.levels.len() - 1;
            ground.walk(&traversal, top, [0, 0], queue, visit);
        }
        others.emit(f32::NEG_INFINITY, queue, visit);
    }
}

/// All items that are not terrain, from the traversal of the geometry's octree.
struct OtherItems<'a> {
    grounds: &'a [Ground],
    geometry: &'a Geometry,
    passage: &'a Passage,
}

impl OtherItems<'_> {
    fn is_empty(&self) -> bool {
        let blocks = self.grounds.iter().map(|ground| ground.terrain.blocks.len());
        blocks.sum::<usize>() == self.geometry.items().len()
    }

    /// Emits the items with reversed depth ≥ `rev_depth` that have not been emitted yet.
    fn emit(&self, rev_depth: f32, queue: &mut Queue, visit: &mut impl Visit) {
        if self.is_empty() {
            return;
        }
        let is_other = |item: u32| {
            let mut grounds = self.grounds.iter();
            grounds.all(|ground| !ground.terrain.blocks.contains(&item))
        };
        let tree = self.geometry.item_tree();
        go_on(
            tree,
            self.geometry,
            self.passage,
            queue,
            visit,
            rev_depth,
            is_other,
        );
    }
}

/// State of the traversal of one height field.
struct Traversal<'a> {
    others: &'a OtherItems<'a>,
    screen_from_field: ScreenMap,
    eye: [f64; 3],
}

impl Ground {
    fn new(terrain: &Terrain, geometry: &Geometry) -> Ground {
        let size = terrain.field.blocks();
        let blocks = terrain.blocks.clone();
        let mut levels = vec![Level {
            size,
            bounds: blocks
                .map(|item| geometry.mesh_of(ItemIndex(item)).bounds())
                .collect(),
        }];
        while let Some(last) = levels.last().filter(|level| level.size != [1, 1]) {
            levels.push(last.above());
        }
        Ground {
            terrain: terrain.clone(),
            levels,
        }
    }

    /// Visits a square and its visible children, front to back.
    fn walk(
        &self,
        traversal: &Traversal,
        level: usize,
        [column, row]: [u32; 2],
        queue: &mut Queue,
        visit: &mut impl Visit,
    ) {
        let Level { size, bounds } = &self.levels[level];
        let index = (row * size[0] + column) as usize;
        let OtherItems {
            geometry, passage, ..
        } = *traversal.others;
        let Some(region) = Region::of(passage, &traversal.screen_from_field, &bounds[index]) else {
            return;
        };
        if level == 0 {
            traversal.others.emit(region.nearest, queue, visit);
            let item = ItemIndex(self.terrain.blocks.start + index as u32);
            emit_item(geometry, passage, item, visit);
            return;
        }
        if visit.enter(&region) == Visibility::Hidden {
            return;
        }
        let below = &self.levels[level - 1];
        let [columns, rows] = [(column, 0), (row, 1)].map(|(square, axis)| {
            let first = 2 * square;
            let squares = (below.size[axis] - first).min(2);
            let border = move |square| below.border(first + square, axis);
            near_to_far(squares, border, traversal.eye[2 * axis]).map(move |square| first + square)
        });
        for row in rows {
            for column in columns.clone() {
                self.walk(traversal, level - 1, [column, row], queue, visit);
            }
        }
    }
}

/// Returns the indices of a row of squares, each before those beyond it: the eye's own square and those before it in
/// descending order, then those after it. `border` returns where a square begins, for all but the first.
pub(super) fn near_to_far(
    squares: u32,
    border: impl Fn(u32) -> f64,
    eye: f64,
) -> impl Iterator<Item = u32> + Clone {
    let own = (1..squares).take_while(|&square| border(square) <= eye).count() as u32;
    (0..=own).rev().chain(own + 1..squares)
}

impl Level {
    /// Returns where a column of squares begins (axis 0: x), or a row (axis 1: z).
    fn border(&self, square: u32, axis: usize) -> f64 {
        let index = if axis == 0 { square } else { square * self.size[0] };
        f64::from(self.bounds[index as usize].min[2 * axis])
    }

    /// Returns the next level: squares of 2×2 of these.
    fn above(&self) -> Level {
        let size = self.size.map(|side| side.div_ceil(2));
        let mut bounds = vec![Aabb::EMPTY; (size[0] * size[1]) as usize];
        for (index, below) in (0..).zip(&self.bounds) {
            let [column, row] = [index % self.size[0] / 2, index / self.size[0] / 2];
            let square = &mut bounds[(row * size[0] + column) as usize];
            *square = square.union(below);
        }
        Level { size, bounds }
    }
}
