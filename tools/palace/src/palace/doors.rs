//! The doors and windows of the palace.

use super::plan::{DOORS_AT, HALF, Name};
use super::room::arched;
use crate::envelope::Side;
use glam::{Vec2, Vec3, vec2, vec3};

/// A doorway or window between two rooms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Door {
    pub(crate) name: &'static str,
    /// The near room, from which one looks in the gate's direction, and the far room.
    pub(crate) from: Name,
    pub(crate) to: Name,
    pub(crate) gate: Gate,
}

/// A hole between two rooms, on the plan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gate {
    /// Direction from the near room to the far room.
    pub(crate) looks: Side,
    /// The middle of its foot, x and z, in the plane of the gate.
    pub(crate) at: [f32; 2],
    pub(crate) width: f32,
    /// Height of the lower edge; 0 for doors.
    pub(crate) sill: f32,
    /// Height where the arch begins, and height of the arch.
    pub(crate) spring: f32,
    pub(crate) rise: f32,
}

impl Gate {
    /// Returns the outline, counter-clockwise as seen in the gate's direction, from the lower left corner.
    pub(crate) fn outline(&self) -> Vec<Vec3> {
        let ahead = self.looks.direction();
        let right = vec2(-ahead.y, ahead.x);
        let at = Vec2::from(self.at);
        arched(self.width, self.sill, self.spring, self.rise)
            .into_iter()
            .map(|corner| {
                let on_plan = at + right * corner.x;
                vec3(on_plan.x, corner.y, on_plan.y)
            })
            .collect()
    }
}

const fn in_line(name: &'static str, from: Name, to: Name, door: usize, rise: f32) -> Door {
    let spring = if rise > 0.0 { 3.1 } else { 4.0 };
    let at = [0.0, DOORS_AT[door]];
    Door {
        name,
        from,
        to,
        gate: Gate {
            looks: Side::North,
            at,
            width: 2.8,
            sill: 0.0,
            spring,
            rise,
        },
    }
}

const fn aside(name: &'static str, from: Name, to: Name, looks: Side, z: f32) -> Door {
    let x = if matches!(looks, Side::East) { HALF } else { -HALF };
    let arched = matches!(from, Name::Rotunda);
    let [spring, rise] = if arched { [3.0, 0.9] } else { [3.3, 0.0] };
    Door {
        name,
        from,
        to,
        gate: Gate {
            looks,
            at: [x, z],
            width: 1.8,
            sill: 0.0,
            spring,
            rise,
        },
    }
}

/// Positions of the windows between gallery and court, as z.
pub(crate) const WINDOWS_AT: [f32; 8] = [-31.5, -36.5, -41.5, -46.5, -56.5, -61.5, -66.5, -71.5];

const fn to_court(name: &'static str, z: f32, width: f32, sill: f32) -> Door {
    let gate = Gate {
        looks: Side::West,
        at: [-15.0, z],
        width,
        sill,
        spring: 3.2,
        rise: 1.0,
    };
    Door {
        name,
        from: Name::Gallery,
        to: Name::Court,
        gate,
    }
}

const fn window(name: &'static str, place: usize) -> Door {
    to_court(name, WINDOWS_AT[place], 2.0, 0.9)
}

/// A window in the western wall of a room of the enfilade.
const fn to_the_west(name: &'static str, from: Name, to: Name, z: f32) -> Door {
    Door {
        name,
        from,
        to,
        gate: Gate {
            looks: Side::West,
            at: [-HALF, z],
            width: 1.4,
            sill: 1.0,
            spring: 3.2,
            rise: 0.7,
        },
    }
}

const fn to_terrace(name: &'static str, from: Name, z: f32) -> Door {
    to_the_west(name, from, Name::Terrace, z)
}

const fn to_garden(name: &'static str, from: Name, z: f32) -> Door {
    to_the_west(name, from, Name::Garden, z)
}

/// A door of the painted gallery, which runs west.
const fn painted(name: &'static str, from: Name, to: Name, x: f32) -> Door {
    Door {
        name,
        from,
        to,
        gate: Gate {
            looks: Side::West,
            at: [x, -87.25],
            width: 1.9,
            sill: 0.0,
            spring: 2.5,
            rise: 0.95,
        },
    }
}

/// A window of the painted gallery.
const fn over_the_garden(name: &'static str, from: Name, x: f32) -> Door {
    Door {
        name,
        from,
        to: Name::Garden,
        gate: Gate {
            looks: Side::North,
            at: [x, -92.0],
            width: 1.8,
            sill: 0.9,
            spring: 2.9,
            rise: 0.7,
        },
    }
}

