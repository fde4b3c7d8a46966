//! Automatic camera placement: positions at eye height in the open space of a scene, deterministic for a given scene.
//!
//! Idea: find the walkable floors of each geometry, segment them into rooms, and distribute positions over the rooms,
//!     more in large ones, each as far as possible from the others. A room from which most rays hit the solid sides of
//!     faces is rejected: it is inside a solid, or outside a map whose faces point inward. Each connected part that
//!     encloses a volume tells itself which side is solid; see `sides.rs`. Of other faces it is the back, unless the
//!     floors of the whole scene contradict, by a factor of three if some parts enclose volumes: there the winding is
//!     inverted, or the author cared for one side only. Floors that see backs but no open side of an enclosed volume,
//!     though the scene has such, do not count: they may be inside a solid with holes.
//! Source: Mononen, Recast Navigation, 2009, for floors and rooms.
//! Cost: see `floors.rs`; then about three hundred rays per room and two hundred per position.
//! No promise: open space need not have a floor. Without any floor, positions float; see `floating.rs`. Around a small
//! object see `around.rs`.

mod around;
mod floating;
mod floors;
mod hard;
mod rooms;
mod shells;
mod sides;
mod turned;

pub use hard::survey_hard;
pub use turned::{SurveyOptions, survey_with};

use super::cast::line_of;
use super::ray::RayEnd;
use crate::geom::{Aabb, Line, Step, nearest_points};
use crate::geometry::{Geometry, Material};
use crate::ids::{ItemIndex, SectorId};
use crate::random::SplitMix;
use crate::scene::Scene;
use crate::sector::{Hit, Ray};
use floors::{BELOW_ROOF, Floor, Floors, Kind};
use glam::DVec3;
use rooms::{NARROWEST, Room, rooms};
use sides::{AllSides, MOST, ShellKey, Side, Sides};
use smallvec::SmallVec;
use std::cell::Cell;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::AddAssign;

/// Camera position in open space with a target, from [`survey`] or [`survey_hard`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurveyView {
    /// The sector that contains the eye.
    pub sector: SectorId,
    /// Camera position, in the sector's space.
    pub eye: [f32; 3],
    /// Camera target; level with the eye in [`survey`] where something is visible there, anywhere in [`survey_hard`].
    pub toward: [f32; 3],
    /// Whether the camera is above a roof.
    pub on_roof: bool,
}

/// Result of [`survey`]: camera positions in the open space of a scene, and how they were found.
#[doc(alias = "camera placement")]
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Survey {
    /// The positions, distributed over the rooms.
    pub views: Vec<SurveyView>,
    /// Number of connected floors found, such as rooms, streets and roofs; 0 if the positions are around an object, or
    /// float because the scene has no floors.
    pub rooms: usize,
    /// Estimated length of a metre in scene units.
    pub metre: f64,
    /// Whether the winding of the file seems inverted: most of the closed parts that are too small for rooms have their
    /// fronts inside; or, where no part encloses a volume, hardly anything but back faces is visible from above the
    /// floors.
    pub seems_inverted: bool,
}

/// Returns up to `count` camera positions above the walkable floors of a scene, always the same for the same scene.
///
/// Eyes are 1.6 m above floors and ground, some of them halfway up to a higher ceiling, and at least 0.25 m from every
/// face. They are distributed over the rooms and look in a direction in which many items are visible, level if
/// possible. At most an eighth are above roofs. A metre is one unit, unless rooms would be lower than 1.2 m or higher
/// than 40 m.
///
/// No eye is inside a closed part of a mesh whose fronts are outside, or inverted and too small for a room.
///
/// A scene of at most 3 m without a ceiling is an object, as is one in which nothing rises above the floors: eyes are
/// around it and look at its centre.
///
/// Returns fewer positions if it finds no more or if thousands of items overlap, and none if the scene has no open
/// space.
#[doc(alias = "camera placement")]
#[doc(alias = "viewpoint selection")]
pub fn survey(scene: &Scene, count: usize) -> Survey {
    survey_with(scene, count, &SurveyOptions::default())
}

/// Returns positions like [`survey`], but in one sector only and with another seed.
pub fn survey_in(scene: &Scene, sector: SectorId, count: usize) -> Survey {
    let options = SurveyOptions {
        sector: Some(sector),
        ..SurveyOptions::default()
    };
    survey_with(scene, count, &options)
}

