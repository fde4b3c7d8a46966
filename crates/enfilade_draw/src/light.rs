//! Ambient light: sun and sky in scenes without lights, indirect light in scenes with lights, and a weak headlight that
//! keeps the corners of closed rooms from looking flat.

use crate::lamps::Lamps;
use crate::lighting::AmbientLight;
use crate::stage::Exposure;
use enfilade::SectorId;
use glam::Vec3;

/// Direction to the sun, in the space of the current sector. It casts no shadows.
const SUN: Vec3 = Vec3::new(0.424, 0.755, 0.5);
const SUNLIGHT: Vec3 = Vec3::new(0.58, 0.53, 0.45);
const ZENITH: Vec3 = Vec3::new(0.36, 0.40, 0.48);
const GROUND: Vec3 = Vec3::new(0.20, 0.18, 0.16);
const FROM_THE_EYE: f32 = 0.22;

/// Ambient light of a sector, exposure applied.
#[derive(Clone, Copy)]
pub(crate) struct Daylight {
    sun: Vec3,
    above: Vec3,
    below: Vec3,
    from_the_eye: f32,
}

/// Exposure and tone mapping.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tone {
    /// Displayed value of one unit of a lamp's light.
    pub(crate) exposure: f32,
    /// Whether highlights are compressed instead of clipped.
    pub(crate) soft: bool,
}

impl Daylight {
    /// Returns the ambient light of a sector. With lamps and a fixed exposure it is at evening level, because full
    /// daylight would outshine them.
    pub(crate) fn of(lamps: &Lamps, sector: SectorId, exposure: Exposure, tone: &Tone) -> Daylight {
        const EVENING: f32 = 0.4;
        match exposure {
            _ if lamps.is_empty() => Daylight::day(1.0),
            Exposure::Fixed(_) => Daylight::day(EVENING),
            Exposure::Eye(_) => {
                let bounced = lamps.bounced(sector) * tone.exposure;
                Daylight {
                    sun: Vec3::ZERO,
                    above: bounced * Vec3::new(1.0, 1.05, 1.12),
                    below: bounced * Vec3::new(0.72, 0.66, 0.60),
                    from_the_eye: 0.05,
                }
            }
        }
    }

    /// Returns a part of full daylight.
    pub(crate) fn day(part: f32) -> Daylight {
        Daylight {
            sun: SUNLIGHT * part,
            above: ZENITH * part,
            below: GROUND * part,
            from_the_eye: FROM_THE_EYE * part,
        }
    }

    /// Returns it in plain numbers.
    pub(crate) fn plain(&self) -> AmbientLight {
        AmbientLight {
            above: self.above.into(),
            below: self.below.into(),
            sun: self.sun.into(),
            to_sun: SUN.into(),
            from_the_eye: self.from_the_eye,
        }
    }

    /// Returns the light that a white surface reflects towards the eye; `back` points to the eye.
    ///
    /// It depends on the normal but not on the position, so the triangles of a flat wall have one shade.
    #[inline]
    pub(crate) fn at(&self, normal: Vec3, back: Vec3) -> Vec3 {
        let upward = 0.5 + 0.5 * normal.y;
        let ambient = self.below * (1.0 - upward) + self.above * upward;
        ambient + self.sun * normal.dot(SUN).max(0.0) + self.from_the_eye * normal.dot(back).abs()
    }
}

impl Tone {
    /// Returns the exposure for a camera in `sector`.
    pub(crate) fn of(lamps: &Lamps, sector: Option<SectorId>, exposure: Exposure) -> Tone {
        /// Displayed value of a well-lit white surface.
        const LIT_WELL: f32 = 0.6;
        match (exposure, sector) {
            (Exposure::Fixed(exposure), _) => Tone {
                exposure,
                soft: false,
            },
            (Exposure::Eye(stops), Some(sector)) if !lamps.is_empty() => Tone {
                exposure: LIT_WELL / lamps.lit(sector) * stops.exp2(),
                soft: true,
            },
            _ => Tone {
                exposure: 1.0,
                soft: false,
            },
        }
    }

    /// Applies tone mapping: returns displayed values, 0 to 1 if highlights are compressed.
    #[inline]
    pub(crate) fn shown(&self, light: Vec3) -> Vec3 {
        /// Values up to this are unchanged.
        const TRUE: f32 = 0.6;
        if !self.soft || light.max_element() <= TRUE {
            return light;
        }
        let soft = |value: f32| {
            if value <= TRUE {
                value
            } else {
                TRUE + (1.0 - TRUE) * (1.0 - (-(value - TRUE) / (1.0 - TRUE)).exp())
            }
        };
        Vec3::new(soft(light.x), soft(light.y), soft(light.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_bright_grows_pale_and_never_passes_white_or_changes_places() {
        let tone = Tone {
            exposure: 1.0,
            soft: true,
        };
        let shown = |value: f32| tone.shown(Vec3::new(value, 0.1, 0.1)).x;
        assert_eq!(shown(0.5), 0.5);
        let mut last = 0.0;
        for step in 0..200 {
            let value = shown(0.05 * step as f32);
            assert!((last..=1.0).contains(&value), "{value} after {last}");
            last = value;
        }
    }
}
