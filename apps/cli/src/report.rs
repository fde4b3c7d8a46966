//! The JSON reports. Their keys are a stable interface.

use crate::check::CheckResult;
use crate::choose::ChoiceReport;
use crate::json::{SceneReport, rounded};
use crate::measure::{LookPassage, LookResult, LookResults, PASSES, draws, looks, median, p99, walks};
use crate::names::Names;
use crate::open::OpenedScene;
use crate::picture::{draw, settings};
use crate::prepare::{PreparedScene, SkippedMethod};
use crate::progress::Progress;
use enfilade::{Contract, ItemIndex, OpeningId, Scene, SectorId, View, Viewer};
use enfilade_draw::Show;
use enfilade_import::SourceNodes;
use serde::ser::{Error, SerializeSeq};
use serde::{Deserialize, Serialize, Serializer};
use serde_json::value::to_raw_value;
use std::collections::HashMap;
use std::fmt::Display;
use std::sync::Arc;

/// Report of one method over all views.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    pub(crate) scene: SceneReport,
    pub(crate) method: &'static str,
    #[serde(serialize_with = "as_text")]
    pub(crate) contract: Contract,
    pub(crate) size: [u32; 2],
    pub(crate) threads: usize,
    pub(crate) simd: &'static str,
    pub(crate) build_ms: f64,
    pub(crate) faces_built: u64,
    /// Number of faces that a tree split, and its depth.
    pub(crate) splits: u64,
    pub(crate) depth: u32,
    pub(crate) bytes: u64,
    /// Counters of the last pass, summed over the views.
    #[serde(serialize_with = "as_map")]
    pub(crate) stats: Vec<(&'static str, u64)>,
    pub(crate) views: Vec<ViewReport>,
    pub(crate) summary: Summary,
    /// With `auto`: the method of each sector, and the measurements it was chosen by.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) choices: Vec<ChoiceReport>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ViewReport {
    pub(crate) eye: [f32; 3],
    pub(crate) toward: [f32; 3],
    pub(crate) up: [f32; 3],
    /// Vertical field of view, in degrees; 0 in a parallel view.
    pub(crate) fov: f64,
    /// Height of what a parallel view shows, in scene units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) parallel: Option<f64>,
    pub(crate) passages: usize,
    /// The passages; the one at the eye comes first.
    pub(crate) through: Vec<PassageReport>,
    pub(crate) items_in_frustum: usize,
    pub(crate) items_visible: usize,
    pub(crate) triangles_in_frustum: u64,
    pub(crate) triangles_visible: u64,
    pub(crate) ms: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) draw_ms: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) order_ms: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) picture: Option<String>,
    /// Number of samples of opaque faces that were shaded for the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) samples_shaded: Option<u64>,
    pub(crate) complete: bool,
    /// Names of the visible items. Shared with `visible_items` and other views, which may be hundreds with thousands of
    /// items.
    pub(crate) visible: Vec<Arc<str>>,
    /// The same items in the same order.
    #[serde(serialize_with = "one_line_each")]
    pub(crate) visible_items: Vec<ItemReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) check: Option<CheckReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) expected: Option<ExpectedReport>,
}

/// A visible item.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ItemReport {
    pub(crate) name: Arc<str>,
    /// Index of its node in the glTF file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) node: Option<u32>,
    /// Id in the `extras` of the node.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) id: Option<Arc<str>>,
    pub(crate) size_px: u16,
}

/// A passage: a chain of portals from the eye into a sector.
#[derive(Debug, Serialize)]
pub(crate) struct PassageReport {
    pub(crate) sector: String,
    /// The opening of its last portal, as `SECTOR/OPENING`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) portal: Option<String>,
    pub(crate) crossings: u16,
    #[serde(serialize_with = "as_text")]
    pub(crate) contract: Contract,
    pub(crate) items_visible: usize,
}

