//! The decoders on streams of meshoptimizer's own encoder, whole and damaged.

#[cfg(feature = "levels")]
mod oracle;

use super::{Damage, Filter, Layout, Mode, Stream, decode, filters, vertices};

/// The streams of meshoptimizer's encoder for [`cases`]: for each its length, as `u32`, and its bytes.
const STREAMS: &[u8] = include_bytes!("../../../../fixtures/meshopt_streams.bin");

/// An input of the encoder, made by code.
#[derive(Clone, Copy, Debug)]
struct Case {
    mode: Mode,
    /// Version of the format; 1 for indices.
    version: u8,
    count: usize,
    stride: usize,
}

impl Case {
    const fn attributes(version: u8, count: usize, stride: usize) -> Case {
        Case {
            mode: Mode::Attributes,
            version,
            count,
            stride,
        }
    }

    const fn indices(mode: Mode, count: usize) -> Case {
        Case {
            mode,
            version: 1,
            count,
            stride: 4,
        }
    }

    fn layout(self) -> Layout {
        Layout {
            mode: self.mode,
            filter: Filter::None,
            count: self.count,
            stride: self.stride,
        }
    }

    /// Whether these are the elements that were encoded. The encoder may begin a triangle at another of its vertices.
    fn is_encoded_from(self, mut elements: Vec<u8>) -> bool {
        let mut expected = self.elements();
        if self.mode == Mode::Triangles {
            for triangles in [&mut elements, &mut expected] {
                for triangle in triangles.as_chunks_mut::<4>().0.as_chunks_mut::<3>().0 {
                    let lowest = (0..3).min_by_key(|&corner| triangle[corner]).expect("three");
                    triangle.rotate_left(lowest);
                }
            }
        }
        elements == expected
    }

    /// The bytes to encode.
    fn elements(self) -> Vec<u8> {
        match self.mode {
            Mode::Attributes => attributes(self.count, self.stride),
            Mode::Triangles | Mode::Indices => {
                let indices = indices(self.count);
                indices.into_iter().flat_map(u32::to_le_bytes).collect()
            }
        }
    }
}

/// Counts around the sizes of groups and blocks, strides with blocks of 256, 224, 128 and 32 elements.
fn cases() -> impl Iterator<Item = Case> {
    let shapes = [
        (1, 4),
        (15, 8),
        (16, 12),
        (17, 16),
        (600, 4),
        (257, 12),
        (130, 20),
        (225, 36),
        (129, 64),
        (33, 256),
        (1, 256),
    ];
    let attributes = shapes
        .into_iter()
        .flat_map(|(count, stride)| [0, 1].map(|version| Case::attributes(version, count, stride)));
    let indices = [Mode::Triangles, Mode::Indices]
        .into_iter()
        .flat_map(|mode| [3, 900, 1500].map(|count| Case::indices(mode, count)));
    attributes.chain(indices)
}

/// Returns the random numbers that the stored streams were encoded from, below those asked for.
fn numbers(mut state: u64) -> impl FnMut(usize) -> usize {
    move |below| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as usize % below
    }
}

/// Elements whose words are, by turns: constant, floats along a curve, two walks of 16 bits, four of 8 bits, random in five bits
/// across two bytes, random in all.
fn attributes(count: usize, stride: usize) -> Vec<u8> {
    let mut number = numbers((count * stride) as u64);
    let mut shorts = [0_u16; 2];
    let mut bytes = [0_u8; 4];
    let mut elements = Vec::with_capacity(count * stride);
    for element in 0..count {
        for word in 0..stride / 4 {
            elements.extend(match (word + count) % 6 {
                0 => [1, 2, 3, 4],
                1 => ((element * element + word) as f32 * 0.01).to_le_bytes(),
                2 => {
                    shorts = shorts.map(|short| short.wrapping_add(number(300) as u16).wrapping_sub(150));
                    let [[a, b], [c, d]] = shorts.map(u16::to_le_bytes);
                    [a, b, c, d]
                }
                3 => {
                    bytes = bytes.map(|byte| byte.wrapping_add(number(4) as u8).wrapping_sub(1));
                    bytes
                }
                4 => (0x3f80_0000 | (number(32) as u32) << 14).to_le_bytes(),
                _ => (number(1 << 31) as u32).to_le_bytes(),
            });
        }
    }
    elements
}

