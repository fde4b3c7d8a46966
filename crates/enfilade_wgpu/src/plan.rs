//! What is drawn of a visible set, in which order: one render pass, depth first through the passages.
//!
//! The stencil holds the number of openings between the eye and what is drawn at a pixel, its level. A passage at level n
//! 1. draws its opaque items where the stencil is n,
//! 2. draws its openings into the depth buffer,
//! 3. for each opening in turn: raises the stencil to n + 1 where the opening is the nearest, paints sky there and sets the
//!    depth to infinitely far, draws the passage behind it at level n + 1, then lowers the stencil again and restores the
//!    opening's depth,
//! 4. draws its alpha-blended items, back to front.
//!
//! So a passage is restricted to exactly the pixels of its openings, however they overlap, and glass is in front of what
//! is behind the openings.

use crate::lens::{Lens, matrix};
use crate::materials::Materials;
use crate::meshes::Meshes;
use crate::openings;
use crate::pipelines::{ItemKind, Sides};
use bytemuck::{Pod, Zeroable};
use enfilade::{
    Alpha, DrawRun, Geometry, Material, Passage, PassageId, Scene, Transform, View, VisibleItem, VisibleSet,
};
use enfilade_draw::{DirectLight, Exposure, PassageLighting, Stage};
use glam::{DVec3, DVec4};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use wgpu::{Device, Queue};

/// Number of openings in a row that the stencil can count. Passages behind more are drawn as closed openings.
pub(crate) const MAX_LEVEL: u32 = 255;
/// Texels before the planes of a light.
const LIGHT_TEXELS: usize = 6;
/// Distance of an eye that counts as in the plane of an opening, relative to the size of the opening.
const NEARLY: f64 = 1e-5;
/// Columns of the texture of lights.
pub(crate) const LIGHT_COLUMNS: usize = 256;

/// The map of an item to eye space, by rows.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Instance {
    rows: [[f32; 4]; 3],
}

pub(crate) const INSTANCE_ATTRIBUTES: [wgpu::VertexAttribute; 3] =
    wgpu::vertex_attr_array![4 => Float32x4, 5 => Float32x4, 6 => Float32x4];

/// A passage in the shader's layout. The fields are documented there.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct PassageBits {
    clip_from_eye: [[f32; 4]; 4],
    sector: [[f32; 4]; 3],
    entry: [f32; 4],
    back: [f32; 4],
    above: [f32; 4],
    below: [f32; 4],
    sun: [f32; 4],
    to_sun: [f32; 4],
    ahead: [f32; 4],
    /// Offsets of uniforms are multiples of 256 bytes.
    unused: [f32; 8],
}

/// A range of triangles of items that differ only in their transforms.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ItemDraw {
    pub(crate) kind: ItemKind,
    pub(crate) material: u32,
    pub(crate) page: u32,
    pub(crate) indices: [u32; 2],
    pub(crate) instances: [u32; 2],
}

/// What is done with an opening.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum OpeningStep {
    /// Its depth is drawn, as of a face.
    Depth,
    /// It is drawn as a face, because its portal is not followed.
    Closed,
    /// The stencil is raised where it is the nearest.
    Raise,
    /// Sky is painted and the depth set to infinitely far, one level up.
    Clear,
    /// The stencil is lowered from one level up, and the opening's depth restored.
    Lower,
}

/// A command of the render pass.
#[derive(Clone, Debug)]
pub(crate) enum Step {
    /// What follows belongs to a passage, by its index in [`Plan::passages`].
    Passage {
        number: u32,
        scissor: [u32; 4],
        level: u32,
    },
    /// Draws items at the level of the passage.
    Items(ItemDraw),
    /// Draws triangles of [`Plan::triangles`].
    Opening(OpeningStep, Range<u32>),
}

/// All that is uploaded and recorded for one picture.
#[derive(Default)]
pub(crate) struct Plan {
    pub(crate) instances: Vec<Instance>,
    pub(crate) passages: Vec<PassageBits>,
    /// Texels of the lights.
    pub(crate) lights: Vec<[f32; 4]>,
    /// Corners of openings, three each, in clip space.
    pub(crate) triangles: Vec<[f32; 4]>,
    pub(crate) steps: Vec<Step>,
    /// Whether all visible passages are drawn.
    pub(crate) complete: bool,
    /// Whether the projection mirrors.
    mirrored: bool,
    runs: Vec<DrawRun>,
    sorted: Vec<VisibleItem>,
    opaque: Vec<ItemDraw>,
    /// Bind groups of materials, by the geometry's address, the material, and whether the mesh has texture coordinates.
    known: HashMap<(usize, u32, bool), (u32, Material)>,
    /// For each passage its first child and its next sibling.
    children: Vec<[Option<u32>; 2]>,
    glass: Vec<VisibleItem>,
}

