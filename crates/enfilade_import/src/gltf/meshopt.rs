//! Decodes what meshoptimizer encoded.
//!
//! Decoders want to know the size of an element when they are compiled; so there is one for each size.
//! Source: Kapoulkine, meshoptimizer; EXT_meshopt_compression.
//! Cost: O(bytes that come out).

use super::compressed::{Compressed, Filter, Mode};
use meshopt::{
    decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat, decode_index_buffer,
    decode_index_sequence, decode_vertex_buffer,
};

/// The bytes of a view; `None` where what is encoded is damaged.
pub(super) fn decode(view: &Compressed, encoded: &[u8]) -> Option<Vec<u8>> {
    let count = view.count;
    match (view.mode, view.stride) {
        // No stream is as short as one of nothing.
        _ if count == 0 => Some(Vec::new()),
        (Mode::Attributes, _) => Some(filtered(words(encoded, count, view.stride)?, view)),
        (Mode::Triangles, 2) => Some(shorts(decode_index_buffer::<u16>(encoded, count).ok()?)),
        (Mode::Triangles, _) => Some(bytes(decode_index_buffer::<u32>(encoded, count).ok()?)),
        (Mode::Indices, 2) => Some(shorts(decode_index_sequence::<u16>(encoded, count).ok()?)),
        (Mode::Indices, _) => Some(bytes(decode_index_sequence::<u32>(encoded, count).ok()?)),
    }
}

fn filtered(mut words: Vec<u32>, view: &Compressed) -> Vec<u8> {
    match (view.filter, view.stride) {
        (Filter::None, _) => bytes(words),
        (Filter::Exponential, _) => {
            decode_filter_exp(words.as_chunks_mut::<1>().0);
            bytes(words)
        }
        (Filter::Octahedral, 4) => {
            let mut vectors: Vec<[i8; 4]> = words.iter().map(small).collect();
            decode_filter_oct(&mut vectors);
            vectors.into_iter().flatten().map(i8::cast_unsigned).collect()
        }
        (Filter::Octahedral, _) => {
            let mut vectors = large(&words);
            decode_filter_oct(&mut vectors);
            vectors.into_iter().flatten().flat_map(i16::to_ne_bytes).collect()
        }
        (Filter::Quaternion, _) => {
            let mut turns = large(&words);
            decode_filter_quat(&mut turns);
            turns.into_iter().flatten().flat_map(i16::to_ne_bytes).collect()
        }
        (Filter::Color, 4) => {
            let mut colors: Vec<[i8; 4]> = words.iter().map(small).collect();
            decode_filter_color(&mut colors);
            colors.into_iter().flatten().map(i8::cast_unsigned).collect()
        }
        (Filter::Color, _) => {
            let mut colors = large(&words);
            decode_filter_color(&mut colors);
            colors.into_iter().flatten().flat_map(i16::to_ne_bytes).collect()
        }
    }
}

fn small(word: &u32) -> [i8; 4] {
    word.to_ne_bytes().map(u8::cast_signed)
}

fn large(words: &[u32]) -> Vec<[i16; 4]> {
    let pairs = words.as_chunks::<2>().0.iter();
    pairs
        .map(|pair| {
            let [a, b] = pair.map(|word| word.to_ne_bytes());
            [[a[0], a[1]], [a[2], a[3]], [b[0], b[1]], [b[2], b[3]]].map(i16::from_ne_bytes)
        })
        .collect()
}

fn bytes(words: Vec<u32>) -> Vec<u8> {
    words.into_iter().flat_map(u32::to_ne_bytes).collect()
}

fn shorts(words: Vec<u16>) -> Vec<u8> {
    words.into_iter().flat_map(u16::to_ne_bytes).collect()
}

/// An element of so many words.
#[derive(Clone)]
struct Element<const WORDS: usize>([u32; WORDS]);

impl<const WORDS: usize> Default for Element<WORDS> {
    fn default() -> Element<WORDS> {
        Element([0; WORDS])
    }
}

fn elements<const WORDS: usize>(encoded: &[u8], count: usize) -> Option<Vec<u32>> {
    let decoded = decode_vertex_buffer::<Element<WORDS>>(encoded, count).ok()?;
    Some(decoded.into_iter().flat_map(|element| element.0).collect())
}

/// The words of `count` elements of `stride` bytes: a multiple of 4, up to 256.
fn words(encoded: &[u8], count: usize, stride: usize) -> Option<Vec<u32>> {
    macro_rules! of_words {
        ($($words:literal)*) => {
            match stride / 4 {
                $($words => elements::<$words>(encoded, count),)*
                _ => None,
            }
        };
    }
    of_words!(
        1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64
    )
}