/// Triangles of a strip, then random ones, then the strip again from 0.
fn indices(count: usize) -> Vec<u32> {
    let mut number = numbers(count as u64);
    let strip = |triangle: usize| {
        let first = triangle as u32;
        match triangle % 2 {
            0 => [first, first + 1, first + 2],
            _ => [first + 1, first, first + 2],
        }
    };
    let triangles = (0..count / 3).map(|triangle| match 6 * triangle / count {
        0 => strip(triangle),
        _ if triangle.is_multiple_of(7) => [0; 3].map(|_| number(100_000) as u32),
        _ => strip(triangle % 100),
    });
    triangles.flatten().collect()
}

/// Each case with its stream.
fn streams() -> impl Iterator<Item = (Case, &'static [u8])> {
    let mut rest = STREAMS;
    cases().map(move |case| {
        let (length, after) = rest.split_first_chunk().expect("a length");
        let (stream, after) = after.split_at(u32::from_le_bytes(*length) as usize);
        rest = after;
        (case, stream)
    })
}

#[test]
fn streams_of_the_encoder_decode_to_what_was_encoded() {
    let (mut short, mut modes) = (0, std::collections::BTreeSet::new());
    for (case, stream) in streams() {
        let elements = decode(case.layout(), stream).expect("decoded");
        short += usize::from(stream.len() < elements.len());
        if case.mode != Mode::Attributes {
            let layout = Layout {
                stride: 2,
                ..case.layout()
            };
            let low = elements
                .as_chunks::<4>()
                .0
                .iter()
                .flat_map(|index| [index[0], index[1]]);
            assert!(decode(layout, stream) == Ok(low.collect()), "{case:?}");
        }
        if case.version == 1 && case.mode == Mode::Attributes {
            modes.extend(&stream[stream.len() - case.stride / 4..]);
        }
        assert!(case.is_encoded_from(elements), "{case:?}");
    }
    assert!(short > 12, "{short} are compressed at all");
    // Deltas of 8 bits, of 16 bits, and XOR with a rotation.
    let has = |expected: fn(u8) -> bool| modes.iter().any(|&mode| expected(mode));
    assert!(
        has(|mode| mode == 0) && has(|mode| mode == 1) && has(|mode| mode > 2),
        "{modes:?}"
    );
}

#[test]
fn streams_that_are_cut_or_too_long_are_errors() {
    for (case, stream) in streams() {
        for length in (0..stream.len()).rev().take(300) {
            assert!(
                decode(case.layout(), &stream[..length]).is_err(),
                "{case:?} cut to {length}"
            );
        }
        let mut longer = stream.to_vec();
        longer.push(0);
        assert!(
            decode(case.layout(), &longer).is_err(),
            "{case:?} with one byte more"
        );
        let more = Layout {
            count: case.count + 3,
            ..case.layout()
        };
        assert!(decode(more, stream) != decode(case.layout(), stream), "{case:?}");
    }
}

/// Calls `check` with each stream, damaged in many ways.
fn damaged(rounds: u64, mut check: impl FnMut(Layout, &[u8])) {
    for (case, stream) in streams() {
        let mut number = numbers(stream.len() as u64);
        for _ in 0..rounds {
            let mut stream = stream.to_vec();
            for _ in 0..=number(3) {
                let at = match number(4) {
                    0 => number(stream.len().min(20)),
                    1 => stream.len() - 1 - number(stream.len().min(30)),
                    _ => number(stream.len()),
                };
                match number(4) {
                    0 => stream[at] = number(256) as u8,
                    1 => stream[at] = 0xff,
                    2 => stream[at] ^= 1 << number(8),
                    _ => stream.truncate(1 + at.max(stream.len() / 2)),
                }
            }
            let stride = if case.mode == Mode::Attributes {
                case.stride
            } else {
                2 + 2 * number(2)
            };
            check(
                Layout {
                    stride,
                    ..case.layout()
                },
                &stream,
            );
        }
    }
}

#[test]
fn damaged_streams_decode_to_the_right_length_or_are_errors() {
    let (mut decoded, mut refused) = (0, 0);
    damaged(500, |layout, stream| match decode(layout, stream) {
        Ok(bytes) => {
            assert_eq!(bytes.len(), layout.count * layout.stride);
            decoded += 1;
        }
        Err(_) => refused += 1,
    });
    assert!(
        decoded > 2000 && refused > 2000,
        "{decoded} decoded, {refused} refused"
    );
}