/// Eye height above the floor, in metres; lower under low ceilings.
const EYE: f64 = 1.6;
/// Maximum height of the eyes that are halfway up to a ceiling, in metres. They represent wall-mounted cameras.
/// Where a file has only the ceiling of the room below and no floor slab, they are in the room above.
const HIGHEST_EYE: f64 = 3.0;
/// Minimum distance of an eye from all faces, in metres.
const CLEARANCE: f64 = 0.25;
/// Candidate floors for each position.
const TRIES: usize = 64;
/// Number of positions in a room that a new one keeps away from.
const LATEST: usize = 256;
/// Maximum mean number of clusters tested per ray. Real scenes need a tenth.
const TESTED_PER_RAY: u64 = 512;
/// Number of clusters tested before that mean counts.
const TESTED_AT_FIRST: u64 = 1 << 20;
/// Number of floors per room from which rays are cast to classify the room.
const SAMPLED_FLOORS: usize = 12;
/// Area that counts per item visible from a room, in square metres.
const AREA_PER_ITEM: f64 = 5.0;
/// Maximum side of a scene that is an object, in metres.
const OBJECT: f64 = 3.0;
/// Slope below which rays are steep: the sine of 20 degrees downwards.
const STEEP: f64 = -0.35;
/// Minimum number of hits of other rays that classify a position without the steep ones.
const ENOUGH_HITS: u32 = 2;
/// Minimum fraction of rays that must hit the open sides of faces.
const OPEN: f64 = 0.6;
/// Ratio of back faces to front faces in view that means inverted winding without any evidence by volume.
const HARDLY_ANY_FRONTS: f64 = 4.0;
/// Slope above which a ray shows what rises above a floor: the sine of 6 degrees downwards.
const LEVEL: f64 = -0.1;
/// Directions of the rays that find the closed parts around an eye: along no axis or diagonal, on which edges often are.
const PROBES: [DVec3; 3] = [
    DVec3::new(0.113, 0.971, 0.071),
    DVec3::new(-0.831, 0.317, 0.463),
    DVec3::new(0.521, 0.277, -0.809),
];
/// Range of plausible median room heights, in metres.
const PLAUSIBLE_HEADROOM: [f64; 2] = [1.2, 40.0];
const USUAL_HEADROOM: f64 = 3.0;
/// Number of headrooms that are tested for being those of the inside of solids.
const SAMPLED_HEADROOMS: usize = 1024;

/// A geometry with its floors and rooms.
struct Site<'a> {
    sector: SectorId,
    geometry: &'a Geometry,
    sides: Sides,
    floors: Floors,
    rooms: Vec<Room>,
    /// By floor, in metres.
    clearance: Vec<f32>,
}

struct Surveyor<'a> {
    scene: &'a Scene,
    geometries: Vec<(SectorId, &'a Geometry)>,
    metre: f64,
    is_metre_given: bool,
    dice: SplitMix,
    budget: RayBudget,
    /// Whether the fronts of faces that enclose no volume are on the open side.
    sheets_are_right: bool,
}

