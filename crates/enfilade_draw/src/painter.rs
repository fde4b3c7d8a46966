//! A [`Canvas`] that renders a picture. It collects spans and shades them in batches on all cores.

use crate::ambient::{Ambient, directions};
use crate::cover::CoverPicture;
use crate::face::{Face, Rays};
use crate::lamps::PassageLight;
use crate::light::{Daylight, Tone};
use crate::palette::{distinct, heat, rainbow};
use crate::pending::{Pending, PendingSpan};
use crate::pixels::{self, Pixel, UNPAINTED, pixel, put};
use crate::samples::{PixelCache, SampleCache};
use crate::shade::{Illumination, Row, Shade};
use crate::shadows::{BandShadows, Shadows};
use crate::show::Show;
use crate::sky::Sky;
use crate::smooth::SmoothRow;
use crate::stage::{Picture, Settings, Stage};
use enfilade::{
    Alpha, Canvas, CoverSpan, Method, Owner, Passage, PassageId, Scene, SectorId, Span, View, VisibleSet,
};
use glam::Vec3;
use image::RgbImage;
use rayon::prelude::*;

/// Renders the spans that [`Viewer::draw`](enfilade::Viewer::draw) emits.
///
/// Per-face values are computed once per passage. Faces with textures, normals or lights are shaded per sample.
#[doc(alias = "rasterizer")]
pub struct Painter<'a> {
    scene: &'a Scene,
    stage: &'a Stage,
    settings: Settings,
    size: [u32; 2],
    pixels: Vec<Pixel>,
    /// Counts from [`Canvas::work`]; empty unless the picture shows them.
    counts: Vec<u32>,
    /// Spans from [`Canvas::cover`], if the picture shows them.
    cover: Option<CoverPicture>,
    sky: Sky,
    tone: Tone,
    sector: SectorId,
    rays: Rays,
    /// Lights that may reach what the current passage shows.
    near: Vec<PassageLight>,
    daylight: Daylight,
    /// For each light of the scene, whether it may reach a visible passage.
    shines: Vec<bool>,
    pending: Pending,
    shaded: u64,
    /// Colours that the pixels' previous samples have shown, with several samples per pixel.
    others: Option<SampleCache>,
    /// Hash of the current passage's sector and transform.
    passage: u64,
    /// The rays of ambient occlusion, over a surface with the normal +z.
    over_surfaces: Vec<Vec3>,
    /// What casts shadows, if they are wanted.
    pub(crate) shadows: Option<Shadows>,
}

/// Rows per parallel job.
const BAND: usize = 8;
/// Batches with fewer samples run on one thread, because parallel jobs would cost more than they save.
const FEW_SAMPLES: u64 = 1 << 13;
/// Colour of an opening that is closed or beyond the recursion limit.
const CLOSED: [f32; 3] = [0.10, 0.07, 0.05];