#[test]
fn short_streams_of_random_bytes_are_harmless() {
    let mut number = numbers(5);
    for _ in 0..50_000 {
        let length = number(60);
        let mut stream: Vec<u8> = (0..length).map(|_| number(256) as u8).collect();
        let mode = [Mode::Attributes, Mode::Triangles, Mode::Indices][number(3)];
        let stride = if mode == Mode::Attributes {
            4 * (1 + number(64))
        } else {
            2 + 2 * number(2)
        };
        if let Some(header) = stream.first_mut() {
            *header = match mode {
                Mode::Attributes => 0xa0,
                Mode::Triangles => 0xe0,
                Mode::Indices => 0xd0,
            } + number(2) as u8;
        }
        let layout = Layout {
            mode,
            filter: Filter::None,
            count: 3 * number(20),
            stride,
        };
        if let Ok(bytes) = decode(layout, &stream) {
            assert_eq!(bytes.len(), layout.count * layout.stride);
        }
    }
}

#[test]
fn a_count_that_no_stream_could_hold_is_refused_before_memory_is_set_aside() {
    for (mode, stride, header) in [
        (Mode::Attributes, 256, 0xa0),
        (Mode::Attributes, 4, 0xa1),
        (Mode::Triangles, 4, 0xe1),
        (Mode::Indices, 4, 0xd1),
    ] {
        let mut stream = vec![0; 1000];
        stream[0] = header;
        let layout = Layout {
            mode,
            filter: Filter::None,
            count: usize::MAX / 1024 / 3 * 3,
            stride,
        };
        assert_eq!(decode(layout, &stream), Err(Damage::TooShort), "{mode:?}");
    }
}

#[test]
fn a_group_of_four_bits_each_is_read_as_the_specification_says() {
    // The example of appendix A: 16 deltas, of which two follow as whole bytes.
    let mut stream = Stream(&[0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5]);
    let mut group = [0; 16];
    vertices::read_group::<4>(&mut stream, &mut group).expect("a group");
    stream.finish().expect("all of it");
    let deltas = group.map(|zigzag| ((zigzag >> 1) ^ 0_u8.wrapping_sub(zigzag & 1)).cast_signed());
    assert_eq!(
        deltas,
        [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]
    );
}

#[test]
fn numbers_are_leb128_of_five_bytes_at_most() {
    let number = |bytes: &[u8]| Stream(bytes).number();
    assert_eq!(number(&[0x7f]), Ok(0x7f));
    assert_eq!(number(&[0x81, 0x04]), Ok(0x201));
    assert_eq!(number(&[0xff, 0xa0, 0x05]), Ok(0x1_507f));
    assert_eq!(number(&[0xff, 0xff, 0xff, 0xff, 0x7f]), Ok(u32::MAX));
    assert_eq!(number(&[0xff; 5]), Err(Damage::LongNumber));
    assert_eq!(number(&[0xff; 4]), Err(Damage::TooShort));
}

/// Decodes indices of 4 bytes from a stream without header and tail; the tail is all zeros.
fn decode_indices(mode: Mode, header: u8, count: usize, stream: &[u8]) -> Result<Vec<u32>, Damage> {
    let tail = if mode == Mode::Triangles { 16 } else { 4 };
    let bytes = [&[header], stream, &[0; 16][..tail]].concat();
    let layout = Layout {
        mode,
        filter: Filter::None,
        count,
        stride: 4,
    };
    let decoded = decode(layout, &bytes)?;
    Ok(decoded
        .as_chunks()
        .0
        .iter()
        .map(|&bytes| u32::from_le_bytes(bytes))
        .collect())
}

#[test]
fn triangles_of_version_0_reach_two_vertices_farther_back() {
    // Five new triangles have 15 vertices; a sixth takes the second edge of the last and the vertex 13 before the last.
    let codes = [0xf0, 0xf0, 0xf0, 0xf0, 0xf0, 0x1d];
    let triangles = |header| decode_indices(Mode::Triangles, header, 18, &codes).expect("triangles");
    assert_eq!(triangles(0xe0)[15..], [14, 13, 1]);
    // In version 1 it is the index before the last that was stored, 0.
    assert_eq!(triangles(0xe1)[15..], [14, 13, u32::MAX]);
}

