//! Large terrain, front to back: culls a quadtree of height-field blocks by minimum and maximum height, and
//! triangulates the visible rest on the fly.
//!
//! Like [`TerrainRows`](super::TerrainRows), but down to squares of 8×8 cells, which are tested one by one, because
//! making their triangles costs more than a test.
//! Source: as for [`TerrainRows`](super::TerrainRows).
//! Cost: O(squares tested), plus reading the heights of the blocks that are not hidden.
//! Guarantees nodes front to back; single faces may come in any order.

use super::Visit;
use super::terrain_rows::near_to_far;
use crate::faces::{FaceSource, Faces};
use crate::geometry::Alpha;
use crate::ids::ItemIndex;
use crate::large_terrain::{LargeTerrain, Workplace};
use crate::view::passage::Passage;
use crate::view::region::Visibility;

/// State of one traversal.
struct Traversal<'a> {
    terrain: &'a LargeTerrain,
    passage: &'a Passage,
    eye: [f64; 3],
}

impl LargeTerrain {
    /// Emits all openings and clusters that may be visible through `passage`.
    pub(crate) fn visit(&self, passage: &Passage, workplace: &mut Workplace, visit: &mut impl Visit) {
        let first = self.first_opening();
        Faces::of_openings(self.holes(), passage, |faces| {
            visit.faces(&Faces {
                first_owner: first + faces.first_owner,
                item_start: first + faces.item_start,
                ..*faces
            });
        });
        let traversal = Traversal {
            terrain: self,
            passage,
            eye: passage.viewpoint(),
        };
        traversal.walk(self.level_count() - 1, [0, 0], workplace, visit);
    }
}

impl Traversal<'_> {
    /// Visits a quadtree square and its visible children, front to back.
    fn walk(&self, level: usize, square: [u32; 2], workplace: &mut Workplace, visit: &mut impl Visit) {
        let Traversal {
            terrain,
            passage,
            eye,
        } = *self;
        let bounds = terrain.bounds_of(level, square);
        if visit.enter_box(passage, &passage.screen_from_sector, &bounds) == Visibility::Hidden {
            return;
        }
        let Some(below) = level.checked_sub(1) else {
            return self.emit_block(square, workplace, visit);
        };
        let size = terrain.level_size(below);
        let [columns, rows] = [0, 1].map(|axis| {
            let first = 2 * square[axis];
            let squares = (size[axis] - first).min(2);
            let border = move |square| terrain.border(below, first + square, axis);
            near_to_far(squares, border, eye[2 * axis]).map(move |square| first + square)
        });
        for row in rows {
            for column in columns.clone() {
                self.walk(below, [column, row], workplace, visit);
            }
        }
    }

    /// Reads a block and emits its squares that may be visible, front to back.
    fn emit_block(&self, block: [u32; 2], workplace: &mut Workplace, visit: &mut impl Visit) {
        let Traversal {
            terrain,
            passage,
            eye,
        } = *self;
        terrain.read(block, workplace);
        let item = ItemIndex(terrain.block_number(block));
        let item_start = terrain.first_face(block);
        let squares = terrain.squares(block);
        let [columns, rows] = [0, 1].map(|axis| {
            let border = move |square| terrain.square_border(block, square, axis);
            near_to_far(squares[axis], border, eye[2 * axis])
        });
        for row in rows {
            for column in columns.clone() {
                let square = terrain.square(block, [column, row]);
                let bounds = terrain.bounds_in(&square, block, workplace);
                if visit.enter_box(passage, &passage.screen_from_sector, &bounds) == Visibility::Hidden {
                    continue;
                }
                let (positions, corners) = terrain.triangles(&square, block, workplace);
                visit.faces(&Faces {
                    source: FaceSource::Item(item, square.number),
                    first_owner: item_start + terrain.first_face_in(square.number),
                    item_start,
                    positions,
                    first_position: 0,
                    corners,
                    starts: None,
                    neighbours: &[],
                    screen_from_local: &passage.screen_from_sector,
                    mirrored: false,
                    double_sided: true,
                    alpha: Alpha::Opaque,
                    can_occlude: true,
                    cuts: &[],
                });
            }
        }
    }
}
