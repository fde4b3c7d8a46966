//! What may be seen at each sample, told by rays that follow portals.

use super::bundle::{Bundle, RAYS};
use super::tree::{Built, Found, Meeting, Trees};
use super::truth::{Chain, Possible, Sample, Truth};
use super::{DELTA_PX, EPSILON};
use crate::content::{ItemId, OpeningId, Owner};
use crate::passage::next_chain;
use crate::scene::{FragmentId, Scene};
use crate::view::View;
use crate::viewer::Limits;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;

/// A scene, ready to be asked what is really seen.
pub struct Reference {
    fragments: Vec<Option<Trees>>,
}

impl Reference {
    /// Builds the trees; the slow part. Fragments of the user's own hold nothing for the reference.
    pub fn new(scene: &Scene) -> Reference {
        let mut built = Built::default();
        let fragments = scene
            .fragments()
            .map(|id| scene.content(id).map(|content| Trees::build(content, &mut built)))
            .collect();
        Reference { fragments }
    }

    /// What may be seen at each sample of a view, on all threads of the pool at hand. `limits` are those of the
    /// viewers that will be held against it.
    pub fn see(&self, scene: &Scene, view: &View, limits: &Limits) -> Truth {
        let lens = Lens::new(view);
        let rows = self.rows(scene, view, limits, |x, y, samples| {
            let bundle = lens.bundle(f64::from(x) + 0.5, f64::from(y) + 0.5);
            samples.push((bundle, [true; RAYS]));
        });
        Truth::new(view.size, rows)
    }

    /// What may be seen at so many places of each pixel, chosen by chance and `seed`, by one ray each: what the set of
    /// a strict method must hold. It says nothing of pictures.
    pub fn see_anywhere(&self, scene: &Scene, view: &View, limits: &Limits, places: u32, seed: u64) -> Truth {
        let lens = Lens::new(view);
        let rows = self.rows(scene, view, limits, |x, y, samples| {
            let mut chance = Chance(seed ^ u64::from(x) << 40 ^ u64::from(y) << 20);
            for _ in 0..places {
                let [dx, dy] = [(); 2].map(|()| chance.next());
                let bundle = lens.ray(f64::from(x) + dx, f64::from(y) + dy);
                samples.push((bundle, std::array::from_fn(|ray| ray == 0)));
            }
        });
        Truth::of_set(view.size, rows)
    }

    /// Follows rays row after row; `rays` gives those of pixel (x, y).
    fn rows(
        &self,
        scene: &Scene,
        view: &View,
        limits: &Limits,
        rays: impl Fn(u32, u32, &mut Vec<(Bundle, [bool; RAYS])>) + Sync,
    ) -> Vec<Vec<Sample>> {
        let Some(fragment) = scene.fragment_of(view) else {
            return Vec::new();
        };
        let row = |y| {
            let mut bundles = Vec::new();
            (0..view.size[0]).for_each(|x| rays(x, y, &mut bundles));
            let sample = |&(bundle, active): &(Bundle, [bool; RAYS])| {
                let mut look = Look {
                    reference: self,
                    scene,
                    limits,
                    near: f64::from(view.near),
                    rays: Default::default(),
                };
                let way = Way {
                    fragment,
                    bundle,
                    active,
                    entry: [0.0; RAYS],
                    depth: 0,
                    chain: u64::from(fragment.0),
                };
                look.follow(&way, [true; RAYS]);
                let sent = active.iter().filter(|&&active| active).count();
                Sample::of(&look.rays[..sent])
            };
            bundles.iter().map(sample).collect()
        };
        (0..view.size[1]).into_par_iter().map(row).collect()
    }
}

/// Numbers by chance, the same for the same seed. Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators,
/// 2014.
struct Chance(u64);

impl Chance {
    /// From 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ mixed >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Directions of rays, computed from the view as its docs state it, not as the methods do.
struct Lens {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    focal: f64,
    middle: [f64; 2],
}

impl Lens {
    fn new(view: &View) -> Lens {
        let [eye, toward, up] = [view.eye, view.toward, view.up].map(|v| DVec3::from(v.map(f64::from)));
        let forward = (toward - eye).normalize();
        let upright = [up, DVec3::Z, DVec3::X]
            .into_iter()
            .map(|up| forward.cross(up.normalize_or_zero()));
        let right = upright
            .into_iter()
            .find(|r| r.length_squared() > 1e-16)
            .unwrap_or(DVec3::X)
            .normalize();
        let [width, height] = view.size.map(f64::from);
        let half_tangent = f64::from((0.5 * f64::from(view.fov_y)).tan() as f32);
        Lens {
            eye,
            forward,
            right,
            up: right.cross(forward),
            focal: 0.5 * height / half_tangent,
            middle: [0.5 * width, 0.5 * height],
        }
    }

