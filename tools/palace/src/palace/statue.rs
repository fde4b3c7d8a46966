//! Statues: draped figures and busts.

use super::head::{Hair, head};
use super::room::shift;
use super::sculpt::{Carved, both, carve, cord, egg, joined, limb, mirrored, ramp, ring, without};
use super::workshop::Workshop;
use crate::shape::{Shape, ball, lathe, round_tube};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Mat3, Vec3, vec3};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// Pose and attributes of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pose {
    /// One arm raised with a torch.
    Torch,
    /// A globe held at the breast.
    Globe,
    /// A jug hanging from one hand.
    Jug,
    /// Leaning on a staff.
    Staff,
    /// Both arms raised to a bowl on the head.
    Bowl,
}

impl Pose {
    pub(crate) const ALL: [Pose; 5] = [Pose::Torch, Pose::Globe, Pose::Jug, Pose::Staff, Pose::Bowl];

    fn hair(self) -> Hair {
        match self {
            Pose::Staff => Hair::Beard,
            _ => Hair::Knot,
        }
    }

    fn is_man(self) -> bool {
        self == Pose::Staff
    }
}

/// Metres from chin to crown.
const FIGURE_HEAD: f32 = 0.252;
const BUST_HEAD: f32 = 0.27;

/// An arm: elbow, wrist, and what the hand does.
struct Arm {
    elbow: Vec3,
    wrist: Vec3,
    hand: Hand,
}

/// What a hand does.
enum Hand {
    /// Closed around an upright shaft through a point, of some radius.
    Grip(Vec3, f32),
    /// Open: direction of its fingers, and of its palm.
    Open(Vec3, Vec3),
}

/// Grips of the torch, the neck of the jug, and the staff.
const TORCH: Vec3 = vec3(-0.375, 1.855, 0.165);
const JUG: Vec3 = vec3(0.335, 1.0, 0.185);
const STAFF: Vec3 = vec3(-0.27, 1.31, 0.225);
const GLOBE: Vec3 = vec3(0.01, 1.235, 0.285);
const GLOBE_RADIUS: f32 = 0.105;

/// Right and left arm.
fn arms(pose: Pose) -> [Arm; 2] {
    let arm = |elbow: [f32; 3], wrist: [f32; 3], hand: Hand| Arm {
        elbow: elbow.into(),
        wrist: wrist.into(),
        hand,
    };
    let open = |fingers: [f32; 3], palm: [f32; 3]| {
        let fingers = Vec3::from(fingers).normalize();
        let palm = Vec3::from(palm);
        Hand::Open(fingers, (palm - fingers * palm.dot(fingers)).normalize())
    };
    let hanging = |side: f32| {
        arm(
            [0.305 * side, 1.14, -0.05],
            [0.315 * side, 0.90, 0.05],
            open([-0.1 * side, -1.0, 0.25], [-side, 0.0, -0.2]),
        )
    };
    match pose {
        Pose::Torch => [
            arm(
                [-0.42, 1.56, 0.0],
                [-0.385, 1.80, 0.105],
                Hand::Grip(TORCH, 0.014),
            ),
            hanging(1.0),
        ],
        Pose::Globe => [-1.0, 1.0].map(|side| {
            arm(
                [0.305 * side, 1.15, -0.01],
                [0.155 * side, 1.12, 0.20],
                open([-0.55 * side, 0.0, 0.85], [-0.8 * side, 0.6, -0.1]),
            )
        }),
        Pose::Jug => [
            hanging(-1.0),
            arm([0.325, 1.17, -0.04], [0.33, 1.03, 0.12], Hand::Grip(JUG, 0.026)),
        ],
        Pose::Staff => [
            arm(
                [-0.31, 1.17, 0.02],
                [-0.285, 1.285, 0.165],
                Hand::Grip(STAFF, 0.014),
            ),
            arm(
                [0.305, 1.15, -0.03],
                [0.215, 1.06, 0.155],
                open([-0.95, -0.1, 0.25], [-0.25, 0.0, -0.95]),
            ),
        ],
        Pose::Bowl => [-1.0, 1.0].map(|side| {
            arm(
                [0.36 * side, 1.60, 0.03],
                [0.245 * side, 1.845, 0.04],
                open([0.05 * side, 1.0, 0.0], [-side, 0.0, 0.0]),
            )
        }),
    }
}

