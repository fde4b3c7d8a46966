//! Roofs of single tiles, with ridges, gutters, chimneys and dormers.

use super::House;
use super::facade::{Facade, Opening, Use};
use super::window::{self, Behind};
use crate::material::Material;
use crate::mesh::{End, Mesh, arc};
use crate::tile::Items;
use crate::vector::{Frame, Vector, v};
use std::f64::consts::TAU;

/// The most triangles of a piece of a roof.
const PIECE: f64 = 9000.0;

/// The section of a roof tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TileShape {
    Plain,
    /// A wave.
    Pantile,
    /// Half a pipe.
    Barrel,
}

impl TileShape {
    /// Returns the height of the section at a share of the width, and its slope.
    fn at(self, share: f64, width: f64) -> (f64, f64) {
        let angle = share * TAU;
        match self {
            TileShape::Plain => {
                let rise = 0.02 * width;
                (
                    rise * (angle / 2.0).sin(),
                    rise * TAU / 2.0 * (angle / 2.0).cos() / width,
                )
            }
            TileShape::Pantile => {
                let rise = 0.1 * width;
                (rise * (1.0 - angle.cos()), rise * TAU * angle.sin() / width)
            }
            TileShape::Barrel => {
                let rise = 0.3 * width;
                (
                    rise * (angle / 2.0).sin(),
                    rise * TAU / 2.0 * (angle / 2.0).cos() / width,
                )
            }
        }
    }

    fn segments(self) -> f64 {
        match self {
            TileShape::Plain => 2.0,
            TileShape::Pantile => 5.0,
            TileShape::Barrel => 4.0,
        }
    }
}

/// A plane of a roof. In its frame x is along the eaves, y up the slope, z outward.
pub(super) struct Slope<'a> {
    pub(super) frame: Frame,
    /// From the eaves to the ridge, along the slope.
    pub(super) length: f64,
    /// Ends of a row at a distance from the eaves: linear between 0, `bend` and `length`.
    pub(super) limits: &'a dyn Fn(f64) -> [f64; 2],
    pub(super) bend: f64,
    pub(super) shape: TileShape,
    pub(super) material: Material,
}

impl Slope<'_> {
    /// Adds the tiles whose middle is between two shares of the width at the eaves; the first piece also has the
    /// boards below all of them.
    fn piece(&self, mesh: &mut Mesh, [from, to]: [f64; 2]) {
        mesh.frame = self.frame;
        let [left, right] = (self.limits)(0.0);
        let [first, last] = [from, to].map(|share| left + (right - left) * share);
        if from == 0.0 {
            mesh.material = Material::Wood;
            self.boards(mesh);
        }
        mesh.material = self.material;
        let size = mesh.piece(0.22, [0.14, 1.6]);
        let rows = (self.length / (1.15 * size)).round().max(1.0);
        let exposed = self.length / rows;
        for row in 0..rows as usize {
            let low = row as f64 * exposed;
            // Half a row up is where the ends of a cut row are right on average.
            let [start, end] = (self.limits)(low + 0.5 * exposed);
            let count = ((end - start) / size).round().max(1.0);
            let width = (end - start) / count;
            for i in 0..count as usize {
                let x = start + i as f64 * width;
                let middle = x + width / 2.0;
                if (first..last).contains(&middle)
                    || (to == 1.0 && middle >= last)
                    || (from == 0.0 && middle < first)
                {
                    self.tile(mesh, [x, low], width, exposed);
                }
            }
        }
    }

    fn boards(&self, mesh: &mut Mesh) {
        let mut outline: Vec<Vector> = Vec::new();
        let [low, bend, high] = [0.0, self.bend, self.length].map(|y| ((self.limits)(y), y));
        let mut add = |x: f64, y: f64| {
            let corner = v(x, y, 0.0);
            let is_new = outline.iter().all(|at: &Vector| (*at - corner).length() > 1e-3);
            if is_new {
                outline.push(corner);
            }
        };
        for ([_, right], y) in [low, bend, high] {
            add(right, y);
        }
        for ([left, _], y) in [high, bend, low] {
            add(left, y);
        }
        mesh.polygon(&outline);
    }

    /// Adds one tile, its lower left corner at `low`.
    fn tile(&self, mesh: &mut Mesh, low: [f64; 2], width: f64, exposed: f64) {
        let segments = mesh.segments(self.shape.segments(), 1);
        let thick = 0.022;
        let lift = 0.02 + mesh.random.between(0.0, 0.01);
        let [tilt, skew] = [mesh.random.around(0.004), mesh.random.around(0.006)];
        let shape = self.shape;
        // Flat tiles do not overlap their neighbours.
        let joint = if shape == TileShape::Plain {
            0.03 * width
        } else {
            0.0
        };
        let (low, width) = ([low[0] + joint / 2.0, low[1]], width - joint);
        // The upper end is below the lower end of the next row.
        let height = |share: f64, up: f64| {
            let (rise, slope) = shape.at(share, width);
            let lower = lift + thick + tilt * (share - 0.5) * 2.0;
            (rise + lower + (0.012 - lower) * up, slope)
        };
        let fall = (lift + thick) / (1.2 * exposed);
        mesh.grid([segments, 1], |column, row| {
            let share = column as f64 / segments as f64;
            let (z, slope) = height(share, row as f64);
            let y = low[1] - 0.01 + skew * share + 1.2 * exposed * row as f64;
            let y = y.min(self.length);
            (v(low[0] + width * share, y, z), v(-slope, fall, 1.0).unit())
        });
        mesh.grid([segments, 1], |column, row| {
            let share = column as f64 / segments as f64;
            let (z, _) = height(share, 0.0);
            let y = low[1] - 0.01 + skew * share;
            let z = if row == 0 { z - thick } else { z };
            (v(low[0] + width * share, y, z), -Vector::Y)
        });
    }
}

