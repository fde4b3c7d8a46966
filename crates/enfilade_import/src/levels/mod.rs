//! Levels of detail of a mesh, made by `meshopt` when they are wanted.
//!
//! Each level halves the error of the one before, down to a quarter of the mean edge; the last is the mesh itself. `meshopt`
//! takes vertices away as long as quadrics say that little changes; what comes of it is measured, and made again finer
//! where it is off by more than the level says.
//! Source: Garland, Heckbert. Surface simplification using quadric error metrics. SIGGRAPH 1997; meshoptimizer by Kapoulkine.
//! Cost: O(faces log faces) for each level, and to measure it O(faces) questions for the nearest; nothing before it is wanted.
//! No point of either surface is farther from the other than the level's error; only the mesh itself hides.

mod measure;
mod welded;

use enfilade::{Aabb, DetailError, DetailOptions, DetailSource, Details, MaterialId, Mesh, Part, Scene};
use glam::DVec3;
use measure::within;
use meshopt::{SimplifyOptions, simplify_with_locks_decoder};
use std::collections::HashMap;
use std::error::Error;
use std::sync::Arc;
use welded::{Welded, triangles};

/// The levels of a mesh.
#[derive(Clone, Debug)]
pub struct Levels {
    mesh: Arc<Mesh>,
    errors: Vec<f32>,
}

/// Levels with an error, at most.
const MAX_LEVELS: i32 = 10;

/// How often a level is made again with half the error asked of `meshopt`, before the mesh itself stands in for it. Mostly
/// once or twice: what it leaves is off by twice to four times what it says.
const ATTEMPTS: i32 = 8;

impl Levels {
    /// The levels of a mesh, none of them made yet.
    pub fn of(mesh: Arc<Mesh>) -> Levels {
        let size = DVec3::from(mesh.bounds().size().map(f64::from)).length();
        // Nothing is saved where less than an edge is taken away.
        let least = 0.25 * mean_edge(&mesh);
        let mut errors: Vec<f32> = (0..MAX_LEVELS)
            .map(|level| size / 16.0 * 0.5_f64.powi(level))
            .take_while(|&error| error > least)
            .map(|error| error as f32)
            .collect();
        errors.push(0.0);
        Levels { mesh, errors }
    }

    /// The mesh with as little as `meshopt` leaves for such an error, which it does not quite keep to.
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
                positions: &welded.positions,
                corners,
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

/// Gives levels to all items of a scene that have at least so many triangles; items that are copies of one mesh share them.
///
/// # Errors
/// As [`Details::adopt`].
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
        for number in (0..geometry.items().len() as u32).map(enfilade::ItemId) {
            let mesh = &geometry.meshes()[geometry.item(number).mesh.0 as usize];
            if mesh.face_count() > 0 && mesh.triangle_count() >= least_triangles {
                let address = Arc::as_ptr(mesh).addr();
                let source = known
                    .entry(address)
                    .or_insert_with(|| Arc::new(Levels::of(Arc::clone(mesh))));
                large.push((sector, number, Arc::clone(source)));
            }
        }
    }
    let mut details = Details::new(options);
    details.adopt(scene, large)?;
    Ok(details)
}

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
