//! Which triangles are worth setting up: sixteen at a time, and the others are left in a few cycles each.
//!
//! Left out are triangles seen from behind and those that no sample's centre can be in; the rest wait in queues until
//! there are sixteen of a kind.
//! Source: back-face and small-face rejection as in Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion
//!     Culling, HPG 2016, section 4; leaving out only what is surely outside is ours.
//! Cost: O(triangles).
//! Exact: what is not certain within a unit of fixed point goes to f64.

use super::clip::clip;
use super::corners::{Block, Corners, MOST_CORNERS};
use super::{Frame, HALF, LANES, ONE, ONE_SHIFT};
use crate::cover::part::Part;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u32x4, u32x16};

/// How many triangles a queue may hold, besides a group that is being let in.
const MOST: usize = 128;

/// What is kept of a triangle: columns, rows and nearness of its corners, and its number.
pub(super) const FIELDS: usize = 10;

/// Triangles that wait to be set up.
pub(super) struct Queue {
    pub(super) count: usize,
    pub(super) fields: [[u32; MOST + LANES]; FIELDS],
}

impl Default for Queue {
    fn default() -> Queue {
        Queue {
            count: 0,
            fields: [[0; MOST + LANES]; FIELDS],
        }
    }
}

impl Queue {
    /// Must what waits be worked off before a group is let in?
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.count + LANES > MOST
    }

    /// How many there is room for.
    pub(super) fn room(&self) -> usize {
        MOST + LANES - self.count
    }

    /// Lets one triangle wait: column, row and nearness of its corners.
    pub(super) fn push_one(&mut self, corners: [[u32; 3]; 3], number: u32) {
        for (corner, fields) in corners.into_iter().enumerate() {
            for (kind, field) in fields.into_iter().enumerate() {
                self.fields[3 * kind + corner][self.count] = field;
            }
        }
        self.fields[FIELDS - 1][self.count] = number;
        self.count += 1;
    }

    #[inline(always)]
    fn push<S: Simd>(&mut self, which: mask32x16<S>, fields: &[u32x16<S>; FIELDS]) {
        let start = self.count.min(MOST);
        for (field, kept) in fields.iter().zip(&mut self.fields) {
            field.compress(which).store_slice(&mut kept[start..start + LANES]);
        }
        self.count = start + which.to_bitmask().count_ones() as usize;
    }

    /// Sixteen from a place on.
    #[inline(always)]
    pub(super) fn sixteen<S: Simd>(&self, simd: S, from: usize) -> Sixteen<S> {
        let fields = self.fields(simd, from);
        let lanes = (self.count - from).min(LANES);
        Sixteen {
            x: [fields[0].bitcast(), fields[1].bitcast(), fields[2].bitcast()],
            y: [fields[3].bitcast(), fields[4].bitcast(), fields[5].bitcast()],
            nearness: [fields[6].bitcast(), fields[7].bitcast(), fields[8].bitcast()],
            number: fields[9],
            lanes,
        }
    }

    /// What is kept of sixteen from a place on.
    #[inline(always)]
    fn fields<S: Simd>(&self, simd: S, from: usize) -> [u32x16<S>; FIELDS] {
        let from = from.min(MOST);
        let mut fields = [u32x16::splat(simd, 0); FIELDS];
        for (field, kept) in fields.iter_mut().zip(&self.fields) {
            *field = u32x16::from_slice(simd, &kept[from..from + LANES]);
        }
        fields
    }

    /// Keeps only those from a place on.
    #[inline(always)]
    pub(super) fn forget_before(&mut self, place: usize) {
        for kept in &mut self.fields {
            kept.copy_within(place..place + LANES, 0);
        }
        self.count -= place;
    }
}

/// Up to sixteen triangles, their corners in units.
pub(super) struct Sixteen<S: Simd> {
    pub(super) x: [i32x16<S>; 3],
    pub(super) y: [i32x16<S>; 3],
    pub(super) nearness: [f32x16<S>; 3],
    pub(super) number: u32x16<S>,
    /// How many there are: the lanes after these are of no meaning.
    pub(super) lanes: usize,
}

/// Up to sixteen triangles that are looked at together.
pub(super) struct Group<'a> {
    /// Three corners each, as places counted from `first_position`.
    pub(super) corners: &'a [u32; 3 * LANES],
    pub(super) first_position: u32,
    /// The number of the first triangle.
    pub(super) first: u32,
    /// How many there are.
    pub(super) lanes: usize,
}

