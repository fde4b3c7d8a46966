//! Light reach: the sectors that each light shines into, through which openings, and the indirect light and brightness
//! of each sector.

use crate::lighting::DirectLight;
use enfilade::{
    Aabb, Light, LightId, LightReach, LightShape, Limits, Passage, Ray, Scene, SectorId, Transform,
};
use glam::{DVec3, Vec3};

/// Maximum number of sector visits per light: two parallel mirrors would reflect forever.
const MAX_REACHED: u32 = 4096;
/// Maximum number of consecutive portals that light passes.
const MAX_CROSSED: u16 = 8;

/// Reach of all lights of a scene, and the brightness of each sector.
pub(crate) struct Lamps {
    /// Sorted by sector.
    all: Vec<Lamp>,
    /// Brightness by sector.
    rooms: Vec<Brightness>,
    /// Number of lights of the scene.
    pub(crate) lights: usize,
}

/// A light in the space of a sector that it reaches.
struct Lamp {
    light: usize,
    /// Number of the beam among those of the light.
    beam: usize,
    lamp: Light,
    reach: LightReach,
    /// Central direction of its light, unit length; zero for a point light.
    onwards: DVec3,
    /// Length in the sector of one unit in the light's own sector.
    scale: f64,
}

/// Brightness of a sector.
#[derive(Clone, Copy, Default)]
struct Brightness {
    /// Indirect light that surfaces receive from others.
    bounced: Vec3,
    /// Estimated light that a typically lit white surface reflects.
    lit: f32,
    /// The same for a surface close to its nearest lamp.
    lit_best: f32,
}

/// A light that may reach what a passage shows; positions are relative to the passage's eye.
pub(crate) struct PassageLight {
    /// Number of the light, and of the beam among those of the light.
    pub(crate) beam: (usize, usize),
    here_from_light: Transform,
    /// Position relative to the passage's eye, or direction to the sun.
    toward: DVec3,
    at: Vec3,
    /// Direction to the sun; zero for a lamp.
    to_sun: Vec3,
    onwards: Vec3,
    color: Vec3,
    /// For a spot: factor and offset of the cosine off its axis, for the square root of its intensity.
    cone: Option<[f32; 2]>,
    /// `per_square`: squared length in the lamp's sector per squared length here. `reach`: range in lengths here.
    /// `per_range_square`: inverse of the squared range in the lamp's sector. `nearest_square`: squared distance there
    /// below which the falloff is constant.
    per_square: f32,
    reach: f32,
    per_range_square: f32,
    nearest_square: f32,
    /// The light beam through openings.
    planes: Vec<BeamPlane>,
    /// For a sun, the plane of the last opening, scaled so that n · x − d is the distance from it along the light.
    opening: Option<(Vec3, f32)>,
}

/// A plane of a light beam; points inside have n · x ≥ d.
struct BeamPlane {
    normal: Vec3,
    distance: f32,
    /// Whether it contains the light, so that an edge of light lies in it. Others are planes of openings.
    is_edge: bool,
}

/// The planes of a beam that cut a face, as bits; the last bit stands for all planes from the 32nd on.
pub(crate) type CutBy = u32;

impl Brightness {
    /// Returns the brightness that automatic exposure adapts to: a compromise between lit spots and the rest of the
    /// room.
    fn adaptation(&self) -> f32 {
        self.lit * (0.5 * self.lit_best / self.lit.max(f32::MIN_POSITIVE)).clamp(1.0, 1.5)
    }
}

/// Returns how far light is followed through portals.
pub(crate) fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_crossings = MAX_CROSSED;
    limits.max_passages = MAX_REACHED;
    limits
}

impl Lamps {
    /// Computes the reach of all lights of a scene.
    pub(crate) fn of(scene: &Scene) -> Lamps {
        let limits = limits();
        let mut all: Vec<Lamp> = Vec::new();
        let mut rooms = vec![Brightness::default(); scene.sectors().count()];
        for (light, lamp) in scene.lights().iter().enumerate() {
            let typical = typical_distance(scene, lamp);
            for (beam, reach) in scene
                .light_reach(LightId(light as u32), &limits)
                .into_iter()
                .enumerate()
            {
                brighten(scene, &mut rooms, lamp, &reach, typical);
                let onwards = lamp
                    .direction()
                    .map_or([0.0; 3], |direction| reach.there_from_here.direction(direction));
                all.push(Lamp {
                    light,
                    beam,
                    lamp: *lamp,
                    onwards: DVec3::from(onwards.map(f64::from)).normalize_or_zero(),
                    scale: reach.there_from_here.scale(),
                    reach,
                });
            }
        }
        all.sort_by_key(|lamp| lamp.reach.sector);
        Lamps {
            all,
            rooms,
            lights: scene.lights().len(),
        }
    }

