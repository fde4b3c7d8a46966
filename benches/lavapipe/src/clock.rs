//! Time measurement.

use cpu_time::ProcessTime;
use std::time::Instant;

/// A kind of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Clock {
    /// Elapsed time.
    Wall,
    /// CPU time of this process on all cores, which hardly depends on other processes.
    Cpu,
}

impl Clock {
    pub(crate) const ALL: [Clock; 2] = [Clock::Wall, Clock::Cpu];

    pub(crate) fn number(self) -> usize {
        self as usize
    }
}

/// Milliseconds by each clock.
pub(crate) type Times = [f64; Clock::ALL.len()];

/// Runs `work`; returns its result and the time it took.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, Times) {
    let (wall, cpu) = (Instant::now(), ProcessTime::now());
    let done = work();
    (
        done,
        [wall.elapsed(), cpu.elapsed()].map(|time| time.as_secs_f64() * 1e3),
    )
}
