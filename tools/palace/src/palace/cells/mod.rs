//! The painted gallery: bays along the garden with flat walls and convex interiors, rendered by the method `cell`.
//!
//! Panels, frames and pictures are painted or flush with the walls; items in the bays are alpha-tested or
//! alpha-blended. Between two bays the thickness of the wall is a small separate cell.

mod shell;

use super::doors::DOORS;
use super::lamps::Lamp;
use super::palette::*;
use super::plan::Name;
use super::room::{FinishedRoom, shift};
use super::workshop::Workshop;
use super::{drapery, palette};
use crate::envelope::{Plan, Side};
use crate::shape::{Shape, ball, lathe};
use drapery::Rug;
use enfilade::{GeometryBuilder, MaterialId, OpeningId, Transform};
use glam::Vec2;
use shell::{Painted, Vaulting};

/// Height of the bays' walls, equal to the height of the panels painted on them.
const HEIGHT: f32 = 4.4;

/// A bay, or the thickness of a wall between two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub(crate) name: Name,
    pub(crate) title: &'static str,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Bay {
        plan: Plan,
        vaulting: Vaulting,
        panels: MaterialId,
        pictures: &'static [Painted],
        rug: ([f32; 2], Rug),
        curtains: MaterialId,
    },
    /// The passage through a wall, between the doors at both ends.
    Threshold,
}

const COVE: Vaulting = Vaulting::Cove(1.1, 1.0);

const fn bay(x: [f32; 2], z: [f32; 2]) -> Plan {
    Plan::Rectangle(x, z)
}

const fn threshold(name: Name, title: &'static str) -> Cell {
    let kind = Kind::Threshold;
    Cell { name, title, kind }
}

/// From the palace to the far end.
pub(crate) const CELLS: [Cell; 9] = [
    Cell {
        name: Name::PaintedLobby,
        title: "Painted Lobby",
        kind: Kind::Bay {
            plan: bay([-15.0, -10.0], [-92.0, -81.45]),
            vaulting: COVE,
            panels: GREEN_PANELS,
            pictures: &[
                Painted::new(Side::East, 2.8, 0),
                Painted::new(Side::East, 7.7, 3),
                Painted::new(Side::West, 8.6, 5),
            ],
            rug: ([2.2, 5.0], Rug::Green),
            curtains: GREEN_CURTAIN,
        },
    },
    threshold(Name::FirstThreshold, "First Threshold"),
    Cell {
        name: Name::MorningBay,
        title: "Morning Bay",
        kind: Kind::Bay {
            plan: bay([-22.5, -15.5], [-92.0, -82.5]),
            vaulting: COVE,
            panels: ROSE_PANELS,
            pictures: &[
                Painted::new(Side::South, 2.0, 0),
                Painted::new(Side::South, 5.0, 2),
            ],
            rug: ([2.4, 5.2], Rug::Rose),
            curtains: RED_CURTAIN,
        },
    },
    threshold(Name::SecondThreshold, "Second Threshold"),
    Cell {
        name: Name::Tribune,
        title: "Tribune",
        kind: Kind::Bay {
            plan: Plan::Round([-27.75, -87.25], 4.75, 8),
            vaulting: Vaulting::Dome(3.6),
            panels: GREEN_PANELS,
            pictures: &[Painted::new(Side::South, 1.9675, 6)],
            rug: ([3.2, 3.2], Rug::Blue),
            curtains: GREEN_CURTAIN,
        },
    },
    threshold(Name::ThirdThreshold, "Third Threshold"),
    Cell {
        name: Name::EveningBay,
        title: "Evening Bay",
        kind: Kind::Bay {
            plan: bay([-40.0, -33.0], [-92.0, -82.5]),
            vaulting: COVE,
            panels: ROSE_PANELS,
            pictures: &[
                Painted::new(Side::South, 2.0, 1),
                Painted::new(Side::South, 5.0, 4),
            ],
            rug: ([2.4, 5.2], Rug::Red),
            curtains: RED_CURTAIN,
        },
    },
    threshold(Name::FourthThreshold, "Fourth Threshold"),
    Cell {
        name: Name::Belvedere,
        title: "Belvedere",
        kind: Kind::Bay {
            plan: bay([-46.5, -40.5], [-92.0, -82.5]),
            vaulting: COVE,
            panels: GREEN_PANELS,
            pictures: &[
                Painted::new(Side::West, 4.75, 3),
                Painted::new(Side::South, 3.0, 5),
            ],
            rug: ([2.2, 5.0], Rug::Yellow),
            curtains: GREEN_CURTAIN,
        },
    },
];

impl Cell {
    /// Builds the cell; also returns its openings, each with the index of its door.
    pub(crate) fn build(&self, shop: &mut Workshop) -> (FinishedRoom, Vec<(usize, OpeningId)>) {
        let mut geometry = palette::geometry();
        let ends = self.ends();
        let openings = ends
            .iter()
            .map(|end| {
                (
                    end.number,
                    geometry.opening(DOORS[end.number].name, end.outline()),
                )
            })
            .collect();
        let lamps = match self.kind {
            Kind::Bay {
                plan,
                vaulting,
                panels,
                pictures,
                ..
            } => {
                let pieces = shell::bay(plan, vaulting, panels, pictures, &ends);
                self.put_shell(&mut geometry, pieces);
                self.furnish(&mut geometry, shop, plan, &ends)
            }
            Kind::Threshold => {
                self.put_shell(&mut geometry, shell::threshold(&ends));
                let middle = (ends[0].corners[0] + ends[1].corners[0]) * 0.5;
                let at = [middle.x, 2.6, -87.25];
                vec![Lamp::candles(at, 0.5)]
            }
        };
        let geometry = geometry.build().expect("a bay is made of sound things");
        (FinishedRoom::of(geometry, lamps), openings)
    }

