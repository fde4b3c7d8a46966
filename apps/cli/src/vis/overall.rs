//! Progress of a whole `vis` run, with the estimated time left; and interruption by a signal.

use crate::out;
use crate::progress::Progress;
use enfilade_bake::{PairsWork, Stage};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Share of the run time of each of [`Stage::ALL`]: the mean of dm1, e1m1, start and lq_e1m5, which differ by a third.
const SHARES: [f64; 6] = [0.09, 0.15, 0.06, 0.17, 0.42, 0.11];

/// Time between two lines if standard error is not a terminal.
const EVERY: Duration = Duration::from_secs(10);

/// Shows the progress of a run: a bar on a terminal, else a line every [`EVERY`].
pub(super) struct OverallProgress {
    bar: Option<Progress>,
    prints: bool,
    /// The stage at which the run ends; it is not worked on.
    end: Stage,
    start: Instant,
    printed: Instant,
}

impl OverallProgress {
    pub(super) fn new(end: Stage, is_quiet: bool) -> OverallProgress {
        let is_terminal = std::io::stderr().is_terminal();
        OverallProgress {
            bar: (is_terminal && !is_quiet).then(|| Progress::share("vis")),
            prints: !is_terminal && !is_quiet,
            end,
            start: Instant::now(),
            printed: Instant::now(),
        }
    }

    /// Updates the bar, or prints a line if one is due.
    pub(super) fn show(&mut self, work: &PairsWork) {
        let share = share(work.stage(), work.share(), self.end);
        if let Some(bar) = &self.bar {
            bar.rename(stage_name(work.stage()));
            bar.set(share);
        } else if self.prints && self.printed.elapsed() >= EVERY {
            self.printed = Instant::now();
            let left = self.start.elapsed().as_secs_f64() * (1.0 / share.max(1e-3) - 1.0);
            out::note(format_args!(
                "vis: {:.0} %, about {} left (stage {})",
                100.0 * share,
                duration(left),
                stage_name(work.stage())
            ));
        }
    }
}

/// Returns the finished share of the work up to `end`, 0 to 1, from the finished share `of_stage` of the current stage.
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

/// Formats a duration: `45 s`, `12 min`, `3.4 h`.
fn duration(seconds: f64) -> String {
    match seconds {
        ..100.0 => format!("{seconds:.0} s"),
        ..6000.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}

fn stage_name(stage: Stage) -> &'static str {
    match stage {
        Stage::FirstBound => "1 of 6: flood fill",
        Stage::Passages => "2 of 6: passages",
        Stage::Fixpoint => "3 of 6: fixpoint",
        Stage::Sampling => "4 of 6: line sampling",
        Stage::Flow => "5 of 6: flow",
        Stage::Backflow | Stage::Done => "6 of 6: backward flow",
    }
}

static IS_STOPPED: AtomicBool = AtomicBool::new(false);

/// Installs a handler: Ctrl-C or a termination request stops the work after the current step, a second one exits at
/// once.
pub(super) fn stop_at_a_signal() {
    // If installing fails, the system's handler ends the program, and --resume continues from the last save.
    let _ = ctrlc::set_handler(|| {
        if IS_STOPPED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
}

/// Whether a signal has requested a stop.
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
        assert_eq!([4.2, 600.0, 12_240.0].map(duration), ["4 s", "10 min", "3.4 h"]);
    }
}