impl Group<'_> {
    /// The fields of one corner of each triangle.
    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, corners: &Corners, which: usize) -> [u32x16<S>; 4] {
        let mut quarters = [u32x16::splat(simd, 0); 4];
        for (quarter, four) in quarters.iter_mut().zip(self.corners.as_chunks::<12>().0) {
            // A remainder instead of a check that would have to be made, and stand, before every load.
            let at = |corner: u32| (corner - self.first_position) as usize % MOST_CORNERS;
            let a = u32x4::simd_from(simd, corners.0[at(four[which])]);
            let b = u32x4::simd_from(simd, corners.0[at(four[3 + which])]);
            let c = u32x4::simd_from(simd, corners.0[at(four[6 + which])]);
            let d = u32x4::simd_from(simd, corners.0[at(four[9 + which])]);
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
    /// Up to 31 columns and 32 rows, counted from the sub-tile they begin in.
    pub(super) small: Queue,
    pub(super) wide: Queue,
    /// What is left of triangles that were cut, to be let in.
    pub(super) clipped: Queue,
    /// Numbers of triangles that are not certain.
    pub(super) uncertain: Vec<u32>,
}

/// The most columns of a small triangle.
const SMALL: i32 = 31;

impl Queues {
    /// Lets in triangles; gives a bit for each of which a corner is odd.
    #[inline(always)]
    pub(super) fn let_in<S: Simd>(
        &mut self,
        simd: S,
        frame: &Frame,
        corners: &Corners,
        group: &Group,
    ) -> u64 {
        let a = group.gather(simd, corners, 0);
        let b = group.gather(simd, corners, 1);
        let c = group.gather(simd, corners, 2);
        let within = (a[3] & b[3] & c[3]).simd_eq(u32x16::splat(simd, 0));
        let there: mask32x16<S> = mask32x16::from_bitmask(simd, (1_u64 << group.lanes) - 1) & within;
        let zero = f32x16::splat(simd, 0.0);
        let nearness: [f32x16<S>; 3] = [a[2].bitcast(), b[2].bitcast(), c[2].bitcast()];
        let sound = nearness[0].min(nearness[1]).min(nearness[2]).simd_gt(zero) & there;
        let number = u32x16::from_slice(simd, &COUNT) + group.first;
        let fields = [a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2], number];
        self.sort_in(simd, frame, &fields, sound);
        (there & !sound).to_bitmask()
    }

    /// Cuts the triangles of a group that have an odd corner.
    pub(super) fn clip(
        &mut self,
        frame: &Frame,
        positions: &[Block],
        group: &Group,
        mut odd: u64,
        part: &mut Part,
    ) {
        while odd != 0 {
            let lane = odd.trailing_zeros();
            odd &= odd - 1;
            let at = [0, 1, 2].map(|corner| {
                let corner = group.corners[3 * lane as usize + corner] - group.first_position;
                positions[corner as usize / LANES].map(|axis| axis[corner as usize % LANES])
            });
            let number = group.first + lane;
            if !clip(frame, at, number, part, &mut self.clipped) {
                self.uncertain.push(number);
            }
        }
    }

    /// Lets in up to sixteen of what is left of those that were cut.
    #[inline(always)]
    pub(super) fn let_in_clipped<S: Simd>(&mut self, simd: S, frame: &Frame) {
        let lanes = self.clipped.count.min(LANES);
        let from = self.clipped.count - lanes;
        let fields = self.clipped.fields(simd, from);
        let there = mask32x16::from_bitmask(simd, (1_u64 << lanes) - 1);
        self.sort_in(simd, frame, &fields, there);
        self.clipped.count = from;
    }

    /// Lets those in that are worth setting up.
    #[inline(always)]
    fn sort_in<S: Simd>(
        &mut self,
        simd: S,
        frame: &Frame,
        fields: &[u32x16<S>; FIELDS],
        sound: mask32x16<S>,
    ) {
        let x: [i32x16<S>; 3] = [fields[0].bitcast(), fields[1].bitcast(), fields[2].bitcast()];
        let y: [i32x16<S>; 3] = [fields[3].bitcast(), fields[4].bitcast(), fields[5].bitcast()];
        let columns = Samples::between(simd, &x, frame.columns);
        let rows = Samples::between(simd, &y, frame.rows);
        let any = columns.end.simd_gt(columns.first) & rows.end.simd_gt(rows.first);

        let [dx1, dx2] = [(x[1] - x[0]).to_float::<f32x16<S>>(), (x[2] - x[0]).to_float()];
        let [dy1, dy2] = [(y[1] - y[0]).to_float::<f32x16<S>>(), (y[2] - y[0]).to_float()];
        let [one, other] = [dx1 * dy2, dx2 * dy1];
        let area = one - other;
        // What f32 rounds, and what moving corners by a unit does.
        let slack = (one.abs() + other.abs()) * EXACTNESS
            + (dx1.abs() + dx2.abs() + dy1.abs() + dy2.abs()) * 4.0
            + 16.0;
        let certain = area.abs().simd_gt(slack);
        let turned = (area * frame.front).simd_lt(f32x16::splat(simd, 0.0));
        let seen = sound & any & !(certain & turned);
        let sure = seen & certain;
        let small = sure
            & (columns.end - (columns.first & !7)).simd_le(SMALL)
            & (rows.end - (rows.first & !3)).simd_le(SMALL);
        let wide = sure & !small;
        if small.any_true() {
            self.small.push(small, fields);
        }
        if wide.any_true() {
            self.wide.push(wide, fields);
        }
        let mut left = (seen & !sure).to_bitmask();
        if left != 0 {
            let numbers = fields[FIELDS - 1].to_array();
            while left != 0 {
                self.uncertain
                    .push(numbers[left.trailing_zeros() as usize % LANES]);
                left &= left - 1;
            }
        }
    }
}

/// What two products and their difference may be off by in f32, relatively, and ample.
pub(super) const EXACTNESS: f32 = 1.0 / (1_u32 << 21) as f32;

pub(super) const COUNT: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// The samples between the least and the greatest of three places on an axis.
pub(super) struct Samples<S: Simd> {
    /// The first that may be between them and the one after the last, from the middle, within the limits.
    pub(super) first: i32x16<S>,
    pub(super) end: i32x16<S>,
}

impl<S: Simd> Samples<S> {
    #[inline(always)]
    pub(super) fn between(simd: S, places: &[i32x16<S>; 3], limits: [i32; 2]) -> Samples<S> {
        let least = places[0].min(places[1]).min(places[2]);
        let greatest = places[0].max(places[1]).max(places[2]);
        // A unit more on each side: places are rounded.
        let first = (least + (ONE - 1 - HALF - 1)) >> ONE_SHIFT;
        let end = ((greatest + (1 - HALF)) >> ONE_SHIFT) + 1;
        Samples {
            first: first.max(i32x16::splat(simd, limits[0])),
            end: end.min(i32x16::splat(simd, limits[1])),
        }
    }
}
