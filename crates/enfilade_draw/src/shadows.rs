//! Hard shadows: which of the samples to be shaded a light does not reach.
//!
//! Idea: look from the light for what casts shadows on something visible ([`ShadowCasters`]). Each face of these keeps light from
//!     a volume behind it: a pyramid from the light over its edges, or a prism in the direction of a sun. The samples of a
//!     picture are grouped in blocks, with a tree of boxes, which each volume descends. No shadow map is
//!     involved, so edges are as exact as the picture.
//! Source: Sintorn, Olsson, Assarsson, An Efficient Alias-free Shadow Algorithm for Opaque and Transparent Objects using
//!     per-triangle Shadow Volumes, SIGGRAPH Asia 2011.
//! Cost: per light O(faces of casters · log samples), and for each volume the blocks that its sides cut.
//!
//! Light passes a one-sided face from behind, as sight does, and alpha-blended faces. Behind portals, light and casters are
//! moved to the space of what is lit, and clipped to the side of the openings that they are on.

use crate::face::Rays;
use crate::lamps::{PassageLight, limits};
use crate::painter::Paint;
use crate::pending::{Pending, PendingSpan};
use crate::shade::Illumination;
use crate::stage::Stage;
use enfilade::{
    Alpha, Geometry, ItemIndex, LightId, LightReach, Mesh, OpeningId, PortalId, Scene, SectorId,
    ShadowCasters, Transform, VisibleSet,
};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use rayon::prelude::*;
use smallvec::SmallVec;
use std::collections::{BTreeMap, HashMap};

/// The casters of one picture.
pub(crate) struct Shadows {
    /// By light.
    lights: Vec<CastersOfLight>,
}

#[derive(Default)]
struct CastersOfLight {
    reach: Vec<LightReach>,
    /// By the portals from the light: items with their clusters, or none for all clusters.
    items: HashMap<Vec<PortalId>, BTreeMap<ItemIndex, Vec<u32>>>,
}

/// One sector on the way of the light.
struct Leg {
    sector: SectorId,
    /// From the space of that sector to that of the lit one, relative to the eye.
    here_from_leg: DAffine3,
    /// The sides of the openings that casters are on, in the space of that sector: n · p ≥ d.
    planes: SmallVec<[(DVec3, f64); 2]>,
    /// The opening by which the light leaves.
    exit: Option<OpeningId>,
}

/// For each light, the samples of a band of rows that are in its shadow.
#[derive(Default)]
pub(crate) struct BandShadows {
    lights: Vec<Option<Vec<u64>>>,
}

impl BandShadows {
    /// Whether a sample, by its place among those of the band, is in the shadow of a light.
    #[inline]
    pub(crate) fn has(&self, light: u16, sample: usize) -> bool {
        let bits = self.lights.get(usize::from(light)).and_then(Option::as_ref);
        bits.is_some_and(|bits| bits[sample / 64] >> (sample % 64) & 1 == 1)
    }
}

/// Columns and rows of a block.
const BLOCK: u16 = 8;
/// Bands of rows that are tested together.
const STRIP: usize = 4;
/// Clusters whose faces are tested at a time.
const CHUNK: usize = 64;
/// Displayed value of light that is too weak to be worth a test for shadows: a quarter of a step of the picture.
const NEGLIGIBLE: f32 = 1.0 / 1024.0;
/// How far behind a face a sample must be to be in its shadow, relative to the distances of samples from the eye, which are
/// rounded to f32.
const BEHIND: f64 = 1e-5;

impl Shadows {
    /// Finds what casts shadows on the items of a visible set.
    pub(crate) fn of(scene: &Scene, visible: &VisibleSet) -> Shadows {
        let mut finder = ShadowCasters::new();
        finder.options.limits = limits();
        let mut of_light = |light: LightId| {
            let mut casters = CastersOfLight::default();
            for map in finder.find(scene, light, visible) {
                let set = &map.casters;
                let mut chains: Vec<Vec<PortalId>> = Vec::new();
                for passage in set.passages() {
                    let mut chain = passage
                        .parent
                        .map_or(Vec::new(), |parent| chains[parent.0 as usize].clone());
                    chain.extend(passage.portal);
                    chains.push(chain);
                }
                for seen in set.items() {
                    let chain = &chains[seen.passage.0 as usize];
                    let items = casters.items.entry(chain.clone()).or_default();
                    let here = set.clusters(seen);
                    let known = items.entry(seen.item.index).or_insert_with(|| here.to_vec());
                    if known.is_empty() || here.is_empty() {
                        known.clear();
                    } else {
                        known.extend(here);
                        known.sort_unstable();
                        known.dedup();
                    }
                }
            }
            if !casters.items.is_empty() {
                casters.reach = scene.light_reach(light, &limits());
            }
            casters
        };
        let count = scene.lights().len() as u32;
        Shadows {
            lights: (0..count).map(|light| of_light(LightId(light))).collect(),
        }
    }

