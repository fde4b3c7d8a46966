//! The report of `choose`, as text and as JSON.

use crate::json::{SceneReport, rounded};
use crate::open::OpenedScene;
use crate::text::{bytes, count, ms, plural, short, table};
use enfilade::{
    ChoiceGoal, ChoiceOptions, Contract, Cost, Method, MethodChoice, Scene, SkipReason, Trial, Unsuited,
};
use serde::Serialize;
use std::time::Duration;

/// The JSON report: all choices of a scene.
#[derive(Debug, Serialize)]
pub(super) struct ChooseReport {
    scene: SceneReport,
    size: [u32; 2],
    threads: usize,
    simd: &'static str,
    aim: &'static str,
    choices: Vec<ChoiceReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    held_back: Option<HeldOut>,
}

/// The method of a sector, and the cost of all methods there.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ChoiceReport {
    sector: String,
    method: &'static str,
    /// Whether both halves of the views agree; if not, the sector keeps its method.
    sure: bool,
    views: usize,
    trials: Vec<TrialReport>,
}

#[derive(Clone, Debug, Serialize)]
struct TrialReport {
    method: &'static str,
    #[serde(flatten)]
    outcome: OutcomeReport,
}

#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
enum OutcomeReport {
    Cost {
        build_ms: f64,
        bytes: u64,
        look_ms: f64,
        draw_ms: f64,
        edit_ms: f64,
        frame_ms: f64,
    },
    Skipped {
        why: String,
        #[serde(skip)]
        word: &'static str,
    },
}

/// Measurement of the choices on held-out views.
#[derive(Debug, Serialize)]
pub(super) struct HeldOut {
    views: usize,
    /// Each sector that both sets of views see, in order.
    sectors: Vec<HeldOutSector>,
    /// Number of sectors whose choice takes at most a tenth longer than the fastest method.
    near_the_best: usize,
}

#[derive(Debug, Serialize)]
struct HeldOutSector {
    sector: u32,
    chosen: &'static str,
    chosen_ms: f64,
    best: &'static str,
    best_ms: f64,
}

/// Maximum ratio to the fastest method that counts as near it.
const NEAR_RATIO: f64 = 1.1;

impl ChoiceReport {
    pub(crate) fn new(scene: &Scene, choice: &MethodChoice) -> ChoiceReport {
        ChoiceReport {
            sector: scene.sector_name(choice.sector).to_owned(),
            method: choice.method.name(),
            sure: choice.sure,
            views: choice.views,
            trials: choice.trials.iter().map(TrialReport::new).collect(),
        }
    }

    fn frame_ms(&self, method: &str) -> Option<f64> {
        let trial = self.trials.iter().find(|trial| trial.method == method)?;
        match trial.outcome {
            OutcomeReport::Cost { frame_ms, .. } => Some(frame_ms),
            OutcomeReport::Skipped { .. } => None,
        }
    }
}

/// Returns the choices in one line: `chosen: cell in Tribune, Bay and 3 more; z-buffer in Hall`. Empty without choices.
pub(crate) fn summary_line(choices: &[ChoiceReport]) -> String {
    const FEW: usize = 3;
    let of = |method: Method| {
        let here = choices.iter().filter(|choice| choice.method == method.name());
        let names: Vec<&str> = here.map(|choice| choice.sector.as_str()).collect();
        let more = match names.len().saturating_sub(FEW) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        (!names.is_empty()).then(|| format!("{method} in {}{more}", names[..names.len().min(FEW)].join(", ")))
    };
    let methods: Vec<String> = Method::ALL.into_iter().filter_map(of).collect();
    if methods.is_empty() {
        return String::new();
    }
    format!("chosen: {} (--json - lists the times)\n", methods.join("; "))
}

