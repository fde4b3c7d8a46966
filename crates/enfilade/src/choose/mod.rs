//! Which method suits which sector: those that may be taken are tried on views of the scene, and the cheapest is chosen.
//!
//! What a sector costs hangs on how it is seen: through which openings, and how near. So the scene is looked at from all
//! views, and then each sector is tried alone, through the passages by which it was seen.
//! Source: Boreskov, Using portals to create aggregate scenes ("with each sector its own most suitable method"); that it is
//!     measured, and not told by rules, is ours.
//! Cost: for each sector, and each view of those it is tried on, one look (or drawing, by the aim) by every method that may be
//!     taken, and some more by those that are not far from the best. Methods take turns at each view, so that what else the machine
//!     does disturbs all of them alike, and the least time of a view counts. Where the two halves of the views disagree, or the
//!     noise of the clock could decide, the choice is unsure, and the sector keeps its method.

mod trial;

use crate::geom::Transform;
use crate::geometry::{Geometry, ItemId};
use crate::method::{Method, Unsuited};
use crate::passage::Passage;
use crate::scene::{Scene, SectorId};
use crate::sector::Contract;
use crate::view::View;
use crate::viewer::Viewer;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;
use trial::Tried;

/// What methods are chosen for.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ChoiceOptions {
    /// What is to be cheap.
    pub aim: ChoiceGoal,
    /// Only methods whose set is what is seen at the samples of the screen, so that no answer depends on the choice? On unless
    /// told. Else also those that may call more visible; never those that may miss anything.
    pub exact: bool,
    /// Sectors in which an item moves between any two looks.
    pub moving: Vec<SectorId>,
    /// Looks over which what it takes to build a method is spread: 10,000 unless told, some minutes of a game.
    pub frames: u32,
    /// What one sector's method may build, in bytes.
    pub limit_bytes: u64,
    /// Methods that take longer to build, by an estimate, are not tried: 20 s unless told.
    pub max_build_time: Duration,
    /// Number of measurements per view, of which the minimum counts; default 4. Methods far from the best are measured less often.
    pub rounds: u32,
    /// Maximum number of views per sector, taken evenly from those that see it; default 64. The costs of methods vary more from
    /// view to view than from one measurement to the next.
    pub max_views: u32,
}

impl Default for ChoiceOptions {
    fn default() -> ChoiceOptions {
        ChoiceOptions {
            aim: ChoiceGoal::Look,
            exact: true,
            moving: Vec::new(),
            frames: 10_000,
            limit_bytes: Method::DEFAULT_LIMIT,
            max_build_time: Duration::from_secs(20),
            rounds: 4,
            max_views: 64,
        }
    }
}

/// What is to be cheap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ChoiceGoal {
    /// [`Viewer::look`]: the set.
    Look,
    /// [`Viewer::draw`], but for what a canvas does with what it gets.
    Draw,
}

/// The method chosen for a sector, and why.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MethodChoice {
    /// Which sector.
    pub sector: SectorId,
    /// The cheapest method. Of methods at most 12 % slower than the fastest, the one that the sector has, else the one that takes
    /// least memory. The sector's own if nothing could be tried, or if the choice is not sure.
    pub method: Method,
    /// Whether the method is at most 15 % slower than the fastest in both halves of the views, and would still be chosen if 10 % or
    /// 15 % counted as equally fast.
    pub sure: bool,
    /// How many views it was tried on; 0 where none sees it.
    pub views: usize,
    /// Every method, in the order of [`Method::ALL`].
    pub trials: Vec<Trial>,
}

/// What came of trying a method.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Trial {
    /// Which method.
    pub method: Method,
    /// What it cost, or why it was not tried.
    pub outcome: Result<Cost, SkipReason>,
}

/// What a method cost in a sector.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Cost {
    /// To build it, once.
    pub build: Duration,
    /// Memory of what it built and of its buffers for the screen.
    pub bytes: u64,
    /// Mean time to gather what is seen from a view. Where it is not the aim, measured once on every eighth view.
    pub look: Duration,
    /// Mean time to hand the picture of a view to a canvas that does next to nothing. Where it is not the aim, measured once on
    /// every eighth view.
    pub draw: Duration,
    /// To follow one item that moves; 0 where none does.
    pub edit: Duration,
    /// What counts: the aim, the edit, and the frame's part of building.
    pub frame: Duration,
}

/// Why a method was not tried in a sector.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SkipReason {
    /// It cannot see the geometry, or not within the limit.
    #[error(transparent)]
    Unsuited(#[from] Unsuited),
    /// What it promises is less than what is wanted.
    #[error("its set is {0}")]
    Promise(Contract),
    /// Building it sorts and splits faces, of which there are so many that it would take too long, about as long as this.
    #[error("to sort its faces would take about {:.0} s", .0.as_secs_f64().ceil())]
    BuildsTooLong(Duration),
    /// It cannot see the geometry once an item has moved.
    #[error("an item that moves would leave what it cannot see")]
    Moves,
    /// No view sees the sector.
    #[error("no view sees the sector")]
    NotSeen,
}