    /// The rays through the sample at (x, y), and about it.
    fn bundle(&self, x: f64, y: f64) -> Bundle {
        let places = [[0.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
        Bundle {
            origin: self.eye,
            directions: places.map(|[dx, dy]| self.direction(x + dx * DELTA_PX, y + dy * DELTA_PX)),
        }
    }

    /// The ray through (x, y) alone.
    fn ray(&self, x: f64, y: f64) -> Bundle {
        Bundle {
            origin: self.eye,
            directions: [self.direction(x, y); RAYS],
        }
    }

    fn direction(&self, x: f64, y: f64) -> DVec3 {
        let [right, down] = [
            (x - self.middle[0]) / self.focal,
            (y - self.middle[1]) / self.focal,
        ];
        self.forward + self.right * right - self.up * down
    }
}

/// What one ray may see, over all ways that it may go.
#[derive(Clone, Default)]
pub(super) struct RaySees {
    pub(super) possible: Vec<Possible>,
    /// Glass in front, and whether it certainly is.
    pub(super) glass: Vec<(Chain, ItemId, bool)>,
}

/// One bundle on its way.
struct Look<'a> {
    reference: &'a Reference,
    scene: &'a Scene,
    limits: &'a Limits,
    near: f64,
    rays: [RaySees; RAYS],
}

/// Where a bundle is: in a fragment, behind a portal.
struct Way {
    fragment: FragmentId,
    bundle: Bundle,
    active: [bool; RAYS],
    /// Where each ray met the last portal; 0 at the eye.
    entry: [f64; RAYS],
    depth: u16,
    chain: u64,
}

/// What one ray meets in a fragment, sorted out when all is known.
#[derive(Default)]
struct Hits {
    nearest: [Nearest; RAYS],
    meetings: Vec<(Meeting, Owner)>,
    active: [bool; RAYS],
    /// Nearer than this a ray sees nothing: the near distance, or the portal.
    from: [f64; RAYS],
}

struct Nearest(f64);

impl Default for Nearest {
    fn default() -> Nearest {
        Nearest(f64::INFINITY)
    }
}

impl Hits {
    /// What is this near to where seeing begins may be seen or not: it is possible, but hides nothing for certain.
    fn certainly_beyond(&self, ray: usize, w: f64) -> bool {
        w > self.from[ray] * (1.0 + EPSILON)
    }

    fn take(&mut self, meeting: Meeting, owner: Owner, certain: bool) {
        let nearest = &mut self.nearest[meeting.ray].0;
        if meeting.w > *nearest * (1.0 + EPSILON) {
            return;
        }
        if meeting.hides && certain && meeting.w < *nearest {
            *nearest = meeting.w;
        }
        self.meetings.push((meeting, owner));
    }
}

impl Found for Hits {
    fn limit(&self) -> f64 {
        let farthest = (0..RAYS)
            .filter(|&ray| self.active[ray])
            .map(|ray| self.nearest[ray].0)
            .fold(0.0, f64::max);
        farthest * (1.0 + 2.0 * EPSILON)
    }

