//! A balcony with a railing, in the frame of a facade.

use crate::material::Material;
use crate::mesh::{End, Mesh, arc};
use crate::vector::v;

/// How far balconies reach over the street.
const DEPTH: f64 = 0.95;

pub(super) fn balcony(mesh: &mut Mesh, [x0, x1]: [f64; 2], floor: f64, turned: bool) {
    mesh.material = Material::Stone;
    let round = mesh.segments(5.0, 1);
    let mut profile = vec![(floor - 0.16, 0.0), (floor - 0.16, DEPTH - 0.08)];
    profile.extend(arc((floor - 0.08, DEPTH - 0.06), 0.06, [2.0, 0.0], 2 * round));
    profile.extend([(floor, DEPTH - 0.08), (floor, 0.0)]);
    mesh.extrude([x0, x1], &profile, [End::Cap; 2]);
    for x in [x0 + 0.15, x1 - 0.35] {
        let mut bracket = vec![(floor - 0.7, 0.0), (floor - 0.7, 0.08)];
        bracket.extend(arc((floor - 0.62, 0.62), 0.46, [-1.0, 0.0], 2 * round));
        bracket.push((floor - 0.16, 0.0));
        mesh.extrude([x, x + 0.2], &bracket, [End::Cap; 2]);
    }
    mesh.material = if turned { Material::Stone } else { Material::Metal };
    let sides = mesh.segments(8.0, 3);
    let front = DEPTH - 0.1;
    let corners = [
        v(x0 + 0.06, 0.0, 0.02),
        v(x0 + 0.06, 0.0, front),
        v(x1 - 0.06, 0.0, front),
        v(x1 - 0.06, 0.0, 0.02),
    ];
    let upright = mesh.frame;
    let spacing = if turned { 0.2 } else { 0.14 };
    let thin = mesh.segments(4.0, 3);
    for pair in corners.windows(2) {
        mesh.frame = upright;
        for (height, radius) in [(0.08, 0.02), (1.0, 0.035)] {
            let ends = [pair[0], pair[1]].map(|at| (at + v(0.0, floor + height, 0.0), radius));
            mesh.tube(&ends, sides);
        }
        let count = ((pair[1] - pair[0]).length() / spacing).round() as usize;
        for i in 0..count {
            let at = pair[0].lerp(pair[1], (i as f64 + 0.5) / count as f64);
            mesh.frame = upright.moved(v(at.x, floor, at.z));
            if turned {
                let baluster = [
                    (0.05, 0.08),
                    (0.03, 0.16),
                    (0.065, 0.36),
                    (0.03, 0.7),
                    (0.05, 0.98),
                ];
                mesh.lathe(&baluster, thin + 1);
            } else {
                let bend = mesh.random.between(0.01, 0.03);
                let bar = [(0.08, 0.0), (0.5, bend), (1.0, 0.0)];
                mesh.tube(&bar.map(|(y, z)| (v(0.0, y, z), 0.009)), thin);
            }
        }
    }
    for corner in corners {
        mesh.frame = upright.moved(v(corner.x, floor, corner.z));
        mesh.lathe(
            &[(0.04, 0.0), (0.04, 1.04), (0.06, 1.08), (0.05, 1.14), (0.0, 1.17)],
            sides + 1,
        );
    }
    mesh.frame = upright;
}