/// Adds a slope as items of limited size.
pub(super) fn slope(items: &mut Items, name: &str, slope: &Slope) {
    let [left, right] = (slope.limits)(0.0);
    let [top_left, top_right] = (slope.limits)(slope.length);
    let area = slope.length * (right - left + top_right - top_left) / 2.0;
    let triangles = area / (0.22 * 0.253) * 4.0 * slope.shape.segments() * items.level().min(3.5);
    let pieces = (triangles / PIECE).ceil().max(1.0) as usize;
    for piece in 0..pieces {
        let name = if pieces == 1 {
            name.to_owned()
        } else {
            format!("{name} {piece}")
        };
        items.add(&name, |mesh| {
            slope.piece(mesh, [piece, piece + 1].map(|i| i as f64 / pieces as f64));
        });
    }
}

/// Returns the frame of a slope above a wall, and its length to a ridge that is `run` inward.
pub(super) fn slope_frame(house: &House, wall: Frame, overhang: f64, run: f64) -> (Frame, f64) {
    let (sine, cosine) = house.pitch.sin_cos();
    let inner = Frame {
        origin: v(0.0, house.eaves - overhang * sine / cosine, overhang),
        x: Vector::X,
        y: v(0.0, sine, -cosine),
        z: v(0.0, cosine, sine),
    };
    (wall.then(inner), (run + overhang) / cosine)
}

/// Adds ridge tiles along a line.
pub(super) fn ridge(mesh: &mut Mesh, from: Vector, to: Vector) {
    let along = to - from;
    let size = mesh.piece(0.4, [0.2, 2.0]);
    let count = (along.length() / size).ceil().max(1.0);
    let x = along.unit();
    let z = x.cross(Vector::Y).unit();
    let frame = Frame {
        origin: from,
        x,
        y: z.cross(x),
        z,
    };
    let before = mesh.frame;
    mesh.frame = before.then(frame);
    let length = along.length() / count;
    for i in 0..count as usize {
        let sides = mesh.segments(6.0, 3);
        let start = length * i as f64;
        let lift = mesh.random.between(0.0, 0.01);
        let point = |column: usize, radius: f64, x: f64| {
            let (sine, cosine) = (column as f64 / sides as f64 * TAU / 2.0).sin_cos();
            let normal = v(0.0, sine, cosine);
            (v(x, 0.9 * radius * sine - 0.04 + lift, radius * cosine), normal)
        };
        let ring = |column: usize, row: usize| match row {
            0 => point(column, 0.145, start - 0.02),
            _ => point(column, 0.12, start + length + 0.03),
        };
        mesh.grid([1, sides], |column, row| ring(row, column));
        mesh.grid([1, sides], |column, row| {
            let (at, _) = point(row, if column == 0 { 0.12 } else { 0.145 }, start - 0.02);
            (at, -Vector::X)
        });
    }
    mesh.frame = before;
}

