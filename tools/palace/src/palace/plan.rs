//! Plan of the palace: position, shape and colors of every room, and the doors between rooms.
//!
//! The enfilade runs along −z at x = 0, through twelve rooms; a gallery and a court are west of it, cabinets east.
//! North of the court a wing of convex cells, the painted gallery, faces the garden, as the last rooms of the enfilade
//! do. Half of every wall belongs to the room on either side: rooms end at the planes of their doors and never extend
//! over them.

use super::floor::Floor;
pub(crate) use super::name::Name;
use super::palette::*;
use super::room::{Design, Style};
use crate::envelope::{Axis, Ceiling, Plan, Side};

/// Half the thickness of a wall.
pub(crate) const WALL: f32 = 0.45;

/// Positions of the enfilade's doors, as z, from the first to the last.
pub(crate) const DOORS_AT: [f32; 11] = [
    -12.0, -21.0, -31.0, -40.0, -54.0, -63.0, -72.0, -82.0, -93.0, -103.0, -111.0,
];

/// Half the width of the enfilade's rooms, to the middle of the walls.
pub(crate) const HALF: f32 = 7.0;

const fn enfilade(first: f32, last: f32) -> Plan {
    Plan::Rectangle([WALL - HALF, HALF - WALL], [last + WALL, first - WALL])
}

/// White and gold over a colored dado.
const GILDED: Style = Style {
    floor: Floor::Bare,
    trim: IVORY,
    gilt: GOLD,
    dado: IVORY,
    wall: PLASTER,
    field: PLASTER,
    ceiling: IVORY,
    reveal: IVORY,
};

pub(crate) const STONEWORK: Style = Style {
    floor: Floor::Bare,
    trim: PALE_STONE,
    gilt: STONE,
    dado: STONE,
    wall: PALE_STONE,
    field: PALE_STONE,
    ceiling: PLASTER,
    reveal: STONE,
};

