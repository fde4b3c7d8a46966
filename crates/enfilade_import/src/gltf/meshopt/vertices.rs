//! Decodes vertex attributes: up to 256 bytes per element, of any types.
//!
//! Blocks of up to 256 elements store each byte of the element separately, as deltas from the element before, in groups of 16
//! with 0, 1, 2, 4 or 8 bits per delta; a delta that needs more bits follows its group as a whole byte.
//! Source: KHR_meshopt_compression, appendix A, mode 0, versions 0 and 1.
//! Cost: O(decoded bytes): 16 deltas at a time without branches, 4 bytes of an element added in one word.
//! Checks the shortest possible stream before it allocates: decoded bytes are at most 1,024 times the encoded ones.

use super::{Damage, Stream};

const VERTICES: u8 = 0xa0;
const GROUP: usize = 16;
const MAX_BLOCK_ELEMENTS: usize = 256;
const MAX_BLOCK_BYTES: usize = 8192;

/// The deltas of one byte of the element in a block.
type Plane = [u8; MAX_BLOCK_ELEMENTS];

/// Decodes `count` elements of `stride` bytes, a multiple of 4 up to 256.
pub(super) fn decode(encoded: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Damage> {
    let channels = stride / 4;
    let (version, mut stream, tail) = Stream::open(encoded, VERTICES, |version| match version {
        0 => stride.max(32),
        _ => (stride + channels).max(24),
    })?;
    // The padding of the tail is at its front. Version 0 has no channel modes.
    let (first, channel_modes) = match version {
        0 => tail[tail.len() - stride..].split_at(stride),
        _ => tail[tail.len() - stride - channels..].split_at(stride),
    };
    let block_elements = (MAX_BLOCK_BYTES / stride / GROUP * GROUP).min(MAX_BLOCK_ELEMENTS);
    // In each block each byte of the element takes at least two bits, the control; in version 0 a byte, the header.
    let shortest = count.div_ceil(block_elements) * if version == 0 { stride } else { channels };
    if stream.0.len() < shortest {
        return Err(Damage::TooShort);
    }

    let deltas: Vec<Deltas> = match version {
        0 => vec![Deltas::BYTES; channels],
        _ => channel_modes
            .iter()
            .map(|&mode| Deltas::new(mode))
            .collect::<Result<_, _>>()?,
    };
    let first = first.as_chunks().0.iter();
    let mut last: Vec<u32> = first.map(|&word| u32::from_le_bytes(word)).collect();
    let mut decoded = vec![0; count * stride];
    let mut planes = [[0; MAX_BLOCK_ELEMENTS]; 4];
    for block in decoded.chunks_mut(block_elements * stride) {
        let elements = block.len() / stride;
        // Version 0 has no controls.
        let controls = stream.take(if version == 0 { 0 } else { channels })?;
        for channel in 0..channels {
            for (byte, plane) in planes.iter_mut().enumerate() {
                let widths = match controls.get(channel).map(|controls| (controls >> (2 * byte)) & 3) {
                    None => Some([0, 2, 4, 8]),
                    Some(0) => Some([0, 1, 2, 4]),
                    Some(1) => Some([1, 2, 4, 8]),
                    Some(2) => {
                        plane.fill(0);
                        continue;
                    }
                    Some(_) => None,
                };
                match widths {
                    Some(widths) => read_groups(&mut stream, widths, elements, plane)?,
                    None => plane[..elements].copy_from_slice(stream.take(elements)?),
                }
            }
            deltas[channel].sum(&planes, &mut last[channel], channel, stride, block);
        }
    }
    stream.finish()?;
    Ok(decoded)
}

/// Reads the deltas of one byte of `elements` elements. Two header bits per group choose its width in bits.
fn read_groups(
    stream: &mut Stream,
    widths: [u8; 4],
    elements: usize,
    plane: &mut Plane,
) -> Result<(), Damage> {
    let groups = elements.div_ceil(GROUP);
    let headers = stream.take(groups.div_ceil(4))?;
    for (number, group) in plane.as_chunks_mut().0.iter_mut().take(groups).enumerate() {
        let header = headers[number / 4] >> (number % 4 * 2);
        match widths[usize::from(header & 3)] {
            0 => group.fill(0),
            1 => read_group::<1>(stream, group)?,
            2 => read_group::<2>(stream, group)?,
            4 => read_group::<4>(stream, group)?,
            _ => group.copy_from_slice(stream.take(GROUP)?),
        }
    }
    Ok(())
}

/// Reads 16 deltas of `WIDTH` bits. One with all bits set is a sentinel: its value is the next of the bytes that follow.
pub(super) fn read_group<const WIDTH: usize>(
    stream: &mut Stream,
    group: &mut [u8; GROUP],
) -> Result<(), Damage> {
    let packed = stream.take(GROUP * WIDTH / 8)?;
    let mut follow = [0; GROUP];
    // At most 16 bytes follow. The loop counts how many; then `take` checks that the stream has them.
    match stream.0.first_chunk() {
        Some(bytes) => follow = *bytes,
        None => follow[..stream.0.len()].copy_from_slice(stream.0),
    }
    let all_set = (1 << WIDTH) - 1;
    let mut followed = 0;
    for (number, delta) in group.iter_mut().enumerate() {
        let bit = number * WIDTH;
        // Deltas of one bit begin at the lowest bit of a byte, all others at the highest.
        let shift = if WIDTH == 1 { bit % 8 } else { 8 - WIDTH - bit % 8 };
        let short = (packed[bit / 8] >> shift) & all_set;
        let is_long = short == all_set;
        *delta = if is_long { follow[followed % GROUP] } else { short };
        followed += usize::from(is_long);
    }
    stream.take(followed)?;
    Ok(())
}

/// The kind of the deltas in a channel, which is four bytes of the element.
#[derive(Clone, Copy)]
enum Deltas {
    /// Zigzag numbers to add, in lanes of `width` bits; `ones` has the lowest bit of each lane set.
    Lanes { ones: u32, width: u32 },
    /// Bits that change, rotated left by so many.
    Xor(u32),
}

impl Deltas {
    const BYTES: Deltas = Deltas::Lanes {
        ones: 0x0101_0101,
        width: 8,
    };
    const SHORTS: Deltas = Deltas::Lanes {
        ones: 0x0001_0001,
        width: 16,
    };

    fn new(mode: u8) -> Result<Deltas, Damage> {
        match (mode & 15, mode >> 4) {
            (0, 0) => Ok(Deltas::BYTES),
            (1, 0) => Ok(Deltas::SHORTS),
            (2, rotation) => Ok(Deltas::Xor(rotation.into())),
            _ => Err(Damage::ChannelMode(mode)),
        }
    }

    /// Adds up the deltas in `planes`, from `last` of the element before the block, and writes a channel of the block.
    fn sum(self, planes: &[Plane; 4], last: &mut u32, channel: usize, stride: usize, block: &mut [u8]) {
        let words = channel_words(channel, stride, block);
        match self {
            Deltas::Lanes { ones, width } => {
                let (full, high) = ((1 << width) - 1, ones << (width - 1));
                accumulate(planes, last, words, |value, zigzag| {
                    let delta = ((zigzag >> 1) & !high) ^ ((zigzag & ones) * full);
                    // The highest bit of each lane is added by XOR, so that nothing carries into the next lane.
                    ((value & !high) + (delta & !high)) ^ ((value ^ delta) & high)
                });
            }
            Deltas::Xor(rotation) => {
                accumulate(planes, last, words, |value, bits| {
                    value ^ bits.rotate_right(rotation)
                });
            }
        }
    }
}

/// The four bytes of a channel in each element of a block.
fn channel_words(channel: usize, stride: usize, block: &mut [u8]) -> impl Iterator<Item = &mut [u8]> {
    block
        .chunks_exact_mut(stride)
        .map(move |element| &mut element[4 * channel..][..4])
}

/// Writes the running result of `add` over the deltas of a channel, starting from `last`.
fn accumulate<'a>(
    [p, q, r, s]: &[Plane; 4],
    last: &mut u32,
    words: impl Iterator<Item = &'a mut [u8]>,
    add: impl Fn(u32, u32) -> u32,
) {
    for (number, word) in words.take(MAX_BLOCK_ELEMENTS).enumerate() {
        *last = add(
            *last,
            u32::from_le_bytes([p[number], q[number], r[number], s[number]]),
        );
        word.copy_from_slice(&last.to_le_bytes());
    }
}
