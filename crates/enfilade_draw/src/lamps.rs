//! Where the light of a scene's lamps and suns goes: into which sectors, through which openings, and how much of it is
//! sent back there by walls.

use enfilade::{Aabb, Light, LightId, LightReach, LightShape, Limits, Passage, Ray, Scene, SectorId};
use glam::{DVec3, Vec3};

/// Sectors that one lamp is followed into at most: two mirrors face to face would go on for ever.
const MAX_REACHED: u32 = 4096;
/// Portals in a row that light goes through.
const MAX_CROSSED: u16 = 8;

/// Where the lights of a scene shine, and how bright it is in each sector.
pub(crate) struct Lamps {
    /// Sector after sector.
    all: Vec<Lamp>,
    /// By sector: what faces send back, and what eyes get used to.
    rooms: Vec<Brightness>,
    /// How many lights there are.
    pub(crate) lights: usize,
}

/// A light as it is seen from a sector that it shines into.
struct Lamp {
    light: usize,
    lamp: Light,
    reached: LightReach,
    /// Where the middle of its light goes, of unit length; zero of a point.
    onwards: DVec3,
    /// Lengths in the sector for one where the lamp hangs.
    scale: f64,
}

/// How bright it is in a sector.
#[derive(Clone, Copy, Default)]
struct Brightness {
    /// What surfaces get from others that are lit.
    bounced: Vec3,
    /// What a white surface that is lit as most are sends back, about.
    lit: f32,
    /// What one sends back that its nearest lamp lights.
    lit_best: f32,
}

/// A light as it shines on what one passage shows: places are seen from the passage's eye.
pub(crate) struct Near {
    at: Vec3,
    /// Towards a sun; zero for a lamp.
    to_sun: Vec3,
    onwards: Vec3,
    color: Vec3,
    /// Of a spot: what the cosine off its middle is multiplied by, and what is added, for the square root of its light.
    cone: Option<[f32; 2]>,
    /// Squares of lengths: one in the lamp's own space for one here; how far it shines, here; and there, and under how much
    /// of it light grows no more.
    per_square: f32,
    reach: f32,
    per_range_square: f32,
    nearest_square: f32,
    /// The beam holds points with n · x ≥ d for all.
    planes: Vec<(Vec3, f32)>,
}

impl Brightness {
    /// What an eye gets used to: pools of light must not be blinding, nor leave all else in the dark.
    fn used_to(&self) -> f32 {
        self.lit * (0.5 * self.lit_best / self.lit.max(f32::MIN_POSITIVE)).clamp(1.0, 1.5)
    }
}

impl Lamps {
    /// Those of a scene.
    pub(crate) fn of(scene: &Scene) -> Lamps {
        let mut limits = Limits::default();
        limits.max_crossings = MAX_CROSSED;
        limits.max_passages = MAX_REACHED;
        let mut all: Vec<Lamp> = Vec::new();
        let mut rooms = vec![Brightness::default(); scene.sectors().count()];
        for (light, lamp) in scene.lights().iter().enumerate() {
            let usual = usual_distance(scene, lamp);
            for reached in scene.light_reach(LightId(light as u32), &limits) {
                brighten(scene, &mut rooms, lamp, &reached, usual);
                let onwards = lamp
                    .direction()
                    .map_or([0.0; 3], |direction| reached.there_from_here.direction(direction));
                all.push(Lamp {
                    light,
                    lamp: *lamp,
                    onwards: DVec3::from(onwards.map(f64::from)).normalize_or_zero(),
                    scale: reached.there_from_here.scale(),
                    reached,
                });
            }
        }
        all.sort_by_key(|lamp| lamp.reached.sector);
        Lamps {
            all,
            rooms,
            lights: scene.lights().len(),
        }
    }

    /// Are there none at all?
    pub(crate) fn is_empty(&self) -> bool {
        self.lights == 0
    }

    /// What surfaces of a sector get from others that are lit, linear: some even in the darkest.
    pub(crate) fn bounced(&self, sector: SectorId) -> Vec3 {
        const LEAST: f32 = 0.05;
        let here = self.rooms.get(sector.0 as usize);
        here.map_or(Vec3::ZERO, |room| room.bounced) + Vec3::splat(LEAST * self.brightest())
    }

    /// What a white surface that is lit well sends back in a sector, about; above 0.
    pub(crate) fn lit(&self, sector: SectorId) -> f32 {
        const DARKEST: f32 = 0.1;
        let here = self.rooms.get(sector.0 as usize).map_or(0.0, Brightness::used_to);
        here.max(DARKEST * self.brightest()).max(f32::MIN_POSITIVE)
    }

