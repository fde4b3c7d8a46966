//! Rasterizes batches of faces and occluder meshes into tiles, with the buffers that one thread needs.
//!
//! Source: original to this library.
//! Cost: as [`super::batch`], plus O(tiles) for each face that the kernels are not certain of.
//! Conservative: as [`super::batch`] and [`super::faces`].

use super::batch::{Batch, Block, Frame, LANES, Shapes};
use super::faces::RunSink;
use super::grid::Tiles;
use super::mesh::{Part, block};
use crate::faces::Faces;
use crate::passage::Passage;
use crate::raster::Raster;
use crate::region::Region;
use crate::stats::Stats;
use fearless_simd::{Level, dispatch};

/// Buffers of one rasterizing thread.
pub(super) struct Worker {
    level: Level,
    raster: Raster,
    batch: Batch,
    blocks: Vec<Block>,
    /// Quads and triangles of polygons with more corners, and the front-facing ones of a mesh part.
    quads: Vec<[u32; 4]>,
    triangles: Vec<[u32; 3]>,
}

impl Worker {
    /// Creates a worker for a SIMD level. The level changes the speed only; the results have the same bits.
    pub(super) fn at(level: Level) -> Worker {
        Worker {
            level,
            raster: Raster::at(level),
            batch: Batch::default(),
            blocks: Vec::new(),
            quads: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// Rasterizes a batch of faces as occluders.
    pub(super) fn hide_batch(
        &mut self,
        tiles: &mut Tiles,
        faces: &Faces,
        passage: &Passage,
        stats: &mut Stats,
    ) {
        let Worker {
            level,
            raster,
            batch,
            blocks,
            quads,
            triangles,
        } = self;
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
        FaceRasterizer {
            level: *level,
            raster,
            batch,
            faces,
            passage,
        }
        .hide(tiles, blocks, shapes, stats);
    }

    /// Rasterizes those parts of a mesh, given in the space of the passage's sector, that overlap the tiles.
    pub(super) fn hide_parts(
        &mut self,
        tiles: &mut Tiles,
        parts: &[Part],
        passage: &Passage,
        stats: &mut Stats,
    ) {
        let Worker {
            level,
            raster,
            batch,
            quads,
            triangles,
            ..
        } = self;
        let mut rasterizer = FaceRasterizer {
            level: *level,
            raster,
            batch,
            faces: &Faces::of_triangles(&[], &[], &passage.screen_from_sector),
            passage,
        };
        let eye = passage.eye().map(|at| at as f32);
        for part in parts {
            let region = Region::of(passage, &passage.screen_from_sector, &part.bounds);
            if region.is_none_or(|region| region.rect.intersection(&tiles.rect).is_empty()) {
                continue;
            }
            dispatch!(rasterizer.level, simd => part.quads.keep_facing(simd, eye, quads));
            dispatch!(rasterizer.level, simd => part.triangles.keep_facing(simd, eye, triangles));
            let shapes = Shapes {
                quads,
                triangles,
                first_position: 0,
            };
            if shapes.triangles() > 0 {
                rasterizer.hide(tiles, &part.blocks, shapes, stats);
            }
        }
    }
}

/// Rasterizes quads and triangles, with the f64 fallback.
struct FaceRasterizer<'a> {
    level: Level,
    raster: &'a mut Raster,
    batch: &'a mut Batch,
    /// Properties of the faces, except their corners.
    faces: &'a Faces<'a>,
    passage: &'a Passage,
}

impl FaceRasterizer<'_> {
    /// Rasterizes with the kernels, then those faces one by one in f64 that the kernels are not certain of.
    fn hide(&mut self, tiles: &mut Tiles, blocks: &[Block], shapes: Shapes, stats: &mut Stats) {
        let FaceRasterizer {
            level,
            ref mut raster,
            ref mut batch,
            faces,
            passage,
        } = *self;
        let frame = Frame::new(faces, passage, tiles);
        stats.triangles += shapes.triangles();
        dispatch!(level, simd => batch.hide(simd, &frame, blocks, shapes, tiles));
        let (uncertain, run_queue) = batch.uncertain();
        if uncertain.is_empty() {
            return;
        }
        // Separate counters, because the batch and its triangles are already counted.
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
                raster.run(&one, passage, &mut RunSink::new(tiles, run_queue), &mut alone);
            }
        }
        stats.triangles_hidden += alone.triangles_hidden;
        stats.samples += alone.samples;
        dispatch!(level, simd => run_queue.cover(simd, tiles));
    }
}

/// Splits a convex polygon into quads and, if one remains, a triangle.
fn fan(face: &[u32], quads: &mut Vec<[u32; 4]>, triangles: &mut Vec<[u32; 3]>) {
    let Some((&first, mut others)) = face.split_first() else {
        return;
    };
    while let Some(&[a, b, c]) = others.first_chunk() {
        quads.push([first, a, b, c]);
        others = &others[2..];
    }
    if let &[a, b] = others {
        triangles.push([first, a, b]);
    }
}
