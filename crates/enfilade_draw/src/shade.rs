//! Shading of samples along one row of a face.

use crate::ambient::Ambient;
use crate::face::{Face, LinearRow, Rays, Varying};
use crate::lamps::{CutBy, PassageLight};
use crate::light::{Daylight, Tone};
use crate::shadows::BandShadows;
use glam::Vec3;

/// The light of one passage.
pub(crate) struct Illumination<'a> {
    pub(crate) rays: &'a Rays,
    pub(crate) lights: &'a [PassageLight],
    pub(crate) daylight: &'a Daylight,
    pub(crate) ambient: Option<&'a Ambient<'a>>,
    pub(crate) tone: &'a Tone,
}

/// Result of shading: displayed linear RGB, 0 to 1, and coverage (alpha).
#[derive(Clone, Copy)]
pub(crate) struct Shade {
    pub(crate) color: Vec3,
    pub(crate) coverage: f32,
}

/// A face along one row of samples.
pub(crate) struct Row<'a, 's> {
    face: &'a Face<'s>,
    light: &'a Illumination<'a>,
    y: u16,
    /// Where shadows fall, and the place of the sample at column 0 among those of the band; it may be negative.
    shadows: Option<(&'a BandShadows, isize)>,
    facing: LinearRow,
    uv: [LinearRow; 2],
    normals: [LinearRow; 3],
    colors: [LinearRow; 4],
}

impl<'a, 's> Row<'a, 's> {
    pub(crate) fn new(face: &'a Face<'s>, light: &'a Illumination<'a>, y: u16) -> Row<'a, 's> {
        let row = |varying: &Varying| varying.over.row(y);
        Row {
            face,
            light,
            y,
            shadows: None,
            facing: face.facing.row(y),
            uv: face
                .uv
                .as_ref()
                .map_or_else(Default::default, |of| [row(&of[0]), row(&of[1])]),
            normals: face
                .normals
                .as_ref()
                .map_or_else(Default::default, |of| [row(&of[0]), row(&of[1]), row(&of[2])]),
            colors: face.colors.as_ref().map_or_else(Default::default, |of| {
                [row(&of[0]), row(&of[1]), row(&of[2]), row(&of[3])]
            }),
        }
    }

    /// Lets shadows fall on the row. `sample` is the place of the sample at column `x0` among those of the band.
    pub(crate) fn with_shadows(
        self,
        shadows: Option<&'a BandShadows>,
        x0: u16,
        sample: usize,
    ) -> Row<'a, 's> {
        Row {
            shadows: shadows.map(|shadows| (shadows, sample as isize - x0 as isize)),
            ..self
        }
    }

    /// Whether the sample at a column is in the shadow of a light.
    #[inline]
    fn is_dark(&self, light: u16, x: u16) -> bool {
        let sample = |start: isize| (start + x as isize) as usize;
        self.shadows
            .is_some_and(|(shadows, start)| shadows.has(light, sample(start)))
    }

    /// Shades the sample at a column.
    #[inline]
    pub(crate) fn at(&self, x: u16) -> Shade {
        let face = self.face;
        let column = f32::from(x);
        let per_facing = 1.0 / self.facing.at(column);
        let [mut r, mut g, mut b, mut coverage] = face.color;
        let mut emission = face.emission;
        if let Some(varying) = &face.colors {
            let channel = |i: usize| varying[i].base + self.colors[i].at(column) * per_facing;
            let [vr, vg, vb, va] = [0, 1, 2, 3].map(channel).map(sound);
            (r, g, b, coverage) = (r * vr, g * vg, b * vb, coverage * va);
        }
        if let Some(varying) = &face.uv {
            let (uv, stretch) = self.texture_uv(varying, x, per_facing);
            if let Some(texture) = face.texture {
                let texel = texture.at(uv, stretch.square(texture.size()));
                (r, g, b, coverage) = (r * texel.x, g * texel.y, b * texel.z, coverage * texel.w);
            }
            if let Some(glow) = face.glow {
                emission *= glow.at(uv, stretch.square(glow.size())).truncate();
            }
        }
        let own = Vec3::new(r, g, b);
        let color = if face.unlit {
            own
        } else {
            let lit = self.light.tone;
            lit.shown(own * self.illuminated(x, per_facing) + emission)
        };
        Shade {
            color,
            coverage: match face.cutoff {
                Some(cutoff) if coverage < cutoff => 0.0,
                _ if face.glass => coverage.clamp(0.0, 1.0),
                _ => 1.0,
            },
        }
    }

    /// Returns the light that a white surface would reflect towards the eye.
    #[inline]
    fn illuminated(&self, x: u16, per_facing: f32) -> Vec3 {
        let face = self.face;
        let normal = match &face.normals {
            None => face.normal,
            Some(varying) => {
                let axis = |i: usize| varying[i].base + self.normals[i].at(f32::from(x)) * per_facing;
                let bent = Vec3::new(axis(0), axis(1), axis(2)).normalize_or_zero();
                if bent == Vec3::ZERO { face.normal } else { bent }
            }
        };
        let light = self.light;
        let mut sum = light.daylight.at(normal, light.rays.back);
        let slopes = [self.facing.right, self.facing.down];
        if let Some(ambient) = light.ambient {
            let (point, _) = light.rays.point(face, [x, self.y], per_facing, slopes);
            sum *= ambient.at(point, face.normal);
        }
        if !face.lights.is_empty() {
            let (point, steps) = light.rays.point(face, [x, self.y], per_facing, slopes);
            let at = |&(number, cut): &(u16, CutBy)| {
                if self.is_dark(number, x) {
                    return Vec3::ZERO;
                }
                light.lights[usize::from(number)].at(point, normal, cut, steps)
            };
            let lamps: Vec3 = face.lights.iter().map(at).sum();
            sum += lamps * light.tone.exposure;
        }
        sum
    }

    /// Returns a sample's texture coordinates and their screen-space derivatives.
    #[inline]
    fn texture_uv(&self, varying: &[Varying; 2], x: u16, per_facing: f32) -> ([f32; 2], Stretch) {
        let mut uv = [0.0; 2];
        let mut stretch = Stretch::default();
        for axis in 0..2 {
            let over = &self.uv[axis];
            let quotient = over.at(f32::from(x)) * per_facing;
            uv[axis] = sound(varying[axis].base + quotient);
            stretch.right[axis] = (over.right - quotient * self.facing.right) * per_facing;
            stretch.down[axis] = (over.down - quotient * self.facing.down) * per_facing;
        }
        (uv, stretch)
    }
}

/// Screen-space derivatives of texture coordinates, per column and per row.
#[derive(Clone, Copy, Default)]
struct Stretch {
    right: [f32; 2],
    down: [f32; 2],
}

impl Stretch {
    /// Returns the squared footprint of a sample in texels, along the longer derivative.
    #[inline]
    fn square(&self, [width, height]: [f32; 2]) -> f32 {
        let square = |[u, v]: [f32; 2]| (u * width) * (u * width) + (v * height) * (v * height);
        square(self.right).max(square(self.down))
    }
}

/// Returns 0 for NaN and infinities, which a face seen edge-on may produce.
#[inline]
fn sound(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}