/// A draped figure, 1.9 m tall, at the origin, facing +z.
pub(crate) fn figure(shop: &mut Workshop, pose: Pose, stone: MaterialId, gilt: MaterialId) -> Arc<Mesh> {
    let body = shop.carved(format!("figure {pose:?}"), || body(pose));
    shop.mesh(format!("figure {pose:?} {} {}", stone.0, gilt.0), || {
        let foot = [
            [0.0, -0.06],
            [0.37, -0.06],
            [0.385, -0.03],
            [0.37, 0.0],
            [0.0, 0.0],
        ];
        let mut shape = lathe(stone, &foot, 32);
        carry(&mut shape, pose, gilt);
        body.mesh(stone, &shape, 0.06)
    })
}

fn body(pose: Pose) -> Carved {
    let [turn, nod] = match pose {
        Pose::Bowl => [0.0, 0.0],
        _ => [0.30 - 0.14 * f32::from(pose as u8), 0.10],
    };
    let turned = Mat3::from_rotation_y(turn) * Mat3::from_rotation_x(nod);
    let middle = vec3(sway(1.7), 1.688, 0.015);
    let clothes = carve(
        [vec3(-0.50, -0.04, -0.38), vec3(0.50, 2.08, 0.44)],
        0.0078,
        3300,
        |at| clothes(at, pose),
    );
    let bare = carve(
        [vec3(-0.50, 0.66, -0.26), vec3(0.50, 2.08, 0.44)],
        0.0040,
        3700,
        |at| {
            let own = turned.transpose() * (at - middle) / FIGURE_HEAD;
            let head = joined(FIGURE_HEAD * head(own, pose.hair()), chest(at), 0.03);
            (shoulders().into_iter().zip(arms(pose)))
                .map(|(shoulder, arm)| limbs(at, shoulder, &arm))
                .fold(head, f32::min)
        },
    );
    clothes.join(bare)
}

/// Contrapposto: sideways offset of the body at a height.
fn sway(height: f32) -> f32 {
    0.035 * (PI * (height / 1.5).clamp(0.0, 1.2)).sin() - 0.012 * height
}

/// Skin below the neck, hidden by clothes except at the neckline.
fn chest(at: Vec3) -> f32 {
    let p = mirrored(at - Vec3::X * sway(at.y));
    let trunk = egg(p, vec3(0.0, 1.36, -0.012), vec3(0.115, 0.11, 0.075));
    let shoulders = limb(
        p,
        [vec3(0.0, 1.46, -0.02), vec3(0.13, 1.435, -0.02)],
        [0.055, 0.04],
    );
    joined(trunk, shoulders, 0.06)
}

/// Half width and half depth of the skirt at a height.
fn skirt_size(height: f32) -> [f32; 2] {
    const SIZES: [[f32; 3]; 8] = [
        [-0.10, 0.262, 0.232],
        [0.05, 0.255, 0.225],
        [0.30, 0.225, 0.195],
        [0.60, 0.205, 0.175],
        [0.85, 0.192, 0.158],
        [0.98, 0.180, 0.142],
        [1.10, 0.145, 0.112],
        [1.30, 0.150, 0.115],
    ];
    let above = SIZES
        .iter()
        .position(|row| row[0] > height)
        .unwrap_or(SIZES.len() - 1)
        .max(1);
    let [low, high] = [SIZES[above - 1], SIZES[above]];
    let part = ((height - low[0]) / (high[0] - low[0])).clamp(0.0, 1.0);
    [1, 2].map(|i| low[i] + (high[i] - low[i]) * part)
}

/// Pipes of falling cloth: round ridges, narrow valleys; between −1 and about 0.6.
fn pipes(angle: f32, count: f32, turn: f32) -> f32 {
    let along = 0.5 * count * angle + turn;
    0.6 - 1.6 * (1.0 - along.sin().abs()).powi(2)
}

fn shoulders() -> [Vec3; 2] {
    [-1.0, 1.0].map(|side| vec3(sway(1.42) + 0.168 * side, 1.425, -0.015))
}

