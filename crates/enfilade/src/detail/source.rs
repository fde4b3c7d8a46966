//! Where levels come from, and those of one source that were built.

use super::DetailError;
use crate::geom::Aabb;
use crate::geometry::MaterialId;
use crate::mesh::Mesh;
use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Makes the geometry of an item when it is wanted, as fine as it is wanted.
///
/// All but [`DetailSource::build`] is asked once.
pub trait DetailSource: Send + Sync {
    /// A box that holds every level, in the space of the item.
    fn bounds(&self) -> Aabb;

    /// What the volume is drawn as until there is more.
    fn material(&self) -> MaterialId;

    /// How many levels there are, from 0, the coarsest; at least 1, and of more than 64 only the first are asked for.
    fn levels(&self) -> u32;

    /// How far a level is off the true surface, and that off it, at most, in lengths of the item's space; less for finer
    /// levels, and 0 for one that is exact and may hide.
    fn error(&self, level: u32) -> f32;

    /// Makes a level.
    ///
    /// # Errors
    /// Any: the item keeps what it has, and the error is told. So it is with a panic, a mesh of no faces, and one that
    /// reaches out of the bounds.
    fn build(&self, level: u32) -> Result<Arc<Mesh>, Box<dyn Error + Send + Sync>>;
}

/// Levels that are asked for: each halving the error, they would end below the last bit of f32.
const MAX_LEVELS: u32 = 64;

/// The levels of a source that were built.
pub(super) struct Levels {
    source: Arc<dyn DetailSource>,
    pub(super) bounds: Aabb,
    /// Of each level, from the coarsest.
    errors: Vec<f32>,
    /// What an item is drawn by until a level is built.
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
        if bounds.is_empty() || !bounds.is_in_range() {
            return Err(DetailError::NoBounds);
        }
        // A level is believed to be no better than any finer one, and what is no number to be no good.
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

    /// How far a level is off; the volume may be by all its size.
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

    /// Was a level neither built nor tried in vain?
    pub(super) fn lacks(&self, level: u32) -> bool {
        !self.built.contains_key(&level) && !self.failed.contains(&level)
    }

    /// Builds a level, and gives its number of faces; or says why not, and then it is not tried again.
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

    /// The level to draw by where `wanted` may not be there: it, or the coarsest that is finer, or the finest there is.
    pub(super) fn best_for(&self, wanted: u32) -> Option<u32> {
        let enough = self.built.range(wanted..).next();
        let best = enough.or_else(|| self.built.range(..wanted).next_back());
        best.map(|(&level, _)| level)
    }

    /// What is drawn of a level; of none, the volume.
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

/// Does a box hold another, up to rounding?
fn holds(bounds: &Aabb, inner: &Aabb) -> bool {
    let slack = 1e-5 * bounds.longest_side();
    (0..3).all(|axis| {
        bounds.min[axis] - slack <= inner.min[axis] && inner.max[axis] <= bounds.max[axis] + slack
    })
}

fn words(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("without a word")
}

/// A box as a mesh. Its sides are seen from within too: the eye may stand in it.
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