/// What a picture is made of.
#[derive(Clone, Copy)]
pub(crate) struct Subject<'a> {
    pub(crate) stage: &'a Stage,
    pub(crate) scene: &'a Scene,
    pub(crate) view: &'a View,
    pub(crate) visible: &'a VisibleSet,
    pub(crate) exposure: Exposure,
}

/// Where meshes and materials are uploaded.
pub(crate) struct Store<'a> {
    pub(crate) device: &'a Device,
    pub(crate) queue: &'a Queue,
    pub(crate) meshes: &'a mut Meshes,
    pub(crate) materials: &'a mut Materials,
}

impl Plan {
    /// Plans a picture.
    pub(crate) fn make(&mut self, of: Subject, store: &mut Store) {
        self.instances.clear();
        self.passages.clear();
        self.lights.clear();
        self.triangles.clear();
        self.steps.clear();
        self.known.clear();
        self.complete = true;
        let passages = of.visible.passages();
        let lens = Lens::new(of.scene, of.view, of.visible);
        self.mirrored = lens.mirrors;
        self.list_children(passages);
        self.glass.clear();
        if of.visible.items().iter().any(|item| item.blends) {
            self.glass = of.visible.blend_order(of.scene);
        }
        let roots: Vec<u32> = (0..)
            .zip(passages)
            .filter(|(_, p)| p.parent.is_none())
            .map(|(n, _)| n)
            .collect();
        if let [root] = roots[..] {
            self.add_passages(of, &lens, store, root, 0);
            return;
        }
        // Rays of a parallel view start in several sectors, each within its own part of the screen.
        for (order, &root) in roots.iter().enumerate() {
            let passage = &passages[root as usize];
            let start = self.triangles.len() as u32;
            // Different depths, so that no pixel belongs to two.
            let depth = 1.0 - order as f64 / f64::from(1 << 20);
            openings::add_aperture(&passage.aperture, passage.size, depth, &mut self.triangles);
            let part = start..self.triangles.len() as u32;
            self.enter(of, &lens, passage, 0, passage.scissor());
            self.steps.push(Step::Opening(OpeningStep::Depth, part.clone()));
            self.steps.push(Step::Opening(OpeningStep::Raise, part.clone()));
            self.steps.push(Step::Opening(OpeningStep::Clear, part.clone()));
            self.add_passages(of, &lens, store, root, 1);
            self.enter(of, &lens, passage, 0, passage.scissor());
            self.steps.push(Step::Opening(OpeningStep::Lower, part));
        }
    }

    fn list_children(&mut self, passages: &[Passage]) {
        self.children.clear();
        self.children.resize(passages.len(), [None, None]);
        // From the last, so that siblings are in order.
        for (number, passage) in passages.iter().enumerate().rev() {
            if let Some(parent) = passage.parent {
                let next = self.children[parent.0 as usize][0].replace(number as u32);
                self.children[number][1] = next;
            }
        }
    }

    /// Adds a passage and all behind it, without recursion: chains may be long.
    fn add_passages(&mut self, of: Subject, lens: &Lens, store: &mut Store, root: u32, level: u32) {
        /// A passage whose children are being drawn.
        struct Entered {
            passage: u32,
            number: u32,
            level: u32,
            /// The next child, and the triangles of the children's openings in order.
            next: Option<u32>,
            openings: std::vec::IntoIter<Range<u32>>,
            last: Option<Range<u32>>,
        }
        let passages = of.visible.passages();
        let mut pending = vec![];
        let mut begin = Some((root, level));
        loop {
            if let Some((passage, level)) = begin.take() {
                let of_passage = &passages[passage as usize];
                let number = self.enter(of, lens, of_passage, level, of_passage.scissor());
                self.add_opaque(of, store, PassageId(passage));
                let openings = self.add_openings(of, lens, passage, level);
                pending.push(Entered {
                    passage,
                    number,
                    level,
                    next: self.children[passage as usize][0].filter(|_| level < MAX_LEVEL),
                    openings: openings.into_iter(),
                    last: None,
                });
            }
            let Some(entered) = pending.last_mut() else { break };
            let scissor = passages[entered.passage as usize].scissor();
            let back = Step::Passage {
                number: entered.number,
                scissor,
                level: entered.level,
            };
            if let Some(last) = entered.last.take() {
                self.steps.push(back.clone());
                self.steps.push(Step::Opening(OpeningStep::Lower, last));
            }
            match entered.next {
                Some(child) => {
                    let opening = entered.openings.next().unwrap_or_default();
                    entered.next = self.children[child as usize][1];
                    entered.last = Some(opening.clone());
                    let level = entered.level + 1;
                    // Openings are in the space of this passage, but only the child's part of the screen is needed.
                    self.steps.push(Step::Passage {
                        number: entered.number,
                        scissor: passages[child as usize].scissor(),
                        level: entered.level,
                    });
                    self.steps
                        .push(Step::Opening(OpeningStep::Raise, opening.clone()));
                    self.steps.push(Step::Opening(OpeningStep::Clear, opening));
                    begin = Some((child, level));
                }
                None => {
                    let passage = PassageId(entered.passage);
                    if self.glass.iter().any(|item| item.passage == passage) {
                        self.steps.push(back);
                        self.add_glass(of, store, passage);
                    }
                    pending.pop();
                }
            }
        }
    }