impl<'a> Surveyor<'a> {
    fn new(scene: &'a Scene, sectors: impl Iterator<Item = SectorId>, seed: u64) -> Surveyor<'a> {
        let geometries = sectors
            .filter_map(|id| scene.geometry(id).map(|geometry| (id, &**geometry)))
            .filter(|(_, geometry)| geometry.items().iter().any(|item| !item.bounds.is_empty()))
            .collect();
        Surveyor {
            scene,
            geometries,
            metre: 1.0,
            is_metre_given: false,
            dice: SplitMix(seed),
            budget: RayBudget::default(),
            sheets_are_right: true,
        }
    }

    fn survey(self, count: usize) -> Survey {
        self.survey_and_met(count).0
    }

    /// Also returns the number of clusters tested.
    fn survey_and_met(mut self, count: usize) -> (Survey, u64) {
        let mut floors = self.floors();
        if !self.is_metre_given
            && let Some(metre) = self.metre_of(&floors)
        {
            self.metre = metre;
            floors = self.floors();
        }
        let geometries: Vec<&Geometry> = self.geometries.iter().map(|&(_, geometry)| geometry).collect();
        let AllSides {
            sides,
            has_shells,
            is_inverted,
        } = AllSides::of(&geometries, self.metre);
        let mut sites: Vec<Site> = (self.geometries.iter().zip(floors).zip(sides))
            .map(|((&(sector, geometry), floors), sides)| {
                let (rooms, clearance) = rooms(&floors, self.metre);
                Site {
                    sector,
                    geometry,
                    sides,
                    floors,
                    rooms,
                    clearance,
                }
            })
            .collect();
        let mut sampled = self.sampled_rooms(&sites);
        let is_right = !(has_shells && is_inverted);
        let agreement = if has_shells { MOST } else { 1.0 };
        self.sheets_are_right = Sheets::of(&sampled, has_shells).are_right(is_right, agreement);
        let inverted = self.inverted_solids(&sampled);
        for &(site, key) in &inverted {
            sites[site].sides.invert(key);
        }
        sampled.iter_mut().for_each(|room| room.settle(&inverted));
        let sheets = Sheets::of(&sampled, has_shells);
        self.sheets_are_right = sheets.are_right(is_right, agreement);
        let rooms = self.open_rooms(&sites, &sampled);
        let mut found = Survey {
            views: Vec::new(),
            rooms: 0,
            metre: self.metre,
            seems_inverted: if has_shells {
                is_inverted && !self.sheets_are_right
            } else {
                sheets.are_inverted()
            },
        };
        if self.is_an_object(&rooms) {
            found.views = around::places(&mut self, count);
        }
        if found.views.is_empty() {
            found.rooms = rooms.len();
            self.distribute(rooms, count, &mut found);
        }
        if found.views.is_empty() {
            found.rooms = 0;
            found.views = floating::places(&mut self, &sites, count);
        }
        (found, self.budget.tested.get())
    }

    fn floors(&self) -> Vec<Floors> {
        let all = self.geometries.iter();
        all.map(|(_, geometry)| Floors::of(geometry, self.metre))
            .collect()
    }

    /// Estimates a metre in scene units from the median headroom; `None` if one unit is plausible.
    fn metre_of(&self, floors: &[Floors]) -> Option<f64> {
        let covered = covered(floors);
        let metre = metre_by_headroom(&covered)?;
        // One unit is plausible if only the headrooms inside towers and foundations say otherwise.
        let geometries: Vec<&Geometry> = self.geometries.iter().map(|&(_, geometry)| geometry).collect();
        let sides = AllSides::of(&geometries, 1.0).sides;
        let is_open = |&covered: &Covered| {
            let Covered {
                at, floor, headroom, ..
            } = covered;
            let middle = floors[at].place(floor) + DVec3::Y * (0.5 * headroom);
            !self.is_inside_solid(geometries[at], &sides[at], middle)
        };
        let stride = covered.len().div_ceil(SAMPLED_HEADROOMS).max(1);
        let sampled = covered.iter().step_by(stride).copied();
        let open: Vec<Covered> = sampled.filter(is_open).collect();
        metre_by_headroom(&open).and(Some(metre))
    }

    /// Returns what is visible from each room; without rooms from which no ray hits.
    fn sampled_rooms(&mut self, sites: &[Site]) -> Vec<SampledRoom> {
        let rooms = sites.iter().enumerate().flat_map(|(number, site)| {
            let rooms = (0..site.rooms.len()).map(move |room| (number, room));
            rooms.map(move |place| (place, site))
        });
        rooms
            .filter_map(|(place, site)| self.sample_room(site, place))
            .collect()
    }

    /// Returns the doubtful shells whose solid sides are visible from floors in the open, by site.
    fn inverted_solids(&self, sampled: &[SampledRoom]) -> BTreeSet<(usize, ShellKey)> {
        let in_the_open = sampled
            .iter()
            .filter(|sampled| sampled.kind == Kind::Floor && self.is_open(&sampled.seen));
        let all = in_the_open.flat_map(|sampled| {
            let doubtful = sampled.doubtful.iter().filter(|(_, seen)| seen.from_solid_side);
            doubtful.map(|(&key, _)| (sampled.place.0, key))
        });
        all.collect()
    }

    /// Returns the rooms from which mostly the open sides of faces are visible.
    fn open_rooms<'s>(&self, sites: &'s [Site<'a>], sampled: &[SampledRoom]) -> Vec<RoomQuota<'s, 'a>> {
        let open = sampled.iter().filter(|room| self.is_open(&room.seen));
        open.map(|sampled| {
            let site = &sites[sampled.place.0];
            let room = &site.rooms[sampled.place.1];
            RoomQuota {
                site,
                room,
                kind: self.kind_of(site, room),
                items: sampled.items,
                rises: sampled.rises,
                eyes: Vec::new(),
                failed: 0,
            }
        })
        .collect()
    }

    /// Returns the kind of a room. The top of a solid is a floor unless it ends at drops, as the roofs of solid houses do.
    fn kind_of(&self, site: &Site, room: &Room) -> Kind {
        let middle = site.floors.place(room.floors[room.floors.len() / 2]);
        let below = middle - DVec3::Y * (0.5 * BELOW_ROOF * self.metre);
        let margin = (NARROWEST * self.metre / site.floors.side).ceil() as usize;
        let is_ground = room.kind == Kind::Roof
            && self.is_inside_solid(site.geometry, &site.sides, below)
            && !site.floors.ends_at_drops(&room.floors, margin);
        if is_ground { Kind::Floor } else { room.kind }
    }

    /// Casts rays from a room, given by its site and its index there; `None` if no ray hits.
    fn sample_room(&mut self, site: &Site, place: (usize, usize)) -> Option<SampledRoom> {
        let room = &site.rooms[place.1];
        let mut sampled = SampledRoom {
            place,
            kind: room.kind,
            area: room.area,
            seen: Seen::default(),
            doubtful: BTreeMap::new(),
            items: 0,
            rises: false,
        };
        let mut items = BTreeSet::new();
        for _ in 0..SAMPLED_FLOORS {
            let floor = room.floors[self.dice.below(room.floors.len())];
            let around = self.cast_around(site, self.eye(site, floor, false));
            for (at, &(direction, side, hit)) in around.hits.iter().enumerate() {
                items.insert(hit.item.index);
                sampled.rises |= direction.y > LEVEL;
                let mut seen = &mut sampled.seen;
                if let Some(key) = site.sides.doubtful(site.geometry, &hit) {
                    let doubtful = sampled.doubtful.entry(key).or_default();
                    doubtful.from_solid_side |= side == Side::Solid;
                    seen = &mut doubtful.seen;
                }
                if at < around.counted {
                    seen.add(side);
                }
            }
        }
        sampled.items = items.len();
        (sampled.items > 0).then_some(sampled)
    }

    /// Returns `true` if most of the faces seen show their open sides.
    fn is_open(&self, seen: &Seen) -> bool {
        match seen.hits() {
            0 => seen.either > 0,
            hits => f64::from(self.open_sides(seen)) >= OPEN * f64::from(hits),
        }
    }

    fn open_sides(&self, seen: &Seen) -> u32 {
        let sheets = if self.sheets_are_right {
            seen.fronts
        } else {
            seen.backs
        };
        seen.open + sheets
    }

    /// Returns `true` if a point is inside a closed part of a mesh, on its solid side.
    fn is_inside_solid(&self, geometry: &Geometry, sides: &Sides, point: DVec3) -> bool {
        let solid = PROBES.into_iter().filter(|&direction| {
            let hits = self.budget.cast_all(geometry, point, direction);
            sides.is_solid(geometry, &hits)
        });
        2 * solid.count() > PROBES.len()
    }

    /// Returns `true` if the scene is an object to view from outside rather than a place to be in.
    fn is_an_object(&self, rooms: &[RoomQuota]) -> bool {
        let is_small =
            |geometry: &Geometry| f64::from(geometry.bounds().longest_side()) <= OBJECT * self.metre;
        let is_covered = |quota: &RoomQuota| {
            let floors = &quota.site.floors.all;
            (quota.room.floors.iter()).any(|&floor| floors[floor as usize].headroom.is_finite())
        };
        let are_small = self.geometries.iter().all(|(_, geometry)| is_small(geometry));
        let is_flat = !rooms.is_empty() && !rooms.iter().any(|quota| quota.rises);
        !self.geometries.is_empty() && (are_small || is_flat) && !rooms.iter().any(is_covered)
    }

    /// Casts rays in all directions.
    ///
    /// Steep rays downwards count only if hardly any others hit: the ground of many cities goes on below closed
    /// buildings, and shows its front inside.
    fn cast_around(&self, site: &Site, eye: DVec3) -> Around {
        let mut hits = SmallVec::new();
        let mut others = Seen::default();
        let mut counted = 0;
        // The steep directions are the last.
        for direction in (0..DIRECTIONS).map(spread) {
            if let Some(hit) = self.budget.cast(site.geometry, eye, direction) {
                let side = site.sides.of(site.geometry, &hit);
                hits.push((direction, side, hit));
                if direction.y >= STEEP {
                    others.add(side);
                    counted = hits.len();
                }
            }
        }
        if others.hits() < ENOUGH_HITS {
            counted = hits.len();
        }
        Around { hits, counted }
    }

    /// Returns the position of an eye above a floor; with `high`, halfway up to a high ceiling.
    fn eye(&self, site: &Site, floor: u32, high: bool) -> DVec3 {
        let headroom = f64::from(site.floors.all[floor as usize].headroom) / self.metre;
        let above = if high && headroom.is_finite() {
            (0.5 * headroom).clamp(EYE, HIGHEST_EYE)
        } else {
            EYE
        };
        site.floors.place(floor) + DVec3::Y * (self.metre * above.min(0.85 * headroom))
    }

    /// Adds positions one after the other, each in the room with the highest priority.
    fn distribute(&mut self, mut rooms: Vec<RoomQuota<'_, 'a>>, count: usize, found: &mut Survey) {
        let mut on_roofs = 0;
        while found.views.len() < count && !self.budget.is_spent() {
            let roofs_left = 8 * (on_roofs + 1) <= count;
            let next = (rooms.iter_mut())
                .filter(|quota| quota.failed < TRIES && (roofs_left || quota.kind != Kind::Roof))
                .max_by(|a, b| a.priority().total_cmp(&b.priority()));
            let Some(next) = next else { break };
            match self.place_in(next) {
                Some(place) => {
                    on_roofs += usize::from(place.on_roof);
                    next.eyes.push(DVec3::from(place.eye.map(f64::from)));
                    found.views.push(place);
                }
                None => next.failed += TRIES / 4,
            }
        }
    }

    /// Returns a position above one of a few random floors of a room: the free one that is farthest from the latest
    /// others there.
    fn place_in(&mut self, quota: &RoomQuota<'_, 'a>) -> Option<SurveyView> {
        let RoomQuota { site, room, eyes, .. } = quota;
        let is_ground = room.kind == Kind::Roof && quota.kind == Kind::Floor;
        let high = eyes.len().is_multiple_of(3);
        let latest = &eyes[eyes.len().saturating_sub(LATEST)..];
        let clear = |floor: u32| f64::from(site.clearance[floor as usize]);
        let most = room.floors.iter().map(|&floor| clear(floor)).fold(0.0, f64::max);
        let chosen: [u32; TRIES] = std::array::from_fn(|_| room.floors[self.dice.below(room.floors.len())]);
        let mut candidates: Vec<(f64, u32)> = (chosen.into_iter())
            .filter(|&floor| clear(floor) >= (2.0 * CLEARANCE).min(0.7 * most))
            .map(|floor| {
                let eye = self.eye(site, floor, high);
                let distances = latest.iter().map(|&other| eye.distance_squared(other));
                (distances.fold(f64::INFINITY, f64::min), floor)
            })
            .collect();
        candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
        candidates.dedup();
        candidates.into_iter().take(TRIES / 4).find_map(|(_, floor)| {
            let eye = self.eye(site, floor, high).as_vec3();
            let place = eye.as_dvec3();
            let is_open = self.is_open(&self.cast_around(site, place).seen())
                && !is_near_a_face(site.geometry, place, CLEARANCE * self.metre, &self.budget)
                && !self.is_inside_solid(site.geometry, &site.sides, place);
            if !is_open {
                return None;
            }
            let toward = self.target(site.sector, site.geometry, place)?.as_vec3();
            // Where sectors overlap the eye belongs to the smallest.
            let at_home = self.scene.locate(eye.to_array(), toward.to_array()) == Some(site.sector);
            (at_home && !self.budget.is_spent()).then(|| SurveyView {
                sector: site.sector,
                eye: eye.to_array(),
                toward: toward.to_array(),
                on_roof: site.floors.all[floor as usize].kind == Kind::Roof && !is_ground,
            })
        })
    }

    /// Returns a target: of eight random level directions one of the two around which most items are visible, the
    /// deeper; if nothing is, the farthest hit in other directions.
    fn target(&mut self, sector: SectorId, geometry: &Geometry, place: DVec3) -> Option<DVec3> {
        let size = f64::from(geometry.bounds().longest_side());
        let level: [f64; 8] = std::array::from_fn(|_| std::f64::consts::TAU * self.dice.fraction());
        let met = |direction| self.met(sector, place, direction, size);
        let ahead = |angle: f64| DVec3::new(angle.cos(), 0.0, angle.sin());
        let mut candidates: SmallVec<[(usize, f64, DVec3); 8]> = SmallVec::new();
        for angle in level {
            let Some((distance, item)) = met(ahead(angle)) else {
                continue;
            };
            let fan = FAN.map(|[aside, slope]| met(ahead(angle + aside) + DVec3::Y * slope));
            let fan = fan.into_iter().flatten().map(|(_, item)| item);
            let items: BTreeSet<_> = fan.chain([item]).collect();
            candidates.push((items.len(), distance, ahead(angle)));
        }
        candidates.sort_by_key(|&(items, ..)| Reverse(items));
        candidates.truncate(2);
        if candidates.is_empty() {
            let hits = (0..DIRECTIONS).filter_map(|i| Some((1, met(spread(i))?.0, spread(i))));
            candidates.extend(hits);
        }
        let (_, distance, direction) = candidates.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(place + direction * distance.min(size))
    }

    /// Returns the distance and identity of what a ray hits, beyond portals too, which are followed up to a distance.
    fn met(
        &self,
        sector: SectorId,
        place: DVec3,
        direction: DVec3,
        far: f64,
    ) -> Option<(f64, (SectorId, ItemIndex))> {
        if self.budget.is_spent() {
            return None;
        }
        self.budget.begin();
        let ray = Ray {
            origin: place.as_vec3().into(),
            direction: direction.as_vec3().into(),
        };
        let cast = self.scene.cast_until(sector, &ray, far);
        match cast.end {
            RayEnd::Face(hit) => Some((cast.distance, (cast.sector, hit.item.index))),
            _ => None,
        }
    }
}

/// Number of faces seen, by side.
#[derive(Clone, Copy, Default)]
struct Seen {
    /// Open and solid sides of what encloses a volume.
    open: u32,
    solid: u32,
    /// Fronts and backs of other faces.
    fronts: u32,
    backs: u32,
    /// Faces of which either side may be the open one.
    either: u32,
}

impl Seen {
    fn add(&mut self, side: Side) {
        *match side {
            Side::Open => &mut self.open,
            Side::Solid => &mut self.solid,
            Side::Front => &mut self.fronts,
            Side::Back => &mut self.backs,
            Side::Either => &mut self.either,
        } += 1;
    }

