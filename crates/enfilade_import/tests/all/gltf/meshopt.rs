//! An encoder of EXT_meshopt_compression that compresses nothing: every difference is stored in full.

const GROUP: usize = 16;

/// Encodes elements of `stride` bytes.
pub(crate) fn vertices(elements: &[u8], stride: usize) -> Vec<u8> {
    let mut encoded = vec![0xa0];
    let mut last = vec![0; stride];
    let block_elements = (8192 / stride / GROUP * GROUP).min(256);
    for block in elements.chunks(block_elements * stride) {
        let groups = (block.len() / stride).div_ceil(GROUP);
        for (byte, last) in last.iter_mut().enumerate() {
            // Each group has eight bits per difference.
            encoded.resize(encoded.len() + groups.div_ceil(4), 0xff);
            let end = encoded.len() + groups * GROUP;
            for element in block.chunks(stride) {
                let difference = element[byte].wrapping_sub(*last).cast_signed();
                encoded.push(((difference << 1) ^ (difference >> 7)).cast_unsigned());
                *last = element[byte];
            }
            encoded.resize(end, 0);
        }
    }
    // The element before the first: all zeros, as the padding is.
    encoded.resize(encoded.len() + stride.max(32), 0);
    encoded
}

/// Encodes triangles, each with three stored indices.
pub(crate) fn triangles(indices: &[u32]) -> Vec<u8> {
    let mut encoded = vec![0xe1];
    encoded.resize(1 + indices.len() / 3, 0xff);
    let mut last = 0;
    for triangle in indices.chunks(3) {
        encoded.push(0xff);
        for &index in triangle {
            number(&mut encoded, zigzag(index, &mut last));
        }
    }
    encoded.extend([0; 16]);
    encoded
}

/// Encodes any indices, each by its difference from the one before.
pub(crate) fn sequence(indices: &[u32]) -> Vec<u8> {
    let mut encoded = vec![0xd1];
    let mut last = 0;
    for &index in indices {
        number(&mut encoded, zigzag(index, &mut last) << 1);
    }
    encoded.extend([0; 4]);
    encoded
}

fn zigzag(index: u32, last: &mut u32) -> u32 {
    let difference = index.wrapping_sub(*last).cast_signed();
    *last = index;
    ((difference << 1) ^ (difference >> 31)).cast_unsigned()
}

/// Appends a number as LEB128.
fn number(encoded: &mut Vec<u8>, mut number: u32) {
    while number >= 0x80 {
        encoded.push(number as u8 | 0x80);
        number >>= 7;
    }
    encoded.push(number as u8);
}
