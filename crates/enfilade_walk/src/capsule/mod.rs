//! Kinematic capsule that slides along walls, for character controllers and cameras.
//!
//! Idea: a step is split into parts that end at obstacles ([`body`]); the obstacles come from every sector that the
//!     capsule reaches into ([`obstacles`]).
//! Source: see those two.
//! Cost: testing the triangles near the path, some tens of times.
//! The capsule never enters a face that it does not already overlap at the start.

mod body;
mod obstacles;

use body::{Body, Mover};
use enfilade::{Location, PortalId, Scene, Transform};
use glam::{DAffine3, DVec3};

/// Capsule that slides along obstacles ([`Capsule::slide`]): a cylinder with hemispherical ends.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Capsule {
    /// Radius in scene units, above 0.
    pub radius: f32,
    /// Total height, hemispheres included, in scene units; a sphere if at most twice the radius.
    pub height: f32,
    /// Direction of the axis, of any length but zero.
    pub up: [f32; 3],
    /// Maximum height of a step that it climbs, in scene units. With 0, obstacles stop it unless its rounded end slides
    /// over them.
    #[doc(alias = "step height")]
    pub climb: f32,
}

/// Result of [`Capsule::slide`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SlideResult {
    /// Location of the capsule's centre after the step.
    pub location: Location,
    /// The capsule in the space of its new sector, rotated and scaled by the portals crossed.
    pub capsule: Capsule,
    /// Maps the space of the start to that of the end. Apply it to velocity and orientation.
    pub there_from_here: Transform,
    /// The portals that its centre crossed, in order.
    pub crossed: Vec<PortalId>,
    /// Unit normals of the obstacles touched, towards the capsule, in the space of the end.
    pub touched: Vec<[f32; 3]>,
    /// Whether it is on a face with a slope of at most 45 degrees, or on the edge of one.
    #[doc(alias = "grounded")]
    pub on_ground: bool,
    /// Whether the step was completed, apart from obstacles. `false` if it was too long or crossed too many obstacles
    /// or portals.
    pub complete: bool,
}

impl Capsule {
    /// Creates a capsule whose axis is +Y, with a `climb` of 0.
    pub const fn new(radius: f32, height: f32) -> Capsule {
        Capsule {
            radius,
            height,
            up: [0.0, 1.0, 0.0],
            climb: 0.0,
        }
    }

    /// Moves the capsule with its centre at `from` by `step`, sliding along obstacles and through open portals.
    ///
    /// Returns where it ends, what it touched and which portals it crossed. `step` is in the space of `from`, in scene
    /// units.
    ///
    /// Obstacles are all faces, from both sides and of every material, alpha-blended and alpha-tested ones included,
    /// and openings that are closed or lead nowhere. The part of the capsule that is beyond an open portal collides
    /// with the sector there, not with what is behind the opening here. Custom sectors have no faces to collide with.
    /// There is no gravity: add it to `step`. A capsule that overlaps a face at the start is pushed out, unless that
    /// would push it into another.
    ///
    /// It keeps a distance of a thousandth of its radius from faces, or more where f32 rounding requires it. Nothing
    /// moves if the step, the position or the capsule is not finite, or if the radius is not above 0.
    #[doc(alias = "character controller")]
    #[doc(alias = "kinematic")]
    #[doc(alias = "move and slide")]
    pub fn slide(self, scene: &Scene, from: Location, step: [f32; 3]) -> SlideResult {
        let unmoved = SlideResult {
            location: from,
            capsule: self,
            there_from_here: Transform::IDENTITY,
            crossed: Vec::new(),
            touched: Vec::new(),
            on_ground: false,
            complete: true,
        };
        let finite = from.position.iter().chain(&step).all(|value| value.is_finite());
        let Some(body) = self.body().filter(|_| finite) else {
            return unmoved;
        };
        let start = Mover {
            scene,
            location: from,
            body,
            there_from_here: Transform::IDENTITY,
            crossed: Vec::new(),
            touched: Vec::new(),
            complete: true,
        };
        let step = DVec3::from(step.map(f64::from));
        let mut moved = start.clone();
        moved.go(step, true);
        if self.climb > 0.0
            && moved
                .touched
                .iter()
                .any(|normal| is_steep(normal.dot(moved.body.up)))
        {
            moved = climbed(&start, step, f64::from(self.climb), &moved).unwrap_or(moved);
        }
        let scale = moved.body.radius / body.radius;
        SlideResult {
            location: moved.location,
            capsule: Capsule {
                radius: moved.body.radius as f32,
                height: (f64::from(self.height) * scale) as f32,
                up: moved.body.up.as_vec3().into(),
                climb: (f64::from(self.climb) * scale) as f32,
            },
            there_from_here: moved.there_from_here,
            touched: moved
                .touched
                .iter()
                .map(|normal| normal.as_vec3().into())
                .collect(),
            on_ground: ground(&moved, body.up).is_some(),
            complete: moved.complete,
            crossed: moved.crossed,
        }
    }

    fn body(&self) -> Option<Body> {
        let [radius, height] = [self.radius, self.height].map(f64::from);
        let up = DVec3::from(self.up.map(f64::from)).try_normalize()?;
        (radius > 0.0 && radius.is_finite() && height.is_finite()).then_some(Body {
            radius,
            half: (0.5 * height - radius).max(0.0),
            up,
        })
    }
}

/// Cosine of the maximum slope of ground.
const STEEPEST: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Returns `true` if the slope is too steep for ground, given the up component of the unit normal.
fn is_steep(up: f64) -> bool {
    up.abs() < STEEPEST
}

/// Returns the height of the ground along `up`, in the space of the start: the highest contact that is a face of low
/// slope, or the edge of one, as on stairs.
fn ground(mover: &Mover, up: DVec3) -> Option<f64> {
    const FROM_ABOVE: f64 = 0.1;
    let here_from_there = DAffine3::from(mover.there_from_here.inverse()?);
    let contacts = mover.contacts_here().into_iter().filter(|contact| {
        let [leans, rises] = [contact.normal, contact.of_face].map(|normal| normal.dot(mover.body.up));
        leans >= FROM_ABOVE && rises >= STEEPEST
    });
    contacts
        .map(|contact| here_from_there.transform_point3(contact.on).dot(up))
        .max_by(f64::total_cmp)
}

/// Repeats the step over a low obstacle: up, along, and down again. `None` unless that leads farther than the `plain`
/// step and onto ground at most `climb` above the ground before.
fn climbed<'a>(start: &Mover<'a>, step: DVec3, climb: f64, plain: &Mover) -> Option<Mover<'a>> {
    let up = start.body.up;
    let ground_before = ground(start, up).or_else(|| ground(plain, up))?;
    let mut tried = start.clone();
    tried.go(up * climb, false);
    let risen = (tried.middle() - start.middle()).dot(up);
    // Through a portal, the rest of the step would be in another space.
    if !tried.crossed.is_empty() || risen <= 0.0 {
        return None;
    }
    let level = step - up * step.dot(up);
    tried.touched.clear();
    tried.go(level, true);
    let scale = tried.body.radius / start.body.radius;
    let down = tried.body.up * (-scale * risen);
    tried.go(down, false);
    let far = |mover: &Mover| {
        let here_from_there = DAffine3::from(mover.there_from_here.inverse()?);
        let here = here_from_there.transform_point3(mover.middle());
        Some((here - start.middle()).dot(level.normalize_or_zero()))
    };
    let further = far(&tried)? > far(plain)? + 1e-3 * start.body.radius;
    let low_enough = ground(&tried, up)? <= ground_before + climb;
    (further && low_enough).then_some(tried)
}
