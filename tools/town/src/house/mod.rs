//! Houses: 20 to 60 items each, with closed outer walls.

mod balcony;
mod facade;
mod roof;
mod room;
mod window;

use crate::material::Material;
use crate::mesh::{End, Mesh};
use crate::plan::{KERB, Lot, PASSAGE, Side};
use crate::random::Random;
use crate::tile::Items;
use crate::vector::{Frame, v};
use facade::{Facade, Opening, Use, WALL};
use roof::{Slope, TileShape};
use window::{Behind, WindowStyle};

/// What the items of a house have in common.
struct House {
    lot: Lot,
    /// Heights of the floors above the roadway.
    floors: Vec<f64>,
    /// Height at which the planes of roof and wall meet.
    eaves: f64,
    /// Slope of the roof in radians.
    pitch: f64,
    base: Material,
    wall: Material,
    door: Material,
    windows: WindowStyle,
    tile_shape: TileShape,
    tile_material: Material,
    has_shops: bool,
    has_balconies: bool,
    turned_railings: bool,
}

impl House {
    fn new(lot: &Lot, random: &mut Random) -> House {
        let is_corner = lot.sides.iter().filter(|&&side| side == Side::Street).count() == 2;
        let storeys = 2 + random.below(3) + random.below(if is_corner { 3 } else { 2 });
        let [ground, upper] = [random.between(3.6, 3.9), random.between(2.9, 3.1)];
        let mut floors = vec![KERB + 0.3];
        floors.extend((0..storeys - 1).map(|i| KERB + 0.3 + ground + upper * i as f64));
        let eaves = KERB + 0.3 + ground + upper * (storeys - 1) as f64 + 0.6;
        let colors = [
            Material::Cream,
            Material::Ochre,
            Material::Rose,
            Material::Grey,
            Material::Brick,
        ];
        let wall = random.pick(&colors);
        let paints = [Material::Paint, Material::Wood, Material::Blue, Material::Red];
        let shutters = random
            .chance(0.4)
            .then(|| random.pick(&[Material::Blue, Material::Wood, Material::Grey]));
        House {
            lot: lot.clone(),
            floors,
            eaves: eaves.min(20.0),
            pitch: if is_corner && random.chance(0.35) {
                random.between(0.95, 1.02)
            } else {
                random.between(0.62, 0.82)
            },
            base: random.pick(&[wall, Material::Stone, Material::Grey]),
            wall,
            door: random.pick(&[Material::Wood, Material::Red, Material::Blue]),
            windows: WindowStyle {
                frame: random.pick(&paints[..2]),
                panes: [random.below(2) + 1, random.below(2) + 2],
                shutters,
                flowers: random.chance(0.4),
            },
            tile_shape: random.pick(&[TileShape::Plain, TileShape::Pantile, TileShape::Barrel]),
            tile_material: random.pick(&[Material::RedTile, Material::RedTile, Material::BrownTile]),
            has_shops: !lot.passage && random.chance(0.4),
            has_balconies: random.chance(0.5),
            turned_railings: random.chance(0.4),
        }
    }

    /// How far the roof reaches over outer walls.
    fn overhang(&self) -> f64 {
        (0.5 / self.pitch.tan()).min(0.45)
    }

    /// Height of the boards below the overhang.
    fn soffit(&self) -> f64 {
        self.eaves - self.overhang() * self.pitch.tan() - 0.02
    }

    /// Returns the sides of the lot, with their numbers, frames and lengths.
    fn sides(&self) -> impl Iterator<Item = (usize, Side, Frame, f64)> {
        (0..4).map(|side| {
            let (frame, width) = self.lot.rect.side(side);
            (side, self.lot.sides[side], frame, width)
        })
    }

