//! Which side of a face is open space.
//!
//! Each [shell](super::shells) answers for itself, by the sign of its volume:
//!
//! * **Fronts outside**: a solid. Its inside is no room, whatever else the scene contains. Exception: the shells in which
//!   nearly everything else is, as in a sky dome, the façade of a house or a room whose faces were left facing outwards.
//!   Both sides of these may be open.
//! * **Fronts inside**, and large enough for a camera at eye height: a room if something is in it, or if its backs are not visible from
//!   other floors in the open. Otherwise its winding is inverted, and it is a solid.
//! * **Fronts inside**, and too small: a solid with inverted winding.
//!
//! The winding of the whole file is inverted if most of its shells that cannot be rooms have their fronts inside; then
//! inside and outside are exchanged above. Faces of no shell, such as terrain and single walls, have an open side only by
//! their winding, which the floors of the whole scene judge; see `mod.rs`.
//! Cost: that of the shells; then O(large shells × [`MAX_PARTS`]) tests of bounds and at most [`MAX_ANGLES`] angles.

use super::floors::HEADROOM;
use super::shells::{Shell, Shells};
use crate::geom::Aabb;
use crate::geometry::Geometry;
use crate::ids::ItemIndex;
use crate::sector::Hit;
use glam::DVec3;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

/// Minimum width of a shell that can be a room, in metres.
const WIDTH: f64 = 0.7;
/// Maximum number of shells and items that are tested for being inside others; of more, every second, third, ….
const MAX_PARTS: usize = 1024;
/// Maximum number of faces whose solid angle is computed.
const MAX_ANGLES: usize = 4_000_000;
/// Fraction of the parts that are inside a shell whose fronts are outside, for its inside to be open.
const NEARLY_ALL: f64 = 0.9;
/// Ratio of areas by which inverted winding must outweigh the other.
pub(super) const MOST: f64 = 3.0;
/// Fraction of the area that is considerable.
const CONSIDERABLE: f64 = 0.1;

/// The side from which a face is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// The open side of a shell.
    Open,
    /// The solid side of a shell.
    Solid,
    /// The front of a face of no shell.
    Front,
    /// The back of a face of no shell.
    Back,
    /// A face of a shell around nearly everything.
    Either,
}

/// The open sides of the faces of one geometry.
pub(super) struct Sides {
    /// By mesh.
    shells: Vec<Shells>,
    /// By item and shell, for those that are large enough for a camera at eye height: whether the fronts are on the open side; `None` if
    /// either may be.
    fronts_are_open: BTreeMap<ShellKey, Option<bool>>,
    /// Those that are rooms or inverted solids.
    doubtful: BTreeSet<ShellKey>,
}

/// An item, and a shell of its mesh.
pub(super) type ShellKey = (u32, u32);

/// The open sides of the faces of several geometries.
pub(super) struct AllSides {
    pub(super) sides: Vec<Sides>,
    /// Whether a considerable part of the faces are of shells.
    pub(super) has_shells: bool,
    /// Whether most shells that cannot be rooms have their fronts inside.
    pub(super) is_inverted: bool,
}

impl Sides {
    /// Returns the side of a face from which a ray hits it.
    pub(super) fn of(&self, geometry: &Geometry, hit: &Hit) -> Side {
        match self.shell_of(geometry, hit) {
            Some((key, shell)) => {
                let known = self.fronts_are_open.get(&key).copied();
                match known.unwrap_or(Some(shell.volume > 0.0)) {
                    Some(fronts_are_open) if fronts_are_open != hit.from_behind => Side::Open,
                    Some(_) => Side::Solid,
                    None => Side::Either,
                }
            }
            None if hit.from_behind => Side::Back,
            None => Side::Front,
        }
    }

    /// Returns the shell of a face, if it is not known whether that is a room or a solid with inverted winding.
    pub(super) fn doubtful(&self, geometry: &Geometry, hit: &Hit) -> Option<ShellKey> {
        let (key, _) = self
            .shell_of(geometry, hit)
            .filter(|_| !self.doubtful.is_empty())?;
        self.doubtful.contains(&key).then_some(key)
    }

    /// Exchanges the sides of a shell.
    pub(super) fn invert(&mut self, key: ShellKey) {
        if let Some(Some(fronts_are_open)) = self.fronts_are_open.get_mut(&key) {
            *fronts_are_open = !*fronts_are_open;
        }
    }

    fn shell_of(&self, geometry: &Geometry, hit: &Hit) -> Option<(ShellKey, &Shell)> {
        let item = hit.item.index;
        let shells = &self.shells[geometry.item(item).mesh.0 as usize];
        let shell = shells.of_face(hit.face)?;
        Some(((item.0, shell), &shells.all[shell as usize]))
    }