#[derive(Debug, Serialize)]
pub(crate) struct CheckReport {
    pub(crate) reference_visible: usize,
    pub(crate) missed: Vec<String>,
    pub(crate) extra: usize,
    pub(crate) pixels_different: u64,
    pub(crate) pixels_contested: u64,
    /// Share of the samples that have one possible owner, an item or nothing.
    pub(crate) certain: f64,
    /// Groups of items that may own the same samples; the largest groups only.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) contested: Vec<ContestedReport>,
}

/// Items that may own the same samples: most often their faces coincide.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct ContestedReport {
    pub(crate) items: Vec<String>,
    pub(crate) pixels: u64,
}

/// Comparison of a visible set with the expected one, and with that of the pass before.
#[derive(Debug, Serialize)]
pub(crate) struct ExpectedReport {
    /// Number of items in the set of a z-buffer.
    pub(crate) items_visible: usize,
    /// False culls: items that are certainly visible and not in the set.
    pub(crate) missed: Vec<String>,
    /// Hidden items in the set of an exact method; 0 for other methods.
    pub(crate) extra: usize,
    pub(crate) same_again: bool,
}

#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) views: usize,
    pub(crate) ms_median: f64,
    pub(crate) ms_p99: f64,
    pub(crate) items_visible_mean: f64,
    pub(crate) items_in_frustum_mean: f64,
    pub(crate) missed: usize,
    pub(crate) pixels_different: u64,
    /// With a check: share of all samples that have one possible owner, an item or nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) certain: Option<f64>,
}

/// The reports of one method, or of all.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum Reports {
    One(Box<Report>),
    All {
        methods: Vec<Report>,
        skipped: Vec<SkippedMethod>,
    },
}

impl Reports {
    /// Wraps the reports: as a list if `all` or if there is not exactly one, else as a single report.
    pub(crate) fn new(all: bool, mut methods: Vec<Report>, skipped: Vec<SkippedMethod>) -> Reports {
        if all || methods.len() != 1 {
            Reports::All { methods, skipped }
        } else {
            Reports::One(Box::new(methods.remove(0)))
        }
    }

    /// Returns the reports, one per method.
    pub(crate) fn each(&self) -> &[Report] {
        match self {
            Reports::One(report) => std::slice::from_ref(report),
            Reports::All { methods, .. } => methods,
        }
    }
}

impl Report {
    /// Creates the report of a method over views of one size.
    pub(crate) fn new(
        opened: &OpenedScene,
        prepared: &PreparedScene,
        views: &[View],
        size: [u32; 2],
        looks: LookResults,
    ) -> Report {
        let items = seen_items(&looks.each, &Names::new(&prepared.scene), &opened.nodes);
        let built = prepared.scene.build_stats();
        let times: Vec<f64> = looks.each.iter().map(|look| look.ms).collect();
        let mean = |sum: usize| {
            if views.is_empty() {
                0.0
            } else {
                sum as f64 / views.len() as f64
            }
        };
        Report {
            scene: SceneReport::new(opened),
            method: prepared.method,
            contract: prepared.contract,
            size,
            threads: rayon::current_num_threads(),
            simd: enfilade::simd_level(),
            build_ms: rounded(prepared.build_ms),
            faces_built: built.faces,
            splits: built.splits,
            depth: built.depth,
            bytes: prepared.bytes(size),
            stats: looks.stats,
            summary: Summary {
                views: views.len(),
                ms_median: rounded(median(&times)),
                ms_p99: rounded(p99(&times)),
                items_visible_mean: mean(looks.each.iter().map(|look| look.visible.len()).sum()),
                items_in_frustum_mean: mean(looks.each.iter().map(|look| look.items_in_frustum).sum()),
                missed: 0,
                pixels_different: 0,
                certain: None,
            },
            views: views
                .iter()
                .zip(looks.each)
                .map(|(view, look)| ViewReport::new(view, look, &items, &prepared.scene))
                .collect(),
            choices: prepared.choices.clone(),
        }
    }

