//! Survey: views in the open space of a scene, the same for the same scene.
//!
//! Idea: stand on the free segment between a point of a surface and the next surface, and look level. A place inside
//!     a solid is told by rays in many directions: nearly all of them end at the backs of faces.
//! Source: after the random walks of visibility sampling; the rule is stated with [`survey`].
//! Cost: about thirty rays a candidate, and at most [`CLUSTERS_PER_TRY`] clusters a candidate on average: many items at
//!     one position end the survey early, for every ray would meet them all.
//! No promise: what is inside a solid with wrongly wound faces may pass for open space, and the other way round.

use super::cast::line_of;
use crate::content::{Content, ItemId};
use crate::fragment::{Hit, Ray};
use crate::scene::{FragmentId, Scene};
use glam::DVec3;
use std::cell::Cell;

/// A place in open space, and where to look from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standpoint {
    /// The fragment that it stands in.
    pub fragment: FragmentId,
    /// Its place, in the space of the fragment.
    pub eye: [f32; 3],
    /// A point straight ahead, level with the eye.
    pub toward: [f32; 3],
}

/// Up to `count` places in the open space of a scene, chosen by a fixed seed.
///
/// Pick an item, a point on it and a direction at random; stand at a random fraction of the free segment to the next
/// surface, at least 1 % of its length from both ends; look level in a random direction, but not straight at a wall.
/// Places inside solids or hard against a surface are left out. Fewer are returned where no more are found, or where
/// thousands of items overlap; none where the scene has no open space.
pub fn survey(scene: &Scene, count: usize) -> Vec<Standpoint> {
    let seed = 0x656E_6669_6C61_6465;
    survey_by(scene, scene.fragments(), TRIES * count, count, seed).0
}

/// The same in one fragment alone, at other places than [`survey`] finds there. It looks longer, so that places are found also
/// where little is open, or little is above the ground.
pub fn survey_in(scene: &Scene, fragment: FragmentId, count: usize) -> Vec<Standpoint> {
    let seed = u64::from(fragment.0);
    survey_by(scene, std::iter::once(fragment), 8 * TRIES * count, count, seed).0
}

/// Also returns how many clusters rays met.
fn survey_by(
    scene: &Scene,
    fragments: impl Iterator<Item = FragmentId>,
    tries: usize,
    count: usize,
    seed: u64,
) -> (Vec<Standpoint>, u64) {
    let contents: Vec<(FragmentId, &Content)> = fragments
        .filter_map(|id| scene.content(id).map(|content| (id, &**content)))
        .filter(|(_, content)| content.items().iter().any(|item| !item.bounds.is_empty()))
        .collect();
    let mut found = Vec::new();
    if contents.is_empty() {
        return (found, 0);
    }
    let mut dice = Dice(seed);
    let work = Work {
        met: Cell::new(0),
        limit: CLUSTERS_PER_TRY * tries as u64,
    };
    for _ in 0..tries {
        if found.len() == count || work.is_too_much() {
            break;
        }
        let items: usize = contents.iter().map(|(_, content)| content.items().len()).sum();
        let mut item = dice.below(items);
        let home = contents.iter().find(|(_, content)| {
            let here = item < content.items().len();
            item -= if here { 0 } else { content.items().len() };
            here
        });
        let Some(&(fragment, content)) = home else {
            continue;
        };
        let Some(place) = place_in_the_open(content, ItemId(item as u32), &mut dice, &work) else {
            continue;
        };
        let eye = place.as_vec3().to_array();
        // Where fragments overlap the eye belongs to the smallest: it must be open there too.
        if let Some(toward) = look_level(content, place, &mut dice, &work)
            && !work.is_too_much()
            && scene.locate(eye, toward.as_vec3().to_array()) == Some(fragment)
        {
            found.push(Standpoint {
                fragment,
                eye,
                toward: toward.as_vec3().into(),
            });
        }
    }
    (found, work.met.get())
}

/// Candidates for each place wanted, before a scene is said to have no open space.
const TRIES: usize = 64;

/// Clusters that the rays of a candidate may meet, on average over all that may be tried. Real scenes need a tenth for
/// those that are.
const CLUSTERS_PER_TRY: u64 = 4096;

/// How many clusters rays have met, and may meet.
struct Work {
    met: Cell<u64>,
    limit: u64,
}

impl Work {
    fn is_too_much(&self) -> bool {
        self.met.get() > self.limit
    }

