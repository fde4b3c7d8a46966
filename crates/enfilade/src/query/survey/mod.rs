//! Survey: views from where people stand, the same for the same scene.
//!
//! Idea: find the floors of each content, part them into rooms, and stand in each of them, more often in large ones,
//!     as far from the other places as is possible. A place is left out where rays in all directions mostly meet the backs of
//!     faces: inside of solids, and around maps whose faces are seen from inside alone. Which side is the back is decided by
//!     the floors of the whole scene, for some files have their winding inverted.
//! Source: Mononen, Recast Navigation, 2009, for floors and rooms.
//! Cost: see `floors.rs`; then about a hundred rays a place.
//! No promise: a scene may have open space that has no floor. Where no floor is found, places float; see `floating.rs`.

mod floating;
mod floors;
mod hard;
mod rooms;

pub use hard::survey_hard;

use super::cast::line_of;
use crate::content::{Content, ItemId};
use crate::fragment::{Hit, Ray};
use crate::geom::{Aabb, Step, nearest_points};
use crate::scene::{FragmentId, Scene};
use floors::{Floors, Kind};
use glam::DVec3;
use rooms::{Room, rooms};
use std::cell::Cell;
use std::collections::BTreeSet;

/// A place in open space, and where to look from there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Standpoint {
    /// The fragment that it stands in.
    pub fragment: FragmentId,
    /// Its place, in the space of the fragment.
    pub eye: [f32; 3],
    /// A point straight ahead, level with the eye.
    pub toward: [f32; 3],
    /// Whether it is above a roof.
    pub on_roof: bool,
}

/// Places in the open space of a scene, and how they were found.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Survey {
    /// The places, spread over the rooms.
    pub places: Vec<Standpoint>,
    /// Rooms and streets that were found; 0 where there is no floor, and places float.
    pub rooms: usize,
    /// What was taken for a metre, in scene units.
    pub metre: f64,
    /// Whether most floors show their backs to those who stand on them: the winding of the file seems inverted.
    pub seems_inverted: bool,
}

/// Up to `count` places where people may stand in a scene, chosen by a fixed seed.
///
/// They are 1.6 m above floors and ground, or some halfway to a higher ceiling, at least a quarter of a metre from everything, spread over the rooms, and look
/// level in a direction with some depth. At most an eighth are above roofs. A metre is one unit, unless rooms would be lower
/// than 1.2 m or higher than 40 m.
///
/// Fewer are returned where no more are found, or where thousands of items overlap; none where the scene has no open space.
pub fn survey(scene: &Scene, count: usize) -> Survey {
    let seed = 0x656E_6669_6C61_6465;
    Surveyor::new(scene, scene.fragments(), seed).survey(count)
}

/// The same in one fragment alone, at other places than [`survey`] finds there.
pub fn survey_in(scene: &Scene, fragment: FragmentId, count: usize) -> Survey {
    let seed = u64::from(fragment.0);
    Surveyor::new(scene, std::iter::once(fragment), seed).survey(count)
}

/// Height of an eye above the floor, in metres; lower under low ceilings.
const EYE: f64 = 1.6;
/// Some eyes are higher, in high rooms: those of cameras on walls, of who flies. And floors may lie lower than they seem, where a
/// file has only the ceiling below.
const HIGHEST_EYE: f64 = 3.0;
/// Distance of an eye from everything, in metres.
const CLEARANCE: f64 = 0.25;
/// Candidates for each place wanted.
const TRIES: usize = 64;
/// Faces and clusters that rays may meet on average. Real scenes need a tenth.
const MET_PER_RAY: u64 = 512;
/// So many are met before the average counts.
const MET_AT_FIRST: u64 = 1 << 20;
/// Floors by which a room is judged.
const JUDGED: usize = 12;
/// As much of a room's area counts for each item that is seen from it, in square metres.
const AREA_OF_ITEM: f64 = 20.0;
/// Part of the rays that must meet fronts.
const FRONTS: f64 = 0.6;
/// Heights of rooms that people may be in, in scene units, where one is a metre.
const PLAUSIBLE_HEADROOM: [f64; 2] = [1.2, 40.0];
const USUAL_HEADROOM: f64 = 3.0;

/// A content that is surveyed.
struct Site<'a> {
    fragment: FragmentId,
    content: &'a Content,
    floors: Floors,
    rooms: Vec<Room>,
    /// By floor, in metres.
    clearance: Vec<f32>,
}

struct Surveyor<'a> {
    scene: &'a Scene,
    contents: Vec<(FragmentId, &'a Content)>,
    metre: f64,
    dice: Dice,
    work: Work,
}

