//! Joins rooms: turns each marked mesh into openings of rooms, and portals through them.

use super::outline::outline;
use super::overlap::overlaps;
use super::sides::{self, LEAST, Rooms, Side, sides};
use super::sky::open_above;
use super::{MarkedMesh, OpeningTarget, Shell, Teleport};
use crate::budget::Budget;
use crate::faults::{Faults, Subject};
use crate::warning::Warnings;
use crate::{AuthoringError, BrokenRule, Room};
use enfilade::{ConvexPolygon, Geometry, OpeningId, Portal, Ray, SectorId, Transform};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Memory of a corner of an opening, in its outlines on both sides and while they are compared, in bytes.
const BYTES_PER_CORNER: u64 = 64;

/// An opening of a room and its target.
struct PlannedPortal {
    /// Index of the marked mesh.
    marked: usize,
    from: usize,
    outline: ConvexPolygon,
    to: usize,
    there_from_here: Transform,
}

/// Builds the rooms with their openings, and the portals between them. Reports and skips invalid marked meshes.
pub(crate) fn join(
    shells: Vec<Shell>,
    mut marked: Vec<MarkedMesh>,
    faults: &mut Faults,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<(Vec<Room>, Vec<Portal>), BrokenRule> {
    // Many may share a mesh, but each has an outline of its own.
    for marked in &marked {
        let corners = marked.faces.iter().map(|(mesh, _)| mesh.positions().len() as u64);
        budget.take(corners.sum::<u64>() * BYTES_PER_CORNER, || marked.spoken.clone())?;
    }
    // Most files are one room without openings, which needs no analysis.
    if shells.len() == 1 && marked.is_empty() {
        return finish(shells, &marked, Analysis::default());
    }
    let bare: Vec<Geometry> = shells
        .iter()
        .map(|shell| shell.builder.clone().build().map_err(BrokenRule::Geometry))
        .collect::<Result<_, _>>()?;
    let spoken: Vec<&str> = shells.iter().map(|shell| &*shell.spoken).collect();
    for (first, second, point) in overlaps(&bare) {
        let [first, second] = [first, second].map(|room| spoken[room].to_owned());
        let why = AuthoringError::RoomsOverlap { first, second, point };
        faults.report(Subject::Room, why, warnings);
    }
    let mut found = find(&bare, &spoken, &marked);
    while !found.bad.is_empty() {
        let bad = std::mem::take(&mut found.bad);
        let mut is_bad = vec![false; marked.len()];
        for (number, why) in bad {
            is_bad[number] = true;
            faults.report(Subject::Portal, why, warnings);
        }
        if !faults.skips_portals() {
            break;
        }
        // Analysed again without them, because a skipped mesh must not cover another or close a room.
        let mut is_bad = is_bad.into_iter();
        marked.retain(|_| !is_bad.next().unwrap_or_default());
        found = find(&bare, &spoken, &marked);
    }
    drop(bare);
    finish(shells, &marked, found)
}

/// Result of analysing the marked meshes.
#[derive(Default)]
struct Analysis {
    leads: Vec<PlannedPortal>,
    /// Whether each room has no ceiling.
    open_above: Vec<bool>,
    /// The invalid marked meshes, in order, with the reason.
    bad: Vec<(usize, AuthoringError)>,
}

/// Analyses all marked meshes.
fn find(rooms: &[Geometry], spoken: &[&str], marked: &[MarkedMesh]) -> Analysis {
    let outlines: Vec<Result<ConvexPolygon, AuthoringError>> = marked
        .par_iter()
        .map(|marked| outline(&marked.faces, &marked.spoken))
        .collect();
    let lids: Vec<ConvexPolygon> = outlines.iter().flatten().cloned().collect();
    let open_above = open_above(rooms, &lids);
    let rooms = Rooms {
        all: rooms,
        open_above: &open_above,
    };
    let found: Vec<Result<Vec<PlannedPortal>, AuthoringError>> = outlines
        .into_par_iter()
        .enumerate()
        .map(|(number, outline)| leads(rooms, spoken, number, &marked[number], outline?))
        .collect();
    let (mut leads, mut bad) = (Vec::new(), Vec::new());
    for (number, found) in found.into_iter().enumerate() {
        match found {
            Ok(found) => leads.extend(found),
            Err(why) => bad.push((number, why)),
        }
    }
    for (first, second, room) in same_places(&leads) {
        let why = AuthoringError::SamePlace {
            first: marked[first].spoken.clone(),
            second: marked[second].spoken.clone(),
            room: spoken[room].to_owned(),
        };
        bad.push((second, why));
    }
    bad.sort_by_key(|&(number, _)| number);
    Analysis {
        leads,
        open_above,
        bad,
    }
}

/// Adds the openings to their rooms and builds the rooms.
fn finish(
    mut shells: Vec<Shell>,
    marked: &[MarkedMesh],
    found: Analysis,
) -> Result<(Vec<Room>, Vec<Portal>), BrokenRule> {
    let mut portals = Vec::with_capacity(found.leads.len());
    for lead in found.leads {
        let opening: OpeningId = shells[lead.from]
            .builder
            .opening(&marked[lead.marked].name, lead.outline);
        portals.push(Portal {
            from: SectorId(lead.from as u32),
            opening,
            to: SectorId(lead.to as u32),
            there_from_here: lead.there_from_here,
            open: true,
        });
    }
    let mut rooms = Vec::with_capacity(shells.len());
    for (number, shell) in shells.into_iter().enumerate() {
        rooms.push(Room {
            name: shell.name,
            geometry: Arc::new(shell.builder.build().map_err(BrokenRule::Geometry)?),
            nodes: shell.nodes,
            non_occluders: shell.non_occluders,
            method: shell.method,
            open_above: found.open_above.get(number).copied().unwrap_or_default(),
            large: None,
        });
    }
    Ok((rooms, portals))
}

/// Returns the openings that one marked mesh creates.
fn leads(
    rooms: Rooms,
    spoken: &[&str],
    number: usize,
    marked: &MarkedMesh,
    outline: ConvexPolygon,
) -> Result<Vec<PlannedPortal>, AuthoringError> {
    let around = OpeningContext {
        rooms,
        spoken,
        marked,
        sides: sides(rooms, &outline),
    };
    let lead = |from, outline, to, there_from_here| PlannedPortal {
        marked: number,
        from,
        outline,
        to,
        there_from_here,
    };
    match &marked.way {
        OpeningTarget::Door { to, one_way } => {
            let (from, to, turned) = around.two_rooms(&outline, *to, *one_way)?;
            let (ahead, back) = if turned {
                (outline.flipped(), outline)
            } else {
                (outline.clone(), outline.flipped())
            };
            let mut leads = vec![lead(from, ahead, to, Transform::IDENTITY)];
            if !one_way {
                leads.push(lead(to, back, from, Transform::IDENTITY));
            }
            Ok(leads)
        }
        OpeningTarget::Teleport(teleport) => {
            let Teleport {
                from,
                exit,
                scale,
                exit_name,
                to,
            } = &**teleport;
            let normal = DVec3::from(outline.normal().map(f64::from));
            // The angle is limited to 80 degrees: a larger one means that the node was never oriented.
            let facing = normal.dot(from.back());
            if facing.abs() < 0.17 {
                let node = marked.spoken.clone();
                return Err(AuthoringError::Edgewise { node });
            }
            let turned = facing < 0.0;
            let room = around.before(turned)?;
            let to = to.or_else(|| sides::around(rooms, exit.place())).ok_or_else(|| {
                AuthoringError::ExitInNoRoom {
                    node: marked.spoken.clone(),
                    exit: exit_name.clone(),
                }
            })?;
            let outline = if turned { outline.flipped() } else { outline };
            Ok(vec![lead(room, outline, to, from.there_from_here(exit, *scale))])
        }
        OpeningTarget::Mirror => {
            let (room, turned) = around.mirrored(&outline)?;
            let outline = if turned { outline.flipped() } else { outline };
            let reflection = Transform::reflection(outline.corners()[0], outline.normal());
            Ok(vec![lead(room, outline, room, reflection)])
        }
    }
}

/// A marked mesh and the rooms on its two sides.
struct OpeningContext<'a> {
    rooms: Rooms<'a>,
    spoken: &'a [&'a str],
    marked: &'a MarkedMesh,
    /// In front of it, behind it.
    sides: [Side; 2],
}

