//! Masked occlusion buffer: for each 8×4 samples two nearnesses, and a mask that says which of them holds where.
//!
//! Sixteen bytes say of 32 samples what would take a depth buffer 128, and one comparison answers for all of them. It
//! holds no picture: few chosen occluders go in first, then boxes are held against it, and the faces of what a walk finds
//! hide what it finds later.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016; the answer does not depend
//!     on how many sub-tiles a kernel takes at once. Beyond the paper: the second test, by a box's outline and front
//!     sides, and holding faces against the tiles as boxes are. Leaving out faces that are small on the screen: Boreskov,
//!     Hierarchical s-buffer for scenes of high complexity.
//! Cost: clear O(tiles of the aperture); an occluder or a face O(tiles it reaches into); a box O(tiles of its rectangle)
//!     where it is hidden, less where it is plainly seen.
//! Conservative: what is stored is never nearer than the truth, a box is never asked about farther than it is, and what
//!     is equally near is seen.

mod ask;
mod batch;
mod coarse;
mod faces;
mod fill;
mod grid;
mod mesh;
mod outline;
mod rows;
mod show;
#[cfg(test)]
mod tests;
mod tile;

use super::raster::Raster;
use super::{Cover, Hides};
use crate::aperture::Rect;
use crate::canvas::{Canvas, CoverShape};
use crate::faces::Faces;
use crate::occluders::{Measure, Occluder};
use crate::order::Unsorted;
use crate::passage::{BEYOND, Passage};
use crate::region::{Region, Sight};
use crate::simd::level;
use crate::stats::Stats;
use batch::{Batch, Block, Frame, LANES, Shapes};
use faces::OneByOne;
use fearless_simd::{Level, dispatch};
use fill::Fill;
use grid::Grid;
pub use mesh::OccluderMesh;
use mesh::block;
use tile::{COLUMNS, ROWS, Tile};

/// Samples of a box, for each face in it, from which on its faces are let in. Where they have fewer, what they hide is not
/// worth setting them up.
const WORTH: u64 = 4;

/// A masked occlusion buffer.
pub struct MaskedDepth {
    level: Level,
    fill: Fill,
    raster: Raster,
    batch: Batch,
    room: Room,
    grid: Grid,
    near: f64,
}

/// A batch of faces as a kernel takes it.
#[derive(Default)]
struct Room {
    blocks: Vec<Block>,
    /// What faces of more corners than three are taken for, and faces that face the eye.
    quads: Vec<[u32; 4]>,
    triangles: Vec<[u32; 3]>,
}

impl Default for MaskedDepth {
    fn default() -> MaskedDepth {
        MaskedDepth::at(level())
    }
}

impl MaskedDepth {
    /// At a SIMD level, which changes the time it takes and no bit of what it says.
    fn at(level: Level) -> MaskedDepth {
        MaskedDepth {
            level,
            fill: Fill::at(level),
            raster: Raster::at(level),
            batch: Batch::default(),
            room: Room::default(),
            grid: Grid::default(),
            near: 0.0,
        }
    }
}

impl Cover for MaskedDepth {
    type CullNeeds = Unsorted;

    fn sees(&mut self, region: &Region) -> Sight {
        let seen = dispatch!(self.level, simd => self.grid.sees(simd, region, self.near));
        if seen { Sight::Partly } else { Sight::Hidden }
    }

    fn needs_bytes(size: [u32; 2]) -> u64 {
        let tiles = u64::from(size[0].div_ceil(COLUMNS as u32)) * u64::from(size[1].div_ceil(ROWS as u32));
        tiles * (size_of::<Tile>() + size_of::<f32>()) as u64
    }

    const SHAPE: Option<CoverShape> = Some(CoverShape::Tiles);

    fn show(&mut self, passage: &Passage, canvas: &mut dyn Canvas) {
        self.grid.show(passage, canvas);
    }
}

impl Hides for MaskedDepth {
    const MEASURE: Measure = Measure::ProjectedArea;
    // The faces that are found, from near to far, hide as much, and choosing takes longer than letting them in.
    const OCCLUDERS: u32 = 0;