    /// Computes which samples of a batch are in the shadow of the lights that their faces list.
    pub(crate) fn on(
        &self,
        (scene, stage): (&Scene, &Stage),
        Illumination {
            rays, lights, tone, ..
        }: &Illumination,
        paints: &[Paint],
        pending: &Pending,
    ) -> Vec<BandShadows> {
        let exposure = tone.exposure;
        let bands: Vec<&[PendingSpan]> = pending.bands().collect();
        let mut all: Vec<BandShadows> = Vec::new();
        all.resize_with(bands.len(), BandShadows::default);
        for (number, light) in (0_u16..).zip(*lights) {
            let lists = |paint: &Paint| match paint {
                Paint::Plain(_) => false,
                Paint::Varied(face) => face.lights.iter().any(|&(of, _)| of == number),
            };
            if !paints.iter().any(lists) {
                continue;
            }
            let mut strips: Vec<Strip> = bands
                .par_chunks(STRIP)
                .map(|bands| Strip::of(bands, (number, light), exposure, rays, paints))
                .collect();
            self.cast((scene, stage), rays.eye, light, &mut strips);
            for (shadows, strip) in all.chunks_mut(STRIP).zip(strips) {
                for (shadows, words) in shadows.iter_mut().zip(strip.words.windows(2)) {
                    shadows.lights.resize_with(lights.len(), || None);
                    shadows.lights[usize::from(number)] = Some(strip.shadow[words[0]..words[1]].to_vec());
                }
            }
        }
        all
    }

    /// Tests all casters of a light against the samples that it may reach.
    fn cast(&self, (scene, stage): (&Scene, &Stage), eye: DVec3, light: &PassageLight, strips: &mut [Strip]) {
        let (number, beam) = light.beam;
        let casters = &self.lights[number];
        if casters.reach.is_empty() {
            return;
        }
        let around = Bounds::around(strips.iter().map(Strip::bounds));
        let (legs, chain) = casters.legs(scene, beam, eye);
        for (number, leg) in legs.iter().enumerate() {
            let caster = Caster { light, leg, stage };
            let mut volumes: Vec<Volume> = Vec::new();
            for (id, opening) in (0..).map(OpeningId).zip(scene.sector(leg.sector).openings()) {
                if leg.exit != Some(id) {
                    let corners = opening.outline.corners().iter();
                    let corners: SmallVec<[DVec3; 8]> =
                        corners.map(|corner| DVec3::from(corner.map(f64::from))).collect();
                    volumes.extend(caster.volume(&corners, DAffine3::IDENTITY, false, None));
                }
            }
            test(&volumes, light, strips);
            let items = casters.items.get(&chain[..number]);
            let (Some(items), Some(geometry)) = (items, scene.geometry(leg.sector)) else {
                continue;
            };
            let clusters: Vec<(ItemIndex, u32)> = items
                .iter()
                .flat_map(|(&item, clusters)| {
                    let count = geometry.mesh_of(item).clusters().len() as u32;
                    let all = if clusters.is_empty() { 0..count } else { 0..0 };
                    all.chain(clusters.iter().copied())
                        .map(move |cluster| (item, cluster))
                })
                .collect();
            for chunk in clusters.chunks(CHUNK) {
                let volumes: Vec<Volume> = chunk
                    .par_iter()
                    .flat_map_iter(|&(item, cluster)| caster.volumes(geometry, item, cluster, &around))
                    .collect();
                test(&volumes, light, strips);
            }
        }
    }
}