    /// Lays out the openings of an outer wall.
    fn facade(&self, side: usize, random: &mut Random) -> Facade {
        let (frame, width) = self.lot.rect.side(side);
        let faces_street = self.lot.sides[side] == Side::Street;
        // The left neighbour of a side is the next one.
        let ends = [(side + 1) % 4, (side + 3) % 4].map(|next| match self.lot.sides[next] {
            Side::Party => End::Cap,
            _ => End::Mitre,
        });
        let target = if self.windows.shutters.is_some() {
            2.5
        } else {
            2.05
        };
        let margin = 0.6;
        let bays = ((width - 2.0 * margin) / target).floor().max(1.0);
        let bay = (width - 2.0 * margin) / bays;
        let middle = |i: usize| margin + bay * (i as f64 + 0.5);
        let half = if self.windows.shutters.is_some() {
            0.48
        } else {
            random.between(0.5, 0.62)
        };
        let bays = bays as usize;
        let with_balcony: Vec<bool> = (0..bays).map(|_| random.chance(0.35)).collect();
        let door = random.below(bays);
        let mut storeys = Vec::new();
        for (storey, &floor) in self.floors.iter().enumerate() {
            let mut openings = Vec::new();
            for (i, &with_balcony) in with_balcony.iter().enumerate() {
                let x = middle(i);
                let opening = |half: f64, low: f64, high: f64, kind: Use| Opening {
                    low: [x - half, floor + low],
                    high: [x + half, floor + high],
                    kind,
                };
                let is_free = !self.lot.passage || (x - width / 2.0).abs() > 2.3;
                openings.push(match storey {
                    0 if !is_free => continue,
                    0 if i == door => opening(0.55, 0.0, 2.55, Use::Door),
                    0 if self.has_shops && faces_street && bay > 1.9 => {
                        opening(bay / 2.0 - 0.3, 0.1, 2.5, Use::Shop)
                    }
                    0 => opening(half, 0.85, 2.5, Use::Window),
                    _ if self.has_balconies && faces_street && with_balcony => {
                        opening(half, 0.05, 2.38, Use::Balcony)
                    }
                    _ => opening(half, 0.85, 2.38, Use::Window),
                });
            }
            if storey == 0 && self.lot.passage {
                openings.push(Opening {
                    low: [width / 2.0 - PASSAGE / 2.0, KERB],
                    high: [width / 2.0 + PASSAGE / 2.0, 3.3],
                    kind: Use::Passage,
                });
            }
            storeys.push(openings);
        }
        Facade {
            frame,
            width,
            faces_street,
            ends,
            storeys,
        }
    }
}

/// Adds a house as items.
pub(crate) fn house(items: &mut Items, lot: &Lot, number: usize) {
    let prefix = format!("house {number}");
    let mut random = items.random(&format!("{prefix} plan"));
    let house = House::new(lot, &mut random);
    let mut facades: Vec<Facade> = Vec::new();
    for (side, kind, ..) in house.sides() {
        if kind != Side::Party {
            facades.push(house.facade(side, &mut random));
        }
    }
    facades.sort_by_key(|facade| !facade.faces_street);
    let sides = ["front", if facades[1].faces_street { "side" } else { "court" }];
    for (index, (facade, side)) in facades.iter().zip(sides).enumerate() {
        items.add(&format!("{prefix} {side} wall"), |mesh| {
            facade::wall(mesh, &house, facade);
            if index == 1 {
                party_walls(mesh, &house);
            }
        });
        fill(
            items,
            &house,
            facade,
            &format!("{prefix} {side}"),
            index,
            &mut random,
        );
        items.add(&format!("{prefix} {side} gutter"), |mesh| {
            roof::gutter(mesh, &house, facade)
        });
    }
    if lot.passage {
        let depth = house.lot.rect.size().into_iter().sum::<f64>() - facades[0].width;
        items.add(&format!("{prefix} passage"), |mesh| {
            for (facade, depth) in facades.iter().zip([Some(depth), None]) {
                let passage = facade.storeys[0]
                    .iter()
                    .find(|opening| opening.kind == Use::Passage);
                mesh.frame = facade.frame;
                if let Some(opening) = passage {
                    window::passage(mesh, opening, depth);
                }
            }
        });
    }
    if facades[1].faces_street {
        hip_roof(items, &house, &prefix);
    } else {
        gable_roof(items, &house, &facades, &prefix, &mut random);
    }
}

