//! The decoders against those of meshoptimizer, in C++.

use super::{Case, Filter, Layout, Mode, cases, damaged, decode, filters, numbers};
use ::meshopt::{
    EncodeExpMode, decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat,
    decode_index_buffer, decode_index_sequence, decode_vertex_buffer, encode_filter_color, encode_filter_exp,
    encode_filter_oct, encode_filter_quat, encode_index_buffer, encode_index_sequence,
    encode_vertex_buffer_level,
};

/// An element of `WORDS` words.
#[derive(Clone)]
struct Element<const WORDS: usize>([u32; WORDS]);

impl<const WORDS: usize> Default for Element<WORDS> {
    fn default() -> Element<WORDS> {
        Element([0; WORDS])
    }
}

fn decoded_words<const WORDS: usize>(count: usize, encoded: &[u8]) -> Option<Vec<u8>> {
    let decoded = decode_vertex_buffer::<Element<WORDS>>(encoded, count).ok()?;
    Some(little_endian(decoded.into_iter().flat_map(|element| element.0)))
}

fn encoded_words<const WORDS: usize>(version: u8, elements: &[u8]) -> Vec<u8> {
    let words: Vec<u32> = elements
        .as_chunks()
        .0
        .iter()
        .map(|&word| u32::from_le_bytes(word))
        .collect();
    encode_vertex_buffer_level(words.as_chunks::<WORDS>().0, 3, Some(version.into())).expect("encoded")
}