    /// Begins a passage. Returns its index in [`Plan::passages`].
    fn enter(&mut self, of: Subject, lens: &Lens, passage: &Passage, level: u32, scissor: [u32; 4]) -> u32 {
        let number = self.passages.len() as u32;
        let lighting = of.stage.lighting(of.scene, of.view, passage, of.exposure);
        let first = self.lights.len();
        for light in &lighting.lights {
            add_light(light, &mut self.lights);
        }
        self.passages
            .push(PassageBits::new(lens, passage, &lighting, first));
        self.steps.push(Step::Passage {
            number,
            scissor,
            level,
        });
        number
    }

    fn add_opaque(&mut self, of: Subject, store: &mut Store, id: PassageId) {
        let passage = of.visible.passage(id);
        let Some(geometry) = of.scene.geometry(passage.sector) else {
            return;
        };
        let mut sorted = std::mem::take(&mut self.sorted);
        for (mesh, items) in of.visible.instances(id, geometry, &mut sorted) {
            let mesh = &geometry.meshes()[mesh.0 as usize];
            let own = store
                .meshes
                .get(store.device, store.queue, mesh)
                .mesh_from_vertices;
            let is_whole = |item: &VisibleItem| {
                let clusters = of.visible.clusters(item).len();
                clusters == 0 || clusters == mesh.clusters().len()
            };
            // Instances of small meshes are drawn at once, even if one shows a cluster that another hides.
            if items.len() > 1 && (mesh.clusters().len() <= 4 || items.iter().all(is_whole)) {
                for mirrored in [false, true] {
                    let start = self.instances.len() as u32;
                    for item in items {
                        let transform = geometry.item(item.item.index).transform();
                        if (self.mirrored != (passage.mirrored() != transform.mirrors())) == mirrored {
                            self.instances.push(Instance::new(passage, transform * own));
                        }
                    }
                    self.runs.clear();
                    whole(mesh, &mut self.runs);
                    let instances = [start, self.instances.len() as u32];
                    self.add_runs(
                        (of, store),
                        (geometry, mesh),
                        (passage, mirrored),
                        instances,
                        false,
                    );
                }
                continue;
            }
            for item in items {
                let transform = geometry.item(item.item.index).transform();
                let start = self.instances.len() as u32;
                self.instances.push(Instance::new(passage, transform * own));
                of.visible.draw_runs(item, mesh, &mut self.runs);
                let mirrored = self.mirrored != (passage.mirrored() != transform.mirrors());
                self.add_runs(
                    (of, store),
                    (geometry, mesh),
                    (passage, mirrored),
                    [start, start + 1],
                    false,
                );
            }
        }
        self.sorted = sorted;
        self.opaque.sort_unstable();
        self.steps.extend(self.opaque.drain(..).map(Step::Items));
    }

    /// Adds the blended items of a passage, back to front.
    fn add_glass(&mut self, of: Subject, store: &mut Store, id: PassageId) {
        let passage = of.visible.passage(id);
        let Some(geometry) = of.scene.geometry(passage.sector) else {
            return;
        };
        let glass = std::mem::take(&mut self.glass);
        for item in glass.iter().filter(|item| item.passage == id) {
            let index = item.item.index;
            let mesh = &geometry.meshes()[geometry.item(index).mesh.0 as usize];
            let transform = geometry.item(index).transform();
            let own = store
                .meshes
                .get(store.device, store.queue, mesh)
                .mesh_from_vertices;
            let start = self.instances.len() as u32;
            self.instances.push(Instance::new(passage, transform * own));
            of.visible.draw_runs(item, mesh, &mut self.runs);
            let mirrored = self.mirrored != (passage.mirrored() != transform.mirrors());
            self.add_runs(
                (of, store),
                (geometry, mesh),
                (passage, mirrored),
                [start, start + 1],
                true,
            );
            self.steps.extend(self.opaque.drain(..).map(Step::Items));
        }
        self.glass = glass;
    }

