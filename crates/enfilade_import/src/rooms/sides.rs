//! Finds the rooms on the two sides of an opening.
//!
//! Rays start slightly in front of the opening and spread in a cone; each votes for the room whose face it hits first.
//! So a garden whose AABB contains the house gets no votes in an inner room, a thick wall of one room gets few in the
//! next, and a door leaf gets none, because it is closer than the ray origins. A ray that hits nothing votes for the
//! room without a ceiling that its origin is in or above, because it ends in the sky of that room.

use super::sky::{by_size, space};
use enfilade::{Aabb, ConvexPolygon, Geometry, Hit, Ray};
use glam::DVec3;

/// Minimum fraction of the votes for a room to be on that side.
pub(super) const LEAST: f64 = 0.15;
/// Distances of the ray origins from the opening, relative to the square root of its area.
const BEFORE: [f64; 2] = [0.1, 0.3];
/// Number of rays in each of two cones around the central one, and the tangents of their angles.
const AROUND: usize = 6;
const CONES: [f64; 2] = [0.55, 1.4];

/// Rooms before their openings are added, and whether each has no ceiling.
#[derive(Clone, Copy)]
pub(super) struct Rooms<'a> {
    pub(super) all: &'a [Geometry],
    pub(super) open_above: &'a [bool],
}

impl Rooms<'_> {
    fn space(&self, room: usize) -> Aabb {
        space(&self.all[room], self.open_above[room])
    }

    /// Returns the room without a ceiling that a point is in or above; if there are several, the one with the smallest
    /// footprint.
    fn sky_over(&self, near: &[usize], point: DVec3) -> Option<usize> {
        let point = point.as_vec3().into();
        let open = near.iter().copied().filter(|&room| self.open_above[room]);
        let holding = open.filter(|&room| self.space(room).contains(point));
        holding.min_by(|&a, &b| by_size(&self.space(a), &self.space(b)))
    }
}

/// One side of an opening: the fraction of the rays that hit each room first, or end in its sky.
#[derive(Debug, Default)]
pub(super) struct Side {
    parts: Vec<(usize, f64)>,
    /// Whether all rays end in the sky of rooms without a ceiling.
    pub(super) is_sky: bool,
}

impl Side {
    /// Returns the fraction of a room, 0 to 1.
    pub(super) fn part(&self, room: usize) -> f64 {
        let entry = self.parts.iter().find(|(other, _)| *other == room);
        entry.map_or(0.0, |(_, part)| *part)
    }

    /// Returns the rooms on this side.
    pub(super) fn rooms(&self) -> impl Iterator<Item = usize> {
        self.parts
            .iter()
            .filter(|(_, part)| *part >= LEAST)
            .map(|(room, _)| *room)
    }

    /// Returns the room with the most votes.
    pub(super) fn first(&self) -> Option<usize> {
        self.rooms()
            .max_by(|a, b| self.part(*a).total_cmp(&self.part(*b)))
    }
}

/// Returns both sides of an opening: front, then back. Rooms that are not near it get no votes.
pub(super) fn sides(rooms: Rooms, outline: &ConvexPolygon) -> [Side; 2] {
    let corners: Vec<DVec3> = outline
        .corners()
        .iter()
        .map(|corner| DVec3::from(corner.map(f64::from)))
        .collect();
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let reach = corners
        .iter()
        .map(|corner| (*corner - middle).length())
        .fold(0.0, f64::max);
    let near: Vec<usize> = (0..rooms.all.len())
        .filter(|&room| meets(&rooms.space(room), &outline.bounds(), 2.0 * reach))
        .collect();
    let normal = DVec3::from(outline.normal().map(f64::from));
    [normal, -normal].map(|ahead| side(rooms, &near, &corners, middle, ahead))
}

/// Returns the room that most rays in all directions from a point hit first.
pub(super) fn around(rooms: Rooms, point: DVec3) -> Option<usize> {
    let mut votes = Votes::default();
    let all: Vec<usize> = (0..rooms.all.len()).collect();
    for i in 0..26 {
        votes.cast(rooms, &all, point, spread(i, 26));
    }
    votes.side().first()
}

/// Returns directions evenly distributed over the sphere, by the golden angle; the first is nearly straight up.
pub(super) fn spread(i: usize, count: usize) -> DVec3 {
    let height = 1.0 - (2 * i + 1) as f64 / count as f64;
    let angle = i as f64 * 2.399_963_229_728_653;
    let radius = (1.0 - height * height).sqrt();
    DVec3::new(radius * angle.cos(), height, radius * angle.sin())
}

