//! Threads: none but the caller's, unless it asks for some.

use crate::lent::Caller;
use crate::status::{EnfiladeError, EnfiladeStatus, Failure, refuse};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{Arc, Once, RwLock};

/// Most threads that a pool may have.
const MOST: u32 = 256;

static POOL: RwLock<Option<Arc<ThreadPool>>> = RwLock::new(None);

/// Sets the number of threads that calls may use that build, read files or find rooms, and looks by viewers with
/// ENFILADE_VIEWER_FLAGS_USES_THREADS. The threads are shared by the whole process, and wait for work.
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

/// Makes the first calling thread the only one of rayon's global pool, which would otherwise start a thread for each core. The
/// core then runs its loops on whichever thread calls.
pub(crate) fn start_none() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Fails if the program uses rayon itself, and has started its threads.
        let _ = ThreadPoolBuilder::new()
            .num_threads(1)
            .use_current_thread()
            .build_global();
    });
}

/// Runs work on the threads that the caller allows: its own, unless it asked for others.
pub(crate) fn on_all<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let pool = POOL.read().unwrap_or_else(|poisoned| poisoned.into_inner());
    let pool_in_use = pool.clone();
    drop(pool);
    match pool_in_use {
        Some(pool) => pool.install(work),
        None => {
            // Readers and the renderer hand work to the pool of the thread that they run on, and would wait for another for ever.
            if rayon::current_thread_index().is_none() {
                // Stays for the life of the process: 7 kB for each thread that reads, builds or draws.
                let _ = ThreadPoolBuilder::new()
                    .num_threads(1)
                    .use_current_thread()
                    .build();
            }
            work()
        }
    }
}