    /// Returns `true` if the innermost closed shell around the origin of a ray is solid there. `hits` are all hits of
    /// the ray, sorted by distance.
    pub(super) fn is_solid(&self, geometry: &Geometry, hits: &[Hit]) -> bool {
        // By item and shell: how often the ray leaves it minus how often it enters, and its first hit.
        let mut crossed: BTreeMap<ShellKey, (i32, usize)> = BTreeMap::new();
        for (at, hit) in hits.iter().enumerate() {
            if let Some((key, shell)) = self.shell_of(geometry, hit)
                && shell.is_closed
                && self.of(geometry, hit) != Side::Either
            {
                let (left, _) = crossed.entry(key).or_insert((0, at));
                *left += if hit.from_behind { 1 } else { -1 };
            }
        }
        let around = crossed.values().filter(|(left, _)| *left != 0);
        let innermost = around.map(|&(_, first)| first).min();
        innermost.is_some_and(|first| self.of(geometry, &hits[first]) == Side::Solid)
    }
}

impl AllSides {
    pub(super) fn of(geometries: &[&Geometry], metre: f64) -> AllSides {
        let shells = geometries
            .iter()
            .map(|geometry| shells_by_mesh(geometry))
            .collect();
        let mut classifier = Classifier {
            geometries,
            shells,
            room_sized: Vec::new(),
            parts: Vec::new(),
            small: [0.0; 2],
            area: 0.0,
            angles: Cell::new(0),
        };
        classifier.collect(metre);
        classifier.classify()
    }
}

/// Returns the shells of the meshes of a geometry that items use.
fn shells_by_mesh(geometry: &Geometry) -> Vec<Shells> {
    let mut shells: Vec<Option<Shells>> = geometry.meshes().iter().map(|_| None).collect();
    for item in (0..geometry.items().len() as u32).map(ItemIndex) {
        let place = &mut shells[geometry.item(item).mesh.0 as usize];
        place.get_or_insert_with(|| Shells::of(geometry.mesh_of(item)));
    }
    shells.into_iter().map(Option::unwrap_or_default).collect()
}

/// A shell of an item, or an item without shells.
#[derive(Clone, Copy)]
struct Part {
    geometry: usize,
    item: ItemIndex,
    shell: Option<u32>,
    /// In the space of the sector.
    bounds: Aabb,
    area: f64,
    /// Positive if the fronts are outside; 0 for an item without shells.
    volume: f64,
}

/// All shells of a scene.
struct Classifier<'a> {
    geometries: &'a [&'a Geometry],
    /// By geometry and mesh.
    shells: Vec<Vec<Shells>>,
    /// The shells that are large enough for a camera at eye height.
    room_sized: Vec<Part>,
    /// Some of all, evenly spread.
    parts: Vec<Part>,
    /// Area of the items whose other shells have their fronts outside, and inside.
    small: [f64; 2],
    /// Area of all faces.
    area: f64,
    /// Number of faces whose solid angle has been computed.
    angles: Cell<usize>,
}

