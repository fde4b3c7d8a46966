//! Which faces are worth setting up: sixteen at a time, and the others are left in a few cycles each.
//!
//! Left out are faces seen from behind and those that no sample's centre can be in. Small quads that are surely convex on the
//! screen wait as such, all others as two triangles.
//! Source: back-face and small-face rejection as in Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion
//!     Culling, HPG 2016, section 4; leaving out only what is surely outside is ours, and so are quads.
//! Cost: O(faces).
//! Exact: what is not certain within a unit of fixed point goes to f64.

use super::clip::clip;
use super::corners::{Block, Corners, MAX_CORNERS};
use super::queue::{Queue, Sixteen};
use super::{COUNT, Frame, HALF, LANES, ONE, ONE_SHIFT, Shapes};
use crate::cover::part::Part;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u32x4, u32x16};

/// Up to sixteen faces that are looked at together.
pub(super) struct Group<'a, const SIDES: usize> {
    /// Corners, as places counted from `first_position`.
    pub(super) corners: &'a [[u32; SIDES]; LANES],
    pub(super) first_position: u32,
    /// The number of the first face.
    pub(super) first: u32,
    /// How many there are.
    pub(super) lanes: usize,
}

/// Sixteen faces as they are on the screen.
pub(super) struct Found<S: Simd, const SIDES: usize> {
    faces: Sixteen<S, SIDES>,
    /// Those that have all corners on the screen.
    sound: mask32x16<S>,
    /// A bit for each of which a corner is odd, but that may be seen.
    pub(super) odd: u64,
}

impl<'a, const SIDES: usize> Group<'a, SIDES> {
    /// Of some of the shapes' faces, of which the first has the number `first`; `last` is room for a group that is not full.
    #[inline(always)]
    pub(super) fn new(
        shapes: &Shapes,
        faces: &'a [[u32; SIDES]],
        group: usize,
        first: usize,
        last: &'a mut [[u32; SIDES]; LANES],
    ) -> Group<'a, SIDES> {
        let faces = &faces[group * LANES..];
        let corners = if let Some(corners) = faces.first_chunk() {
            corners
        } else {
            last[..faces.len()].copy_from_slice(faces);
            last
        };
        Group {
            corners,
            first_position: shapes.first_position,
            first: (first + group * LANES) as u32,
            lanes: faces.len().min(LANES),
        }
    }

    /// Finds them on the screen.
    #[inline(always)]
    pub(super) fn find<S: Simd>(&self, simd: S, corners: &Corners) -> Found<S, SIDES> {
        let mut faces = Sixteen::none(simd);
        let mut beyond = u32x16::splat(simd, u32::MAX);
        let mut least = f32x16::splat(simd, f32::INFINITY);
        for corner in 0..SIDES {
            let [x, y, rev_depth, outside] = self.gather(simd, corners, corner);
            faces.x[corner] = x.bitcast();
            faces.y[corner] = y.bitcast();
            faces.rev_depth[corner] = rev_depth.bitcast();
            least = least.min(faces.rev_depth[corner]);
            beyond &= outside;
        }
        faces.number = u32x16::from_slice(simd, &COUNT) + self.first;
        faces.lanes = self.lanes;
        let there: mask32x16<S> = mask32x16::from_bitmask(simd, (1_u64 << self.lanes) - 1);
        let within = there & beyond.simd_eq(u32x16::splat(simd, 0));
        let sound = within & least.simd_gt(f32x16::splat(simd, 0.0));
        Found {
            faces,
            sound,
            odd: (within & !sound).to_bitmask(),
        }
    }

    /// What is known of one corner of each face.
    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, corners: &Corners, which: usize) -> [u32x16<S>; 4] {
        let mut quarters = [u32x16::splat(simd, 0); 4];
        for (quarter, four) in quarters.iter_mut().zip(self.corners.as_chunks::<4>().0) {
            // A remainder instead of a check that would have to be made, and stand, before every load.
            let at = |corner: u32| (corner - self.first_position) as usize % MAX_CORNERS;
            let a = u32x4::simd_from(simd, corners.0[at(four[0][which])]);
            let b = u32x4::simd_from(simd, corners.0[at(four[1][which])]);
            let c = u32x4::simd_from(simd, corners.0[at(four[2][which])]);
            let d = u32x4::simd_from(simd, corners.0[at(four[3][which])]);
            *quarter = a.combine(b).combine(c.combine(d));
        }
        let [a, b, c, d] = quarters;
        let [even, odd] = [a.unzip_low(b), a.unzip_high(b)];
        let [even_above, odd_above] = [c.unzip_low(d), c.unzip_high(d)];
        [
            even.unzip_low(even_above),
            odd.unzip_low(odd_above),
            even.unzip_high(even_above),
            odd.unzip_high(odd_above),
        ]
    }
}

