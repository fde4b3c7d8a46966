//! Reads portal files: PRT1, PRT2, and the variant of PRT1 that Quake 3 compilers write.
//!
//! The format is text: a magic word; one number per line for leafs (PRT2), clusters, portals and solid faces (Quake 3);
//! then one portal per line with its corner count, two clusters, a hint flag (Quake 3) and the corners `(x y z)`. The
//! corners are counter-clockwise when seen from the second cluster. PRT2 ends with one line per cluster: its leafs,
//! then −1.
//! Source: the files themselves; id Software's tools defined PRT1, later tools the rest.
//! Cost: O(bytes).
//! Hostile input: nothing is allocated before the text that fills it has been read.

use super::PrtError;
use crate::gltf;
use enfilade_bake::{Cells, Portal};

/// Format of a portal file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrtKind {
    /// Quake and other engines; each leaf is a cluster.
    Prt1,
    /// Quake, with leafs grouped into clusters.
    Prt2,
    /// The PRT1 variant of Quake 3 compilers.
    Quake3,
}

impl PrtKind {
    /// Returns `PRT1`, `PRT2` or `PRT1 of Quake 3`.
    pub fn name(self) -> &'static str {
        match self {
            PrtKind::Prt1 => "PRT1",
            PrtKind::Prt2 => "PRT2",
            PrtKind::Quake3 => "PRT1 of Quake 3",
        }
    }
}

/// The portals of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct PortalFile {
    /// Format of the file.
    pub kind: PrtKind,
    /// The clusters and the portals between them, in file order.
    pub cells: Cells,
    /// PRT2 only: the cluster of each non-solid leaf. Index 0 is leaf 1 of the map, because leaf 0 is solid. `None` for
    /// PRT1, where each leaf is a cluster, and for Quake 3, where the map stores the clusters.
    pub cluster_of_leaf: Option<Vec<u32>>,
}

impl PortalFile {
    /// Parses the text of a portal file.
    ///
    /// # Errors
    /// Returns a [`PrtError`] for the first violated rule.
    pub fn parse(text: &[u8]) -> Result<PortalFile, PrtError> {
        let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
        let mut lines = Lines {
            rest: text,
            number: 0,
        };
        let magic = lines.next().map(|line| line.text);
        let is_second = match magic {
            Some(b"PRT1") => false,
            Some(b"PRT2") => true,
            _ => {
                return Err(PrtError::NotPrt {
                    begins: gltf::beginning(text),
                });
            }
        };
        let leafs = if is_second {
            lines.number("the number of leafs")?
        } else {
            0
        };
        let clusters = lines.number("the number of clusters")?;
        let portals = lines.number("the number of portals")?;
        // Portal lines have more than one word, so a third line with a single number is the count of solid faces.
        let alone = lines
            .clone()
            .next()
            .is_some_and(|line| words(line.text).count() == 1);
        let faces = if !is_second && alone {
            Some(lines.number("the number of faces")?)
        } else {
            None
        };
        let (read, numbers) = read_portals(&mut lines, portals, faces.is_some())?;
        let cells = Cells::new(clusters, read).map_err(|why| PrtError::Portal {
            line: numbers[why.portal()],
            why,
        })?;
        if let Some(faces) = faces {
            for face in 0..faces {
                let line = lines.wanted(|| format!("solid face {face} of {faces}"))?;
                corners(&line, 1)?;
            }
        }
        let cluster_of_leaf = if is_second {
            Some(read_clusters(&mut lines, clusters, leafs)?)
        } else {
            None
        };
        if let Some(line) = lines.next() {
            let promised = format!("{clusters} clusters and {portals} portals");
            return Err(PrtError::More {
                line: line.number,
                promised,
            });
        }
        let kind = match (is_second, faces) {
            (true, _) => PrtKind::Prt2,
            (false, None) => PrtKind::Prt1,
            (false, Some(_)) => PrtKind::Quake3,
        };
        Ok(PortalFile {
            kind,
            cells,
            cluster_of_leaf,
        })
    }
}

/// Returns the portals and their line numbers.
fn read_portals(
    lines: &mut Lines,
    count: u32,
    with_hints: bool,
) -> Result<(Vec<Portal>, Vec<usize>), PrtError> {
    let mut portals = Vec::new();
    let mut numbers = Vec::new();
    for nth in 0..count {
        let line = lines.wanted(|| format!("portal {nth} of {count}"))?;
        let (head, corners) = corners(&line, if with_hints { 3 } else { 2 })?;
        portals.push(Portal {
            corners,
            cells: [head[0], head[1]],
        });
        numbers.push(line.number);
    }
    Ok((portals, numbers))
}

