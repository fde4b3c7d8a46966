//! Sectors with different methods in one scene: each passage keeps the contract that it states.

use crate::subject::{SIZE, Subject, drawn, limits, subject, subjects, viewer};
use enfilade::laws::Reference;
use enfilade::{Contract, Method, PortalId, Scene, SectorId, Transform, VisibleSet};
use std::collections::BTreeSet;

/// Contracts from which random assignments draw their methods: some laws hold only in scenes without weaker ones.
const POOLS: [&[Contract]; 3] = [
    &[Contract::Exact],
    &[Contract::Exact, Contract::Strict, Contract::Conservative],
    &[
        Contract::Exact,
        Contract::Strict,
        Contract::Conservative,
        Contract::Approximate,
    ],
];

/// Returns the scene with a random method per sector, reproducible by seed.
fn mixed(scene: &Scene, contracts: &[Contract], seed: u64) -> Scene {
    let pool: Vec<Method> = Method::ALL
        .into_iter()
        .filter(|method| scene.suits(*method) && contracts.contains(&method.contract()))
        .collect();
    let mut scene = scene.clone();
    let mut random = fastrand::Rng::with_seed(seed);
    for sector in scene.sectors() {
        let method = pool[random.usize(..pool.len())];
        let builds = scene.builds(sector);
        scene
            .set_method(sector, method)
            .expect("the scenes of the laws are small");
        assert_eq!(
            (scene.method(sector), scene.builds(sector)),
            (Some(method), builds + 1)
        );
    }
    scene
}

/// Returns the sectors in which a set may miss items: those entered by passages without a guarantee, and those visible
/// further on.
fn excused(scene: &Scene, set: &VisibleSet) -> BTreeSet<SectorId> {
    let without = set
        .passages()
        .iter()
        .filter(|passage| passage.contract == Contract::Approximate);
    let mut waiting: Vec<(SectorId, Option<PortalId>)> =
        without.map(|passage| (passage.sector, passage.portal)).collect();
    let mut met: BTreeSet<_> = waiting.iter().copied().collect();
    while let Some((sector, came)) = waiting.pop() {
        for (id, portal) in (0..).map(PortalId).zip(scene.portals()) {
            let is_way_back = came.is_some_and(|came| is_way_back(scene, came, id));
            if portal.from == sector && portal.open && !is_way_back && met.insert((portal.to, Some(id))) {
                waiting.push((portal.to, Some(id)));
            }
        }
    }
    met.into_iter().map(|(sector, _)| sector).collect()
}

/// Returns `true` if a portal leads back to where another one came from. The opening just passed cannot be seen from
/// behind.
fn is_way_back(scene: &Scene, came: PortalId, back: PortalId) -> bool {
    let [came, back] = [came, back].map(|id| &scene.portals()[id.0 as usize]);
    let round = (back.there_from_here * came.there_from_here).columns();
    let still = Transform::IDENTITY.columns();
    let moved = round.iter().flatten().zip(still.iter().flatten());
    back.to == came.from && back.from == came.to && moved.into_iter().all(|(a, b)| (a - b).abs() < 1e-4)
}

/// Counts of what was tested.
#[derive(Default)]
struct Tried {
    /// Certainly visible items.
    looked_at: usize,
    /// Visible sets with two or more methods.
    mixed: usize,
    /// Sets with only exact passages, sets with only passages better than approximate, and others.
    by_contract: [usize; 3],
}

fn every_passage_keeps_its_contract(
    subject: &Subject,
    size: [u32; 2],
    seeds: std::ops::Range<u64>,
    tried: &mut Tried,
) {
    let scene = &subject.built.scene;
    let reference = Reference::new(scene);
    let truths: Vec<_> = (subject.built.cameras.iter())
        .map(|camera| reference.see(scene, &camera.view(size).expect("a valid view"), &limits()))
        .collect();
    for (contracts, seed) in POOLS
        .into_iter()
        .flat_map(|contract| seeds.clone().map(move |seed| (contract, seed)))
    {
        let scene = mixed(scene, contracts, seed);
        for (camera, truth) in subject.built.cameras.iter().zip(&truths) {
            let view = camera.view(size).expect("a valid view");
            let (mut looks, mut draws) = (viewer(), viewer());
            looks.look(&scene, &view);
            let picture = drawn(&mut draws, &scene, &view);
            for (set, picture) in [(looks.visible(), None), (draws.visible(), Some(&picture))] {
                let verdict = truth.check(set, picture);
                let methods: Vec<_> = scene.sectors().map(|id| scene.method(id)).collect();
                let place = format!("@{} from `{}`: {methods:?}", subject.name, camera.name);
                let excused = excused(&scene, set);
                let missed = verdict
                    .missed
                    .iter()
                    .filter(|(sector, _)| !excused.contains(sector));
                assert_eq!(missed.count(), 0, "{place}: {:?}", verdict.missed);
                assert!(!set.passages().is_empty(), "the eye is in a passage");
                let never_misses = set
                    .passages()
                    .iter()
                    .all(|passage| passage.contract.never_misses());
                let all_exact = set
                    .passages()
                    .iter()
                    .all(|passage| passage.contract == Contract::Exact);
                if never_misses {
                    let first = picture.and_then(|picture| truth.different(picture).next());
                    let why = first.map(|at| truth.describe(at));
                    assert_eq!(verdict.pixels_different, 0, "{place}: {first:?} is {why:?}");
                }
                if all_exact {
                    assert_eq!(verdict.extra, 0, "{place}");
                }
                let kind = usize::from(!all_exact) + usize::from(!never_misses);
                tried.by_contract[kind] += 1;
                let seen_by: BTreeSet<_> = (set.passages().iter())
                    .filter_map(|passage| scene.method(passage.sector).map(Method::name))
                    .collect();
                tried.mixed += usize::from(seen_by.len() > 1);
                tried.looked_at += verdict.reference_visible;
            }
        }
    }
}

#[test]
fn methods_mixed_by_chance_keep_the_contract_of_each_passage_on_the_small_scenes() {
    let mut tried = Tried::default();
    let has_portals =
        |subject: &&Subject| subject.name != "enfilade" && subject.built.scene.sector_count() > 1;
    for subject in subjects().iter().filter(has_portals) {
        every_passage_keeps_its_contract(subject, SIZE, 1..5, &mut tried);
    }
    assert!(
        tried.looked_at > 1000 && tried.mixed > 100,
        "hardly anything is seen by two methods"
    );
    assert!(
        tried.by_contract.iter().all(|&sets| sets > 50),
        "{:?}",
        tried.by_contract
    );
}

#[test]
fn methods_mixed_by_chance_keep_the_contract_of_each_passage_in_the_palace() {
    let mut tried = Tried::default();
    every_passage_keeps_its_contract(subject("enfilade"), [160, 90], 1..2, &mut tried);
    assert!(tried.looked_at > 100 && tried.mixed > 3);
}
