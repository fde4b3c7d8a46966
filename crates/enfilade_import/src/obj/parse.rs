//! The second pass: parses positions, attributes and face corners; names stay in the text.
//!
//! Chunks of the text are parsed in parallel. The first pass counted the elements before each chunk, so relative
//! indices are resolved immediately, and each chunk writes directly into its part of the tables.
//! Cost: O(bytes).

use super::ObjError;
use super::corner::{Corner, ElementCounts};
use super::survey::{Counts, Piece};
use super::text::{Line, Lines, number, quoted};
use crate::warning::{WarningKind, Warnings};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::num::NonZeroU32;

/// The elements that face corners reference, in file order.
#[derive(Debug, Default)]
pub(super) struct Tables {
    /// May contain values that are not finite; an error only if a face uses them.
    pub(super) positions: Vec<[f32; 3]>,
    /// sRGB colors, one per position; empty if no position has one.
    pub(super) colors: Vec<[f32; 3]>,
    /// As in the file, v up; finite.
    pub(super) texture: Vec<[f32; 2]>,
    /// As in the file; finite.
    pub(super) normals: Vec<[f32; 3]>,
}

/// The faces of a chunk, and the state statements between them.
#[derive(Debug)]
pub(super) struct Faces<'a> {
    pub(super) corners: Vec<Corner>,
    /// End of each face in `corners`.
    pub(super) ends: Vec<u32>,
    pub(super) marks: Vec<Mark<'a>>,
    warnings: Warnings,
    unread: BTreeSet<String>,
}

/// A statement that applies to all faces after it.
#[derive(Debug)]
pub(super) struct Mark<'a> {
    /// Number of faces of the chunk before it.
    pub(super) face: usize,
    pub(super) what: Statement<'a>,
}

#[derive(Debug)]
pub(super) enum Statement<'a> {
    /// `o` or `g`: begins an object or a group.
    Group(Cow<'a, str>),
    /// `usemtl`: the material of the faces.
    Material(Cow<'a, str>),
    /// `s`: the smoothing group of the faces; `None` for flat shading.
    Smooth(Option<NonZeroU32>),
    /// `mtllib`: material files.
    Libraries(Cow<'a, str>),
}

impl Statement<'_> {
    /// Returns the argument of the statement, or an empty string.
    pub(super) fn name(&self) -> &str {
        match self {
            Statement::Group(name) | Statement::Material(name) | Statement::Libraries(name) => name,
            Statement::Smooth(_) => "",
        }
    }
}

impl Faces<'_> {
    /// Returns the corners of a face.
    pub(super) fn face(&self, face: usize) -> &[Corner] {
        let start = face.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.corners[start as usize..self.ends[face] as usize]
    }
}

/// Parses all chunks.
pub(super) fn parse<'a>(
    pieces: &[Piece<'a>],
    all: &Counts,
    warnings: &mut Warnings,
) -> Result<(Tables, Vec<Faces<'a>>), ObjError> {
    let mut tables = Tables {
        positions: vec![[0.0; 3]; all.positions],
        colors: Vec::new(),
        texture: vec![[0.0; 2]; all.texture],
        normals: vec![[0.0; 3]; all.normals],
    };
    let mut readers: Vec<Reader> = Vec::with_capacity(pieces.len());
    let (mut positions, mut texture, mut normals) =
        (&mut *tables.positions, &mut *tables.texture, &mut *tables.normals);
    for piece in pieces {
        readers.push(Reader {
            positions: take(&mut positions, piece.within.positions),
            texture: take(&mut texture, piece.within.texture),
            normals: take(&mut normals, piece.within.normals),
            ..Reader::new(piece, all)
        });
    }
    let read: Vec<Result<(), ObjError>> = readers.par_iter_mut().map(Reader::read).collect();
    // In order, so that of several invalid lines the first is named, whichever thread finishes first.
    read.into_iter().collect::<Result<(), _>>()?;

    let mut colors = Vec::new();
    let mut unread = BTreeSet::new();
    let mut faces = Vec::with_capacity(pieces.len());
    for reader in readers {
        if !reader.colors.is_empty() {
            colors.resize(all.positions, [1.0; 3]);
            let start = reader.before.positions;
            colors[start..start + reader.colors.len()].copy_from_slice(&reader.colors);
        }
        let mut read = reader.faces;
        warnings.absorb(std::mem::take(&mut read.warnings));
        unread.append(&mut read.unread);
        faces.push(read);
    }
    tables.colors = colors;
    for keyword in unread {
        warnings.name(WarningKind::UnreadStatements, || keyword);
    }
    Ok((tables, faces))
}

/// Splits the first `count` elements off a slice.
fn take<'t, T>(list: &mut &'t mut [T], count: usize) -> &'t mut [T] {
    let (first, rest) = std::mem::take(list).split_at_mut(count);
    *list = rest;
    first
}

/// Parses one chunk.
struct Reader<'a, 't> {
    lines: Lines<'a>,
    before: Counts,
    all: &'t Counts,
    /// Number of positions parsed in this chunk, and likewise for the others.
    positions_read: usize,
    texture_read: usize,
    normals_read: usize,
    positions: &'t mut [[f32; 3]],
    texture: &'t mut [[f32; 2]],
    normals: &'t mut [[f32; 3]],
    /// Colors up to the last position that has one.
    colors: Vec<[f32; 3]>,
    faces: Faces<'a>,
}

