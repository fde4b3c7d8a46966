//! The laws themselves: each is stated once here, and holds for every method and custom sector on every scene.

use super::layers::LayerPicture;
use super::owners::OwnerPicture;
use super::reference::Reference;
use super::truth::Truth;
use crate::contract::Contract;
use crate::ids::{ItemIndex, PassageId, SectorId};
use crate::method::Method;
use crate::scene::Scene;
use crate::view::View;
use crate::view::canvas::{Canvas, Span};
use crate::view::options::Limits;
use crate::view::passage::Passage;
use crate::view::viewer::Viewer;
use crate::view::visible::VisibleSet;
use std::collections::BTreeSet;
use std::fmt;

/// A property that every method must have on every scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Law {
    /// The set holds every visible item, each sample has an owner that the reference allows, and an exact set holds no
    /// hidden item; also at one of [`View::FOUR_SAMPLES`], another in each view, and for strict methods at random
    /// positions.
    Contract,
    /// Transparent layers are painted in the order of the reference.
    Layers,
    /// What was visible before (temporal coherence) changes the cost, never the set.
    Coherence,
    /// [`Viewer::draw`] has the set of [`Viewer::look`].
    DrawnAsLooked,
    /// Each sample is painted by at most one opaque span.
    PaintedOnce,
    /// A wider screen at the same focal length never shows less.
    WiderSeesMore,
    /// Any number of selected occluders keeps the contract, and no passage rasterizes more of them than that.
    Occluders,
    /// The work is bounded by the size of the sectors passed: triangles set up and boxes tested.
    Cost,
    /// The set is no larger than a stated multiple of what meets the clip regions of its passages.
    Tightness,
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Law::Contract => "the contract",
            Law::Layers => "transparent layers in order",
            Law::Coherence => "coherence does not change the set",
            Law::DrawnAsLooked => "drawing gives the set of looking",
            Law::PaintedOnce => "each sample is painted once",
            Law::WiderSeesMore => "a wider screen shows no less",
            Law::Occluders => "any number of occluders",
            Law::Cost => "cost",
            Law::Tightness => "tightness",
        })
    }
}

/// A violation of a law in one view.
#[derive(Clone, Debug)]
pub struct Broken {
    /// The law.
    pub law: Law,
    /// The method of all sectors; `None` for the scene as it was built.
    pub method: Option<Method>,
    /// The view.
    pub view: View,
    /// What is wrong, and where.
    pub what: String,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.method {
            Some(method) => write!(f, "{method}: {}: {}", self.law, self.what),
            None => write!(f, "as built: {}: {}", self.law, self.what),
        }
    }
}

/// What [`check`] found.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Report {
    /// Items that are certainly visible, summed over the views. If it is 0, nothing was tested.
    pub visible: usize,
    /// Samples with transparent layers that were compared.
    pub layers: usize,
    /// Number of those with two or more layers.
    pub stacked: usize,
    /// Items in the set, summed over the views, for each method tested; `None` for the scene as it was built.
    pub listed: Vec<(Option<Method>, usize)>,
    /// The violations.
    pub broken: Vec<Broken>,
}

/// Tests every law on a scene as it was built and with each method that suits it, from the given views.
///
/// The scene must have no custom sectors: see [`check_custom`] for these.
///
/// ```
/// # use enfilade::{GeometryBuilder, Limits, Material, MaterialId, Mesh, Method, Scene, Transform, View, laws};
/// # let mut builder = GeometryBuilder::new([Material::opaque([0.5; 3])]);
/// # let crate_mesh = builder.mesh(Mesh::cuboid([-0.5; 3], [0.5; 3], MaterialId(0))?);
/// # builder.item("crate", crate_mesh, Transform::IDENTITY);
/// # let scene = Scene::single(builder.build()?, Method::HierarchicalZ)?;
/// let views = [View::new([4.0, 1.0, 5.0], [0.0; 3], [64, 36])];
/// let report = laws::check(&scene, &views, Limits::default());
/// assert!(report.visible > 0, "the views show nothing, so nothing was tested");
/// assert!(report.broken.is_empty(), "{}", report.broken[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn check(scene: &Scene, views: &[View], limits: Limits) -> Report {
    let mut contestants = Contestants::with(Method::ALL.into_iter(), scene, limits, Method::DEFAULT_LIMIT);
    contestants.all.push(Contestant::new(None, scene.clone(), limits));
    contestants.report(views)
}

