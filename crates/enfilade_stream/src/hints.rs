//! Prefetch hints, by sampling: eyes where people could stand, looks in all directions, until further eyes see nothing new.
//!
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, for loading what is visible.
//! Cost: a position takes six exact looks, once the pages around it are loaded. Memory: the boxes of all items, and pages within
//!     the budget.

use crate::{Pager, PagerOptions, Pages};
use enfilade::{
    Aabb, Camera, Geometry, GeometryBuilder, GeometryError, Item, ItemIndex, Method, Scene, SceneBuilder,
    SceneError, SectorId, View, ViewError, Viewers, VisibleSet, survey,
};
use enfilade_import::{Hint, ImportError, ReadOptions};
use std::collections::{BTreeSet, HashMap};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;

/// How hints are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct HintOptions {
    /// Maximum number of positions in a region of a room.
    pub positions: u32,
    /// Width and height of the looks, in pixels. What is smaller than a pixel may be missed.
    pub size: u32,
    /// Memory for meshes, in bytes. All that is visible from a position must fit.
    pub bytes: u64,
}

impl Default for HintOptions {
    /// 128 positions, looks of 512 pixels, 4 GB.
    fn default() -> HintOptions {
        HintOptions {
            positions: 128,
            size: 512,
            bytes: 4_000_000_000,
        }
    }
}

/// Why hints cannot be sampled.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum HintError {
    /// The file cannot be read.
    #[error(transparent)]
    Unreadable(#[from] ImportError),
    /// The scene cannot be built.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Places cannot be looked for.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// Looks of this size are not possible.
    #[error(transparent)]
    View(#[from] ViewError),
    /// A page cannot be read.
    #[error("{0}")]
    Page(String),
    /// What is visible from a position does not fit into memory.
    #[error("what is visible at once takes more than {0} bytes of memory; allow more (--memory)")]
    Memory(u64),
}

/// How good hints are for views from further positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct HintCheck {
    /// Number of views.
    pub views: u32,
    /// Number of views of whose visible items at least 95 % are hinted.
    pub covered: u32,
    /// Visible items, each once per view, and how many of them are hinted.
    pub visible: u64,
    /// See `visible`.
    pub hinted: u64,
    /// Number of items seen from the region, by sampling and by these views.
    pub seen: u64,
}

/// Samples what is seen from the regions of the rooms of a baked scene.
///
/// A region is a room, or, where its meshes take more than 32 MB, one of the halves of a half, and so on, of its box.
pub struct HintSampler {
    options: HintOptions,
    pages: Arc<Pages>,
    /// Of each room, with boxes as meshes.
    geometries: Vec<Arc<Geometry>>,
    scene: Scene,
    pager: Pager,
    viewers: Viewers,
    regions: Vec<Region>,
}

/// A room, or a piece of it.
#[derive(Clone, Copy)]
struct Region {
    sector: SectorId,
    bounds: Aabb,
}

/// Size of the meshes of a region above which it is halved, in bytes.
const REGION_BYTES: u64 = 32 << 20;
/// Sampling ends once so many positions in a row see nothing new.
const IN_A_ROW: usize = 16;

impl HintSampler {
    /// Opens a baked scene.
    ///
    /// # Errors
    /// Returns a [`HintError`] if the file is no baked scene, or is damaged.
    pub fn open(path: &Path, options: HintOptions) -> Result<HintSampler, HintError> {
        let read = ReadOptions {
            textures: false,
            limit_bytes: u64::MAX,
            ..ReadOptions::default()
        };
        let (import, pages) = Pages::open(path, &read)?;
        let pages = Arc::new(pages);
        let scene = import.scene(Method::HierarchicalZ, u64::MAX)?;
        let mut regions = Vec::new();
        for (room, sector) in import.rooms.iter().zip((0..).map(SectorId)) {
            let geometry = &room.geometry;
            let placed = |item: &Item| {
                let bytes = pages.mesh_bytes(pages.mesh_of(sector.0 as usize, item.mesh));
                (item.bounds.center(), bytes)
            };
            let items = geometry.items().iter().filter(|item| !item.bounds.is_empty());
            split(
                sector,
                geometry.bounds(),
                items.map(placed).collect(),
                &mut regions,
            );
        }
        let of_pager = PagerOptions {
            bytes: options.bytes,
            pages_per_step: 16,
            levels: false,
            ..PagerOptions::default()
        };
        let geometries = import.rooms.iter().map(|room| Arc::clone(&room.geometry));
        let geometries = geometries.collect();
        let mut pager = Pager::new(import, Arc::clone(&pages), of_pager);
        // Those that the file has already would only load more.
        pager.hints.clear();
        Ok(HintSampler {
            options,
            geometries,
            pager,
            pages,
            scene,
            viewers: Viewers::new(),
            regions,
        })
    }

