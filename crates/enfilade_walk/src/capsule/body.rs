//! Advances a capsule along a step: position, remaining motion and contacts.
//!
//! Idea: conservative advancement. The distance between a translated body and a convex face is a convex function of the
//!     translation, so its slope at the current position bounds it from below: a part of the step that is short enough
//!     by that bound passes through no face, however fast the body is. At zero distance the remaining step is projected
//!     onto the face, or onto the crease between two.
//! Source: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996, for conservative advancement;
//!     Fauerby, Improved Collision Detection and Response, 2003, for the sliding response.
//! Cost: at most some tens of parts in practice, each with a distance to every nearby triangle.
//! A body that starts free never passes through a face: it keeps its radius from every face, up to f32 rounding.

use super::obstacles::{Contact, Obstacles};
use enfilade::{Location, PortalId, Scene, Transform};
use glam::{DAffine3, DVec3};

/// A capsule in the space of the sector that contains its centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub(super) radius: f64,
    /// Distance from the centre to each end of the axis.
    pub(super) half: f64,
    pub(super) up: DVec3,
}

impl Body {
    pub(super) fn axis(&self, middle: DVec3) -> [DVec3; 2] {
        let off = self.up * self.half;
        [middle - off, middle + off]
    }
}

/// A moving body: its current state and what it crossed and touched.
#[derive(Clone)]
pub(super) struct Mover<'a> {
    pub(super) scene: &'a Scene,
    pub(super) location: Location,
    pub(super) body: Body,
    pub(super) there_from_here: Transform,
    pub(super) crossed: Vec<PortalId>,
    /// Unit normals of the obstacles that stopped it, in its current space.
    pub(super) touched: Vec<DVec3>,
    pub(super) complete: bool,
}

/// Maximum number of parts of a step.
const MAX_PARTS: usize = 512;

/// Maximum number of obstacles that one step slides along; then the body is stuck.
const MAX_STOPS: usize = 32;

/// Maximum number of times in a row that a body is pushed out of faces.
const MAX_PUSHES: usize = 16;

/// A direction counts as parallel to a face if its component into the face is below this fraction of its length.
const ALONG: f64 = 1e-6;

impl Mover<'_> {
    pub(super) fn middle(&self) -> DVec3 {
        DVec3::from(self.location.position.map(f64::from))
    }

    /// Returns the extra distance, beyond the radius, that a body keeps from faces: f32 positions must not round into
    /// them.
    fn skin(&self) -> f64 {
        let reach = self.middle().abs().max_element() + self.body.half + self.body.radius;
        (1e-3 * self.body.radius).max(8.0 * f64::from(f32::EPSILON) * reach)
    }

    /// Returns the contacts at the current position.
    pub(super) fn contacts_here(&self) -> Vec<Contact> {
        let skin = self.skin();
        let near = self.body.radius + 3.0 * skin;
        let obstacles = Obstacles::about(self.scene, self.location, &self.body, 3.0 * skin);
        let mut contacts = Vec::new();
        obstacles.contacts(self.middle(), &self.body, near, &mut contacts);
        contacts
    }

    /// Moves by `step` as far as possible; if `slides`, continues along obstacles.
    pub(super) fn go(&mut self, step: DVec3, slides: bool) {
        let mut rest = step;
        let mut contacts: Vec<Contact> = Vec::new();
        // Normals of the obstacles that stop it at the current position.
        let mut planes: Vec<DVec3> = Vec::new();
        let [mut pushes, mut stopped] = [0; 2];
        let mut near: Option<NearbyObstacles> = None;
        for _ in 0..MAX_PARTS {
            let skin = self.skin();
            let [stops, keeps] = [0.5, 1.0].map(|part| self.body.radius + part * skin);
            let (length, forward) = (rest.length(), rest.normalize_or_zero());
            let size = self.body.half + self.body.radius;
            let middle = self.middle();
            if !(near.as_ref()).is_some_and(|near| near.serves(middle, length.min(size) + skin)) {
                let reach = length.min(8.0 * size) + self.body.radius;
                near = Some(NearbyObstacles {
                    obstacles: Obstacles::about(self.scene, self.location, &self.body, reach),
                    middle,
                    reach,
                });
            }
            let Some(NearbyObstacles { obstacles, .. }) = &near else {
                return;
            };
            // Near openings, faces become reachable or unreachable as the body moves.
            let most = if obstacles.has_ways_out() {
                0.5 * self.body.radius
            } else {
                size
            };
            let most = length.min(most);
            obstacles.contacts(middle, &self.body, keeps + most, &mut contacts);
            // Distance that the body can move before a face stops it. Negligible distances count as 0: f32 cannot
            // resolve them, and the loop would not end.
            let free = |contact: &Contact| {
                let [speed, gap] = [-forward.dot(contact.normal), contact.distance - stops];
                let free = if gap <= 0.1 * skin { 0.0 } else { gap / speed };
                (speed > ALONG).then_some(free)
            };
            let nearest = contacts
                .iter()
                .map(|contact| contact.distance)
                .fold(f64::INFINITY, f64::min);
            let is_in = nearest < self.body.radius + 0.25 * skin && pushes < MAX_PUSHES;
            let part = contacts.iter().filter_map(free).fold(most, f64::min);
            let shifted = if is_in {
                pushes += 1;
                self.pushed_out(obstacles, &contacts, keeps, &mut rest)
            } else if length <= 1e-3 * skin {
                return;
            } else if part > 0.0 {
                rest -= forward * part;
                if part > 2.0 * skin {
                    pushes = 0;
                    planes.clear();
                }
                self.shift(forward * part, &mut rest)
            } else {
                contacts.retain(|contact| free(contact) == Some(0.0));
                for &Contact { normal, .. } in &contacts {
                    add_distinct(&mut planes, normal);
                    add_distinct(&mut self.touched, normal);
                }
                let along = along(rest, &planes);
                stopped += 1;
                // With too many planes, continuing may gain nothing.
                if !slides || stopped == MAX_STOPS || along.length() > (1.0 - 0.1 * ALONG * ALONG) * length {
                    return;
                }
                rest = along;
                // Continue a little farther from the wall, where the edges that its faces share do not stop the body.
                self.pushed_out(obstacles, &contacts, keeps, &mut rest)
            };
            if shifted {
                near = None;
                planes.clear();
            }
        }
        self.complete = false;
    }

    /// Pushes the body away from the nearest contact until it keeps its distance, unless that leads closer to another
    /// face. Returns `true` if that crossed a portal.
    fn pushed_out(
        &mut self,
        obstacles: &Obstacles,
        contacts: &[Contact],
        keeps: f64,
        rest: &mut DVec3,
    ) -> bool {
        let by_distance = |a: &&Contact, b: &&Contact| a.distance.total_cmp(&b.distance);
        let Some(nearest) = contacts.iter().min_by(by_distance) else {
            return false;
        };
        let push = nearest.normal * (keeps - nearest.distance);
        self.is_freer_at(obstacles, push, nearest.distance) && self.shift(push, rest)
    }

    /// Returns `true` if no face is nearer than `depth` after a push.
    fn is_freer_at(&self, obstacles: &Obstacles, push: DVec3, depth: f64) -> bool {
        let mut contacts = Vec::new();
        obstacles.contacts(self.middle() + push, &self.body, depth, &mut contacts);
        contacts.is_empty()
    }

    /// Translates the body. Returns `true` if that crossed a portal; then all vectors are transformed to the new space.
    fn shift(&mut self, by: DVec3, rest: &mut DVec3) -> bool {
        let walked = self.scene.walk(self.location, by.as_vec3().to_array());
        self.location = walked.location;
        self.complete &= walked.complete;
        if walked.crossed.is_empty() {
            return false;
        }
        let map = walked.there_from_here;
        let carried = |vector: DVec3| DAffine3::from(map).transform_vector3(vector);
        *rest = carried(*rest);
        self.body = Body {
            radius: self.body.radius * map.scale(),
            half: self.body.half * map.scale(),
            up: carried(self.body.up).normalize_or(self.body.up),
        };
        for normal in &mut self.touched {
            *normal = carried(*normal).normalize_or_zero();
        }
        self.there_from_here = map * self.there_from_here;
        self.crossed.extend(walked.crossed);
        true
    }
}