impl OpeningContext<'_> {
    /// Returns the room that a door leads out of, the room that it leads into, and whether the first is behind the
    /// front.
    fn two_rooms(
        &self,
        outline: &ConvexPolygon,
        to: Option<usize>,
        one_way: bool,
    ) -> Result<(usize, usize, bool), AuthoringError> {
        let [front, back] = &self.sides;
        let owner = self.marked.owner;
        // A room that the author names counts even if no rays hit it: rays leave a threshold by its other door.
        let is_named = |room: usize| {
            to == Some(room)
                || to.is_some() && owner == Some(room) && is_around(&self.rooms.all[room], outline)
        };
        let near: Vec<usize> = (0..self.rooms.all.len())
            .filter(|&room| front.part(room).max(back.part(room)) >= LEAST || is_named(room))
            .collect();
        let mut best: Option<(bool, f64, usize, usize)> = None;
        for &a in &near {
            for &b in near.iter().filter(|&&b| b != a) {
                let part = |side: &Side, room: usize| {
                    let part = side.part(room);
                    (part >= LEAST || is_named(room)).then_some(part)
                };
                let (Some(before), Some(behind)) = (part(front, a), part(back, b)) else {
                    continue;
                };
                if to.is_some_and(|to| to != a && to != b) {
                    continue;
                }
                let with_owner = owner.is_some_and(|owner| owner == a || owner == b);
                let pair = (with_owner, before + behind, a, b);
                if best.is_none_or(|(owners, votes, ..)| (with_owner, pair.1) > (owners, votes)) {
                    best = Some(pair);
                }
            }
        }
        let Some((_, _, front, back)) = best else {
            return Err(self.no_two_rooms(to));
        };
        let leads_out_of = match (to, owner) {
            (Some(to), _) => {
                if front == to {
                    back
                } else {
                    front
                }
            }
            (None, Some(owner)) if owner == front || owner == back => owner,
            _ if one_way => {
                return Err(AuthoringError::OneWayFromNowhere {
                    node: self.marked.spoken.clone(),
                    rooms: format!("{} and {}", self.spoken[front], self.spoken[back]),
                });
            }
            _ => front,
        };
        let turned = leads_out_of == back;
        let other = if turned { front } else { back };
        Ok((leads_out_of, other, turned))
    }

    /// Returns the reason why a door does not join two rooms.
    fn no_two_rooms(&self, to: Option<usize>) -> AuthoringError {
        let node = self.marked.spoken.clone();
        let touched = self.sides.iter().filter_map(Side::first).next();
        let Some(room) = touched.or(to) else {
            return AuthoringError::TouchesNoRoom { node };
        };
        let room = self.spoken[room].to_owned();
        match &self.sides {
            [front, back] if front.is_sky && back.is_sky => AuthoringError::OnlySky { node, room },
            [front, back] if front.is_sky || back.is_sky => AuthoringError::OwnSky { node, room },
            [front, back] if front.first().is_none() || back.first().is_none() => {
                AuthoringError::LeadsNowhere { node, room }
            }
            _ => AuthoringError::TouchesOneRoom { node, room },
        }
    }

    /// Returns the room in front of the mesh, or behind it if `turned`.
    fn before(&self, turned: bool) -> Result<usize, AuthoringError> {
        let side = &self.sides[usize::from(turned)];
        let owner = self.marked.owner.filter(|&owner| side.part(owner) >= LEAST);
        let found = owner.or_else(|| side.first());
        found.ok_or_else(|| AuthoringError::TouchesNoRoom {
            node: self.marked.spoken.clone(),
        })
    }

    /// Returns the room of a mirror, and whether its reflecting side is behind the front of its mesh, because the front
    /// faces a wall.
    fn mirrored(&self, outline: &ConvexPolygon) -> Result<(usize, bool), AuthoringError> {
        let room = match self.marked.owner {
            Some(owner) => owner,
            None => self.before(false).or_else(|_| self.before(true))?,
        };
        let [front, back] = [1.0, -1.0].map(|side| free_rays(&self.rooms.all[room], outline, side));
        Ok((room, back > front))
    }
}

