//! Rows of bits: one set of small numbers for each of as many things.

use std::ops::Range;

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

    /// Returns the rows that [`pack`] wrote at the beginning of `words`, and the words after them; `None` where words are
    /// missing, or bits are beyond the columns.
    pub(crate) fn unpack(rows: usize, columns: usize, words: &[u64]) -> Option<(BitRows, &[u64])> {
        let mut unpacked = BitRows::new(rows, columns);
        let rest = unpacked.unpack_rows(0..rows, columns, words)?;
        Some((unpacked, rest))
    }

    /// As [`BitRows::unpack`], into some of the rows.
    pub(crate) fn unpack_rows<'a>(
        &mut self,
        rows: Range<usize>,
        columns: usize,
        words: &'a [u64],
    ) -> Option<&'a [u64]> {
        let mine = &mut self.words[rows.start * self.words_in_row..rows.end * self.words_in_row];
        let mut rest = words;
        for group in mine.chunks_mut(64) {
            let (&present, words) = rest.split_first()?;
            let (words, after) = words.split_at_checked(present.count_ones() as usize)?;
            for (at, &word) in ones_of(0, present).zip(words) {
                *group.get_mut(at)? = word;
            }
            rest = after;
        }
        let beyond = !0u64 << (columns % 64);
        let is_clean = columns.is_multiple_of(64)
            || mine
                .chunks(self.words_in_row)
                .all(|row| row[self.words_in_row - 1] & beyond == 0);
        is_clean.then_some(rest)
    }

    /// Returns the words of some rows.
    pub(crate) fn words(&self, rows: Range<usize>) -> &[u64] {
        &self.words[rows.start * self.words_in_row..rows.end * self.words_in_row]
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

/// Appends words without those that are zero: before each 64 one whose bits say which of them follow.
pub(crate) fn pack(words: &[u64], packed: &mut Vec<u64>) {
    for group in words.chunks(64) {
        let at = packed.len();
        packed.push(0);
        let mut present = 0;
        for (bit, &word) in group.iter().enumerate().filter(|&(_, &word)| word != 0) {
            present |= 1 << bit;
            packed.push(word);
        }
        packed[at] = present;
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