    /// Adds the times to draw each view, and to walk its traversal orders alone.
    pub(crate) fn add_times(&mut self, draw_ms: &[f64], order_ms: &[f64]) {
        for (view, (&draw, &order)) in self.views.iter_mut().zip(draw_ms.iter().zip(order_ms)) {
            view.draw_ms = Some(rounded(draw));
            view.order_ms = Some(rounded(order));
        }
    }

    /// Returns the median of a time over the views; `None` if it was not measured.
    pub(crate) fn median_ms(&self, of: impl Fn(&ViewReport) -> Option<f64>) -> Option<f64> {
        let times: Vec<f64> = self.views.iter().filter_map(of).collect();
        (!times.is_empty()).then(|| median(&times))
    }

    /// Returns the ratio of items in the visible sets to those of them that are visible, over all checked views.
    pub(crate) fn overestimate(&self) -> Option<f64> {
        let checked = || {
            self.views
                .iter()
                .filter_map(|view| Some((view, view.check.as_ref()?)))
        };
        let called: usize = checked().map(|(view, _)| view.items_visible).sum();
        let extra: usize = checked().map(|(_, check)| check.extra).sum();
        (called > extra).then(|| called as f64 / (called - extra) as f64)
    }

    /// Whether a check found a false cull or a wrong pixel; `false` without a check.
    pub(crate) fn is_wrong(&self) -> bool {
        self.summary.missed > 0 || self.summary.pixels_different > 0
    }

    /// Whether it is wrong although its contract excludes that.
    pub(crate) fn breaks_its_contract(&self) -> bool {
        self.contract != Contract::Approximate && self.is_wrong()
    }

    /// Whether any visible set violates the contract or differs between passes; `false` outside of `bench`.
    pub(crate) fn is_not_as_expected(&self) -> bool {
        let mut expected = self.views.iter().filter_map(|view| view.expected.as_ref());
        expected.any(|set| !set.missed.is_empty() || set.extra > 0 || !set.same_again)
    }

    /// Adds the results of the check of each view.
    pub(crate) fn add_checks(&mut self, found: &[CheckResult], scene: &Scene) {
        let names = Names::new(scene);
        let share = |contested: u64, pixels: u64| rounded(1.0 - contested as f64 / pixels.max(1) as f64);
        let sum = |of: fn(&CheckResult) -> u64| found.iter().map(of).sum();
        self.summary.certain = Some(share(sum(|f| f.pixels_contested), sum(|f| f.pixels)));
        for (view, found) in self.views.iter_mut().zip(found) {
            self.summary.missed += found.missed.len();
            self.summary.pixels_different += found.pixels_different;
            view.check = Some(CheckReport {
                reference_visible: found.reference_visible,
                missed: found.missed.iter().map(|&item| names.of(item)).collect(),
                extra: found.extra,
                pixels_different: found.pixels_different,
                pixels_contested: found.pixels_contested,
                certain: share(found.pixels_contested, found.pixels),
                contested: (found.contested.iter())
                    .map(|(items, pixels)| ContestedReport {
                        items: items.iter().map(|&item| names.of(item)).collect(),
                        pixels: *pixels,
                    })
                    .collect(),
            });
        }
    }
}

/// Times looks, drawing and traversal of every method over all views.
pub(crate) fn measured(
    opened: &OpenedScene,
    prepared: &[PreparedScene],
    viewers: &mut [Viewer],
    views: &[View],
    size: [u32; 2],
) -> Vec<Report> {
    let settings = settings(Show::Image);
    // The first pictures of a run are slow for any method, so they are not timed.
    if let Some(view) = views.first() {
        for (prepared, viewer) in prepared.iter().zip(&mut *viewers) {
            draw(prepared, viewer, view, &settings);
        }
    }
    let progress = Progress::steps("measuring", prepared.len() * views.len() * (1 + 3 * PASSES));
    let measured = prepared.iter().zip(viewers).map(|(prepared, viewer)| {
        let looks = looks(prepared, views, viewer, &progress);
        let draws = draws(prepared, views, viewer, &settings, &progress);
        let walks = walks(prepared, views, viewer, &progress);
        let mut report = Report::new(opened, prepared, views, size, looks);
        report.add_times(&draws, &walks);
        report
    });
    measured.collect()
}

