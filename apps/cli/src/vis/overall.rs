//! How much of the whole work is done, how long the rest may take, and whether somebody wants it to stop.

use crate::out;
use crate::progress::Progress;
use enfilade_bake::{PairsWork, Stage};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The share of the whole that each of [`Stage::ALL`] takes: the mean of dm1, e1m1, start and lq_e1m5, which differ by a third.
const SHARES: [f64; 6] = [0.09, 0.15, 0.06, 0.17, 0.42, 0.11];

/// Time between two lines where standard error is no terminal.
const EVERY: Duration = Duration::from_secs(10);

/// Shows the progress of a run: a bar on a terminal, else a line now and then.
pub(super) struct Overall {
    bar: Option<Progress>,
    prints: bool,
    /// The stage that is not worked on any more.
    end: Stage,
    start: Instant,
    printed: Instant,
}

impl Overall {
    pub(super) fn new(end: Stage, is_quiet: bool) -> Overall {
        let is_terminal = std::io::stderr().is_terminal();
        Overall {
            bar: (is_terminal && !is_quiet).then(|| Progress::share("vis")),
            prints: !is_terminal && !is_quiet,
            end,
            start: Instant::now(),
            printed: Instant::now(),
        }
    }

    /// Shows how far the work is.
    pub(super) fn show(&mut self, work: &PairsWork) {
        let share = share(work.stage(), work.share(), self.end);
        if let Some(bar) = &self.bar {
            bar.rename(in_words(work.stage()));
            bar.set(share);
        } else if self.prints && self.printed.elapsed() >= EVERY {
            self.printed = Instant::now();
            let left = self.start.elapsed().as_secs_f64() * (1.0 / share.max(1e-3) - 1.0);
            out::note(format_args!(
                "vis: {:.0} %, about {} left (stage {})",
                100.0 * share,
                in_time(left),
                in_words(work.stage())
            ));
        }
    }
}

/// How much of the work up to a stage is done, 0 to 1, if so much of the present stage is.
fn share(stage: Stage, of_stage: f64, end: Stage) -> f64 {
    let until = |end: Stage| -> f64 {
        let stages = Stage::ALL.iter().zip(SHARES);
        stages
            .filter(|&(&stage, _)| stage < end)
            .map(|(_, share)| share)
            .sum()
    };
    let of_this = Stage::ALL.iter().position(|&other| other == stage);
    let done = until(stage) + of_this.map_or(0.0, |at| SHARES[at]) * of_stage;
    (done / until(end)).min(1.0)
}

/// `45 s`, `12 min`, `3.4 h`.
fn in_time(seconds: f64) -> String {
    match seconds {
        ..100.0 => format!("{seconds:.0} s"),
        ..6000.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}

fn in_words(stage: Stage) -> &'static str {
    match stage {
        Stage::FirstBound => "1 of 6: floods",
        Stage::Passages => "2 of 6: passages",
        Stage::Fixpoint => "3 of 6: fixpoint",
        Stage::Sampling => "4 of 6: lines",
        Stage::Flow => "5 of 6: flow",
        Stage::Backflow | Stage::Done => "6 of 6: flow back",
    }
}

static IS_STOPPED: AtomicBool = AtomicBool::new(false);

/// Has Ctrl-C and a request to terminate end the work after the present step. A second one ends the program at once.
pub(super) fn stop_at_a_signal() {
    // Without a handler the system's own ends the program, and what was saved last is what a run goes on from.
    let _ = ctrlc::set_handler(|| {
        if IS_STOPPED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
}

/// Whether somebody wants the work to stop.
pub(super) fn is_stopped() -> bool {
    IS_STOPPED.load(Ordering::Relaxed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_grow_from_nothing_to_the_whole() {
        for end in [Stage::Sampling, Stage::Done] {
            let mut last = 0.0;
            assert_eq!(share(Stage::FirstBound, 0.0, end), 0.0);
            for stage in Stage::ALL.into_iter().filter(|&stage| stage < end) {
                for of_stage in [0.0, 0.5, 1.0] {
                    let now = share(stage, of_stage, end);
                    assert!(now >= last && now <= 1.0, "{stage:?}: {now} after {last}");
                    last = now;
                }
            }
            assert!((last - 1.0).abs() < 1e-9, "{end:?}: {last}");
        }
    }

    #[test]
    fn times_have_the_unit_that_suits_them() {
        assert_eq!([4.2, 600.0, 12_240.0].map(in_time), ["4 s", "10 min", "3.4 h"]);
    }
}
