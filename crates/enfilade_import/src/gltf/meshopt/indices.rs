//! Decodes triangle lists and index sequences.
//!
//! A triangle is one byte: the index of its edge in a FIFO of 16, and the source of its third vertex. An index of a sequence is
//! its delta from the last of one of two subsequences.
//! Source: KHR_meshopt_compression, appendix A, modes 1 and 2; version 0 of mode 1 as meshoptimizer decodes it.
//! Cost: O(indices). Both check the shortest possible stream before they allocate: at most 12 bytes for each byte read.
//! A reference to an edge or vertex that is not in its FIFO yet is an error, as the specification demands.

use super::{Damage, Stream};

const TRIANGLES: u8 = 0xe0;
const SEQUENCE: u8 = 0xd0;

/// Decodes `count` indices of `stride` bytes, three per triangle.
pub(super) fn decode_triangles(encoded: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Damage> {
    let (version, mut stream, table) = Stream::open(encoded, TRIANGLES, |_| 16)?;
    if let Some(&entry) = table.iter().find(|&&entry| entry & 15 == 15 || entry >> 4 == 15) {
        return Err(Damage::CodeTable(entry));
    }
    let codes = stream.take(count / 3)?;
    let mut decoded = Vec::with_capacity(count * stride);
    let mut triangles = Triangles {
        stream,
        // Version 0 has two more vertices of the FIFO instead of the neighbours of the last index.
        fifo_end: if version == 0 { 15 } else { 13 },
        next: 0,
        last: 0,
        edges: Fifo::default(),
        vertices: Fifo::default(),
    };
    for &code in codes {
        let corners = match code {
            0..0xf0 => triangles.with_edge(code),
            0xf0..0xfe => triangles.without_edge(code, table[usize::from(code & 15)]),
            0xfe.. => {
                let sources = triangles.stream.byte()?;
                triangles.without_edge(code, sources)
            }
        }?;
        for index in corners {
            push(&mut decoded, index, stride);
        }
    }
    triangles.stream.finish()?;
    Ok(decoded)
}

/// Decodes `count` indices of `stride` bytes.
pub(super) fn decode_sequence(encoded: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Damage> {
    let (_, mut stream, _) = Stream::open(encoded, SEQUENCE, |_| 4)?;
    // An index takes at least one byte.
    if stream.0.len() < count {
        return Err(Damage::TooShort);
    }
    let mut decoded = Vec::with_capacity(count * stride);
    let mut last = [0_u32; 2];
    for _ in 0..count {
        let number = stream.number()?;
        let last = &mut last[(number & 1) as usize];
        *last = last.wrapping_add(unzigzag(number >> 1));
        push(&mut decoded, *last, stride);
    }
    stream.finish()?;
    Ok(decoded)
}

/// Appends the low `stride` bytes of an index, 2 or 4.
fn push(decoded: &mut Vec<u8>, index: u32, stride: usize) {
    let bytes = index.to_le_bytes();
    match stride {
        2 => decoded.extend_from_slice(&bytes[..2]),
        _ => decoded.extend_from_slice(&bytes),
    }
}

/// Zigzag numbers alternate in sign: 0, −1, 1, −2, …
fn unzigzag(number: u32) -> u32 {
    (number >> 1) ^ 0_u32.wrapping_sub(number & 1)
}

/// The state between two triangles.
struct Triangles<'a> {
    /// The bytes after the codes: sources of vertices, and stored indices.
    stream: Stream<'a>,
    /// Sources of a third vertex from 1 to below this one are in the FIFO.
    fifo_end: u8,
    /// The lowest index that is not used yet.
    next: u32,
    /// The last index that was stored as a delta.
    last: u32,
    edges: Fifo<[u32; 2]>,
    vertices: Fifo<u32>,
}

impl Triangles<'_> {
    /// Decodes a triangle that shares an edge in the FIFO.
    fn with_edge(&mut self, code: u8) -> Result<[u32; 3], Damage> {
        let [a, b] = self.edges.get(code >> 4)?;
        let third = code & 15;
        let c = match third {
            0 => self.new_index(),
            _ if third < self.fifo_end => self.vertices.get(third)?,
            15 => self.stored_index()?,
            // 13 is the index before the last one, 14 the one after it.
            _ => {
                self.last = self.last.wrapping_add(if third == 13 { u32::MAX } else { 1 });
                self.last
            }
        };
        if third == 0 || third >= self.fifo_end {
            self.vertices.push(c);
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// Decodes a triangle that shares no edge in the FIFO.
    ///
    /// `sources` are those of the second vertex (high four bits) and the third: 0 is a new index, 15 a stored one, all others
    /// are vertices in the FIFO.
    fn without_edge(&mut self, code: u8, sources: u8) -> Result<[u32; 3], Damage> {
        // Streams were concatenated: the next one counts from 0 again.
        if code >= 0xfe && sources == 0 {
            self.next = 0;
        }
        let from_source = |triangles: &mut Self, source| match source {
            0 => Ok(triangles.new_index()),
            15 => triangles.stored_index(),
            in_fifo => triangles.vertices.get(in_fifo - 1),
        };
        let sources = [if code == 0xff { 15 } else { 0 }, sources >> 4, sources & 15];
        let mut corners = [0; 3];
        for (corner, source) in corners.iter_mut().zip(sources) {
            *corner = from_source(self, source)?;
        }
        let [a, b, c] = corners;
        for (corner, source) in corners.into_iter().zip(sources) {
            if source == 0 || source == 15 {
                self.vertices.push(corner);
            }
        }
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok(corners)
    }

    fn new_index(&mut self) -> u32 {
        let index = self.next;
        self.next = self.next.wrapping_add(1);
        index
    }

    fn stored_index(&mut self) -> Result<u32, Damage> {
        let delta = unzigzag(self.stream.number()?);
        self.last = self.last.wrapping_add(delta);
        Ok(self.last)
    }
}

/// The last 16 values that were pushed.
#[derive(Default)]
struct Fifo<T> {
    ring: [T; 16],
    pushed: usize,
}

impl<T: Copy> Fifo<T> {
    fn push(&mut self, value: T) {
        self.ring[self.pushed % 16] = value;
        self.pushed += 1;
    }

    /// The value that was pushed `age` pushes before the last one, 0 to 15.
    fn get(&self, age: u8) -> Result<T, Damage> {
        let index = self
            .pushed
            .checked_sub(1 + usize::from(age))
            .ok_or(Damage::NotYetSeen)?;
        Ok(self.ring[index % 16])
    }
}
