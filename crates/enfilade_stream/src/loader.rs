//! Reads pages on threads of its own, in the order in which they are asked for.

use enfilade::Mesh;
use enfilade_import::{ImportError, Pages};
use std::collections::{BTreeSet, VecDeque};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// The meshes of a page, by their index in the file; or why it cannot be read.
type Read = Result<Vec<(u32, Arc<Mesh>)>, ImportError>;

/// Threads that read pages. Dropping it ends them.
pub(crate) struct Loader {
    queue: Arc<Queue>,
    results: Receiver<(u32, Read)>,
    /// A result that [`Loader::wait`] has taken off already.
    first: Option<(u32, Read)>,
    threads: Vec<JoinHandle<()>>,
}

#[derive(Default)]
struct Queue {
    state: Mutex<QueueState>,
    has_changed: Condvar,
}

#[derive(Default)]
struct QueueState {
    waiting: VecDeque<u32>,
    /// Pages that a thread has taken, until [`Loader::arrived`] returns them.
    being_read: BTreeSet<u32>,
    has_ended: bool,
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, QueueState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a page to read; `None` at the end.
    fn take(&self) -> Option<u32> {
        let mut state = self.lock();
        loop {
            if state.has_ended {
                return None;
            }
            if let Some(page) = state.waiting.pop_front() {
                state.being_read.insert(page);
                return Some(page);
            }
            state = self
                .has_changed
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Loader {
    pub(crate) fn new(pages: Arc<Pages>, threads: usize) -> Loader {
        let queue = Arc::new(Queue::default());
        let (sender, results) = channel();
        let thread = |_| {
            let (pages, queue, sender) = (Arc::clone(&pages), Arc::clone(&queue), sender.clone());
            std::thread::spawn(move || read_pages(&pages, &queue, &sender))
        };
        Loader {
            threads: (0..threads).map(thread).collect(),
            queue,
            results,
            first: None,
        }
    }

    /// Replaces the pages that wait to be read.
    pub(crate) fn ask(&self, pages: Vec<u32>) {
        let mut state = self.queue.lock();
        state.waiting = pages.into();
        self.queue.has_changed.notify_all();
    }

    /// Returns the pages that a thread has taken and that have not arrived, and forgets those that wait.
    pub(crate) fn being_read(&self) -> BTreeSet<u32> {
        let mut state = self.queue.lock();
        state.waiting.clear();
        state.being_read.clone()
    }

    /// Returns a page that has been read.
    pub(crate) fn arrived(&mut self) -> Option<(u32, Read)> {
        let (page, read) = self.first.take().or_else(|| self.results.try_recv().ok())?;
        self.queue.lock().being_read.remove(&page);
        Some((page, read))
    }

    /// Waits until a page has been read; returns `false` if none was before the timeout, or none is being read.
    pub(crate) fn wait(&mut self, timeout: Duration) -> bool {
        let is_idle = {
            let state = self.queue.lock();
            state.waiting.is_empty() && state.being_read.is_empty()
        };
        if self.first.is_none() && !is_idle {
            self.first = self.results.recv_timeout(timeout).ok();
        }
        self.first.is_some()
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        self.queue.lock().has_ended = true;
        self.queue.has_changed.notify_all();
        for thread in self.threads.drain(..) {
            // A thread that panicked has nothing left to do.
            let _ = thread.join();
        }
    }
}

fn read_pages(pages: &Pages, queue: &Queue, sender: &Sender<(u32, Read)>) {
    while let Some(page) = queue.take() {
        if sender.send((page, pages.load(page))).is_err() {
            return;
        }
    }
}
