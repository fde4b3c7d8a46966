//! A compact list of short strings: names of items.

/// A list of short names, stored in a single string.
#[derive(Clone, Debug, Default)]
pub(super) struct Names {
    text: String,
    /// Start and end of each name in `text`.
    runs: Vec<[u32; 2]>,
    /// Bytes in `text` of names that were replaced.
    waste: usize,
}

impl Names {
    pub(super) fn push(&mut self, name: &str) {
        let run = self.append(name);
        self.runs.push(run);
    }

    pub(super) fn get(&self, index: usize) -> &str {
        let [start, end] = self.runs[index];
        &self.text[start as usize..end as usize]
    }

    /// Replaces a name.
    pub(super) fn set(&mut self, index: usize, name: &str) {
        let [start, end] = std::mem::take(&mut self.runs[index]);
        self.waste += (end - start) as usize;
        if 2 * self.waste > self.text.len() {
            self.tidy();
        }
        self.runs[index] = self.append(name);
    }

    fn append(&mut self, name: &str) -> [u32; 2] {
        let start = self.text.len() as u32;
        self.text.push_str(name);
        [start, self.text.len() as u32]
    }

    fn tidy(&mut self) {
        let old = std::mem::take(&mut self.text);
        for run in &mut self.runs {
            let name = &old[run[0] as usize..run[1] as usize];
            let start = self.text.len() as u32;
            self.text.push_str(name);
            *run = [start, self.text.len() as u32];
        }
        self.waste = 0;
    }

    pub(super) fn bytes(&self) -> usize {
        self.text.len() + size_of_val(&*self.runs)
    }
}

#[cfg(test)]
mod tests {
    use super::Names;

    #[test]
    fn names_that_change_all_the_time_take_no_more_and_more_room() {
        let mut names = Names::default();
        for name in ["Anna", "Berta", "Clara"] {
            names.push(name);
        }
        for night in 0..1000 {
            names.set(1, &format!("guest {night}"));
        }
        assert_eq!(
            [0, 1, 2].map(|index| names.get(index)),
            ["Anna", "guest 999", "Clara"]
        );
        assert!(names.bytes() < 100, "{}", names.bytes());
    }
}
