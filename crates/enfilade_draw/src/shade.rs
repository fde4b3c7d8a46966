//! The light that samples of a face send to the eye, one after another along a row.

use crate::face::{Along, Face, Rays, Varying};
use crate::lamps::Near;
use crate::light::{Daylight, Tone};
use glam::Vec3;

/// What shines on what a passage shows.
pub(crate) struct Illumination<'a> {
    pub(crate) rays: &'a Rays,
    pub(crate) lights: &'a [Near],
    pub(crate) daylight: &'a Daylight,
    pub(crate) tone: &'a Tone,
}

/// What is shown of a sample: red, green and blue, linear, from 0 to 1, and how much of what is behind it is covered.
#[derive(Clone, Copy)]
pub(crate) struct Shade {
    pub(crate) color: Vec3,
    pub(crate) coverage: f32,
}

/// A face along one row.
pub(crate) struct Row<'a, 's> {
    face: &'a Face<'s>,
    light: &'a Illumination<'a>,
    y: u16,
    facing: Along,
    place: [Along; 2],
    normals: [Along; 3],
    colors: [Along; 4],
}

impl<'a, 's> Row<'a, 's> {
    pub(crate) fn new(face: &'a Face<'s>, light: &'a Illumination<'a>, y: u16) -> Row<'a, 's> {
        let row = |varying: &Varying| varying.over.row(y);
        Row {
            face,
            light,
            y,
            facing: face.facing.row(y),
            place: face
                .place
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

    /// What is shown at a column.
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
        if let Some(varying) = &face.place {
            let (place, stretch) = self.texture_place(varying, x, per_facing);
            if let Some(texture) = face.texture {
                let texel = texture.at(place, stretch.square(texture.size()));
                (r, g, b, coverage) = (r * texel.x, g * texel.y, b * texel.z, coverage * texel.w);
            }
            if let Some(glow) = face.glow {
                emission *= glow.at(place, stretch.square(glow.size())).truncate();
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

    /// What a white surface would send to the eye.
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
        if !face.lights.is_empty() {
            let point = light.rays.direction([x, self.y]) * (face.off * per_facing);
            let lamps: Vec3 = (face.lights.iter())
                .map(|&(number, narrowed)| light.lights[usize::from(number)].at(point, normal, narrowed))
                .sum();
            sum += lamps * light.tone.exposure;
        }
        sum
    }

    /// Where in its texture a sample is, and how that changes from sample to sample.
    #[inline]
    fn texture_place(&self, varying: &[Varying; 2], x: u16, per_facing: f32) -> ([f32; 2], Stretch) {
        let mut place = [0.0; 2];
        let mut stretch = Stretch::default();
        for axis in 0..2 {
            let over = &self.place[axis];
            let quotient = over.at(f32::from(x)) * per_facing;
            place[axis] = sound(varying[axis].base + quotient);
            stretch.right[axis] = (over.right - quotient * self.facing.right) * per_facing;
            stretch.down[axis] = (over.down - quotient * self.facing.down) * per_facing;
        }
        (place, stretch)
    }
}

/// By how much a place in a texture changes to the next sample on the right, and below.
#[derive(Clone, Copy, Default)]
struct Stretch {
    right: [f32; 2],
    down: [f32; 2],
}

impl Stretch {
    /// The square of how many texels of a texture a sample is wide, where it is wider.
    #[inline]
    fn square(&self, [width, height]: [f32; 2]) -> f32 {
        let square = |[u, v]: [f32; 2]| (u * width) * (u * width) + (v * height) * (v * height);
        square(self.right).max(square(self.down))
    }
}

/// A number, or 0 for what is none: a face seen all but edge-on may give one that is not.
#[inline]
fn sound(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}
