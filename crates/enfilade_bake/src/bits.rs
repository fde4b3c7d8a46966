//! Bit matrices: one row of bits per way or cell, dense or packed.

/// A dense bit matrix, all zero at first. Each row starts at a word boundary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct BitRows {
    rows: usize,
    words_in_row: usize,
    words: Vec<u64>,
}

impl BitRows {
    pub(crate) fn new(rows: usize, columns: usize) -> BitRows {
        let words_in_row = columns.div_ceil(64);
        BitRows {
            rows,
            words_in_row,
            words: vec![0; rows * words_in_row],
        }
    }

    /// Reads rows that [`pack`] wrote at the beginning of `words`; returns them and the remaining words. Returns `None`
    /// if words are missing or a bit beyond the columns is set.
    pub(crate) fn unpack(rows: usize, columns: usize, words: &[u64]) -> Option<(BitRows, &[u64])> {
        let mut unpacked = BitRows::new(rows, columns);
        let mut rest = words;
        for group in unpacked.words.chunks_mut(64) {
            let (&present, words) = rest.split_first()?;
            let (words, after) = words.split_at_checked(present.count_ones() as usize)?;
            for (at, &word) in ones_of(0, present).zip(words) {
                *group.get_mut(at)? = word;
            }
            rest = after;
        }
        let beyond = !0u64 << (columns % 64);
        let is_within = columns.is_multiple_of(64)
            || unpacked
                .words
                .chunks(unpacked.words_in_row)
                .all(|row| row[unpacked.words_in_row - 1] & beyond == 0);
        is_within.then_some((unpacked, rest))
    }

    /// Returns the words of all rows.
    pub(crate) fn words(&self) -> &[u64] {
        &self.words
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn words_in_row(&self) -> usize {
        self.words_in_row
    }

    pub(crate) fn row(&self, row: usize) -> &[u64] {
        &self.words[row * self.words_in_row..][..self.words_in_row]
    }

    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [u64] {
        &mut self.words[row * self.words_in_row..][..self.words_in_row]
    }

    pub(crate) fn has(&self, row: usize, column: usize) -> bool {
        has(self.row(row), column)
    }

    pub(crate) fn put(&mut self, row: usize, column: usize) {
        put(self.row_mut(row), column);
    }

    pub(crate) fn take(&mut self, row: usize, column: usize) {
        take(self.row_mut(row), column);
    }

    pub(crate) fn count(&self) -> usize {
        count(&self.words)
    }

    /// Returns the words of all rows, to be filled in parallel.
    pub(crate) fn rows_mut(&mut self) -> &mut [u64] {
        &mut self.words
    }
}

/// An append-only bit matrix that stores only the nonzero words of each row, in the format of [`pack`].
#[derive(Clone, Debug)]
pub(crate) struct PackedRows {
    words_in_row: usize,
    /// For each row, the index in `words` after its last word.
    ends: Vec<usize>,
    words: Vec<u64>,
}

impl PackedRows {
    /// Creates a matrix without rows.
    pub(crate) fn new(columns: usize) -> PackedRows {
        PackedRows {
            words_in_row: columns.div_ceil(64),
            ends: Vec::new(),
            words: Vec::new(),
        }
    }

    /// Reads `rows` rows; returns `None` if there are too few or too many words or a bit beyond the columns is set.
    pub(crate) fn from_words(rows: usize, columns: usize, words: &[u64]) -> Option<PackedRows> {
        let mut packed = PackedRows::new(columns);
        let mut rest = words;
        for _ in 0..rows {
            for group in 0..packed.words_in_row.div_ceil(64) {
                let (&present, after) = rest.split_first()?;
                let (group_words, after) = after.split_at_checked(present.count_ones() as usize)?;
                let is_beyond =
                    |(at, &word): (usize, &u64)| ones_of(at, word).last().is_some_and(|bit| bit >= columns);
                if ones_of(group, present)
                    .zip(group_words)
                    .last()
                    .is_some_and(is_beyond)
                {
                    return None;
                }
                rest = after;
            }
            packed.ends.push(words.len() - rest.len());
        }
        packed.words.extend_from_slice(words);
        rest.is_empty().then_some(packed)
    }

    /// Appends a row, given its nonzero words with their indices in ascending order.
    pub(crate) fn push(&mut self, row: &[(u32, u64)]) {
        let mut rest = row.iter().peekable();
        for group in 0..self.words_in_row.div_ceil(64) {
            let at = self.words.len();
            self.words.push(0);
            while let Some((number, word)) = rest.next_if(|(number, _)| *number as usize / 64 == group) {
                self.words[at] |= 1 << (number % 64);
                self.words.push(*word);
            }
        }
        self.ends.push(self.words.len());
    }

    /// Appends all rows of `others`, which has the same number of columns.
    pub(crate) fn append(&mut self, others: &PackedRows) {
        let before = self.words.len();
        self.ends.extend(others.ends.iter().map(|end| before + end));
        self.words.extend_from_slice(&others.words);
    }

    /// Returns the words of all rows, packed.
    pub(crate) fn words(&self) -> &[u64] {
        &self.words
    }

    /// Returns the nonzero words of a row, each with its index.
    pub(crate) fn row(&self, row: usize) -> impl Iterator<Item = (usize, u64)> + '_ {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        let mut rest = &self.words[start..self.ends[row]];
        (0..self.words_in_row.div_ceil(64)).flat_map(move |group| {
            let (words, after) = rest[1..].split_at(rest[0].count_ones() as usize);
            let present = std::mem::replace(&mut rest, after)[0];
            ones_of(group, present).zip(words.iter().copied())
        })
    }
}

/// Appends the nonzero words of `words`, with a word before each group of 64 whose bits mark the words that follow.
pub(crate) fn pack(words: &[u64], packed: &mut Vec<u64>) {
    for group in words.chunks(64) {
        let mut present = 0;
        for (bit, &word) in group.iter().enumerate() {
            present |= u64::from(word != 0) << bit;
        }
        packed.push(present);
        packed.extend(ones_of(0, present).map(|at| group[at]));
    }
}

pub(crate) fn has(row: &[u64], column: usize) -> bool {
    row[column / 64] >> (column % 64) & 1 != 0
}

pub(crate) fn put(row: &mut [u64], column: usize) {
    row[column / 64] |= 1 << (column % 64);
}

pub(crate) fn take(row: &mut [u64], column: usize) {
    row[column / 64] &= !(1 << (column % 64));
}

pub(crate) fn count(row: &[u64]) -> usize {
    row.iter().map(|word| word.count_ones() as usize).sum()
}

/// Returns the columns set in a row, in ascending order.
pub(crate) fn ones(row: &[u64]) -> impl Iterator<Item = usize> + '_ {
    row.iter().enumerate().flat_map(|(at, &word)| ones_of(at, word))
}

/// Returns the columns set in `row` but not in `other`, in ascending order.
pub(crate) fn ones_besides<'a>(row: &'a [u64], other: &'a [u64]) -> impl Iterator<Item = usize> + 'a {
    let words = row.iter().zip(other).enumerate();
    words.flat_map(|(at, (&word, &not))| ones_of(at, word & !not))
}

/// Returns the columns set in the word with index `at`, in ascending order.
pub(crate) fn ones_of(at: usize, word: u64) -> impl Iterator<Item = usize> {
    let mut rest = word;
    std::iter::from_fn(move || {
        (rest != 0).then(|| {
            let bit = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            at * 64 + bit
        })
    })
}