/// Adds the walls toward the neighbours, up to the roof.
fn party_walls(mesh: &mut Mesh, house: &House) {
    let is_gabled = house.lot.sides.contains(&Side::Court);
    for (_, kind, frame, width) in house.sides() {
        if kind == Side::Party {
            mesh.frame = frame;
            mesh.material = house.wall;
            let [low, high] = [0.0, house.eaves];
            let mut corners = vec![v(0.0, low, 0.0), v(width, low, 0.0), v(width, high, 0.0)];
            if is_gabled {
                corners.push(v(width / 2.0, high + width / 2.0 * house.pitch.tan(), 0.0));
            }
            corners.push(v(0.0, high, 0.0));
            mesh.polygon(&corners);
        }
    }
}

/// Adds the windows of each storey as an item, with rooms and balconies.
fn fill(items: &mut Items, house: &House, facade: &Facade, prefix: &str, index: usize, random: &mut Random) {
    let depth =
        (house.lot.rect.size().into_iter().fold(f64::INFINITY, f64::min) / 2.0 - WALL - 0.2).clamp(1.0, 3.6);
    for (storey, openings) in facade.storeys.iter().enumerate() {
        let windows: Vec<&Opening> = openings
            .iter()
            .filter(|opening| opening.kind != Use::Passage)
            .collect();
        let top = house
            .floors
            .get(storey + 1)
            .copied()
            .unwrap_or(house.soffit() - 0.05);
        let is_shop = openings.iter().any(|opening| opening.kind == Use::Shop);
        // Rooms of two street facades would overlap at the corner: they take turns.
        let may = index == storey % 2 || !facade.ends.contains(&End::Mitre);
        let is_blocked = storey == 0 && (house.lot.passage || !is_shop);
        let has_room = may && !is_blocked && !openings.is_empty() && (is_shop || random.chance(0.2));
        let behind = if has_room { Behind::Room } else { Behind::Dark };
        for (part, group) in windows.chunks(2).enumerate() {
            items.add(&format!("{prefix} windows {storey}.{part}"), |mesh| {
                mesh.frame = facade.frame;
                for opening in group {
                    window::fill(mesh, house, opening, behind);
                }
            });
        }
        if has_room {
            let [left, right] = facade.clearance();
            items.add(&format!("{prefix} room {storey}"), |mesh| {
                mesh.frame = facade.frame;
                let ends = [left, facade.width - right];
                room::room(mesh, ends, [house.floors[storey], top - 0.25], depth, openings);
            });
        }
        let balconies = openings.iter().filter(|opening| opening.kind == Use::Balcony);
        for (number, opening) in balconies.enumerate() {
            items.add(&format!("{prefix} balcony {storey}.{number}"), |mesh| {
                mesh.frame = facade.frame;
                let ends = [opening.low[0] - 0.4, opening.high[0] + 0.4];
                balcony::balcony(mesh, ends, house.floors[storey], house.turned_railings);
            });
        }
    }
}

