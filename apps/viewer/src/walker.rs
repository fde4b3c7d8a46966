//! The camera: flies, or walks on the ground, through portals.

use enfilade::{Camera, Location, Scene, SectorId, Transform};
use enfilade_walk::Capsule;
use glam::{DQuat, DVec3};

/// Height of the body and of its eyes, its radius, and the steps that it climbs, in metres.
const HEIGHT: f64 = 1.75;
const EYES: f64 = 1.62;
const RADIUS: f64 = 0.25;
const CLIMB: f64 = 0.35;
/// Acceleration of a fall, in metres per second squared.
const GRAVITY: f64 = 9.8;

/// A camera that moves.
#[derive(Clone, Debug)]
pub struct Walker {
    /// Position of the eye, or the middle of the body if it walks.
    at: Location,
    forward: DVec3,
    up: DVec3,
    fov_y: f32,
    z_near: Option<f32>,
    /// Scene units per metre here; portals may scale.
    metre: f64,
    /// Whether it walks on the ground, and is stopped by walls.
    pub walks: bool,
    /// Whether it moves through everything and follows no portals, as above a frozen scene.
    pub is_free: bool,
    /// Metres per second downwards.
    falls: f64,
}

impl Walker {
    /// Places it at a camera.
    pub fn new(scene: &Scene, camera: &Camera, metre: f64) -> Walker {
        let eye = camera.eye.map(|value| value as f32);
        let toward = camera.toward.map(|value| value as f32);
        let located = || scene.locate(eye, toward).unwrap_or(SectorId(0));
        let forward = (DVec3::from(camera.toward) - DVec3::from(camera.eye)).normalize_or(-DVec3::Z);
        Walker {
            at: Location {
                sector: camera.sector.unwrap_or_else(located),
                position: eye,
            },
            forward,
            up: DVec3::from(camera.up).normalize_or(DVec3::Y),
            fov_y: camera.fov_y,
            z_near: camera.z_near,
            metre,
            walks: false,
            is_free: false,
            falls: 0.0,
        }
    }

    /// Returns its sector.
    pub fn sector(&self) -> SectorId {
        self.at.sector
    }

    /// Returns what it sees.
    pub fn camera(&self, scene: &Scene) -> Camera {
        let (mut eye, mut forward, mut up) = (self.at, self.forward, self.up);
        if self.walks {
            // The head may be behind a portal that the middle of the body has not crossed.
            let rise = (EYES - 0.5 * HEIGHT) * self.metre * up;
            let head = scene.walk(eye, rise.as_vec3().into());
            forward = turned(&head.there_from_here, forward);
            up = turned(&head.there_from_here, up);
            eye = head.location;
        }
        let position = DVec3::from(eye.position.map(f64::from));
        // Rays begin beside the direction up even when looking straight down.
        Camera {
            eye: position.into(),
            toward: (position + forward * self.metre).into(),
            up: up.into(),
            fov_y: self.fov_y,
            z_near: self.z_near,
            sector: (!self.is_free).then_some(eye.sector),
            name: String::new(),
        }
    }

    /// Turns right and up, in radians.
    pub fn turn(&mut self, right: f64, up: f64) {
        /// Greatest angle from the horizon.
        const STEEPEST: f64 = 1.55;
        let turned = DQuat::from_axis_angle(self.up, -right) * self.forward;
        let across = turned.cross(self.up).normalize_or(DVec3::X);
        let pitch = turned.dot(self.up).clamp(-1.0, 1.0).asin();
        let up = (pitch + up).clamp(-STEEPEST, STEEPEST) - pitch;
        self.forward = (DQuat::from_axis_angle(across, up) * turned).normalize_or(self.forward);
    }

    /// Starts or stops walking. The eyes stay where they are.
    pub fn set_walks(&mut self, scene: &Scene, walks: bool) {
        if self.walks != walks {
            let rise = (EYES - 0.5 * HEIGHT) * self.metre * self.up * if walks { -1.0 } else { 1.0 };
            self.cross(scene, rise);
            (self.walks, self.falls) = (walks, 0.0);
        }
    }

