//! Where levels come from, and those of one source that were built.

use crate::content::MaterialId;
use crate::geom::Aabb;
use crate::mesh::Mesh;
use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Makes the geometry of an item when it is wanted, as fine as it is wanted.
pub trait DetailSource: Send + Sync {
    /// A box that holds every level, in the space of the item. Its sides must be finite and not empty.
    fn bounds(&self) -> Aabb;

    /// What the volume is drawn as until there is more.
    fn material(&self) -> MaterialId;

    /// How many levels there are, from 0, the coarsest; at least 1.
    fn levels(&self) -> u32;

    /// How far a level is off the true surface, at most, in lengths of the item's space; less for finer levels, and 0 for
    /// one that is exact.
    fn error(&self, level: u32) -> f32;

    /// Makes a level.
    ///
    /// # Errors
    /// Any: the item keeps what it has, and the error is told. So it is with a panic.
    fn build(&self, level: u32) -> Result<Mesh, Box<dyn Error + Send + Sync>>;
}

/// The levels of a source that were built.
pub(super) struct Levels {
    pub(super) source: Arc<dyn DetailSource>,
    /// What an item is drawn by until a level is built.
    pub(super) volume: Arc<Mesh>,
    built: BTreeMap<u32, Arc<Mesh>>,
    failed: BTreeSet<u32>,
}

impl Levels {
    pub(super) fn new(source: Arc<dyn DetailSource>) -> Levels {
        Levels {
            volume: volume(&source.bounds(), source.material()),
            source,
            built: BTreeMap::new(),
            failed: BTreeSet::new(),
        }
    }

    /// Builds a level unless it is there, and gives its number of faces. What failed once is not tried again, and told
    /// once.
    pub(super) fn build(&mut self, level: u32) -> Result<Option<u64>, Option<String>> {
        if self.built.contains_key(&level) {
            return Ok(None);
        }
        if self.failed.contains(&level) {
            return Err(None);
        }
        let made = catch_unwind(AssertUnwindSafe(|| self.source.build(level)));
        let mesh = match made {
            Ok(Ok(mesh)) if mesh.face_count() == 0 => Err("it made a mesh of no faces".to_owned()),
            Ok(Ok(mesh)) if !holds(&self.source.bounds(), &mesh.bounds()) => {
                Err("it made a mesh that reaches out of its bounds".to_owned())
            }
            Ok(Ok(mesh)) => Ok(mesh),
            Ok(Err(why)) => Err(why.to_string()),
            Err(panic) => Err(format!("it panicked: {}", words(&*panic))),
        };
        match mesh {
            Ok(mesh) => {
                let faces = u64::from(mesh.face_count());
                self.built.insert(level, Arc::new(mesh));
                Ok(Some(faces))
            }
            Err(why) => {
                self.failed.insert(level);
                Err(Some(format!("level {level}: {why}")))
            }
        }
    }

    pub(super) fn has_failed(&self, level: u32) -> bool {
        self.failed.contains(&level)
    }

    /// The level to draw by where `wanted` may not be there: it, or the coarsest that is finer, or the finest there is;
    /// never a coarser one than `now`, as long as that is coarser than it should be.
    pub(super) fn best_for(&self, wanted: u32, now: Option<u32>) -> Option<u32> {
        let enough = self.built.range(wanted..).next();
        let best = enough.or_else(|| self.built.range(..wanted).next_back());
        best.map(|(&level, _)| level).max(now.filter(|&now| now < wanted))
    }

    /// What is drawn of a level; of none, the volume.
    pub(super) fn mesh(&self, level: Option<u32>) -> Arc<Mesh> {
        let built = level.and_then(|level| self.built.get(&level));
        Arc::clone(built.unwrap_or(&self.volume))
    }

    pub(super) fn is_exact(&self, level: Option<u32>) -> bool {
        level.is_some_and(|level| self.source.error(level) == 0.0)
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

fn words(panic: &dyn std::any::Any) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("without a word")
}

/// A box as a mesh.
fn volume(bounds: &Aabb, material: MaterialId) -> Arc<Mesh> {
    const SIDES: [[u32; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let corners = bounds.corners();
    let triangles: Vec<u32> = SIDES
        .iter()
        .flat_map(|&[a, b, c, d]| [a, b, c, a, c, d])
        .collect();
    // What is not finite is refused where it is put into the scene: it has no faces.
    Arc::new(Mesh::triangles(&corners, &triangles, material).unwrap_or_else(|_| Mesh::nothing()))
}