impl PassageReport {
    fn new(way: &LookPassage, scene: &Scene) -> PassageReport {
        let opening = |(sector, opening): (SectorId, OpeningId)| {
            let name = &scene.sector(sector).openings()[usize::from(opening.0)].name;
            format!("{}/{name}", scene.sector_name(sector))
        };
        PassageReport {
            sector: scene.sector_name(way.sector).to_owned(),
            portal: way.through.map(opening),
            crossings: way.crossings,
            contract: way.contract,
            items_visible: way.items_visible,
        }
    }
}

/// The visible items of all views, each once, without size.
type SeenItems = HashMap<(SectorId, ItemIndex), ItemReport>;

fn seen_items(looks: &[LookResult], names: &Names, nodes: &[SourceNodes]) -> SeenItems {
    let mut items = SeenItems::new();
    for &(sector, item) in looks.iter().flat_map(|look| &look.visible) {
        items.entry((sector, item)).or_insert_with(|| {
            let nodes = nodes.get(sector.0 as usize);
            ItemReport {
                name: names.of((sector, item)).into(),
                node: nodes.and_then(|nodes| nodes.node(item)),
                id: nodes.and_then(|nodes| nodes.id(item)).map(Arc::from),
                size_px: 0,
            }
        });
    }
    items
}

/// Rounds a coordinate as it was typed or read, so that 0.1 is printed as such.
pub(crate) fn single(coordinate: f64) -> f32 {
    coordinate as f32
}

/// Returns the height of what a parallel view shows, in scene units; `None` in perspective.
pub(crate) fn parallel_height(view: &View) -> Option<f64> {
    view.is_parallel().then(|| {
        let [top, bottom] = [0.0, f64::from(view.size()[1])].map(|y| view.ray([0.0, y])[0]);
        let square = (0..3).map(|axis| (top[axis] - bottom[axis]).powi(2)).sum::<f64>();
        rounded(square.sqrt())
    })
}

impl ViewReport {
    fn new(view: &View, look: LookResult, items: &SeenItems, scene: &Scene) -> ViewReport {
        let visible = || look.visible.iter().map(|item| &items[item]);
        ViewReport {
            eye: view.eye().map(single),
            toward: view.toward().map(single),
            up: view.up().map(single),
            fov: rounded(f64::from(view.fov_y()).to_degrees()),
            parallel: parallel_height(view),
            passages: look.passages.len(),
            through: look
                .passages
                .iter()
                .map(|way| PassageReport::new(way, scene))
                .collect(),
            items_in_frustum: look.items_in_frustum,
            items_visible: look.visible.len(),
            triangles_in_frustum: look.triangles_in_frustum,
            triangles_visible: look.triangles_visible,
            ms: rounded(look.ms),
            draw_ms: None,
            order_ms: None,
            picture: None,
            samples_shaded: None,
            complete: look.complete,
            visible: visible().map(|item| Arc::clone(&item.name)).collect(),
            visible_items: visible()
                .zip(&look.sizes_px)
                .map(|(item, &size_px)| ItemReport {
                    size_px,
                    ..item.clone()
                })
                .collect(),
            check: None,
            expected: None,
        }
    }
}

fn as_text<S: Serializer>(value: &impl Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}

fn as_map<S: Serializer>(counters: &[(&'static str, u64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(counters.iter().copied())
}

/// Serializes one item per line: with one line per field, a report of many views would be twice as long.
fn one_line_each<S: Serializer>(items: &[ItemReport], serializer: S) -> Result<S::Ok, S::Error> {
    let mut list = serializer.serialize_seq(Some(items.len()))?;
    for item in items {
        list.serialize_element(&to_raw_value(item).map_err(S::Error::custom)?)?;
    }
    list.end()
}
