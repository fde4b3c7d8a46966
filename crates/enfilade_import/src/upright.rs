//! Finds the up axis and the unit of a scene from its floors, for files that do not tell them.

use enfilade::{Cluster, Geometry, ItemIndex, Mesh, Ray, Scene, SectorId, SurveyOptions, Transform};
use enfilade_bake::{FaceAreas, Up, metres_per_unit_of};
use glam::DVec3;
use rayon::prelude::*;

/// Returns the options of a survey that stands on the floors of a scene whose format does not tell its up axis
/// ([`Import::tells_up`](crate::Import::tells_up)): the axis that floors face, and the unit if rooms show that it is not a metre.
pub fn survey_options(scene: &Scene) -> SurveyOptions {
    let up = detect_scene_up(scene).unwrap_or(Up::Y);
    let unit = detect_scene_unit(scene, up).filter(|&unit| unit != 1.0);
    let mut options = SurveyOptions::default();
    options.up = match up {
        Up::X => [1.0, 0.0, 0.0],
        Up::Y => [0.0, 1.0, 0.0],
        Up::Z => [0.0, 0.0, 1.0],
    };
    options.metre = unit.map(f64::recip);
    options
}

/// Returns the axis that the floors of a scene face; `None` where that is not clear.
///
/// OBJ files do not tell it. [`read`](crate::read) keeps their coordinates, so this is for programs that place cameras, such
/// as with [`enfilade::SurveyOptions`]. Cost: O(faces of large clusters), a small part of reading a file. The same for any
/// number of threads.
pub fn detect_scene_up(scene: &Scene) -> Option<Up> {
    let bounds = scene.sectors().map(|sector| scene.bounds(sector));
    let bounds = bounds
        .filter(|bounds| !bounds.is_empty())
        .reduce(|a, b| a.union(&b))?;
    let none = FaceAreas::new([bounds.min, bounds.max].map(|corner| corner.map(f64::from)));
    let mut all = none.clone();
    for geometry in scene.sectors().filter_map(|sector| scene.geometry(sector)) {
        let items: Vec<ItemIndex> = (0..geometry.items().len() as u32).map(ItemIndex).collect();
        let areas_of = |items: &[ItemIndex]| {
            let mut sampler = Sampler {
                areas: none.clone(),
                small_side: SMALL * f64::from(bounds.longest_side()),
                small_clusters: 0,
            };
            items.iter().for_each(|&item| sampler.add_item(geometry, item));
            sampler.areas
        };
        // Parts of one size, added in order, so that sums do not depend on the number of threads.
        let parts: Vec<FaceAreas> = items.par_chunks(ITEMS_PER_PART).map(areas_of).collect();
        parts.iter().for_each(|part| all.merge(part));
    }
    all.up()
}

/// Items whose faces one thread adds up.
const ITEMS_PER_PART: usize = 64;
/// Longest side of a small cluster, relative to the scene. All small faces together matter, but none of them alone.
const SMALL: f64 = 0.02;
/// One of so many small clusters is added, for all of them.
const SAMPLED: u32 = 8;

/// Adds up the faces of items: all of large clusters, and a sample of small ones, which have most of the faces.
struct Sampler {
    areas: FaceAreas,
    small_side: f64,
    small_clusters: u32,
}

impl Sampler {
    fn add_item(&mut self, geometry: &Geometry, item: ItemIndex) {
        if !geometry.holds(item) {
            return;
        }
        let mesh = geometry.mesh_of(item);
        let scene_from_item = geometry.item(item).transform();
        let small_side = self.small_side / scene_from_item.scale();
        for cluster in mesh.clusters() {
            let count = if f64::from(cluster.bounds.longest_side()) < small_side {
                self.small_clusters += 1;
                SAMPLED
            } else {
                1
            };
            if count == 1 || self.small_clusters % SAMPLED == 1 {
                self.add_cluster(mesh, cluster, &scene_from_item, count);
            }
        }
    }

    fn add_cluster(&mut self, mesh: &Mesh, cluster: &Cluster, scene_from_item: &Transform, count: u32) {
        let [x, y, z, origin] = scene_from_item.columns_f64().map(DVec3::from);
        let place = |index: u32| -> [f64; 3] {
            let [a, b, c] = mesh.positions()[index as usize].map(f64::from);
            (x * a + y * b + z * c + origin).into()
        };
        for face in cluster.faces.clone() {
            let corners = mesh.face(face);
            for pair in corners[1..].windows(2) {
                let triangle = [corners[0], pair[0], pair[1]].map(place);
                self.areas.add_sample(triangle, count);
            }
        }
    }
}

/// Returns the metres per scene unit: 1 if rooms are as high as rooms are, else that of the usual unit for which they are.
/// `None` if there are no rooms with a floor and a ceiling.
///
/// Samples the heights of rooms with up to 3,500 rays along the up axis.
pub fn detect_scene_unit(scene: &Scene, up: Up) -> Option<f64> {
    let mut heights: Vec<f64> = scene
        .sectors()
        .filter(|&sector| scene.geometry(sector).is_some())
        .flat_map(|sector| free_heights(scene, sector, up))
        .collect();
    heights.sort_by(f64::total_cmp);
    // By volume, because hollow slabs have as much area as rooms.
    let half = 0.5 * heights.iter().sum::<f64>();
    let mut below = 0.0;
    let median = heights.into_iter().find(|height| {
        below += height;
        below >= half
    })?;
    Some(metres_per_unit_of(median))
}

/// Returns the heights of the free space between the faces of a sector, along lines on a grid.
fn free_heights(scene: &Scene, sector: SectorId, up: Up) -> Vec<f64> {
    /// Lines along each side of the grid.
    const LINES: usize = 12;
    /// Faces per line.
    const MOST: usize = 24;
    /// Smallest height that counts, relative to the longest extent.
    const MIN_HEIGHT: f32 = 0.008;
    let bounds = scene.bounds(sector);
    let up = match up {
        Up::X => 0,
        Up::Y => 1,
        Up::Z => 2,
    };
    let [a, b] = [(up + 1) % 3, (up + 2) % 3];
    let mut heights = Vec::new();
    if bounds.is_empty() {
        return heights;
    }
    let least = MIN_HEIGHT * bounds.longest_side();
    let mut direction = [0.0; 3];
    direction[up] = 1.0;
    for line in 0..LINES * LINES {
        // Off the middles, where walls and ridges of symmetric buildings are.
        let at = |step: usize, axis: usize| {
            let share = (step as f32 + 0.37) / LINES as f32;
            bounds.min[axis] + share * (bounds.max[axis] - bounds.min[axis])
        };
        let mut origin = [0.0; 3];
        (origin[a], origin[b]) = (at(line % LINES, a), at(line / LINES, b));
        origin[up] = bounds.min[up] - least;
        let mut last = None;
        for _ in 0..MOST {
            let Some(hit) = scene.sector(sector).cast(&Ray { origin, direction }) else {
                break;
            };
            let height = origin[up] + hit.distance as f32;
            heights.extend(
                last.map(|last| f64::from(height - last))
                    .filter(|&free| free > f64::from(least)),
            );
            last = Some(height);
            origin[up] = (height + 0.01 * least).max(height.next_up());
        }
    }
    heights
}
