//! What was chosen and why, for people and for programs.

use crate::open::Opened;
use crate::report::{SceneReport, rounded};
use crate::text::{bytes, count, ms, plural, short, table};
use enfilade::{
    ChoiceGoal, ChoiceOptions, Contract, Cost, Method, MethodChoice, Scene, SkipReason, Trial, Unsuited,
};
use serde::Serialize;
use std::time::Duration;

/// All choices for a scene.
#[derive(Debug, Serialize)]
pub(super) struct Chosen {
    scene: SceneReport,
    size: [u32; 2],
    threads: usize,
    simd: &'static str,
    aim: &'static str,
    choices: Vec<ChoiceReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    held_back: Option<HeldBack>,
}

/// The method of a sector, and what all cost there.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ChoiceReport {
    sector: String,
    method: &'static str,
    /// Whether both halves of the views agree; else it is the sector's own.
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
    Not {
        why: String,
        #[serde(skip)]
        word: &'static str,
    },
}

/// How choices stand on views that they were not made by.
#[derive(Debug, Serialize)]
pub(super) struct HeldBack {
    views: usize,
    /// Of each sector that both see, in order.
    sectors: Vec<HeldBackReport>,
    /// How many of them take at most a tenth longer than the best there.
    near_the_best: usize,
}

#[derive(Debug, Serialize)]
struct HeldBackReport {
    sector: u32,
    chosen: &'static str,
    chosen_ms: f64,
    best: &'static str,
    best_ms: f64,
}

/// So much longer than the best is near it.
const NEAR: f64 = 1.1;

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
            OutcomeReport::Not { .. } => None,
        }
    }
}

/// `chosen: cell in Tribune, Bay and 3 more; z-buffer in Hall`; nothing where nothing was.
pub(crate) fn in_words(choices: &[ChoiceReport]) -> String {
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
    format!("chosen: {} (--json - says why)\n", methods.join("; "))
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
            Err(why) => OutcomeReport::Not {
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

/// The reason in a word or two.
fn word(why: &SkipReason) -> &'static str {
    match why {
        SkipReason::Promise(Contract::Approximate) => "sets that may lack something",
        SkipReason::Promise(_) => "sets that may hold more (--conservative)",
        SkipReason::BuildsTooLong(_) => "too long to build",
        SkipReason::Moves => "what moves",
        SkipReason::NotSeen => "not seen",
        SkipReason::Unsuited(Unsuited::TooLarge(_)) => "too large (--memory)",
        SkipReason::Unsuited(Unsuited::NotBaked(_)) => "not baked",
        SkipReason::Unsuited(Unsuited::NotConvex(_)) => "not convex",
        SkipReason::Unsuited(Unsuited::TerrainUnusable(_)) => "no terrain",
        _ => "unsuited",
    }
}

fn in_ms(time: Duration) -> f64 {
    rounded(time.as_secs_f64() * 1e3)
}

impl HeldBack {
    /// Holds choices against the same sectors measured on other views.
    pub(super) fn new(choices: &[MethodChoice], again: &[MethodChoice], views: usize) -> HeldBack {
        let sectors: Vec<HeldBackReport> = choices.iter().zip(again).filter_map(held_back).collect();
        HeldBack {
            views,
            near_the_best: sectors
                .iter()
                .filter(|held| held.chosen_ms <= NEAR * held.best_ms)
                .count(),
            sectors,
        }
    }
}

fn held_back((choice, again): (&MethodChoice, &MethodChoice)) -> Option<HeldBackReport> {
    let costs = || {
        let trials = again.trials.iter();
        trials.filter_map(|trial| Some((trial.method, trial.outcome.as_ref().ok()?.frame)))
    };
    let (best, best_frame) = costs().min_by_key(|&(_, frame)| frame)?;
    let (_, chosen_frame) = costs().find(|&(method, _)| method == choice.method)?;
    (choice.views > 0).then(|| HeldBackReport {
        sector: choice.sector.0,
        chosen: choice.method.name(),
        chosen_ms: in_ms(chosen_frame),
        best: best.name(),
        best_ms: in_ms(best_frame),
    })
}

impl Chosen {
    pub(super) fn new(
        opened: &Opened,
        choices: &[MethodChoice],
        terms: &ChoiceOptions,
        size: [u32; 2],
        held_back: Option<HeldBack>,
    ) -> Chosen {
        Chosen {
            scene: SceneReport::new(opened),
            size,
            threads: rayon::current_num_threads(),
            simd: enfilade::simd_level(),
            aim: if terms.aim == ChoiceGoal::Draw {
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
            "{file}: {}, {} triangles, {}; ms a frame to {}, {width}x{height}, {}, {}\n\n",
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

    /// What a frame takes in each sector by each method that was tried anywhere.
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
    /// What is chosen, or kept where nothing is sure.
    fn chosen(&self) -> String {
        match (self.sure, self.views) {
            (true, _) => self.method.to_owned(),
            (false, 0) => format!("{} (not seen)", self.method),
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

/// The methods that were tried in no sector, by why not in the first.
fn left_out(choices: &[ChoiceReport]) -> String {
    let mut by_reason: Vec<(&str, Vec<&str>)> = Vec::new();
    for (place, method) in Method::ALL.into_iter().enumerate() {
        let mut reasons = choices.iter().map(|choice| match choice.trials[place].outcome {
            OutcomeReport::Not { word, .. } => Some(word),
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
    let line = |(word, methods): &(&str, Vec<&str>)| format!("  not tried: {}: {word}\n", methods.join(", "));
    by_reason.iter().map(line).collect()
}

impl HeldBack {
    fn for_people(&self, choices: &[ChoiceReport]) -> String {
        let header = ["sector", "chosen", "ms", "best", "ms", "times"];
        let row = |held: &HeldBackReport| {
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
            "\non {} that methods were not chosen by:\n{}{} of {} within a tenth of the best\n",
            plural(self.views, "view"),
            table(&header, &rows),
            self.near_the_best,
            plural(self.sectors.len(), "sector"),
        )
    }
}
