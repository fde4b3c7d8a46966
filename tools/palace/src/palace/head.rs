//! Heads for statues and busts, as distance fields.

use super::sculpt::{both, cord, egg, joined, limb, mirrored, ramp, without};
use glam::{Vec3, vec3};

/// Hairstyle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hair {
    /// Waves, and a knot at the back.
    Knot,
    /// Short curls.
    Curls,
    /// A wig down to the shoulders.
    Wig,
    /// Curls and a beard.
    Beard,
}

/// A head facing +z, its chin at y = −0.5 and the crown of its skull at 0.5, with a neck to y = −0.95.
pub(crate) fn head(at: Vec3, hair: Hair) -> f32 {
    let face = face(at);
    match hair {
        Hair::Knot => joined(face, knotted(at), 0.006),
        Hair::Curls => joined(face, curly(at), 0.012),
        Hair::Wig => joined(face, wig(at), 0.03),
        Hair::Beard => joined(joined(face, curly(at), 0.03), beard(at), 0.03),
    }
}

fn face(at: Vec3) -> f32 {
    // One half; the other is its mirror image.
    let p = mirrored(at);
    let skull = egg(p, vec3(0.0, 0.14, -0.06), vec3(0.315, 0.36, 0.395));
    let cheeks = egg(p, vec3(0.0, -0.09, 0.085), vec3(0.262, 0.325, 0.262));
    let mut d = joined(skull, cheeks, 0.14);
    let jaw = limb(
        p,
        [vec3(0.215, -0.16, -0.02), vec3(0.06, -0.42, 0.225)],
        [0.085, 0.075],
    );
    d = joined(d, jaw, 0.12);
    d = joined(
        d,
        egg(p, vec3(0.0, -0.425, 0.255), vec3(0.085, 0.075, 0.075)),
        0.07,
    );
    let neck = limb(
        p,
        [vec3(0.0, -0.20, -0.10), vec3(0.0, -0.95, -0.13)],
        [0.215, 0.225],
    );
    let tendon = limb(
        p,
        [vec3(0.22, -0.22, -0.10), vec3(0.06, -0.88, 0.09)],
        [0.05, 0.05],
    );
    d = joined(d, joined(neck, tendon, 0.10), 0.05);
    d = joined(
        d,
        egg(p, vec3(0.175, -0.06, 0.215), vec3(0.085, 0.07, 0.075)),
        0.09,
    );
    // Sockets below the brow, and the eyes in them between two lids.
    let brow = cord(
        p,
        &[
            vec3(0.035, 0.095, 0.325),
            vec3(0.11, 0.125, 0.315),
            vec3(0.205, 0.085, 0.225),
        ],
        0.03,
    );
    d = joined(d, brow, 0.05);
    d = without(
        d,
        egg(p, vec3(0.118, 0.025, 0.37), vec3(0.09, 0.062, 0.085)),
        0.05,
    );
    d = joined(d, egg(p, vec3(0.118, 0.018, 0.252), Vec3::splat(0.066)), 0.012);
    let upper_lid = cord(
        p,
        &[
            vec3(0.055, 0.012, 0.298),
            vec3(0.09, 0.042, 0.3175),
            vec3(0.135, 0.044, 0.315),
            vec3(0.185, 0.008, 0.275),
        ],
        0.0135,
    );
    let lower_lid = cord(
        p,
        &[
            vec3(0.058, 0.006, 0.295),
            vec3(0.095, -0.020, 0.310),
            vec3(0.140, -0.018, 0.305),
            vec3(0.183, 0.004, 0.272),
        ],
        0.010,
    );
    d = joined(d, upper_lid.min(lower_lid), 0.012);
    // The nose runs on from the forehead without a dent, as the Greeks liked it.
    let nose = limb(
        p,
        [vec3(0.0, 0.11, 0.325), vec3(0.0, -0.115, 0.425)],
        [0.036, 0.040],
    );
    d = joined(d, nose, 0.045);
    d = joined(
        d,
        egg(p, vec3(0.045, -0.128, 0.365), vec3(0.034, 0.032, 0.042)),
        0.025,
    );
    d = without(d, egg(p, vec3(0.024, -0.165, 0.395), Vec3::splat(0.014)), 0.015);
    d = without(
        d,
        limb(p, [vec3(0.0, -0.18, 0.375), vec3(0.0, -0.21, 0.365)], [0.012; 2]),
        0.02,
    );
    // Lips, with the line between them and the dent above the chin.
    let muzzle = egg(p, vec3(0.0, -0.245, 0.255), vec3(0.115, 0.09, 0.085));
    d = joined(d, muzzle, 0.06);
    let upper_lip = limb(
        p,
        [vec3(0.018, -0.222, 0.342), vec3(0.08, -0.248, 0.300)],
        [0.020, 0.011],
    );
    let lower_lip = limb(
        p,
        [vec3(0.0, -0.277, 0.338), vec3(0.07, -0.258, 0.302)],
        [0.026, 0.012],
    );
    d = joined(d, upper_lip.min(lower_lip), 0.018);
    let line = limb(
        p,
        [vec3(0.0, -0.249, 0.368), vec3(0.092, -0.254, 0.308)],
        [0.008, 0.006],
    );
    d = without(d, line, 0.014);
    d = without(d, egg(p, vec3(0.0, -0.338, 0.372), vec3(0.07, 0.03, 0.05)), 0.05);
    let ear = egg(
        vec3(p.x, p.y - 0.35 * (p.z + 0.04), p.z),
        vec3(0.312, 0.0, -0.05),
        vec3(0.035, 0.105, 0.062),
    );
    let hollow = egg(p, vec3(0.350, 0.01, -0.035), vec3(0.024, 0.06, 0.034));
    joined(d, without(ear, hollow, 0.02), 0.02)
}