    /// Number of faces that tell which side they are seen from.
    fn hits(&self) -> u32 {
        self.open + self.solid + self.fronts + self.backs
    }
}

impl AddAssign for Seen {
    fn add_assign(&mut self, other: Seen) {
        self.open += other.open;
        self.solid += other.solid;
        self.fronts += other.fronts;
        self.backs += other.backs;
        self.either += other.either;
    }
}

/// The hits of rays in all directions.
struct Around {
    hits: SmallVec<[(DVec3, Side, Hit); DIRECTIONS]>,
    /// Number of hits that count, from the first on.
    counted: usize,
}

impl Around {
    fn seen(&self) -> Seen {
        let mut seen = Seen::default();
        for &(_, side, _) in &self.hits[..self.counted] {
            seen.add(side);
        }
        seen
    }
}

/// What is visible from a room.
struct SampledRoom {
    /// Indices of the site and of the room there.
    place: (usize, usize),
    kind: Kind,
    area: f64,
    /// Without doubtful shells, until they are settled.
    seen: Seen,
    doubtful: BTreeMap<ShellKey, Doubtful>,
    /// Number of distinct items visible from it.
    items: usize,
    /// Whether anything rises above its floors.
    rises: bool,
}

/// What is visible of a shell of which it is not known whether it is a room or a solid with inverted winding, as if it
/// were a room.
#[derive(Default)]
struct Doubtful {
    seen: Seen,
    /// Whether its solid side is visible, also by rays that do not count.
    from_solid_side: bool,
}

impl SampledRoom {
    /// Adds the hits on doubtful shells; those in `inverted` are solids.
    fn settle(&mut self, inverted: &BTreeSet<(usize, ShellKey)>) {
        for (key, Doubtful { mut seen, .. }) in std::mem::take(&mut self.doubtful) {
            if inverted.contains(&(self.place.0, key)) {
                (seen.open, seen.solid) = (seen.solid, seen.open);
            }
            self.seen += seen;
        }
    }
}

/// Floor area from which faces that enclose no volume are visible, by their side.
struct Sheets {
    fronts: f64,
    backs: f64,
}

impl Sheets {
    fn of(rooms: &[SampledRoom], has_shells: bool) -> Sheets {
        let mut sheets = Sheets {
            fronts: 0.0,
            backs: 0.0,
        };
        for SampledRoom { kind, area, seen, .. } in rooms {
            let may_be_in_a_solid = has_shells && seen.open == 0 && seen.backs > seen.fronts;
            // The outside of a map whose faces point inward consists of roofs and assumed floors.
            if *kind == Kind::Floor && !may_be_in_a_solid {
                let area_per_hit = area / f64::from(seen.hits().max(1));
                sheets.fronts += area_per_hit * f64::from(seen.fronts);
                sheets.backs += area_per_hit * f64::from(seen.backs);
            }
        }
        sheets
    }