    /// Returns the doors and windows in its walls.
    fn ends(&self) -> Vec<shell::End> {
        (DOORS.iter().enumerate())
            .filter(|(_, door)| door.from == self.name || door.to == self.name)
            .map(|(number, door)| shell::End::new(number, &door.gate, door.from == self.name))
            .collect()
    }

    fn put_shell(&self, geometry: &mut GeometryBuilder, pieces: Vec<Shape>) {
        for (number, shape) in pieces.iter().enumerate() {
            let mesh = geometry.mesh(shape.dressed(dress));
            let name = format!("{}: shell {}", self.title, number + 1);
            geometry.item(&name, mesh, Transform::IDENTITY);
        }
    }

    /// Adds the alpha-tested and alpha-blended items: a rug, curtains at the windows, a lustre.
    fn furnish(
        &self,
        geometry: &mut GeometryBuilder,
        shop: &mut Workshop,
        plan: Plan,
        ends: &[shell::End],
    ) -> Vec<Lamp> {
        let Kind::Bay {
            rug: (size, rug),
            curtains,
            ..
        } = self.kind
        else {
            return Vec::new();
        };
        let Vec2 { x, y: z } = plan.center();
        let mut put = |thing: &str, mesh, at: Transform| {
            let mesh = geometry.mesh(mesh);
            geometry.item(&format!("{}: {thing}", self.title), mesh, at);
        };
        let carpet = drapery::carpet(shop, size, rug);
        put("carpet", carpet, shift(x, 0.0, z));
        let lustre = shop.piece("lustre".to_owned(), lustre);
        put("lustre", lustre, shift(x, 3.0, z));
        let mut lamps = vec![Lamp::candles([x, 3.5, z], 5.0)];
        /// Distance from the wall to the axis of a curtain rod.
        const STAND: f32 = 0.07;
        /// Gap behind its brackets: nothing may reach out of the cell.
        const GAP: f32 = 1e-3;
        let windows = ends.iter().filter(|end| end.gate.sill > 0.0);
        for (number, window) in windows.enumerate() {
            let top = window.gate.spring + window.gate.rise;
            let wide = 0.42 * window.gate.width;
            let reach = 0.5 * window.gate.width + 0.36;
            let cloth = drapery::curtain(shop, wide, top + 0.24, curtains, curtains);
            let swags = drapery::swags(shop, 2.0 * reach, 3, STAND, curtains, curtains);
            let [x, z] = window.gate.at;
            put(
                &format!("swags {}", number + 1),
                swags,
                shift(x - reach, top + 0.32, z + STAND + GAP),
            );
            // Windows are in the northern wall, whose frames face south.
            for side in [-1.0_f32, 1.0] {
                let mirrored = Transform::scaling([side, 1.0, 1.0]);
                let name = format!(
                    "curtain {} {}",
                    number + 1,
                    if side < 0.0 { "left" } else { "right" }
                );
                put(
                    &name,
                    cloth.clone(),
                    shift(x - side * reach, 0.06, z + STAND) * mirrored,
                );
            }
            lamps.push(Lamp::daylight([x, 2.2, z + 1.6], [1.3, 1.6, 2.0], 8.0));
        }
        lamps
    }
}

/// A lustre of glass, its lowest point at the origin.
fn lustre() -> Shape {
    let stem = [
        [0.0, 0.0],
        [0.09, 0.06],
        [0.03, 0.16],
        [0.05, 0.3],
        [0.02, 0.5],
        [0.06, 0.62],
        [0.02, 0.8],
        [0.02, 2.2],
    ];
    let mut shape = lathe(CRYSTAL, &stem, 12);
    for (radius, up, drops) in [(0.62, 0.42, 18), (0.40, 0.72, 12), (0.2, 0.16, 8)] {
        shape.join(lathe(
            CRYSTAL,
            &[
                [radius - 0.03, up],
                [radius, up - 0.02],
                [radius + 0.03, up],
                [radius, up + 0.03],
            ],
            24,
        ));
        let drop = ball(CRYSTAL, 0.045, 4, 6);
        for i in 0..drops {
            let turn = Transform::rotation(
                [0.0, 1.0, 0.0],
                std::f64::consts::TAU * f64::from(i) / f64::from(drops),
            );
            shape.add(
                &drop,
                turn * shift(radius, up - 0.08, 0.0) * Transform::scaling([0.7, 1.5, 0.7]),
            );
        }
    }
    shape
}

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade::Method;

    #[test]
    fn each_is_convex_and_the_method_for_that_takes_it() {
        let mut shop = Workshop::default();
        for cell in CELLS {
            let (closed, openings) = cell.build(&mut shop);
            assert!(openings.len() >= 2, "{}", cell.title);
            let built = Method::Cell.build(closed.geometry.into(), Method::DEFAULT_LIMIT);
            assert!(built.is_ok(), "{}: {:?}", cell.title, built.err());
        }
    }
}