impl CastersOfLight {
    /// Returns the sectors on the way of a beam, the light's first, and the portals between them.
    fn legs(&self, scene: &Scene, beam: usize, eye: DVec3) -> (Vec<Leg>, Vec<PortalId>) {
        let end = &self.reach[beam];
        let mut way = vec![end];
        while let Some(parent) = way.last().and_then(|beam| beam.parent) {
            way.push(&self.reach[parent as usize]);
        }
        way.reverse();
        let chain: Vec<PortalId> = way.iter().filter_map(|beam| beam.portal).collect();
        let affine = |transform: &Transform| {
            let [x, y, z, offset] = transform.columns_f64().map(DVec3::from);
            DAffine3 {
                matrix3: DMat3::from_cols(x, y, z),
                translation: offset,
            }
        };
        let to_end = DAffine3::from_translation(-eye) * affine(&end.there_from_here);
        let legs = way.iter().enumerate().map(|(number, beam)| {
            let exit = chain
                .get(number)
                .map(|&id| scene.portals()[id.0 as usize].opening);
            let mut planes = SmallVec::new();
            // The first plane of a beam is that of the opening it came through.
            let entry = beam.planes().next().filter(|_| beam.parent.is_some());
            planes.extend(entry.map(|(normal, distance)| (DVec3::from(normal), distance)));
            if let Some(exit) = exit {
                let outline = &scene.sector(beam.sector).openings()[usize::from(exit.0)].outline;
                let normal = DVec3::from(outline.normal().map(f64::from));
                let corner = DVec3::from(outline.corners()[0].map(f64::from));
                planes.push((normal, normal.dot(corner)));
            }
            Leg {
                sector: beam.sector,
                here_from_leg: to_end * affine(&beam.there_from_here).inverse(),
                planes,
                exit,
            }
        });
        (legs.collect(), chain)
    }
}

/// What makes shadow volumes of the faces on one leg.
struct Caster<'a> {
    light: &'a PassageLight,
    leg: &'a Leg,
    stage: &'a Stage,
}

impl<'a> Caster<'a> {
    /// Returns the shadow volumes of the faces of a cluster.
    fn volumes(
        &self,
        geometry: &'a Geometry,
        item: ItemIndex,
        cluster: u32,
        around: &Bounds,
    ) -> Vec<Volume<'a>> {
        let mesh = geometry.mesh_of(item);
        let cluster = &mesh.clusters()[cluster as usize];
        let material = geometry.material(cluster);
        if material.alpha == Alpha::Blend {
            return Vec::new();
        }
        let [x, y, z, offset] = geometry.item(item).transform().columns_f64().map(DVec3::from);
        let leg_from_item = DAffine3 {
            matrix3: DMat3::from_cols(x, y, z),
            translation: offset,
        };
        let cutout = (material.alpha == Alpha::Mask)
            .then(|| self.stage.mips(geometry, material.texture))
            .flatten()
            .filter(|_| !mesh.texture().is_empty());
        let volumes = cluster.faces.clone().filter_map(|face| {
            let corners: SmallVec<[DVec3; 8]> = mesh
                .face(face)
                .iter()
                .map(|&corner| DVec3::from(mesh.positions()[corner as usize].map(f64::from)))
                .collect();
            let cutout = cutout.map(|texture| Cutout {
                texture,
                mesh,
                face,
                cutoff: material.cutoff,
                opacity: material.base_color[3],
                item_from_here: (self.leg.here_from_leg * leg_from_item).inverse(),
            });
            self.volume(&corners, leg_from_item, material.double_sided, cutout)
        });
        volumes.filter(|volume| volume.meets(around)).collect()
    }

    /// Returns the shadow volume of a face; `None` if it casts no shadow.
    fn volume(
        &self,
        corners: &[DVec3],
        leg_from_item: DAffine3,
        double_sided: bool,
        cutout: Option<Cutout<'a>>,
    ) -> Option<Volume<'a>> {
        let mut outline: SmallVec<[DVec3; 8]> = corners
            .iter()
            .map(|&corner| leg_from_item.transform_point3(corner))
            .collect();
        for &(normal, distance) in &self.leg.planes {
            clip(&mut outline, normal, distance);
        }
        for corner in &mut outline {
            *corner = self.leg.here_from_leg.transform_point3(*corner);
        }
        let first = *outline.first()?;
        let mut normal: DVec3 = outline
            .windows(2)
            .map(|pair| (pair[0] - first).cross(pair[1] - first))
            .sum();
        let determinant = self.leg.here_from_leg.matrix3.determinant() * leg_from_item.matrix3.determinant();
        let mirrored = determinant < 0.0;
        let toward = self.light.toward(first);
        let facing = normal.dot(toward);
        let is_front = (facing > 0.0) != mirrored;
        let length = normal.length();
        if !(facing.abs() > 1e-12 * length * toward.length()) || !(is_front || double_sided) {
            return None;
        }
        if facing < 0.0 {
            outline.reverse();
            normal = -normal;
        }
        normal /= length;
        let mut planes: SmallVec<[(DVec3, f64); 5]> = SmallVec::new();
        planes.push((-normal, -normal.dot(first)));
        for (number, &start) in outline.iter().enumerate() {
            let end = outline[(number + 1) % outline.len()];
            // In one order for both faces that share the edge, so that no sample is between their volumes.
            let is_ordered = start.to_array() < end.to_array();
            let [low, high] = if is_ordered { [start, end] } else { [end, start] };
            let side = self.light.toward(low).cross(high - low);
            let distance = side.dot(low);
            planes.push(if is_ordered {
                (side, distance)
            } else {
                (-side, -distance)
            });
        }
        Some(Volume { planes, cutout })
    }
}

