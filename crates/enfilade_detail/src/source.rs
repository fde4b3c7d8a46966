//! Sources of levels, and the levels built from each.

use crate::DetailError;
use enfilade::{Aabb, MAX_COORDINATE, MaterialId, Mesh};
use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Builds the geometry of an item on demand, at the requested level of detail.
///
/// All methods but [`DetailSource::build`] are called once per source.
pub trait DetailSource: Send + Sync {
    /// Returns an AABB that contains every level, in item space.
    fn bounds(&self) -> Aabb;

    /// Returns the material of the box that is drawn until a level is built.
    fn material(&self) -> MaterialId;

    /// Returns the number of levels, at least 1. Level 0 is the coarsest. At most 64 levels are used.
    fn levels(&self) -> u32;

    /// Returns the geometric error of a level: the maximum distance from the level to the true surface and from the
    /// surface to the level, in item space. Smaller for finer levels; 0 for an exact level, which may be an occluder.
    fn error(&self, level: u32) -> f32;

    /// Builds a level.
    ///
    /// # Errors
    /// Any error: the item keeps its current level and the error is reported in
    /// [`RefineStats::failed`](crate::RefineStats::failed). A panic, a mesh without faces, and a mesh that exceeds the
    /// bounds count as errors too.
    fn build(&self, level: u32) -> Result<Arc<Mesh>, Box<dyn Error + Send + Sync>>;
}

/// Maximum number of levels: if each halves the error, further ones are below f32 precision.
const MAX_LEVELS: u32 = 64;

/// A source and the levels built from it.
pub(super) struct Levels {
    source: Arc<dyn DetailSource>,
    pub(super) bounds: Aabb,
    /// Error of each level, coarsest first.
    errors: Vec<f32>,
    /// The box that is drawn until a level is built.
    volume: Arc<Mesh>,
    built: BTreeMap<u32, Arc<Mesh>>,
    failed: BTreeSet<u32>,
}

impl Levels {
    pub(super) fn new(source: Arc<dyn DetailSource>) -> Result<Levels, DetailError> {
        let ask = || {
            let count = source.levels().clamp(1, MAX_LEVELS);
            let errors: Vec<f32> = (0..count).map(|level| source.error(level)).collect();
            (source.bounds(), source.material(), errors)
        };
        let (bounds, material, mut errors) = catch_unwind(AssertUnwindSafe(ask))
            .map_err(|panic| DetailError::Panicked(words(&*panic).to_owned()))?;
        let is_in_range = |value: &f32| value.abs() <= MAX_COORDINATE;
        if bounds.is_empty() || !bounds.min.iter().chain(&bounds.max).all(is_in_range) {
            return Err(DetailError::NoBounds);
        }
        // Makes errors monotonic: a level is assumed no better than any finer one. NaN and negative errors count as
        // infinite.
        let mut worst = 0.0;
        for error in errors.iter_mut().rev() {
            let claimed = if *error >= 0.0 { *error } else { f32::INFINITY };
            worst = claimed.max(worst);
            *error = worst;
        }
        Ok(Levels {
            source,
            bounds,
            errors,
            volume: volume(&bounds, material)?,
            built: BTreeMap::new(),
            failed: BTreeSet::new(),
        })
    }

    /// Returns the geometric error of a level; for the box, its diagonal.
    pub(super) fn error(&self, level: Option<u32>) -> f64 {
        match level {
            Some(level) => f64::from(self.errors[level as usize]),
            None => {
                let sides = self.bounds.size().map(f64::from);
                sides.iter().map(|side| side * side).sum::<f64>().sqrt()
            }
        }
    }

    pub(super) fn finest(&self) -> u32 {
        self.errors.len() as u32 - 1
    }

    /// Returns `true` if a level was neither built nor failed to build.
    pub(super) fn lacks(&self, level: u32) -> bool {
        !self.built.contains_key(&level) && !self.failed.contains(&level)
    }

    /// Builds a level and returns its number of faces, or the reason of the failure. A failed level is not tried again.
    pub(super) fn build(&mut self, level: u32) -> Result<u64, String> {
        let made = match catch_unwind(AssertUnwindSafe(|| self.source.build(level))) {
            Ok(Ok(mesh)) if mesh.face_count() == 0 => Err("it made a mesh of no faces".to_owned()),
            Ok(Ok(mesh)) if !holds(&self.bounds, &mesh.bounds()) => {
                Err("it made a mesh that reaches out of its bounds".to_owned())
            }
            Ok(Ok(mesh)) => Ok(mesh),
            Ok(Err(why)) => Err(why.to_string()),
            Err(panic) => Err(format!("it panicked: {}", words(&*panic))),
        };
        match made {
            Ok(mesh) => {
                let faces = u64::from(mesh.face_count());
                self.built.insert(level, mesh);
                Ok(faces)
            }
            Err(why) => {
                self.failed.insert(level);
                Err(format!("level {level}: {why}"))
            }
        }
    }

    /// Returns the best built level for `wanted`: itself, else the coarsest finer one, else the finest.
    pub(super) fn best_for(&self, wanted: u32) -> Option<u32> {
        let enough = self.built.range(wanted..).next();
        let best = enough.or_else(|| self.built.range(..wanted).next_back());
        best.map(|(&level, _)| level)
    }

    /// Returns the mesh of a level; for `None`, the box.
    pub(super) fn mesh(&self, level: Option<u32>) -> &Arc<Mesh> {
        let built = level.and_then(|level| self.built.get(&level));
        built.unwrap_or(&self.volume)
    }

    pub(super) fn is_exact(&self, level: Option<u32>) -> bool {
        level.is_some() && self.error(level) == 0.0
    }

    pub(super) fn bytes_of(&self, level: u32) -> u64 {
        self.built.get(&level).map_or(0, |mesh| mesh.bytes())
    }

    pub(super) fn bytes(&self) -> u64 {
        self.built.values().map(|mesh| mesh.bytes()).sum()
    }

    pub(super) fn keep(&mut self, wanted: impl Fn(u32) -> bool) {
        self.built.retain(|&level, _| wanted(level));
    }
}

/// Returns `true` if a box contains another, up to rounding.
fn holds(bounds: &Aabb, inner: &Aabb) -> bool {
    let slack = 1e-5 * bounds.longest_side();
    (0..3).all(|axis| {
        bounds.min[axis] - slack <= inner.min[axis] && inner.max[axis] <= bounds.max[axis] + slack
    })
}

fn words(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message")
}

/// Returns a box as a mesh. It has back faces too, as the eye may be inside.
fn volume(bounds: &Aabb, material: MaterialId) -> Result<Arc<Mesh>, DetailError> {
    const SIDES: [[u32; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let triangles: Vec<u32> = SIDES
        .iter()
        .flat_map(|&[a, b, c, d]| [a, b, c, a, c, d, c, b, a, d, c, a])
        .collect();
    let mesh = Mesh::triangles(&bounds.corners(), &triangles, material);
    mesh.map(Arc::new).map_err(|_| DetailError::NoBounds)
}
