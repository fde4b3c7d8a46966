//! How fast this machine can go over a buffer of floats, reading, changing and writing each.
//!
//! It is the most that updating the state of a cover can come to, whatever is decided meanwhile. Each byte counts once,
//! though it goes both ways. The machine's best SIMD level is used, also where rows are measured at a lower one: it is the
//! machine's ceiling.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16};
use std::hint::black_box;
use std::time::Instant;

/// A third of the first-level data cache of usual machines, and a quarter of the second-level one or less.
const L1_BYTES: usize = 16 << 10;
const L2_BYTES: usize = 256 << 10;
/// What is gone over for one figure, again and again the same buffer: a millisecond or so.
const BYTES_A_RUN: usize = 128 << 20;

/// Which buffer.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Ceiling {
    L1,
    L2,
}

/// Buffers, and what was measured on them so far, in GB/s.
pub(super) struct Ceilings {
    buffers: [Vec<f32>; 2],
    measured: [Vec<f64>; 2],
}

impl Ceilings {
    pub(super) fn new() -> Ceilings {
        Ceilings {
            buffers: [L1_BYTES, L2_BYTES].map(|bytes| vec![1.0; bytes / size_of::<f32>()]),
            measured: [Vec::new(), Vec::new()],
        }
    }

    /// Measures both once.
    pub(super) fn measure(&mut self) {
        for (buffer, measured) in self.buffers.iter_mut().zip(&mut self.measured) {
            let bytes = size_of_val(&buffer[..]);
            let passes = BYTES_A_RUN / bytes;
            let start = Instant::now();
            dispatch!(Level::new(), simd => go_over(simd, buffer, passes));
            measured.push((passes * bytes) as f64 / start.elapsed().as_secs_f64() / 1e9);
        }
    }

    /// What was measured first is thrown away: caches and clocks had to settle.
    pub(super) fn forget(&mut self) {
        self.measured.iter_mut().for_each(Vec::clear);
    }

    /// The median, in GB/s.
    pub(super) fn gb_s(&self, ceiling: Ceiling) -> f64 {
        crate::measure::median(&self.measured[ceiling as usize])
    }
}

#[inline(always)]
fn go_over<S: Simd>(simd: S, buffer: &mut [f32], passes: usize) {
    let factor = f32x16::splat(simd, black_box(1.000_000_1));
    for _ in 0..passes {
        // Four at once, so that the loop itself takes no time: both buffers are a multiple of that. No closure: what runs in
        // one does not run at the SIMD level.
        for four in buffer.chunks_exact_mut(64) {
            let a = f32x16::from_slice(simd, &four[..16]) * factor;
            let b = f32x16::from_slice(simd, &four[16..32]) * factor;
            let c = f32x16::from_slice(simd, &four[32..48]) * factor;
            let d = f32x16::from_slice(simd, &four[48..]) * factor;
            a.store_slice(&mut four[..16]);
            b.store_slice(&mut four[16..32]);
            c.store_slice(&mut four[32..48]);
            d.store_slice(&mut four[48..]);
        }
        black_box(&mut *buffer);
    }
}