/// Queues, and what goes to f64.
#[derive(Default)]
pub(super) struct Queues {
    /// Triangles of up to 31 columns and rows, counted from the sub-tile they begin in.
    pub(super) small: Queue<3>,
    pub(super) wide: Queue<3>,
    /// Quads as small, and convex on the screen.
    pub(super) quads: Queue<4>,
    /// What is left of triangles that were cut, to be let in.
    pub(super) clipped: Queue<3>,
    /// Numbers of faces that are not certain.
    pub(super) uncertain: Vec<u32>,
}

/// The most columns and rows of a small face.
const SMALL: i32 = 31;

impl Queues {
    /// Must what waits be worked off before a group is let in?
    #[inline(always)]
    pub(super) fn are_full(&self) -> bool {
        self.small.is_full() || self.wide.is_full() || self.quads.is_full()
    }

    /// Cuts the faces of a group that have an odd corner.
    pub(super) fn clip<const SIDES: usize>(
        &mut self,
        frame: &Frame,
        positions: &[Block],
        group: &Group<SIDES>,
        mut odd: u64,
        part: &mut Part,
    ) {
        while odd != 0 {
            let lane = odd.trailing_zeros();
            odd &= odd - 1;
            let at = group.corners[lane as usize].map(|corner| {
                let corner = (corner - group.first_position) as usize;
                positions[corner / LANES].map(|axis| axis[corner % LANES])
            });
            let number = group.first + lane;
            for last in 2..SIDES {
                let three = [at[0], at[last - 1], at[last]];
                if !clip(frame, three, number, part, &mut self.clipped) {
                    self.uncertain.push(number);
                    break;
                }
            }
        }
    }

    /// Lets in up to sixteen of what is left of those that were cut.
    #[inline(always)]
    pub(super) fn let_in_clipped<S: Simd>(&mut self, simd: S, frame: &Frame) {
        let from = self.clipped.count - self.clipped.count.min(LANES);
        let faces = self.clipped.sixteen(simd, from);
        let sound = mask32x16::from_bitmask(simd, (1_u64 << faces.lanes) - 1);
        self.sort_triangles(simd, frame, &faces, sound);
        self.clipped.count = from;
    }

    #[inline(always)]
    pub(super) fn let_in_triangles<S: Simd>(&mut self, simd: S, frame: &Frame, found: &Found<S, 3>) {
        self.sort_triangles(simd, frame, &found.faces, found.sound);
    }

    /// Lets quads in that are worth setting up.
    #[inline(always)]
    pub(super) fn let_in_quads<S: Simd>(&mut self, simd: S, frame: &Frame, found: &Found<S, 4>) {
        let quads = &found.faces;
        let extent = Extent::new(simd, frame, &quads.x, &quads.y);
        let [mut dx, mut dy] = [[f32x16::splat(simd, 0.0); 4]; 2];
        for corner in 0..4 {
            let next = (corner + 1) % 4;
            dx[corner] = (quads.x[next] - quads.x[corner]).to_float();
            dy[corner] = (quads.y[next] - quads.y[corner]).to_float();
        }
        // Which way round the triangle of each corner and its neighbours goes.
        let [mut all_left, mut all_right] = [mask32x16::splat(simd, true); 2];
        let mut behind = all_left;
        for corner in 0..4 {
            let next = (corner + 1) % 4;
            let turn = Turn::new(simd, [dx[corner], dx[next]], [dy[corner], dy[next]]);
            all_left &= turn.left;
            all_right &= turn.right;
            // These two are its halves.
            if corner % 2 == 0 {
                behind &= turn.is_behind(simd, frame);
            }
        }
        let seen = found.sound & extent.any & !behind;
        let small = seen & extent.small & (all_left | all_right);
        self.quads.push(small, quads);
        let others = seen & !small;
        if others.any_true() {
            self.sort_triangles(simd, frame, &quads.half([1, 2]), others);
            self.sort_triangles(simd, frame, &quads.half([2, 3]), others);
        }
    }