/// Returns `true` if the middle of an outline is within the AABB of a room.
fn is_around(room: &Geometry, outline: &ConvexPolygon) -> bool {
    let (held, middle) = (room.bounds(), outline.bounds().center());
    let slack = 1e-4 * outline.bounds().longest_side();
    (0..3).all(|axis| (held.min[axis] - slack..=held.max[axis] + slack).contains(&middle[axis]))
}

/// Rates the free space on one side of an opening, by rays along its normal: 2 for each that hits a front face at some
/// distance, 1 for each that hits nothing, 0 for a near wall or a back face.
fn free_rays(room: &Geometry, outline: &ConvexPolygon, side: f64) -> usize {
    let corners: Vec<DVec3> = points(outline);
    let size = area(&corners).sqrt();
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let ahead = DVec3::from(outline.normal().map(f64::from)) * side;
    let origins = corners
        .iter()
        .map(|corner| (*corner + middle) * 0.5)
        .chain([middle]);
    origins
        .map(|origin| {
            let ray = Ray {
                origin: (origin + ahead * (1e-4 * size)).as_vec3().into(),
                direction: ahead.as_vec3().into(),
            };
            match room.cast(&ray) {
                Some(hit) if hit.from_behind || hit.distance < 0.1 * size => 0,
                Some(_) => 2,
                None => 1,
            }
        })
        .sum()
}