    /// Returns `true` if the scene has no lights.
    pub(crate) fn is_empty(&self) -> bool {
        self.lights == 0
    }

    /// Returns the indirect light of a sector, linear; above zero even in the darkest.
    pub(crate) fn bounced(&self, sector: SectorId) -> Vec3 {
        const LEAST: f32 = 0.05;
        let here = self.rooms.get(sector.0 as usize);
        here.map_or(Vec3::ZERO, |room| room.bounced) + Vec3::splat(LEAST * self.brightest())
    }

    /// Returns the estimated light that a well-lit white surface of a sector reflects; above 0.
    pub(crate) fn lit(&self, sector: SectorId) -> f32 {
        const DARKEST: f32 = 0.1;
        let here = self
            .rooms
            .get(sector.0 as usize)
            .map_or(0.0, Brightness::adaptation);
        here.max(DARKEST * self.brightest()).max(f32::MIN_POSITIVE)
    }

    fn brightest(&self) -> f32 {
        self.rooms.iter().map(Brightness::adaptation).fold(0.0, f32::max)
    }

    /// Returns the lights that may reach what a passage shows, each with its index.
    pub(crate) fn near<'a>(
        &'a self,
        passage: &'a Passage,
    ) -> impl Iterator<Item = (usize, PassageLight)> + 'a {
        let first = self
            .all
            .partition_point(|lamp| lamp.reach.sector < passage.sector);
        let here = self.all[first..]
            .iter()
            .take_while(|lamp| lamp.reach.sector == passage.sector);
        let eye = DVec3::from(passage.eye());
        here.filter(|lamp| passage.may_show(&lamp.around()))
            .map(move |lamp| (lamp.light, lamp.near(eye)))
    }
}

impl Lamp {
    /// Returns the range in lengths of the sector it reaches.
    fn range(&self) -> f64 {
        match self.lamp.shape {
            LightShape::Sun { .. } => f64::INFINITY,
            _ => f64::from(self.lamp.range) * self.scale,
        }
    }

    /// Returns the bounding box of its range.
    fn around(&self) -> Aabb {
        // Limited so that later arithmetic does not overflow.
        let range = self.range().min(1e30);
        Aabb {
            min: self.reach.origin.map(|value| (value - range) as f32),
            max: self.reach.origin.map(|value| (value + range) as f32),
        }
    }

    fn near(&self, eye: DVec3) -> PassageLight {
        let at = DVec3::from(self.reach.origin) - eye;
        let is_sun = matches!(self.lamp.shape, LightShape::Sun { .. });
        let toward = at.normalize_or_zero();
        let planes = self.reach.planes().map(|(normal, distance)| {
            let long = DVec3::from(normal).length().max(f64::MIN_POSITIVE);
            let normal = DVec3::from(normal) / long;
            let distance = distance / long - normal.dot(eye);
            let off = if is_sun {
                normal.dot(toward)
            } else {
                (normal.dot(at) - distance) / (1.0 + at.length())
            };
            BeamPlane {
                normal: normal.as_vec3(),
                distance: distance as f32,
                is_edge: off.abs() < 1e-4,
            }
        });
        PassageLight {
            beam: (self.light, self.beam),
            here_from_light: self.reach.there_from_here,
            toward: if is_sun { -self.onwards } else { at },
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
            opening: if is_sun { self.opening(eye, toward) } else { None },
        }
    }

    /// Returns the plane of the last opening relative to the eye, scaled to the direction of the light.
    fn opening(&self, eye: DVec3, toward: DVec3) -> Option<(Vec3, f32)> {
        let corners: Vec<DVec3> = self.reach.window.iter().map(|&corner| corner.into()).collect();
        let first = *corners.first()?;
        let normal: DVec3 = corners
            .windows(2)
            .map(|pair| (pair[0] - first).cross(pair[1] - first))
            .sum();
        let along = normal.dot(toward);
        let scaled = normal / along;
        let plane = (scaled.as_vec3(), scaled.dot(first - eye) as f32);
        scaled.is_finite().then_some(plane)
    }
}

