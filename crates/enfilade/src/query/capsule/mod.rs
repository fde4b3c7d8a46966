//! A capsule that slides along walls: for walking, and for cameras that must not look through walls.
//!
//! It goes its step by parts that end where something is in the way ([`body`]); what is in the way is asked of every
//! sector that it stands in ([`obstacles`]).
//! Source: as in those two.
//! Cost: that of the triangles near its way, some tens of times.
//! It never gets into a wall that it did not begin in.

mod body;
mod obstacles;

use super::place::Location;
use crate::geom::Transform;
use crate::scene::{PortalId, Scene};
use body::{Body, Mover};
use glam::DVec3;

/// An upright cylinder with round ends.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Capsule {
    /// In scene units, above 0.
    pub radius: f32,
    /// From end to end; a sphere where it is no more than twice the radius.
    pub height: f32,
    /// Along its axis, of any length but zero.
    pub up: [f32; 3],
    /// The height of a step that it walks up. With 0 it is stopped by all that its round end does not slide over.
    pub climb: f32,
}

/// Where a step of a capsule leads.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SlideResult {
    /// Where its middle is.
    pub place: Location,
    /// The capsule as it is there: turned, and grown or shrunk, as the portals have it.
    pub capsule: Capsule,
    /// From the space that it began in to the one that it is in: turns its course, too.
    pub there_from_here: Transform,
    /// The portals that its middle went through, in order.
    pub crossed: Vec<PortalId>,
    /// Unit normals of what was in its way, towards the capsule, in the space that it is in.
    pub touched: Vec<[f32; 3]>,
    /// Does it stand on a face no steeper than 45 degrees, or on the edge of one?
    pub on_ground: bool,
    /// Was the whole step gone, but for what was in the way? If not, it was too long, or through too much.
    pub complete: bool,
}

impl Capsule {
    /// Upright along y, climbing nothing.
    pub const fn new(radius: f32, height: f32) -> Capsule {
        Capsule {
            radius,
            height,
            up: [0.0, 1.0, 0.0],
            climb: 0.0,
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

/// The cosine of the steepest ground.
const STEEPEST: f64 = std::f64::consts::FRAC_1_SQRT_2;

impl Scene {
    /// Moves a capsule, its middle at `from`, by a step: along what is in its way, and through open portals.
    ///
    /// Every face stops it, from whichever side and of whatever it is made, glass and cut-outs too; so do openings that are
    /// closed or lead nowhere. What reaches through an open portal is stopped by what stands there, not by what stands behind
    /// the opening here. Sectors of the user's own have no faces to be stopped by. Nothing pulls it down: say so with the
    /// step. Where it stands in a wall to begin with, it is pushed out, if that is not into another.
    ///
    /// It keeps a thousandth of its radius away from faces, or as much as f32 loses there. A step, a place or a capsule that
    /// is not finite, and a capsule without radius, go nowhere.
    pub fn slide(&self, from: Location, capsule: Capsule, step: [f32; 3]) -> SlideResult {
        let goes_nowhere = SlideResult {
            place: from,
            capsule,
            there_from_here: Transform::IDENTITY,
            crossed: Vec::new(),
            touched: Vec::new(),
            on_ground: false,
            complete: true,
        };
        let finite = from.position.iter().chain(&step).all(|value| value.is_finite());
        let Some(body) = capsule.body().filter(|_| finite) else {
            return goes_nowhere;
        };
        let start = Mover {
            scene: self,
            place: from,
            body,
            there_from_here: Transform::IDENTITY,
            crossed: Vec::new(),
            touched: Vec::new(),
            complete: true,
        };
        let step = DVec3::from(step.map(f64::from));
        let mut moved = start.clone();
        moved.go(step, true);
        if capsule.climb > 0.0
            && moved
                .touched
                .iter()
                .any(|normal| is_steep(normal.dot(moved.body.up)))
        {
            moved = climbed(&start, step, f64::from(capsule.climb), &moved).unwrap_or(moved);
        }
        let scale = moved.body.radius / body.radius;
        SlideResult {
            place: moved.place,
            capsule: Capsule {
                radius: moved.body.radius as f32,
                height: (f64::from(capsule.height) * scale) as f32,
                up: moved.body.up.as_vec3().into(),
                climb: (f64::from(capsule.climb) * scale) as f32,
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
}

/// Is that a wall, told by how much its normal points up?
fn is_steep(up: f64) -> bool {
    up.abs() < STEEPEST
}

/// How high, in the space that it began in, what it stands on is: a face that is not steep, or the edge of one, as on stairs.
fn ground(mover: &Mover, up: DVec3) -> Option<f64> {
    const FROM_ABOVE: f64 = 0.1;
    let here_from_there = mover.there_from_here.inverse()?.0;
    let contacts = mover.leans_on().into_iter().filter(|contact| {
        let [leans, rises] = [contact.normal, contact.of_face].map(|normal| normal.dot(mover.body.up));
        leans >= FROM_ABOVE && rises >= STEEPEST
    });
    contacts
        .map(|contact| here_from_there.transform_point3(contact.on).dot(up))
        .max_by(f64::total_cmp)
}

/// The same step over something low: up, along, and down again; `None` where that does not lead further, to firm ground
/// that is no higher above what it stood on.
fn climbed<'a>(start: &Mover<'a>, step: DVec3, climb: f64, plain: &Mover) -> Option<Mover<'a>> {
    let up = start.body.up;
    let ground_before = ground(start, up).or_else(|| ground(plain, up))?;
    let mut tried = start.clone();
    tried.go(up * climb, false);
    let risen = (tried.middle() - start.middle()).dot(up);
    // It may have been lifted into another space.
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
        let here = mover
            .there_from_here
            .inverse()?
            .0
            .transform_point3(mover.middle());
        Some((here - start.middle()).dot(level.normalize_or_zero()))
    };
    let further = far(&tried)? > far(plain)? + 1e-3 * start.body.radius;
    let low_enough = ground(&tried, up)? <= ground_before + climb;
    (further && low_enough).then_some(tried)
}