/// The part of the head that hair grows on: behind a line from the forehead past the ears to the nape.
fn scalp(at: Vec3, grown: f32) -> f32 {
    let p = mirrored(at);
    let cap = egg(p, vec3(0.0, 0.145, -0.075), vec3(0.325, 0.37, 0.405) + grown);
    // The line is higher over the forehead than over the temples.
    let front = 0.62 * (0.285 - p.y - 0.35 * p.x) - 0.78 * (0.215 - p.z);
    both(both(cap, front, 0.03), -0.26 - p.y, 0.05)
}

/// Curls as bumps that are turned against each other.
fn curls(at: Vec3, size: f32) -> f32 {
    let p = at / size;
    let bent = p + 0.6 * vec3((1.7 * p.y).sin(), (1.9 * p.z).sin(), (1.6 * p.x).sin());
    let lock = bent.x.sin() * bent.y.cos() + bent.y.sin() * bent.z.cos() + bent.z.sin() * bent.x.cos();
    let strand = (3.0 * lock + 2.0 * bent.x).sin();
    0.60 * lock + 0.10 * strand
}

fn curly(at: Vec3) -> f32 {
    0.7 * (scalp(at, 0.045) - 0.032 * curls(at, 0.052))
}

fn beard(at: Vec3) -> f32 {
    let p = mirrored(at);
    let chin = egg(p, vec3(0.0, -0.47, 0.205), vec3(0.185, 0.20, 0.15));
    let sides = limb(
        p,
        [vec3(0.265, -0.02, -0.01), vec3(0.12, -0.40, 0.17)],
        [0.05, 0.10],
    );
    let mass = joined(chin, sides, 0.08);
    let mouth = egg(p, vec3(0.0, -0.255, 0.37), vec3(0.085, 0.045, 0.12));
    let moustache = limb(
        p,
        [vec3(0.02, -0.198, 0.365), vec3(0.125, -0.285, 0.285)],
        [0.026, 0.028],
    );
    let mass = joined(without(mass, mouth, 0.04), moustache, 0.02);
    0.7 * (mass - 0.024 * curls(vec3(at.x, 0.6 * at.y, at.z), 0.045))
}

/// Hair that is combed back from a parting in waves, in a roll around the face and a knot at the nape.
fn knotted(at: Vec3) -> f32 {
    let p = mirrored(at);
    let round = p.z.atan2(p.y - 0.1);
    let strands = (40.0 * p.x + 2.0 * (4.0 * round).sin()).sin();
    let parting = 0.02 * (1.0 - ramp(0.0, 0.03, p.x)) * ramp(-0.25, 0.0, p.z);
    let cap = scalp(at, 0.045) - 0.010 * strands + parting;
    let twist = (52.0 * (p.y + 0.8 * p.x - 0.9 * p.z)).sin();
    let roll = cord(
        p,
        &[
            vec3(0.02, 0.415, 0.235),
            vec3(0.135, 0.365, 0.255),
            vec3(0.245, 0.250, 0.200),
            vec3(0.322, 0.110, 0.085),
            vec3(0.340, 0.0, -0.075),
            vec3(0.260, -0.10, -0.245),
            vec3(0.10, -0.12, -0.40),
        ],
        0.066 + 0.009 * twist,
    );
    let off = at - vec3(0.0, -0.02, -0.50);
    let coil = (9.0 * off.y.atan2(off.x) + 60.0 * off.x.hypot(off.y)).sin();
    let knot = egg(off, Vec3::ZERO, vec3(0.135, 0.125, 0.11)) - 0.010 * coil;
    0.75 * joined(joined(cap, roll, 0.025), knot, 0.03)
}

/// A full-bottomed wig: two peaks above the forehead, and rolls of curls down to the shoulders.
fn wig(at: Vec3) -> f32 {
    let p = mirrored(at);
    let peak = egg(p, vec3(0.11, 0.42, 0.10), vec3(0.15, 0.14, 0.17));
    let sides = cord(
        p,
        &[
            vec3(0.22, 0.36, 0.06),
            vec3(0.335, 0.12, -0.03),
            vec3(0.375, -0.22, -0.03),
            vec3(0.385, -0.52, 0.03),
            vec3(0.33, -0.80, 0.12),
        ],
        0.115,
    );
    let back = egg(p, vec3(0.0, -0.22, -0.34), vec3(0.36, 0.60, 0.17));
    let mass = joined(
        joined(joined(scalp(at, 0.05), peak, 0.06), sides, 0.06),
        back,
        0.10,
    );
    let rolls = (34.0 * p.y + 6.0 * p.x + 3.0 * (9.0 * p.z).sin()).sin();
    0.65 * (mass - 0.020 * rolls - 0.012 * curls(at, 0.05))
}