impl<'a> Surveyor<'a> {
    fn new(scene: &'a Scene, fragments: impl Iterator<Item = FragmentId>, seed: u64) -> Surveyor<'a> {
        let contents = fragments
            .filter_map(|id| scene.content(id).map(|content| (id, &**content)))
            .filter(|(_, content)| content.items().iter().any(|item| !item.bounds.is_empty()))
            .collect();
        Surveyor {
            scene,
            contents,
            metre: 1.0,
            dice: Dice(seed),
            work: Work::default(),
        }
    }

    fn survey(self, count: usize) -> Survey {
        self.survey_and_met(count).0
    }

    /// Also returns how many clusters rays have met.
    fn survey_and_met(mut self, count: usize) -> (Survey, u64) {
        let mut floors = self.floors();
        if let Some(metre) = metre_of(&floors) {
            self.metre = metre;
            floors = self.floors();
        }
        let sites: Vec<Site> = (self.contents.iter().zip(floors))
            .map(|(&(fragment, content), floors)| {
                let (rooms, clearance) = rooms(&floors, self.metre);
                Site {
                    fragment,
                    content,
                    floors,
                    rooms,
                    clearance,
                }
            })
            .collect();
        let (rooms, seems_inverted) = self.judged(&sites);
        let mut found = Survey {
            places: Vec::new(),
            rooms: rooms.len(),
            metre: self.metre,
            seems_inverted,
        };
        if rooms.is_empty() {
            found.places = floating::places(&mut self, count);
        } else {
            self.spread(rooms, count, &mut found);
        }
        (found, self.work.met.get())
    }

    fn floors(&self) -> Vec<Floors> {
        let all = self.contents.iter();
        all.map(|(_, content)| Floors::of(content, self.metre)).collect()
    }

    /// The rooms from which mostly fronts are seen, and whether those are what files call backs.
    fn judged<'s>(&mut self, sites: &'s [Site<'a>]) -> (Vec<Wanted<'s, 'a>>, bool) {
        let mut judged = Vec::new();
        // Floor area from which fronts are seen, less that from which backs are.
        let mut balance = 0.0;
        for site in sites {
            for room in &site.rooms {
                if let Some((fronts, items)) = self.seen_in(site, room) {
                    // The top of a map that is seen from inside alone is all roofs, and below it is nothing.
                    if room.kind == Kind::Floor {
                        balance += room.area * (2.0 * fronts - 1.0);
                    }
                    judged.push((site, room, fronts, items));
                }
            }
        }
        let seems_inverted = balance < 0.0;
        let wanted = judged.into_iter().filter_map(|(site, room, fronts, items)| {
            let fronts = if seems_inverted { 1.0 - fronts } else { fronts };
            (fronts >= FRONTS).then_some(Wanted {
                site,
                room,
                items,
                taken: 0,
                failed: 0,
            })
        });
        (wanted.collect(), seems_inverted)
    }

    /// The part of the rays from a room that meet fronts, as the file has them, and how many items they meet; `None` where
    /// they meet none.
    fn seen_in(&mut self, site: &Site, room: &Room) -> Option<(f64, usize)> {
        let (mut all, mut items) = ([0, 0], BTreeSet::new());
        for _ in 0..JUDGED {
            let floor = room.floors[self.dice.below(room.floors.len())];
            let eye = self.eye(site, floor, false);
            let [fronts, hits] = self.seen_from(site.content, eye, |item| {
                items.insert(item);
            });
            all = [all[0] + fronts, all[1] + hits];
        }
        (all[1] > 0).then(|| (f64::from(all[0]) / f64::from(all[1]), items.len()))
    }

    /// How many of the rays in all directions meet fronts, and how many meet anything.
    fn seen_from(&self, content: &Content, eye: DVec3, mut met: impl FnMut(ItemId)) -> [u32; 2] {
        let mut seen = [0, 0];
        for i in 0..DIRECTIONS {
            if let Some(hit) = self.work.cast(content, eye, spread(i)) {
                seen = [seen[0] + u32::from(!hit.from_behind), seen[1] + 1];
                met(hit.item);
            }
        }
        seen
    }

    /// The eye of someone who stands on a floor; or higher, halfway to a high ceiling.
    fn eye(&self, site: &Site, floor: u32, high: bool) -> DVec3 {
        let headroom = f64::from(site.floors.all[floor as usize].headroom) / self.metre;
        let above = if high && headroom.is_finite() {
            (0.5 * headroom).clamp(EYE, HIGHEST_EYE)
        } else {
            EYE
        };
        site.floors.place(floor) + DVec3::Y * (self.metre * above.min(0.85 * headroom))
    }

    /// Takes places in the rooms, the next one always where the area for each is the largest.
    fn spread(&mut self, mut rooms: Vec<Wanted<'_, 'a>>, count: usize, found: &mut Survey) {
        let mut on_roofs = 0;
        while found.places.len() < count && !self.work.is_too_much() {
            let roofs_left = 8 * (on_roofs + 1) <= count;
            let next = (rooms.iter_mut())
                .filter(|wanted| wanted.failed < TRIES && (roofs_left || wanted.room.kind != Kind::Roof))
                .max_by(|a, b| a.urgency().total_cmp(&b.urgency()));
            let Some(next) = next else { break };
            match self.place_in(next, found) {
                Some(place) => {
                    on_roofs += usize::from(place.on_roof);
                    next.taken += 1;
                    found.places.push(place);
                }
                None => next.failed += TRIES / 4,
            }
        }
    }

    /// Of some floors of a room the one that is farthest from other places, if one can stand there.
    fn place_in(&mut self, wanted: &Wanted<'_, 'a>, found: &Survey) -> Option<Standpoint> {
        let Wanted { site, room, .. } = wanted;
        let high = wanted.taken.is_multiple_of(3);
        let clear = |floor: u32| f64::from(site.clearance[floor as usize]);
        let most = room.floors.iter().map(|&floor| clear(floor)).fold(0.0, f64::max);
        let chosen: [u32; TRIES] = std::array::from_fn(|_| room.floors[self.dice.below(room.floors.len())]);
        let mut candidates: Vec<(f64, u32)> = (chosen.into_iter())
            .filter(|&floor| clear(floor) >= (2.0 * CLEARANCE).min(0.7 * most))
            .map(|floor| {
                let eye = self.eye(site, floor, high);
                let others = found
                    .places
                    .iter()
                    .filter(|place| place.fragment == site.fragment);
                let nearest = others
                    .map(|place| eye.distance_squared(DVec3::from(place.eye.map(f64::from))))
                    .fold(f64::INFINITY, f64::min);
                (nearest, floor)
            })
            .collect();
        candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
        candidates.dedup();
        candidates.into_iter().take(TRIES / 4).find_map(|(_, floor)| {
            let eye = self.eye(site, floor, high).as_vec3();
            let place = eye.as_dvec3();
            let [fronts, hits] = self.seen_from(site.content, place, |_| {});
            let fronts = if found.seems_inverted {
                hits - fronts
            } else {
                fronts
            };
            let is_open = f64::from(fronts) >= FRONTS * f64::from(hits)
                && !is_near_a_face(site.content, place, CLEARANCE * self.metre, &self.work);
            if !is_open {
                return None;
            }
            let toward = self.look_level(site.content, place)?.as_vec3();
            // Where fragments overlap the eye belongs to the smallest.
            let at_home = self.scene.locate(eye.to_array(), toward.to_array()) == Some(site.fragment);
            (at_home && !self.work.is_too_much()).then(|| Standpoint {
                fragment: site.fragment,
                eye: eye.to_array(),
                toward: toward.to_array(),
                on_roof: site.floors.all[floor as usize].kind == Kind::Roof,
            })
        })
    }

    /// A level direction with some depth before it: of a few, the first that reaches as far as the median of them.
    fn look_level(&mut self, content: &Content, place: DVec3) -> Option<DVec3> {
        let ahead: [DVec3; 5] = std::array::from_fn(|_| {
            let angle = std::f64::consts::TAU * self.dice.fraction();
            DVec3::new(angle.cos(), 0.0, angle.sin())
        });
        let depth = ahead.map(|direction| {
            let hit = self.work.cast(content, place, direction);
            hit.map_or(f64::INFINITY, |hit| hit.distance)
        });
        let mut sorted = depth;
        sorted.sort_by(f64::total_cmp);
        let chosen = depth.iter().position(|&free| free >= sorted[2])?;
        let reach = depth[chosen].min(f64::from(content.bounds().longest_side()));
        Some(place + ahead[chosen] * reach)
    }
}

/// A room, and how many places are in it.
struct Wanted<'s, 'a> {
    site: &'s Site<'a>,
    room: &'s Room,
    /// How many items were met from it.
    items: usize,
    taken: usize,
    failed: usize,
}

impl Wanted<'_, '_> {
    /// Large rooms come more often, but each early: as Sainte-Laguë gives seats, to the root of the area. An empty plain around a
    /// house counts for no more than what is seen from it.
    fn urgency(&self) -> f64 {
        let area = self.room.area.min(AREA_OF_ITEM * self.items as f64);
        let weight = if self.room.kind == Kind::Roof { 0.3 } else { 1.0 };
        weight * area.sqrt() / (0.5 + self.taken as f64)
    }
}

/// A metre in scene units, where one unit cannot be: by the median height of what is above floors.
fn metre_of(floors: &[Floors]) -> Option<f64> {
    let covered = floors.iter().flat_map(|floors| {
        let area = floors.side * floors.side;
        let all = floors.all.iter().filter(|floor| floor.headroom.is_finite());
        all.map(move |floor| (f64::from(floor.headroom), area))
    });
    let mut covered: Vec<(f64, f64)> = covered.collect();
    covered.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * covered.iter().map(|&(_, area)| area).sum::<f64>();
    let mut sum = 0.0;
    let (median, _) = covered.into_iter().find(|&(_, area)| {
        sum += area;
        sum >= half
    })?;
    let [least, most] = PLAUSIBLE_HEADROOM;
    (median > most || median < least).then_some(median / USUAL_HEADROOM)
}

/// Whether any face is nearer to a point than `radius`.
fn is_near_a_face(content: &Content, point: DVec3, radius: f64, work: &Work) -> bool {
    let around = Aabb {
        min: (point - radius).as_vec3().to_array(),
        max: (point + radius).as_vec3().to_array(),
    };
    let mut is_near = false;
    work.begin();
    content.items_in_box(&around, |item| {
        let mesh = content.mesh_of(item);
        let transform = content.item(item).transform();
        mesh.walk([0.0; 3], |step| {
            if is_near || work.is_too_much() {
                return false;
            }
            work.met.set(work.met.get() + 1);
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

/// How many rays were followed, or questions asked, and how many clusters they have met.
#[derive(Default)]
struct Work {
    rays: Cell<u64>,
    met: Cell<u64>,
}

impl Work {
    fn begin(&self) {
        self.rays.set(self.rays.get() + 1);
    }

    fn is_too_much(&self) -> bool {
        self.met.get() > MET_AT_FIRST + MET_PER_RAY * self.rays.get()
    }

    /// The first face along a ray; nothing is met any more once too much was met.
    fn cast(&self, content: &Content, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let ray = Ray {
            origin: origin.as_vec3().into(),
            direction: direction.as_vec3().into(),
        };
        let line = line_of(&ray).filter(|_| !self.is_too_much())?;
        self.begin();
        content.first_along(&line, f64::INFINITY, |_| {
            self.met.set(self.met.get() + 1);
            true
        })
    }
}

const DIRECTIONS: usize = 26;

/// Directions spread evenly over the sphere, by the golden angle.
fn spread(i: usize) -> DVec3 {
    let height = 1.0 - (2 * i + 1) as f64 / DIRECTIONS as f64;
    let around = i as f64 * 2.399_963_229_728_653;
    let radius = (1.0 - height * height).sqrt();
    DVec3::new(radius * around.cos(), height, radius * around.sin())
}

/// SplitMix64: Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators, OOPSLA 2014.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// From 0 to just below 1.
    fn fraction(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// From 0 to `end` - 1; `end` above 0.
    fn below(&mut self, end: usize) -> usize {
        (self.fraction() * end as f64) as usize
    }

    fn direction(&mut self) -> DVec3 {
        let height = 2.0 * self.fraction() - 1.0;
        let around = std::f64::consts::TAU * self.fraction();
        let radius = (1.0 - height * height).sqrt();
        DVec3::new(radius * around.cos(), height, radius * around.sin())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::content::{ContentBuilder, Material, MaterialId};
    use crate::geom::Transform;
    use crate::mesh::Mesh;
    use crate::method::Method;
    use crate::scene::SceneBuilder;

    /// A scene of so many pyramids at one position.
    fn pyramids(count: usize) -> Scene {
        let corners = [
            [-1.0, 0.0, -1.0],
            [1.0, 0.0, -1.0],
            [0.0, 0.0, 1.0],
            [0.0, 2.0, 0.0],
        ];
        let faces = [0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0];
        let mut builder = ContentBuilder::new([Material::opaque([1.0; 3])]);
        let mesh = Mesh::triangles(&corners, &faces, MaterialId(0)).expect("four triangles");
        let mesh = builder.mesh(mesh);
        for _ in 0..count {
            builder.item("pyramid", mesh, Transform::IDENTITY);
        }
        let mut scene = SceneBuilder::new();
        let content = builder.build().expect("sound items");
        scene.add("all", content, Method::ZBuffer);
        scene.build().expect("one sector")
    }

    #[test]
    fn a_survey_of_items_at_one_position_meets_a_bounded_number_of_clusters() {
        for items in [10, 30_000] {
            let scene = pyramids(items);
            let surveyor = Surveyor::new(&scene, scene.fragments(), 1);
            let met = surveyor.survey_and_met(4).1;
            assert!(
                met > 0 && met <= 2 * MET_AT_FIRST,
                "{items} items: {met} clusters"
            );
        }
    }
}
