//! Rasterizes instances of occluder meshes: culls the parts of all meshes of a batch, then fills the buffer in strips.
//!
//! A batch is one list of parts, whatever the number of meshes. Faces of successive parts share the queues of the
//! kernels, so a thousand meshes of a few faces fill the SIMD lanes as one large mesh does. Strips of the screen share
//! only the list. Their height depends on the list, never on the number of threads, and so does every bit of the
//! result: depths of a sub-tile may depend on where strips begin.
//! Source: sort-middle in Molnar, Cox, Ellsworth, Fuchs, A Sorting Classification of Parallel Rendering, IEEE CG&A 1994.
//! Cost: O(1) for each part out of view or hidden; otherwise, for each strip it reaches, as [`batch`](super::batch).
//! Conservative: as [`batch`](super::batch). A part is left out if what is in the buffer hides its box.

use super::batch::{Batch, Shapes, UncertainFace};
use super::mesh::{OccluderMesh, Part};
use super::project::Frame;
use super::tiles::{Grid, ROWS, Tiles, tiles};
use crate::faces::Faces;
use crate::geom::{Aabb, Transform};
use crate::simd::dispatch;
use crate::stats::Stats;
use crate::threads;
use crate::view::aperture::Rect;
use crate::view::passage::Passage;
use crate::view::region::{BOXES, EightBoxes, Volume};
use crate::view::screen_map::ScreenMap;
use fearless_simd::Level;
use fearless_simd::prelude::*;
use std::hint::black_box;

/// Minimum height of a strip, in rows of tiles.
const STRIP_ROWS: usize = 6;

/// A part that reaches into several strips is projected in each. Strips are made higher until that adds at most this
/// share of the work.
const MAX_REPEATED: f64 = 0.25;

/// Samples that take as long to fill as one face takes to project.
const SAMPLES_PER_FACE: f64 = 1024.0;

/// Number of faces after which those that went to f64 are rasterized, so that the lists stay in the cache.
const MANY: usize = 4096;

/// A mesh with its transform.
struct Instance {
    screen_from_mesh: ScreenMap,
    /// Eye position in the space of the mesh.
    eye: [f32; 3],
    mirrored: bool,
    double_sided: bool,
}

/// A part of an instance that may be in view.
struct PlacedPart<'a> {
    part: &'a Part,
    instance: u32,
    rect: Rect,
    nearest: f32,
}

/// The parts of a batch of meshes.
#[derive(Default)]
pub(super) struct DrawList<'a> {
    instances: Vec<Instance>,
    parts: Vec<PlacedPart<'a>>,
}

impl<'a> DrawList<'a> {
    /// Adds those parts of a mesh that may be in view. Nothing of a mesh with a transform that is not finite.
    pub(super) fn add(&mut self, passage: &Passage, mesh: &'a OccluderMesh, world_from_mesh: &Transform) {
        let screen_from_mesh = passage.screen_from(world_from_mesh);
        if !screen_from_mesh.linear.is_finite() {
            return;
        }
        let instance = self.instances.len() as u32;
        let before = self.parts.len();
        for parts in mesh.parts.chunks(BOXES) {
            let mut boxes = [Aabb::EMPTY; BOXES];
            for (bounds, part) in boxes.iter_mut().zip(parts) {
                *bounds = part.bounds;
            }
            let eight = EightBoxes::of(passage, &screen_from_mesh, &boxes[..parts.len()]);
            for (lane, part) in parts.iter().enumerate() {
                let (rect, nearest) = eight.rect(lane);
                let is_mapped = !screen_from_mesh.is_parallel
                    || Volume::new(&screen_from_mesh, &part.bounds).is_in_depth_range();
                if !rect.is_empty() && is_mapped {
                    self.parts.push(PlacedPart {
                        part,
                        instance,
                        rect,
                        nearest,
                    });
                }
            }
        }
        if self.parts.len() > before {
            // Front to back, then as in the mesh, where parts are in one array.
            let place = |placed: &PlacedPart| std::ptr::from_ref(placed.part);
            self.parts[before..].sort_unstable_by(|a, b| {
                b.nearest
                    .total_cmp(&a.nearest)
                    .then_with(|| place(a).cmp(&place(b)))
            });
            self.instances.push(Instance {
                eye: screen_from_mesh.eye().as_vec3().into(),
                screen_from_mesh,
                mirrored: world_from_mesh.mirrors(),
                double_sided: mesh.double_sided,
            });
        }
    }