    /// Returns whether the fronts are on the open side: as the shells say, unless the area that contradicts is larger by
    /// a factor.
    fn are_right(&self, shells_are_right: bool, factor: f64) -> bool {
        let [agrees, contradicts] = match shells_are_right {
            true => [self.fronts, self.backs],
            false => [self.backs, self.fronts],
        };
        (contradicts > factor * agrees) != shells_are_right
    }

    fn are_inverted(&self) -> bool {
        self.backs > HARDLY_ANY_FRONTS * self.fronts
    }
}

/// A room and its positions so far.
struct RoomQuota<'s, 'a> {
    site: &'s Site<'a>,
    room: &'s Room,
    kind: Kind,
    /// Number of distinct items visible from it.
    items: usize,
    /// Whether anything rises above its floors.
    rises: bool,
    eyes: Vec<DVec3>,
    failed: usize,
}

impl RoomQuota<'_, '_> {
    /// Returns the Sainte-Laguë quotient of the square root of the area: large rooms get more positions, and small ones
    /// get their first early. The area that counts is limited by what is visible, for the empty plain around a house.
    fn priority(&self) -> f64 {
        let area = self.room.area.min(AREA_PER_ITEM * self.items as f64);
        let weight = if self.kind == Kind::Roof { 0.3 } else { 1.0 };
        weight * area.sqrt() / (0.5 + self.eyes.len() as f64)
    }
}

/// A floor below a ceiling.
#[derive(Clone, Copy)]
struct Covered {
    /// Index of the geometry.
    at: usize,
    floor: u32,
    headroom: f64,
    area: f64,
}

/// Returns all floors below ceilings, by headroom.
fn covered(floors: &[Floors]) -> Vec<Covered> {
    let all = floors.iter().enumerate().flat_map(|(at, floors)| {
        let area = floors.side * floors.side;
        let is_below_ceiling =
            |(_, floor): &(u32, &Floor)| floor.headroom.is_finite() && floor.kind != Kind::Assumed;
        let all = (0..).zip(&floors.all).filter(is_below_ceiling);
        all.map(move |(number, floor)| Covered {
            at,
            floor: number,
            headroom: f64::from(floor.headroom),
            area,
        })
    });
    let mut all: Vec<Covered> = all.collect();
    all.sort_by(|a, b| a.headroom.total_cmp(&b.headroom));
    all
}

/// Estimates a metre in scene units from the median headroom, weighted by area; `None` if one unit is plausible.
fn metre_by_headroom(covered: &[Covered]) -> Option<f64> {
    let half = 0.5 * covered.iter().map(|covered| covered.area).sum::<f64>();
    let mut sum = 0.0;
    let median = covered.iter().find(|covered| {
        sum += covered.area;
        sum >= half
    })?;
    let [least, most] = PLAUSIBLE_HEADROOM;
    (median.headroom > most || median.headroom < least).then_some(median.headroom / USUAL_HEADROOM)
}

/// Returns `true` if any face is nearer to a point than `radius`.
fn is_near_a_face(geometry: &Geometry, point: DVec3, radius: f64, budget: &RayBudget) -> bool {
    let around = Aabb {
        min: (point - radius).as_vec3().to_array(),
        max: (point + radius).as_vec3().to_array(),
    };
    let mut is_near = false;
    budget.begin();
    geometry.items_in_box(&around, |item| {
        let mesh = geometry.mesh_of(item);
        let transform = geometry.item(item).transform();
        mesh.walk([0.0; 3], |step| {
            if is_near || budget.is_spent() {
                return false;
            }
            budget.tested.set(budget.tested.get() + 1);
            let cluster = match step {
                Step::Node(bounds) => return bounds.placed(&transform.0).meets(&around),
                Step::Thing(cluster) => &mesh.clusters()[cluster as usize],
            };
            for face in cluster.faces.clone() {
                let corner = |&at: &u32| DVec3::from(transform.point_f64(mesh.positions()[at as usize]));
                let corners = mesh.face(face);
                for pair in corners[1..].windows(2) {
                    let triangle = [corner(&corners[0]), corner(&pair[0]), corner(&pair[1])];
                    let [near, on] = nearest_points([point, point], triangle);
                    is_near |= near.distance(on) < radius;
                }
            }
            true
        });
    });
    is_near
}

/// Bounds the work per ray: where thousands of items overlap, a ray tests all of them.
#[derive(Default)]
struct RayBudget {
    rays: Cell<u64>,
    /// Clusters tested.
    tested: Cell<u64>,
}

impl RayBudget {
    /// Counts a ray or a query.
    fn begin(&self) {
        self.rays.set(self.rays.get() + 1);
    }

