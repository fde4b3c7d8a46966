//! Measures how fast this machine can read, change and write a buffer of floats.
//!
//! This bounds the rate at which a depth buffer can be updated, whatever else is computed. Each byte counts once,
//! though it is read and written. Uses the machine's best SIMD level, even if the rows are measured at a lower one,
//! because it is the ceiling of the machine.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16};
use std::hint::black_box;
use std::time::Instant;

/// A third of the L1 data cache of usual machines, and at most a quarter of the L2 cache.
const L1_BYTES: usize = 16 << 10;
const L2_BYTES: usize = 256 << 10;
/// Bytes processed per measurement, in repeated passes over the same buffer: about a millisecond.
const BYTES_PER_RUN: usize = 128 << 20;

/// The cache whose buffer is measured.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Ceiling {
    L1,
    L2,
}

/// The buffers, and their measurements so far, in GB/s.
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

    /// Measures both buffers once.
    pub(super) fn measure(&mut self) {
        for (buffer, measured) in self.buffers.iter_mut().zip(&mut self.measured) {
            let bytes = size_of_val(&buffer[..]);
            let passes = BYTES_PER_RUN / bytes;
            let start = Instant::now();
            dispatch!(Level::new(), simd => scale_all(simd, buffer, passes));
            measured.push((passes * bytes) as f64 / start.elapsed().as_secs_f64() / 1e9);
        }
    }

    /// Discards the measurements, after the warm-up of caches and clocks.
    pub(super) fn clear(&mut self) {
        self.measured.iter_mut().for_each(Vec::clear);
    }

    /// Returns the median of the measurements, in GB/s.
    pub(super) fn gb_s(&self, ceiling: Ceiling) -> f64 {
        crate::median(&self.measured[ceiling as usize])
    }
}

#[inline(always)]
fn scale_all<S: Simd>(simd: S, buffer: &mut [f32], passes: usize) {
    let factor = f32x16::splat(simd, black_box(1.000_000_1));
    for _ in 0..passes {
        // Four vectors per iteration, so that the loop overhead is negligible; both buffer sizes are multiples of that.
        // No closure, because code in a closure is not compiled for the SIMD level.
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