impl TrialReport {
    fn new(trial: &Trial) -> TrialReport {
        let outcome = match &trial.outcome {
            Ok(Cost {
                build,
                bytes,
                look,
                draw,
                edit,
                frame,
                ..
            }) => OutcomeReport::Cost {
                build_ms: in_ms(*build),
                bytes: *bytes,
                look_ms: in_ms(*look),
                draw_ms: in_ms(*draw),
                edit_ms: in_ms(*edit),
                frame_ms: in_ms(*frame),
            },
            Err(why) => OutcomeReport::Skipped {
                why: why.to_string(),
                word: word(why),
            },
        };
        TrialReport {
            method: trial.method.name(),
            outcome,
        }
    }
}

/// Returns a short label of the reason.
fn word(why: &SkipReason) -> &'static str {
    match why {
        SkipReason::Contract(Contract::Approximate) => "sets that may miss items",
        SkipReason::Contract(_) => "sets that may contain hidden items (--conservative)",
        SkipReason::BuildsTooLong(_) => "too long to build",
        SkipReason::Moves => "items move",
        SkipReason::NotSeen => "in no view",
        SkipReason::Unsuited(why) => match why.reason {
            Unsuited::TooLarge { .. } => "too large (--memory)",
            Unsuited::NotBaked => "not baked",
            Unsuited::NotConvex(_) => "not convex",
            Unsuited::NoTerrain | Unsuited::TerrainEdited => "no terrain",
            _ => "unsuited",
        },
        _ => "unsuited",
    }
}

fn in_ms(time: Duration) -> f64 {
    rounded(time.as_secs_f64() * 1e3)
}

impl HeldOut {
    /// Compares choices with the same sectors measured on other views.
    pub(super) fn new(choices: &[MethodChoice], again: &[MethodChoice], views: usize) -> HeldOut {
        let sectors: Vec<HeldOutSector> = choices.iter().zip(again).filter_map(held_back).collect();
        HeldOut {
            views,
            near_the_best: sectors
                .iter()
                .filter(|held| held.chosen_ms <= NEAR_RATIO * held.best_ms)
                .count(),
            sectors,
        }
    }
}

fn held_back((choice, again): (&MethodChoice, &MethodChoice)) -> Option<HeldOutSector> {
    let costs = || {
        let trials = again.trials.iter();
        trials.filter_map(|trial| Some((trial.method, trial.outcome.as_ref().ok()?.frame)))
    };
    let (best, best_frame) = costs().min_by_key(|&(_, frame)| frame)?;
    let (_, chosen_frame) = costs().find(|&(method, _)| method == choice.method)?;
    (choice.views > 0).then(|| HeldOutSector {
        sector: choice.sector.0,
        chosen: choice.method.name(),
        chosen_ms: in_ms(chosen_frame),
        best: best.name(),
        best_ms: in_ms(best_frame),
    })
}

impl ChooseReport {
    pub(super) fn new(
        opened: &OpenedScene,
        choices: &[MethodChoice],
        options: &ChoiceOptions,
        size: [u32; 2],
        held_back: Option<HeldOut>,
    ) -> ChooseReport {
        ChooseReport {
            scene: SceneReport::new(opened),
            size,
            threads: rayon::current_num_threads(),
            simd: enfilade::simd_level(),
            aim: if options.aim == ChoiceGoal::Draw {
                "draw"
            } else {
                "look"
            },
            choices: choices
                .iter()
                .map(|choice| ChoiceReport::new(&opened.scene, choice))
                .collect(),
            held_back,
        }
    }

    pub(super) fn for_people(&self) -> String {
        let [width, height] = self.size;
        let SceneReport {
            file,
            items,
            triangles,
            sectors,
            ..
        } = &self.scene;
        let mut text = format!(
            "{file}: {}, {} triangles, {}; ms per frame to {}, {width}x{height}, {}, {}\n\n",
            plural(*items, "item"),
            count(*triangles),
            plural(*sectors, "sector"),
            self.aim,
            plural(self.threads, "thread"),
            self.simd
        );
        text += &self.costs();
        text += &left_out(&self.choices);
        if let Some(held_back) = &self.held_back {
            text += &held_back.for_people(&self.choices);
        }
        text
    }

