//! Rows that rasterise all of a scene that is in view, from the places of its survey.

use super::ceilings::Ceiling;
use super::lens::Lens;
use super::screen::{Screen, passage};
use super::truth::{Held, Truth};
use super::{Found, Row, SUB_TILE_BYTES, Work};
use anyhow::{Result, bail};
use enfilade::cover::Hides;
use enfilade::{Aabb, Alpha, Geometry, ItemId, OccluderMesh, Passage, Scene, SectorId, Stats, View};
use std::rc::Rc;
use std::time::Instant;

/// What the rows are called, after the scene that the figures of others are known of.
pub(super) const NAMES: [&str; 2] = ["sponza-1280", "sponza-512"];
/// Their screens, and the milliseconds a view that the best other culler takes in that scene.
const SCREENS: [([u32; 2], f64); 2] = [([1280, 720], 0.565), ([512, 256], 0.243)];

/// Places to look from.
const VIEWS: usize = 16;

/// What hides of an item, in the space of its sector.
struct Part {
    sector: SectorId,
    bounds: Aabb,
    positions: Vec<[f32; 3]>,
    /// Three for each triangle; one with two sides is there twice, once for each.
    corners: Vec<u32>,
    mesh: OccluderMesh,
    /// Those with two sides counted once.
    triangles: u64,
}

/// A view, and which parts are in it.
struct Look {
    lens: Lens,
    passage: Passage,
    parts: Vec<usize>,
}

/// All views on a screen of one size.
struct Walk {
    parts: Rc<Vec<Part>>,
    looks: Vec<Look>,
}

/// The rows of a scene.
///
/// # Errors
/// A scene in which there is nowhere to stand.
pub(super) fn rows(scene: &Scene, wanted: impl Fn(&str) -> bool) -> Result<Vec<Row>> {
    let places = enfilade::survey(scene, VIEWS).views;
    if places.is_empty() {
        bail!(
            "the survey finds no open space to stand in; `bench --micro` without a scene leaves its rows out"
        );
    }
    let mut parts = Vec::new();
    for sector in scene.sectors() {
        if let Some(geometry) = scene.geometry(sector) {
            let items = (0..geometry.items().len() as u32).map(ItemId);
            parts.extend(items.filter_map(|item| Part::new(sector, geometry, item)));
        }
    }
    let parts = Rc::new(parts);
    let row = |(name, (size, best_ms)): (&'static str, ([u32; 2], f64))| {
        let look = |place: &enfilade::SurveyView| {
            let view = View::new(place.eye, place.toward, size);
            let passage = passage(&view)?;
            let in_view = |part: &Part| part.sector == place.sector && passage.may_show(&part.bounds);
            let in_view = (0..parts.len()).filter(|&part| in_view(&parts[part])).collect();
            Ok(Look {
                lens: Lens::new(&view),
                passage,
                parts: in_view,
            })
        };
        let looks = places.iter().map(look).collect::<Result<Vec<Look>>>()?;
        let walk = Walk {
            parts: Rc::clone(&parts),
            looks,
        };
        let millions = walk.count() as f64 / places.len() as f64 / 1e6;
        let mut row = Row::new(name, millions / (best_ms * 1e-3), Box::new(walk));
        row.views = Some(places.len() as u64);
        Ok(row)
    };
    let rows = NAMES.into_iter().zip(SCREENS);
    rows.filter(|(name, _)| wanted(name)).map(row).collect()
}

impl Part {
    /// `None` of an item that hides nothing.
    fn new(sector: SectorId, geometry: &Geometry, item: ItemId) -> Option<Part> {
        if !geometry.holds(item) || !geometry.item(item).is_occluder {
            return None;
        }
        let mesh = geometry.mesh_of(item);
        let place = geometry.item(item).transform();
        let positions: Vec<[f32; 3]> = mesh
            .positions()
            .iter()
            .map(|&position| place.point(position))
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
                    if material.double_sided || !place.mirrors() {
                        corners.extend([a, b, c]);
                    }
                    if material.double_sided || place.mirrors() {
                        corners.extend([c, b, a]);
                    }
                }
            }
        }
        (triangles > 0).then(|| Part {
            sector,
            bounds: geometry.item(item).bounds,
            mesh: OccluderMesh::triangles(&positions, &corners),
            positions,
            corners,
            triangles,
        })
    }

    /// The corners of each triangle.
    fn faces(&self) -> impl Iterator<Item = [[f32; 3]; 3]> {
        let corners = self.corners.chunks_exact(3);
        corners.map(|corners| [0, 1, 2].map(|corner| self.positions[corners[corner] as usize]))
    }
}

impl Walk {
    /// Empties the cover and lets in all that a look sees.
    fn fill(&self, look: &Look, screen: &mut Screen) {
        let mut stats = Stats::default();
        screen.cover.clear(&look.passage);
        for &part in &look.parts {
            screen
                .cover
                .hide_mesh(&self.parts[part].mesh, &look.passage, &mut stats);
        }
    }
}

impl Work for Walk {
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

    fn hold(&mut self, screen: &mut Screen) -> Found {
        let (mut held, mut sub_tiles) = (Held::default(), 0);
        for look in &self.looks {
            self.fill(look, screen);
            let mut truth = Truth::new(look.lens);
            let faces = look.parts.iter().flat_map(|&part| self.parts[part].faces());
            sub_tiles += faces.map(|face| truth.add(&face)).sum::<u64>();
            held.add(truth.hold(|x, y| screen.cover.rev_depth_at(x, y)));
        }
        Found {
            held,
            least_bytes: sub_tiles * SUB_TILE_BYTES,
            ceiling: Ceiling::L2,
        }
    }
}
