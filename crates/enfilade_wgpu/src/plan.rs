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
use crate::pipelines::{ItemKind, Pass, Sides};
use bytemuck::{Pod, Zeroable};
use enfilade::{
    Alpha, DrawRun, Geometry, ItemIndex, LightId, LightView, Material, Mesh, Passage, PassageId, Scene,
    SectorId, Transform, View, VisibleItem, VisibleSet,
};
use enfilade_draw::{AmbientLight, DirectLight, Exposure, PassageLighting, Stage};
use glam::{DMat4, DVec3, DVec4};
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
    /// For each view of the sun what is drawn of its casters.
    pub(crate) shadow_steps: Vec<Vec<Step>>,
    /// The maps from the light's sector to clip space of these views.
    shadow_maps: Vec<DMat4>,
    pub(crate) passages_drawn: u32,
    /// Whether all visible passages are drawn.
    pub(crate) complete: bool,
    /// Whether the projection mirrors.
    mirrored: bool,
    runs: Vec<DrawRun>,
    sorted: Vec<VisibleItem>,
    batches: Vec<ItemDraw>,
    /// Bind groups of materials, by the geometry's address, the material, and whether the mesh has texture coordinates.
    known: HashMap<(usize, u32, bool), (u32, Material)>,
    /// For each passage its first child and its next sibling.
    children: Vec<[Option<u32>; 2]>,
    glass: Vec<VisibleItem>,
}

/// What a picture is made of.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct Frame<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its light and textures.
    pub stage: &'a Stage,
    /// The view.
    pub view: &'a View,
    /// The set of a look of that view.
    pub visible: &'a VisibleSet,
    /// Exposure of lights. Default: automatic.
    pub exposure: Exposure,
    /// A sun that casts shadows, and the views that [`ShadowCasters::find`](enfilade::ShadowCasters::find) returned for it
    /// and `visible`. Default: none.
    pub sun: Option<(LightId, &'a [LightView])>,
}

impl<'a> Frame<'a> {
    /// Creates a frame with defaults.
    pub fn new(scene: &'a Scene, stage: &'a Stage, view: &'a View, visible: &'a VisibleSet) -> Frame<'a> {
        Frame {
            scene,
            stage,
            view,
            visible,
            exposure: Exposure::Eye(0.0),
            sun: None,
        }
    }
}

/// An item at a place of its own, for [`Renderer::draw_placed`](crate::Renderer::draw_placed).
#[derive(Clone, Copy, Debug)]
pub struct PlacedItem {
    /// The sector of the item.
    pub sector: SectorId,
    /// The item.
    pub item: ItemIndex,
    /// Maps the space of the sector to that of the view's sector.
    pub root_from_sector: Transform,
    /// An entry of the visible set: these clusters are drawn as they look in daylight.
    pub visible: Option<VisibleItem>,
    /// What is not drawn so is drawn in this translucent colour: linear red, green and blue, and coverage.
    pub ghost: Option<[f32; 4]>,
}

/// Instances of a mesh that are drawn alike.
struct Batch<'a> {
    geometry: &'a Arc<Geometry>,
    mesh: &'a Arc<Mesh>,
    instances: [u32; 2],
    mirrored: bool,
    clips: bool,
    style: Style,
}

