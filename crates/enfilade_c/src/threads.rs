//! Threads: none but the caller's, unless it asks for some.

use crate::lent::Caller;
use crate::status::{EnfiladeError, EnfiladeStatus, Failure, refuse};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::cell::Cell;
use std::sync::{Arc, RwLock};

/// Most threads that a pool may have.
const MOST: u32 = 256;

static POOL: RwLock<Option<Arc<ThreadPool>>> = RwLock::new(None);

/// Sets the number of threads that calls may use that build, read files or find rooms, and looks by viewers with
/// ENFILADE_VIEWER_USES_THREADS. The threads are shared by the whole process, and wait for work.
///
/// @param count 1 to 256; 0 for one per core. Until the first call, and with 1, every call runs on the thread that makes it,
/// and the library starts none.
///
/// Results do not depend on it. Calls that run already keep the threads that they have.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_set_threads(count: u32, error: *mut EnfiladeError) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |_| {
        if count > MOST {
            return Err(refuse(
                "c/threads",
                format_args!("{count} threads; there can be {MOST}"),
            ));
        }
        let pool = if count == 1 {
            None
        } else {
            let built = ThreadPoolBuilder::new().num_threads(count as usize).build();
            Some(Arc::new(built.map_err(|why| {
                Failure::new(EnfiladeStatus::TooLarge, "c/threads", why)
            })?))
        };
        *POOL.write().unwrap_or_else(|poisoned| poisoned.into_inner()) = pool;
        Ok(())
    })
}

/// Makes sure that parallel loops of the libraries run on the calling thread: rayon would start a thread for each core.
pub(crate) fn start_none() {
    thread_local! {
        static IS_ALONE: Cell<bool> = const { Cell::new(false) };
    }
    if !IS_ALONE.replace(true) {
        // Fails on a thread of a pool, which has one already.
        let _ = ThreadPoolBuilder::new()
            .num_threads(1)
            .use_current_thread()
            .build();
    }
}

/// Runs work on the threads that the caller allows.
pub(crate) fn on_all<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let pool = POOL.read().unwrap_or_else(|poisoned| poisoned.into_inner());
    match pool.clone() {
        Some(pool_in_use) => {
            drop(pool);
            pool_in_use.install(work)
        }
        None => work(),
    }
}