impl<'a> Painter<'a> {
    /// Creates an empty picture of the view's size. [`Stage::draw`] does the whole rendering.
    pub fn on(stage: &'a Stage, scene: &'a Scene, view: &View, settings: &Settings) -> Painter<'a> {
        let show = settings.show;
        let samples = view.size()[0] as usize * view.size()[1] as usize;
        let counted = matches!(show, Show::Overdraw | Show::Order);
        let tone = Tone::of(&stage.lamps, scene.sector_of(view), settings.exposure);
        Painter {
            scene,
            stage,
            settings: *settings,
            size: view.size(),
            pixels: vec![UNPAINTED; samples],
            counts: vec![0; if counted { samples } else { 0 }],
            cover: (show == Show::Cover).then(|| CoverPicture::new(view.size())),
            sky: Sky::new(view),
            sector: SectorId(0),
            rays: Rays::default(),
            near: Vec::new(),
            daylight: Daylight::of(&stage.lamps, SectorId(0), settings.exposure, &tone),
            tone,
            shines: vec![false; stage.lamps.lights],
            pending: Pending::default(),
            shaded: 0,
            others: None,
            passage: 0,
            over_surfaces: match show {
                Show::Image => directions(settings.ambient_occlusion),
                _ => Vec::new(),
            },
            shadows: None,
        }
    }

    /// Keeps every `of`-th of the rays of ambient occlusion, from the one numbered `part` on.
    pub(crate) fn with_part_of_rays(mut self, part: usize, of: usize) -> Painter<'a> {
        let rays = std::mem::take(&mut self.over_surfaces);
        // At least one ray.
        let first = part.min(rays.len().saturating_sub(1));
        self.over_surfaces = rays.into_iter().skip(first).step_by(of).collect();
        self
    }

    /// Lets lights cast shadows in a picture of [`Show::Image`]. `visible` is the set of a look of the same view.
    #[must_use]
    pub fn with_shadows(mut self, visible: &VisibleSet) -> Painter<'a> {
        let is_lit = self.settings.show == Show::Image;
        self.shadows = is_lit.then(|| Shadows::of(self.scene, visible));
        self
    }

    /// Shares shaded colours with the pixels' previous samples.
    pub(crate) fn beside(mut self, others: SampleCache) -> Painter<'a> {
        self.others = Some(others);
        self
    }

    /// Returns the pixels with the sky filled in, the colours shown before any blending, and the statistics.
    pub(crate) fn finish_samples(mut self) -> (Vec<Pixel>, SampleCache, Picture) {
        self.flush();
        pixels::fill(&mut self.pixels, self.size, &self.sky);
        let (pixels, others) = (
            std::mem::take(&mut self.pixels),
            self.others.take().unwrap_or_default(),
        );
        let picture = self.picture(RgbImage::default());
        (pixels, others, picture)
    }

    /// Fills the unpainted pixels with sky and returns the picture.
    pub fn finish(mut self) -> Picture {
        self.flush();
        let greatest = self.counts.iter().copied().max().unwrap_or(0).max(1) as f32;
        for (at, &count) in self.pixels.iter_mut().zip(&self.counts) {
            *at = pixel(Vec3::from(match self.settings.show {
                Show::Overdraw => heat(count as f32 / 16.0),
                _ if count == 0 => [0.007; 3],
                _ => rainbow(count as f32 / greatest),
            }));
        }
        let image = match self.cover.take() {
            Some(cover) => cover.into_image(),
            None => {
                pixels::fill(&mut self.pixels, self.size, &self.sky);
                pixels::image(&self.pixels, self.size)
            }
        };
        self.picture(image)
    }

    fn picture(&self, image: RgbImage) -> Picture {
        Picture {
            image,
            lights_shining: self.shines.iter().filter(|&&shines| shines).count(),
            shaded: self.shaded,
        }
    }

    /// Shades all pending spans: first the faces, then in parallel the samples of each band of rows, in order of
    /// arrival.
    fn flush(&mut self) {
        let mut pending = std::mem::take(&mut self.pending);
        if !pending.is_empty() {
            let ambient = Ambient::new(self.scene, self.sector, self.rays.eye, &self.over_surfaces);
            let light = Illumination {
                ambient: (!self.over_surfaces.is_empty()).then_some(&ambient),
                rays: &self.rays,
                lights: &self.near,
                daylight: &self.daylight,
                tone: &self.tone,
            };
            let one = |&owner: &Owner| self.paint_of(owner, &light);
            let few = pending.samples() < FEW_SAMPLES;
            let paints: Vec<Paint> = if few {
                pending.owners().iter().map(one).collect()
            } else {
                pending.owners().par_iter().with_min_len(64).map(one).collect()
            };
            let width = self.size[0] as usize;
            pending.sort(self.size[1] as usize, BAND);
            let shadows = self.shadows.as_ref().map(|shadows| {
                let of = (self.scene, self.stage);
                shadows.on(of, &light, &paints, &pending)
            });
            let work = Work {
                shadows: shadows.as_deref(),
                light: &light,
                paints: &paints,
                pending: &pending,
                width,
                sky: &self.sky,
                passage: self.passage,
            };
            let pixels = self.pixels.par_chunks_mut(BAND * width);
            let jobs = pixels.zip(pending.bands()).enumerate();
            let shaded = match &mut self.others {
                None => jobs
                    .with_min_len(if few { usize::MAX } else { 1 })
                    .map(|(band, (pixels, spans))| work.shade(band, pixels, spans, None))
                    .sum::<u64>(),
                Some(others) => {
                    let (number, known) = others.bands(BAND * width);
                    jobs.zip(known)
                        .map(|((band, (pixels, spans)), known)| {
                            work.shade(band, pixels, spans, Some((number, known)))
                        })
                        .sum()
                }
            };
            self.shaded += shaded;
        }
        pending.clear();
        self.pending = pending;
    }

    /// Computes how a face or a closed opening looks through the current passage.
    fn paint_of(&self, owner: Owner, light: &Illumination) -> Paint<'a> {
        let Owner::Face(item, face) = owner else {
            return Paint::Plain(Shade {
                color: CLOSED.into(),
                coverage: 1.0,
            });
        };
        let surface = self.scene.sector(self.sector).surface(item, face);
        let coverage = if surface.alpha == Alpha::Blend {
            surface.color[3]
        } else {
            1.0
        };
        let plain = |color: [f32; 3]| {
            Paint::Plain(Shade {
                color: color.into(),
                coverage,
            })
        };
        match self.settings.show {
            Show::Items => plain(distinct(u64::from(self.sector.0) << 32 | u64::from(item.0))),
            Show::Sectors => {
                let seen = Face::plain(&surface, light.rays);
                let lit = light.daylight.at(seen.normal, light.rays.back);
                plain((lit * Vec3::from(distinct(u64::from(self.sector.0)))).into())
            }
            _ => {
                let made = match self.scene.geometry(self.sector) {
                    Some(geometry) => {
                        let of = (&**geometry, self.stage);
                        Face::of_geometry(of, (item, face), &surface, light.rays, light.lights)
                    }
                    None => Face::plain(&surface, light.rays),
                };
                if made.is_plain() && light.ambient.is_none() {
                    Paint::Plain(Row::new(&made, light, 0).at(0))
                } else {
                    Paint::Varied(Box::new(made))
                }
            }
        }
    }
}

