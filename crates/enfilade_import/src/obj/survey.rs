//! The first pass: counts elements, so that memory is reserved once and the number of elements before every chunk is
//! known.

use super::ObjError;
use super::text::{Lines, pieces};
use rayon::prelude::*;
use std::ops::AddAssign;

/// Numbers of elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) lines: usize,
    pub(super) positions: usize,
    pub(super) texture: usize,
    pub(super) normals: usize,
    pub(super) faces: usize,
    pub(super) corners: usize,
    /// Lines with a state statement, point or line element.
    pub(super) marks: usize,
    /// Lines with an unknown keyword.
    pub(super) unknown: usize,
}

impl AddAssign for Counts {
    fn add_assign(&mut self, more: Counts) {
        self.lines += more.lines;
        self.positions += more.positions;
        self.texture += more.texture;
        self.normals += more.normals;
        self.faces += more.faces;
        self.corners += more.corners;
        self.marks += more.marks;
        self.unknown += more.unknown;
    }
}

impl Counts {
    /// Returns `true` if there is any known statement.
    pub(super) fn any_known(&self) -> bool {
        self.positions + self.texture + self.normals + self.faces + self.marks > 0
    }
}

/// A chunk of the text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece<'a> {
    pub(super) text: &'a [u8],
    /// Counts before the chunk.
    pub(super) before: Counts,
    /// Counts in the chunk.
    pub(super) within: Counts,
}

/// Chunk size, in bytes.
const PIECE: usize = 1 << 20;

/// Splits a text into chunks; counts the elements of each, and of all.
pub(super) fn survey(text: &[u8]) -> Result<(Vec<Piece<'_>>, Counts), ObjError> {
    let pieces = pieces(text, PIECE);
    let counted: Vec<(Counts, Option<usize>)> = pieces.par_iter().map(|piece| count(piece)).collect();
    let mut before = Counts::default();
    let mut surveyed = Vec::with_capacity(pieces.len());
    for (text, (within, zero)) in pieces.into_iter().zip(counted) {
        if let Some(line) = zero {
            return Err(ObjError::NotText {
                line: before.lines + line,
            });
        }
        surveyed.push(Piece { text, before, within });
        before += within;
    }
    Ok((surveyed, before))
}

/// Counts the elements of a chunk; also returns the line of the first NUL byte, if there is one.
fn count(piece: &[u8]) -> (Counts, Option<usize>) {
    if let Some(at) = piece.iter().position(|&byte| byte == 0) {
        let lines = piece[..at].iter().filter(|&&byte| byte == b'\n').count();
        return (Counts::default(), Some(lines + 1));
    }
    let mut counts = Counts::default();
    let mut lines = Lines::of(piece, 0);
    for line in &mut lines {
        match line.keyword() {
            b"v" => counts.positions += 1,
            b"vt" => counts.texture += 1,
            b"vn" => counts.normals += 1,
            b"f" | b"fo" => {
                counts.faces += 1;
                counts.corners += line.words().count();
            }
            b"o" | b"g" | b"usemtl" | b"mtllib" | b"s" | b"p" | b"l" => counts.marks += 1,
            _ => counts.unknown += 1,
        }
    }
    counts.lines = lines.passed();
    (counts, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_knows_what_stands_before_it() {
        let text = "v 1 2 3\nvt 0 0\n# f\nf 1 2 3 # 4\no hall\nvn 0 0 1\nodd\n".repeat(60_000);
        let (pieces, all) = survey(text.as_bytes()).expect("it is text");
        assert!(pieces.len() > 2);
        let mut sum = Counts::default();
        for piece in &pieces {
            assert_eq!(piece.before, sum);
            sum += piece.within;
        }
        assert_eq!(sum, all);
        let times = |n: usize| 60_000 * n;
        assert_eq!(
            [all.lines, all.positions, all.corners],
            [times(7), times(1), times(3)]
        );
        assert_eq!([all.texture, all.normals, all.marks], [times(1); 3]);
        assert_eq!([all.faces, all.unknown], [times(1); 2]);
    }

    #[test]
    fn the_line_of_a_byte_zero_is_found_in_any_piece() {
        let mut text = "v 1 2 3\n".repeat(400_000).into_bytes();
        text.extend(b"\0");
        let found = survey(&text).expect_err("it is no text");
        assert_eq!(found, ObjError::NotText { line: 400_001 });
    }
}
