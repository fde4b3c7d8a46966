//! A short run of the fuzz driver; `cargo run --release -p enfilade_c --example fuzz` runs it for longer.
#![allow(unsafe_code, reason = "calls the functions as C does")]

#[path = "../examples/fuzz/main.rs"]
mod driver;

use std::sync::Mutex;
use std::time::Duration;

#[test]
fn null_wrong_and_random_arguments_give_a_code() {
    let handles = Mutex::new(driver::Handles::default());
    let count = driver::fuzz(7, Duration::from_secs(60), 10_000, &handles, false);
    assert!(count.calls.iter().all(|&calls| calls > 0), "{:?}", count.calls);
    let never = count.succeeded.iter().filter(|&&calls| calls == 0).count();
    assert!(
        never < 10,
        "{never} functions never succeed: {:?}",
        count.succeeded
    );
    assert!(
        count.statuses[0] > 500,
        "hardly a call succeeded: {:?}",
        count.statuses
    );
}

#[test]
fn threads_that_share_objects_get_a_code() {
    let handles = Mutex::new(driver::Handles::default());
    std::thread::scope(|scope| {
        for seed in 0..3 {
            let handles = &handles;
            scope.spawn(move || driver::fuzz(seed, Duration::from_secs(20), 4_000, handles, true));
        }
    });
}