    fn brightest(&self) -> f32 {
        self.rooms.iter().map(Brightness::used_to).fold(0.0, f32::max)
    }

    /// The lights that may shine on what a passage shows, each with its number.
    pub(crate) fn near<'a>(&'a self, passage: &'a Passage) -> impl Iterator<Item = (usize, Near)> + 'a {
        let first = self
            .all
            .partition_point(|lamp| lamp.reached.sector < passage.sector);
        let here = self.all[first..]
            .iter()
            .take_while(|lamp| lamp.reached.sector == passage.sector);
        let eye = DVec3::from(passage.eye());
        here.filter(|lamp| passage.may_show(&lamp.around()))
            .map(move |lamp| (lamp.light, lamp.near(eye)))
    }
}

impl Lamp {
    /// Lengths of the sector that it reaches.
    fn range(&self) -> f64 {
        match self.lamp.shape {
            LightShape::Sun { .. } => f64::INFINITY,
            _ => f64::from(self.lamp.range) * self.scale,
        }
    }

    /// The box that it shines in.
    fn around(&self) -> Aabb {
        // Numbers of this size still leave room to calculate.
        let range = self.range().min(1e30);
        Aabb {
            min: self.reached.origin.map(|value| (value - range) as f32),
            max: self.reached.origin.map(|value| (value + range) as f32),
        }
    }

    fn near(&self, eye: DVec3) -> Near {
        let at = DVec3::from(self.reached.origin) - eye;
        let is_sun = matches!(self.lamp.shape, LightShape::Sun { .. });
        let planes = self.reached.planes().map(|(normal, distance)| {
            let normal = DVec3::from(normal);
            (normal.as_vec3(), (distance - normal.dot(eye)) as f32)
        });
        Near {
            at: at.as_vec3(),
            to_sun: if is_sun {
                at.normalize_or_zero().as_vec3()
            } else {
                Vec3::ZERO
            },
            onwards: self.onwards.as_vec3(),
            color: self.lamp.color.into(),
            cone: match self.lamp.shape {
                LightShape::Spot { inner, outer, .. } => {
                    let steepness = 1.0 / (inner.cos() - outer.cos()).max(1e-3);
                    Some([steepness, -outer.cos() * steepness])
                }
                _ => None,
            },
            per_square: (1.0 / self.scale.powi(2)) as f32,
            reach: self.range() as f32,
            per_range_square: 1.0 / self.lamp.range.powi(2),
            nearest_square: (1.0 / self.lamp.falloff(0.0)) as f32,
            planes: planes.collect(),
        }
    }
}

impl Near {
    /// May it shine on a face with these corners, whose normal is turned to the eye? `None`: not at all. Else: must it be
    /// asked of each point whether the light comes through the openings so far?
    pub(crate) fn shines_on(&self, corners: &[Vec3], normal: Option<Vec3>) -> Option<bool> {
        let first = *corners.first()?;
        let to_light = if self.to_sun == Vec3::ZERO {
            self.at - first
        } else {
            self.to_sun
        };
        if normal.is_some_and(|normal| normal.dot(to_light) <= 0.0) {
            return None;
        }
        let radius = corners
            .iter()
            .fold(0.0_f32, |most, corner| most.max(corner.distance(first)));
        if self.to_sun == Vec3::ZERO && to_light.length() - radius >= self.reach {
            return None;
        }
        let mut narrowed = false;
        for &(normal, distance) in &self.planes {
            let inside = |corner: &&Vec3| normal.dot(**corner) >= distance;
            match corners.iter().filter(inside).count() {
                0 => return None,
                all if all == corners.len() => {}
                _ => narrowed = true,
            }
        }
        Some(narrowed)
    }