    /// As [`Content::cast`]; meets nothing any more once too much was met.
    fn cast(&self, content: &Content, ray: &Ray) -> Option<Hit> {
        let line = line_of(ray).filter(|_| !self.is_too_much())?;
        content.first_along(&line, f64::INFINITY, |_| {
            self.met.set(self.met.get() + 1);
            true
        })
    }
}

/// A point on the free segment from a face of an item to the next surface.
fn place_in_the_open(content: &Content, item: ItemId, dice: &mut Dice, work: &Work) -> Option<DVec3> {
    let mesh = content.mesh_of(item);
    if mesh.face_count() == 0 {
        return None;
    }
    let face = mesh.face(dice.below(mesh.face_count() as usize) as u32);
    let transform = content.item(item).transform();
    let corner = |i: usize| {
        transform
            .0
            .transform_point3(DVec3::from(mesh.positions()[face[i] as usize].map(f64::from)))
    };
    let last = 2 + dice.below(face.len() - 2);
    let [mut u, mut v] = [dice.fraction(), dice.fraction()];
    if u + v > 1.0 {
        [u, v] = [1.0 - u, 1.0 - v];
    }
    let start = corner(0) * (1.0 - u - v) + corner(last - 1) * u + corner(last) * v;
    let direction = dice.direction();
    let size = f64::from(content.bounds().longest_side());
    // Off the surface by what f32 loses, so that the ray does not end where it begins.
    let start = start + direction * (1e-5 * size);
    let free = distance(content, start, direction, work)?;
    let place = start + direction * (free * (0.01 + 0.98 * dice.fraction()));
    is_open(content, place, size, work).then_some(place)
}

/// The distance to the next surface; `None` where there is none.
fn distance(content: &Content, from: DVec3, direction: DVec3, work: &Work) -> Option<f64> {
    let ray = Ray {
        origin: from.as_vec3().into(),
        direction: direction.as_vec3().into(),
    };
    work.cast(content, &ray).map(|hit| hit.distance)
}

/// Is a place neither inside a solid nor hard against a surface?
fn is_open(content: &Content, place: DVec3, size: f64, work: &Work) -> bool {
    let (mut hits, mut from_behind, mut nearest) = (0, 0, f64::INFINITY);
    for i in 0..DIRECTIONS {
        let ray = Ray {
            origin: place.as_vec3().into(),
            direction: spread(i).as_vec3().into(),
        };
        if let Some(hit) = work.cast(content, &ray) {
            hits += 1;
            from_behind += usize::from(hit.from_behind);
            nearest = nearest.min(hit.distance);
        }
    }
    10 * from_behind < 9 * hits && nearest > CLEARANCE * size
}

/// Free space around an eye, relative to the fragment's size.
const CLEARANCE: f64 = 1e-3;
const DIRECTIONS: usize = 26;

/// Directions spread evenly over the sphere, by the golden angle.
fn spread(i: usize) -> DVec3 {
    let height = 1.0 - (2 * i + 1) as f64 / DIRECTIONS as f64;
    let around = i as f64 * 2.399_963_229_728_653;
    let radius = (1.0 - height * height).sqrt();
    DVec3::new(radius * around.cos(), height, radius * around.sin())
}

/// A level direction with some depth before it: of a few, the first that reaches as far as the median of them.
fn look_level(content: &Content, place: DVec3, dice: &mut Dice, work: &Work) -> Option<DVec3> {
    let ahead: [DVec3; 5] = std::array::from_fn(|_| {
        let angle = std::f64::consts::TAU * dice.fraction();
        DVec3::new(angle.cos(), 0.0, angle.sin())
    });
    let depth = ahead.map(|direction| distance(content, place, direction, work).unwrap_or(f64::INFINITY));
    let mut sorted = depth;
    sorted.sort_by(f64::total_cmp);
    let chosen = depth.iter().position(|&free| free >= sorted[2])?;
    let reach = depth[chosen].min(f64::from(content.bounds().longest_side()));
    Some(place + ahead[chosen] * reach)
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
            let (_, met) = survey_by(&scene, scene.fragments(), TRIES * 4, 4, 1);
            let most = CLUSTERS_PER_TRY * 4 * TRIES as u64 + items as u64;
            assert!(met > 0 && met <= most, "{items} items: {met} clusters");
        }
    }
}