/// Obstacles around a position, valid as long as the body stays within `reach`.
struct NearbyObstacles {
    obstacles: Obstacles,
    middle: DVec3,
    reach: f64,
}

impl NearbyObstacles {
    fn serves(&self, middle: DVec3, part: f64) -> bool {
        middle.distance(self.middle) + part <= self.reach
    }
}

/// Adds a normal unless a nearly equal one is in the list or the list is full.
fn add_distinct(normals: &mut Vec<DVec3>, normal: DVec3) {
    const MAX_NORMALS: usize = 16;
    if normals.len() < MAX_NORMALS && !normals.iter().any(|known| known.distance_squared(normal) < 1e-14) {
        normals.push(normal);
    }
}

/// Returns the longest projection of a step that enters none of the planes: the step itself, along one plane, along the
/// crease of two, or zero.
fn along(step: DVec3, normals: &[DVec3]) -> DVec3 {
    let slack = 0.5 * ALONG * step.length();
    let is_free = |way: &DVec3| normals.iter().all(|normal| way.dot(*normal) >= -slack);
    if is_free(&step) {
        return step;
    }
    let on_one = normals.iter().map(|&normal| step - normal * step.dot(normal));
    let creases = normals.iter().enumerate().flat_map(|(i, a)| {
        normals[..i].iter().map(move |b| {
            let crease = a.cross(*b).normalize_or_zero();
            crease * crease.dot(step)
        })
    });
    on_one
        .chain(creases)
        .filter(is_free)
        .max_by(|a, b| a.dot(step).total_cmp(&b.dot(step)))
        .filter(|way| way.dot(step) > 0.0)
        .unwrap_or(DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_of_a_step_goes_along_a_wall_a_crease_or_nowhere() {
        let step = DVec3::new(1.0, 2.0, 3.0);
        assert_eq!(along(step, &[DVec3::Y]), step);
        assert_eq!(along(step, &[-DVec3::Y]), DVec3::new(1.0, 0.0, 3.0));
        assert_eq!(along(step, &[-DVec3::Y, -DVec3::X]), DVec3::new(0.0, 0.0, 3.0));
        assert_eq!(along(step, &[-DVec3::Y, -DVec3::X, -DVec3::Z]), DVec3::ZERO);
    }
}
