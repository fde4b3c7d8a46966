//! A canvas that is a picture.

use crate::cover::CoverPicture;
use crate::lamps::Lamps;
use crate::light::{Eye, lit, sky, turned_to};
use crate::palette::{decode, distinct, encode, heat, rainbow};
use crate::show::Show;
use enfilade::{
    Alpha, Canvas, CoverSpan, FragmentId, Method, Owner, Passage, PassageId, Scene, Span, Surface, Transform,
    View,
};
use glam::{DVec3, Vec3};
use image::RgbImage;

/// A picture of what [`Viewer::draw`](enfilade::Viewer::draw) sees.
///
/// Faces are shaded once for each passage; where a lamp may shine on them, once for each sample.
pub struct Painter<'a> {
    scene: &'a Scene,
    show: Show,
    size: [u32; 2],
    /// sRGB, and 255 where painted; where not, the sky shows.
    pixels: Vec<[u8; 4]>,
    /// What [`Canvas::work`] counted; empty unless it is shown.
    counts: Vec<u32>,
    /// What [`Canvas::cover`] told, if that is shown.
    cover: Option<CoverPicture>,
    sky: Sky,
    fragment: FragmentId,
    eye: Eye,
    lamps: Lamps,
    rays: Rays,
    shades: Vec<Shade>,
}

/// The colour of a face through the passage at hand.
#[derive(Clone, Copy)]
struct Shade {
    owner: Option<Owner>,
    color: [f32; 3],
    bytes: [u8; 4],
    coverage: f32,
    /// What lamps shine on, and the normal of the side that is seen.
    lit: Option<(Surface, Vec3)>,
}

/// Colours kept, by a hash of the face: a face is met again in its next row.
const SHADES: usize = 1 << 12;
const NO_SHADE: Shade = Shade {
    owner: None,
    color: [0.0; 3],
    bytes: [0; 4],
    coverage: 1.0,
    lit: None,
};
/// What is seen where an opening is closed, or no longer followed.
const CLOSED: [f32; 3] = [0.10, 0.07, 0.05];

impl<'a> Painter<'a> {
    /// An empty picture of the view's size.
    pub fn new(scene: &'a Scene, view: &View, show: Show) -> Painter<'a> {
        let samples = view.size[0] as usize * view.size[1] as usize;
        let counts = if matches!(show, Show::Overdraw | Show::Order) {
            samples
        } else {
            0
        };
        Painter {
            scene,
            show,
            size: view.size,
            pixels: vec![[0; 4]; samples],
            counts: vec![0; counts],
            cover: (show == Show::Cover).then(|| CoverPicture::new(view.size)),
            sky: Sky::new(view),
            fragment: FragmentId(0),
            eye: Eye::default(),
            lamps: if show == Show::Image {
                Lamps::of(scene)
            } else {
                Lamps::default()
            },
            rays: Rays::default(),
            shades: vec![NO_SHADE; SHADES],
        }
    }

    /// Paints the sky where nothing else was, and gives the picture.
    pub fn into_image(mut self) -> RgbImage {
        if let Some(cover) = self.cover {
            return cover.into_image();
        }
        let greatest = self.counts.iter().copied().max().unwrap_or(0).max(1) as f32;
        let count_color = |count: u32| match self.show {
            Show::Overdraw => encode(heat(count as f32 / 16.0)),
            _ if count == 0 => [20; 3],
            _ => encode(rainbow(count as f32 / greatest)),
        };
        for (pixel, &count) in self.pixels.iter_mut().zip(&self.counts) {
            let [r, g, b] = count_color(count);
            *pixel = [r, g, b, 255];
        }
        let mut image = RgbImage::new(self.size[0], self.size[1]);
        for (i, (pixel, target)) in self.pixels.iter().zip(image.pixels_mut()).enumerate() {
            let [r, g, b, painted] = *pixel;
            target.0 = if painted > 0 {
                [r, g, b]
            } else {
                self.sky.at(i, self.size[0])
            };
        }
        image
    }

    /// How many of the scene's lights shine on something that was seen; the others cost nothing. Only [`Show::Image`] has
    /// light.
    pub fn lights_shining(&self) -> usize {
        self.lamps.shining()
    }

    fn start(&self, y: u16, x: u16) -> usize {
        usize::from(y) * self.size[0] as usize + usize::from(x)
    }

    fn shade(&mut self, owner: Owner) -> Shade {
        let slot = match owner {
            Owner::Face(item, face) => item.0.wrapping_mul(0x9E37_79B1).wrapping_add(face) as usize % SHADES,
            Owner::Opening(_) => 0,
        };
        if self.shades[slot].owner != Some(owner) {
            let (color, coverage) = self.color(owner);
            let [r, g, b] = encode(color);
            let lit = match owner {
                Owner::Face(item, face) if self.lamps.any_here() => {
                    let surface = self.scene.fragment(self.fragment).surface(item, face);
                    Some((surface, turned_to(&self.eye, &surface)))
                }
                _ => None,
            };
            self.shades[slot] = Shade {
                owner: Some(owner),
                color,
                bytes: [r, g, b, 255],
                coverage,
                lit,
            };
        }
        self.shades[slot]
    }

    fn color(&self, owner: Owner) -> ([f32; 3], f32) {
        let Owner::Face(item, face) = owner else {
            return (CLOSED, 1.0);
        };
        let surface = self.scene.fragment(self.fragment).surface(item, face);
        // A cut-out has no texture here, so it is painted whole.
        let coverage = if surface.alpha == Alpha::Blend {
            surface.color[3]
        } else {
            1.0
        };
        match self.show {
            Show::Items => (
                distinct(u64::from(self.fragment.0) << 32 | u64::from(item.0)),
                coverage,
            ),
            Show::Fragments => {
                let [r, g, b] = distinct(u64::from(self.fragment.0));
                (
                    lit(
                        &Surface {
                            color: [r, g, b, 1.0],
                            ..surface
                        },
                        &self.eye,
                    ),
                    coverage,
                )
            }
            _ => (self.by_daylight(&surface), coverage),
        }
    }

    /// Lamps would be lost in the sun: where there are any, it is evening.
    fn by_daylight(&self, surface: &Surface) -> [f32; 3] {
        const EVENING: f32 = 0.4;
        let part = if self.lamps.is_empty() { 1.0 } else { EVENING };
        lit(surface, &self.eye).map(|value| value * part)
    }

    /// Paints one sample, over what is there if it is glass.
    fn paint(&mut self, i: usize, color: [f32; 3], coverage: f32) {
        let color = if coverage < 1.0 {
            let [r, g, b, painted] = self.pixels[i];
            let behind = decode(if painted > 0 {
                [r, g, b]
            } else {
                self.sky.at(i, self.size[0])
            });
            std::array::from_fn(|c| behind[c] * (1.0 - coverage) + color[c] * coverage)
        } else {
            color
        };
        let [r, g, b] = encode(color);
        self.pixels[i] = [r, g, b, 255];
    }

    /// The colour of a sample of a face that lamps may shine on.
    fn by_lamplight(&self, [x, y]: [u16; 2], shade: &Shade, (surface, normal): &(Surface, Vec3)) -> [f32; 3] {
        let point = self.rays.meet([x, y], surface, *normal);
        (Vec3::from(shade.color) + self.lamps.at(point, *normal, surface)).into()
    }
}

/// Where the passage at hand sees samples: from an eye, in a direction that grows by the same from each to the next.
#[derive(Default)]
struct Rays {
    eye: DVec3,
    corner: DVec3,
    right: DVec3,
    down: DVec3,
}

impl Rays {
    fn new(passage: &Passage) -> Rays {
        let direction = |at| DVec3::from(passage.ray(at)[1]);
        let corner = direction([0.5, 0.5]);
        Rays {
            eye: passage.ray([0.5, 0.5])[0].into(),
            corner,
            right: direction([1.5, 0.5]) - corner,
            down: direction([0.5, 1.5]) - corner,
        }
    }

