//! Generates the LODs of a mesh with `meshopt`, on demand.
//!
//! Each level has half the error of the one before, down to a quarter of the mean edge length; the last level is the
//! mesh itself. `meshopt` removes vertices as long as the quadric error stays small. The true error of the result is
//! then measured; if it exceeds the level's error, the level is generated again with a smaller target.
//! Source: Garland, Heckbert. Surface simplification using quadric error metrics. SIGGRAPH 1997; meshoptimizer by
//! Kapoulkine.
//! Cost: O(faces log faces) for each level, plus O(faces) nearest-triangle queries to measure it; nothing before a
//! level is built.
//! The Hausdorff distance between a level and the mesh is at most the level's error. Only the mesh itself is an
//! occluder.

mod measure;
mod welded;

use enfilade::{Aabb, Indices, MaterialId, Mesh, Part, Scene, Vertices};
use enfilade_detail::{DetailError, DetailOptions, DetailSource, Details};
use glam::DVec3;
use measure::within;
use meshopt::{SimplifyOptions, simplify_with_locks_decoder};
use std::collections::HashMap;
use std::error::Error;
use std::sync::Arc;
use welded::{Welded, triangles};

/// The LODs of a mesh; implements [`DetailSource`].
#[derive(Clone, Debug)]
pub struct Levels {
    mesh: Arc<Mesh>,
    errors: Vec<f32>,
}

/// Maximum number of levels with an error above 0.
const MAX_LEVELS: i32 = 10;

/// Maximum number of attempts per level, each with half the target error of the one before; after that, the mesh itself
/// is used. Usually one or two suffice: the true error of a result is two to four times what `meshopt` reports.
const ATTEMPTS: i32 = 8;

impl Levels {
    /// Creates the levels of a mesh; none is built yet.
    pub fn of(mesh: Arc<Mesh>) -> Levels {
        let size = DVec3::from(mesh.bounds().size().map(f64::from)).length();
        // Levels whose error is a fraction of an edge would save nothing.
        let least = 0.25 * mean_edge(&mesh);
        let mut errors: Vec<f32> = (0..MAX_LEVELS)
            .map(|level| size / 16.0 * 0.5_f64.powi(level))
            .take_while(|&error| error > least)
            .map(|error| error as f32)
            .collect();
        errors.push(0.0);
        Levels { mesh, errors }
    }

    /// Simplifies the mesh to the target error `error`, which `meshopt` may exceed.
    fn simplified(&self, welded: &Welded, error: f32) -> Result<Mesh, Box<dyn Error + Send + Sync>> {
        let options = SimplifyOptions::ErrorAbsolute | SimplifyOptions::Sparse;
        let left: Vec<(MaterialId, Vec<u32>)> = welded
            .parts
            .iter()
            .map(|(&material, corners)| {
                let locks = &welded.shared[..];
                let left =
                    simplify_with_locks_decoder(corners, &welded.positions, locks, 0, error, options, None);
                (material, left)
            })
            .collect();
        let parts: Vec<Part> = left
            .iter()
            .map(|(material, corners)| Part {
                positions: Vertices::Packed(&welded.positions),
                corners: Indices::U32(corners),
                sides: None,
                material: *material,
                attributes: welded.attributes(),
            })
            .collect();
        Ok(Mesh::new(&parts)?)
    }
}

impl DetailSource for Levels {
    fn bounds(&self) -> Aabb {
        self.mesh.bounds()
    }

    fn material(&self) -> MaterialId {
        self.mesh
            .clusters()
            .first()
            .map_or(MaterialId(0), |cluster| cluster.material)
    }

    fn levels(&self) -> u32 {
        self.errors.len() as u32
    }

    fn error(&self, level: u32) -> f32 {
        self.errors[level as usize]
    }

    fn build(&self, level: u32) -> Result<Arc<Mesh>, Box<dyn Error + Send + Sync>> {
        let error = self.errors[level as usize];
        if error > 0.0 {
            let welded = Welded::new(&self.mesh);
            for attempt in 0..ATTEMPTS {
                let mesh = self.simplified(&welded, error * 0.5_f32.powi(attempt))?;
                let off = f64::from(error);
                if mesh.face_count() > 0 && within(&self.mesh, &mesh, off) && within(&mesh, &self.mesh, off) {
                    return Ok(Arc::new(mesh));
                }
            }
        }
        Ok(Arc::clone(&self.mesh))
    }
}

/// Attaches LODs to all items of a scene with at least `least_triangles` triangles; items that share a mesh share its
/// LODs.
///
/// # Errors
/// The same as [`Details::adopt`].
pub fn details_of(
    scene: &mut Scene,
    least_triangles: u64,
    options: DetailOptions,
) -> Result<Details, DetailError> {
    let mut known: HashMap<usize, Arc<dyn DetailSource>> = HashMap::new();
    let mut large = Vec::new();
    for sector in scene.sectors() {
        let Some(geometry) = scene.geometry(sector) else {
            continue;
        };
        for number in (0..geometry.items().len() as u32).map(enfilade::ItemIndex) {
            let mesh = &geometry.meshes()[geometry.item(number).mesh.0 as usize];
            if mesh.face_count() > 0 && mesh.triangle_count() >= least_triangles {
                let address = Arc::as_ptr(mesh).addr();
                let source = known
                    .entry(address)
                    .or_insert_with(|| Arc::new(Levels::of(Arc::clone(mesh))));
                large.push((sector, geometry.id_of(number), Arc::clone(source)));
            }
        }
    }
    let mut details = Details::new(options);
    details.adopt(scene, large)?;
    Ok(details)
}

/// Returns the mean edge length of all triangles; 0 for a mesh without faces.
fn mean_edge(mesh: &Mesh) -> f64 {
    let at = |index: u32| DVec3::from(mesh.positions()[index as usize].map(f64::from));
    let (mut sum, mut count) = (0.0, 0.0);
    for face in 0..mesh.face_count() {
        for [a, b, c] in triangles(mesh.face(face)) {
            sum += at(a).distance(at(b)) + at(b).distance(at(c)) + at(c).distance(at(a));
            count += 3.0;
        }
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests;