/// As [`check`], for a scene with custom sectors, tested as it is. `same` is the same scene with a
/// [`Geometry`](crate::Geometry) in place of each custom sector, with equal ids of sectors, items, openings and
/// portals: the reference traces that.
pub fn check_custom(scene: &Scene, same: &Scene, views: &[View], limits: Limits) -> Report {
    let contestants = Contestants {
        reference: Reference::new(same),
        scene: same.clone(),
        limits,
        all: vec![Contestant::new(None, scene.clone(), limits)],
    };
    contestants.report(views)
}

/// A scene built once for each suitable method, each with its own viewer, which keeps its state between views (temporal
/// coherence).
pub struct Contestants {
    reference: Reference,
    scene: Scene,
    limits: Limits,
    all: Vec<Contestant>,
}

struct Contestant {
    method: Option<Method>,
    scene: Scene,
    viewer: Viewer,
}

impl Contestant {
    fn new(method: Option<Method>, scene: Scene, limits: Limits) -> Contestant {
        let viewer = viewer(limits);
        Contestant {
            method,
            scene,
            viewer,
        }
    }
}

/// Number of random positions per pixel at which strict methods are tested.
const POSITIONS: u32 = 4;

/// Triangles that a look may set up per triangle of the sectors passed: BSP trees split faces, and clipping at the eye
/// adds corners. Largest seen: 1.5.
const MAX_SETUPS: u64 = 2;

/// Boxes that a look may test per item and cluster of the sectors passed, and per face in a BSP tree: a tree has at most
/// two nodes per box, and its items and clusters are tested too. Largest seen: 1.5.
const MAX_BOXES: u64 = 2;

/// Items that a set may hold per item that meets its clip regions: a tree may list all items of a leaf that meets them.
/// Largest seen: 1.4.
const MAX_LISTED: usize = 2;

impl Contestants {
    /// Builds the reference, and the scene for every method that suits it, at most `limit_bytes` per sector.
    /// Approximate methods are left out.
    pub fn new(scene: &Scene, limits: Limits, limit_bytes: u64) -> Contestants {
        let methods = Method::ALL.into_iter();
        let promising = methods.filter(|method| method.contract().never_misses());
        Contestants::with(promising, scene, limits, limit_bytes)
    }

    fn with(
        methods: impl Iterator<Item = Method>,
        scene: &Scene,
        limits: Limits,
        limit_bytes: u64,
    ) -> Contestants {
        let all = methods
            .filter(|&method| scene.suits(method))
            .filter_map(|method| {
                let scene = scene.with_method(method, limit_bytes).ok()?;
                Some(Contestant::new(Some(method), scene, limits))
            });
        Contestants {
            reference: Reference::new(scene),
            scene: scene.clone(),
            limits,
            all: all.collect(),
        }
    }

