//! Terrain near to far, and between its blocks what stands on it: whole squares of blocks dropped by the least and the greatest
//! of their heights.
//!
//! Squares of a height field are parted by upright planes, so that the one that the eye stands over comes before its
//! neighbours, and these before the one beyond both: no ground comes after ground that it hides, wherever the eye is and
//! however it is turned.
//! Source: Boreskov, Using portals to create aggregate scenes (floating horizon); Anderson, Hidden Line Elimination in
//!     Projected Grid Surfaces, ACM Transactions on Graphics 1982; the quadtree as in Samet, The Quadtree and Related
//!     Hierarchical Data Structures, ACM Computing Surveys 1984.
//! Cost: building O(samples); a walk O(squares met), then as [`OctreeOrder`](super::OctreeOrder) for all else.
//! Gives nodes near to far; single faces may come in any order.

use super::items::{hand_out, hand_out_openings};
use super::queue::{Queue, begin, go_on};
use super::{NodesNearToFar, Order, Refusal, Visit};
use crate::geom::Aabb;
use crate::geometry::{Geometry, ItemId, MovedItem};
use crate::passage::{Passage, eye_in};
use crate::region::{Region, Visibility};
use crate::terrain::Terrain;
use glam::DAffine3;

/// Squares of height fields in squares, and before each block what is nearer, by the geometry's own tree.
pub struct TerrainRows {
    grounds: Vec<Ground>,
}

/// One height field.
struct Ground {
    terrain: Terrain,
    /// The blocks first, then squares of 2×2 of the level before.
    levels: Vec<Level>,
}

struct Level {
    size: [u32; 2],
    bounds: Vec<Aabb>,
}

impl Order for TerrainRows {
    type Gives = NodesNearToFar;
    type Scratch = Queue;

    fn build(geometry: &Geometry, _limit_bytes: u64) -> Result<TerrainRows, Refusal> {
        let terrains = geometry.terrains();
        if terrains.is_empty() {
            return Err(Refusal::NoTerrain);
        }
        if !terrains.iter().all(|terrain| terrain.is_whole(geometry)) {
            return Err(Refusal::TerrainChanged);
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
        // The tree over all else is the geometry's, and has followed them already.
        let is_ground = |item: u32| {
            let mut grounds = self.grounds.iter();
            grounds.any(|ground| ground.terrain.blocks.contains(&item))
        };
        !moved.iter().any(|moved| is_ground(moved.item.0))
    }

    fn visit(&self, geometry: &Geometry, passage: &Passage, queue: &mut Queue, visit: &mut impl Visit) {
        let things = Things {
            grounds: &self.grounds,
            geometry,
            passage,
        };
        if things.are_none() {
            hand_out_openings(geometry, passage, visit);
        } else {
            begin(geometry.item_tree(), geometry, passage, queue, visit);
        }
        for ground in &self.grounds {
            let screen_from_field = passage.screen_from(&ground.terrain.sector_from_field);
            let way = Way {
                things: &things,
                screen_from_field,
                eye: eye_in(&screen_from_field).into(),
            };
            let top = ground.levels.len() - 1;
            ground.walk(&way, top, [0, 0], queue, visit);
        }
        things.hand_out(f32::NEG_INFINITY, queue, visit);
    }
}

/// What is not ground, on its way out of the geometry's own tree.
struct Things<'a> {
    grounds: &'a [Ground],
    geometry: &'a Geometry,
    passage: &'a Passage,
}

impl Things<'_> {
    fn are_none(&self) -> bool {
        let blocks = self.grounds.iter().map(|ground| ground.terrain.blocks.len());
        blocks.sum::<usize>() == self.geometry.items().len()
    }

    /// Hands out those that are at least so near, and were not yet.
    fn hand_out(&self, rev_depth: f32, queue: &mut Queue, visit: &mut impl Visit) {
        if self.are_none() {
            return;
        }
        let is_thing = |item: u32| {
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
            is_thing,
        );
    }
}

/// What a walk over one height field goes by.
struct Way<'a> {
    things: &'a Things<'a>,
    screen_from_field: DAffine3,
    eye: [f64; 3],
}

impl Ground {
    fn new(terrain: &Terrain, geometry: &Geometry) -> Ground {
        let size = terrain.field.blocks();
        let blocks = terrain.blocks.clone();
        let mut levels = vec![Level {
            size,
            bounds: blocks
                .map(|item| geometry.mesh_of(ItemId(item)).bounds())
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

    /// Goes through a square, and those in it that may be seen, near to far.
    fn walk(
        &self,
        way: &Way,
        level: usize,
        [column, row]: [u32; 2],
        queue: &mut Queue,
        visit: &mut impl Visit,
    ) {
        let Level { size, bounds } = &self.levels[level];
        let place = (row * size[0] + column) as usize;
        let Things {
            geometry, passage, ..
        } = *way.things;
        let Some(region) = Region::of(passage, &way.screen_from_field, &bounds[place]) else {
            return;
        };
        if level == 0 {
            way.things.hand_out(region.nearest, queue, visit);
            let item = ItemId(self.terrain.blocks.start + place as u32);
            hand_out(geometry, passage, item, visit);
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
            near_to_far(squares, border, way.eye[2 * axis]).map(move |square| first + square)
        });
        for row in rows {
            for column in columns.clone() {
                self.walk(way, level - 1, [column, row], queue, visit);
            }
        }
    }
}

/// Squares in a row, each before those that are beyond it: the eye's own and what is before it, then what is after. `border` says
/// where one begins, but for the first.
pub(super) fn near_to_far(
    squares: u32,
    border: impl Fn(u32) -> f64,
    eye: f64,
) -> impl Iterator<Item = u32> + Clone {
    let own = (1..squares).take_while(|&square| border(square) <= eye).count() as u32;
    (0..=own).rev().chain(own + 1..squares)
}

impl Level {
    /// Where a column of squares begins, or with axis 1 a row: x, or z.
    fn border(&self, square: u32, axis: usize) -> f64 {
        let place = if axis == 0 { square } else { square * self.size[0] };
        f64::from(self.bounds[place as usize].min[2 * axis])
    }

    /// Squares of 2×2 of these.
    fn above(&self) -> Level {
        let size = self.size.map(|side| side.div_ceil(2));
        let mut bounds = vec![Aabb::EMPTY; (size[0] * size[1]) as usize];
        for (place, below) in (0..).zip(&self.bounds) {
            let [column, row] = [place % self.size[0] / 2, place / self.size[0] / 2];
            let square = &mut bounds[(row * size[0] + column) as usize];
            *square = square.union(below);
        }
        Level { size, bounds }
    }
}
