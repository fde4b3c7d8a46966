//! Chooses which pages to load next, and which to evict for them: least recently seen first.

use crate::loader::Request;
use crate::page::{Page, PageChange, State};
use crate::{Pager, PagerStats};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Number of coarser pages that are requested at once, per page: they are about thirty times smaller.
const LEVELS_PER_PAGE: usize = 8;
/// One in this many pages that are requested at once may be a prefetch.
const PAGES_PER_PREFETCH: usize = 4;
/// Steps after it was visible during which a page is not evicted for a prefetch.
const RECENT: u64 = 300;

impl Pager {
    /// Requests pages that are absent and visible, or to be prefetched, and returns those that are evicted for them.
    pub(crate) fn request(&mut self, stats: &mut PagerStats) -> Vec<PageChange> {
        let being_read = self.loader.being_read();
        for (number, page) in (0..).zip(&mut self.pages) {
            for (state, request) in [
                (&mut page.meshes, Request::Page(number)),
                (&mut page.levels, Request::Levels(number)),
            ] {
                if matches!(state, State::Requested) && !being_read.contains(&request) {
                    *state = State::Absent;
                }
            }
        }
        let step = self.step;
        let is_wanted = |page: &Page| matches!(page.meshes, State::Absent) && page.priority(step).is_some();
        let mut wanted: Vec<u32> = (0..self.pages.len() as u32)
            .filter(|&page| is_wanted(&self.pages[page as usize]))
            .collect();
        wanted.sort_by_cached_key(|&page| (self.pages[page as usize].priority(step), page));
        let mut budget = Budget::new(&self.pages, step, self.options.bytes);
        // Pages may take more than was estimated before they were read.
        budget.evict(&mut self.pages);
        // The largest hide others, which then need not be read.
        let at_once = self.options.pages_per_step.max(1) as usize;
        let is_page = |request: &&Request| matches!(request, Request::Page(_));
        let pages_read = being_read.iter().filter(is_page).count();
        let pages_left = at_once.saturating_sub(pages_read);
        let levels_left = if self.options.levels {
            LEVELS_PER_PAGE * at_once
        } else {
            0
        };
        let mut requests = Vec::new();
        for &number in &wanted {
            let page = &self.pages[number as usize];
            let is_needed = page.seen_at == step && matches!(page.levels, State::Absent);
            let bytes = page.level_bytes;
            if requests.len() >= levels_left {
                break;
            }
            if is_needed && budget.reserve(&mut self.pages, bytes, true) {
                self.pages[number as usize].levels = State::Requested;
                requests.push(Request::Levels(number));
            }
        }
        let levels_requested = requests.len();
        for number in wanted {
            if requests.len() - levels_requested >= pages_left {
                break;
            }
            let page = &self.pages[number as usize];
            let (is_visible, bytes) = (page.seen_at == step, page.bytes);
            if !is_visible && PAGES_PER_PREFETCH * (requests.len() - levels_requested + pages_read) >= at_once
            {
                break;
            }
            if !budget.reserve(&mut self.pages, bytes, is_visible) {
                stats.over_budget += u32::from(is_visible);
                continue;
            }
            self.pages[number as usize].meshes = State::Requested;
            requests.push(Request::Page(number));
        }
        stats.loading = (requests.len() + being_read.len()) as u32;
        self.loader.ask(requests);
        budget.evicted
    }
}

/// The memory budget, and the pages that may be evicted.
struct Budget {
    limit: u64,
    used: u64,
    /// Pages that are not visible, the least recently seen first. Those to be prefetched count as seen [`RECENT`] steps ago.
    unseen: BinaryHeap<Reverse<(u64, u32)>>,
    /// Memory of all of them, and of those that may be evicted for a prefetch.
    evictable: u64,
    idle: u64,
    step: u64,
    evicted: Vec<PageChange>,
}

impl Budget {
    fn new(pages: &[Page], step: u64, limit: u64) -> Budget {
        let mut budget = Budget {
            limit,
            used: pages.iter().map(Page::memory).sum(),
            unseen: BinaryHeap::new(),
            evictable: 0,
            idle: 0,
            step,
            evicted: Vec::new(),
        };
        let unseen = (0..)
            .zip(pages)
            .filter(|(_, page)| page.seen_at < step && page.evictable_bytes() > 0);
        budget.unseen = unseen
            .inspect(|(_, page)| budget.count(page, |sum, bytes| sum + bytes))
            .map(|(number, page)| {
                let prefetched = if page.is_prefetch(step) {
                    step.saturating_sub(RECENT)
                } else {
                    0
                };
                Reverse((page.seen_at.max(prefetched), number))
            })
            .collect();
        budget
    }

    fn count(&mut self, page: &Page, count: impl Fn(u64, u64) -> u64) {
        let bytes = page.evictable_bytes();
        self.evictable = count(self.evictable, bytes);
        if !page.is_prefetch(self.step) && page.seen_at + RECENT < self.step {
            self.idle = count(self.idle, bytes);
        }
    }

    /// Reserves memory, and evicts pages for it. Returns `false`, and changes nothing, if that is not enough. A prefetch evicts only
    /// pages that are neither to be prefetched nor recently seen.
    fn reserve(&mut self, pages: &mut [Page], needs: u64, for_visible: bool) -> bool {
        let evictable = if for_visible { self.evictable } else { self.idle };
        if self.used + needs > self.limit + evictable {
            return false;
        }
        self.used += needs;
        self.evict(pages);
        true
    }

    /// Evicts pages until the rest is within the budget, or all that is left is visible.
    fn evict(&mut self, pages: &mut [Page]) {
        while self.used > self.limit
            && let Some(Reverse((_, number))) = self.unseen.pop()
        {
            let page = &mut pages[number as usize];
            self.used -= page.evictable_bytes();
            self.count(page, |sum, bytes| sum - bytes);
            page.levels.take();
            if let Some(before) = page.meshes.take() {
                self.evicted.push(PageChange { number, before });
            }
        }
    }
}
