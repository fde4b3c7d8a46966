//! Rows of bits: one set of small numbers for each of as many things.

/// As many rows as columns or not, all empty at first; a row is whole words.
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

    /// As many rows as that from the beginning of `words`, and the words after them; `None` where there are too few, or
    /// bits beyond the columns.
    pub(crate) fn read(rows: usize, columns: usize, words: &[u64]) -> Option<(BitRows, &[u64])> {
        let words_in_row = columns.div_ceil(64);
        let (mine, rest) = words.split_at_checked(rows * words_in_row)?;
        let beyond = !0u64 << (columns % 64);
        let is_clean = columns.is_multiple_of(64)
            || mine
                .chunks(words_in_row)
                .all(|row| row[words_in_row - 1] & beyond == 0);
        let rows = BitRows {
            rows,
            words_in_row,
            words: mine.to_vec(),
        };
        is_clean.then_some((rows, rest))
    }

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

    /// All rows at once, to be filled side by side.
    pub(crate) fn rows_mut(&mut self) -> &mut [u64] {
        &mut self.words
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

/// The columns in a row, rising.
pub(crate) fn ones(row: &[u64]) -> impl Iterator<Item = usize> + '_ {
    row.iter().enumerate().flat_map(|(at, &word)| ones_of(at, word))
}

/// The columns in a row that are not in another, rising.
pub(crate) fn ones_besides<'a>(row: &'a [u64], other: &'a [u64]) -> impl Iterator<Item = usize> + 'a {
    let words = row.iter().zip(other).enumerate();
    words.flat_map(|(at, (&word, &not))| ones_of(at, word & !not))
}

fn ones_of(at: usize, word: u64) -> impl Iterator<Item = usize> {
    let mut rest = word;
    std::iter::from_fn(move || {
        (rest != 0).then(|| {
            let bit = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            at * 64 + bit
        })
    })
}