    /// Returns an empty list that reuses the memory of this one.
    pub(super) fn emptied<'b>(self) -> DrawList<'b> {
        let DrawList {
            mut instances,
            mut parts,
        } = self;
        instances.clear();
        parts.clear();
        // Collects in place, so nothing is allocated: the lifetime is all that changes.
        let renamed = parts.into_iter().map(|placed| PlacedPart {
            part: &EMPTY,
            instance: placed.instance,
            rect: placed.rect,
            nearest: placed.nearest,
        });
        DrawList {
            instances,
            parts: renamed.collect(),
        }
    }

    /// Rasterizes the list, in strips of the screen. Returns the work done.
    pub(super) fn draw(
        &self,
        grid: &mut Grid,
        passage: &Passage,
        workers: &mut Workers,
        parallel: bool,
    ) -> Stats {
        let height = self.strip_height(grid.rows());
        let strips = grid.rows().div_ceil(height).max(1);
        let shares = if parallel {
            strips.min(2 * threads::count())
        } else {
            1
        };
        let Workers { level, workers } = workers;
        if workers.len() < shares {
            workers.resize_with(shares, || DrawWorker::at(*level));
        }
        self.share(
            grid.all(),
            &mut workers[..shares],
            [height, strips.div_ceil(shares) * height],
            passage,
        );
        let mut stats = Stats::default();
        for worker in &mut workers[..shares] {
            stats.add(&std::mem::take(&mut worker.stats));
        }
        stats
    }

    /// Returns the height of the strips, in rows of tiles, on a screen of `rows`.
    fn strip_height(&self, rows: usize) -> usize {
        let mut height = STRIP_ROWS;
        while height < rows {
            let (mut work, mut repeated) = (0.0, 0.0);
            for PlacedPart { part, rect, .. } in &self.parts {
                let Rect { x0, y0, x1, y1 } = *rect;
                let faces = part.face_count() as f64;
                let samples = f64::from(x1 - x0) * f64::from(y1 - y0) * f64::from(part.fill);
                work += faces + samples / SAMPLES_PER_FACE;
                repeated += faces * (tiles(y0, y1, height * ROWS).len() - 1) as f64;
            }
            if repeated <= MAX_REPEATED * work {
                break;
            }
            height *= 2;
        }
        height
    }

    /// Gives each worker the same number of rows of tiles, `rows`, in parallel; it goes through them in strips.
    fn share(&self, tiles: Tiles, workers: &mut [DrawWorker], [height, rows]: [usize; 2], passage: &Passage) {
        if let [worker] = workers {
            for mut strip in tiles.strips(height) {
                worker.draw(&mut strip, self, passage);
            }
            return;
        }
        let half = workers.len() / 2;
        let (upper, lower) = tiles.split(half * rows);
        let (first, second) = workers.split_at_mut(half);
        threads::join(
            true,
            || self.share(upper, first, [height, rows], passage),
            || self.share(lower, second, [height, rows], passage),
        );
    }
}

static EMPTY: Part = Part::EMPTY;

/// One worker for each thread that rasterizes.
pub(super) struct Workers {
    level: Level,
    workers: Vec<DrawWorker>,
}

impl Workers {
    /// Creates workers for a SIMD level. The level changes the speed only; the results have the same bits.
    pub(super) fn at(level: Level) -> Workers {
        Workers {
            level,
            workers: Vec::new(),
        }
    }
}

/// The kernels, and the faces that were given to them since the buffer was last up to date.
struct DrawWorker {
    batch: Batch,
    quads: Vec<[u32; 4]>,
    triangles: Vec<[u32; 3]>,
    queued: Vec<QueuedPart>,
    stats: Stats,
}

/// A part whose faces are queued.
struct QueuedPart {
    /// Index in the list.
    part: usize,
    /// Number of the first face; the quads come first.
    first: u32,
    first_quad: usize,
    first_triangle: usize,
}

impl DrawWorker {
    fn at(level: Level) -> DrawWorker {
        DrawWorker {
            batch: Batch::at(level),
            quads: Vec::new(),
            triangles: Vec::new(),
            queued: Vec::new(),
            stats: Stats::default(),
        }
    }