    /// The light that it adds to a point of a white surface, seen from the eye; `narrowed` as [`Near::shines_on`] has it.
    #[inline]
    pub(crate) fn at(&self, point: Vec3, normal: Vec3, narrowed: bool) -> Vec3 {
        let outside = |&(normal, distance): &(Vec3, f32)| normal.dot(point) < distance;
        if self.to_sun != Vec3::ZERO {
            let facing = normal.dot(self.to_sun);
            if facing <= 0.0 || (narrowed && self.planes.iter().any(outside)) {
                return Vec3::ZERO;
            }
            return self.color * facing;
        }
        let to_lamp = self.at - point;
        let facing = normal.dot(to_lamp);
        let square = to_lamp.length_squared();
        let own_square = square * self.per_square;
        let range_part = own_square * self.per_range_square;
        if facing <= 0.0 || range_part >= 1.0 || (narrowed && self.planes.iter().any(outside)) {
            return Vec3::ZERO;
        }
        let per_distance = 1.0 / square.sqrt();
        let cone = self.cone.map_or(1.0, |[steepness, added]| {
            let off = -self.onwards.dot(to_lamp) * per_distance;
            (off * steepness + added).clamp(0.0, 1.0).powi(2)
        });
        // As `Light::falloff` has it.
        let falloff = (1.0 - range_part * range_part) / own_square.max(self.nearest_square);
        self.color * (falloff * cone * facing * per_distance)
    }
}

/// How far from a lamp the surfaces are that it lights well: nearer than most of several tried.
fn usual_distance(scene: &Scene, lamp: &Light) -> f64 {
    let sector = scene.sector(lamp.sector);
    let corner = 1.0 / 3.0_f32.sqrt();
    let axes = [0, 1, 2].map(|axis| std::array::from_fn(|i| f32::from(u8::from(i == axis))));
    let corners = [
        [corner, corner, corner],
        [corner, corner, -corner],
        [corner, -corner, corner],
        [corner, -corner, -corner],
    ];
    let directions: Vec<[f32; 3]> = match lamp.shape {
        LightShape::Spot { direction, .. } => vec![direction],
        _ => axes
            .into_iter()
            .chain(corners)
            .flat_map(|direction| [direction, direction.map(|value: f32| -value)])
            .collect(),
    };
    let size = DVec3::from(sector.bounds().size().map(f64::from)).length();
    let mut distances: Vec<f64> = directions
        .into_iter()
        .filter_map(|direction| {
            let length = DVec3::from(direction.map(f64::from)).length();
            let ray = Ray {
                origin: lamp.position,
                direction,
            };
            sector.cast(&ray).map(|hit| hit.distance * length)
        })
        // The lamp's own shade is not what it lights.
        .filter(|&distance| distance > 0.02 * size.min(20.0))
        .collect();
    distances.sort_unstable_by(f64::total_cmp);
    let near = distances.get(distances.len() / 3).copied();
    near.unwrap_or(0.25 * size).min(0.5 * f64::from(lamp.range))
}

/// Adds what a light does in a sector that it reaches. What comes through an opening counts by how large that is beside
/// the walls; what fills a small part of a large sector, by that part.
fn brighten(scene: &Scene, rooms: &mut [Brightness], lamp: &Light, reached: &LightReach, usual: f64) {
    const SENT_BACK: f32 = 0.35;
    let size = DVec3::from(scene.sector(reached.sector).bounds().size().map(f64::from));
    let walls = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    let is_sun = matches!(lamp.shape, LightShape::Sun { .. });
    let part = if reached.parent.is_some() {
        let corners: Vec<DVec3> = reached.window.iter().map(|&corner| corner.into()).collect();
        let middle = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
        let away = middle.distance(reached.origin.into()) / reached.there_from_here.scale();
        lamp.falloff(away) * (area(&corners) / walls.max(f64::MIN_POSITIVE)).min(1.0)
    } else if is_sun {
        1.0
    } else {
        let filled = (4.0 * usual).powi(3) / (size.x * size.y * size.z).max(f64::MIN_POSITIVE);
        // A spot lights no more of it than its cone takes of what a bare lamp shines on before it.
        let cone = match lamp.shape {
            LightShape::Spot { outer, .. } => 1.0 - f64::from(outer).cos(),
            _ => 1.0,
        };
        0.6 * lamp.falloff(usual) * filled.min(1.0) * cone
    };
    let color = Vec3::from(lamp.color);
    let brightness = color.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    let room = &mut rooms[reached.sector.0 as usize];
    room.bounced += color * (SENT_BACK * part as f32);
    room.lit += brightness * part as f32;
    if reached.parent.is_none() && !is_sun {
        room.lit_best = room.lit_best.max(brightness * lamp.falloff(usual) as f32);
    }
}

fn area(corners: &[DVec3]) -> f64 {
    let Some((first, rest)) = corners.split_first() else {
        return 0.0;
    };
    let twice: DVec3 = rest
        .windows(2)
        .map(|pair| (pair[0] - first).cross(pair[1] - first))
        .sum();
    0.5 * twice.length()
}
