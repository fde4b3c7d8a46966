//! Vertex attributes of meshes: texture coordinates and smooth normals.
//!
//! Vertices at the same position with different attributes become several vertices of the mesh. Their positions have
//! the same bits, by which adjacent faces are found, so the attributes do not affect the occluders.

use super::Sheet;
use enfilade::{Attributes, Indices, MaterialId, Mesh, Part, Vertices};
use glam::{Vec2, Vec3, vec2};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::Arc;

/// Vertex attributes that the faces of a material get.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Dress {
    /// One color, with smooth normals at edges below the crease angle.
    Smooth,
    /// As [`Dress::Smooth`], with a texture.
    Textured {
        /// Repetitions per metre.
        per_metre: f32,
        /// Whether the texture has a grain, which follows the longer side of a face.
        grain: bool,
        /// Whether it is cloth, which stays smooth even at sharp folds.
        cloth: bool,
    },
}

/// Cosine of the crease angle, below which adjacent faces are smoothed: 48°, and 84° for cloth.
const CREASE: f32 = 0.67;
const FOLD: f32 = 0.1;

/// Returns texture coordinates in metres by box projection: along the axis that the face looks at most, upright on
/// walls.
pub(super) fn boxed(corners: &[Vec3]) -> Vec<Vec2> {
    let normal = newell(corners);
    let away = normal.abs();
    // Biased, so that rounding does not split slopes of exactly 45°.
    let place: fn(Vec3) -> Vec2 = if away.y >= 1.01 * away.x.max(away.z) {
        |at| vec2(at.x, at.z)
    } else if away.x >= 0.99 * away.z {
        |at| vec2(at.z, -at.y)
    } else {
        |at| vec2(at.x, -at.y)
    };
    corners.iter().map(|&corner| place(corner)).collect()
}

/// Returns the vector area times two (Newell's method).
fn newell(corners: &[Vec3]) -> Vec3 {
    (1..corners.len() - 1)
        .map(|i| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]))
        .sum()
}

/// A fast hasher for coordinate bits. The palace hashes millions of them, and no input is adversarial.
#[derive(Default)]
struct Mixed(u64);

type Quick = BuildHasherDefault<Mixed>;

impl Hasher for Mixed {
    fn write(&mut self, bytes: &[u8]) {
        for four in bytes.chunks(4) {
            let mut word = [0; 4];
            word[..four.len()].copy_from_slice(four);
            self.write_u32(u32::from_le_bytes(word));
        }
    }

    fn write_u32(&mut self, word: u32) {
        self.0 = (self.0.rotate_left(23) ^ u64::from(word)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }

    fn write_usize(&mut self, _length: usize) {
        // All arrays have one length, so the length need not be hashed.
    }

    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 29)
    }
}

/// Vertices and faces of one material.
#[derive(Default)]
struct Welded {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    texture: Vec<[f32; 2]>,
    corners: Vec<u32>,
}

/// Builds the mesh of all faces; equal vertices are merged.
pub(super) fn mesh(sheets: &[Sheet], dress: impl Fn(MaterialId) -> Dress) -> Arc<Mesh> {
    let welded: Vec<Welded> = sheets
        .iter()
        .map(|sheet| weld(sheet, dress(sheet.material)))
        .collect();
    let parts: Vec<Part> = (sheets.iter().zip(&welded))
        .map(|(sheet, welded)| Part {
            positions: Vertices::Packed(&welded.positions),
            corners: Indices::U32(&welded.corners),
            sides: sheet
                .sides
                .iter()
                .any(|&sides| sides != 3)
                .then_some(&*sheet.sides),
            material: sheet.material,
            attributes: Attributes {
                normals: Vertices::Packed(&welded.normals),
                texture: Vertices::Packed(&welded.texture),
                ..Attributes::default()
            },
        })
        .collect();
    Arc::new(Mesh::new(&parts).expect("faces are validated when they are added"))
}

fn weld(sheet: &Sheet, dress: Dress) -> Welded {
    let normals = match dress {
        Dress::Textured { cloth: true, .. } => smooth(sheet, FOLD),
        _ => smooth(sheet, CREASE),
    };
    let texture = match dress {
        Dress::Textured { per_metre, grain, .. } => texture(sheet, per_metre, grain),
        _ => Vec::new(),
    };
    let mut welded = Welded::default();
    let bits = |value: f32| value.to_bits();
    let mut numbers = HashMap::with_capacity_and_hasher(sheet.corners.len() / 2, Quick::default());
    for (i, corner) in sheet.corners.iter().enumerate() {
        let normal = normals.get(i).copied().unwrap_or(Vec3::ZERO);
        let place = texture.get(i).copied().unwrap_or(Vec2::ZERO);
        let key = (
            corner.to_array().map(bits),
            normal.to_array().map(bits),
            place.to_array().map(bits),
        );
        let number = *numbers.entry(key).or_insert_with(|| {
            welded.positions.push(corner.to_array());
            if !normals.is_empty() {
                welded.normals.push(normal.to_array());
            }
            if !texture.is_empty() {
                welded.texture.push(place.to_array());
            }
            welded.positions.len() as u32 - 1
        });
        welded.corners.push(number);
    }
    // Omit the normals if all faces are flat.
    if welded.normals.iter().all(|normal| *normal == [0.0; 3]) {
        welded.normals.clear();
    }
    welded
}