    /// Adds draws for the runs in `self.runs` that are blended, or are not.
    fn add_runs(
        &mut self,
        (of, store): (Subject, &mut Store),
        (geometry, mesh): (&Arc<Geometry>, &Arc<enfilade::Mesh>),
        (passage, mirrored): (&Passage, bool),
        instances: [u32; 2],
        blended: bool,
    ) {
        if instances[0] == instances[1] {
            return;
        }
        let has_uv = !mesh.texture().is_empty();
        let gpu = (store.device, store.queue);
        for run in self.runs.drain(..).filter(|run| !run.indices.is_empty()) {
            let key = (Arc::as_ptr(geometry).addr(), run.material.0, has_uv);
            let (number, material) = *self.known.entry(key).or_insert_with(|| {
                let material = geometry.materials()[run.material.0 as usize];
                let number = store.materials.get(gpu, (geometry, of.stage), &material, has_uv);
                (number, material)
            });
            if (material.alpha == Alpha::Blend) != blended {
                continue;
            }
            let sides: &[Sides] = match (material.double_sided, blended) {
                (false, _) => &[Sides::Front],
                (true, false) => &[Sides::Both],
                // Of a convex body the back is behind the front.
                (true, true) => &[Sides::Back, Sides::Front],
            };
            let pieces = &store.meshes.get(store.device, store.queue, mesh).pieces;
            for (&sides, piece) in sides
                .iter()
                .flat_map(|sides| pieces.iter().map(move |piece| (sides, piece)))
            {
                if let Some(indices) = piece.part(&run.indices) {
                    self.opaque.push(ItemDraw {
                        kind: ItemKind {
                            blends: blended,
                            clips: passage.entry_plane().is_some(),
                            sides,
                            mirrored,
                        },
                        material: number,
                        page: piece.page,
                        indices: [indices.start, indices.end],
                        instances,
                    });
                }
            }
        }
    }

    /// Adds the depth of all openings of a passage. Returns the triangles of those that lead to its children, in order.
    fn add_openings(&mut self, of: Subject, lens: &Lens, id: u32, level: u32) -> Vec<Range<u32>> {
        let passages = of.visible.passages();
        let passage = &passages[id as usize];
        let openings = of.scene.sector(passage.sector).openings();
        if openings.is_empty() || of.scene.is_flat() {
            return Vec::new();
        }
        let clip_from_sector = lens.clip_from_sector(passage);
        let near = (!lens.is_parallel).then(|| f64::from(of.view.z_near()));
        let entry = passage.entry_plane();
        let mut followed = vec![false; openings.len()];
        let mut children = Vec::new();
        let mut child = self.children[id as usize][0];
        while let Some(number) = child {
            child = self.children[number as usize][1];
            let behind = &passages[number as usize];
            let Some(portal) = behind.portal else { continue };
            let opening = usize::from(of.scene.portals()[portal.0 as usize].opening.0);
            if level >= MAX_LEVEL {
                self.complete = false;
                continue;
            }
            followed[opening] = true;
            let outline = &openings[opening].outline;
            let start = self.triangles.len() as u32;
            let near_plane = outline.slack() + NEARLY * f64::from(outline.bounds().longest_side());
            if distance(outline, passage).abs() <= near_plane && !lens.is_parallel {
                // With the eye in its plane the opening is a line on the screen, or covers all of it.
                openings::add_aperture(&behind.aperture, behind.size, 1.0, &mut self.triangles);
            } else {
                openings::add(
                    &clip_from_sector,
                    outline.corners(),
                    entry,
                    near,
                    &mut self.triangles,
                );
            }
            let triangles = start..self.triangles.len() as u32;
            self.steps
                .push(Step::Opening(OpeningStep::Depth, triangles.clone()));
            children.push(triangles);
        }
        let start = self.triangles.len() as u32;
        for (opening, _) in openings.iter().zip(&followed).filter(|(_, followed)| !**followed) {
            if is_front(&opening.outline, passage) {
                openings::add(
                    &clip_from_sector,
                    opening.outline.corners(),
                    entry,
                    near,
                    &mut self.triangles,
                );
            }
        }
        let end = self.triangles.len() as u32;
        if start < end {
            self.steps.push(Step::Opening(OpeningStep::Closed, start..end));
        }
        children
    }
}