/// Marks the samples in volumes.
fn test(volumes: &[Volume], light: &PassageLight, strips: &mut [Strip]) {
    let strips = strips.par_iter_mut().filter(|strip| !strip.levels.is_empty());
    strips.for_each(|strip| {
        let top = strip.levels.len() - 1;
        for volume in volumes {
            strip.darken(volume, light, top, 0);
        }
    });
}

/// Clips a convex outline to n · p ≥ d.
fn clip(outline: &mut SmallVec<[DVec3; 8]>, normal: DVec3, distance: f64) {
    if outline.iter().all(|corner| normal.dot(*corner) >= distance) {
        return;
    }
    let whole = std::mem::take(outline);
    for (number, &here) in whole.iter().enumerate() {
        let there = whole[(number + 1) % whole.len()];
        let [at_here, at_there] = [here, there].map(|corner| normal.dot(corner) - distance);
        if at_here >= 0.0 {
            outline.push(here);
        }
        if (at_here < 0.0) != (at_there < 0.0) {
            outline.push(here + (there - here) * (at_here / (at_here - at_there)));
        }
    }
}

/// The points that a face keeps a light from: n · p ≥ d for all planes. The first is that of the face.
struct Volume<'a> {
    planes: SmallVec<[(DVec3, f64); 5]>,
    cutout: Option<Cutout<'a>>,
}

/// The alpha test of a face.
struct Cutout<'a> {
    texture: &'a crate::mips::Mips,
    mesh: &'a Mesh,
    face: u32,
    cutoff: f32,
    opacity: f32,
    item_from_here: DAffine3,
}

/// How much of a box is inside a volume.
enum Part {
    None,
    Some,
    All,
}

impl Volume<'_> {
    fn meets(&self, bounds: &Bounds) -> bool {
        !matches!(self.part(bounds, 0.0), Part::None)
    }

    fn part(&self, bounds: &Bounds, behind: f64) -> Part {
        let mut part = Part::All;
        for (number, &(normal, distance)) in self.planes.iter().enumerate() {
            let slack = if number == 0 { behind } else { 0.0 };
            let at = normal.dot(bounds.middle()) - distance - slack;
            let reach = normal.abs().dot(bounds.half());
            if at + reach < 0.0 {
                return Part::None;
            }
            if at < reach {
                part = Part::Some;
            }
        }
        if self.cutout.is_some() { Part::Some } else { part }
    }

    /// Returns where light on its way to a point inside goes through the face.
    fn entry(&self, point: DVec3, light: &PassageLight) -> DVec3 {
        let (normal, distance) = self.planes[0];
        let toward = light.toward(point);
        point + toward * ((distance - normal.dot(point)) / normal.dot(toward))
    }
}

impl Cutout<'_> {
    /// Whether the face passes the alpha test where light goes through it.
    fn is_opaque_at(&self, at: DVec3) -> bool {
        let at = self.item_from_here.transform_point3(at);
        let corners = self.mesh.face(self.face);
        let position = |i: usize| DVec3::from(self.mesh.positions()[corners[i] as usize].map(f64::from));
        let uv = |i: usize| self.mesh.texture()[corners[i] as usize].map(f64::from);
        let first = position(0);
        let mut best = (f64::NEG_INFINITY, [0.0; 2]);
        for last in 2..corners.len() {
            let [a, b] = [position(last - 1) - first, position(last) - first];
            let normal = a.cross(b);
            let square = normal.length_squared();
            let off = at - first;
            let [v, w] = [
                off.cross(b).dot(normal) / square,
                a.cross(off).dot(normal) / square,
            ];
            let inside = v.min(w).min(1.0 - v - w);
            if inside > best.0 {
                let [o, a, b] = [uv(0), uv(last - 1), uv(last)];
                best = (
                    inside,
                    [0, 1].map(|axis| o[axis] + v * (a[axis] - o[axis]) + w * (b[axis] - o[axis])),
                );
            }
        }
        let texel = self.texture.at(best.1.map(|value| value as f32), 0.0);
        texel.w * self.opacity >= self.cutoff
    }
}

