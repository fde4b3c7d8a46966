//! A bar on standard error for what takes more than a second.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Work that is going on. Shown after a second, on a terminal only; gone when dropped.
pub(crate) struct Progress {
    bar: ProgressBar,
    waiting: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    /// Work whose end cannot be foreseen.
    pub(crate) fn spinner(what: &str) -> Progress {
        Progress::start(None, "{spinner} {msg} ({elapsed})", what)
    }

    /// Work in `steps` steps.
    pub(crate) fn steps(what: &str, steps: usize) -> Progress {
        Progress::start(
            Some(steps as u64),
            "{msg} {wide_bar} {pos} of {len}, {eta} left",
            what,
        )
    }

    /// Work that says itself how much of it is done.
    pub(crate) fn share(what: &str) -> Progress {
        Progress::start(Some(PARTS), "{msg} {wide_bar} {percent} %, {eta} left", what)
    }

    /// So much of it is done, 0 to 1.
    pub(crate) fn set(&self, share: f64) {
        self.bar.set_position((share * PARTS as f64) as u64);
    }

    /// Changes what the bar is called.
    pub(crate) fn rename(&self, what: &'static str) {
        self.bar.set_message(what);
    }

    /// One step is done.
    pub(crate) fn step(&self) {
        self.bar.inc(1);
    }

    fn start(steps: Option<u64>, template: &str, what: &str) -> Progress {
        let bar =
            ProgressBar::with_draw_target(steps, ProgressDrawTarget::hidden()).with_message(what.to_owned());
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        let waiting = std::io::stderr().is_terminal().then(|| {
            let (over, ends) = channel();
            let shown = bar.clone();
            (
                over,
                std::thread::spawn(move || show_after_a_second(&shown, || ends.recv_timeout(A_SECOND))),
            )
        });
        Progress { bar, waiting }
    }
}

/// Into how many parts a bar is cut that shows a share.
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
        if let Some((over, thread)) = self.waiting.take() {
            // The thread sees the end at once, so that no bar appears after its work is over.
            drop(over);
            let _ = thread.join();
        }
        self.bar.finish_and_clear();
    }
}