/// All clothes and the feet of a figure.
fn clothes(at: Vec3, pose: Pose) -> f32 {
    let seed = pose as u8 as f32;
    let p = at - Vec3::X * sway(at.y);
    let angle = p.x.atan2(p.z);
    let around = |[wide, deep]: [f32; 2]| -> f32 {
        let off = vec3(p.x / wide, 0.0, p.z / deep);
        let length = off.length().max(1e-4);
        (length - 1.0) * length / vec3(off.x / wide, 0.0, off.z / deep).length().max(1e-4)
    };
    // The free leg presses through the cloth, which is smooth there and falls in folds beside it.
    let knee = vec3(-0.105, 0.53, 0.135);
    let leg = limb(at, [vec3(-0.085, 0.95, 0.03), knee], [0.105, 0.082]).min(limb(
        at,
        [knee, vec3(-0.115, 0.10, 0.07)],
        [0.080, 0.060],
    ));
    let fall = ramp(1.12, 0.70, p.y);
    let wander = 0.25 * (2.3 * p.y + seed).sin() + 0.12 * (7.0 * p.y + 3.0 * angle).sin();
    let folds =
        pipes(angle + 0.12 * wander, 13.0, wander + seed) + 0.45 * pipes(angle, 29.0, 1.3 * seed + wander);
    let smooth = ramp(-0.01, 0.06, leg);
    let skirt = around(skirt_size(p.y)) - (0.006 + 0.020 * fall) * folds * smooth;
    let mut cloth = joined(skirt, leg - 0.004 * folds, 0.07);
    cloth = both(cloth, p.y - 1.20, 0.03);
    cloth = both(cloth, 0.012 * (5.0 * angle + seed).sin() + 0.006 - p.y, 0.01);
    // Feet before the hem.
    for (heel, toe) in [
        (vec3(-0.115, 0.035, 0.10), vec3(-0.135, 0.026, 0.285)),
        (vec3(0.095, 0.035, 0.10), vec3(0.135, 0.026, 0.265)),
    ] {
        cloth = joined(
            cloth,
            limb(at, [heel, toe], [0.042, 0.030]).max(-at.y - 0.005),
            0.015,
        );
    }
    let torso = torso(p, pose);
    // The overfold: from the belt over the hips, with a hem that hangs lower at the sides.
    let hem = 0.86 + 0.05 * (2.0 * angle).cos() + 0.022 * pipes(angle, 11.0, seed);
    let [wide, deep] = skirt_size(p.y);
    let flare = 0.018 + 0.030 * ramp(1.10, 0.84, p.y);
    let over =
        around([wide + flare, deep + flare]) - 0.013 * pipes(angle + 0.1 * wander, 15.0, seed + 1.0 + wander);
    let over = both(both(over, hem - p.y, 0.008), p.y - 1.13, 0.04);
    let blouse = ring(
        vec3(p.x, p.y, 1.30 * p.z),
        Vec3::Y * 1.095,
        Vec3::Y,
        0.128,
        0.036 + 0.006 * pipes(angle, 17.0, seed),
    ) * 0.8;
    let belt = ring(vec3(p.x, p.y, 1.28 * p.z), Vec3::Y * 1.135, Vec3::Y, 0.148, 0.013) * 0.8;
    let mut d = joined(cloth, over, 0.012);
    d = joined(d, torso, 0.02);
    d = joined(d, blouse, 0.02);
    d = d.min(belt);
    d = d.min(mantle(p, pose));
    for (shoulder, arm) in shoulders().into_iter().zip(arms(pose)) {
        d = joined(d, sleeve(at, shoulder, arm.elbow, seed), 0.025);
    }
    0.8 * d
}

/// The dress above the belt, with a round neckline and folds that hang from shoulder to shoulder.
fn torso(p: Vec3, pose: Pose) -> f32 {
    let q = mirrored(p);
    let ribs = egg(q, vec3(0.0, 1.28, -0.005), vec3(0.162, 0.215, 0.116));
    let waist = egg(q, vec3(0.0, 1.13, -0.002), vec3(0.142, 0.13, 0.104));
    let shoulders = limb(
        q,
        [vec3(0.05, 1.445, -0.018), vec3(0.160, 1.420, -0.018)],
        [0.064, 0.064],
    );
    let mut d = joined(joined(ribs, waist, 0.08), shoulders, 0.09);
    let breast = if pose.is_man() {
        egg(q, vec3(0.075, 1.335, 0.055), vec3(0.085, 0.062, 0.062))
    } else {
        egg(q, vec3(0.074, 1.300, 0.080), vec3(0.067, 0.070, 0.064))
    };
    d = joined(d, breast, 0.045);
    // Hanging arcs, deepest in the middle of the front and the back.
    let arc = p.y + 1.9 * p.x * p.x;
    let front = ramp(0.0, 0.06, p.z.abs());
    let arcs = (TAU * arc / 0.052 + 1.2 * (8.0 * p.x).sin()).sin();
    let pulls = (TAU * (p.x + 0.25 * (p.y - 1.1) * p.x.signum()) / 0.035).sin();
    let high = ramp(1.26, 1.36, p.y);
    d -= 0.0045 * front * (arcs * high + pulls * (1.0 - high));
    let neckline = egg(q, vec3(0.0, 1.515, 0.05), vec3(0.100, 0.095, 0.16));
    without(d, neckline, 0.012)
}