/// A box around samples, relative to the eye.
#[derive(Clone, Copy)]
struct Bounds {
    min: Vec3,
    max: Vec3,
}

impl Bounds {
    const NONE: Bounds = Bounds {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    fn with(&self, other: &Bounds) -> Bounds {
        Bounds {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    fn around(boxes: impl IntoIterator<Item = Bounds>) -> Bounds {
        boxes
            .into_iter()
            .fold(Bounds::NONE, |sum, bounds| sum.with(&bounds))
    }

    fn middle(&self) -> DVec3 {
        0.5 * (self.min.as_dvec3() + self.max.as_dvec3())
    }

    fn half(&self) -> DVec3 {
        0.5 * (self.max.as_dvec3() - self.min.as_dvec3())
    }
}

/// Maximum number of samples of a block.
const SAMPLES: usize = (BLOCK * BLOCK) as usize;

/// Samples that are near each other.
struct Block {
    middle: DVec3,
    /// Positions relative to the middle, axis by axis; NaN beyond the last.
    points: [[f32; SAMPLES]; 3],
    /// Their places among the samples of the strip.
    samples: SmallVec<[u32; SAMPLES]>,
    /// One bit for each that is not in shadow yet.
    lit: u64,
}

impl Block {
    fn of(points: &[(u32, u32, Vec3)]) -> (Block, Bounds) {
        let bounds = Bounds::around(points.iter().map(|&(_, _, point)| Bounds {
            min: point,
            max: point,
        }));
        let middle = bounds.middle();
        let mut axes = [[f32::NAN; SAMPLES]; 3];
        for (place, (_, _, point)) in points.iter().enumerate() {
            let off = (point.as_dvec3() - middle).as_vec3();
            (0..3).for_each(|axis| axes[axis][place] = off[axis]);
        }
        let block = Block {
            middle,
            points: axes,
            samples: points.iter().map(|point| point.1).collect(),
            lit: u64::MAX >> (SAMPLES - points.len()),
        };
        (block, bounds)
    }

    /// Returns one bit for each sample in a volume.
    fn inside(&self, volume: &Volume, behind: f64) -> u64 {
        // The least signed distance from any plane.
        let mut least = [f32::INFINITY; SAMPLES];
        let [x, y, z] = &self.points;
        for (number, &(normal, distance)) in volume.planes.iter().enumerate() {
            let slack = if number == 0 { behind } else { 0.0 };
            let scale = 1.0 / normal.abs().max_element().max(f64::MIN_POSITIVE);
            let at_middle = ((normal.dot(self.middle) - distance - slack) * scale) as f32;
            let normal = (normal * scale).as_vec3();
            for i in 0..SAMPLES {
                let at = at_middle + normal.x * x[i] + normal.y * y[i] + normal.z * z[i];
                // Not `min`, which would leave out NaN.
                least[i] = if at >= least[i] { least[i] } else { at };
            }
        }
        least
            .iter()
            .enumerate()
            .fold(0, |bits, (i, &least)| bits | u64::from(least >= 0.0) << i)
    }

    fn point(&self, place: usize) -> DVec3 {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(self.points[axis][place]));
        self.middle + DVec3::new(x, y, z)
    }
}

/// The samples of some bands of rows that a light may reach: blocks of them, and a tree over the blocks.
struct Strip {
    /// How far behind a face a sample must be to be in its shadow.
    behind: f64,
    blocks: Vec<Block>,
    /// Boxes of the blocks, then of four blocks each, then of four of those, up to a single one. Empty without samples.
    levels: Vec<Vec<Bounds>>,
    /// One bit per sample of the strip; each band begins a word.
    shadow: Vec<u64>,
    /// Where the words of each band begin, and the end of the last.
    words: Vec<usize>,
}

impl Strip {
    fn of(
        bands: &[&[PendingSpan]],
        (number, light): (u16, &PassageLight),
        exposure: f32,
        rays: &Rays,
        paints: &[Paint],
    ) -> Strip {
        let mut points: Vec<(u32, u32, Vec3)> = Vec::new();
        let mut words = vec![0];
        for spans in bands {
            let mut sample = words[words.len() - 1] as u32 * 64;
            for span in *spans {
                let first = sample;
                sample += u32::from(span.x1 - span.x0);
                let Paint::Varied(face) = &paints[span.owner as usize] else {
                    continue;
                };
                if !face.lights.iter().any(|&(of, _)| of == number) {
                    continue;
                }
                let facing = face.facing.row(span.y);
                let slopes = [facing.right, facing.down];
                points.extend((span.x0..span.x1).zip(first..).filter_map(|(x, sample)| {
                    let per_facing = 1.0 / facing.at(f32::from(x));
                    let (point, _) = rays.point(face, [x, span.y], per_facing, slopes);
                    let block = interleaved([x, span.y].map(|at| at / BLOCK));
                    let counts = point.is_finite() && light.at_most(point) * exposure > NEGLIGIBLE;
                    counts.then_some((block, sample, point))
                }));
            }
            words.push((sample as usize).div_ceil(64));
        }
        points.sort_by_key(|&(block, ..)| block);
        let blocks = points.chunk_by(|a, b| a.0 == b.0);
        let (blocks, bounds): (Vec<Block>, Vec<Bounds>) = blocks
            .flat_map(|here| here.chunks(SAMPLES))
            .map(Block::of)
            .unzip();
        let mut levels = Vec::new();
        let mut level = bounds;
        while !level.is_empty() {
            let above = match level.len() {
                1 => Vec::new(),
                _ => level
                    .chunks(4)
                    .map(|four| Bounds::around(four.iter().copied()))
                    .collect(),
            };
            levels.push(std::mem::replace(&mut level, above));
        }
        let bounds = levels.last().map_or(Bounds::NONE, |top| top[0]);
        let farthest = bounds.min.abs().max(bounds.max.abs()).length();
        Strip {
            behind: BEHIND * f64::from(farthest),
            blocks,
            levels,
            shadow: vec![0; words[words.len() - 1]],
            words,
        }
    }

    fn bounds(&self) -> Bounds {
        self.levels.last().map_or(Bounds::NONE, |top| top[0])
    }

    /// Marks the samples in a volume that are below a node of the tree.
    fn darken(&mut self, volume: &Volume, light: &PassageLight, level: usize, number: usize) {
        let part = volume.part(&self.levels[level][number], self.behind);
        if matches!(part, Part::None) {
            return;
        }
        if matches!(part, Part::All) {
            let width = 4_usize.pow(level as u32);
            let end = (width * (number + 1)).min(self.blocks.len());
            for block in &mut self.blocks[width * number..end] {
                mark(&mut self.shadow, block, block.lit);
            }
        } else if level > 0 {
            let below = self.levels[level - 1].len();
            for child in 4 * number..(4 * number + 4).min(below) {
                self.darken(volume, light, level - 1, child);
            }
        } else if self.blocks[number].lit != 0 {
            let block = &mut self.blocks[number];
            let mut dark = block.inside(volume, self.behind) & block.lit;
            if let Some(cutout) = &volume.cutout {
                for place in 0..block.samples.len() {
                    let is_dark = dark >> place & 1 == 1;
                    if is_dark && !cutout.is_opaque_at(volume.entry(block.point(place), light)) {
                        dark &= !(1 << place);
                    }
                }
            }
            mark(&mut self.shadow, block, dark);
        }
    }
}

/// Marks samples of a block as in shadow.
fn mark(shadow: &mut [u64], block: &mut Block, dark: u64) {
    let mut rest = dark;
    while rest != 0 {
        let sample = block.samples[rest.trailing_zeros() as usize] as usize;
        shadow[sample / 64] |= 1 << (sample % 64);
        rest &= rest - 1;
    }
    block.lit &= !dark;
}

/// Returns the bits of two numbers in turn, so that neighbours in both have numbers near each other.
fn interleaved(at: [u16; 2]) -> u32 {
    let spread = |value: u16| (0..16).fold(0, |sum, bit| sum | (u32::from(value) >> bit & 1) << (2 * bit));
    spread(at[0]) | spread(at[1]) << 1
}
