//! The light of a scene's lamps, in every fragment that it reaches through openings.

use enfilade::{Aabb, FragmentId, Light, LightId, Limits, Passage, Reached, Scene, Surface};
use glam::{DVec3, Vec3};

/// Fragments that one lamp is followed into at most: two mirrors face to face would go on for ever.
const MOST_REACHED: u32 = 4096;
/// Portals in a row that light goes through.
const MOST_CROSSED: u16 = 8;

/// Where lamps of a scene shine, and which of them shine on what is seen. None, for pictures without light.
#[derive(Default)]
pub(crate) struct Lamps {
    /// Fragment after fragment.
    all: Vec<Lamp>,
    /// Those that may shine on what the passage at hand shows, by their places.
    here: Vec<usize>,
    /// Of each light, does it shine on anything seen?
    shines: Vec<bool>,
}

/// A lamp as it is seen from a fragment that it shines into.
struct Lamp {
    light: usize,
    lamp: Light,
    reached: Reached,
    /// Lengths in the fragment for one where the lamp hangs.
    scale: f64,
}

impl Lamps {
    /// Those of a scene.
    pub(crate) fn of(scene: &Scene) -> Lamps {
        let mut limits = Limits::default();
        limits.max_crossings = MOST_CROSSED;
        limits.max_passages = MOST_REACHED;
        let lights = scene.lights().iter().enumerate();
        let mut all: Vec<Lamp> = lights
            .flat_map(|(light, &lamp)| {
                let reached = scene.light_reach(LightId(light as u32), &limits).into_iter();
                reached.map(move |reached| Lamp {
                    light,
                    lamp,
                    scale: reached.there_from_here.scale(),
                    reached,
                })
            })
            .collect();
        all.sort_by_key(|lamp| lamp.reached.fragment);
        Lamps {
            all,
            here: Vec::new(),
            shines: vec![false; scene.lights().len()],
        }
    }

    /// Are there none at all?
    pub(crate) fn is_empty(&self) -> bool {
        self.shines.is_empty()
    }

    /// How many lights shine on something that was seen.
    pub(crate) fn shining(&self) -> usize {
        self.shines.iter().filter(|&&shines| shines).count()
    }

    /// A passage comes: leaves out the lamps that shine on nothing it shows.
    pub(crate) fn enter(&mut self, passage: &Passage) {
        let first = self
            .all
            .partition_point(|lamp| lamp.reached.fragment < passage.fragment);
        let in_fragment = |fragment: FragmentId| fragment == passage.fragment;
        self.here.clear();
        for (number, lamp) in (first..).zip(&self.all[first..]) {
            if !in_fragment(lamp.reached.fragment) {
                break;
            }
            let range = f64::from(lamp.lamp.range) * lamp.scale;
            let bounds = Aabb {
                min: lamp.reached.origin.map(|value| (value - range) as f32),
                max: lamp.reached.origin.map(|value| (value + range) as f32),
            };
            if passage.may_show(&bounds) {
                self.here.push(number);
                self.shines[lamp.light] = true;
            }
        }
    }

    /// Does any lamp shine on what the passage at hand shows?
    pub(crate) fn any_here(&self) -> bool {
        !self.here.is_empty()
    }

    /// What the lamps add to a point of a surface, whose normal is turned to the eye: linear light, sent back by it.
    pub(crate) fn at(&self, point: DVec3, normal: Vec3, surface: &Surface) -> Vec3 {
        let normal = normal.as_dvec3();
        let [r, g, b, _] = surface.color;
        let mut sum = Vec3::ZERO;
        for &number in &self.here {
            let lamp = &self.all[number];
            let to_lamp = DVec3::from(lamp.reached.origin) - point;
            let facing = normal.dot(to_lamp);
            let distance = to_lamp.length();
            if facing <= 0.0 || distance >= f64::from(lamp.lamp.range) * lamp.scale {
                continue;
            }
            if lamp.reached.holds(point.into()) {
                let strength = lamp.lamp.falloff(distance / lamp.scale) * facing / distance;
                sum += Vec3::from(lamp.lamp.color) * strength as f32;
            }
        }
        sum * Vec3::new(r, g, b)
    }
}