/// A rolled cloak from the left shoulder across the breast to the right hip and up the back.
fn mantle(p: Vec3, pose: Pose) -> f32 {
    let path = [
        vec3(0.150, 1.475, -0.03),
        vec3(0.120, 1.465, 0.055),
        vec3(0.065, 1.375, 0.125),
        vec3(-0.035, 1.255, 0.148),
        vec3(-0.115, 1.150, 0.110),
        vec3(-0.168, 1.075, 0.030),
        vec3(-0.150, 1.080, -0.070),
        vec3(-0.060, 1.160, -0.125),
        vec3(0.050, 1.310, -0.128),
        vec3(0.125, 1.435, -0.085),
        vec3(0.150, 1.475, -0.03),
    ];
    // Three pleats beside each other.
    let across = vec3(0.78, -0.62, 0.0);
    let roll = [-0.028, 0.0, 0.028]
        .map(|off| cord(p - across * off, &path, 0.017))
        .into_iter()
        .reduce(|a, b| joined(a, b, 0.003))
        .unwrap_or(f32::MAX);
    if pose != Pose::Staff && pose != Pose::Torch {
        return roll;
    }
    // A panel that falls from the left shoulder down the back.
    let fall = ramp(1.45, 0.5, p.y);
    let panel = vec3(p.x - 0.075, p.y - 0.86, p.z + 0.155 + 0.075 * fall);
    let wide = 0.07 + 0.055 * fall;
    let folds = 0.012 * (TAU * panel.x / (0.35 * wide)).cos();
    let slab = vec3(
        panel.x.abs() - wide,
        panel.y.abs() - 0.58,
        (panel.z - folds).abs() - 0.022,
    );
    let outside = slab.max(Vec3::ZERO).length() + slab.max_element().min(0.0);
    joined(roll, 0.7 * (outside - 0.006), 0.03)
}

fn sleeve(at: Vec3, shoulder: Vec3, elbow: Vec3, seed: f32) -> f32 {
    let end = shoulder.lerp(elbow, 0.62);
    let along = (end - shoulder).normalize();
    let off = at - shoulder;
    let up = off.dot(along);
    let side = off - along * up;
    let turn = side.x.atan2(side.z + side.y);
    let folds = 0.006 * pipes(turn, 9.0, seed + 9.0 * up);
    let tube = limb(at, [shoulder, end], [0.066, 0.080]) - folds * ramp(0.0, 0.06, up);
    let length = shoulder.distance(end);
    both(tube, up - length - 0.012 * (3.0 * turn).sin(), 0.008)
}

fn limbs(at: Vec3, shoulder: Vec3, arm: &Arm) -> f32 {
    let upper = limb(at, [shoulder, arm.elbow], [0.052, 0.040]);
    let muscle = arm.elbow.lerp(arm.wrist, 0.25);
    let fore = joined(
        limb(at, [arm.elbow, arm.wrist], [0.038, 0.0255]),
        limb(at, [arm.elbow, muscle], [0.036, 0.041]),
        0.03,
    );
    joined(joined(upper, fore, 0.02), hand(at, arm), 0.012)
}

