//! Hard shadows: which of the samples to be shaded a light does not reach.
//!
//! Idea: look from the light for what casts shadows on something visible ([`ShadowCasters`]). Each face of these keeps light from
//!     a volume behind it: a pyramid from the light over its edges, or a prism in the direction of a sun. The samples of a
//!     picture are grouped in blocks, with a tree of boxes, which each volume descends. No shadow map is involved, so edges
//!     are as exact as the picture.
//! Source: Sintorn, Olsson, Assarsson, An Efficient Alias-free Shadow Algorithm for Opaque and Transparent Objects using
//!     per-triangle Shadow Volumes, SIGGRAPH Asia 2011.
//! Cost: per light O(faces of casters · log samples), and for each volume the blocks that its sides cut.
//!
//! Light passes a one-sided face from behind, as sight does, and alpha-blended faces. Behind portals, light and casters are
//! moved to the space of what is lit, and clipped to the side of the openings that they are on.

mod strip;
#[cfg(test)]
mod tests;
mod volume;

use crate::lamps::{PassageLight, limits};
use crate::painter::Paint;
use crate::pending::{Pending, PendingSpan};
use crate::shade::Illumination;
use crate::stage::Stage;
use enfilade::{
    ItemIndex, LightId, LightReach, OpeningId, PortalId, Scene, SectorId, ShadowCasters, Transform,
    VisibleSet,
};
use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;
use smallvec::SmallVec;
use std::collections::{BTreeMap, HashMap};
use strip::{Bounds, Strip};
use volume::{Caster, Volume};

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

/// Bands of rows that are tested together.
const STRIP: usize = 4;
/// Clusters whose faces are tested at a time.
const CHUNK: usize = 64;
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
        // A light without casters has no beams here, and one that the stage does not know in its present state may lack some.
        let casters = self.lights.get(number);
        let Some(casters) = casters.filter(|casters| beam < casters.reach.len()) else {
            return;
        };
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
