//! Lights of the palace: flames, spots on exhibits, and the sun.

use enfilade::{Light, LightShape, SectorId, Transform};
use glam::Vec3;

/// Maximum number of lamps per room, because each is evaluated at every visible sample.
pub(crate) const MAX_LAMPS: usize = 6;

/// Direction of sunlight: late afternoon, with the sun low in the south-west.
pub(crate) const SUNLIGHT: [f32; 3] = [0.78, -0.46, -0.34];

/// Color of candlelight, for a brightness of one.
const CANDLELIGHT: Vec3 = Vec3::new(1.0, 0.76, 0.48);

/// A light of a room under construction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lamp {
    position: [f32; 3],
    color: Vec3,
    range: f32,
    shape: LightShape,
}

impl Lamp {
    /// Candles at a position; `strength` is the light that a white wall one metre away reflects.
    pub(crate) fn candles(position: [f32; 3], strength: f32) -> Lamp {
        Lamp {
            position,
            color: CANDLELIGHT * strength,
            range: 5.0 + 2.5 * strength.sqrt(),
            shape: LightShape::Point,
        }
    }

    /// A fire.
    pub(crate) fn fire(position: [f32; 3]) -> Lamp {
        Lamp {
            color: Vec3::new(1.0, 0.42, 0.13) * 2.6,
            range: 7.0,
            ..Lamp::candles(position, 1.0)
        }
    }

    /// Daylight from all sides of a position.
    pub(crate) fn daylight(position: [f32; 3], color: [f32; 3], range: f32) -> Lamp {
        Lamp {
            color: color.into(),
            range,
            ..Lamp::candles(position, 1.0)
        }
    }

    /// A spot aimed at `target`.
    pub(crate) fn spot(position: [f32; 3], target: [f32; 3], strength: f32) -> Lamp {
        let direction = Vec3::from(target) - Vec3::from(position);
        Lamp {
            range: 4.0 * direction.length(),
            shape: LightShape::Spot {
                direction: direction.into(),
                inner: 0.16,
                outer: 0.52,
            },
            color: Vec3::new(1.0, 0.88, 0.70) * strength,
            position,
        }
    }

    /// The sun over a sector without a roof.
    pub(crate) fn sun(strength: f32) -> Lamp {
        Lamp::from_afar(SUNLIGHT, Vec3::new(1.0, 0.84, 0.60) * strength)
    }

    /// Sky light, from the direction opposite to the sun, so that it does not enter through the same windows as
    /// sunlight.
    pub(crate) fn sky(strength: f32) -> Lamp {
        let [x, y, z] = SUNLIGHT;
        Lamp::from_afar([-x, 1.5 * y, -z], Vec3::new(0.70, 0.86, 1.0) * strength)
    }

    fn from_afar(direction: [f32; 3], color: Vec3) -> Lamp {
        Lamp {
            position: [0.0; 3],
            color,
            range: f32::INFINITY,
            shape: LightShape::Sun { direction },
        }
    }

    /// Returns the lamp with its brightness multiplied by a factor.
    pub(crate) fn times(self, factor: f32) -> Lamp {
        Lamp {
            color: self.color * factor,
            ..self
        }
    }

    pub(crate) fn in_sector(self, sector: SectorId) -> Light {
        Light {
            sector,
            position: self.position,
            color: self.color.into(),
            range: self.range,
            shape: self.shape,
        }
    }
}

/// Returns the point at height `up` over the origin of a transform.
pub(crate) fn over(place: Transform, up: f32) -> [f32; 3] {
    place.point([0.0, up, 0.0])
}

/// Returns all required lamps, and as many candles as the limit allows: each time the one farthest from all others.
pub(super) fn chosen(lamps: Vec<Lamp>, candles: Vec<Lamp>) -> Vec<Lamp> {
    let mut chosen = lamps;
    let mut left = candles;
    let away = |lamp: &Lamp, all: &[Lamp]| {
        let squared = |other: &Lamp| Vec3::from(lamp.position).distance_squared(other.position.into());
        all.iter().map(squared).fold(f32::INFINITY, f32::min)
    };
    while chosen.len() < MAX_LAMPS && !left.is_empty() {
        let distances: Vec<f32> = left.iter().map(|lamp| away(lamp, &chosen)).collect();
        let farthest = (0..left.len())
            .reduce(|best, i| if distances[i] > distances[best] { i } else { best })
            .unwrap_or(0);
        chosen.push(left.remove(farthest));
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_candles_those_are_lit_that_are_far_apart() {
        let at = |x: f32| Lamp::candles([x, 0.0, 0.0], 1.0);
        let lamps = chosen(vec![at(0.0)], (1..=20).map(|i| at(i as f32)).collect());
        let xs: Vec<f32> = lamps.iter().map(|lamp| lamp.position[0]).collect();
        assert_eq!(xs, [0.0, 20.0, 10.0, 5.0, 15.0, 2.0]);
        assert_eq!(chosen(vec![at(0.0); 9], vec![at(1.0)]).len(), 9);
    }
}