fn hand(at: Vec3, arm: &Arm) -> f32 {
    const APART: f32 = 0.0205;
    match arm.hand {
        Hand::Grip(grip, radius) => {
            let back = grip + (arm.wrist - grip).normalize() * (radius + 0.016);
            let palm = limb(at, [arm.wrist, back], [0.026, 0.033]);
            let fingers = (0..4)
                .map(|i| {
                    let middle = grip + Vec3::Y * APART * (i as f32 - 1.5);
                    let thick = [0.0105, 0.0115, 0.0120, 0.0115][i];
                    ring(at, middle, Vec3::Y, radius + 0.011, thick)
                })
                .fold(f32::MAX, f32::min);
            joined(palm, fingers, 0.003)
        }
        Hand::Open(fingers, palm) => {
            let side = fingers.cross(palm);
            let knuckles = arm.wrist + fingers * 0.078;
            let mut d = cord(
                at,
                &[
                    arm.wrist,
                    knuckles - side * 0.020,
                    knuckles + side * 0.020,
                    arm.wrist,
                ],
                0.0165,
            );
            d = joined(d, limb(at, [arm.wrist, knuckles], [0.024, 0.020]), 0.02);
            for i in 0..4 {
                let root = knuckles + side * APART * (i as f32 - 1.5);
                let long = [0.060, 0.072, 0.076, 0.066][i];
                let joint = root + (fingers + palm * 0.18) * 0.55 * long;
                let tip = joint + (fingers + palm * 0.55).normalize() * 0.5 * long;
                d = joined(d, cord(at, &[root, joint, tip], 0.0105), 0.003);
            }
            let thumb = arm.wrist + fingers * 0.03 + side * 0.022;
            let end = thumb + (fingers * 0.7 + side * 0.5 + palm * 0.35).normalize() * 0.06;
            joined(d, limb(at, [thumb, end], [0.0135, 0.0105]), 0.012)
        }
    }
}

fn carry(shape: &mut Shape, pose: Pose, gilt: MaterialId) {
    match pose {
        Pose::Torch => {
            let shaft = [
                [0.0, -0.16],
                [0.011, -0.155],
                [0.016, 0.10],
                [0.045, 0.17],
                [0.048, 0.19],
                [0.030, 0.19],
                [0.0, 0.18],
            ];
            shape.add(&lathe(gilt, &shaft, 16), shift(TORCH.x, TORCH.y, TORCH.z));
            let flame = [
                [0.0, 0.0],
                [0.030, 0.02],
                [0.041, 0.06],
                [0.030, 0.12],
                [0.012, 0.18],
                [0.0, 0.22],
            ];
            shape.add(&lathe(gilt, &flame, 14), shift(TORCH.x, TORCH.y + 0.182, TORCH.z));
        }
        Pose::Globe => {
            shape.add(
                &ball(gilt, GLOBE_RADIUS, 16, 24),
                shift(GLOBE.x, GLOBE.y, GLOBE.z),
            );
            let band = round_tube(gilt, GLOBE_RADIUS + 0.003, 0.007, 32, 6);
            let tilt = Transform::rotation([0.0, 0.0, 1.0], 0.5);
            shape.add(&band, shift(GLOBE.x, GLOBE.y, GLOBE.z) * tilt);
        }
        Pose::Jug => {
            let jug = [
                [0.0, -0.25],
                [0.045, -0.25],
                [0.03, -0.225],
                [0.075, -0.14],
                [0.070, -0.085],
                [0.026, -0.03],
                [0.024, 0.035],
                [0.042, 0.065],
                [0.034, 0.062],
                [0.0, 0.04],
            ];
            shape.add(&lathe(gilt, &jug, 20), shift(JUG.x, JUG.y, JUG.z));
        }
        Pose::Staff => {
            let staff = [
                [0.0, 0.0],
                [0.016, 0.0],
                [0.013, 1.74],
                [0.026, 1.75],
                [0.038, 1.79],
                [0.026, 1.83],
                [0.0, 1.85],
            ];
            shape.add(&lathe(gilt, &staff, 12), shift(STAFF.x, 0.0, STAFF.z));
        }
        Pose::Bowl => {
            let bowl = [
                [0.0, 0.0],
                [0.05, 0.0],
                [0.06, 0.03],
                [0.21, 0.11],
                [0.235, 0.15],
                [0.215, 0.15],
                [0.0, 0.07],
            ];
            shape.add(&lathe(gilt, &bowl, 28), shift(sway(1.7), 1.834, 0.005));
        }
    }
}