    /// Returns the number of regions of rooms.
    pub fn region_count(&self) -> usize {
        self.regions.len()
    }

    /// Samples what is seen from a region. The result depends on the scene alone; it has no items if no position was found.
    ///
    /// # Errors
    /// Returns a [`HintError`] if a page is damaged, or what is visible does not fit into memory.
    ///
    /// # Panics
    /// If there is no such region.
    pub fn sample(&mut self, region: usize) -> Result<Hint, HintError> {
        let Region { sector, bounds } = self.regions[region];
        // The number of positions that see each item.
        let mut seen_from: HashMap<(SectorId, ItemIndex), u32> = HashMap::new();
        let positions = self.positions(region, self.options.positions)?;
        for eyes in positions.chunks(IN_A_ROW) {
            let known = seen_from.len();
            for &eye in eyes {
                let views = around(eye, sector, self.options.size)?;
                for item in self.look(&views)? {
                    *seen_from.entry(item).or_default() += 1;
                }
            }
            if seen_from.len() == known {
                break;
            }
        }
        let mut items: Vec<_> = seen_from.into_iter().collect();
        items.sort_unstable_by_key(|&(item, positions)| (u32::MAX - positions, item));
        Ok(Hint {
            sector,
            bounds,
            items: items.into_iter().map(|(item, _)| item).collect(),
        })
    }

    /// Compares hints of a region with views from further positions, in all directions, of 1280 by 720 pixels.
    ///
    /// # Errors
    /// As [`HintSampler::sample`].
    ///
    /// # Panics
    /// If there is no such region.
    pub fn check(&mut self, region: usize, hint: &Hint, views: u32) -> Result<HintCheck, HintError> {
        const GOLDEN_ANGLE: f32 = 2.399_963;
        let Region { sector, .. } = self.regions[region];
        let hinted: BTreeSet<_> = hint.items.iter().collect();
        let mut check = HintCheck::default();
        let mut all = hinted.clone().into_iter().copied().collect::<BTreeSet<_>>();
        let eyes = self.positions(region, self.options.positions + views)?;
        let further = eyes.into_iter().rev().take(views as usize);
        for (number, eye) in further.enumerate() {
            let angle = GOLDEN_ANGLE * number as f32;
            let [ahead, aside] = [angle.cos(), angle.sin()].map(f64::from);
            let eye = eye.map(f64::from);
            let toward = [eye[0] + ahead, eye[1], eye[2] + aside];
            let view = Camera::new(eye, toward).view([1280, 720])?.in_sector(sector);
            let seen = self.look(&[view])?;
            let known = seen.iter().filter(|item| hinted.contains(item)).count();
            check.views += 1;
            check.covered += u32::from(known as f64 >= 0.95 * seen.len() as f64);
            check.visible += seen.len() as u64;
            check.hinted += known as u64;
            all.extend(seen);
        }
        check.seen = all.len() as u64;
        Ok(check)
    }