/// All doors and windows.
pub(crate) const DOORS: [Door; 58] = [
    in_line("vestibule door", Name::Vestibule, Name::GuardRoom, 0, 1.4),
    in_line("guard room door", Name::GuardRoom, Name::RedSalon, 1, 0.0),
    in_line("red salon door", Name::RedSalon, Name::GreenSalon, 2, 0.0),
    in_line("green salon door", Name::GreenSalon, Name::Rotunda, 3, 1.4),
    in_line("rotunda door", Name::Rotunda, Name::BlueSalon, 4, 1.4),
    in_line("blue salon door", Name::BlueSalon, Name::MirrorRoom, 5, 0.0),
    in_line("mirror room door", Name::MirrorRoom, Name::MusicRoom, 6, 0.0),
    in_line("music room door", Name::MusicRoom, Name::Library, 7, 0.0),
    in_line("library door", Name::Library, Name::PictureRoom, 8, 0.0),
    in_line("picture room door", Name::PictureRoom, Name::Antechamber, 9, 0.0),
    in_line("throne room door", Name::Antechamber, Name::ThroneRoom, 10, 1.4),
    aside(
        "red salon gallery door",
        Name::RedSalon,
        Name::Gallery,
        Side::West,
        -26.0,
    ),
    aside(
        "rotunda gallery arch",
        Name::Rotunda,
        Name::Gallery,
        Side::West,
        -47.0,
    ),
    aside(
        "music room gallery door",
        Name::MusicRoom,
        Name::Gallery,
        Side::West,
        -77.0,
    ),
    aside("treasury door", Name::RedSalon, Name::Treasury, Side::East, -26.0),
    aside(
        "porcelain door",
        Name::GreenSalon,
        Name::PorcelainCabinet,
        Side::East,
        -35.5,
    ),
    aside("chapel arch", Name::Rotunda, Name::Chapel, Side::East, -47.0),
    aside(
        "winter garden door",
        Name::BlueSalon,
        Name::WinterGarden,
        Side::East,
        -58.5,
    ),
    aside("study door", Name::Library, Name::Study, Side::East, -87.5),
    window("window 1", 0),
    window("window 2", 1),
    window("window 3", 2),
    window("window 4", 3),
    to_court("court door", -51.5, 2.4, 0.0),
    window("window 5", 4),
    window("window 6", 5),
    window("window 7", 6),
    window("window 8", 7),
    Door {
        name: "grotto arch",
        from: Name::Court,
        to: Name::Fountain,
        gate: Gate {
            looks: Side::West,
            at: [-41.45, -51.5],
            width: 2.8,
            sill: 0.0,
            spring: 2.6,
            rise: 1.4,
        },
    },
    Door {
        name: "small door",
        from: Name::Gallery,
        to: Name::SecretPassage,
        gate: Gate {
            looks: Side::North,
            at: [-8.45, -81.45],
            width: 1.0,
            sill: 0.0,
            spring: 2.2,
            rise: 0.0,
        },
    },
    to_terrace("vestibule window 1", Name::Vestibule, -2.51),
    to_terrace("vestibule window 2", Name::Vestibule, -4.835),
    to_terrace("vestibule window 3", Name::Vestibule, -7.16),
    to_terrace("vestibule window 4", Name::Vestibule, -9.485),
    to_terrace("guard room window 1", Name::GuardRoom, -13.85),
    to_terrace("guard room window 2", Name::GuardRoom, -19.15),
    Door {
        name: "gallery's end",
        from: Name::Gallery,
        to: Name::Terrace,
        gate: Gate {
            looks: Side::South,
            at: [-11.0, -21.55],
            width: 2.0,
            sill: 0.9,
            spring: 3.2,
            rise: 1.0,
        },
    },
    to_garden("antechamber window 1", Name::Antechamber, -104.65),
    to_garden("antechamber window 2", Name::Antechamber, -109.35),
    to_garden("throne room window 1", Name::ThroneRoom, -114.27),
    to_garden("throne room window 2", Name::ThroneRoom, -117.02),
    to_garden("throne room window 3", Name::ThroneRoom, -119.77),
    Door {
        name: "painted gallery entrance",
        from: Name::Gallery,
        to: Name::PaintedLobby,
        gate: Gate {
            looks: Side::North,
            at: [-13.2, -81.45],
            width: 1.2,
            sill: 0.0,
            spring: 2.3,
            rise: 0.0,
        },
    },
    painted(
        "painted gallery 1",
        Name::PaintedLobby,
        Name::FirstThreshold,
        -15.0,
    ),
    painted("painted gallery 2", Name::FirstThreshold, Name::MorningBay, -15.5),
    painted(
        "painted gallery 3",
        Name::MorningBay,
        Name::SecondThreshold,
        -22.5,
    ),
    painted("painted gallery 4", Name::SecondThreshold, Name::Tribune, -23.0),
    painted("painted gallery 5", Name::Tribune, Name::ThirdThreshold, -32.5),
    painted("painted gallery 6", Name::ThirdThreshold, Name::EveningBay, -33.0),
    painted(
        "painted gallery 7",
        Name::EveningBay,
        Name::FourthThreshold,
        -40.0,
    ),
    painted("painted gallery 8", Name::FourthThreshold, Name::Belvedere, -40.5),
    over_the_garden("painted lobby window", Name::PaintedLobby, -12.5),
    over_the_garden("morning bay window 1", Name::MorningBay, -17.0),
    over_the_garden("morning bay window 2", Name::MorningBay, -21.0),
    // A French window to the garden, with a sill.
    Door {
        name: "garden window",
        from: Name::Tribune,
        to: Name::Garden,
        gate: Gate {
            looks: Side::North,
            at: [-27.75, -92.0],
            width: 2.2,
            sill: 0.15,
            spring: 2.9,
            rise: 0.9,
        },
    },
    over_the_garden("evening bay window 1", Name::EveningBay, -34.5),
    over_the_garden("evening bay window 2", Name::EveningBay, -38.5),
    over_the_garden("belvedere window", Name::Belvedere, -43.5),
];
