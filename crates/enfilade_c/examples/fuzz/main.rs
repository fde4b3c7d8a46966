//! Calls every function with null, wrong and random arguments, and checks that it returns a code and stays sound.
//!
//! Run with `cargo run --release -p enfilade_c --example fuzz -- SECONDS SEED [THREADS]`. With one thread, a seed repeats a run.
//! Pointers that are not null point to as much as their count says: the library cannot detect others.
#![allow(unsafe_code, reason = "calls the functions as C does")]
#![allow(clippy::print_stdout, reason = "a driver prints what it counted")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "all pointers are null, or into arrays of the driver"
)]

mod arguments;
mod calls;
mod world;

use calls::FUNCTION_COUNT;
use enfilade_c::*;
use fastrand::Rng;
use std::collections::HashSet;
use std::ffi::{CStr, c_char, c_void};
use std::ptr::{null, null_mut, without_provenance_mut};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Number of functions that are called.
pub(crate) const FUNCTIONS: usize = FUNCTION_COUNT;

/// What a run did.
#[derive(Clone, Debug, Default)]
pub(crate) struct Count {
    /// Calls of each function, by number.
    pub(crate) calls: Vec<u64>,
    /// Those of them that succeeded.
    pub(crate) succeeded: Vec<u64>,
    /// Calls that returned each status.
    pub(crate) statuses: Vec<u64>,
}

// The test of the driver has no use for it.
#[cfg(not(test))]
fn main() {
    let mut arguments = std::env::args()
        .skip(1)
        .map(|argument| argument.parse::<u64>().expect("a number"));
    let [seconds, seed] = [arguments.next().unwrap_or(10), arguments.next().unwrap_or(1)];
    let threads = arguments.next().unwrap_or(1);
    let handles = Mutex::new(Handles::default());
    let run = |number: u64| {
        fuzz(
            seed + number,
            Duration::from_secs(seconds),
            u64::MAX,
            &handles,
            threads > 1,
        )
    };
    let counts = std::thread::scope(|scope| {
        let started: Vec<_> = (0..threads)
            .map(|number| scope.spawn(move || run(number)))
            .collect();
        started
            .into_iter()
            .map(|thread| thread.join().expect("no panic"))
            .collect::<Vec<_>>()
    });
    for (number, count) in counts.iter().enumerate() {
        let calls: u64 = count.calls.iter().sum();
        let least = count.calls.iter().min().copied().unwrap_or(0);
        println!(
            "thread {number}: {calls} calls, at least {least} of each of {} functions",
            count.calls.len()
        );
        println!("  by status: {:?}", count.statuses);
        println!("  succeeded, by function: {:?}", count.succeeded);
    }
}

/// Handles that were created, and some that were freed.
#[derive(Default)]
pub(crate) struct Handles {
    all: [Vec<usize>; 6],
    /// Ids of all kinds.
    ids: Vec<u64>,
}

const MESH: usize = 0;
const SCENE: usize = 1;
const VIEWER: usize = 2;
const OCCLUDER: usize = 3;
const OCCLUSION: usize = 4;
const ROOMS: usize = 5;

/// Most objects of a kind at a time.
const MOST: usize = 6;

struct Fuzz<'a> {
    rng: Rng,
    handles: &'a Mutex<Handles>,
    error: EnfiladeError,
    /// Bytes for inputs, aligned to 8; random, but valid as what the functions read.
    words: Vec<u64>,
    results: Vec<u64>,
    is_shared: bool,
    removed: HashSet<u64>,
}

/// Calls functions until the time is over, or `most` were called.
pub(crate) fn fuzz(seed: u64, time: Duration, most: u64, handles: &Mutex<Handles>, is_shared: bool) -> Count {
    let start = Instant::now();
    let mut fuzz = Fuzz {
        rng: Rng::with_seed(seed),
        handles,
        error: unsafe { std::mem::zeroed() },
        words: vec![0; 1 << 13],
        results: vec![0; 1 << 16],
        is_shared,
        removed: HashSet::new(),
    };
    let mut count = Count {
        calls: vec![0; FUNCTIONS],
        succeeded: vec![0; FUNCTIONS],
        statuses: vec![0; 15],
    };
    while count.calls.iter().sum::<u64>() < most && start.elapsed() < time {
        // Now and then a world that is sound, so that the calls after it reach something.
        if fuzz.rng.u32(0..400) == 0 {
            fuzz.build();
        }
        let function = fuzz.rng.usize(0..FUNCTIONS);
        let status = fuzz.call(function) as usize;
        assert!(
            status < 13,
            "function {function} returned {status}: {:?}",
            fuzz.message()
        );
        count.calls[function] += 1;
        count.succeeded[function] += u64::from(status == 0);
        count.statuses[status] += 1;
        if function != 0 {
            fuzz.check(function, status);
        }
    }
    count
}

impl Fuzz<'_> {
    fn message(&self) -> String {
        let text = unsafe { CStr::from_ptr(self.error.message.as_ptr()) };
        text.to_string_lossy().into_owned()
    }

    /// Checks what the last call reported.
    fn check(&mut self, function: usize, status: usize) {
        if self.error.reserved == u32::MAX {
            // It was given no error to fill in.
            return;
        }
        assert_eq!(self.error.status as usize, status, "function {function}");
        assert!(self.error.message.contains(&0) && self.error.code.contains(&0));
        let is_empty = self.error.message[0] == 0;
        assert_eq!(is_empty, status == 0, "function {function}: {:?}", self.message());
    }

    fn one_in(&mut self, chance: u32) -> bool {
        self.rng.u32(0..chance) == 0
    }

    /// Returns null sometimes.
    fn error(&mut self) -> *mut EnfiladeError {
        self.error.status = EnfiladeStatus::Ok;
        self.error.reserved = u32::MAX;
        if self.one_in(20) {
            null_mut()
        } else {
            &raw mut self.error
        }
    }
}
