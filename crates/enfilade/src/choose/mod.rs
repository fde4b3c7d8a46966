//! Chooses a method per sector by measurement: times the candidates on sample views and returns the fastest.
//!
//! The cost of a sector depends on the openings and distances that it is seen from. So the scene is culled from all
//! views first, and then each sector is measured alone, through the passages that lead to it. Choosing is a function
//! and no [`Method`], because it returns one: the caller sets it with [`Scene::set_method`], and looks cost nothing
//! extra. By default only exact methods are candidates ([`ChoiceOptions::exact`]), so visible sets do not depend on
//! which of them is chosen.
//! Source: Boreskov, Using portals to create aggregate scenes ("with each sector its own most suitable method");
//!     choosing by measurement rather than by rules is original.
//! Cost: per sector, building every candidate; per sector and view, one look (or drawing, by the goal) by each of them,
//!     and [`ChoiceOptions::rounds`] by those that are not far from the fastest.
//! Methods take turns at each view, so that background load disturbs all alike, and the minimum time of each view
//! counts. If the two halves of the views disagree, or timer noise could decide, the choice is unsure and the sector
//! keeps its method.

mod trial;

use crate::contract::Contract;
use crate::geom::Transform;
use crate::geometry::Geometry;
use crate::ids::{ItemIndex, SectorId};
use crate::method::{Method, UnsuitedMethod};
use crate::scene::Scene;
use crate::view::View;
use crate::view::passage::Passage;
use crate::view::viewer::Viewer;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;
use trial::MethodTrial;

/// Options of [`choose_methods`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ChoiceOptions {
    /// Which cost to minimize. Default [`ChoiceGoal::Look`].
    pub aim: ChoiceGoal,
    /// Whether to consider only exact methods, so that the visible set does not depend on the choice. Default `true`.
    /// Otherwise conservative and strict methods are candidates too, which may report hidden items; approximate ones
    /// never.
    pub exact: bool,
    /// Sectors in which an item moves between any two looks; the cost of the edit is added. Default: none.
    pub moving: Vec<SectorId>,
    /// Number of looks over which the build time of a method is amortized. Default 10,000: some minutes of a game.
    pub frames: u32,
    /// Memory limit of one sector's method, in bytes. Default [`Method::DEFAULT_LIMIT`].
    pub limit_bytes: u64,
    /// Methods whose estimated build time is longer are skipped. Default 20 s.
    pub max_build_time: Duration,
    /// Number of measurements per view, of which the minimum counts. Default 4. Methods far from the best get fewer.
    pub rounds: u32,
    /// Maximum number of views per sector, taken evenly from those that see it. Default 64. Costs vary more from view
    /// to view than from one measurement to the next.
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

/// The cost that [`choose_methods`] minimizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ChoiceGoal {
    /// Time of [`Viewer::look`].
    Look,
    /// Time of [`Viewer::draw`], without the work of the canvas.
    Draw,
}

/// The method chosen for a sector, with the measurements behind it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MethodChoice {
    /// The sector.
    pub sector: SectorId,
    /// The fastest method. Among methods at most 12 % slower: the sector's current method, or else the one that uses
    /// the least memory. The current method if nothing could be measured, or if the choice is not sure.
    pub method: Method,
    /// Whether the method is at most 15 % slower than the fastest in both halves of the views, and would still be
    /// chosen if 10 % or 15 % counted as equally fast.
    pub sure: bool,
    /// Number of views measured; 0 if no view sees the sector.
    pub views: usize,
    /// Results of all methods, in the order of [`Method::ALL`].
    pub trials: Vec<Trial>,
}

/// The measurement of one method in one sector, or why it was skipped.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Trial {
    /// The method.
    pub method: Method,
    /// Its cost, or why it was skipped.
    pub outcome: Result<Cost, SkipReason>,
}

/// The cost of a method in a sector.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Cost {
    /// Build time.
    pub build: Duration,
    /// Memory of the structures it built and of its screen buffers, in bytes.
    pub bytes: u64,
    /// Mean time to compute the visible set of a view. If it is not the goal, measured once on every eighth view.
    pub look: Duration,
    /// Mean time to draw a view to a canvas that does next to nothing. If it is not the goal, measured once on every
    /// eighth view.
    pub draw: Duration,
    /// Time to update the method after one item moved; 0 if no item moves.
    pub edit: Duration,
    /// The total that decides: time of the goal, plus edit time, plus build time divided by [`ChoiceOptions::frames`].
    pub frame: Duration,
}

