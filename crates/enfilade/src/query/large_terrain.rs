//! Ray casts against out-of-core terrain.
//!
//! Idea: traverses the quadtree of squares, then clusters, near to far by their vertical splitting planes. Squares
//!     beyond the first hit are skipped, and blocks that the ray misses are not read.
//! Source: the traversal is that of the floating horizon's order; the triangle test as in `query/cast.rs`.
//! Cost: O(squares met), plus reading the blocks among them.

use super::cast::{line_of, meet};
use crate::geom::Line;
use crate::ids::ItemIndex;
use crate::large_terrain::{LargeTerrain, Workplace};
use crate::sector::{Hit, Ray};
use glam::DVec3;

impl LargeTerrain {
    /// Returns the first face along a ray, as [`Geometry::cast`](crate::Geometry::cast) does.
    pub(crate) fn first_along(&self, ray: &Ray) -> Option<Hit> {
        let mut search = Search {
            terrain: self,
            line: line_of(ray)?,
            first: None,
            workplace: Workplace::default(),
        };
        search.walk(self.level_count() - 1, [0, 0]);
        search.first
    }
}

struct Search<'a> {
    terrain: &'a LargeTerrain,
    line: Line,
    first: Option<Hit>,
    workplace: Workplace,
}

impl Search<'_> {
    fn limit(&self) -> f64 {
        self.first.map_or(f64::INFINITY, |hit| hit.distance)
    }

    fn walk(&mut self, level: usize, square: [u32; 2]) {
        let bounds = self.terrain.bounds_of(level, square);
        if self.line.meets(&bounds, 0.0, self.limit()).is_none() {
            return;
        }
        let Some(below) = level.checked_sub(1) else {
            return self.through_block(square);
        };
        let size = self.terrain.level_size(below);
        // A ray crosses the plane between two squares once, in its own direction.
        let [columns, rows] = [0, 1].map(|axis| {
            let first = 2 * square[axis];
            if self.line.direction[2 * axis] < 0.0 {
                [first + 1, first]
            } else {
                [first, first + 1]
            }
        });
        for row in rows {
            for column in columns {
                if column < size[0] && row < size[1] {
                    self.walk(below, [column, row]);
                }
            }
        }
    }

    fn through_block(&mut self, block: [u32; 2]) {
        let terrain = self.terrain;
        terrain.read(block, &mut self.workplace);
        let item = ItemIndex(terrain.block_number(block));
        let [columns, rows] = terrain.squares(block);
        for place in (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row])) {
            let square = terrain.square(block, place);
            let bounds = terrain.bounds_in(&square, block, &self.workplace);
            let Some([enter, leave]) = self.line.meets(&bounds, 0.0, self.limit()) else {
                continue;
            };
            let (positions, corners) = terrain.triangles(&square, block, &mut self.workplace);
            let faces = corners.as_chunks::<3>().0.iter();
            for (face, corners) in (terrain.first_face_in(square.number)..).zip(faces) {
                let triangle = corners.map(|corner| DVec3::from(positions[corner as usize].map(f64::from)));
                let Some((distance, from_behind)) = meet(triangle, self.line.origin, self.line.direction)
                else {
                    continue;
                };
                let distance = distance.max(enter).min(leave.max(f64::MIN_POSITIVE));
                let comes_first =
                    |known: Hit| (distance, item, face) < (known.distance, known.item.index, known.face);
                if self.first.is_none_or(comes_first) {
                    self.first = Some(Hit {
                        item: item.into(),
                        key: u64::from(item.0),
                        face,
                        distance,
                        from_behind,
                    });
                }
            }
        }
    }
}