/// Points of a cubic curve that ends in its first and last control point.
pub(crate) fn bezier([a, b, c, d]: [Vec3; 4], steps: usize) -> Vec<Vec3> {
    (0..=steps)
        .map(|i| i as f32 / steps as f32)
        .map(|t| {
            a.lerp(b, t)
                .lerp(b.lerp(c, t), t)
                .lerp(b.lerp(c, t).lerp(c.lerp(d, t), t), t)
        })
        .collect()
}

/// A bust on its round foot, 0.75 m tall.
pub(crate) fn bust(shop: &mut Workshop, hair: Hair, stone: MaterialId, foot: MaterialId) -> Arc<Mesh> {
    let carved = shop.carved(format!("bust {hair:?}"), || {
        let cloak = carve(
            [vec3(-0.32, 0.10, -0.24), vec3(0.32, 0.56, 0.26)],
            0.0055,
            1050,
            cloak,
        );
        let turned = Mat3::from_rotation_y(0.35);
        let skin = carve(
            [vec3(-0.24, 0.24, -0.26), vec3(0.24, 0.88, 0.26)],
            0.0042,
            3500,
            |at| {
                let own = turned.transpose() * (at - vec3(0.0, 0.615, 0.005)) / BUST_HEAD;
                joined(BUST_HEAD * head(own, hair), throat(at), 0.03)
            },
        );
        cloak.join(skin)
    });
    shop.mesh(format!("bust {hair:?} {} {}", stone.0, foot.0), || {
        let socle = [
            [0.0, 0.0],
            [0.12, 0.0],
            [0.12, 0.04],
            [0.105, 0.05],
            [0.07, 0.07],
            [0.058, 0.11],
            [0.065, 0.135],
            [0.085, 0.15],
            [0.085, 0.165],
            [0.0, 0.165],
        ];
        carved.mesh(stone, &lathe(foot, &socle, 28), 0.0)
    })
}

/// Skin of a bust below the neck, hidden by the drapery except at the neckline.
fn throat(at: Vec3) -> f32 {
    let p = mirrored(at);
    let shoulders = limb(
        p,
        [vec3(0.0, 0.375, -0.02), vec3(0.12, 0.345, -0.02)],
        [0.07, 0.05],
    );
    joined(
        shoulders,
        egg(p, vec3(0.0, 0.32, 0.0), vec3(0.13, 0.09, 0.09)),
        0.06,
    )
}

/// Shoulders and breast of a bust, cut off in a curve, with a cloak over them that is gathered on one shoulder.
fn cloak(at: Vec3) -> f32 {
    let p = mirrored(at);
    let trunk = egg(p, vec3(0.0, 0.27, -0.005), vec3(0.205, 0.17, 0.118));
    let shoulders = limb(
        p,
        [vec3(0.05, 0.372, -0.02), vec3(0.195, 0.325, -0.02)],
        [0.075, 0.070],
    );
    let chest = egg(p, vec3(0.08, 0.30, 0.07), vec3(0.095, 0.075, 0.065));
    let body = joined(joined(trunk, shoulders, 0.10), chest, 0.06);
    let curve = egg(p, vec3(0.0, 0.405, -0.01), vec3(0.275, 0.262, 0.185));
    let body = both(body, curve, 0.02);
    // Folds fan out from a brooch on the left shoulder.
    let brooch = vec3(0.165, 0.395, 0.045);
    let off = at - brooch;
    let fan = (off.y + 0.1).atan2(-off.x + 0.06);
    let ridges = 1.0 - 2.0 * (6.0 * fan + 1.5 * (5.0 * off.length()).sin()).sin().abs();
    let cloth = body - 0.010 + 0.010 * ridges * ramp(0.02, 0.10, off.length());
    let open = egg(at, vec3(-0.02, 0.455, 0.07), vec3(0.105, 0.115, 0.15));
    let cloth = without(cloth, open, 0.012);
    let hem = 0.8
        * (cord(
            at,
            &[
                vec3(0.135, 0.420, 0.015),
                vec3(0.075, 0.385, 0.092),
                vec3(-0.02, 0.335, 0.128),
                vec3(-0.105, 0.375, 0.070),
                vec3(-0.125, 0.425, -0.01),
            ],
            0.020,
        ));
    let d = joined(cloth, hem, 0.02);
    0.8 * joined(d, egg(at, brooch, vec3(0.026, 0.026, 0.020)), 0.004)
}