/// Why a method was not measured in a sector.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SkipReason {
    /// The geometry does not meet the method's requirements, or its structures exceed the memory limit.
    #[error(transparent)]
    Unsuited(#[from] UnsuitedMethod),
    /// The method's contract does not meet [`ChoiceOptions::exact`].
    #[error("its contract is {0}, which does not meet the requirement")]
    Contract(Contract),
    /// Building its BSP tree would take too long; holds the estimated time.
    #[error("building its BSP tree would take about {:.0} s", .0.as_secs_f64().ceil())]
    BuildsTooLong(Duration),
    /// The geometry no longer meets the method's requirements once an item has moved.
    #[error("a moving item would violate its requirements")]
    Moves,
    /// The sector is not visible in any view.
    #[error("the sector is not visible in any view")]
    NotSeen,
}

/// Building a BSP tree over n faces takes about n log₂ n times as long. On fourteen real scenes this was 0.24 to 2.1
/// µs: trees of furniture split many faces, those of terrain none.
const SORTING_A_FACE: Duration = Duration::from_nanos(900);

/// Methods at most this factor slower than the fastest count as equally fast. On a busy machine ratios of measurements
/// differ by up to 4 % from run to run, so a choice that another threshold would change is unsure. In most rooms of the
/// palace scene the second best takes 1.0 to 1.1 times as long: a threshold in that range would make half of the
/// choices unsure.
const EQUALLY_FAST: [f64; 3] = [1.1, 1.12, 1.15];
/// A choice is sure if it takes at most this factor longer than the best, in both halves of the views.
const NEAR_THE_BEST: f64 = EQUALLY_FAST[2];
/// Methods slower than the best by this factor are not measured again: after the first round, and after later ones.
const FAR_FROM_BEST: [f64; 2] = [2.0, 1.3];

/// A subset of the views that a method is measured on.
#[derive(Clone, Copy, Debug)]
enum ViewSubset {
    All,
    Even,
    Odd,
}

impl ViewSubset {
    fn holds(self, view: usize) -> bool {
        match self {
            ViewSubset::All => true,
            ViewSubset::Even => view.is_multiple_of(2),
            ViewSubset::Odd => !view.is_multiple_of(2),
        }
    }
}

/// Benchmarks methods on `views` and returns the fastest for each sector, except for custom sectors.
///
/// The scene is not changed; apply a choice by [`Scene::set_method`]. `views` should be typical of how the scene is
/// viewed; [`survey_in`](crate::survey_in) generates camera positions in a sector. `clock` returns the time since any
/// fixed moment and must never go back; the library reads no clock itself. Methods use as many threads as looks may
/// use.
#[doc(alias = "autotune")]
#[doc(alias = "benchmark")]
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