/// Building a BSP tree over n faces takes about n log₂ n times as long. On fourteen real scenes it was 0.24 to 2.1 µs: trees of
/// furniture split many faces, those of terrain none.
const SORTING_A_FACE: Duration = Duration::from_nanos(900);

/// Methods at most so many times slower than the fastest count as equally fast. On a busy machine ratios of measurements differ by
/// up to 4 % from run to run, so a choice that another threshold would change is unsure. In most rooms of the palace the second best
/// takes 1.0 to 1.1 times as long: a threshold among those would make half of the choices unsure.
const EQUALLY_FAST: [f64; 3] = [1.1, 1.12, 1.15];
/// A choice is sure if it takes at most so many times as long as the best, in both halves of the views.
const NEAR_THE_BEST: f64 = EQUALLY_FAST[2];
/// Methods so many times slower than the best are not measured again: after the first round, and after later ones.
const FAR_FROM_BEST: [f64; 2] = [2.0, 1.3];

/// Some of the views that a method is tried on.
#[derive(Clone, Copy, Debug)]
enum Views {
    All,
    Even,
    Odd,
}

impl Views {
    fn holds(self, view: usize) -> bool {
        match self {
            Views::All => true,
            Views::Even => view.is_multiple_of(2),
            Views::Odd => !view.is_multiple_of(2),
        }
    }
}

/// Finds the method that suits each sector of a scene, but for those of the user's own. The scene stays as it is:
/// [`Scene::set_method`] takes a choice over.
///
/// `views` should stand for how the scene will be looked at; [`survey_in`](crate::survey_in) gives places in a sector. `clock`
/// gives the time since any moment, and never less than before; the library has none of its own. Methods are tried with as many
/// threads as looks may use.
pub fn choose_methods(
    scene: &Scene,
    views: &[View],
    terms: &ChoiceOptions,
    clock: &dyn Fn() -> Duration,
) -> Vec<MethodChoice> {
    let mut viewer = Viewer::new();
    let ways: Vec<Vec<Passage>> = views
        .iter()
        .map(|view| viewer.look(scene, view).passages().to_vec())
        .collect();
    let choices = scene.sectors().filter_map(|sector| {
        let own = scene.method(sector)?;
        let through = ways_into(sector, &ways, terms.max_views);
        Some(choose(scene, sector, own, &through, terms, clock))
    });
    choices.collect()
}

/// The passages that lead into a sector, view by view, of some of the views that see it.
fn ways_into(sector: SectorId, ways: &[Vec<Passage>], most: u32) -> Vec<Vec<&Passage>> {
    let here = ways.iter().map(|passages| {
        let here = passages.iter().filter(|passage| passage.sector == sector);
        here.collect::<Vec<&Passage>>()
    });
    let mut seeing: Vec<Vec<&Passage>> = here.filter(|passages| !passages.is_empty()).collect();
    let (all, most) = (seeing.len(), most.max(1) as usize);
    let mut place = 0;
    seeing.retain(|_| {
        // The views whose share of `most` begins a new whole.
        place += 1;
        all <= most || place * most / all > (place - 1) * most / all
    });
    seeing
}

fn choose(
    scene: &Scene,
    sector: SectorId,
    own: Method,
    through: &[Vec<&Passage>],
    terms: &ChoiceOptions,
    clock: &dyn Fn() -> Duration,
) -> MethodChoice {
    let mut tried: Vec<(Method, Result<Tried, SkipReason>)> = Method::ALL
        .into_iter()
        .map(|method| (method, begin(scene, sector, method, through, terms, clock)))
        .collect();
    measure(&mut tried, through, terms, clock);
    let [lower, cheapest, upper] = EQUALLY_FAST.map(|within| cheapest(&tried, own, terms, within));
    let sure = cheapest.is_some_and(|method| {
        lower == upper
            && [Views::Even, Views::Odd]
                .iter()
                .all(|&half| through.len() < 2 || is_near_the_best(&tried, method, half, terms))
    });
    let trials: Vec<Trial> = tried
        .into_iter()
        .map(|(method, outcome)| Trial {
            method,
            outcome: outcome.map(|tried| tried.cost(terms)),
        })
        .collect();
    MethodChoice {
        sector,
        method: cheapest.filter(|_| sure).unwrap_or(own),
        sure,
        views: through.len(),
        trials,
    }
}

type Outcomes = [(Method, Result<Tried, SkipReason>)];

/// Methods that run, and what a frame of each takes by some of the views.
fn frames(
    tried: &Outcomes,
    views: Views,
    terms: &ChoiceOptions,
) -> impl Iterator<Item = (Method, Duration, u64)> {
    let running = tried
        .iter()
        .filter_map(|(method, tried)| Some((*method, tried.as_ref().ok()?)));
    running.map(move |(method, tried)| (method, tried.frame(views, terms), tried.bytes()))
}