    fn add(&mut self, meeting: Meeting) {
        if meeting.w >= self.from[meeting.ray] * (1.0 - EPSILON) {
            let certain = self.certainly_beyond(meeting.ray, meeting.w);
            self.take(meeting, Owner::Face(meeting.item, meeting.face), certain);
        }
    }
}

impl Look<'_> {
    /// Follows the active rays through a fragment. `certain`: does the ray go this way for certain?
    fn follow(&mut self, way: &Way, certain: [bool; RAYS]) {
        let chain = Chain {
            hash: way.chain,
            fragment: way.fragment,
        };
        let Some(trees) = &self.reference.fragments[way.fragment.0 as usize] else {
            return;
        };
        let mut hits = Hits {
            active: way.active,
            ..Hits::default()
        };
        hits.from = way.entry.map(|entry| entry.max(self.near));
        if !self.scene.is_flat() {
            self.meet_openings(way, trees, &mut hits);
        }
        trees.walk(&way.bundle, way.active, &mut hits);

        let mut ahead: Vec<(OpeningId, [bool; RAYS], [f64; RAYS])> = Vec::new();
        let mut alone = [true; RAYS];
        for ray in (0..RAYS).filter(|&ray| way.active[ray]) {
            let nearest = hits.nearest[ray].0;
            let mine = || {
                hits.meetings
                    .iter()
                    .filter(move |(meeting, _)| meeting.ray == ray)
            };
            let before = self.rays[ray].possible.len();
            for (meeting, owner) in
                mine().filter(|(meeting, _)| meeting.hides && meeting.w <= nearest * (1.0 + EPSILON))
            {
                match *owner {
                    Owner::Opening(opening) if self.leads_on(way, opening) => {
                        let place = ahead
                            .iter()
                            .position(|(known, ..)| *known == opening)
                            .unwrap_or_else(|| {
                                ahead.push((opening, [false; RAYS], [0.0; RAYS]));
                                ahead.len() - 1
                            });
                        ahead[place].1[ray] = true;
                        ahead[place].2[ray] = meeting.w;
                    }
                    owner => self.rays[ray].possible.push(Possible {
                        chain,
                        owner: Some(owner),
                    }),
                }
            }
            if nearest == f64::INFINITY {
                self.rays[ray].possible.push(Possible { chain, owner: None });
            }
            let ways = ahead.iter().filter(|(_, rays, _)| rays[ray]).count();
            alone[ray] = ways == 1 && self.rays[ray].possible.len() == before;
            for (meeting, owner) in mine().filter(|(meeting, _)| !meeting.hides) {
                let Owner::Face(item, _) = *owner else { continue };
                let in_front = meeting.w < nearest * (1.0 - EPSILON);
                let sure = certain[ray] && in_front && hits.certainly_beyond(ray, meeting.w);
                self.rays[ray].glass.push((chain, item, sure));
            }
        }
        for (opening, active, entry) in ahead {
            self.go_through(
                way,
                opening,
                active,
                entry,
                std::array::from_fn(|ray| certain[ray] && alone[ray]),
            );
        }
    }

    fn leads_on(&self, way: &Way, opening: OpeningId) -> bool {
        let portal = self.scene.portal_of(way.fragment, opening);
        portal.is_some_and(|id| self.scene.portals()[id.0 as usize].open)
            && way.depth < self.limits.max_crossings
    }

    fn meet_openings(&self, way: &Way, trees: &Trees, hits: &mut Hits) {
        for (number, opening) in trees.content().openings().iter().enumerate() {
            let corners: Vec<DVec3> = opening
                .outline
                .corners()
                .iter()
                .map(|c| DVec3::from(c.map(f64::from)))
                .collect();
            for ray in (0..RAYS).filter(|&ray| way.active[ray]) {
                for last in 2..corners.len() {
                    let triangle = [corners[0], corners[last - 1], corners[last]];
                    let Some((w, false)) = way.bundle.meets(ray, triangle) else {
                        continue;
                    };
                    // An opening has no near limit: it is seen through even where the eye stands in it.
                    if w >= way.entry[ray] * (1.0 - EPSILON) {
                        let owner = Owner::Opening(OpeningId(number as u16));
                        let certain = way.depth == 0 || w > way.entry[ray] * (1.0 + EPSILON);
                        let meeting = Meeting {
                            ray,
                            w,
                            item: ItemId(u32::MAX),
                            face: 0,
                            hides: true,
                        };
                        hits.take(meeting, owner, certain);
                        break;
                    }
                }
            }
        }
    }

    fn go_through(
        &mut self,
        way: &Way,
        opening: OpeningId,
        active: [bool; RAYS],
        entry: [f64; RAYS],
        certain: [bool; RAYS],
    ) {
        let Some(portal_id) = self.scene.portal_of(way.fragment, opening) else {
            return;
        };
        let portal = &self.scene.portals()[portal_id.0 as usize];
        let there_from_here: DAffine3 = portal.there_from_here.0;
        let next = Way {
            fragment: portal.to,
            bundle: way.bundle.moved(&there_from_here),
            active,
            entry,
            depth: way.depth + 1,
            chain: next_chain(way.chain, portal_id),
        };
        self.follow(&next, certain);
    }
}