/// Parses a line of a corner count, `after` more integers, and the corners; returns those integers and the corners.
fn corners(line: &Line, after: usize) -> Result<(Vec<u32>, Vec<[f64; 3]>), PrtError> {
    let mut words = words(line.text);
    let promised = line.number_in(words.next(), "the number of corners")?;
    let head: Vec<u32> = (0..after)
        .map(|_| line.number_in(words.next(), "the number of a cluster"))
        .collect::<Result<_, _>>()?;
    let mut corners = Vec::new();
    let mut words = words.peekable();
    while words.peek().is_some() {
        line.mark(words.next(), b"(", "`(` before a corner")?;
        let mut corner = [0.0; 3];
        for at in &mut corner {
            *at = line.number_in(words.next(), "a coordinate")?;
        }
        line.mark(words.next(), b")", "`)` after a corner's three coordinates")?;
        corners.push(corner);
    }
    if corners.len() != promised as usize {
        let (line, has) = (line.number, corners.len());
        return Err(PrtError::Corners { line, promised, has });
    }
    Ok((head, corners))
}

/// Returns the cluster of each leaf.
fn read_clusters(lines: &mut Lines, clusters: u32, leafs: u32) -> Result<Vec<u32>, PrtError> {
    let mut named = Vec::new();
    for cluster in 0..clusters {
        let line = lines.wanted(|| format!("the leafs of cluster {cluster} of {clusters}"))?;
        let mut words = words(line.text).peekable();
        loop {
            let word = words.next();
            if word == Some(b"-1".as_slice()) && words.peek().is_none() {
                break;
            }
            let leaf: u32 = line.number_in(word, "the number of a leaf, or −1 at the end")?;
            named.push((leaf, cluster, line.number));
        }
    }
    named.sort_unstable();
    for (wanted, &(leaf, _, line)) in (0u32..).zip(&named) {
        let why = if leaf >= leafs {
            "does not exist"
        } else if leaf < wanted {
            "is in two clusters"
        } else if leaf > wanted {
            "comes after one that is in no cluster"
        } else {
            continue;
        };
        return Err(PrtError::Leaf {
            line,
            leaf,
            why,
            leafs,
        });
    }
    if named.len() < leafs as usize {
        return Err(PrtError::Ends {
            wanted: format!("the cluster of leaf {} of {leafs}", named.len()),
        });
    }
    Ok(named.into_iter().map(|(_, cluster, _)| cluster).collect())
}

#[derive(Clone, Copy, Debug)]
struct Line<'a> {
    /// Line number, from 1.
    number: usize,
    text: &'a [u8],
}

impl Line<'_> {
    /// Parses a word of this line as a number.
    fn number_in<T: std::str::FromStr>(
        &self,
        word: Option<&[u8]>,
        wanted: &'static str,
    ) -> Result<T, PrtError> {
        let number = word.and_then(|word| std::str::from_utf8(word).ok()?.parse().ok());
        number.ok_or_else(|| self.lacks(word, wanted))
    }

    fn mark(&self, word: Option<&[u8]>, mark: &[u8], wanted: &'static str) -> Result<(), PrtError> {
        if word == Some(mark) {
            Ok(())
        } else {
            Err(self.lacks(word, wanted))
        }
    }

    fn lacks(&self, word: Option<&[u8]>, wanted: &'static str) -> PrtError {
        PrtError::NotANumber {
            line: self.number,
            found: word.map_or("the end of the line".to_owned(), shown),
            wanted,
        }
    }
}

/// Iterates over the non-empty lines.
#[derive(Clone, Debug)]
struct Lines<'a> {
    rest: &'a [u8],
    /// Number of the last line, from 1.
    number: usize,
}

impl<'a> Lines<'a> {
    fn wanted(&mut self, wanted: impl FnOnce() -> String) -> Result<Line<'a>, PrtError> {
        self.next().ok_or_else(|| PrtError::Ends { wanted: wanted() })
    }

    /// Parses the next line as a single number.
    fn number(&mut self, wanted: &'static str) -> Result<u32, PrtError> {
        let line = self.wanted(|| wanted.to_owned())?;
        line.number_in(Some(line.text), wanted)
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        while !self.rest.is_empty() {
            let end = self.rest.iter().position(|&byte| byte == b'\n');
            let (text, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
            self.rest = rest.get(1..).unwrap_or_default();
            self.number += 1;
            let text = text.trim_ascii();
            if !text.is_empty() {
                return Some(Line {
                    number: self.number,
                    text,
                });
            }
        }
        None
    }
}

/// Splits at white space; each parenthesis is a separate word.
fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = text;
    std::iter::from_fn(move || {
        rest = rest.trim_ascii_start();
        let &first = rest.first()?;
        let is_mark = |byte: u8| byte == b'(' || byte == b')';
        let ends = |&byte: &u8| is_mark(byte) || byte.is_ascii_whitespace();
        let end = if is_mark(first) {
            1
        } else {
            rest.iter().position(ends).unwrap_or(rest.len())
        };
        let (word, after) = rest.split_at(end);
        rest = after;
        Some(word)
    })
}

/// Quotes the first few bytes of a word for a message.
fn shown(word: &[u8]) -> String {
    const ENOUGH: usize = 16;
    let beginning = String::from_utf8_lossy(&word[..word.len().min(ENOUGH)]);
    format!("`{}`", beginning.escape_debug())
}
