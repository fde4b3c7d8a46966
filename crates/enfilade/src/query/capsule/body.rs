//! A body on its way: where it is by now, what it may still go, what it has touched.
//!
//! A step is gone by parts. The distance from a body that is shifted to a convex face is a convex function of the shift, so
//! its slope where the body stands bounds it from below: a part as long as that allows goes through nothing, however fast.
//! Where nothing is left between body and face, what is left of the step goes on along it, or along the crease of two.
//! Source: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996, for advancement that is conservative;
//!     Fauerby, Improved Collision Detection and Response, 2003, for what is left of a step.
//! Cost: some tens of parts at most, each a distance to each triangle near by.
//! Never through a face: a body that begins free keeps its radius from every face, but for what f32 rounds.

use super::obstacles::{Contact, Obstacles};
use crate::geom::Transform;
use crate::query::place::Location;
use crate::scene::{PortalId, Scene};
use glam::DVec3;

/// A capsule in the space of the sector that its middle is in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub(super) radius: f64,
    /// From the middle to each end of the axis.
    pub(super) half: f64,
    pub(super) up: DVec3,
}

impl Body {
    pub(super) fn axis(&self, middle: DVec3) -> [DVec3; 2] {
        let off = self.up * self.half;
        [middle - off, middle + off]
    }
}

/// A body, and how far it has come.
#[derive(Clone)]
pub(super) struct Mover<'a> {
    pub(super) scene: &'a Scene,
    pub(super) place: Location,
    pub(super) body: Body,
    pub(super) there_from_here: Transform,
    pub(super) crossed: Vec<PortalId>,
    /// Unit normals of what has stopped it, in the space that it is in now.
    pub(super) touched: Vec<DVec3>,
    pub(super) complete: bool,
}

/// Parts of one step, at most.
const MAX_PARTS: usize = 512;

/// Things in the way of one step that it slides along, at most: then it is stuck.
const MAX_STOPS: usize = 32;

/// Times that a body is pushed out of what it stands in, at most, in a row.
const MAX_PUSHES: usize = 16;

/// A direction that goes into a face by less than this part of itself goes along it.
const ALONG: f64 = 1e-6;

impl Mover<'_> {
    pub(super) fn middle(&self) -> DVec3 {
        DVec3::from(self.place.position.map(f64::from))
    }

    /// How much more than its radius a body keeps from faces: positions are of f32, and must not round into them.
    fn skin(&self) -> f64 {
        let reach = self.middle().abs().max_element() + self.body.half + self.body.radius;
        (1e-3 * self.body.radius).max(8.0 * f64::from(f32::EPSILON) * reach)
    }

    /// What it stands on, or leans on, there where it is.
    pub(super) fn leans_on(&self) -> Vec<Contact> {
        let skin = self.skin();
        let near = self.body.radius + 3.0 * skin;
        let obstacles = Obstacles::about(self.scene, self.place, &self.body, 3.0 * skin);
        let mut contacts = Vec::new();
        obstacles.contacts(self.middle(), &self.body, near, &mut contacts);
        contacts
    }

    /// Goes a step as far as it can, and on along what is in its way if it `slides`.
    pub(super) fn go(&mut self, step: DVec3, slides: bool) {
        let mut rest = step;
        let mut contacts: Vec<Contact> = Vec::new();
        // What has stopped it where it is now.
        let mut planes: Vec<DVec3> = Vec::new();
        let [mut pushes, mut stopped] = [0; 2];
        let mut near: Option<Near> = None;
        for _ in 0..MAX_PARTS {
            let skin = self.skin();
            let [stops, keeps] = [0.5, 1.0].map(|part| self.body.radius + part * skin);
            let (length, forward) = (rest.length(), rest.normalize_or_zero());
            let size = self.body.half + self.body.radius;
            let middle = self.middle();
            if !(near.as_ref()).is_some_and(|near| near.serves(middle, length.min(size) + skin)) {
                let reach = length.min(8.0 * size) + self.body.radius;
                near = Some(Near {
                    obstacles: Obstacles::about(self.scene, self.place, &self.body, reach),
                    middle,
                    reach,
                });
            }
            let Some(Near { obstacles, .. }) = &near else {
                return;
            };
            // Near openings faces come and go with the way to them.
            let most = if obstacles.has_ways_out() {
                0.5 * self.body.radius
            } else {
                size
            };
            let most = length.min(most);
            obstacles.contacts(middle, &self.body, keeps + most, &mut contacts);
            // How far it may go before a face stops it. What is as good as nothing is nothing: f32 could not tell the
            // places apart, and it would go on and on.
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
                // Where there are too many planes, nothing may be gained by going on.
                if !slides || stopped == MAX_STOPS || along.length() > (1.0 - 0.1 * ALONG * ALONG) * length {
                    return;
                }
                rest = along;
                // It goes on a little farther away: there the edges that two faces of one wall share are not in its way.
                self.pushed_out(obstacles, &contacts, keeps, &mut rest)
            };
            if shifted {
                near = None;
                planes.clear();
            }
        }
        self.complete = false;
    }

    /// Goes away from the nearest of some faces until it keeps off it, if that does not lead nearer to another; says whether
    /// it led through a portal.
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

    /// Is nothing nearer than `depth` after a push?
    fn is_freer_at(&self, obstacles: &Obstacles, push: DVec3, depth: f64) -> bool {
        let mut contacts = Vec::new();
        obstacles.contacts(self.middle() + push, &self.body, depth, &mut contacts);
        contacts.is_empty()
    }

    /// Moves by so much; says whether that led through a portal, and then all is carried to the other space.
    fn shift(&mut self, by: DVec3, rest: &mut DVec3) -> bool {
        let walked = self.scene.walk(self.place, by.as_vec3().to_array());
        self.place = walked.place;
        self.complete &= walked.complete;
        if walked.crossed.is_empty() {
            return false;
        }
        let map = walked.there_from_here;
        let carried = |vector: DVec3| map.0.transform_vector3(vector);
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

/// What stands about a place, and how far a body may go from there before that must be asked again.
struct Near {
    obstacles: Obstacles,
    middle: DVec3,
    reach: f64,
}

impl Near {
    fn serves(&self, middle: DVec3, part: f64) -> bool {
        middle.distance(self.middle) + part <= self.reach
    }
}

/// Adds a normal, if none is nearly the same and there are not very many.
fn add_distinct(normals: &mut Vec<DVec3>, normal: DVec3) {
    const MOST: usize = 16;
    if normals.len() < MOST && !normals.iter().any(|known| known.distance_squared(normal) < 1e-14) {
        normals.push(normal);
    }
}

/// The most of a step that goes into none of some planes: all of it, along one, along the crease of two, or nothing.
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
