//! Reads pages on threads of its own, in the order in which they are asked for.

use enfilade::Mesh;
use enfilade_import::{ImportError, Pages};
use std::collections::{BTreeSet, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// What is read: the coarser meshes of a page, or its meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Request {
    Levels(u32),
    Page(u32),
}

/// The meshes, by their index in the file; or why they cannot be read.
type Read = Result<Vec<(u32, Arc<Mesh>)>, ImportError>;

/// Threads that read pages. Dropping it ends them.
pub(crate) struct Loader {
    queue: Arc<Queue>,
    threads: Vec<JoinHandle<()>>,
}

#[derive(Default)]
struct Queue {
    state: Mutex<QueueState>,
    has_work: Condvar,
    has_read: Condvar,
}

#[derive(Default)]
struct QueueState {
    waiting: VecDeque<Request>,
    /// What a thread has taken, until [`Loader::arrived`] returns it.
    being_read: BTreeSet<Request>,
    read: VecDeque<(Request, Read)>,
    has_ended: bool,
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, QueueState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for something to read; `None` at the end.
    fn take(&self) -> Option<Request> {
        let is_idle = |state: &mut QueueState| state.waiting.is_empty() && !state.has_ended;
        let state = self.has_work.wait_while(self.lock(), is_idle);
        let mut state = state.unwrap_or_else(PoisonError::into_inner);
        if state.has_ended {
            return None;
        }
        let request = state.waiting.pop_front()?;
        state.being_read.insert(request);
        Some(request)
    }
}

impl Loader {
    pub(crate) fn new(pages: Arc<Pages>, threads: usize) -> Loader {
        let queue = Arc::new(Queue::default());
        let thread = |_| {
            let (pages, queue) = (Arc::clone(&pages), Arc::clone(&queue));
            std::thread::spawn(move || {
                while let Some(request) = queue.take() {
                    let read = match request {
                        Request::Levels(page) => pages.load_levels(page),
                        Request::Page(page) => pages.load(page),
                    };
                    queue.lock().read.push_back((request, read));
                    queue.has_read.notify_all();
                }
            })
        };
        Loader {
            threads: (0..threads).map(thread).collect(),
            queue,
        }
    }

    /// Replaces what waits to be read.
    pub(crate) fn ask(&self, requests: Vec<Request>) {
        self.queue.lock().waiting = requests.into();
        self.queue.has_work.notify_all();
    }

    /// Returns what a thread has taken and has not arrived, and forgets what waits.
    pub(crate) fn being_read(&self) -> BTreeSet<Request> {
        let mut state = self.queue.lock();
        state.waiting.clear();
        state.being_read.clone()
    }

    /// Returns something that has been read.
    pub(crate) fn arrived(&self) -> Option<(Request, Read)> {
        let mut state = self.queue.lock();
        let (request, read) = state.read.pop_front()?;
        state.being_read.remove(&request);
        Some((request, read))
    }

    /// Waits until something has been read; returns `false` if none was before the timeout, or none is being read.
    pub(crate) fn wait(&self, timeout: Duration) -> bool {
        let is_busy = |state: &mut QueueState| {
            state.read.is_empty() && !(state.waiting.is_empty() && state.being_read.is_empty())
        };
        let waited = self
            .queue
            .has_read
            .wait_timeout_while(self.queue.lock(), timeout, is_busy);
        let (state, _) = waited.unwrap_or_else(PoisonError::into_inner);
        !state.read.is_empty()
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        self.queue.lock().has_ended = true;
        self.queue.has_work.notify_all();
        for thread in self.threads.drain(..) {
            // A thread that panicked has nothing left to do.
            let _ = thread.join();
        }
    }
}