    /// Lets those triangles in that are worth setting up.
    #[inline(always)]
    fn sort_triangles<S: Simd>(
        &mut self,
        simd: S,
        frame: &Frame,
        faces: &Sixteen<S, 3>,
        sound: mask32x16<S>,
    ) {
        let Sixteen { x, y, number, .. } = faces;
        let extent = Extent::new(simd, frame, x, y);
        let dx = [(x[1] - x[0]).to_float(), (x[2] - x[0]).to_float()];
        let dy = [(y[1] - y[0]).to_float(), (y[2] - y[0]).to_float()];
        let turn = Turn::new(simd, dx, dy);
        let seen = sound & extent.any & !turn.is_behind(simd, frame);
        let sure = seen & (turn.left | turn.right);
        self.small.push(sure & extent.small, faces);
        self.wide.push(sure & !extent.small, faces);
        let mut left = (seen & !sure).to_bitmask();
        if left != 0 {
            let numbers = number.to_array();
            while left != 0 {
                self.uncertain
                    .push(numbers[left.trailing_zeros() as usize % LANES]);
                left &= left - 1;
            }
        }
    }
}

/// Which faces reach over samples at all, and which over few columns and rows.
struct Extent<S: Simd> {
    any: mask32x16<S>,
    small: mask32x16<S>,
}

impl<S: Simd> Extent<S> {
    #[inline(always)]
    fn new<const SIDES: usize>(
        simd: S,
        frame: &Frame,
        x: &[i32x16<S>; SIDES],
        y: &[i32x16<S>; SIDES],
    ) -> Extent<S> {
        let columns = Samples::between(simd, x, frame.columns);
        let rows = Samples::between(simd, y, frame.rows);
        Extent {
            any: columns.end.simd_gt(columns.first) & rows.end.simd_gt(rows.first),
            small: (columns.end - (columns.first & !7)).simd_le(SMALL)
                & (rows.end - (rows.first & !3)).simd_le(SMALL),
        }
    }
}

/// Which way round triangles surely go.
struct Turn<S: Simd> {
    left: mask32x16<S>,
    right: mask32x16<S>,
}

impl<S: Simd> Turn<S> {
    /// By two of its sides.
    #[inline(always)]
    fn new(simd: S, dx: [f32x16<S>; 2], dy: [f32x16<S>; 2]) -> Turn<S> {
        let [one, other] = [dx[0] * dy[1], dx[1] * dy[0]];
        let area = one - other;
        // What f32 rounds, and what moving corners by a unit does.
        let slack = (one.abs() + other.abs()) * EXACTNESS
            + (dx[0].abs() + dx[1].abs() + dy[0].abs() + dy[1].abs()) * 4.0
            + f32x16::splat(simd, 16.0);
        Turn {
            left: area.simd_gt(slack),
            right: area.simd_lt(-slack),
        }
    }

    /// Are they surely seen from behind?
    #[inline(always)]
    fn is_behind(&self, simd: S, frame: &Frame) -> mask32x16<S> {
        if frame.front > 0.0 {
            self.right
        } else if frame.front < 0.0 {
            self.left
        } else {
            mask32x16::splat(simd, false)
        }
    }
}

/// What two products and their difference may be off by in f32, relatively, and ample.
pub(super) const EXACTNESS: f32 = 1.0 / (1_u32 << 21) as f32;

/// The samples between the least and the greatest of some places on an axis.
pub(super) struct Samples<S: Simd> {
    /// The first that may be between them and the one after the last, from the middle, within the limits.
    pub(super) first: i32x16<S>,
    pub(super) end: i32x16<S>,
    /// Is it certain which they are, but for the limits?
    pub(super) sure: mask32x16<S>,
}

impl<S: Simd> Samples<S> {
    #[inline(always)]
    pub(super) fn between<const SIDES: usize>(
        simd: S,
        places: &[i32x16<S>; SIDES],
        limits: [i32; 2],
    ) -> Samples<S> {
        let [mut least, mut greatest] = [places[0]; 2];
        for &place in &places[1..] {
            least = least.min(place);
            greatest = greatest.max(place);
        }
        // A unit more on each side: places are rounded.
        let first = (least + (ONE - 1 - HALF - 1)) >> ONE_SHIFT;
        let last = (greatest + (1 - HALF)) >> ONE_SHIFT;
        // And a unit less.
        let sure = first.simd_eq((least + (ONE - 1 - HALF + 1)) >> ONE_SHIFT)
            & last.simd_eq((greatest + (-1 - HALF)) >> ONE_SHIFT);
        Samples {
            first: first.max(i32x16::splat(simd, limits[0])),
            end: (last + 1).min(i32x16::splat(simd, limits[1])),
            sure,
        }
    }
}