    /// Returns `true` if rays have tested too many clusters on average.
    fn is_spent(&self) -> bool {
        self.tested.get() > TESTED_AT_FIRST + TESTED_PER_RAY * self.rays.get()
    }

    /// Returns the first hit along a ray; `None` once the budget is spent.
    fn cast(&self, geometry: &Geometry, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let ray = Ray {
            origin: origin.as_vec3().into(),
            direction: direction.as_vec3().into(),
        };
        let line = line_of(&ray).filter(|_| !self.is_spent())?;
        self.begin();
        geometry.first_along(&line, f64::INFINITY, |_| {
            self.tested.set(self.tested.get() + 1);
            true
        })
    }

    /// Returns all hits along a ray by distance; those so far once the budget is spent.
    fn cast_all(&self, geometry: &Geometry, origin: DVec3, direction: DVec3) -> Vec<Hit> {
        let mut hits = Vec::new();
        let Some(line) = Line::new(origin, direction).filter(|_| !self.is_spent()) else {
            return hits;
        };
        self.begin();
        let counts = |_: &Material| {
            self.tested.set(self.tested.get() + 1);
            !self.is_spent()
        };
        geometry.along(&line, f64::INFINITY, counts, |hit| {
            hits.push(hit);
            f64::INFINITY
        });
        hits.sort_unstable_by(|a, b| {
            let by_face = (a.item.index, a.face).cmp(&(b.item.index, b.face));
            a.distance.total_cmp(&b.distance).then(by_face)
        });
        hits
    }
}

const DIRECTIONS: usize = 26;
/// Rays that count the items in view, by their angle aside in radians and their slope.
const FAN: [[f64; 2]; 8] = [
    [-0.5, 0.0],
    [-0.25, 0.0],
    [0.25, 0.0],
    [0.5, 0.0],
    [-0.3, 0.25],
    [0.3, 0.25],
    [-0.3, -0.25],
    [0.3, -0.25],
];

/// Returns direction `i` of a spherical Fibonacci lattice.
fn spread(i: usize) -> DVec3 {
    let height = 1.0 - (2 * i + 1) as f64 / DIRECTIONS as f64;
    let around = i as f64 * 2.399_963_229_728_653;
    let radius = (1.0 - height * height).sqrt();
    DVec3::new(radius * around.cos(), height, radius * around.sin())
}

fn direction(dice: &mut SplitMix) -> DVec3 {
    let height = 2.0 * dice.fraction() - 1.0;
    let around = std::f64::consts::TAU * dice.fraction();
    let radius = (1.0 - height * height).sqrt();
    DVec3::new(radius * around.cos(), height, radius * around.sin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Transform;
    use crate::geometry::{GeometryBuilder, Material};
    use crate::ids::MaterialId;
    use crate::mesh::Mesh;
    use crate::method::Method;
    use crate::scene::SceneBuilder;

    /// Builds a scene of `count` pyramids at one position.
    fn pyramids(count: usize) -> Scene {
        let corners = [
            [-4.0, 0.0, -4.0],
            [4.0, 0.0, -4.0],
            [0.0, 0.0, 4.0],
            [0.0, 8.0, 0.0],
        ];
        let faces = [0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0];
        let mut builder = GeometryBuilder::new([Material::opaque([1.0; 3])]);
        let mesh = Mesh::triangles(&corners, &faces, MaterialId(0)).expect("four triangles");
        let mesh = builder.mesh(mesh);
        for _ in 0..count {
            builder.item("pyramid", mesh, Transform::IDENTITY);
        }
        let mut scene = SceneBuilder::new();
        let geometry = builder.build().expect("sound items");
        scene.add("all", geometry, Method::ZBuffer);
        scene.build().expect("one sector")
    }

    #[test]
    fn a_survey_of_items_at_one_position_meets_a_bounded_number_of_clusters() {
        for items in [10, 30_000] {
            let scene = pyramids(items);
            let surveyor = Surveyor::new(&scene, scene.sectors(), 1);
            let met = surveyor.survey_and_met(4).1;
            assert!(
                met > 0 && met <= 2 * TESTED_AT_FIRST,
                "{items} items: {met} clusters"
            );
        }
    }
}
