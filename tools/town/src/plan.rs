//! The plan of a tile: streets, blocks and lots. Depends on the seed and the position of the tile alone, so that
//! neighbours agree on the street between them.

use crate::random::Random;
use crate::vector::Rect;

/// Side of a tile in metres.
pub(crate) const TILE: u32 = 64;

/// Distance between the middles of parallel streets: two blocks along each side of a tile.
const PITCH: f64 = TILE as f64 / 2.0;

/// Width of the raised pavement around a block.
pub(crate) const PAVEMENT: f64 = 1.4;

/// Height of the pavement above the roadway.
pub(crate) const KERB: f64 = 0.12;

/// Width of a passage through a house.
pub(crate) const PASSAGE: f64 = 2.6;

/// A street of the town, from end to end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Street {
    pub(crate) width: f64,
    /// Cobbles or asphalt.
    pub(crate) cobbled: bool,
}

/// What is beyond a side of a lot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Side {
    Street,
    Court,
    /// The neighbour's wall.
    Party,
}

/// The ground of a house; sides as in [`Rect::side`].
#[derive(Clone, Debug)]
pub(crate) struct Lot {
    pub(crate) rect: Rect,
    pub(crate) sides: [Side; 4],
    /// Whether a passage leads through the house into the court.
    pub(crate) passage: bool,
}

/// An area between streets.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(crate) rect: Rect,
    /// Empty in a park.
    pub(crate) lots: Vec<Lot>,
    /// The area that the houses enclose; in a park the area within its paths.
    pub(crate) court: Rect,
    /// The streets along the sides.
    pub(crate) streets: [Street; 4],
}

impl Block {
    pub(crate) fn is_park(&self) -> bool {
        self.lots.is_empty()
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) blocks: Vec<Block>,
    /// Streets with constant x, then with constant z: at the lower border, in the middle, at the upper border.
    pub(crate) streets: [[Street; 3]; 2],
}

impl Plan {
    pub(crate) fn new(seed: u64, tile: [u32; 2]) -> Plan {
        let streets =
            [0, 1].map(|axis: usize| [0, 1, 2].map(|line| street(seed, axis, 2 * tile[axis] + line)));
        let mut blocks = Vec::new();
        for number in 0..4 {
            let at = [number % 2, number / 2];
            let around = [0, 1].map(|axis| [streets[axis][at[axis]], streets[axis][at[axis] + 1]]);
            let end = |axis: usize, side: usize| {
                let from_middle = around[axis][side].width / 2.0 * if side == 0 { 1.0 } else { -1.0 };
                (at[axis] + side) as f64 * PITCH + from_middle
            };
            let rect = Rect::new(end(0, 0), end(1, 0), end(0, 1), end(1, 1));
            let mut random = Random::new(seed, &format!("block {tile:?} {number}"));
            let sides = [around[1][0], around[0][1], around[1][1], around[0][0]];
            blocks.push(block(rect, sides, &mut random));
        }
        Plan { blocks, streets }
    }

    /// Returns the area of the roadways along a street with the number `line`, as a strip through the tile.
    pub(crate) fn roadway(&self, axis: usize, line: usize) -> Rect {
        let half = self.streets[axis][line].width / 2.0 - PAVEMENT;
        let middle = line as f64 * PITCH;
        let [low, high] = [(middle - half).max(0.0), (middle + half).min(f64::from(TILE))];
        let far = f64::from(TILE);
        match axis {
            0 => Rect::new(low, 0.0, high, far),
            _ => Rect::new(0.0, low, far, high),
        }
    }
}

fn street(seed: u64, axis: usize, line: u32) -> Street {
    let mut random = Random::new(seed, &format!("street {axis} {line}"));
    Street {
        width: 6.0 + 0.5 * random.below(9) as f64,
        cobbled: random.chance(0.5),
    }
}

fn block(rect: Rect, streets: [Street; 4], random: &mut Random) -> Block {
    if random.chance(0.1) {
        return Block {
            rect,
            lots: Vec::new(),
            court: rect.grown(-1.8),
            streets,
        };
    }
    let depth = 7.5 + 0.25 * random.below(5) as f64;
    let court = rect.grown(-depth);
    let ([x0, z0], [x1, z1]) = (rect.low, rect.high);
    let ([a0, b0], [a1, b1]) = (court.low, court.high);
    let mut lots = Vec::new();
    let with_passage = random.below(4);
    for side in 0..4 {
        let corner = [
            Rect::new(a1, z0, x1, b0),
            Rect::new(a1, b1, x1, z1),
            Rect::new(x0, b1, a0, z1),
            Rect::new(x0, z0, a0, b0),
        ][side];
        let mut sides = [Side::Party; 4];
        sides[side] = Side::Street;
        sides[(side + 1) % 4] = Side::Street;
        lots.push(Lot {
            rect: corner,
            sides,
            passage: false,
        });
        let row = [
            Rect::new(a0, z0, a1, b0),
            Rect::new(a1, b0, x1, b1),
            Rect::new(a0, b1, a1, z1),
            Rect::new(x0, b0, a0, b1),
        ][side];
        sides[(side + 1) % 4] = Side::Party;
        sides[(side + 2) % 4] = Side::Court;
        // Lengths are cut at multiples of 1 / 16 m.
        let axis = side % 2;
        let length = row.size()[axis];
        let parts = if length > 8.4 && random.chance(0.6) { 2 } else { 1 };
        let share = random.between(0.45, 0.55);
        let cut = row.low[axis] + (length * share * 16.0).round() / 16.0;
        for part in 0..parts {
            let mut rect = row;
            if parts == 2 && part == 0 {
                rect.high[axis] = cut;
            } else if parts == 2 {
                rect.low[axis] = cut;
            }
            lots.push(Lot {
                rect,
                sides,
                passage: side == with_passage && part == 0,
            });
        }
    }
    Block {
        rect,
        lots,
        court,
        streets,
    }
}

#[cfg(test)]
mod tests {
    use super::{Plan, Side};

    #[test]
    fn houses_fill_the_ring_around_each_court() {
        for x in 0..6 {
            for block in Plan::new(1, [x, 2])
                .blocks
                .iter()
                .filter(|block| !block.is_park())
            {
                let area = |rect: &crate::vector::Rect| rect.size()[0] * rect.size()[1];
                let lots: f64 = block.lots.iter().map(|lot| area(&lot.rect)).sum();
                assert!((lots + area(&block.court) - area(&block.rect)).abs() < 1e-9);
                assert_eq!(block.lots.iter().filter(|lot| lot.passage).count(), 1);
                for lot in &block.lots {
                    assert!(lot.sides.contains(&Side::Street), "{lot:?}");
                }
            }
        }
    }

    #[test]
    fn neighbours_agree_on_the_street_between_them() {
        let [left, right] = [[3, 5], [4, 5]].map(|tile| Plan::new(7, tile));
        assert_eq!(left.streets[0][2].width, right.streets[0][0].width);
        assert_eq!(left.streets[1][1].width, right.streets[1][1].width);
    }
}
