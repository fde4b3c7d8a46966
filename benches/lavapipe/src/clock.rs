//! What something takes.

use cpu_time::ProcessTime;
use std::time::Instant;

/// How time is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Clock {
    /// What one waits.
    Wall,
    /// What all cores work for this process: nearly the same however much else the machine does.
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

/// Does it, and says what it took.
pub(crate) fn timed<T>(what: impl FnOnce() -> T) -> (T, Times) {
    let (wall, cpu) = (Instant::now(), ProcessTime::now());
    let done = what();
    (
        done,
        [wall.elapsed(), cpu.elapsed()].map(|time| time.as_secs_f64() * 1e3),
    )
}