/// The materials that are drawn, and how.
#[derive(Clone, Copy, PartialEq)]
enum Style {
    Opaque,
    Blended,
    /// All materials, in one translucent colour.
    Ghost([f32; 4]),
    /// Depths of what is not blended.
    Caster,
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
    pub(crate) fn make(&mut self, of: Frame, store: &mut Store) {
        self.clear();
        for view in of.sun.map_or(&[][..], |(_, views)| views) {
            self.add_shadow_view(of, view, store);
        }
        let passages = of.visible.passages();
        let lens = Lens::new(of.scene, of.view, of.visible);
        self.mirrored = lens.mirrors;
        self.passages_drawn = passages.len() as u32;
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

    fn clear(&mut self) {
        self.instances.clear();
        self.passages.clear();
        self.lights.clear();
        self.triangles.clear();
        self.steps.clear();
        self.shadow_steps.clear();
        self.shadow_maps.clear();
        self.known.clear();
        self.complete = true;
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

    /// Adds what a view of the sun draws: all opaque and alpha-tested casters, where they are through its passages.
    fn add_shadow_view(&mut self, of: Frame, light: &LightView, store: &mut Store) {
        let lens = Lens::new(of.scene, &light.view, &light.casters);
        self.mirrored = lens.mirrors;
        self.shadow_maps
            .push(lens.clip_from_eye * matrix(&light.view.eye_from_sector()));
        let [width, height] = light.view.size();
        for (id, passage) in (0..).map(PassageId).zip(light.casters.passages()) {
            let Some(geometry) = of.scene.geometry(passage.sector) else {
                continue;
            };
            let sector_from_eye = passage.eye_from_sector().inverse().unwrap_or(Transform::IDENTITY);
            let number = self.passages.len() as u32;
            self.passages
                .push(PassageBits::plain(&lens, &sector_from_eye, &AmbientLight::day()));
            self.steps.push(Step::Passage {
                number,
                scissor: [0, 0, width, height],
                level: 0,
            });
            for item in light.casters.items().iter().filter(|item| item.passage == id) {
                let place = (passage.eye_from_sector(), false);
                self.add_item(
                    (of.stage, store),
                    (geometry, item.item.index),
                    place,
                    Style::Caster,
                    |mesh, runs| {
                        light.casters.draw_runs(item, mesh, runs);
                    },
                );
            }
            self.finish_batches(true);
        }
        self.shadow_steps.push(std::mem::take(&mut self.steps));
    }

    /// Adds a passage and all behind it, without recursion: chains may be long.
    fn add_passages(&mut self, of: Frame, lens: &Lens, store: &mut Store, root: u32, level: u32) {
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
    fn enter(&mut self, of: Frame, lens: &Lens, passage: &Passage, level: u32, scissor: [u32; 4]) -> u32 {
        let number = self.passages.len() as u32;
        let lighting = of.stage.lighting(of.scene, of.view, passage, of.exposure);
        let first = self.lights.len();
        for light in &lighting.lights {
            let is_shaded = of.sun.is_some_and(|(sun, _)| sun == light.light);
            let maps = if is_shaded { &self.shadow_maps[..] } else { &[] };
            add_light(light, maps, passage, &mut self.lights);
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

    fn add_opaque(&mut self, of: Frame, store: &mut Store, id: PassageId) {
        let passage = of.visible.passage(id);
        let Some(geometry) = of.scene.geometry(passage.sector) else {
            return;
        };
        let (eye_from_sector, clips) = (passage.eye_from_sector(), passage.entry_plane().is_some());
        let mut sorted = std::mem::take(&mut self.sorted);
        for (mesh, items) in of.visible.instances(id, geometry, &mut sorted) {
            let mesh = &geometry.meshes()[mesh.0 as usize];
            let is_whole = |item: &VisibleItem| {
                let clusters = of.visible.clusters(item).len();
                clusters == 0 || clusters == mesh.clusters().len()
            };
            // Instances of small meshes are drawn at once, even if one shows a cluster that another hides.
            let at_once = items.len() > 1 && (mesh.clusters().len() <= 4 || items.iter().all(is_whole));
            for items in items.chunks(if at_once { items.len() } else { 1 }) {
                if at_once {
                    whole(mesh, &mut self.runs);
                } else {
                    of.visible.draw_runs(&items[0], mesh, &mut self.runs);
                    join(mesh, &mut self.runs);
                }
                for mirrored in [false, true] {
                    let start = self.instances.len() as u32;
                    for item in items {
                        self.add_instance(
                            store,
                            eye_from_sector,
                            (geometry, item.item.index),
                            Some(mirrored),
                        );
                    }
                    let batch = Batch {
                        geometry,
                        mesh,
                        instances: [start, self.instances.len() as u32],
                        mirrored,
                        clips,
                        style: Style::Opaque,
                    };
                    self.add_runs(of.stage, store, &batch);
                }
            }
        }
        self.sorted = sorted;
        self.finish_batches(true);
    }

    /// Adds the blended items of a passage, back to front.
    fn add_glass(&mut self, of: Frame, store: &mut Store, id: PassageId) {
        let passage = of.visible.passage(id);
        let Some(geometry) = of.scene.geometry(passage.sector) else {
            return;
        };
        let glass = std::mem::take(&mut self.glass);
        for item in glass.iter().filter(|item| item.passage == id) {
            let place = (passage.eye_from_sector(), passage.entry_plane().is_some());
            self.add_item(
                (of.stage, store),
                (geometry, item.item.index),
                place,
                Style::Blended,
                |mesh, runs| {
                    of.visible.draw_runs(item, mesh, runs);
                },
            );
            self.finish_batches(false);
        }
        self.glass = glass;
    }

    /// Plans a picture of items at places of their own.
    pub(crate) fn make_placed(&mut self, of: Frame, placed: &[PlacedItem], store: &mut Store) {
        self.clear();
        let lens = Lens::new(of.scene, of.view, of.visible);
        self.mirrored = lens.mirrors;
        let eye_from_root = of.view.eye_from_sector();
        let root_from_eye = eye_from_root.inverse().unwrap_or(Transform::IDENTITY);
        self.passages
            .push(PassageBits::plain(&lens, &root_from_eye, &AmbientLight::day()));
        let ([x, y], [width, height]) = (of.view.viewport().origin, of.view.size());
        self.steps.push(Step::Passage {
            number: 0,
            scissor: [x, y, width, height],
            level: 0,
        });
        let place = |item: &PlacedItem| (eye_from_root * item.root_from_sector, false);
        for style in [Style::Opaque, Style::Blended] {
            for item in placed {
                let Some(visible) = &item.visible else { continue };
                if let Some(geometry) = of.scene.geometry(item.sector) {
                    let runs =
                        |mesh: &Mesh, runs: &mut Vec<DrawRun>| of.visible.draw_runs(visible, mesh, runs);
                    self.add_item((of.stage, store), (geometry, item.item), place(item), style, runs);
                }
            }
            self.finish_batches(style == Style::Opaque);
        }
        self.add_ghosts(of, placed, store, eye_from_root);
    }

    /// Adds the ghosts, all instances of a mesh that have one colour at once.
    fn add_ghosts(&mut self, of: Frame, placed: &[PlacedItem], store: &mut Store, eye_from_root: Transform) {
        let mut ghosts: Vec<_> = placed
            .iter()
            .filter_map(|item| {
                let geometry = of.scene.geometry(item.sector)?;
                let mesh = &geometry.meshes()[geometry.item(item.item).mesh.0 as usize];
                Some((item.ghost?, Arc::as_ptr(mesh).addr(), item, geometry, mesh))
            })
            .collect();
        ghosts.sort_by_key(|(color, address, ..)| (color.map(f32::to_bits), *address));
        for same in ghosts.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let &(color, _, _, geometry, mesh) = &same[0];
            for mirrored in [false, true] {
                let start = self.instances.len() as u32;
                for (_, _, item, geometry, _) in same {
                    let eye_from_sector = eye_from_root * item.root_from_sector;
                    self.add_instance(store, eye_from_sector, (geometry, item.item), Some(mirrored));
                }
                whole(mesh, &mut self.runs);
                let batch = Batch {
                    geometry,
                    mesh,
                    instances: [start, self.instances.len() as u32],
                    mirrored,
                    clips: false,
                    style: Style::Ghost(color),
                };
                self.add_runs(of.stage, store, &batch);
            }
        }
        self.finish_batches(false);
    }

    /// Adds one item.
    fn add_item(
        &mut self,
        (stage, store): (&Stage, &mut Store),
        (geometry, item): (&Arc<Geometry>, ItemIndex),
        (eye_from_sector, clips): (Transform, bool),
        style: Style,
        list_runs: impl FnOnce(&Mesh, &mut Vec<DrawRun>),
    ) {
        let mesh = &geometry.meshes()[geometry.item(item).mesh.0 as usize];
        list_runs(mesh, &mut self.runs);
        let start = self.instances.len() as u32;
        let mirrored = self.add_instance(store, eye_from_sector, (geometry, item), None);
        let batch = Batch {
            geometry,
            mesh,
            instances: [start, start + 1],
            mirrored,
            clips,
            style,
        };
        self.add_runs(stage, store, &batch);
    }

    /// Adds an instance of an item; if `only` is given, only if it is mirrored on the screen, or is not. Returns whether it
    /// is.
    fn add_instance(
        &mut self,
        store: &mut Store,
        eye_from_sector: Transform,
        (geometry, item): (&Geometry, ItemIndex),
        only: Option<bool>,
    ) -> bool {
        let mesh = &geometry.meshes()[geometry.item(item).mesh.0 as usize];
        let resident = store.meshes.get(store.device, store.queue, mesh);
        let sector_from_item = geometry.item(item).transform();
        let mirrored = self.mirrored != (eye_from_sector.mirrors() != sector_from_item.mirrors());
        if only.is_none_or(|only| only == mirrored) {
            let eye_from_vertices = eye_from_sector * sector_from_item * resident.mesh_from_vertices;
            self.instances.push(Instance::new(eye_from_vertices));
        }
        mirrored
    }

    /// Adds draws of a batch for those of the runs in `self.runs` that have its style.
    fn add_runs(&mut self, stage: &Stage, store: &mut Store, batch: &Batch) {
        if batch.instances[0] == batch.instances[1] {
            return;
        }
        let (mesh, has_uv) = (batch.mesh, !batch.mesh.texture().is_empty());
        let gpu = (store.device, store.queue);
        for run in self.runs.iter().filter(|run| !run.indices.is_empty()) {
            let of_scene = (&**batch.geometry, stage);
            let key = (Arc::as_ptr(batch.geometry).addr(), run.material.0, has_uv);
            let (mut number, material) = *self.known.entry(key).or_insert_with(|| {
                let material = batch.geometry.materials()[run.material.0 as usize];
                (store.materials.get(gpu, of_scene, &material, has_uv), material)
            });
            let blends = material.alpha == Alpha::Blend;
            let sides: &[Sides] = match (batch.style, material.double_sided) {
                (Style::Opaque | Style::Caster, _) if blends => continue,
                (Style::Blended, _) if !blends => continue,
                (Style::Ghost(base_color), _) => {
                    let ghost = Material {
                        base_color,
                        unlit: true,
                        alpha: Alpha::Blend,
                        ..Material::opaque([0.0; 3])
                    };
                    number = store.materials.get(gpu, of_scene, &ghost, false);
                    // From outside, walls of rooms do not hide what is inside.
                    if material.double_sided {
                        &[Sides::Both]
                    } else {
                        &[Sides::Front]
                    }
                }
                (_, false) => &[Sides::Front],
                (Style::Opaque | Style::Caster, true) => &[Sides::Both],
                // Of a convex body the back is behind the front.
                (Style::Blended, true) => &[Sides::Back, Sides::Front],
            };
            let pieces = &store.meshes.get(store.device, store.queue, mesh).pieces;
            let draws = sides
                .iter()
                .flat_map(|&sides| pieces.iter().map(move |piece| (sides, piece)));
            for (sides, piece) in draws {
                if let Some(indices) = piece.part(&run.indices) {
                    self.batches.push(ItemDraw {
                        kind: ItemKind {
                            pass: match batch.style {
                                Style::Opaque => Pass::Opaque,
                                Style::Blended | Style::Ghost(_) => Pass::Blended,
                                Style::Caster => Pass::Depth,
                            },
                            clips: batch.clips,
                            sides,
                            mirrored: batch.mirrored,
                        },
                        material: number,
                        page: piece.page,
                        indices: [indices.start, indices.end],
                        instances: batch.instances,
                    });
                }
            }
        }
    }

    /// Adds the steps of the batches, sorted by state if their order does not matter.
    fn finish_batches(&mut self, sort: bool) {
        if sort {
            self.batches.sort_unstable();
        }
        self.steps.extend(self.batches.drain(..).map(Step::Items));
    }

    /// Adds the depth of all openings of a passage. Returns the triangles of those that lead to its children, in order.
    fn add_openings(&mut self, of: Frame, lens: &Lens, id: u32, level: u32) -> Vec<Range<u32>> {
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

/// Joins runs of one material where few hidden triangles are between them: they cost less than another draw call.
fn join(mesh: &Mesh, runs: &mut Vec<DrawRun>) {
    /// Most indices between runs that are joined.
    const FEW: u32 = 3 * 512;
    let clusters = mesh.clusters();
    // Whether all clusters in a range of indices have a material.
    let all_have = |material, indices: Range<u32>| {
        let (mut low, mut high) = (0, clusters.len());
        while low < high {
            let middle = low.midpoint(high);
            match mesh.cluster_indices(middle).start < indices.start {
                true => low = middle + 1,
                false => high = middle,
            }
        }
        let mut between =
            (low..clusters.len()).take_while(|&number| mesh.cluster_indices(number).start < indices.end);
        between.all(|number| clusters[number].material == material)
    };
    runs.dedup_by(|next, run| {
        let gap = run.indices.end..next.indices.start;
        let joins = run.material == next.material
            && run.indices.end <= next.indices.start
            && gap.len() <= FEW as usize
            && all_have(run.material, gap);
        if joins {
            run.indices.end = next.indices.end;
        }
        joins
    });
}

/// Adds the runs of all clusters of a mesh.
fn whole(mesh: &Mesh, runs: &mut Vec<DrawRun>) {
    runs.clear();
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
    /// Creates an instance from its transform, composed in 64 bits: coordinates far from the origin cancel in it.
    pub(crate) fn new(eye_from_vertices: Transform) -> Instance {
        let [x, y, z, moved] = eye_from_vertices.columns();
        Instance {
            rows: [0, 1, 2].map(|row| [x[row], y[row], z[row], moved[row]]),
        }
    }
}

impl PassageBits {
    fn new(lens: &Lens, passage: &Passage, lighting: &PassageLighting, first_light: usize) -> PassageBits {
        let sector_from_eye = passage.eye_from_sector().inverse().unwrap_or(Transform::IDENTITY);
        let entry = passage.entry_plane().map_or(DVec4::ZERO, |plane| {
            // A plane transforms by the transpose of the inverse.
            matrix(&sector_from_eye).transpose() * DVec4::from(plane)
        });
        let mut bits = PassageBits::plain(lens, &sector_from_eye, &lighting.ambient);
        bits.sector[0][3] = lighting.exposure;
        bits.sector[1][3] = flag(lighting.compresses);
        bits.entry = entry.as_vec4().into();
        bits.above[3] = first_light as f32;
        bits.below[3] = lighting.lights.len() as f32;
        bits.ahead = DVec3::from(passage.ray([0.5, 0.5])[1])
            .as_vec3()
            .extend(0.0)
            .into();
        bits
    }

    /// Returns a passage with ambient light only, without an entry plane.
    pub(crate) fn plain(lens: &Lens, sector_from_eye: &Transform, ambient: &AmbientLight) -> PassageBits {
        let [x, y, z, _] = sector_from_eye.columns();
        let row = |row: usize, last: f32| [x[row], y[row], z[row], last];
        let with = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let back = DVec3::from(sector_from_eye.direction([0.0, 0.0, 1.0]).map(f64::from)).normalize_or_zero();
        PassageBits {
            clip_from_eye: lens.clip_from_eye.as_mat4().to_cols_array_2d(),
            sector: [row(0, 1.0), row(1, 0.0), row(2, ambient.from_the_eye)],
            entry: [0.0; 4],
            back: back.as_vec3().extend(flag(lens.is_parallel)).into(),
            above: with(ambient.above),
            below: with(ambient.below),
            sun: with(ambient.sun),
            to_sun: with(ambient.to_sun),
            ahead: (-back).as_vec3().extend(0.0).into(),
            unused: [0.0; 8],
        }
    }
}

fn flag(set: bool) -> f32 {
    if set { 1.0 } else { 0.0 }
}

/// Adds the texels of a light, and of its shadow maps. The shader says what is where.
fn add_light(light: &DirectLight, maps: &[DMat4], passage: &Passage, texels: &mut Vec<[f32; 4]>) {
    let with = |[x, y, z]: [f32; 3], last: f32| [x, y, z, last];
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
            maps.len() as f32,
        ],
    ];
    texels.extend(first);
    texels.extend(&light.planes);
    let light_from_here = matrix(&light.light_from_here) * DMat4::from_translation(passage.eye().into());
    for clip_from_light in maps {
        let clip_from_here = *clip_from_light * light_from_here;
        texels.extend([0, 1, 2].map(|row| <[f32; 4]>::from(clip_from_here.row(row).as_vec4())));
    }
}