fn gable_roof(items: &mut Items, house: &House, facades: &[Facade], prefix: &str, random: &mut Random) {
    let depth = house.lot.rect.size().into_iter().sum::<f64>() - facades[0].width;
    let run = depth / 2.0;
    for (facade, side) in facades.iter().zip(["street", "court"]) {
        let (frame, length) = roof::slope_frame(house, facade.frame, house.overhang(), run);
        let slope = Slope {
            frame,
            length,
            limits: &|_| [0.0, facade.width],
            bend: length,
            shape: house.tile_shape,
            material: house.tile_material,
        };
        roof::slope(items, &format!("{prefix} roof {side}"), &slope);
    }
    let facade = &facades[0];
    let top = house.eaves + run * house.pitch.tan();
    items.add(&format!("{prefix} ridge"), |mesh| {
        mesh.frame = facade.frame;
        mesh.material = house.tile_material;
        roof::ridge(mesh, v(0.0, top + 0.05, -run), v(facade.width, top + 0.05, -run));
    });
    let x = if random.chance(0.5) {
        0.55
    } else {
        facade.width - 0.55
    };
    let chimney_at = facade.frame.moved(v(x, 0.0, -run + random.around(1.0)));
    let pots = 2 + random.below(2);
    items.add(&format!("{prefix} chimney"), |mesh| {
        roof::chimney(mesh, chimney_at, [house.eaves + 1.0, top + 0.9], [0.7, 0.5], pots);
    });
    let dormers = ((facade.width - 2.0) / 2.4) as usize;
    if run * house.pitch.tan() > 2.75 && random.chance(0.6) {
        for dormer in 0..dormers {
            let x = 1.0 + (facade.width - 2.0) * (dormer as f64 + 0.5) / dormers as f64;
            roof::dormer(items, &format!("{prefix} dormer {dormer}"), house, facade, x);
        }
    }
}

fn hip_roof(items: &mut Items, house: &House, prefix: &str) {
    let run = house.lot.rect.size()[0] / 2.0;
    let cosine = house.pitch.cos();
    let over = |side: usize| match house.lot.sides[side % 4] {
        Side::Street => house.overhang(),
        _ => 0.0,
    };
    for (side, _, wall, width) in house.sides() {
        let overhang = over(side);
        let (frame, length) = roof::slope_frame(house, wall, overhang, run);
        let [left, right] = [over(side + 1), over(side + 3)];
        let limits = |up: f64| {
            let inward = up * cosine - overhang;
            [inward.max(-left), width - inward.max(-right)]
        };
        let slope = Slope {
            frame,
            length,
            limits: &limits,
            bend: overhang / cosine,
            shape: house.tile_shape,
            material: house.tile_material,
        };
        roof::slope(items, &format!("{prefix} roof {side}"), &slope);
    }
    let top = house.eaves + run * house.pitch.tan() + 0.05;
    let [x, z] = house.lot.rect.center();
    items.add(&format!("{prefix} ridge"), |mesh| {
        mesh.material = house.tile_material;
        for (side, _, frame, _) in house.sides() {
            // The hip at the left end of the side.
            let out = over(side).min(over(side + 1));
            let foot = frame.point(v(-out, house.eaves - out * house.pitch.tan() + 0.05, out));
            roof::ridge(mesh, foot, v(x, top, z));
        }
        mesh.material = Material::Metal;
        mesh.frame = Frame::upright(v(x, top - 0.1, z), 0.0);
        let sides = mesh.segments(14.0, 6);
        mesh.lathe(
            &[
                (0.3, 0.0),
                (0.1, 0.25),
                (0.06, 0.4),
                (0.16, 0.55),
                (0.16, 0.65),
                (0.05, 0.8),
                (0.02, 1.4),
                (0.0, 1.5),
            ],
            sides,
        );
    });
    // Beside the inner corner of the block.
    let inward = |low: Side, high: Side| match (low, high) {
        (Side::Street, _) => 1.0,
        (_, Side::Street) => -1.0,
        _ => 0.0,
    };
    let [a, b, c, d] = house.lot.sides;
    let at = v(x + 0.3 * run * inward(d, b), 0.0, z + 0.3 * run * inward(a, c));
    items.add(&format!("{prefix} chimney"), |mesh| {
        let low = house.eaves + 0.5 * run * house.pitch.tan();
        roof::chimney(mesh, Frame::upright(at, 0.0), [low, top + 0.3], [0.6, 0.6], 2);
    });
}