#[test]
fn every_damage_has_its_own_error() {
    let triangles = |stream: &[u8]| decode_indices(Mode::Triangles, 0xe1, 3, stream);
    assert_eq!(triangles(&[0x00]), Err(Damage::NotYetSeen));
    assert_eq!(triangles(&[0xfe, 0x10]), Err(Damage::NotYetSeen));
    assert_eq!(triangles(&[0xf0, 7, 7]), Err(Damage::LeftOver(2)));
    assert_eq!(triangles(&[0xff, 0xff, 1]), Err(Damage::TooShort));
    assert_eq!(
        decode_indices(Mode::Triangles, 0xe2, 3, &[0xf0]),
        Err(Damage::Header(0xe2))
    );
    assert_eq!(
        decode_indices(Mode::Indices, 0xe1, 3, &[0; 3]),
        Err(Damage::Header(0xe1))
    );
    assert_eq!(
        decode_indices(Mode::Indices, 0xd1, 3, &[0; 4]),
        Err(Damage::LeftOver(1))
    );
    let layout = Layout {
        mode: Mode::Triangles,
        filter: Filter::None,
        count: 3,
        stride: 4,
    };
    let mut table = [0; 18];
    table[..2].copy_from_slice(&[0xe1, 0xf0]);
    table[9] = 0x2f;
    assert_eq!(decode(layout, &table), Err(Damage::CodeTable(0x2f)));
    let layout = Layout {
        mode: Mode::Attributes,
        ..layout
    };
    for (mode, expected) in [
        (0x00, Ok(vec![0; 12])),
        (0x01, Ok(vec![0; 12])),
        (0x72, Ok(vec![0; 12])),
        (0x03, Err(Damage::ChannelMode(0x03))),
        (0x10, Err(Damage::ChannelMode(0x10))),
    ] {
        // All deltas of the four bytes are 0.
        let mut stream = [0; 26];
        stream[..2].copy_from_slice(&[0xa1, 0xaa]);
        stream[25] = mode;
        assert_eq!(decode(layout, &stream), expected, "{mode:#x}");
    }
}

/// Applies a filter to an element of four numbers of 16 bits.
fn filtered(filter: Filter, element: [i16; 4]) -> [i16; 4] {
    let mut bytes = element.map(i16::to_le_bytes);
    filters::apply(filter, 8, bytes.as_flattened_mut());
    bytes.map(i16::from_le_bytes)
}

#[test]
fn filters_decode_what_the_specification_says() {
    let octahedral = |element| filtered(Filter::Octahedral, element);
    assert_eq!(octahedral([0, 0, 511, -7]), [0, 0, 32767, -7]);
    assert_eq!(octahedral([511, 0, 511, 0]), [32767, 0, 0, 0]);
    assert_eq!(octahedral([0, -511, 511, 0]), [0, -32767, 0, 0]);
    assert_eq!(octahedral([511, -511, 511, 0]), [0, 0, -32767, 0]);
    let quaternion = |element| filtered(Filter::Quaternion, element);
    assert_eq!(quaternion([0, 0, 0, 2044]), [32767, 0, 0, 0]);
    assert_eq!(quaternion([0, 0, 0, 2047]), [0, 0, 0, 32767]);
    assert_eq!(quaternion([2047, 0, 0, 2045]), [0, 23170, 23170, 0]);
    let color =
        |element: [i32; 4]| filtered(Filter::Color, element.map(|part| part as i16)).map(i16::cast_unsigned);
    assert_eq!(color([127, 0, 0, 127]), [65535; 4]);
    assert_eq!(color([0, 0, 0, 64]), [0; 4]);
    assert_eq!(color([32767, 32767, 0, 65535]), [65534, 32767, 0, 65535]);
    for (encoded, float) in [
        (3, 3.0),
        (-3 & 0xff_ffff, -3.0),
        ((-2 << 24) | 3, 0.75),
        (100 << 24 | 1, 2.0_f32.powi(100)),
        ((-100 << 24) | 1, 2.0_f32.powi(-100)),
        ((127 << 24) | 1, 2.0_f32.powi(127)),
        ((-128 << 24) | (1 << 22), 2.0_f32.powi(-106)),
        ((127 << 24) | 2, f32::INFINITY),
    ] {
        let mut bytes = i32::to_le_bytes(encoded);
        filters::apply(Filter::Exponential, 4, &mut bytes);
        assert_eq!(f32::from_le_bytes(bytes), float, "{encoded:#x}");
    }
}

#[test]
fn filters_take_any_bytes() {
    let mut number = numbers(3);
    let filters = [
        Filter::Octahedral,
        Filter::Quaternion,
        Filter::Exponential,
        Filter::Color,
    ];
    for _ in 0..100_000 {
        let mut bytes: [u8; 8] = std::array::from_fn(|_| match number(4) {
            0 => 0,
            1 => 0xff,
            _ => number(256) as u8,
        });
        for filter in filters {
            filters::apply(filter, 8, &mut bytes);
            if filter != Filter::Quaternion {
                filters::apply(filter, 4, &mut bytes[..4]);
            }
        }
    }
}