/// Finds marked meshes whose openings duplicate earlier ones: they face the same way in one room and mostly cover each
/// other. Returns the earlier one, the later one (once), and the room.
fn same_places(leads: &[PlannedPortal]) -> Vec<(usize, usize, usize)> {
    let mut by_room: Vec<&PlannedPortal> = leads.iter().collect();
    by_room.sort_by(|a, b| {
        let low = |lead: &PlannedPortal| lead.outline.bounds().min[0];
        a.from.cmp(&b.from).then(low(a).total_cmp(&low(b)))
    });
    let mut found = BTreeMap::new();
    for (place, a) in by_room.iter().enumerate() {
        let bounds = a.outline.bounds();
        let end = bounds.max[0] + bounds.longest_side();
        let near = by_room[place + 1..]
            .iter()
            .take_while(|b| b.from == a.from && b.outline.bounds().min[0] <= end);
        for b in near {
            if found.contains_key(&a.marked) {
                break;
            }
            let [first, second] = [a.marked.min(b.marked), a.marked.max(b.marked)];
            if !found.contains_key(&second) && covers_most(&a.outline, &b.outline) {
                found.insert(second, (first, a.from));
            }
        }
    }
    let named = found.into_iter();
    named
        .map(|(second, (first, room))| (first, second, room))
        .collect()
}

/// Returns `true` if two outlines face the same way, are nearly coplanar, and mostly overlap.
fn covers_most(a: &ConvexPolygon, b: &ConvexPolygon) -> bool {
    let normal = DVec3::from(a.normal().map(f64::from));
    let (a, mut rest, facing) = (
        points(a),
        points(b),
        normal.dot(DVec3::from(b.normal().map(f64::from))),
    );
    let [area_a, area_b] = [&a, &rest].map(|polygon| area(polygon));
    let off = rest
        .iter()
        .map(|corner| normal.dot(*corner - a[0]).abs())
        .fold(0.0, f64::max);
    if facing < 0.99 || off > 0.1 * area_a.min(area_b).sqrt() {
        return false;
    }
    for (i, corner) in a.iter().enumerate() {
        let inward = normal.cross(a[(i + 1) % a.len()] - *corner);
        rest = clipped(&rest, *corner, inward);
    }
    area(&rest) > 0.5 * area_a.min(area_b)
}

fn points(polygon: &ConvexPolygon) -> Vec<DVec3> {
    let corner = |corner: &[f32; 3]| DVec3::from(corner.map(f64::from));
    polygon.corners().iter().map(corner).collect()
}

fn area(polygon: &[DVec3]) -> f64 {
    let sum: DVec3 = polygon
        .windows(2)
        .map(|pair| (pair[0] - polygon[0]).cross(pair[1] - polygon[0]))
        .sum();
    0.5 * sum.length()
}

/// Clips a polygon to the inner side of a line. Sutherland, Hodgman, Reentrant Polygon Clipping, 1974.
fn clipped(polygon: &[DVec3], origin: DVec3, inward: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::new();
    for (i, &here) in polygon.iter().enumerate() {
        let next = polygon[(i + 1) % polygon.len()];
        let [a, b] = [here, next].map(|point| inward.dot(point - origin));
        if a >= 0.0 {
            kept.push(here);
        }
        if (a < 0.0) != (b < 0.0) {
            kept.push(here + (next - here) * (a / (a - b)));
        }
    }
    kept
}
