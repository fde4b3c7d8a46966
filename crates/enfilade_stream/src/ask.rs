//! Chooses what is read next, and what leaves memory for it.

use crate::loader::Request;
use crate::page::{Changed, Page, State};
use crate::{Pager, PagerStats};

/// So many times more pages are asked for coarser meshes at once, which are as many times smaller.
const LEVELS_PER_PAGE: usize = 8;

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
        let pages_read = being_read
            .iter()
            .filter(|request| matches!(request, Request::Page(_)));
        let pages_left = at_once.saturating_sub(pages_read.count());
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
    /// The last leave first: those that hints do not name, and have not been seen for longest.
    unseen: Vec<u32>,
    step: u64,
    dropped: Vec<Changed>,
}

impl Room {
    fn new(pages: &[Page], step: u64, budget: u64) -> Room {
        let may_leave = |page: &Page| page.seen_at < step && page.memory_there() > 0;
        let mut unseen: Vec<u32> = (0..pages.len() as u32)
            .filter(|&page| may_leave(&pages[page as usize]))
            .collect();
        unseen.sort_by_cached_key(|&number| {
            let page = &pages[number as usize];
            (page.rank(step) == u32::MAX, u64::MAX - page.seen_at, number)
        });
        Room {
            budget,
            used: pages.iter().map(Page::memory).sum(),
            unseen,
            step,
            dropped: Vec::new(),
        }
    }

    /// Lets pages leave until the rest is within the budget, or all that is left is visible.
    fn shrink(&mut self, pages: &mut [Page]) {
        let (count, used) = self.plan(pages, 0, true);
        self.leave(pages, count, used);
    }

    /// Takes so many bytes of the budget, after others have left. Returns `false`, and changes nothing, if that is not enough.
    /// What hints name leaves for what is visible only.
    fn make(&mut self, pages: &mut [Page], needs: u64, for_visible: bool) -> bool {
        let (count, used) = self.plan(pages, needs, for_visible);
        let is_enough = used <= self.budget;
        if is_enough {
            self.leave(pages, count, used);
        }
        is_enough
    }

    /// Returns how many pages have to leave for so many bytes, and what is used then; more than the budget if all that may leave
    /// are not enough.
    fn plan(&self, pages: &[Page], needs: u64, for_visible: bool) -> (usize, u64) {
        let (mut count, mut used) = (0, self.used + needs);
        for &number in self.unseen.iter().rev() {
            let page = &pages[number as usize];
            if used <= self.budget || !(for_visible || page.rank(self.step) == u32::MAX) {
                break;
            }
            used -= page.memory_there();
            count += 1;
        }
        (count, used)
    }

    fn leave(&mut self, pages: &mut [Page], count: usize, used: u64) {
        self.used = used;
        for number in self.unseen.drain(self.unseen.len() - count..).rev() {
            let page = &mut pages[number as usize];
            page.levels.take();
            if let Some(before) = page.meshes.take() {
                self.dropped.push(Changed { number, before });
            }
        }
    }
}