    /// Returns the methods under test.
    pub fn methods(&self) -> impl Iterator<Item = Method> + '_ {
        self.all.iter().filter_map(|contestant| contestant.method)
    }

    /// Draws a view with every method. Returns the number of certainly visible items and all violations of
    /// [`Law::Contract`] at the view's own sample position and, for strict methods, at random ones.
    pub fn check(&mut self, view: &View) -> (usize, Vec<Broken>) {
        let mut report = Report::default();
        self.contracts(view, &mut report);
        (report.visible, report.broken)
    }

    fn report(mut self, views: &[View]) -> Report {
        let mut report = Report {
            listed: self.all.iter().map(|contestant| (contestant.method, 0)).collect(),
            ..Report::default()
        };
        for (number, view) in views.iter().enumerate() {
            let truth = self.contracts(view, &mut report);
            for ((_, listed), contestant) in report.listed.iter_mut().zip(&self.all) {
                *listed += contestant.viewer.visible().items().len();
            }
            self.sample(view, View::FOUR_SAMPLES[number % 4], &mut report);
            self.layers(view, &mut report);
            for contestant in &self.all {
                let mut trial = Trial {
                    contestant,
                    same: &self.scene,
                    limits: self.limits,
                    view,
                    truth: &truth,
                    broken: &mut report.broken,
                };
                trial.painting();
                trial.wider();
                trial.occluders();
                trial.cost();
                trial.tightness();
            }
        }
        self.coherence(views, &mut report);
        report
    }

    /// Follows the views there and back with viewers that remember the view before, beside ones that remember nothing.
    fn coherence(&self, views: &[View], report: &mut Report) {
        for Contestant { method, scene, .. } in &self.all {
            let mut remembers = viewer(self.limits);
            for view in views.iter().chain(views.iter().rev()) {
                let with = items_of(remembers.look(scene, view));
                let without = items_of(viewer(self.limits).look(scene, view));
                let differs: Vec<_> = with.symmetric_difference(&without).collect();
                if !differs.is_empty() {
                    report.broken.push(Broken {
                        law: Law::Coherence,
                        method: *method,
                        view: *view,
                        what: format!("{differs:?} differ"),
                    });
                }
            }
        }
    }

    fn contracts(&mut self, view: &View, report: &mut Report) -> Truth {
        let Contestants {
            reference,
            scene,
            limits,
            all,
        } = self;
        let truth = reference.see(scene, view, limits);
        let anywhere = reference.see_anywhere(scene, view, limits, POSITIONS, 1);
        report.visible += truth.visible().len();
        for Contestant {
            method,
            scene,
            viewer,
        } in all
        {
            let mut broken = |what: String| {
                report.broken.push(Broken {
                    law: Law::Contract,
                    method: *method,
                    view: *view,
                    what,
                });
            };
            let mut picture = OwnerPicture::new(view.size);
            viewer.draw(scene, view, &mut picture);
            if let Some(what) = contract_broken(&truth, viewer.visible(), &picture) {
                broken(what);
            }
            if contract_of(viewer.visible()) == Contract::Strict {
                let missed = anywhere.check(viewer.look(scene, view), None).missed;
                if !missed.is_empty() {
                    broken(format!(
                        "missed {missed:?} at random positions between the samples"
                    ));
                }
            }
        }
        truth
    }

    /// The contract at another sample position.
    fn sample(&self, view: &View, sample: [f32; 2], report: &mut Report) {
        let mut view = *view;
        view.sample = sample;
        let truth = self.reference.see(&self.scene, &view, &self.limits);
        for Contestant { method, scene, .. } in &self.all {
            let mut picture = OwnerPicture::new(view.size);
            let mut viewer = viewer(self.limits);
            viewer.draw(scene, &view, &mut picture);
            if let Some(what) = contract_broken(&truth, viewer.visible(), &picture) {
                report.broken.push(Broken {
                    law: Law::Contract,
                    method: *method,
                    view,
                    what,
                });
            }
        }
    }

    fn layers(&mut self, view: &View, report: &mut Report) {
        let truth = self.reference.layers(&self.scene, view, &self.limits);
        for Contestant { method, scene, .. } in &self.all {
            let mut picture = LayerPicture::new(view.size);
            let mut viewer = viewer(self.limits);
            viewer.draw(scene, view, &mut picture);
            let verdict = truth.check(&picture);
            report.layers += verdict.compared;
            report.stacked += verdict.stacked;
            let promises = contract_of(viewer.visible()).never_misses();
            if let Some(&first) = verdict.different.first().filter(|_| promises) {
                let (count, why) = (verdict.different.len(), truth.describe(&picture, first));
                report.broken.push(Broken {
                    law: Law::Layers,
                    method: *method,
                    view: *view,
                    what: format!("{count} samples differ, as {first:?}: {why}"),
                });
            }
        }
    }
}

