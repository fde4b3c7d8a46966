//! Shows a progress bar on standard error for work that takes more than a second.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// A progress bar. Appears after a second, on a terminal only; removed when dropped.
pub(crate) struct Progress {
    bar: ProgressBar,
    timer: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    /// Starts a spinner, for work of unknown length.
    pub(crate) fn spinner(label: &str) -> Progress {
        Progress::start(None, "{spinner} {msg} ({elapsed})", label)
    }

    /// Starts a bar for work of `steps` steps.
    pub(crate) fn steps(label: &str, steps: usize) -> Progress {
        Progress::start(
            Some(steps as u64),
            "{msg} {wide_bar} {pos} of {len}, {eta} left",
            label,
        )
    }

    /// Starts a bar whose position is set with [`Progress::set`].
    pub(crate) fn share(label: &str) -> Progress {
        Progress::start(Some(PARTS), "{msg} {wide_bar} {percent} %, {eta} left", label)
    }

    /// Sets the finished share of the work, 0 to 1.
    pub(crate) fn set(&self, share: f64) {
        self.bar.set_position((share * PARTS as f64) as u64);
    }

    /// Changes the bar's label.
    pub(crate) fn rename(&self, label: &'static str) {
        self.bar.set_message(label);
    }

    /// Advances the bar by one step.
    pub(crate) fn step(&self) {
        self.bar.inc(1);
    }

    fn start(steps: Option<u64>, template: &str, label: &str) -> Progress {
        let bar =
            ProgressBar::with_draw_target(steps, ProgressDrawTarget::hidden()).with_message(label.to_owned());
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        let timer = std::io::stderr().is_terminal().then(|| {
            let (over, ends) = channel();
            let shown = bar.clone();
            (
                over,
                std::thread::spawn(move || show_after_a_second(&shown, || ends.recv_timeout(A_SECOND))),
            )
        });
        Progress { bar, timer }
    }
}

/// Resolution of a bar that shows a share.
const PARTS: u64 = 10_000;

const A_SECOND: Duration = Duration::from_secs(1);

fn show_after_a_second(bar: &ProgressBar, wait: impl FnOnce() -> Result<(), RecvTimeoutError>) {
    if wait() == Err(RecvTimeoutError::Timeout) {
        bar.set_draw_target(ProgressDrawTarget::stderr());
        bar.enable_steady_tick(Duration::from_millis(100));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((over, thread)) = self.timer.take() {
            // The thread notices at once, so no bar appears after the work is done.
            drop(over);
            let _ = thread.join();
        }
        self.bar.finish_and_clear();
    }
}
