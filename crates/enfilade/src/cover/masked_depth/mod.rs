//! Masked occlusion buffer: a low-memory depth buffer for occlusion queries with SIMD rasterization.
//!
//! The screen is split into tiles of 32×16 samples and sub-tiles of 8×4. A sub-tile stores the reversed depth of a
//! reference layer and of a working layer, and a coverage mask of the samples in the working layer: 16 bytes instead of
//! the 128 of a depth buffer, and one comparison tests all 32 samples. The buffer holds no picture. The caller first
//! rasterizes selected occluders, then tests boxes; visible faces found by a traversal are rasterized too and hide
//! geometry found later.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016; the result does not
//!     depend on the number of sub-tiles that a kernel processes at once. Beyond the paper: the second test by a box's
//!     outline and front faces, and testing faces against the tiles as boxes are tested. Skipping faces that are small
//!     on the screen: Boreskov, Hierarchical s-buffer for scenes of high complexity.
//! Cost: clear O(tiles of the aperture); an occluder or a face O(tiles it overlaps); a box O(tiles of its rectangle) if
//!     it is hidden, less if it is clearly visible.
//! Conservative: stored depths are never nearer than the true ones, a box is never tested farther than it is, and equal
//!     depths count as visible.

mod batch;
mod draw;
mod mesh;
mod occluder;
mod occlusion_buffer;
mod project;
mod query;
mod resolve;
mod runs;
mod setup;
mod small;
mod sort;
#[cfg(test)]
mod tests;
mod tiles;
mod wide;

use super::{Coarse, Cover, FineNode, Hides};
use crate::contract::Contract;
use crate::faces::{FaceSource, Faces};
use crate::occluders::{Occluder, OccluderMeasure};
use crate::order::Unsorted;
use crate::raster::{Band, Triangle};
use crate::simd::{dispatch, level};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::canvas::{Canvas, CoverShape};
use crate::view::options::Tightness;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use batch::Worker;
use fearless_simd::Level;
pub use mesh::{OccluderMesh, OccluderMeshError};
use occluder::{Fill, Slope};
pub use occlusion_buffer::OcclusionBuffer;
pub use resolve::ItemTest;
use resolve::Resolver;
use tiles::{COLUMNS, Grid, ROWS, Tile, TileMasks};

/// SIMD lanes of a kernel, at every level, and their indices.
const LANES: usize = 16;
const COUNT: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Minimum number of samples in a box per face in it for its faces to be rasterized as occluders. With fewer, setting
/// them up costs more than they hide.
const WORTH: u64 = 4;

/// The same for a node of a mesh to be visited in parts. With fewer, it is visible or hidden as a whole and occludes
/// nothing: its parts would have to be tested too.
const WORTH_PARTS: u64 = 16;

/// Returns `true` if a region has at least `worth` samples for each of a number of faces.
fn is_worth(worth: u64, faces: u64, region: &Region) -> bool {
    let Rect { x0, y0, x1, y1 } = region.rect;
    u64::from(x1 - x0) * u64::from(y1 - y0) >= worth * faces
}

/// The cover of [`Method::Masked`](crate::Method::Masked). Engines without a scene use the same buffer as an
/// [`OcclusionBuffer`](crate::OcclusionBuffer).
pub struct MaskedDepth {
    level: Level,
    fill: Fill,
    worker: Worker,
    grid: Grid,
    near: f64,
    /// How far tested boxes grow, in pixels.
    growth: f64,
    resolver: Resolver,
}

impl Default for MaskedDepth {
    fn default() -> MaskedDepth {
        MaskedDepth::at(level())
    }
}

impl MaskedDepth {
    /// Creates a buffer for a SIMD level. The level changes the speed only; the results have the same bits.
    fn at(level: Level) -> MaskedDepth {
        MaskedDepth {
            level,
            fill: Fill::at(level),
            worker: Worker::at(level),
            grid: Grid::default(),
            near: 0.0,
            growth: 0.0,
            resolver: Resolver::at(level),
        }
    }
}

impl Cover for MaskedDepth {
    type Needs = Unsorted;

    const NAME: &'static str = "MaskedDepth";

    fn test(&mut self, region: &Region) -> Visibility {
        let seen = dispatch!(self.level, simd => self.grid.sees(simd, region, self.near, self.growth));
        if seen {
            Visibility::Partial
        } else {
            Visibility::Hidden
        }
    }

    fn needs_bytes(size: [u32; 2]) -> u64 {
        let tiles = u64::from(size[0].div_ceil(COLUMNS as u32)) * u64::from(size[1].div_ceil(ROWS as u32));
        let grid = size_of::<Tile>() + size_of::<f32>() + size_of::<TileMasks>();
        tiles * (grid + Resolver::BYTES_PER_TILE) as u64
    }

    const SHAPE: Option<CoverShape> = Some(CoverShape::Tiles);

    fn show(&mut self, passage: &Passage, canvas: &mut dyn Canvas) {
        self.grid.show(passage, canvas);
    }
}

impl Hides for MaskedDepth {
    const CONTRACT: Contract = Contract::Conservative;
    const MEASURE: OccluderMeasure = OccluderMeasure::ProjectedArea;
    // Visible faces, found front to back, hide as much, and occluder selection takes longer than rasterizing them.
    const OCCLUDERS: u32 = 0;

    fn clear(&mut self, passage: &Passage) {
        self.grid.clear(passage);
        self.near = f64::from(passage.z_near);
        self.growth = passage.options.growth();
        self.resolver.clear();
    }

    fn hide(&mut self, occluder: &Occluder, passage: &Passage, stats: &mut Stats) {
        stats.samples += self.fill.hide(&mut self.grid, occluder, passage);
    }

    const TAKES_FACES: bool = true;

    fn hide_faces(&mut self, faces: &Faces, region: &Region, passage: &Passage, stats: &mut Stats) {
        if is_worth(WORTH, faces.count() as u64, region) {
            if let FaceSource::Item(item, cluster) = faces.source
                && passage.options.tightness == Tightness::Resolved
            {
                self.resolver.note_occluders(item, &[cluster], region);
            }
            self.worker
                .hide_batch(&mut self.grid.all(), faces, passage, stats);
        }
    }

    fn note_fine(&mut self, node: &FineNode, region: &Region, passage: &Passage) {
        if passage.options.tightness == Tightness::Resolved && is_worth(WORTH, node.triangles, region) {
            self.resolver.note_occluders(node.item, node.clusters, region);
        }
    }

    fn item_test(&mut self) -> Option<ItemTest<'_>> {
        Some(ItemTest::new(&self.grid, &mut self.resolver))
    }

    fn are_too_fine(triangles: u64, region: &Region) -> bool {
        !is_worth(WORTH_PARTS, triangles, region)
    }
}

impl Coarse for MaskedDepth {
    fn clear_cells(&mut self, passage: &Passage) {
        self.clear(passage);
    }

    fn sees_cells(&mut self, rect: &Rect, nearest: f32) -> bool {
        let rect = rect.intersection(&self.grid.rect);
        !rect.is_empty() && self.grid.view().first_seen(&rect, nearest).is_some()
    }

    fn sees_plane(&mut self, cells: &Band, rev_depth: &Triangle) -> bool {
        self.grid.sees_plane(cells, rev_depth)
    }

    fn cover_cells(&mut self, cells: &Band, rev_depth: &Triangle) {
        let slope = Slope::of(rev_depth, &self.grid.rect);
        self.grid.cover(cells, &slope);
    }
}
