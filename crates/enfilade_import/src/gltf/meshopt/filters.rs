//! Filters: decode unit vectors, quaternions, floats and colors from the integers that compress well.
//!
//! Each element stores its own precision: one of its numbers says how many bits the others have.
//! Source: KHR_meshopt_compression, appendix B.
//! Cost: O(elements), at most one square root and one division each.
//! Floats are exact; all else is within one unit of the last place, as the specification allows. No input panics.

use super::super::compressed::Filter;

/// Replaces decoded elements of `stride` bytes by the values that they encode.
pub(super) fn apply(filter: Filter, stride: usize, elements: &mut [u8]) {
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => bytes(elements, |vector| octahedral(vector, 127.0)),
        (Filter::Octahedral, _) => shorts(elements, |vector| octahedral(vector, 32767.0)),
        (Filter::Quaternion, _) => shorts(elements, quaternion),
        (Filter::Exponential, _) => {
            for number in elements.as_chunks_mut().0 {
                *number = exponential(i32::from_le_bytes(*number)).to_le_bytes();
            }
        }
        (Filter::Color, 4) => bytes(elements, |color| ycocg(color, 255)),
        (Filter::Color, _) => shorts(elements, |color| ycocg(color, 65535)),
    }
}

/// Maps elements of four 8-bit numbers: sign-extended on the way in, the low 8 bits on the way out.
fn bytes(elements: &mut [u8], decode: impl Fn([i32; 4]) -> [i32; 4]) {
    for element in elements.as_chunks_mut::<4>().0 {
        *element = decode(element.map(|part| part.cast_signed().into())).map(|part| part as u8);
    }
}

/// Maps elements of four 16-bit numbers: sign-extended on the way in, the low 16 bits on the way out.
fn shorts(elements: &mut [u8], decode: impl Fn([i32; 4]) -> [i32; 4]) {
    for element in elements.as_chunks_mut::<8>().0 {
        let parts = element.as_chunks_mut::<2>().0;
        let encoded = std::array::from_fn(|part| i16::from_le_bytes(parts[part]).into());
        for (part, decoded) in parts.iter_mut().zip(decode(encoded)) {
            *part = (decoded as i16).to_le_bytes();
        }
    }
}

/// A unit vector from its point on an octahedron that is unfolded to a square. The fourth number stays as it is.
///
/// `one` encodes 1.0; the result is scaled to `max`.
fn octahedral([x, y, one, fourth]: [i32; 4], max: f32) -> [i32; 4] {
    let [x, y, one] = [x, y, one].map(|part| part as f32);
    let z = one - x.abs() - y.abs();
    // The lower half of the octahedron is folded outwards over the corners of the square.
    let below = z.min(0.0);
    let [x, y] = [x, y].map(|part| part + below.copysign(-part));
    let scale = max / (x * x + y * y + z * z).sqrt();
    let [x, y, z] = [x, y, z].map(|part| round(part * scale));
    [x, y, z, fourth]
}

/// A unit quaternion from its three smaller components; the largest is positive, so the others determine it.
///
/// The fourth number encodes 1.0, but for its low two bits, which say which component is the largest.
fn quaternion([x, y, z, one_and_largest]: [i32; 4]) -> [i32; 4] {
    let one = (one_and_largest | 3) as f32;
    // No smaller component exceeds 1/√2: they are stored as multiples of that.
    let [x, y, z] = [x, y, z].map(|part| part as f32 / one * std::f32::consts::FRAC_1_SQRT_2);
    let largest = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut components = [largest, x, y, z].map(|part| round(part * 32767.0));
    components.rotate_right((one_and_largest & 3) as usize);
    components
}

/// A float from 24 bits of mantissa below 8 bits of exponent, both signed.
fn exponential(encoded: i32) -> f32 {
    let (exponent, mantissa) = (encoded >> 24, encoded << 8 >> 8);
    // In f64 every such number is exact, and its exponent never leaves the normal range.
    let power = f64::from_bits(u64::from((1023 + exponent).cast_unsigned()) << 52);
    (f64::from(mantissa) * power) as f32
}

/// Red, green, blue and alpha from luma, two chroma differences and alpha; white is `max`.
///
/// The highest bit of the fourth number says how many bits the others have; below it is alpha, with one bit less.
fn ycocg([luma, orange, green, alpha]: [i32; 4], max: i32) -> [i32; 4] {
    let (luma, alpha) = (luma & max, alpha & max);
    let white = u32::MAX
        .checked_shr(alpha.leading_zeros())
        .unwrap_or(0)
        .cast_signed();
    let alpha = (alpha << 1 & white) | (alpha & 1);
    let scale = max as f32 / white as f32;
    [luma + orange - green, luma + green, luma - orange - green, alpha].map(|part| round(part as f32 * scale))
}

/// The nearest integer, halves away from zero; 0 for NaN. Unlike `f32::round` no call where there is no instruction for it.
fn round(value: f32) -> i32 {
    (value + 0.5_f32.copysign(value)) as i32
}