impl PassageLight {
    /// Returns it in plain numbers.
    pub(crate) fn plain(&self) -> DirectLight {
        let is_sun = self.to_sun != Vec3::ZERO;
        let plane = |plane: &BeamPlane| plane.normal.extend(plane.distance).into();
        let (edges, others): (Vec<&BeamPlane>, Vec<&BeamPlane>) =
            self.planes.iter().partition(|plane| plane.is_edge);
        DirectLight {
            light: LightId(self.beam.0 as u32),
            beam: self.beam.1,
            light_from_here: self.here_from_light.inverse().unwrap_or(Transform::IDENTITY),
            is_sun,
            at: if is_sun { self.to_sun } else { self.at }.into(),
            color: self.color.into(),
            per_square: self.per_square,
            per_range_square: if is_sun { 0.0 } else { self.per_range_square },
            nearest_square: self.nearest_square,
            cone: self.cone.map(|cone| (self.onwards.into(), cone)),
            edge_planes: edges.len(),
            planes: edges.into_iter().chain(others).map(plane).collect(),
            opening: self
                .opening
                .map(|(normal, distance)| normal.extend(distance).into()),
        }
    }

    /// Returns the vector from a point, relative to the eye, to the lamp, or the direction to the sun.
    pub(crate) fn toward(&self, point: DVec3) -> DVec3 {
        if self.to_sun == Vec3::ZERO {
            self.toward - point
        } else {
            self.toward
        }
    }

    /// Tests whether the light may reach a face with these corners, whose normal points towards the eye. Returns `None`
    /// if not; otherwise the planes of its beam that must be tested per point.
    pub(crate) fn shines_on(&self, corners: &[Vec3], normal: Option<Vec3>) -> Option<CutBy> {
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
        // A face that ends at a plane is not cut by it: its last samples are in full light.
        const TOUCHES: f32 = 1e-4;
        let mut cut = 0;
        for (number, plane) in self.planes.iter().enumerate() {
            let inside = |corner: &Vec3| plane.normal.dot(*corner) - plane.distance;
            if corners.iter().all(|corner| inside(corner) < 0.0) {
                return None;
            }
            let is_cut = corners
                .iter()
                .any(|corner| inside(corner) < -TOUCHES * (1.0 + corner.length()));
            cut |= CutBy::from(is_cut) << number.min(31);
        }
        Some(cut)
    }

    /// Returns the light at a point of a white surface, relative to the eye. `cut` is the result of
    /// [`PassageLight::shines_on`], `steps` the distances on the surface to the next sample right and down.
    #[inline]
    pub(crate) fn at(&self, point: Vec3, normal: Vec3, cut: CutBy, steps: [Vec3; 2]) -> Vec3 {
        if self.to_sun != Vec3::ZERO {
            let facing = normal.dot(self.to_sun);
            if facing <= 0.0 {
                return Vec3::ZERO;
            }
            return self.color * (facing * self.passing(point, cut, steps));
        }
        let to_lamp = self.at - point;
        let facing = normal.dot(to_lamp);
        let square = to_lamp.length_squared();
        let own_square = square * self.per_square;
        let range_part = own_square * self.per_range_square;
        if facing <= 0.0 || range_part >= 1.0 {
            return Vec3::ZERO;
        }
        let passing = self.passing(point, cut, steps);
        if passing <= 0.0 {
            return Vec3::ZERO;
        }
        let per_distance = 1.0 / square.sqrt();
        let cone = self.cone.map_or(1.0, |[steepness, added]| {
            let off = -self.onwards.dot(to_lamp) * per_distance;
            (off * steepness + added).clamp(0.0, 1.0).powi(2)
        });
        // As [`Light::falloff`].
        let falloff = (1.0 - range_part * range_part) / own_square.max(self.nearest_square);
        self.color * (passing * falloff * cone * facing * per_distance)
    }

    /// Returns the most light that a white surface may reflect at a point, in any channel.
    pub(crate) fn at_most(&self, point: Vec3) -> f32 {
        let brightest = self.color.max_element();
        if self.to_sun != Vec3::ZERO {
            return brightest;
        }
        let square = (self.at - point).length_squared() * self.per_square;
        if square * self.per_range_square >= 1.0 {
            return 0.0;
        }
        brightest / square.max(self.nearest_square)
    }