    /// Returns up to `count` positions in a region where people could stand.
    fn positions(&self, region: usize, count: u32) -> Result<Vec<[f32; 3]>, HintError> {
        let Region { sector, bounds } = self.regions[region];
        let geometry = &self.geometries[sector.0 as usize];
        let mut near = Vec::new();
        geometry.items_in_box(&bounds, |index| near.push(geometry.item(index)));
        let mesh_of = |item: &Item| self.pages.mesh_of(sector.0 as usize, item.mesh);
        let pages: BTreeSet<u32> = near
            .iter()
            .map(|item| self.pages.page_of(mesh_of(item)))
            .collect();
        let mut builder = GeometryBuilder::new(geometry.materials());
        let mut meshes = HashMap::new();
        for page in pages {
            for (mesh, read) in self.pages.load(page)? {
                meshes.insert(mesh, builder.mesh(read));
            }
        }
        for item in near {
            builder.item("", meshes[&mesh_of(item)], item.transform());
        }
        let mut scene = SceneBuilder::new();
        scene.add("", builder.build()?, Method::ZBuffer);
        let scene = scene.build()?;
        let is_in_part =
            |eye: [f32; 3], toward| bounds.contains(eye) && self.scene.locate(eye, toward) == Some(sector);
        let found = survey(&scene, count as usize).views;
        let in_part = found.iter().filter(|view| is_in_part(view.eye, view.toward));
        Ok(in_part.map(|view| view.eye).collect())
    }

    /// Loads what is visible in some views, and returns the visible items.
    fn look(&mut self, views: &[View]) -> Result<BTreeSet<(SectorId, ItemIndex)>, HintError> {
        loop {
            let sets = self.viewers.look_many(&self.scene, views);
            let seen: Vec<&VisibleSet> = sets.iter().collect();
            let stats = self.pager.step(&mut self.scene, &seen)?;
            if let Some((_, why)) = stats.failed.into_iter().next() {
                return Err(HintError::Page(why));
            }
            if stats.absent == 0 && stats.loaded == 0 {
                return Ok(sets.iter().flat_map(items).collect());
            }
            if stats.loading == 0 && stats.loaded == 0 {
                return Err(HintError::Memory(self.options.bytes));
            }
            self.pager.wait(Duration::from_secs(60));
        }
    }
}

fn items(set: &VisibleSet) -> impl Iterator<Item = (SectorId, ItemIndex)> {
    let seen = set.items().iter();
    seen.map(|item| (set.passage(item.passage).sector, item.item.index))
}

/// Returns the views of a cube map.
fn around(eye: [f32; 3], sector: SectorId, size: u32) -> Result<Vec<View>, ViewError> {
    let directions = (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]);
    directions
        .map(|(axis, sign)| {
            // In f64, because in f32 a step may vanish far from the origin.
            let eye = eye.map(f64::from);
            let mut toward = eye;
            toward[axis] += sign;
            let camera = Camera {
                sector: Some(sector),
                fov_y: std::f32::consts::FRAC_PI_2,
                ..Camera::new(eye, toward)
            };
            camera.view([size; 2])
        })
        .collect()
}

/// Halves a region along its longest side until its meshes are few. `items` are the centre and the bytes of each.
fn split(sector: SectorId, bounds: Aabb, items: Vec<([f32; 3], u64)>, regions: &mut Vec<Region>) {
    let bytes: u64 = items.iter().map(|(_, bytes)| bytes).sum();
    let size = bounds.size();
    let axis = (1..3).fold(
        0,
        |longest, axis| if size[axis] > size[longest] { axis } else { longest },
    );
    let middle = bounds.center()[axis];
    let [mut lower, mut upper] = [bounds; 2];
    (lower.max[axis], upper.min[axis]) = (middle, middle);
    let is_divisible = bounds.min[axis] < middle && middle < bounds.max[axis];
    if items.is_empty() {
        return;
    }
    if bytes <= REGION_BYTES || items.len() == 1 || !is_divisible {
        regions.push(Region { sector, bounds });
        return;
    }
    let (below, above) = items.into_iter().partition(|(center, _)| center[axis] < middle);
    split(sector, lower, below, regions);
    split(sector, upper, above, regions);
}
