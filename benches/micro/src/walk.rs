//! Rows that rasterize everything in view of a scene, from the positions of its survey.

use super::ceilings::Ceiling;
use super::lens::Lens;
use super::screen::{Screen, are_visible, buffer};
use super::truth::{ErrorCounts, Truth};
use super::{Row, SUB_TILE_BYTES, Verification, Workload};
use anyhow::{Result, bail};
use enfilade::{Aabb, Alpha, Geometry, ItemIndex, OccluderMesh, Scene, SectorId, Transform, View};
use std::rc::Rc;
use std::time::Instant;

/// Names of the rows, after the scene of the figures of other cullers.
pub(super) const NAMES: [&str; 2] = ["sponza-1280", "sponza-512"];
/// Screen sizes of the rows, and the milliseconds per view of the best other culler in that scene.
const SCREENS: [([u32; 2], f64); 2] = [([1280, 720], 0.565), ([512, 256], 0.243)];

/// Number of views.
const VIEWS: usize = 16;

/// The opaque faces of an occluder item, in the space of its sector.
struct Part {
    sector: SectorId,
    bounds: Aabb,
    positions: Vec<[f32; 3]>,
    /// Three per triangle; a double-sided one is stored twice, once per side.
    corners: Vec<u32>,
    mesh: OccluderMesh,
    /// Number of triangles, double-sided ones counted once.
    triangles: u64,
}

/// A view, and the indices of the parts in it.
struct WalkView {
    lens: Lens,
    view: View,
    parts: Vec<usize>,
}

/// All views on a screen of one size.
struct Walk {
    parts: Rc<Vec<Part>>,
    looks: Vec<WalkView>,
}

/// Returns the rows of a scene.
///
/// # Errors
/// Fails if the survey finds no position to stand at.
pub(super) fn rows(scene: &Scene, wanted: impl Fn(&str) -> bool) -> Result<Vec<Row>> {
    let survey_views = enfilade::survey(scene, VIEWS).views;
    if survey_views.is_empty() {
        bail!("the survey found no open space; run without a scene to omit its rows");
    }
    let mut parts = Vec::new();
    for sector in scene.sectors() {
        if let Some(geometry) = scene.geometry(sector) {
            let items = (0..geometry.items().len() as u32).map(ItemIndex);
            parts.extend(items.filter_map(|item| Part::new(sector, geometry, item)));
        }
    }
    let parts = Rc::new(parts);
    let row = |(name, (size, best_ms)): (&'static str, ([u32; 2], f64))| {
        let mut empty = buffer();
        let look = |survey_view: &enfilade::SurveyView| {
            let view = View::new(survey_view.eye, survey_view.toward, size).expect("a valid view");
            // Against an empty buffer, boxes are tested for being in view.
            empty.begin(&view);
            let boxes: Vec<Aabb> = parts.iter().map(|part| part.bounds).collect();
            let mut visible = vec![0; boxes.len().div_ceil(64)];
            empty.test_boxes(&boxes, &mut visible);
            let in_view = are_visible(&visible, boxes.len()).enumerate();
            let is_here = |&(part, visible): &(usize, bool)| visible && parts[part].sector == survey_view.sector;
            WalkView {
                lens: Lens::new(&view),
                view,
                parts: in_view.filter(is_here).map(|(part, _)| part).collect(),
            }
        };
        let looks: Vec<WalkView> = survey_views.iter().map(look).collect();
        let walk = Walk {
            parts: Rc::clone(&parts),
            looks,
        };
        let millions = walk.count() as f64 / survey_views.len() as f64 / 1e6;
        let mut row = Row::new(name, millions / (best_ms * 1e-3), Box::new(walk));
        row.views = Some(survey_views.len() as u64);
        row
    };
    let rows = NAMES.into_iter().zip(SCREENS);
    Ok(rows.filter(|(name, _)| wanted(name)).map(row).collect())
}

impl Part {
    /// Returns `None` for an item that occludes nothing.
    fn new(sector: SectorId, geometry: &Geometry, item: ItemIndex) -> Option<Part> {
        if !geometry.holds(item) || !geometry.item(item).options.is_occluder {
            return None;
        }
        let mesh = geometry.mesh_of(item);
        let transform = geometry.item(item).transform();
        let positions: Vec<[f32; 3]> = mesh
            .positions()
            .iter()
            .map(|&position| transform.point(position))
            .collect();
        let (mut corners, mut triangles) = (Vec::new(), 0);
        for cluster in mesh.clusters() {
            let material = geometry.material_of(item, cluster);
            if material.alpha != Alpha::Opaque {
                continue;
            }
            for face in cluster.faces.clone().map(|face| mesh.face(face)) {
                for last in 2..face.len() {
                    let [a, b, c] = [face[0], face[last - 1], face[last]];
                    triangles += 1;
                    if material.double_sided || !transform.mirrors() {
                        corners.extend([a, b, c]);
                    }
                    if material.double_sided || transform.mirrors() {
                        corners.extend([c, b, a]);
                    }
                }
            }
        }
        (triangles > 0).then(|| Part {
            sector,
            bounds: geometry.item(item).bounds,
            mesh: OccluderMesh::triangles(&positions, &corners).expect("triangles of a mesh"),
            positions,
            corners,
            triangles,
        })
    }

    /// Returns the corners of each triangle.
    fn faces(&self) -> impl Iterator<Item = [[f32; 3]; 3]> {
        let corners = self.corners.chunks_exact(3);
        corners.map(|corners| [0, 1, 2].map(|corner| self.positions[corners[corner] as usize]))
    }
}

impl Walk {
    /// Clears the buffer and rasterizes everything in a view.
    fn fill(&self, look: &WalkView, screen: &mut Screen) {
        screen.cover.begin(&look.view);
        let meshes = look.parts.iter().map(|&part| (&self.parts[part].mesh, Transform::IDENTITY));
        screen.cover.draw_all(meshes);
    }
}

impl Workload for Walk {
    fn count(&self) -> u64 {
        let parts = self.looks.iter().flat_map(|look| &look.parts);
        parts.map(|&part| self.parts[part].triangles).sum()
    }

    fn run(&mut self, screen: &mut Screen) -> f64 {
        let start = Instant::now();
        for look in &self.looks {
            self.fill(look, screen);
        }
        start.elapsed().as_secs_f64()
    }

    fn check(&mut self, screen: &mut Screen) -> Verification {
        let (mut errors, mut sub_tiles) = (ErrorCounts::default(), 0);
        for look in &self.looks {
            self.fill(look, screen);
            let mut truth = Truth::new(look.lens);
            let faces = look.parts.iter().flat_map(|&part| self.parts[part].faces());
            sub_tiles += faces.map(|face| truth.add(&face)).sum::<u64>();
            errors.add(truth.check(&screen.cover.depth()));
        }
        Verification {
            errors,
            min_bytes: sub_tiles * SUB_TILE_BYTES,
            ceiling: Ceiling::L2,
        }
    }
}
