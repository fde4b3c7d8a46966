//! Rows that rasterize a scene from the positions of its survey: everything in view, and front to back those items
//! only that are not hidden yet.

use super::lens::Lens;
use super::screen::{Screen, are_visible, buffer};
use super::truth::{ErrorCounts, Truth};
use super::{Row, Workload};
use anyhow::{Result, bail};
use enfilade::{Aabb, Alpha, Geometry, ItemIndex, OccluderMesh, Scene, SectorId, Transform, View};
use std::rc::Rc;
use std::time::Instant;

/// Names of the rows.
pub(super) const NAMES: [&str; 4] = ["whole-1280", "whole-512", "asked-1280", "asked-512"];
/// Screen size of each row, and whether items are tested before they are drawn.
const ROWS: [([u32; 2], bool); 4] = [
    ([1280, 720], false),
    ([512, 256], false),
    ([1280, 720], true),
    ([512, 256], true),
];

/// Number of views.
const VIEWS: usize = 16;

/// The opaque faces of an item of a scene, in the space of its sector.
struct Part {
    sector: SectorId,
    bounds: Aabb,
    positions: Vec<[f32; 3]>,
    /// Three per triangle.
    corners: [Vec<u32>; 2],
    /// The faces that occlude from one side, and those that do from both.
    meshes: [OccluderMesh; 2],
}

/// A view, and the indices of the parts in it, the nearest first.
struct WalkView {
    lens: Lens,
    view: View,
    parts: Vec<usize>,
}

/// All views on a screen of one size.
struct Walk {
    parts: Rc<Vec<Part>>,
    looks: Vec<WalkView>,
    /// Whether parts are tested before they are drawn.
    asks: bool,
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
    let row = |(name, (size, asks)): (&'static str, ([u32; 2], bool))| {
        let mut empty = buffer();
        let look = |survey_view: &enfilade::SurveyView| {
            let view = View::new(survey_view.eye, survey_view.toward, size).expect("a valid view");
            // Against an empty buffer, boxes are tested for being in view.
            empty.begin(&view);
            let boxes: Vec<Aabb> = parts.iter().map(|part| part.bounds).collect();
            let mut visible = vec![0; boxes.len().div_ceil(64)];
            empty.test_boxes(&boxes, &mut visible);
            let in_view = are_visible(&visible, boxes.len()).enumerate();
            let is_here =
                |&(part, visible): &(usize, bool)| visible && parts[part].sector == survey_view.sector;
            let mut in_view: Vec<usize> = in_view.filter(is_here).map(|(part, _)| part).collect();
            in_view.sort_by(|&a, &b| {
                let distance = |part: usize| distance(&parts[part].bounds, survey_view.eye.map(f64::from));
                distance(a).total_cmp(&distance(b))
            });
            WalkView {
                lens: Lens::new(&view),
                view,
                parts: in_view,
            }
        };
        let looks: Vec<WalkView> = survey_views.iter().map(look).collect();
        let walk = Walk {
            parts: Rc::clone(&parts),
            looks,
            asks,
        };
        let mut row = Row::new(name, Box::new(walk));
        row.views = Some(survey_views.len() as u64);
        row
    };
    let rows = NAMES.into_iter().zip(ROWS);
    Ok(rows.filter(|(name, _)| wanted(name)).map(row).collect())
}

/// Returns the squared distance of a point from a box.
fn distance(bounds: &Aabb, from: [f64; 3]) -> f64 {
    let sides = bounds.min.iter().zip(&bounds.max).zip(from);
    sides
        .map(|((&low, &high), at)| (at - at.clamp(f64::from(low), f64::from(high))).powi(2))
        .sum()
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
        let mut corners = [Vec::new(), Vec::new()];
        for cluster in mesh.clusters() {
            let material = geometry.material_of(item, cluster);
            if material.alpha != Alpha::Opaque {
                continue;
            }
            for face in cluster.faces.clone().map(|face| mesh.face(face)) {
                for last in 2..face.len() {
                    let [a, b, c] = [face[0], face[last - 1], face[last]];
                    corners[usize::from(material.double_sided)].extend(if transform.mirrors() {
                        [c, b, a]
                    } else {
                        [a, b, c]
                    });
                }
            }
        }
        let mesh = |corners| OccluderMesh::triangles(&positions, corners).expect("triangles of a mesh");
        let [one_sided, mut two_sided] = corners.each_ref().map(|corners| mesh(corners));
        two_sided.double_sided = true;
        (!corners.iter().all(Vec::is_empty)).then(|| Part {
            sector,
            bounds: geometry.item(item).bounds,
            meshes: [one_sided, two_sided],
            positions,
            corners,
        })
    }

    /// Returns the number of triangles, double-sided ones counted once.
    fn triangles(&self) -> u64 {
        self.corners.iter().map(|corners| corners.len() as u64 / 3).sum()
    }

    /// Returns the corners of each triangle, once per side from which it occludes.
    fn faces(&self) -> impl Iterator<Item = [[f32; 3]; 3]> {
        let [one_sided, two_sided] = self.corners.each_ref().map(|corners| corners.chunks_exact(3));
        let fronts = one_sided
            .chain(two_sided.clone())
            .map(|corners| [corners[0], corners[1], corners[2]]);
        let backs = two_sided.map(|corners| [corners[2], corners[1], corners[0]]);
        fronts
            .chain(backs)
            .map(|corners| corners.map(|corner| self.positions[corner as usize]))
    }
}

impl Walk {
    /// Clears the buffer and rasterizes the parts in a view.
    fn fill(&self, look: &WalkView, screen: &mut Screen) {
        screen.cover.begin(&look.view);
        let meshes = |part: usize| {
            self.parts[part]
                .meshes
                .iter()
                .map(|mesh| (mesh, Transform::IDENTITY))
        };
        if !self.asks {
            screen
                .cover
                .draw_all(look.parts.iter().flat_map(|&part| meshes(part)));
            return;
        }
        for &part in &look.parts {
            let mut visible = [0];
            screen.cover.test_boxes(&[self.parts[part].bounds], &mut visible);
            if visible != [0] {
                screen.cover.draw_all(meshes(part));
            }
        }
    }
}

impl Workload for Walk {
    fn count(&self) -> u64 {
        let parts = self.looks.iter().flat_map(|look| &look.parts);
        parts.map(|&part| self.parts[part].triangles()).sum()
    }

    fn run(&mut self, screen: &mut Screen) -> f64 {
        let start = Instant::now();
        for look in &self.looks {
            self.fill(look, screen);
        }
        start.elapsed().as_secs_f64()
    }

    fn check(&mut self, screen: &mut Screen) -> ErrorCounts {
        let mut errors = ErrorCounts::default();
        for look in &self.looks {
            self.fill(look, screen);
            let mut truth = Truth::new(look.lens);
            let faces = look.parts.iter().flat_map(|&part| self.parts[part].faces());
            faces.for_each(|face| truth.add(&face));
            errors.add(truth.check(&screen.cover.depth()));
        }
        errors
    }
}
