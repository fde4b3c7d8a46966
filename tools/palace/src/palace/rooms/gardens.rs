//! The terrace by the vestibule, a garden within walls.

use super::*;
use crate::envelope::Plan;
use crate::palace::plan::{HALF, STONEWORK, WALL};
use crate::palace::room::{Design, Style};

pub(crate) const TERRACE: Design = Design {
    name: "Terrace",
    plan: Plan::Rectangle([-30.0, -HALF - WALL], [-21.1, -WALL]),
    height: 6.4,
    ceiling: Ceiling::Sky,
    style: Style {
        wall: PALE_ASHLAR,
        trim: GRAVEL,
        reveal: PALE_STONE,
        ..STONEWORK
    },
};

/// Brightness of the sun.
const SUNSHINE: f32 = 2.4;

/// Lawns with statues, clipped yew and urns.
pub(super) fn terrace(room: &mut Room) {
    enclose(room);
    let beds = [
        ([-28.0, -19.6], [-19.2, -12.6]),
        ([-17.6, -9.6], [-19.2, -12.6]),
        ([-28.0, -19.6], [-9.4, -2.4]),
        ([-17.6, -9.6], [-9.4, -2.4]),
    ];
    lawns(room, &beds);
    let fountain = garden::fountain(room.shop, PALE_STONE);
    room.put("fountain", &fountain, spot(-18.6, -11.0, 0.0) * scaled(0.55));
    let [cone, stack] = [false, true].map(|stacked| garden::topiary(room.shop, stacked));
    let base = column::pedestal(room.shop, 0.8, 1.1, PALE_STONE, STONE);
    for (i, (x, z)) in beds.into_iter().enumerate() {
        for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let tree = if (a + b + i) % 2 == 0 { &cone } else { &stack };
            let inset = [0.8, -0.8];
            room.put("topiary", tree, spot(x[a] + inset[a], z[b] + inset[b], 0.0));
        }
        let middle = [0.5 * (x[0] + x[1]), 0.5 * (z[0] + z[1])];
        let statue = statue::figure(room.shop, Pose::ALL[i], WHITE_MARBLE, VERDIGRIS);
        let turn = 90.0 - 20.0 * i as f32;
        room.put("pedestal", &base, spot(middle[0], middle[1], turn));
        let on_top = spot(middle[0], middle[1], turn) * shift(0.0, 1.1, 0.0) * scaled(1.1);
        room.put("statue", &statue, on_top);
    }
    // Crowns must not extend through the walls.
    trees(
        room,
        &[
            (-26.6, -3.8),
            (-26.4, -17.6),
            (-18.6, -17.8),
            (-12.4, -17.6),
            (-22.4, -3.4),
        ],
    );
    let urn = ornament::urn(room.shop, TERRACOTTA, STONE);
    for z in [-1.4, -6.0, -8.3, -11.0, -16.5] {
        room.put("urn", &urn, spot(-8.3, z, 0.0) * scaled(1.2));
    }
}

/// Adds the sun, hedges along the walls, a cornice on them, and window frames.
fn enclose(room: &mut Room) {
    under_the_sky(room);
    let corners = room.design.plan.corners();
    cornice(room, &corners, room.design.height, 0.4);
    for side in [Side::West, Side::North, Side::South] {
        let wall = room.wall(side);
        let window = room
            .doorways
            .iter()
            .any(|door| door.wall == room.design.plan.wall(side));
        if window {
            continue;
        }
        let hedge = garden::hedge(room.shop, wall.length() - 0.6, 2.1);
        room.put(
            "hedge",
            &hedge,
            wall.at(0.5 * wall.length(), 0.0) * shift(0.0, 0.0, 0.3),
        );
    }
    court::window_cases(room);
}

/// The sun and the sky over a garden.
pub(crate) fn under_the_sky(room: &mut Room) {
    room.lamps.push(Lamp::sun(SUNSHINE));
    room.lamps.push(Lamp::sky(0.3 * SUNSHINE));
}

fn lawns(room: &mut Room, beds: &[([f32; 2], [f32; 2])]) {
    let mut shape = Shape::new();
    for (x, z) in beds {
        shape.join(block(LAWN, [x[0], 0.0, z[0]], [x[1], 0.05, z[1]]));
    }
    room.make("lawn", &shape);
}

fn trees(room: &mut Room, places: &[(f32, f32)]) {
    for (i, &(x, z)) in places.iter().enumerate() {
        let tree = garden::tree(room.shop, i as u64);
        let turn = room.random.between(0.0, 360.0);
        let size = room.random.between(1.0, 1.3);
        room.put("tree", &tree, spot(x, z, turn) * scaled(size));
    }
}