fn viewer(limits: Limits) -> Viewer {
    let mut viewer = Viewer::new();
    viewer.options.limits = limits;
    viewer
}

/// Returns the contract of a set: that of all its passages together.
fn contract_of(set: &VisibleSet) -> Contract {
    let mut each = set.passages().iter().map(|passage| passage.contract);
    let first = each.next().unwrap_or(Contract::Exact);
    each.fold(first, Contract::combined_with)
}

fn items_of(set: &VisibleSet) -> BTreeSet<(SectorId, ItemIndex)> {
    let name = |seen: &crate::VisibleItem| (set.passage(seen.passage).sector, seen.item.index);
    set.items().iter().map(name).collect()
}

/// Returns how a set and its picture break the contract of the set.
fn contract_broken(truth: &Truth, set: &VisibleSet, picture: &OwnerPicture) -> Option<String> {
    let contract = contract_of(set);
    if !contract.never_misses() {
        return None;
    }
    let verdict = truth.check(set, Some(picture));
    let extra = if contract == Contract::Exact {
        verdict.extra
    } else {
        0
    };
    let wrong = truth.different(picture).next();
    if verdict.missed.is_empty() && wrong.is_none() && extra == 0 {
        return None;
    }
    let (missed, pixels) = (&verdict.missed, verdict.pixels_different);
    let sample = wrong.map(|at| {
        let (is, may_be) = (picture.describe(at), truth.describe(at));
        format!("; {at:?} is {is}, not {may_be}")
    });
    let sample = sample.unwrap_or_default();
    Some(format!(
        "missed {missed:?}, {pixels} wrong pixels, {extra} extra{sample}"
    ))
}

/// One scene under test in one view.
struct Trial<'a> {
    contestant: &'a Contestant,
    /// The scene with geometry in place of custom sectors.
    same: &'a Scene,
    limits: Limits,
    view: &'a View,
    truth: &'a Truth,
    broken: &'a mut Vec<Broken>,
}