/// Shading of a face: constant, or varying from sample to sample.
pub(crate) enum Paint<'s> {
    Plain(Shade),
    Varied(Box<Face<'s>>),
}

/// State shared by the threads that shade.
struct Work<'a, 's> {
    /// By band.
    shadows: Option<&'a [BandShadows]>,
    light: &'a Illumination<'a>,
    paints: &'a [Paint<'s>],
    pending: &'a Pending,
    width: usize,
    sky: &'a Sky,
    passage: u64,
}

impl Work<'_, '_> {
    /// Shades the spans of one band of rows; returns the number of shaded samples of opaque faces.
    fn shade(
        &self,
        band: usize,
        pixels: &mut [Pixel],
        spans: &[PendingSpan],
        mut others: Option<(usize, &mut [PixelCache])>,
    ) -> u64 {
        let (mut shaded, mut sample) = (0, 0);
        let shadows = self.shadows.map(|bands| &bands[band]);
        for span in spans {
            let y = usize::from(span.y);
            let start = (y - band * BAND) * self.width;
            let run = start + usize::from(span.x0)..start + usize::from(span.x1);
            let first = sample;
            sample += run.len();
            let behind = |x: u16| self.sky.at([usize::from(x), y]);
            let at = (span.x0..).zip(pixels[run.clone()].iter_mut());
            let opaque = !span.see_through;
            let length = if opaque { run.len() as u64 } else { 0 };
            match &self.paints[span.owner as usize] {
                Paint::Plain(shade) if shade.coverage >= 1.0 => {
                    pixels[run].fill(pixel(shade.color));
                    shaded += length;
                }
                Paint::Plain(shade) => at.for_each(|(x, at)| put(at, *shade, || behind(x))),
                Paint::Varied(face) => {
                    let row = Row::new(face, self.light, span.y).with_shadows(shadows, span.x0, first);
                    match &mut others {
                        Some((number, known)) if opaque => {
                            let name = name(self.passage, self.pending.owners()[span.owner as usize]);
                            for ((x, at), known) in at.zip(&mut known[run]) {
                                let shown = known.of(name).unwrap_or_else(|| {
                                    shaded += 1;
                                    pixel(row.at(x).color)
                                });
                                known.keep(*number, name, shown);
                                *at = shown;
                            }
                        }
                        _ => {
                            match SmoothRow::of(face, self.light, span.y) {
                                Some(smooth) => smooth.paint(span.x0, &mut pixels[run]),
                                None => at.for_each(|(x, at)| put(at, row.at(x), || behind(x))),
                            }
                            shaded += length;
                        }
                    }
                }
            }
        }
        shaded
    }
}