fn side(rooms: Rooms, near: &[usize], corners: &[DVec3], middle: DVec3, ahead: DVec3) -> Side {
    let area: f64 = (0..corners.len())
        .map(|i| {
            let [a, b] = [corners[i] - middle, corners[(i + 1) % corners.len()] - middle];
            0.5 * a.cross(b).length()
        })
        .sum();
    let x = ahead.any_orthonormal_vector();
    let y = ahead.cross(x);
    let mut votes = Votes::default();
    // Four of many corners are enough.
    let step = corners.len().div_ceil(4);
    let places = corners
        .iter()
        .step_by(step)
        .map(|corner| (middle + *corner) * 0.5);
    for place in places.chain([middle]) {
        for before in BEFORE {
            let origin = place + ahead * (before * area.sqrt());
            votes.cast(rooms, near, origin, ahead);
            for (turn, tangent) in CONES.into_iter().enumerate() {
                for i in 0..AROUND {
                    let angle = std::f64::consts::TAU * (i as f64 + 0.5 * turn as f64) / AROUND as f64;
                    let aside = x * angle.cos() + y * angle.sin();
                    votes.cast(rooms, near, origin, ahead + aside * tangent);
                }
            }
        }
    }
    if votes.rays > 0 {
        return votes.side();
    }
    // No ray hits anything, and the sky belongs to no room: use the smallest AABB that contains the point.
    let outside = (middle + ahead * (BEFORE[1] * area.sqrt())).as_vec3().into();
    let volume = |room: &usize| rooms.all[*room].bounds().volume();
    let holds = near
        .iter()
        .filter(|&&room| rooms.all[room].bounds().contains(outside));
    let smallest = holds.min_by(|a, b| volume(a).total_cmp(&volume(b)));
    Side {
        parts: smallest.map(|&room| (room, LEAST)).into_iter().collect(),
        is_sky: false,
    }
}

fn meets(a: &Aabb, b: &Aabb, margin: f64) -> bool {
    !a.is_empty()
        && (0..3).all(|axis| {
            f64::from(a.min[axis]) <= f64::from(b.max[axis]) + margin
                && f64::from(b.min[axis]) <= f64::from(a.max[axis]) + margin
        })
}

#[derive(Default)]
struct Votes {
    rays: usize,
    first: Vec<(usize, usize)>,
    /// Number of rays that end in a sky.
    in_sky: usize,
}

impl Votes {
    /// Casts one ray, which votes if it hits anything or ends in a sky. If walls of several rooms coincide, the room
    /// whose front face is hit gets the vote.
    fn cast(&mut self, rooms: Rooms, near: &[usize], origin: DVec3, direction: DVec3) {
        let ray = Ray {
            origin: origin.as_vec3().into(),
            direction: direction.as_vec3().into(),
        };
        let met: Vec<(usize, Hit)> = near
            .iter()
            .filter_map(|&room| Some((room, rooms.all[room].cast(&ray)?)))
            .collect();
        if met.is_empty() {
            if let Some(room) = rooms.sky_over(near, origin) {
                self.rays += 1;
                self.in_sky += 1;
                self.count(room);
            }
            return;
        }
        let nearest = met
            .iter()
            .map(|(_, hit)| hit.distance)
            .fold(f64::INFINITY, f64::min);
        let first = |hit: &Hit| hit.distance <= nearest * (1.0 + 1e-5);
        let from_behind = met
            .iter()
            .filter(|(_, hit)| first(hit))
            .all(|(_, hit)| hit.from_behind);
        self.rays += 1;
        for (room, hit) in met {
            if first(&hit) && hit.from_behind == from_behind {
                self.count(room);
            }
        }
    }

    fn side(&self) -> Side {
        let part = |votes: usize| votes as f64 / self.rays as f64;
        let parts = self.first.iter().map(|&(room, votes)| (room, part(votes)));
        Side {
            parts: parts.collect(),
            is_sky: self.rays > 0 && self.in_sky == self.rays,
        }
    }

    /// Adds one vote for a room.
    fn count(&mut self, room: usize) {
        match self.first.iter_mut().find(|(other, _)| *other == room) {
            Some((_, votes)) => *votes += 1,
            None => self.first.push((room, 1)),
        }
    }
}