fn little_endian(words: impl IntoIterator<Item = u32>) -> Vec<u8> {
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// Calls a function that is generic over the number of words in an element.
macro_rules! for_words {
    ($words:expr, $function:ident($first:expr, $second:expr), $($number:literal)*) => {
        match $words {
            $($number => $function::<$number>($first, $second),)*
            words => panic!("{words} words"),
        }
    };
    ($words:expr, $function:ident($first:expr, $second:expr)) => {
        for_words!($words, $function($first, $second),
            1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
            33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
    };
}

fn encoded(case: Case) -> Vec<u8> {
    let elements = case.elements();
    let indices = || -> Vec<u32> {
        elements
            .as_chunks()
            .0
            .iter()
            .map(|&index| u32::from_le_bytes(index))
            .collect()
    };
    match case.mode {
        Mode::Attributes => for_words!(case.stride / 4, encoded_words(case.version, &elements)),
        Mode::Triangles => encode_index_buffer(&indices(), 1 << 20).expect("encoded"),
        Mode::Indices => encode_index_sequence(&indices(), 1 << 20).expect("encoded"),
    }
}

fn decoded(layout: Layout, encoded: &[u8]) -> Option<Vec<u8>> {
    let shorts = |indices: Vec<u16>| indices.into_iter().flat_map(u16::to_le_bytes).collect();
    let count = layout.count;
    match (layout.mode, layout.stride) {
        (Mode::Attributes, stride) => for_words!(stride / 4, decoded_words(count, encoded)),
        (Mode::Triangles, 2) => decode_index_buffer(encoded, count).ok().map(shorts),
        (Mode::Triangles, _) => decode_index_buffer(encoded, count).ok().map(little_endian),
        (Mode::Indices, 2) => decode_index_sequence(encoded, count).ok().map(shorts),
        (Mode::Indices, _) => decode_index_sequence(encoded, count).ok().map(little_endian),
    }
}

#[test]
#[ignore = "writes the fixture that the other tests read"]
fn write_streams() {
    let mut bytes = Vec::new();
    for case in cases() {
        let encoded = encoded(case);
        bytes.extend((encoded.len() as u32).to_le_bytes());
        bytes.extend(encoded);
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/meshopt_streams.bin");
    std::fs::write(path, bytes).expect("written");
}

#[test]
fn all_strides_and_both_versions_decode_to_what_was_encoded() {
    for words in 1..=64 {
        for version in [0, 1] {
            for count in [1, 31, 255, 300] {
                let case = Case::attributes(version, count, 4 * words);
                let elements = decode(case.layout(), &encoded(case)).expect("decoded");
                assert!(case.is_encoded_from(elements), "{case:?}");
            }
        }
    }
    for mode in [Mode::Triangles, Mode::Indices] {
        for count in (3..600).step_by(3) {
            let case = Case::indices(mode, count);
            let elements = decode(case.layout(), &encoded(case)).expect("decoded");
            assert!(case.is_encoded_from(elements), "{case:?}");
        }
    }
}

#[test]
fn damaged_streams_decode_to_the_same_bytes_or_are_errors() {
    let (mut same, mut refused, mut stricter) = (0, 0, 0);
    damaged(1000, |layout, stream| {
        match (decode(layout, stream), decoded(layout, stream)) {
            (Ok(ours), theirs) => {
                assert!(theirs == Some(ours), "{layout:?}: {stream:?}");
                same += 1;
            }
            (Err(_), None) => refused += 1,
            (Err(_), Some(_)) => stricter += 1,
        }
    });
    assert!(
        same > 2000 && refused > 2000 && stricter < same,
        "{same} the same, {refused} refused, {stricter} by us alone"
    );
}

/// Random unit vectors or quaternions.
fn unit_vectors(seed: u64) -> Vec<[f32; 4]> {
    let mut number = numbers(seed);
    let vectors = (0..2000).map(|_| [0; 4].map(|_| number(2001) as f32 / 1000.0 - 1.0));
    let unit = |vector: [f32; 4]| {
        let length = vector.iter().map(|part| part * part).sum::<f32>().sqrt();
        (length > 0.1).then(|| vector.map(|part| part / length))
    };
    vectors.filter_map(unit).collect()
}

/// Compares numbers that may differ by one: meshoptimizer takes some quotients and roots from the processor's estimates.
fn nearly_the_same<T: Copy + Into<i32> + std::fmt::Debug>(ours: &[[T; 4]], theirs: &[[T; 4]]) {
    assert_eq!(ours.len(), theirs.len());
    for (ours, theirs) in ours.iter().zip(theirs) {
        let differs = |part: usize| (ours[part].into() - theirs[part].into()).abs() > 1;
        assert!(!(0..4).any(differs), "{ours:?}, not {theirs:?}");
    }
}

fn filtered_bytes(filter: Filter, elements: &[[i8; 4]]) -> Vec<[i8; 4]> {
    let mut bytes: Vec<[u8; 4]> = elements
        .iter()
        .map(|element| element.map(i8::cast_unsigned))
        .collect();
    filters::apply(filter, 4, bytes.as_flattened_mut());
    bytes
        .into_iter()
        .map(|element| element.map(u8::cast_signed))
        .collect()
}

fn filtered_shorts(filter: Filter, elements: &[[i16; 4]]) -> Vec<[i16; 4]> {
    elements
        .iter()
        .map(|&element| super::filtered(filter, element))
        .collect()
}

#[test]
fn filters_of_all_precisions_agree() {
    let vectors: Vec<[f32; 4]> = unit_vectors(1)
        .into_iter()
        .filter_map(|[x, y, z, w]| {
            let length = (x * x + y * y + z * z).sqrt();
            (length > 0.1).then(|| [x / length, y / length, z / length, w])
        })
        .collect();
    let colors: Vec<[f32; 4]> = unit_vectors(2)
        .into_iter()
        .map(|color| color.map(f32::abs))
        .collect();
    for bits in 2..=8 {
        let mut theirs = encode_filter_oct::<i8>(&vectors, bits);
        let ours = filtered_bytes(Filter::Octahedral, &theirs);
        decode_filter_oct(&mut theirs);
        nearly_the_same(&ours, &theirs);

        let mut theirs = encode_filter_color::<u8>(&colors, bits);
        let signed: Vec<[i8; 4]> = theirs.iter().map(|color| color.map(u8::cast_signed)).collect();
        let ours = filtered_bytes(Filter::Color, &signed);
        let ours: Vec<[u8; 4]> = ours.iter().map(|color| color.map(i8::cast_unsigned)).collect();
        decode_filter_color(&mut theirs);
        nearly_the_same(&ours, &theirs);
    }
    for bits in 2..=16 {
        let mut theirs = encode_filter_oct::<i16>(&vectors, bits);
        let ours = filtered_shorts(Filter::Octahedral, &theirs);
        decode_filter_oct(&mut theirs);
        nearly_the_same(&ours, &theirs);

        let mut theirs = encode_filter_color::<u16>(&colors, bits);
        let signed: Vec<[i16; 4]> = theirs.iter().map(|color| color.map(u16::cast_signed)).collect();
        let ours = filtered_shorts(Filter::Color, &signed);
        let ours: Vec<[u16; 4]> = ours.iter().map(|color| color.map(i16::cast_unsigned)).collect();
        decode_filter_color(&mut theirs);
        nearly_the_same(&ours, &theirs);
    }
    let quaternions = unit_vectors(3);
    for bits in 4..=16 {
        let mut theirs = encode_filter_quat(&quaternions, bits);
        let ours = filtered_shorts(Filter::Quaternion, &theirs);
        decode_filter_quat(&mut theirs);
        nearly_the_same(&ours, &theirs);
    }
}

#[test]
fn floats_are_the_same_to_the_bit() {
    let mut number = numbers(4);
    let mut theirs: Vec<[u32; 1]> = (0..100_000)
        .map(|_| [((number(201) as i32 - 100) << 24 | number(1 << 24) as i32).cast_unsigned()])
        .collect();
    let vectors: Vec<[f32; 1]> = unit_vectors(5)
        .iter()
        .map(|vector| [vector[0] * 1000.0])
        .collect();
    for bits in 1..=24 {
        theirs.extend(encode_filter_exp(&vectors, bits, EncodeExpMode::Separate));
    }
    let mut ours = little_endian(theirs.iter().flatten().copied());
    filters::apply(Filter::Exponential, 4, &mut ours);
    decode_filter_exp(&mut theirs);
    assert!(ours == little_endian(theirs.into_iter().flatten()));
}