/// Adds the soffit, the gutter and a downpipe of a facade.
pub(super) fn gutter(mesh: &mut Mesh, house: &House, facade: &Facade) {
    mesh.frame = facade.frame;
    let overhang = house.overhang();
    let soffit = house.soffit();
    let y = soffit + 0.02;
    mesh.material = Material::Wood;
    let boards = [
        (soffit, 0.0),
        (soffit, overhang - 0.03),
        (y + 0.01, overhang - 0.03),
    ];
    let open = facade
        .ends
        .map(|end| if end == End::Mitre { end } else { End::Open });
    mesh.extrude([0.0, facade.width], &boards, open);
    // The ends toward lower neighbours.
    let side = |x: f64| {
        [
            v(x, soffit, 0.0),
            v(x, soffit, overhang - 0.03),
            v(x, y + 0.01, overhang - 0.03),
            v(x, house.eaves, 0.0),
        ]
    };
    if open[0] == End::Open {
        mesh.polygon(&side(0.0));
    }
    if open[1] == End::Open {
        let mut corners = side(facade.width);
        corners.reverse();
        mesh.polygon(&corners);
    }
    mesh.material = Material::Metal;
    let round = mesh.segments(8.0, 3);
    let center = (y - 0.01, overhang + 0.06);
    // From the inner rim below to the outer one, and back inside.
    let outside = arc(center, 0.07, [3.0, 1.0], round);
    let mut inside = arc(center, 0.06, [3.0, 1.0], round);
    inside.reverse();
    mesh.extrude([0.0, facade.width], &outside, open);
    mesh.extrude([0.0, facade.width], &inside, open);
    let sides = mesh.segments(10.0, 4);
    // It covers the joint with the neighbour.
    let x = if facade.ends[0] == End::Mitre {
        facade.width
    } else {
        0.0
    };
    let foot = if facade.faces_street { 0.35 } else { 0.2 };
    let path = [
        (v(x, foot, 0.22), 0.05),
        (v(x, foot + 0.15, 0.12), 0.05),
        (v(x, foot + 0.3, 0.11), 0.05),
        (v(x, house.eaves - 0.9, 0.11), 0.05),
        (v(x, house.eaves - 0.7, 0.16), 0.05),
        (v(x, soffit - 0.25, 0.38), 0.05),
        (v(x, soffit - 0.12, overhang + 0.05), 0.05),
        (v(x, y - 0.05, overhang + 0.06), 0.05),
    ];
    mesh.tube(&path, sides);
    let clamps = ((house.eaves - 2.0) / 1.8) as usize;
    for i in 0..clamps {
        let at = v(x, 1.2 + 1.8 * i as f64, 0.11);
        mesh.tube(&[(at, 0.06), (at + v(0.0, 0.05, 0.0), 0.06)], sides);
        mesh.cuboid(at + v(-0.02, 0.01, -0.12), at + v(0.02, 0.04, -0.05));
    }
}

/// Adds a chimney of bricks with pots; its frame is on the ground, `low` is inside the roof.
pub(super) fn chimney(mesh: &mut Mesh, frame: Frame, [low, high]: [f64; 2], size: [f64; 2], pots: usize) {
    mesh.frame = frame;
    mesh.material = Material::Brick;
    let [x, z] = size.map(|side| side / 2.0);
    mesh.open_cuboid(v(-x, low, -z), v(x, high - 0.02, z));
    let height = mesh.piece(0.14, [0.07, 0.5]);
    let courses = ((high - low) / height).round().max(2.0) as usize;
    for course in 0..courses {
        let [y0, y1] = [course, course + 1].map(|i| low + (high - low) * i as f64 / courses as f64);
        let wide = if course + 2 >= courses { 0.05 } else { 0.0 };
        for side in 0..4 {
            let turned = frame.turned(Vector::ZERO, side as f64 * TAU / 4.0);
            mesh.frame = turned;
            let [half, out] = if side % 2 == 0 {
                [x + wide, z + wide]
            } else {
                [z + wide, x + wide]
            };
            let bricks = (2.0 * half / (3.0 * height)).round().max(1.0);
            let shift = if course % 2 == 0 { 0.0 } else { 0.5 };
            for i in 0..=bricks as usize {
                let end = |at: f64| (-half + 2.0 * half * at / bricks).clamp(-half, half);
                let [a, b] = [end(i as f64 - shift) + 0.004, end(i as f64 + 1.0 - shift) - 0.004];
                if b - a > 0.02 {
                    let front = out + 0.012 + mesh.random.between(0.0, 0.006);
                    let profile = [
                        (y0 + 0.004, out - wide),
                        (y0 + 0.006, front),
                        (y1 - 0.006, front),
                        (y1 - 0.004, out - wide),
                    ];
                    mesh.extrude([a, b], &profile, [End::Cap; 2]);
                }
            }
        }
    }
    mesh.frame = frame;
    mesh.material = Material::Stone;
    mesh.cuboid(v(-x - 0.1, high, -z - 0.1), v(x + 0.1, high + 0.08, z + 0.1));
    mesh.material = Material::RedTile;
    let sides = mesh.segments(14.0, 5);
    for pot in 0..pots {
        let along = (pot as f64 + 0.5) / pots as f64 * 2.0 - 1.0;
        mesh.frame = frame.moved(v(along * x, high + 0.08, 0.0));
        let profile = [
            (0.13, 0.0),
            (0.11, 0.1),
            (0.1, 0.32),
            (0.13, 0.35),
            (0.13, 0.42),
            (0.1, 0.42),
            (0.09, 0.05),
        ];
        mesh.lathe(&profile, sides);
    }
}