    fn clear(&mut self, passage: &Passage) {
        self.grid.clear(passage);
        self.near = f64::from(passage.near);
    }

    fn hide(&mut self, occluder: &Occluder, passage: &Passage, stats: &mut Stats) {
        stats.samples += self.fill.hide(&mut self.grid, occluder, passage);
    }

    const TAKES_FACES: bool = true;

    fn hide_faces(&mut self, faces: &Faces, region: &Region, passage: &Passage, stats: &mut Stats) {
        if !Self::are_too_fine(faces.count() as u64, region) {
            self.hide_batch(faces, passage, stats);
        }
    }

    fn are_too_fine(triangles: u64, region: &Region) -> bool {
        let Rect { x0, y0, x1, y1 } = region.rect;
        u64::from(x1 - x0) * u64::from(y1 - y0) < WORTH * triangles
    }
}

impl MaskedDepth {
    /// Lets faces hide what is behind them.
    fn hide_batch(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats) {
        let mut room = std::mem::take(&mut self.room);
        let Room {
            blocks,
            quads,
            triangles,
        } = &mut room;
        blocks.clear();
        blocks.extend(faces.positions.chunks(LANES).map(block));
        stats.batches += 1;
        let mut shapes = Shapes {
            quads: &[],
            triangles: faces.corners.as_chunks().0,
            first_position: faces.first_position,
        };
        if faces.starts.is_some() {
            quads.clear();
            triangles.clear();
            faces.for_each(|_, face| fan(face, quads, triangles));
            shapes.quads = quads;
            shapes.triangles = triangles;
        }
        self.hide_shapes(faces, blocks, shapes, passage, stats);
        self.room = room;
    }

    /// Lets shapes that are otherwise as `faces` hide what is behind them: most by the kernels, and those of which these are
    /// not certain one by one.
    fn hide_shapes(
        &mut self,
        faces: &Faces,
        blocks: &[Block],
        shapes: Shapes,
        passage: &Passage,
        stats: &mut Stats,
    ) {
        let MaskedDepth {
            level,
            raster,
            batch,
            grid,
            near,
            ..
        } = self;
        let entry = passage
            .entry
            .map(|(normal, distance)| (normal, distance * BEYOND));
        let frame = Frame::new(faces.screen_from_local, *near, entry, faces.front(passage), grid);
        stats.triangles += shapes.triangles();
        dispatch!(*level, simd => batch.hide(simd, &frame, blocks, shapes, grid));
        let (uncertain, waiting) = batch.uncertain();
        if uncertain.is_empty() {
            return;
        }
        // They are of a batch that is counted already.
        let mut alone = Stats::default();
        for &number in uncertain {
            let corners = shapes.corners(number as usize);
            let at = |corner: u32| {
                let place = (corner - shapes.first_position) as usize;
                blocks[place / LANES].map(|axis| axis[place % LANES])
            };
            for last in 2..corners.len() {
                let three = [corners[0], corners[last - 1], corners[last]].map(at);
                if !three.as_flattened().iter().all(|value| value.is_finite()) {
                    continue;
                }
                let one = Faces {
                    positions: &three,
                    first_position: 0,
                    corners: &[0, 1, 2],
                    starts: None,
                    neighbours: &[],
                    ..*faces
                };
                raster.run(&one, passage, &mut OneByOne::new(grid, waiting), &mut alone);
            }
        }
        stats.triangles_hidden += alone.triangles_hidden;
        stats.samples += alone.samples;
        dispatch!(*level, simd => waiting.cover(simd, grid));
    }
}

/// A convex face as quads, and a triangle that is left.
fn fan(face: &[u32], quads: &mut Vec<[u32; 4]>, triangles: &mut Vec<[u32; 3]>) {
    let Some((&first, others)) = face.split_first() else {
        return;
    };
    let mut last = 0;
    while let Some(&[a, b, c]) = others[last..].first_chunk() {
        quads.push([first, a, b, c]);
        last += 2;
    }
    if let Some(&[a, b]) = others[last..].first_chunk() {
        triangles.push([first, a, b]);
    }
}