/// Returns a hash of a face in a passage; two faces collide with probability 2⁻⁶⁴.
fn name(passage: u64, owner: Owner) -> u64 {
    let [high, low] = match owner {
        Owner::Face(item, face) => [item.0, face],
        Owner::Opening(opening) => [u32::MAX, u32::from(opening.0)],
    };
    mix(passage ^ mix(u64::from(high) << 32 | u64::from(low)))
}

fn mix(name: u64) -> u64 {
    let name = (name ^ name >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let name = (name ^ name >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    name ^ name >> 31
}

impl Canvas for Painter<'_> {
    fn enter(&mut self, _id: PassageId, passage: &Passage) {
        self.flush();
        self.sector = passage.sector;
        if let Some(cover) = &mut self.cover {
            let method = self.scene.method(passage.sector);
            return cover.enter(method.and_then(Method::cover_shape));
        }
        self.rays = Rays::new(passage);
        let exposure = self.settings.exposure;
        self.daylight = Daylight::of(&self.stage.lamps, passage.sector, exposure, &self.tone);
        self.near.clear();
        if self.settings.show == Show::Image {
            for (light, near) in self.stage.lamps.near(passage) {
                self.shines[light] = true;
                self.near.push(near);
            }
        }
        let columns = passage.eye_from_sector().columns();
        let bits = columns.iter().flatten().map(|value| u64::from(value.to_bits()));
        self.passage = bits.fold(u64::from(passage.sector.0), |name, bits| mix(name ^ bits));
    }

    fn row(&mut self, y: u16, spans: &[Span]) {
        if self.cover.is_some() || !self.counts.is_empty() {
            return;
        }
        for span in spans {
            if self.pending.is_full(self.shadows.is_some()) {
                self.flush();
            }
            self.pending.push(y, span);
        }
    }

    fn wants_work(&self) -> bool {
        !self.counts.is_empty()
    }

    fn work(&mut self, y: u16, x0: u16, tested: &[u16], batch: &[u32]) {
        let start = usize::from(y) * self.size[0] as usize + usize::from(x0);
        for (i, count) in self.counts[start..start + tested.len()].iter_mut().enumerate() {
            if self.settings.show == Show::Overdraw {
                *count += u32::from(tested[i]);
            } else if batch[i] > 0 {
                *count = batch[i];
            }
        }
    }

    fn wants_cover(&self) -> bool {
        self.cover.is_some()
    }

    fn cover(&mut self, y: u16, spans: &[CoverSpan]) {
        if let Some(cover) = &mut self.cover {
            cover.row(y, spans);
        }
    }
}