/// Returns the passages that lead into a sector, by view, for at most `most` of the views that see it.
fn ways_into(sector: SectorId, ways: &[Vec<Passage>], most: u32) -> Vec<Vec<&Passage>> {
    let here = ways.iter().map(|passages| {
        let here = passages.iter().filter(|passage| passage.sector == sector);
        here.collect::<Vec<&Passage>>()
    });
    let mut seeing: Vec<Vec<&Passage>> = here.filter(|passages| !passages.is_empty()).collect();
    let (all, most) = (seeing.len(), most.max(1) as usize);
    let mut place = 0;
    seeing.retain(|_| {
        // Keeps `most` views at even distances.
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
    let mut tried: Vec<(Method, Result<MethodTrial, SkipReason>)> = Method::ALL
        .into_iter()
        .map(|method| (method, begin(scene, sector, method, through, terms, clock)))
        .collect();
    measure(&mut tried, through, terms, clock);
    let [lower, cheapest, upper] = EQUALLY_FAST.map(|within| cheapest(&tried, own, terms, within));
    let sure = cheapest.is_some_and(|method| {
        lower == upper
            && [ViewSubset::Even, ViewSubset::Odd]
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

type Outcomes = [(Method, Result<MethodTrial, SkipReason>)];

/// Returns the measured methods, with the time per frame over a subset of the views, and the memory of each.
fn frames(
    tried: &Outcomes,
    views: ViewSubset,
    terms: &ChoiceOptions,
) -> impl Iterator<Item = (Method, Duration, u64)> {
    let running = tried
        .iter()
        .filter_map(|(method, tried)| Some((*method, tried.as_ref().ok()?)));
    running.map(move |(method, tried)| (method, tried.frame(views, terms), tried.bytes()))
}

/// Measures all methods; stops early for those far from the best.
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
                // Another method starts each time, because the first one finds colder caches.
                let place = (turn + view + round as usize) % count;
                if let Ok(tried) = &mut tried[place].1
                    && left[place]
                {
                    tried.run(view, passages, terms.aim, clock);
                }
            }
        }
        let best = frames(tried, ViewSubset::All, terms)
            .map(|(_, frame, _)| frame)
            .min();
        let far = best
            .unwrap_or_default()
            .mul_f64(FAR_FROM_BEST[usize::from(round > 0)]);
        for ((_, tried), left) in tried.iter().zip(&mut left) {
            *left &= tried
                .as_ref()
                .is_ok_and(|tried| tried.frame(ViewSubset::All, terms) <= far);
        }
    }
}

/// Returns the fastest method. Among those at most `within` times as slow: the sector's current one, or else the one
/// that uses the least memory, or else the first in [`Method::ALL`].
fn cheapest(tried: &Outcomes, own: Method, terms: &ChoiceOptions, within: f64) -> Option<Method> {
    let all = || frames(tried, ViewSubset::All, terms);
    let best = all().map(|(_, frame, _)| frame).min()?;
    let as_fast = all().filter(|&(_, frame, _)| frame <= best.mul_f64(within));
    as_fast
        .min_by_key(|&(method, _, bytes)| (method != own, bytes))
        .map(|(method, ..)| method)
}

fn is_near_the_best(tried: &Outcomes, method: Method, views: ViewSubset, terms: &ChoiceOptions) -> bool {
    let all = || frames(tried, views, terms);
    let best = all().map(|(_, frame, _)| frame).min().unwrap_or_default();
    all().any(|(other, frame, _)| other == method && frame <= best.mul_f64(NEAR_THE_BEST))
}

/// Builds a method over a sector, if it is a candidate.
fn begin(
    scene: &Scene,
    sector: SectorId,
    method: Method,
    through: &[Vec<&Passage>],
    terms: &ChoiceOptions,
    clock: &dyn Fn() -> Duration,
) -> Result<MethodTrial, SkipReason> {
    let contract = method.contract();
    if contract == Contract::Approximate || (terms.exact && contract != Contract::Exact) {
        return Err(SkipReason::Contract(contract));
    }
    let geometry = scene.geometry(sector).ok_or(SkipReason::NotSeen)?;
    let first = through.first().ok_or(SkipReason::NotSeen)?;
    if method.splits_faces() {
        let estimate = sorting(geometry.face_count());
        if estimate > terms.max_build_time {
            return Err(SkipReason::BuildsTooLong(estimate));
        }
    }
    let size = first[0].size;
    let mut tried = MethodTrial::build(method, Arc::clone(geometry), size, terms.limit_bytes, clock)?;
    if terms.moving.contains(&sector) {
        tried.edit = edit(scene, sector, method, geometry, clock)?;
    }
    tried.warm_up(first);
    Ok(tried)
}

/// Measures the update after one item moves a little and back. Takes the movable item with the fewest faces.
fn edit(
    scene: &Scene,
    sector: SectorId,
    method: Method,
    geometry: &Geometry,
    clock: &dyn Fn() -> Duration,
) -> Result<Duration, SkipReason> {
    #[cfg(feature = "terrain")]
    let is_ground = |item: u32| {
        geometry
            .terrains()
            .iter()
            .any(|terrain| terrain.blocks.contains(&item))
    };
    #[cfg(not(feature = "terrain"))]
    let is_ground = |_| false;
    let items = (0..geometry.items().len() as u32).map(ItemIndex);
    let items = items.filter(|&item| geometry.holds(item) && !is_ground(item.0));
    let Some(item) = items.min_by_key(|&item| geometry.mesh_of(item).face_count()) else {
        return Ok(Duration::ZERO);
    };
    let mut scene = scene.clone();
    scene.set_method(sector, method).map_err(|_| SkipReason::Moves)?;
    let here = geometry.item(item).transform();
    // Along no axis: a wall that slides within its plane would leave a room convex.
    let step = 0.01 * geometry.bounds().longest_side();
    let there = Transform::translation([step, 0.7 * step, 0.4 * step]) * here;
    let mut least = None::<Duration>;
    // The first edit copies the shared geometry, so its time does not count.
    for time in 0..4 {
        let start = clock();
        let mut edit = scene.edit();
        let placed = edit.set_transform(
            sector,
            geometry.id_of(item),
            if time % 2 == 0 { there } else { here },
        );
        placed.map_err(|_| SkipReason::Moves)?;
        edit.finish().map_err(|_| SkipReason::Moves)?;
        let took = clock().saturating_sub(start);
        if time > 0 {
            least = Some(least.map_or(took, |least| least.min(took)));
        }
    }
    Ok(least.unwrap_or_default())
}

/// Estimates the build time of a BSP tree.
fn sorting(faces: u64) -> Duration {
    let faces = faces as f64;
    SORTING_A_FACE.mul_f64(faces * faces.max(2.0).log2())
}