/// Measures all methods that run; those that are far from the best not to the end.
fn measure(
    tried: &mut Outcomes,
    through: &[Vec<&Passage>],
    terms: &ChoiceOptions,
    clock: &dyn Fn() -> Duration,
) {
    let count = tried.len();
    let mut left = vec![true; count];
    for round in 0..terms.rounds.max(1) {
        for (view, passages) in through.iter().enumerate() {
            for turn in 0..count {
                // Another one begins each time: what comes first finds caches that are less warm.
                let place = (turn + view + round as usize) % count;
                if let Ok(tried) = &mut tried[place].1
                    && left[place]
                {
                    tried.run(view, passages, terms.aim, clock);
                }
            }
        }
        let best = frames(tried, Views::All, terms).map(|(_, frame, _)| frame).min();
        let far = best
            .unwrap_or_default()
            .mul_f64(FAR_FROM_BEST[usize::from(round > 0)]);
        for ((_, tried), left) in tried.iter().zip(&mut left) {
            *left &= tried
                .as_ref()
                .is_ok_and(|tried| tried.frame(Views::All, terms) <= far);
        }
    }
}

/// Returns the cheapest method; of those at most `within` times as slow as it the sector's own, else the one that takes least
/// memory, else the first of [`Method::ALL`].
fn cheapest(tried: &Outcomes, own: Method, terms: &ChoiceOptions, within: f64) -> Option<Method> {
    let all = || frames(tried, Views::All, terms);
    let best = all().map(|(_, frame, _)| frame).min()?;
    let as_fast = all().filter(|&(_, frame, _)| frame <= best.mul_f64(within));
    as_fast
        .min_by_key(|&(method, _, bytes)| (method != own, bytes))
        .map(|(method, ..)| method)
}

fn is_near_the_best(tried: &Outcomes, method: Method, views: Views, terms: &ChoiceOptions) -> bool {
    let all = || frames(tried, views, terms);
    let best = all().map(|(_, frame, _)| frame).min().unwrap_or_default();
    all().any(|(other, frame, _)| other == method && frame <= best.mul_f64(NEAR_THE_BEST))
}

/// Builds a method over a sector, if it may be taken there.
fn begin(
    scene: &Scene,
    sector: SectorId,
    method: Method,
    through: &[Vec<&Passage>],
    terms: &ChoiceOptions,
    clock: &dyn Fn() -> Duration,
) -> Result<Tried, SkipReason> {
    let contract = method.contract();
    if contract == Contract::Approximate || (terms.exact && contract != Contract::Exact) {
        return Err(SkipReason::Promise(contract));
    }
    let geometry = scene.geometry(sector).ok_or(SkipReason::NotSeen)?;
    let first = through.first().ok_or(SkipReason::NotSeen)?;
    if method.builds_bsp() {
        let estimate = sorting(geometry.face_count());
        if estimate > terms.max_build_time {
            return Err(SkipReason::BuildsTooLong(estimate));
        }
    }
    let size = first[0].size;
    let mut tried = Tried::build(method, Arc::clone(geometry), size, terms.limit_bytes, clock)?;
    if terms.moving.contains(&sector) {
        tried.edit = edit(scene, sector, method, geometry, clock)?;
    }
    tried.warm_up(first);
    Ok(tried)
}

/// What it takes to follow one item that moves a little and back: of all that may, the one with the fewest faces.
fn edit(
    scene: &Scene,
    sector: SectorId,
    method: Method,
    geometry: &Geometry,
    clock: &dyn Fn() -> Duration,
) -> Result<Duration, SkipReason> {
    let is_ground = |item: u32| {
        geometry
            .terrains()
            .iter()
            .any(|terrain| terrain.blocks.contains(&item))
    };
    let items = (0..geometry.items().len() as u32).map(ItemId);
    let items = items.filter(|&item| geometry.holds(item) && !is_ground(item.0));
    let Some(item) = items.min_by_key(|&item| geometry.mesh_of(item).face_count()) else {
        return Ok(Duration::ZERO);
    };
    let mut scene = scene.clone();
    scene.set_method(sector, method).map_err(|_| SkipReason::Moves)?;
    let here = geometry.item(item).transform();
    // Out of whatever plane it may lie in: a wall that slides along itself would leave a room convex.
    let step = 0.01 * geometry.bounds().longest_side();
    let there = Transform::translation([step, 0.7 * step, 0.4 * step]) * here;
    let mut least = None::<Duration>;
    // The first time the geometry is copied, for it is shared.
    for time in 0..4 {
        let start = clock();
        let mut edit = scene.edit();
        let placed = edit.set_transform(sector, item, if time % 2 == 0 { there } else { here });
        placed.map_err(|_| SkipReason::Moves)?;
        edit.finish().map_err(|_| SkipReason::Moves)?;
        let took = clock().saturating_sub(start);
        if time > 0 {
            least = Some(least.map_or(took, |least| least.min(took)));
        }
    }
    Ok(least.unwrap_or_default())
}

/// About how long it takes to sort so many faces by a BSP tree.
fn sorting(faces: u64) -> Duration {
    let faces = faces as f64;
    SORTING_A_FACE.mul_f64(faces * faces.max(2.0).log2())
}