/// Adds a dormer window as items; `x` is its middle along the facade.
pub(super) fn dormer(items: &mut Items, name: &str, house: &House, facade: &Facade, x: f64) {
    let [half, back, rise] = [0.75, 0.7, 0.55];
    let tangent = house.pitch.tan();
    // Heights at which the front meets the slope, and of its eaves; `behind` is where a height meets the slope.
    let low = house.eaves + back * tangent;
    let eaves = low + 1.6;
    let front = facade.frame.moved(v(x - half, 0.0, -back));
    let behind = |y: f64| (y - low) / tangent;
    items.add(&format!("{name} front"), |mesh| {
        mesh.frame = front;
        let opening = Opening {
            low: [half - 0.45, low + 0.5],
            high: [half + 0.45, eaves - 0.1],
            kind: Use::Balcony,
        };
        mesh.material = house.wall;
        super::facade::strip(mesh, 2.0 * half, [low - 0.2, eaves], 0.0, &[opening]);
        mesh.polygon(&[
            v(0.0, eaves, 0.0),
            v(2.0 * half, eaves, 0.0),
            v(half, eaves + rise, 0.0),
        ]);
        let cheek = |x: f64| [v(x, low, 0.0), v(x, eaves, 0.0), v(x, eaves, -behind(eaves))];
        mesh.polygon(&cheek(0.0));
        let mut right = cheek(2.0 * half);
        right.reverse();
        mesh.polygon(&right);
        window::fill(mesh, house, &opening, Behind::Dark);
    });
    let (pitch, over) = ((rise / half).atan(), 0.15);
    let (sine, cosine) = pitch.sin_cos();
    for (side, away) in [("left", -1.0), ("right", 1.0)] {
        // From the front to where the slope cuts it, seen from the side.
        let depth = |y: f64| behind(y) + over + 0.05;
        let length = (half + over) / cosine;
        let start = eaves - over * sine / cosine;
        let limits = |up: f64| {
            let cut = depth(start + up * sine);
            if away < 0.0 {
                [over - cut, over]
            } else {
                [-over, cut - over]
            }
        };
        let inner = if away < 0.0 {
            Frame {
                origin: v(-over, start, 0.0),
                x: Vector::Z,
                y: v(cosine, sine, 0.0),
                z: v(-sine, cosine, 0.0),
            }
        } else {
            Frame {
                origin: v(2.0 * half + over, start, 0.0),
                x: -Vector::Z,
                y: v(-cosine, sine, 0.0),
                z: v(sine, cosine, 0.0),
            }
        };
        let slope_of = Slope {
            frame: front.then(inner),
            length,
            limits: &limits,
            bend: length,
            shape: house.tile_shape,
            material: house.tile_material,
        };
        slope(items, &format!("{name} roof {side}"), &slope_of);
    }
    items.add(&format!("{name} ridge"), |mesh| {
        mesh.frame = front;
        mesh.material = house.tile_material;
        let top = eaves + rise + 0.03;
        ridge(mesh, v(half, top, over), v(half, top, -behind(top)));
        // Boards below the tiles, seen from the street.
        mesh.material = Material::Paint;
        for (from, to) in [
            (
                v(-over, eaves - over * sine / cosine, over),
                v(half, eaves + rise, over),
            ),
            (
                v(half, eaves + rise, over),
                v(2.0 * half + over, eaves - over * sine / cosine, over),
            ),
        ] {
            let down = v(0.0, 0.16, 0.0);
            mesh.quad(from - down, to - down, to + down * 0.2, from + down * 0.2);
            let [a, b] = [from - down, to - down].map(|at| at - v(0.0, 0.0, over));
            mesh.quad(a, b, to - down, from - down);
        }
    });
}