    /// Returns the table of frame times, by sector and by method that was measured anywhere.
    fn costs(&self) -> String {
        let names = Method::ALL.map(Method::name);
        let tried = |name: &&&str| self.choices.iter().any(|choice| choice.frame_ms(name).is_some());
        let tried: Vec<&str> = names.iter().filter(tried).copied().collect();
        let header: Vec<&str> = ["sector", "views", "method", "builds"]
            .into_iter()
            .chain(tried.iter().copied())
            .collect();
        let row = |choice: &ChoiceReport| {
            let times = tried.iter().map(|name| {
                let time = choice
                    .frame_ms(name)
                    .map_or_else(|| "–".to_owned(), in_three_places);
                if *name == choice.method {
                    format!("*{time}")
                } else {
                    time
                }
            });
            let first = [
                choice.sector.clone(),
                choice.views.to_string(),
                choice.chosen(),
                choice.build_stats(),
            ];
            first.into_iter().chain(times).collect()
        };
        table(
            &header,
            &self.choices.iter().map(row).collect::<Vec<Vec<String>>>(),
        )
    }
}

impl ChoiceReport {
    /// Returns the method, and whether it is a default because no view sees the sector or the choice is unsure.
    fn chosen(&self) -> String {
        match (self.sure, self.views) {
            (true, _) => self.method.to_owned(),
            (false, 0) => format!("{} (in no view)", self.method),
            (false, _) => format!("{} (unsure)", self.method),
        }
    }

    fn build_stats(&self) -> String {
        let mut trials = self.trials.iter();
        let chosen = trials.find(|trial| trial.method == self.method);
        match chosen.map(|trial| &trial.outcome) {
            Some(OutcomeReport::Cost {
                build_ms,
                bytes: size,
                ..
            }) => format!("{} ms, {}", ms(*build_ms), bytes(*size)),
            _ => "–".to_owned(),
        }
    }
}

fn in_three_places(ms: f64) -> String {
    format!("{ms:.3}")
}

/// Returns the methods that were measured in no sector, grouped by the reason in the first sector.
fn left_out(choices: &[ChoiceReport]) -> String {
    let mut by_reason: Vec<(&str, Vec<&str>)> = Vec::new();
    for (index, method) in Method::ALL.into_iter().enumerate() {
        let mut reasons = choices.iter().map(|choice| match choice.trials[index].outcome {
            OutcomeReport::Skipped { word, .. } => Some(word),
            OutcomeReport::Cost { .. } => None,
        });
        let Some(Some(word)) = reasons.next().filter(|_| reasons.all(|other| other.is_some())) else {
            continue;
        };
        match by_reason.iter_mut().find(|(reason, _)| *reason == word) {
            Some((_, methods)) => methods.push(method.name()),
            None => by_reason.push((word, vec![method.name()])),
        }
    }
    let line =
        |(word, methods): &(&str, Vec<&str>)| format!("  not measured: {}: {word}\n", methods.join(", "));
    by_reason.iter().map(line).collect()
}

impl HeldOut {
    fn for_people(&self, choices: &[ChoiceReport]) -> String {
        let header = ["sector", "chosen", "ms", "fastest", "ms", "ratio"];
        let row = |held: &HeldOutSector| {
            vec![
                choices[held.sector as usize].sector.clone(),
                held.chosen.to_owned(),
                in_three_places(held.chosen_ms),
                held.best.to_owned(),
                in_three_places(held.best_ms),
                short(held.chosen_ms / held.best_ms.max(1e-4)),
            ]
        };
        let rows: Vec<Vec<String>> = self.sectors.iter().map(row).collect();
        format!(
            "\non {} held out from the choice:\n{}{} of {} within 10 % of the fastest method\n",
            plural(self.views, "view"),
            table(&header, &rows),
            self.near_the_best,
            plural(self.sectors.len(), "sector"),
        )
    }
}