impl<'a, 't> Reader<'a, 't> {
    fn new(piece: &Piece<'a>, all: &'t Counts) -> Reader<'a, 't> {
        Reader {
            lines: Lines::of(piece.text, piece.before.lines),
            before: piece.before,
            all,
            positions_read: 0,
            texture_read: 0,
            normals_read: 0,
            positions: &mut [],
            texture: &mut [],
            normals: &mut [],
            colors: Vec::new(),
            faces: Faces {
                corners: Vec::with_capacity(piece.within.corners),
                ends: Vec::with_capacity(piece.within.faces),
                marks: Vec::new(),
                warnings: Warnings::default(),
                unread: BTreeSet::new(),
            },
        }
    }

    fn read(&mut self) -> Result<(), ObjError> {
        while let Some(line) = self.lines.next() {
            match line.keyword() {
                b"v" => self.position(&line)?,
                b"vt" => {
                    let ([u, v, _], _) = numbers::<3>(&line, "vt", 1)?;
                    self.texture[self.texture_read] = self.finite([u, v]);
                    self.texture_read += 1;
                }
                b"vn" => {
                    let (normal, _) = numbers::<3>(&line, "vn", 3)?;
                    self.normals[self.normals_read] = self.finite(normal);
                    self.normals_read += 1;
                }
                b"f" | b"fo" => self.face(&line)?,
                b"p" => self.warn(WarningKind::Points, line.number),
                b"l" => self.warn(WarningKind::Lines, line.number),
                b"o" | b"g" => self.mark(line, Statement::Group),
                b"usemtl" => self.mark(line, Statement::Material),
                b"mtllib" => self.mark(line, Statement::Libraries),
                b"s" => {
                    // `off` and 0 are equivalent.
                    let number = line.rest().parse().unwrap_or(0);
                    let smooth = Statement::Smooth(NonZeroU32::new(number));
                    self.mark(line, |_| smooth);
                }
                unread => self.unread(unread),
            }
        }
        Ok(())
    }

    fn warn(&mut self, kind: WarningKind, line: usize) {
        self.faces.warnings.name(kind, || format!("line {line}"));
    }

    /// Records an unsupported keyword, up to a limit.
    fn unread(&mut self, keyword: &[u8]) {
        const FEW: usize = 64;
        if self.faces.unread.len() < FEW {
            self.faces.unread.insert(quoted(keyword));
        }
    }

    fn mark(&mut self, line: Line<'a>, what: impl FnOnce(Cow<'a, str>) -> Statement<'a>) {
        let keyword = line.keyword().len();
        let name = match line.text {
            Cow::Borrowed(text) => String::from_utf8_lossy(text[keyword..].trim_ascii()),
            Cow::Owned(text) => {
                Cow::Owned(String::from_utf8_lossy(text[keyword..].trim_ascii()).into_owned())
            }
        };
        self.faces.marks.push(Mark {
            face: self.faces.ends.len(),
            what: what(name),
        });
    }

    /// Parses `x y z`, `x y z w` or `x y z r g b`. The weight w applies only to curves, which are not supported.
    fn position(&mut self, line: &Line) -> Result<(), ObjError> {
        let ([x, y, z, colors @ ..], count) = numbers::<6>(line, "v", 3)?;
        self.positions[self.positions_read] = [x, y, z];
        if count == 6 {
            const WHITE: [f32; 3] = [1.0; 3];
            self.colors.resize(self.positions_read, WHITE);
            let finite = colors.iter().all(|value| value.is_finite());
            self.faces
                .warnings
                .count(WarningKind::NotFinite, usize::from(!finite));
            self.colors.push(if finite { colors } else { WHITE });
        }
        self.positions_read += 1;
        Ok(())
    }

    /// Replaces attributes that are not finite by 0; they do not affect visibility.
    fn finite<const N: usize>(&mut self, values: [f32; N]) -> [f32; N] {
        if values.iter().all(|value| value.is_finite()) {
            return values;
        }
        self.faces.warnings.count(WarningKind::NotFinite, 1);
        [0.0; N]
    }

    fn face(&mut self, line: &Line) -> Result<(), ObjError> {
        let first = self.faces.corners.len();
        let so_far = ElementCounts {
            positions: self.before.positions + self.positions_read,
            texture: self.before.texture + self.texture_read,
            normals: self.before.normals + self.normals_read,
        };
        for word in line.words() {
            let corner = Corner::parse(word, so_far, self.all).map_err(|why| why.error(line.number, word))?;
            self.faces.corners.push(corner);
        }
        let kind = match self.faces.corners.len() - first {
            0 => return Err(ObjError::NoCorners { line: line.number }),
            1 => WarningKind::Points,
            2 => WarningKind::Lines,
            _ => {
                self.faces.ends.push(self.faces.corners.len() as u32);
                return Ok(());
            }
        };
        self.faces.corners.truncate(first);
        self.warn(kind, line.number);
        Ok(())
    }
}

/// Parses up to `N` numbers after the keyword, at least `wants`; returns them and their count.
fn numbers<const N: usize>(
    line: &Line,
    keyword: &'static str,
    wants: usize,
) -> Result<([f32; N], usize), ObjError> {
    let mut values = [0.0; N];
    let mut has = 0;
    for (value, word) in values.iter_mut().zip(line.words()) {
        *value = number(word).ok_or_else(|| ObjError::NotANumber {
            line: line.number,
            found: quoted(word),
        })?;
        has += 1;
    }
    if has < wants {
        return Err(ObjError::FewNumbers {
            line: line.number,
            keyword,
            wants,
            has,
        });
    }
    Ok((values, has))
}