impl Classifier<'_> {
    fn collect(&mut self, metre: f64) {
        let stride = self.part_count().div_ceil(MAX_PARTS).max(1);
        let mut number = 0;
        let mut keep = |parts: &mut Vec<Part>, part: Part| {
            if number % stride == 0 {
                parts.push(part);
            }
            number += 1;
        };
        for (at, geometry) in self.geometries.iter().enumerate() {
            for item in (0..geometry.items().len() as u32).map(ItemIndex) {
                let placed = geometry.item(item);
                let all = &self.shells[at][placed.mesh.0 as usize];
                let shells = &all.all;
                let part = Part {
                    geometry: at,
                    item,
                    shell: None,
                    bounds: placed.bounds,
                    area: 0.0,
                    volume: 0.0,
                };
                if shells.is_empty() {
                    keep(&mut self.parts, part);
                }
                let transform = placed.transform();
                let scale = transform.scale();
                self.area += all.area * scale * scale;
                let [mut area, mut volume] = [0.0; 2];
                for (number, shell) in shells.iter().enumerate() {
                    let part = Part {
                        shell: Some(number as u32),
                        bounds: shell.bounds.placed(&transform.0),
                        area: shell.area * scale * scale,
                        volume: shell.volume * scale.powi(3),
                        ..part
                    };
                    keep(&mut self.parts, part);
                    if is_room_sized(&part.bounds, metre) {
                        self.room_sized.push(part);
                    } else {
                        area += part.area;
                        volume += part.volume;
                    }
                }
                // Together, because the cavities of a hollow item have their fronts inside.
                self.small[usize::from(volume < 0.0)] += area;
            }
        }
    }

    fn part_count(&self) -> usize {
        let all = self.geometries.iter().zip(&self.shells);
        let counts = all.flat_map(|(geometry, shells)| {
            let items = geometry.items().iter();
            items.map(|item| shells[item.mesh.0 as usize].all.len().max(1))
        });
        counts.sum()
    }

    fn classify(self) -> AllSides {
        let contents: Vec<Vec<usize>> = self.room_sized.iter().map(|outer| self.contents(outer)).collect();
        let [mut outward, inward] = self.small;
        for (outer, contents) in self.room_sized.iter().zip(&contents) {
            if outer.volume > 0.0 && contents.is_empty() {
                outward += outer.area;
            }
        }
        let is_inverted = inward > MOST * outward;
        let of_shells =
            self.small.iter().sum::<f64>() + self.room_sized.iter().map(|outer| outer.area).sum::<f64>();
        let is_solid = |outer: &Part| (outer.volume > 0.0) != is_inverted;
        let around_all = self.around_nearly_all(&contents, is_solid);
        let mut known = vec![(BTreeMap::new(), BTreeSet::new()); self.geometries.len()];
        for ((outer, contents), around_all) in self.room_sized.iter().zip(&contents).zip(around_all) {
            let (fronts_are_open, doubtful) = &mut known[outer.geometry];
            let key = (outer.item.0, outer.shell.unwrap_or_default());
            fronts_are_open.insert(key, (!around_all).then_some(!is_inverted));
            if !is_solid(outer) && contents.is_empty() {
                doubtful.insert(key);
            }
        }
        let sides = self.shells.into_iter().zip(known);
        AllSides {
            sides: (sides.map(|(shells, (fronts_are_open, doubtful))| Sides {
                shells,
                fronts_are_open,
                doubtful,
            }))
            .collect(),
            has_shells: of_shells >= CONSIDERABLE * self.area,
            is_inverted,
        }
    }

    /// Returns for each room-sized shell whether it is one of the solids that contain something, if nearly everything is inside
    /// these.
    fn around_nearly_all(&self, contents: &[Vec<usize>], is_solid: impl Fn(&Part) -> bool) -> Vec<bool> {
        let all = self.room_sized.iter().zip(contents);
        let mut are_around: Vec<bool> = all
            .map(|(outer, contents)| is_solid(outer) && !contents.is_empty())
            .collect();
        let mut is_inside = vec![false; self.parts.len()];
        for (contents, _) in contents.iter().zip(&are_around).filter(|(_, around)| **around) {
            contents.iter().for_each(|&part| is_inside[part] = true);
        }
        let is_around = |part: &Part| {
            let mut around = self
                .room_sized
                .iter()
                .zip(&are_around)
                .filter(|(_, around)| **around);
            around.any(|(outer, _)| outer.is(part))
        };
        let others = self.parts.iter().zip(&is_inside);
        let others: Vec<bool> = others
            .filter(|(part, _)| !is_around(part))
            .map(|(_, &is_inside)| is_inside)
            .collect();
        let inside = others.iter().filter(|&&is_inside| is_inside).count();
        if (inside as f64) < NEARLY_ALL * others.len() as f64 {
            are_around.fill(false);
        }
        are_around
    }

    /// Returns the parts inside a room-sized shell.
    fn contents(&self, outer: &Part) -> Vec<usize> {
        let all = self.parts.iter().enumerate();
        all.filter(|(_, part)| self.contains(outer, part))
            .map(|(at, _)| at)
            .collect()
    }

    /// Returns `true` if a part is inside a room-sized shell and much smaller; `false` when unsure.
    fn contains(&self, outer: &Part, part: &Part) -> bool {
        let (Some(shell), true) = (outer.shell, outer.geometry == part.geometry) else {
            return false;
        };
        let is_within = (0..3).all(|axis| {
            part.bounds.min[axis] >= outer.bounds.min[axis] && part.bounds.max[axis] <= outer.bounds.max[axis]
        });
        // Duplicates do not contain each other.
        if !is_within || outer.is(part) || 2.0 * part.bounds.volume() > outer.bounds.volume() {
            return false;
        }
        let geometry = self.geometries[outer.geometry];
        let item = geometry.item(outer.item);
        let shells = &self.shells[outer.geometry][item.mesh.0 as usize];
        let angles = self.angles.get() + shells.face_count(shell);
        let Some(item_from_sector) = item.transform().inverse().filter(|_| angles <= MAX_ANGLES) else {
            return false;
        };
        self.angles.set(angles);
        let centre = DVec3::from(part.bounds.center().map(f64::from));
        shells.encloses(
            geometry.mesh_of(outer.item),
            shell,
            item_from_sector.0.transform_point3(centre),
        )
    }
}

impl Part {
    fn is(&self, other: &Part) -> bool {
        (self.geometry, self.item, self.shell) == (other.geometry, other.item, other.shell)
    }
}

/// Returns `true` if a camera at eye height fits into bounds.
fn is_room_sized(bounds: &Aabb, metre: f64) -> bool {
    let [x, y, z] = bounds.size().map(f64::from);
    y >= HEADROOM * metre && x.min(z) >= WIDTH * metre
}