/// The rooms, in the order of [`Name`].
pub(crate) const ROOMS: [Design; 22] = [
    Design {
        name: "Vestibule",
        plan: Plan::Rectangle([WALL - HALF, HALF - WALL], [DOORS_AT[0] + WALL, -WALL]),
        height: 5.4,
        ceiling: Ceiling::Vault(Axis::NorthSouth, 3.6),
        style: Style {
            floor: Floor::Checker(0.7, [WHITE_MARBLE, BLACK_MARBLE]),
            dado: GREEN_MARBLE,
            wall: PALE_ASHLAR,
            field: PLASTER,
            gilt: OLD_GOLD,
            ..STONEWORK
        },
    },
    Design {
        name: "Guard Room",
        plan: enfilade(DOORS_AT[0], DOORS_AT[1]),
        height: 6.0,
        ceiling: Ceiling::Flat,
        style: Style {
            floor: Floor::Octagons(0.9, [TERRACOTTA, STONE, DARK_STONE]),
            trim: OAK,
            gilt: WALNUT,
            dado: OAK,
            wall: ASHLAR,
            field: PLASTER,
            ceiling: PLANKS,
            reveal: OAK,
        },
    },
    Design {
        name: "Red Salon",
        plan: enfilade(DOORS_AT[1], DOORS_AT[2]),
        height: 6.2,
        ceiling: Ceiling::Cove(1.5, 1.2),
        style: Style {
            floor: Floor::Herringbone(0.16, [OAK, PALE_OAK, WALNUT]),
            dado: DARK_RED,
            wall: DARK_RED,
            field: RED_SILK,
            ..GILDED
        },
    },
    Design {
        name: "Green Salon",
        plan: enfilade(DOORS_AT[2], DOORS_AT[3]),
        height: 6.6,
        ceiling: Ceiling::Flat,
        style: Style {
            floor: Floor::Parquet(1.2, [WALNUT, OAK, PALE_OAK]),
            dado: PALE_GREEN,
            wall: PALE_GREEN,
            field: GREEN_SILK,
            ..GILDED
        },
    },
    Design {
        name: "Rotunda",
        plan: Plan::Round([0.0, -47.0], 6.55, 12),
        height: 7.2,
        ceiling: Ceiling::Dome(5.6, 1.5),
        style: Style {
            floor: Floor::Star(0.8, [WHITE_MARBLE, RED_MARBLE, GREEN_MARBLE]),
            dado: GREEN_MARBLE,
            ceiling: PALE_BLUE,
            reveal: WHITE_MARBLE,
            ..STONEWORK
        },
    },
    Design {
        name: "Blue Salon",
        plan: enfilade(DOORS_AT[4], DOORS_AT[5]),
        height: 6.2,
        ceiling: Ceiling::Cove(1.3, 1.3),
        style: Style {
            floor: Floor::Herringbone(0.18, [PALE_OAK, OAK, PALE_OAK]),
            dado: PALE_BLUE,
            wall: PALE_BLUE,
            field: BLUE_SILK,
            ..GILDED
        },
    },
    Design {
        name: "Mirror Room",
        plan: enfilade(DOORS_AT[5], DOORS_AT[6]),
        height: 6.4,
        ceiling: Ceiling::Cove(1.0, 1.0),
        style: Style {
            floor: Floor::Cubes(0.5, [WHITE_MARBLE, STONE, BLACK_MARBLE]),
            dado: ROSE,
            ..GILDED
        },
    },
    Design {
        name: "Music Room",
        plan: enfilade(DOORS_AT[6], DOORS_AT[7]),
        height: 6.4,
        ceiling: Ceiling::Flat,
        style: Style {
            floor: Floor::Parquet(1.0, [MAHOGANY, PALE_OAK, OAK]),
            dado: ROSE,
            wall: IVORY,
            field: ROSE,
            ..GILDED
        },
    },
    Design {
        name: "Library",
        plan: enfilade(DOORS_AT[7], DOORS_AT[8]),
        height: 5.6,
        ceiling: Ceiling::Vault(Axis::NorthSouth, 2.4),
        style: Style {
            floor: Floor::Herringbone(0.2, [WALNUT, MAHOGANY, OAK]),
            trim: WALNUT,
            gilt: OLD_GOLD,
            dado: MAHOGANY,
            wall: WALNUT,
            field: MAHOGANY,
            ceiling: PLASTER,
            reveal: WALNUT,
        },
    },
    Design {
        name: "Picture Room",
        plan: enfilade(DOORS_AT[8], DOORS_AT[9]),
        height: 7.0,
        ceiling: Ceiling::Cove(2.0, 1.4),
        style: Style {
            floor: Floor::Octagons(1.0, [PALE_OAK, OAK, EBONY]),
            dado: WALNUT,
            wall: GREEN_SILK,
            field: GREEN_SILK,
            trim: WALNUT,
            gilt: OLD_GOLD,
            reveal: WALNUT,
            ..GILDED
        },
    },
    Design {
        name: "Antechamber",
        plan: enfilade(DOORS_AT[9], DOORS_AT[10]),
        height: 6.0,
        ceiling: Ceiling::Flat,
        style: Style {
            floor: Floor::Checker(0.6, [RED_MARBLE, WHITE_MARBLE]),
            dado: IVORY,
            wall: PLASTER,
            field: YELLOW_SILK,
            ..GILDED
        },
    },
    Design {
        name: "Throne Room",
        plan: Plan::Apse(
            [WALL - HALF, HALF - WALL],
            [-122.0, DOORS_AT[10] - WALL],
            Side::North,
        ),
        height: 6.4,
        ceiling: Ceiling::Vault(Axis::NorthSouth, 5.2),
        style: Style {
            floor: Floor::Octagons(1.2, [WHITE_MARBLE, IVORY, RED_MARBLE]),
            trim: WHITE_MARBLE,
            dado: RED_MARBLE,
            wall: DARK_RED,
            field: RED_SILK,
            ceiling: NIGHT_BLUE,
            reveal: WHITE_MARBLE,
            ..GILDED
        },
    },
    Design {
        name: "Gallery",
        plan: Plan::Rectangle([-14.55, -HALF - WALL], [-81.0, -22.0]),
        height: 5.2,
        ceiling: Ceiling::Vault(Axis::NorthSouth, 2.6),
        style: Style {
            floor: Floor::Checker(0.9, [WHITE_MARBLE, GREEN_MARBLE]),
            trim: WHITE_MARBLE,
            dado: GREEN_MARBLE,
            ..GILDED
        },
    },
    Design {
        name: "Court",
        plan: Plan::Rectangle([-41.0, -15.45], [-76.0, -27.0]),
        height: 9.0,
        ceiling: Ceiling::Sky,
        style: Style {
            wall: PALE_ASHLAR,
            trim: GRAVEL,
            reveal: PALE_STONE,
            ..STONEWORK
        },
    },
    Design {
        name: "Porcelain Cabinet",
        plan: Plan::Rectangle([HALF + WALL, 15.0], [-39.0, -32.0]),
        height: 4.6,
        ceiling: Ceiling::Cove(0.9, 0.8),
        style: Style {
            floor: Floor::Checker(0.45, [PORCELAIN, COBALT]),
            dado: PALE_BLUE,
            wall: IVORY,
            field: PALE_BLUE,
            ..GILDED
        },
    },
    Design {
        name: "Chapel",
        plan: Plan::Apse([HALF + WALL, 16.0], [-51.0, -43.0], Side::East),
        height: 5.0,
        ceiling: Ceiling::Vault(Axis::WestEast, 4.0),
        style: Style {
            floor: Floor::Octagons(0.8, [WHITE_MARBLE, PALE_STONE, BLACK_MARBLE]),
            dado: RED_MARBLE,
            ceiling: NIGHT_BLUE,
            ..STONEWORK
        },
    },
    Design {
        name: "Winter Garden",
        plan: Plan::Rectangle([HALF + WALL, 17.0], [-67.5, -55.5]),
        height: 6.0,
        ceiling: Ceiling::Vault(Axis::NorthSouth, 2.6),
        style: Style {
            floor: Floor::Octagons(0.7, [PALE_STONE, WHITE_MARBLE, VERDIGRIS]),
            trim: WHITE_MARBLE,
            gilt: VERDIGRIS,
            dado: WHITE_MARBLE,
            wall: PALE_GREEN,
            field: IVORY,
            ceiling: SKYLIGHT,
            reveal: WHITE_MARBLE,
        },
    },
    Design {
        name: "Study",
        plan: Plan::Rectangle([HALF + WALL, 15.0], [-92.0, -83.5]),
        height: 4.6,
        ceiling: Ceiling::Flat,
        style: Style {
            floor: Floor::Parquet(0.9, [EBONY, WALNUT, OAK]),
            trim: MAHOGANY,
            gilt: OLD_GOLD,
            dado: MAHOGANY,
            wall: GREEN_SILK,
            field: GREEN_SILK,
            ceiling: PLANKS,
            reveal: MAHOGANY,
        },
    },
    Design {
        name: "Treasury",
        plan: Plan::Rectangle([HALF + WALL, 15.0], [-29.8, -22.2]),
        height: 4.4,
        ceiling: Ceiling::Vault(Axis::WestEast, 1.8),
        style: Style {
            floor: Floor::Cubes(0.4, [STONE, DARK_STONE, PALE_STONE]),
            dado: DARK_STONE,
            wall: ASHLAR,
            field: DARK_RED,
            ..STONEWORK
        },
    },
    super::secret::DESIGN,
    super::rooms::gardens::TERRACE,
    super::park::GARDEN,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_room_stands_at_the_place_of_its_name() {
        for (name, expected) in [
            (Name::Vestibule, "Vestibule"),
            (Name::Rotunda, "Rotunda"),
            (Name::ThroneRoom, "Throne Room"),
            (Name::Gallery, "Gallery"),
            (Name::Treasury, "Treasury"),
            (Name::SecretPassage, "Secret Passage"),
            (Name::Garden, "Garden"),
        ] {
            assert_eq!(ROOMS[name as usize].name, expected);
        }
    }
}