impl Trial<'_> {
    fn hold(&mut self, law: Law, holds: bool, what: impl FnOnce() -> String) {
        if !holds {
            self.broken.push(Broken {
                law,
                method: self.contestant.method,
                view: *self.view,
                what: what(),
            });
        }
    }

    /// Looks with a viewer that remembers nothing.
    fn look_anew(&self, view: &View) -> Viewer {
        let mut viewer = viewer(self.limits);
        viewer.look(&self.contestant.scene, view);
        viewer
    }

    fn painting(&mut self) {
        let looked = self.look_anew(self.view);
        let mut drawn = viewer(self.limits);
        let mut paint = Paint::new(self.view.size);
        drawn.draw(&self.contestant.scene, self.view, &mut paint);
        let [looked, drew] = [&looked, &drawn].map(|viewer| items_of(viewer.visible()));
        let differs: Vec<_> = looked.symmetric_difference(&drew).collect();
        self.hold(Law::DrawnAsLooked, differs.is_empty(), || {
            format!("{differs:?} differ")
        });
        let most = paint.times.iter().copied().max().unwrap_or(0);
        self.hold(Law::PaintedOnce, most <= 1, || {
            format!("a sample is painted {most} times")
        });
    }

    fn wider(&mut self) {
        let [width, height] = self.view.size;
        let mut wide = *self.view;
        // Three times, so that the samples of the view are among those of the wide one, for odd widths too.
        wide.size = [3 * width, height];
        if wide.check().is_err() {
            return;
        }
        // A wider screen may lead to another selection of occluders; then only what certainly is visible must stay.
        let narrow = self.look_anew(self.view);
        let before = match contract_of(narrow.visible()) {
            Contract::Approximate => return,
            Contract::Exact => items_of(narrow.visible()),
            Contract::Conservative | Contract::Strict => self.truth.visible(),
        };
        let wide = self.look_anew(&wide);
        // With a limit reached, a wide screen may follow other portals first.
        if !narrow.visible().complete() || !wide.visible().complete() {
            return;
        }
        let after = items_of(wide.visible());
        let lost: Vec<_> = before.difference(&after).collect();
        self.hold(Law::WiderSeesMore, lost.is_empty(), || {
            format!("{lost:?} are lost on a screen of {} columns", 3 * width)
        });
    }

    fn occluders(&mut self) {
        for budget in [0, 1, 8, 100_000] {
            let mut viewer = viewer(self.limits);
            viewer.options.occluders = Some(budget);
            let set = viewer.look(&self.contestant.scene, self.view);
            let missed = self.truth.check(set, None).missed;
            let promises = contract_of(set).never_misses();
            self.hold(Law::Occluders, missed.is_empty() || !promises, || {
                format!("missed {missed:?} with {budget} occluders")
            });
            let (taken, passages) = (viewer.stats().occluders, viewer.visible().passages().len() as u64);
            self.hold(Law::Occluders, taken <= u64::from(budget) * passages, || {
                format!("{taken} occluders in {passages} passages, of {budget} each")
            });
        }
    }

    fn cost(&mut self) {
        let mut viewer = viewer(self.limits);
        viewer.options.parallel = false;
        let scene = &self.contestant.scene;
        viewer.look(scene, self.view);
        let passages = viewer.visible().passages();
        let size_of = |passage: &Passage| {
            let sector = passage.sector;
            let geometry = self.same.geometry(sector)?;
            let all = 0..geometry.items().len() as u32;
            let clusters = all.map(|item| 1 + geometry.mesh_of(ItemIndex(item)).clusters().len() as u64);
            let faces = scene.sector(sector).build_stats().faces;
            let splits = scene.method(sector).is_some_and(Method::splits_faces);
            let boxes = clusters.sum::<u64>() + if splits { faces } else { 0 };
            Some((self.same.triangles_of(sector).max(2 * faces), boxes))
        };
        let sizes = passages.iter().filter_map(size_of);
        let (triangles, boxes) = sizes.fold((0, 0), |sum, size| (sum.0 + size.0, sum.1 + size.1));
        let (stats, passages) = (*viewer.stats(), passages.len() as u64);
        let most = MAX_SETUPS * (triangles + passages);
        self.hold(Law::Cost, stats.triangles <= most, || {
            format!("{} triangles set up, at most {most}", stats.triangles)
        });
        let most = MAX_BOXES * (boxes + passages);
        self.hold(Law::Cost, stats.boxes_tested <= most, || {
            format!("{} boxes tested, at most {most}", stats.boxes_tested)
        });
    }

    fn tightness(&mut self) {
        let viewer = self.look_anew(self.view);
        let set = viewer.visible();
        let (within, _) = set.in_frustum(self.same);
        let listed = items_of(set).len();
        self.hold(Law::Tightness, listed <= MAX_LISTED * within, || {
            format!("{listed} items in the set, but {within} meet its clip regions")
        });
    }
}

/// Counts the opaque writes per sample.
struct Paint {
    width: usize,
    times: Vec<u8>,
}

impl Paint {
    fn new(size: [u32; 2]) -> Paint {
        let [width, height] = size.map(|side| side as usize);
        Paint {
            width,
            times: vec![0; width * height],
        }
    }
}

impl Canvas for Paint {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}

    fn row(&mut self, y: u16, spans: &[Span]) {
        for span in spans.iter().filter(|span| !span.see_through) {
            let row = usize::from(y) * self.width;
            for times in &mut self.times[row + usize::from(span.x0)..row + usize::from(span.x1)] {
                *times = times.saturating_add(1);
            }
        }
    }
}