    /// Rasterizes the parts that reach into a strip.
    fn draw(&mut self, strip: &mut Tiles, list: &DrawList, passage: &Passage) {
        let mut last: Option<(u32, Frame)> = None;
        for (number, part) in list.parts.iter().enumerate() {
            let rect = part.rect.intersection(&strip.rect);
            if rect.is_empty() || strip.view().first_seen(&rect, part.nearest).is_none() {
                continue;
            }
            let frame = match &last {
                Some((instance, frame)) if *instance == part.instance => frame,
                _ => {
                    let faces = faces_of(&list.instances[part.instance as usize]);
                    &last.insert((part.instance, Frame::new(&faces, passage, strip))).1
                }
            };
            dispatch!(self.batch.level, simd => self.queue(simd, number, list, frame, strip));
            if self.quads.len() + self.triangles.len() > MANY {
                self.finish(strip, list, passage);
            }
        }
        self.finish(strip, list, passage);
    }

    /// Queues the front-faces of a part.
    #[inline(always)]
    fn queue<S: Simd>(&mut self, simd: S, number: usize, list: &DrawList, frame: &Frame, strip: &mut Tiles) {
        let PlacedPart { part, instance, .. } = &list.parts[number];
        let Instance {
            eye, double_sided, ..
        } = &list.instances[*instance as usize];
        let [first_quad, first_triangle] = [self.quads.len(), self.triangles.len()];
        if *double_sided {
            part.quads.keep_all(&mut self.quads);
            part.triangles.keep_all(&mut self.triangles);
        } else {
            part.quads.keep_facing(simd, *eye, &mut self.quads);
            part.triangles.keep_facing(simd, *eye, &mut self.triangles);
        }
        let shapes = Shapes {
            quads: &self.quads[first_quad..],
            triangles: &self.triangles[first_triangle..],
            first_position: 0,
        };
        if shapes.triangles() == 0 {
            return;
        }
        // Fetch all vertices first, so that the cache misses overlap.
        for axis in part.blocks.as_flattened() {
            black_box(axis[0]);
        }
        self.stats.triangles += shapes.triangles();
        let first = (first_quad + first_triangle) as u32;
        self.batch.queue(simd, frame, &part.blocks, shapes, first, strip);
        self.queued.push(QueuedPart {
            part: number,
            first,
            first_quad,
            first_triangle,
        });
    }

    /// Rasterizes everything that is queued.
    fn finish(&mut self, strip: &mut Tiles, list: &DrawList, passage: &Passage) {
        if self.queued.is_empty() {
            return;
        }
        self.stats.batches += 1;
        // Any part's will do: from here on, only the strip matters.
        let faces = Faces::of_triangles(&[], &[], &passage.screen_from_sector);
        let uncertain = self.batch.finish(&Frame::new(&faces, passage, strip), strip);
        for &number in &uncertain {
            let place = self.queued.partition_point(|queued| queued.first <= number) - 1;
            let queued = &self.queued[place];
            let end_of_quads = self
                .queued
                .get(place + 1)
                .map_or(self.quads.len(), |next| next.first_quad);
            let place = (number - queued.first) as usize;
            let quads = &self.quads[queued.first_quad..end_of_quads];
            let corners: &[u32] = match quads.get(place) {
                Some(quad) => quad,
                None => &self.triangles[queued.first_triangle + place - quads.len()],
            };
            let PlacedPart { part, instance, .. } = &list.parts[queued.part];
            let face = UncertainFace {
                faces: &faces_of(&list.instances[*instance as usize]),
                blocks: &part.blocks,
                corners,
                first_position: 0,
            };
            self.batch.hide_in_f64(&face, passage, strip, &mut self.stats);
        }
        self.batch.end(uncertain, strip);
        self.quads.clear();
        self.triangles.clear();
        self.queued.clear();
    }
}

/// Returns the properties of the faces of an instance.
fn faces_of(instance: &Instance) -> Faces<'_> {
    Faces {
        mirrored: instance.mirrored,
        double_sided: instance.double_sided,
        ..Faces::of_triangles(&[], &[], &instance.screen_from_mesh)
    }
}