/// Returns for each corner the normal of the smooth surface it belongs to, or zero.
fn smooth(sheet: &Sheet, crease: f32) -> Vec<Vec3> {
    let mut faces = Vec::with_capacity(sheet.sides.len());
    let mut face_of = Vec::with_capacity(sheet.corners.len());
    let mut start = 0;
    for &sides in &sheet.sides {
        let end = start + sides as usize;
        let normal = newell(&sheet.corners[start..end]);
        face_of.extend(std::iter::repeat_n(faces.len(), sides as usize));
        faces.push((normal, normal.normalize_or_zero()));
        start = end;
    }
    // Linked lists of the corners at one position.
    const END: usize = usize::MAX;
    let mut last: HashMap<[u32; 3], usize, Quick> =
        HashMap::with_capacity_and_hasher(sheet.corners.len() / 2, Quick::default());
    let mut before = vec![END; sheet.corners.len()];
    for (i, corner) in sheet.corners.iter().enumerate() {
        if let Some(other) = last.insert(corner.to_array().map(f32::to_bits), i) {
            before[i] = other;
        }
    }
    (sheet.corners.iter().zip(&face_of))
        .map(|(corner, &face)| {
            let own = faces[face].1;
            let mut sum = Vec3::ZERO;
            let mut other = last[&corner.to_array().map(f32::to_bits)];
            while other != END {
                let (sized, unit) = faces[face_of[other]];
                if unit.dot(own) > crease {
                    sum += sized;
                }
                other = before[other];
            }
            let bent = sum.normalize_or_zero();
            if bent.dot(own) > 0.9999 {
                Vec3::ZERO
            } else {
                bent + Vec3::ZERO
            }
        })
        .collect()
}

fn texture(sheet: &Sheet, per_metre: f32, grain: bool) -> Vec<Vec2> {
    let mut places = Vec::with_capacity(sheet.places.len());
    let mut start = 0;
    for &sides in &sheet.sides {
        let end = start + sides as usize;
        let face = &sheet.places[start..end];
        let least = face.iter().copied().reduce(Vec2::min).unwrap_or_default();
        let most = face.iter().copied().reduce(Vec2::max).unwrap_or_default();
        let [across, down] = (most - least).to_array();
        // Triangles are parts of larger surfaces, so their extent does not show the grain direction.
        let is_rotated = grain && sides > 3 && across > 1.2 * down;
        places.extend(face.iter().map(|&place| {
            let place = place * per_metre;
            if is_rotated { vec2(place.y, place.x) } else { place }
        }));
        start = end;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::super::{Shape, ball, block, lathe};
    use super::*;

    const STONE: MaterialId = MaterialId(0);
    const TEXTURED: Dress = Dress::Textured {
        per_metre: 2.0,
        grain: false,
        cloth: false,
    };

    #[test]
    fn balls_are_round_and_boxes_are_not() {
        let ball = ball(STONE, 2.0, 16, 24).dressed(|_| Dress::Smooth);
        assert_eq!(ball.normals().len(), ball.positions().len());
        for (normal, position) in ball.normals().iter().zip(ball.positions()) {
            let [normal, outwards] = [Vec3::from(*normal), Vec3::from(*position).normalize()];
            assert!(normal.dot(outwards) > 0.99, "{normal} at {outwards}");
        }
        let block = block(STONE, [0.0; 3], [1.0; 3]).dressed(|_| Dress::Smooth);
        assert!(block.normals().is_empty());
        assert_eq!(block.positions().len(), 8);
    }

    #[test]
    fn a_rim_stays_sharp_where_the_side_is_round() {
        let drum = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let drum = lathe(STONE, &drum, 32).dressed(|_| Dress::Smooth);
        for (normal, position) in drum.normals().iter().zip(drum.positions()) {
            let level = normal[1].abs() < 1e-3;
            assert!(level, "{normal:?} at {position:?}");
        }
    }

    #[test]
    fn textures_have_one_measure_on_all_sides_of_a_box() {
        let mesh = block(STONE, [0.0, 1.0, 2.0], [1.0, 3.0, 5.0]).dressed(|_| TEXTURED);
        for face in 0..mesh.face_count() {
            let corners = mesh.face(face);
            for i in 0..corners.len() {
                let [a, b] = [corners[i], corners[(i + 1) % corners.len()]].map(|corner| corner as usize);
                let long = Vec3::from(mesh.positions()[a]).distance(mesh.positions()[b].into());
                let drawn = Vec2::from(mesh.texture()[a]).distance(mesh.texture()[b].into());
                assert!((drawn - 2.0 * long).abs() < 1e-5, "{drawn} for {long} metres");
            }
        }
    }

    #[test]
    fn places_stay_with_faces_that_are_moved() {
        let square = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
        let places = [vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(1.0, 0.0), vec2(0.0, 0.0)];
        let mut shape = Shape::new();
        shape.placed(STONE, &square, &places);
        let mirrored = enfilade::Transform::scaling([-3.0, 1.0, 1.0]);
        let mut moved = Shape::new();
        moved.add(&shape, mirrored);
        let mesh = moved.dressed(|_| Dress::Textured {
            per_metre: 1.0,
            grain: false,
            cloth: false,
        });
        for (position, place) in mesh.positions().iter().zip(mesh.texture()) {
            assert_eq!(*place, [-position[0] / 3.0, 1.0 - position[1]]);
        }
    }
}