    /// Moves for some seconds: right, up and forward, in metres per second.
    pub fn step(&mut self, scene: &Scene, [right, up, forward]: [f64; 3], seconds: f64) {
        let across = self.forward.cross(self.up).normalize_or(DVec3::X);
        if !self.walks {
            let way = across * right + self.up * up + self.forward * forward;
            return self.cross(scene, way * seconds * self.metre);
        }
        let level = self.up.cross(across).normalize_or(self.forward);
        self.falls = (self.falls + GRAVITY * seconds).min(50.0);
        let way = across * right + level * forward - self.up * self.falls;
        let mut body = Capsule::new((RADIUS * self.metre) as f32, (HEIGHT * self.metre) as f32);
        body.up = self.up.as_vec3().into();
        body.climb = (CLIMB * self.metre) as f32;
        let moved = body.slide(scene, self.at, (way * seconds * self.metre).as_vec3().into());
        self.at = moved.location;
        if moved.on_ground {
            self.falls = 0.0;
        }
        self.turn_by(&moved.there_from_here);
    }

    fn cross(&mut self, scene: &Scene, step: DVec3) {
        if self.is_free {
            let moved = DVec3::from(self.at.position.map(f64::from)) + step;
            if moved.abs().max_element() < f64::from(enfilade::MAX_COORDINATE) {
                self.at.position = moved.as_vec3().into();
            }
            return;
        }
        let moved = scene.walk(self.at, step.as_vec3().into());
        self.at = moved.location;
        self.turn_by(&moved.there_from_here);
    }

    fn turn_by(&mut self, there_from_here: &Transform) {
        self.forward = turned(there_from_here, self.forward);
        self.up = turned(there_from_here, self.up);
        self.metre *= there_from_here.scale();
    }
}

/// Returns a direction moved through portals, of length 1.
fn turned(there_from_here: &Transform, direction: DVec3) -> DVec3 {
    let moved = there_from_here.direction(direction.as_vec3().into());
    DVec3::from(moved.map(f64::from)).normalize_or(direction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade_scenes::built_in;

    #[test]
    fn a_walker_stands_on_the_floor_of_the_palace_and_is_stopped_by_its_walls() {
        let palace = built_in("enfilade").expect("a built-in scene");
        let mut walker = Walker::new(&palace.scene, &palace.cameras[0], 1.0);
        walker.set_walks(&palace.scene, true);
        for _ in 0..60 {
            walker.step(&palace.scene, [0.0; 3], 1.0 / 30.0);
        }
        let eye = walker.camera(&palace.scene).eye;
        assert!((eye[1] - EYES).abs() < 0.05, "the eyes are at {eye:?}");
        let start = walker.sector();
        walker.turn(std::f64::consts::FRAC_PI_2, 0.0);
        for _ in 0..300 {
            walker.step(&palace.scene, [0.0, 0.0, 2.0], 1.0 / 30.0);
        }
        let bounds = palace.scene.bounds(start);
        let eye = walker.camera(&palace.scene).eye.map(|value| value as f32);
        assert!(bounds.contains(eye), "{eye:?} is outside of {bounds:?}");
    }

    #[test]
    fn a_flight_along_the_row_of_rooms_crosses_their_doors() {
        let palace = built_in("enfilade").expect("a built-in scene");
        let mut walker = Walker::new(&palace.scene, &palace.cameras[0], 1.0);
        let mut rooms = vec![walker.sector()];
        for _ in 0..400 {
            walker.step(&palace.scene, [0.0, 0.0, 3.0], 1.0 / 30.0);
            if rooms.last() != Some(&walker.sector()) {
                rooms.push(walker.sector());
            }
        }
        assert!(rooms.len() > 3, "{rooms:?}");
    }
}