/// Adds the runs of all clusters of a mesh.
fn whole(mesh: &enfilade::Mesh, runs: &mut Vec<DrawRun>) {
    for (number, cluster) in mesh.clusters().iter().enumerate() {
        let indices = mesh.cluster_indices(number);
        match runs.last_mut() {
            Some(run) if run.material == cluster.material && run.indices.end == indices.start => {
                run.indices.end = indices.end;
            }
            _ => runs.push(DrawRun {
                material: cluster.material,
                indices,
            }),
        }
    }
}

/// Returns the distance of a passage's eye in front of an opening.
fn distance(outline: &enfilade::geom::ConvexPolygon, passage: &Passage) -> f64 {
    let first = DVec3::from(outline.corners()[0].map(f64::from));
    let normal = DVec3::from(outline.normal().map(f64::from));
    normal.dot(DVec3::from(passage.eye()) - first)
}

/// Whether a passage shows the front of an opening.
fn is_front(outline: &enfilade::geom::ConvexPolygon, passage: &Passage) -> bool {
    if !passage.is_parallel() {
        return distance(outline, passage) > 0.0;
    }
    let normal = DVec3::from(outline.normal().map(f64::from));
    normal.dot(DVec3::from(passage.ray([0.0, 0.0])[1])) < 0.0
}

impl Instance {
    fn new(passage: &Passage, sector_from_vertices: Transform) -> Instance {
        // Composed in 64 bits: coordinates far from the origin cancel here.
        let eye_from_vertices = passage.eye_from_sector() * sector_from_vertices;
        let [x, y, z, moved] = eye_from_vertices.columns();
        Instance {
            rows: [0, 1, 2].map(|row| [x[row], y[row], z[row], moved[row]]),
        }
    }
}

impl PassageBits {
    fn new(lens: &Lens, passage: &Passage, lighting: &PassageLighting, first_light: usize) -> PassageBits {
        let eye_from_sector = passage.eye_from_sector();
        let sector_from_eye = eye_from_sector.inverse().unwrap_or(Transform::IDENTITY);
        let [x, y, z, _] = sector_from_eye.columns();
        let ambient = &lighting.ambient;
        let row = |row: usize, last: f32| [x[row], y[row], z[row], last];
        let with = |[x, y, z]: [f32; 3], last: f32| [x, y, z, last];
        let flag = |set: bool| if set { 1.0 } else { 0.0 };
        let back = DVec3::from(sector_from_eye.direction([0.0, 0.0, 1.0]).map(f64::from));
        let entry = passage.entry_plane().map_or(DVec4::ZERO, |plane| {
            // A plane transforms by the transpose of the inverse.
            matrix(&sector_from_eye).transpose() * DVec4::from(plane)
        });
        PassageBits {
            clip_from_eye: lens.clip_from_eye.as_mat4().to_cols_array_2d(),
            sector: [
                row(0, lighting.exposure),
                row(1, flag(lighting.compresses)),
                row(2, ambient.from_the_eye),
            ],
            entry: entry.as_vec4().into(),
            back: back
                .normalize_or_zero()
                .as_vec3()
                .extend(flag(lens.is_parallel))
                .into(),
            above: with(ambient.above, first_light as f32),
            below: with(ambient.below, lighting.lights.len() as f32),
            sun: with(ambient.sun, 0.0),
            to_sun: with(ambient.to_sun, 0.0),
            ahead: DVec3::from(passage.ray([0.5, 0.5])[1])
                .as_vec3()
                .extend(0.0)
                .into(),
            unused: [0.0; 8],
        }
    }
}

/// Adds the texels of a light. The shader says what is where.
fn add_light(light: &DirectLight, texels: &mut Vec<[f32; 4]>) {
    let with = |[x, y, z]: [f32; 3], last: f32| [x, y, z, last];
    let flag = |set: bool| if set { 1.0 } else { 0.0 };
    let (onwards, [steepness, added]) = light.cone.unwrap_or_default();
    let first: [[f32; 4]; LIGHT_TEXELS] = [
        with(light.at, flag(light.is_sun)),
        with(light.color, light.per_square),
        with(onwards, light.per_range_square),
        [steepness, added, flag(light.cone.is_some()), light.nearest_square],
        light.opening.unwrap_or_default(),
        [
            light.planes.len() as f32,
            light.edge_planes as f32,
            flag(light.opening.is_some()),
            0.0,
        ],
    ];
    texels.extend(first);
    texels.extend(&light.planes);
}
