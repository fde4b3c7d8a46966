//! Chooses what is read next, and what leaves memory for it.

use crate::loader::Request;
use crate::page::{Changed, Page, State};
use crate::{Pager, PagerStats};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// So many times more pages are asked for coarser meshes at once, which are as many times smaller.
const LEVELS_PER_PAGE: usize = 8;
/// Of so many pages that are asked for at once, one may be loaded ahead.
const PAGES_PER_AHEAD: usize = 4;
/// Steps that a page stays after it was visible, if memory is only needed for what is loaded ahead.
const STAY: u64 = 300;

impl Pager {
    /// Asks for the visible pages that are absent, and returns those that leave the scene for them.
    pub(crate) fn ask(&mut self, stats: &mut PagerStats) -> Vec<Changed> {
        let being_read = self.loader.being_read();
        for (number, page) in (0..).zip(&mut self.pages) {
            for (state, request) in [
                (&mut page.meshes, Request::Page(number)),
                (&mut page.levels, Request::Levels(number)),
            ] {
                if matches!(state, State::Asked) && !being_read.contains(&request) {
                    *state = State::Absent;
                }
            }
        }
        let step = self.step;
        let is_wanted = |page: &Page| matches!(page.meshes, State::Absent) && page.urgency(step).is_some();
        let mut wanted: Vec<u32> = (0..self.pages.len() as u32)
            .filter(|&page| is_wanted(&self.pages[page as usize]))
            .collect();
        wanted.sort_by_cached_key(|&page| (self.pages[page as usize].urgency(step), page));
        let mut room = Room::new(&self.pages, step, self.options.bytes);
        // Pages may take more than was estimated before they were read.
        room.shrink(&mut self.pages);
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
        let mut asked = Vec::new();
        for &number in &wanted {
            let page = &self.pages[number as usize];
            let is_needed = page.seen_at == step && matches!(page.levels, State::Absent);
            let bytes = page.level_bytes;
            if asked.len() >= levels_left {
                break;
            }
            if is_needed && room.make(&mut self.pages, bytes, true) {
                self.pages[number as usize].levels = State::Asked;
                asked.push(Request::Levels(number));
            }
        }
        let levels_asked = asked.len();
        for number in wanted {
            if asked.len() - levels_asked >= pages_left {
                break;
            }
            let page = &self.pages[number as usize];
            let (is_visible, bytes) = (page.seen_at == step, page.bytes);
            if !is_visible && PAGES_PER_AHEAD * (asked.len() - levels_asked + pages_read) >= at_once {
                break;
            }
            if !room.make(&mut self.pages, bytes, is_visible) {
                stats.over_budget += u32::from(is_visible);
                continue;
            }
            self.pages[number as usize].meshes = State::Asked;
            asked.push(Request::Page(number));
        }
        stats.loading = (asked.len() + being_read.len()) as u32;
        self.loader.ask(asked);
        room.dropped
    }
}

/// Memory within the budget, and the pages that may leave it.
struct Room {
    budget: u64,
    used: u64,
    /// Those that have not been seen for longest leave first. What is loaded ahead counts as seen not long ago.
    unseen: BinaryHeap<Reverse<(u64, u32)>>,
    /// Memory of all that may leave, and of those that even leave for what is loaded ahead.
    may_leave: u64,
    idle: u64,
    step: u64,
    dropped: Vec<Changed>,
}

impl Room {
    fn new(pages: &[Page], step: u64, budget: u64) -> Room {
        let mut room = Room {
            budget,
            used: pages.iter().map(Page::memory).sum(),
            unseen: BinaryHeap::new(),
            may_leave: 0,
            idle: 0,
            step,
            dropped: Vec::new(),
        };
        let unseen = (0..)
            .zip(pages)
            .filter(|(_, page)| page.seen_at < step && page.memory_there() > 0);
        room.unseen = unseen
            .inspect(|(_, page)| room.count(page, |sum, bytes| sum + bytes))
            .map(|(number, page)| {
                let ahead = if page.is_ahead(step) {
                    step.saturating_sub(STAY)
                } else {
                    0
                };
                Reverse((page.seen_at.max(ahead), number))
            })
            .collect();
        room
    }

    fn count(&mut self, page: &Page, count: impl Fn(u64, u64) -> u64) {
        let bytes = page.memory_there();
        self.may_leave = count(self.may_leave, bytes);
        if !page.is_ahead(self.step) && page.seen_at + STAY < self.step {
            self.idle = count(self.idle, bytes);
        }
    }

    /// Takes so many bytes of the budget, after others have left. Returns `false`, and changes nothing, if that is not enough.
    /// For what is visible anything leaves, else what is neither loaded ahead nor was visible lately.
    fn make(&mut self, pages: &mut [Page], needs: u64, for_visible: bool) -> bool {
        let may_leave = if for_visible { self.may_leave } else { self.idle };
        if self.used + needs > self.budget + may_leave {
            return false;
        }
        self.used += needs;
        self.shrink(pages);
        true
    }

    /// Lets pages leave until the rest is within the budget, or all that is left is visible.
    fn shrink(&mut self, pages: &mut [Page]) {
        while self.used > self.budget
            && let Some(Reverse((_, number))) = self.unseen.pop()
        {
            let page = &mut pages[number as usize];
            self.used -= page.memory_there();
            self.count(page, |sum, bytes| sum - bytes);
            page.levels.take();
            if let Some(before) = page.meshes.take() {
                self.dropped.push(Changed { number, before });
            }
        }
    }
}
