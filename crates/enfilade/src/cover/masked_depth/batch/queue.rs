//! Queues of faces, so that the kernels get sixteen of a kind.
//!
//! Source: original to this library.
//! Cost: O(corners).
//! Exact: only copies.

use super::LANES;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u32x16};

/// Maximum number of queued faces; two more groups fit while they are being queued.
const MAX_QUEUED: usize = 128;
const ROOM: usize = MAX_QUEUED + 2 * LANES;

/// Faces waiting for setup: columns, rows and reversed depths of their corners, and their numbers.
pub(super) struct Queue<const SIDES: usize> {
    pub(super) count: usize,
    x: [[u32; ROOM]; SIDES],
    y: [[u32; ROOM]; SIDES],
    rev_depth: [[u32; ROOM]; SIDES],
    number: [u32; ROOM],
}

impl<const SIDES: usize> Default for Queue<SIDES> {
    fn default() -> Queue<SIDES> {
        Queue {
            count: 0,
            x: [[0; ROOM]; SIDES],
            y: [[0; ROOM]; SIDES],
            rev_depth: [[0; ROOM]; SIDES],
            number: [0; ROOM],
        }
    }
}

/// Up to sixteen faces, one per lane, with corners in units of fixed point.
pub(super) struct FaceLanes<S: Simd, const SIDES: usize> {
    pub(super) x: [i32x16<S>; SIDES],
    pub(super) y: [i32x16<S>; SIDES],
    pub(super) rev_depth: [f32x16<S>; SIDES],
    pub(super) number: u32x16<S>,
    /// Number of faces; the other lanes are undefined.
    pub(super) lanes: usize,
}

impl<const SIDES: usize> Queue<SIDES> {
    /// Returns `true` if the queue must be flushed before another group is queued.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.count + LANES > MAX_QUEUED
    }

    /// Returns the number of faces that still fit.
    pub(super) fn room(&self) -> usize {
        ROOM - self.count
    }

    /// Queues one face: column, row and reversed depth of each corner.
    pub(super) fn push_one(&mut self, corners: [[u32; 3]; SIDES], number: u32) {
        for (corner, [x, y, rev_depth]) in corners.into_iter().enumerate() {
            self.x[corner][self.count] = x;
            self.y[corner][self.count] = y;
            self.rev_depth[corner][self.count] = rev_depth;
        }
        self.number[self.count] = number;
        self.count += 1;
    }

    /// Queues the faces in the lanes `which`.
    #[inline(always)]
    pub(super) fn push<S: Simd>(&mut self, which: mask32x16<S>, faces: &FaceLanes<S, SIDES>) {
        let found = which.to_bitmask().count_ones() as usize;
        if found == 0 {
            return;
        }
        let start = self.count.min(ROOM - LANES);
        for corner in 0..SIDES {
            keep(which, faces.x[corner].bitcast(), &mut self.x[corner], start);
            keep(which, faces.y[corner].bitcast(), &mut self.y[corner], start);
            let kept = &mut self.rev_depth[corner];
            keep(which, faces.rev_depth[corner].bitcast(), kept, start);
        }
        keep(which, faces.number, &mut self.number, start);
        self.count = start + found;
    }

    /// Loads up to sixteen faces, starting at index `from`.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S, from: usize) -> FaceLanes<S, SIDES> {
        let start = from.min(ROOM - LANES);
        let mut faces = FaceLanes::none(simd);
        for corner in 0..SIDES {
            faces.x[corner] = get(simd, &self.x[corner], start).bitcast();
            faces.y[corner] = get(simd, &self.y[corner], start).bitcast();
            faces.rev_depth[corner] = get(simd, &self.rev_depth[corner], start).bitcast();
        }
        faces.number = get(simd, &self.number, start);
        faces.lanes = (self.count - from).min(LANES);
        faces
    }

    /// Removes the faces before index `place`; fewer than sixteen must remain.
    #[inline(always)]
    pub(super) fn discard_before(&mut self, place: usize) {
        if place == 0 {
            return;
        }
        let corners = self.x.iter_mut().chain(&mut self.y).chain(&mut self.rev_depth);
        for kept in corners {
            kept.copy_within(place..place + LANES, 0);
        }
        self.number.copy_within(place..place + LANES, 0);
        self.count -= place;
    }
}

#[inline(always)]
fn keep<S: Simd>(which: mask32x16<S>, field: u32x16<S>, kept: &mut [u32; ROOM], start: usize) {
    field.compress(which).store_slice(&mut kept[start..start + LANES]);
}

#[inline(always)]
fn get<S: Simd>(simd: S, kept: &[u32; ROOM], start: usize) -> u32x16<S> {
    u32x16::from_slice(simd, &kept[start..start + LANES])
}

impl<S: Simd, const SIDES: usize> FaceLanes<S, SIDES> {
    #[inline(always)]
    pub(super) fn none(simd: S) -> FaceLanes<S, SIDES> {
        FaceLanes {
            x: [i32x16::splat(simd, 0); SIDES],
            y: [i32x16::splat(simd, 0); SIDES],
            rev_depth: [f32x16::splat(simd, 0.0); SIDES],
            number: u32x16::splat(simd, 0),
            lanes: 0,
        }
    }
}

impl<S: Simd> FaceLanes<S, 4> {
    /// Returns one triangle of each quad: its first corner and two adjacent ones.
    #[inline(always)]
    pub(super) fn half(&self, [a, b]: [usize; 2]) -> FaceLanes<S, 3> {
        FaceLanes {
            x: [self.x[0], self.x[a], self.x[b]],
            y: [self.y[0], self.y[a], self.y[b]],
            rev_depth: [self.rev_depth[0], self.rev_depth[a], self.rev_depth[b]],
            number: self.number,
            lanes: self.lanes,
        }
    }
}