    /// Where the ray of a sample meets the plane of a surface.
    fn meet(&self, [x, y]: [u16; 2], surface: &Surface, normal: Vec3) -> DVec3 {
        let direction = self.corner + self.right * f64::from(x) + self.down * f64::from(y);
        let normal = normal.as_dvec3();
        let off = normal.dot(DVec3::from(surface.point.map(f64::from)) - self.eye);
        self.eye + direction * (off / normal.dot(direction))
    }
}

impl Canvas for Painter<'_> {
    fn enter(&mut self, _id: PassageId, passage: &Passage) {
        self.fragment = passage.fragment;
        if let Some(cover) = &mut self.cover {
            let method = self.scene.method(passage.fragment);
            return cover.enter(method.and_then(Method::cover_shape));
        }
        let fragment_from_eye = passage
            .eye_from_fragment()
            .inverse()
            .unwrap_or(Transform::IDENTITY);
        let back =
            DVec3::from(fragment_from_eye.direction([0.0, 0.0, 1.0]).map(f64::from)).normalize_or_zero();
        self.eye = Eye {
            at: passage.eye().into(),
            back,
        };
        self.rays = Rays::new(passage);
        self.lamps.enter(passage);
        self.shades.fill(NO_SHADE);
    }

    fn row(&mut self, y: u16, spans: &[Span]) {
        if self.cover.is_some() {
            return;
        }
        for span in spans {
            let run = self.start(y, span.x0)..self.start(y, span.x1);
            let shade = self.shade(span.owner);
            if let Some(lit) = &shade.lit {
                for (x, i) in (span.x0..).zip(run) {
                    let color = self.by_lamplight([x, y], &shade, lit);
                    self.paint(i, color, shade.coverage);
                }
            } else if shade.coverage >= 1.0 {
                self.pixels[run].fill(shade.bytes);
            } else {
                run.for_each(|i| self.paint(i, shade.color, shade.coverage));
            }
        }
    }

    fn wants_work(&self) -> bool {
        !self.counts.is_empty()
    }

    fn work(&mut self, y: u16, x0: u16, tested: &[u16], batch: &[u32]) {
        let start = self.start(y, x0);
        for (i, count) in self.counts[start..start + tested.len()].iter_mut().enumerate() {
            if self.show == Show::Overdraw {
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

/// Directions of samples, for what is behind everything.
struct Sky {
    corner: DVec3,
    right: DVec3,
    down: DVec3,
}

impl Sky {
    fn new(view: &View) -> Sky {
        let [eye, toward, up] = [view.eye, view.toward, view.up].map(|v| DVec3::from(v.map(f64::from)));
        let forward = (toward - eye).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(up).normalize_or(forward.any_orthonormal_vector());
        let down = forward.cross(right);
        let [width, height] = view.size.map(f64::from);
        let step = 2.0 * (0.5 * f64::from(view.fov_y)).tan() / height;
        let corner = forward + right * (step * 0.5 * (1.0 - width)) + down * (step * 0.5 * (1.0 - height));
        Sky {
            corner,
            right: right * step,
            down: down * step,
        }
    }

    fn at(&self, sample: usize, width: u32) -> [u8; 3] {
        let [x, y] = [sample % width as usize, sample / width as usize];
        encode(sky(self.corner + self.right * x as f64 + self.down * y as f64))
    }
}