    /// Returns the part of the light that passes all openings, 0 to 1: at an edge of the beam, the part of the pixel
    /// within it, and for the sun of its disc.
    ///
    /// The ramp is symmetric about the edge, so light through two openings side by side adds up to the whole.
    #[inline]
    fn passing(&self, point: Vec3, cut: CutBy, steps: [Vec3; 2]) -> f32 {
        /// Angle at which the sun is seen, in radians.
        const SUN_SIZE: f32 = 0.0093;
        if cut == 0 {
            return 1.0;
        }
        let penumbra = self.opening.map_or(0.0, |(normal, distance)| {
            SUN_SIZE * (normal.dot(point) - distance).abs()
        });
        // Most points are farther from all edges than any pixel reaches.
        let most = 0.5 * (steps[0].length() + steps[1].length() + penumbra);
        let mut part = 1.0;
        for (number, plane) in self.planes.iter().enumerate() {
            if (cut >> number.min(31)) & 1 == 0 {
                continue;
            }
            let inside = plane.normal.dot(point) - plane.distance;
            if inside >= most {
                continue;
            }
            if inside <= -most {
                return 0.0;
            }
            let own = if plane.is_edge {
                let [a, b] = steps.map(|step| plane.normal.dot(step).abs());
                let wide = (a.max(b).powi(2) + penumbra * penumbra).sqrt();
                part_within(inside, wide, a.min(b))
            } else {
                f32::from(u8::from(inside >= 0.0))
            };
            if own <= 0.0 {
                return 0.0;
            }
            part *= own;
        }
        part
    }
}

/// Returns the part of a pixel on the inner side of an edge. `inside` is the signed distance of its centre; `wide` and
/// `narrow` are the extents of its longer and its shorter side across the edge.
#[inline]
fn part_within(inside: f32, wide: f32, narrow: f32) -> f32 {
    let off = inside.abs();
    let outer = if wide <= 0.0 {
        0.0
    } else if off <= 0.5 * (wide - narrow) {
        0.5 - off / wide
    } else if off < 0.5 * (wide + narrow) {
        (0.5 * (wide + narrow) - off).powi(2) / (2.0 * wide * narrow)
    } else {
        0.0
    };
    if inside < 0.0 { outer } else { 1.0 - outer }
}

/// Returns the typical distance of the surfaces that a lamp lights well: the lower third of the hits of several rays.
fn typical_distance(scene: &Scene, lamp: &Light) -> f64 {
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
        // Skip hits on the lamp's own shade.
        .filter(|&distance| distance > 0.02 * size.min(20.0))
        .collect();
    distances.sort_unstable_by(f64::total_cmp);
    let near = distances.get(distances.len() / 3).copied();
    near.unwrap_or(0.25 * size).min(0.5 * f64::from(lamp.range))
}

/// Adds the contribution of a light to a sector it reaches. Light through an opening is weighted by the opening's area
/// relative to the walls; light that fills a small part of a large sector, by that part.
fn brighten(scene: &Scene, rooms: &mut [Brightness], lamp: &Light, reach: &LightReach, typical: f64) {
    const SENT_BACK: f32 = 0.35;
    let size = DVec3::from(scene.sector(reach.sector).bounds().size().map(f64::from));
    let walls = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    let is_sun = matches!(lamp.shape, LightShape::Sun { .. });
    let part = if reach.parent.is_some() {
        let corners: Vec<DVec3> = reach.window.iter().map(|&corner| corner.into()).collect();
        let middle = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
        let away = middle.distance(reach.origin.into()) / reach.there_from_here.scale();
        lamp.falloff(away) * (area(&corners) / walls.max(f64::MIN_POSITIVE)).min(1.0)
    } else if is_sun {
        1.0
    } else {
        let filled = (4.0 * typical).powi(3) / (size.x * size.y * size.z).max(f64::MIN_POSITIVE);
        // A spot lights only the solid angle of its cone.
        let cone = match lamp.shape {
            LightShape::Spot { outer, .. } => 1.0 - f64::from(outer).cos(),
            _ => 1.0,
        };
        0.6 * lamp.falloff(typical) * filled.min(1.0) * cone
    };
    let color = Vec3::from(lamp.color);
    let brightness = color.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    let room = &mut rooms[reach.sector.0 as usize];
    room.bounced += color * (SENT_BACK * part as f32);
    room.lit += brightness * part as f32;
    if reach.parent.is_none() && !is_sun {
        room.lit_best = room.lit_best.max(brightness * lamp.falloff(typical) as f32);
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
