//! Random convex worlds.

use enfilade::{
    Alpha, Attributes, ConvexPolygon, Geometry, GeometryBuilder, Indices, ItemOptions, Material, MaterialId,
    Mesh, OpeningId, Part, Transform, Vertices,
};
use enfilade_scenes::Random;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// Corners, and faces with counter-clockwise winding seen from inside.
#[derive(Clone)]
pub(super) struct Solid {
    pub(super) corners: Vec<DVec3>,
    pub(super) faces: Vec<Vec<usize>>,
}

/// Options for converting a solid to a geometry.
#[derive(Clone, Copy, Default)]
pub(super) struct Dress {
    /// One wall in this many is double-sided; 0: none.
    pub(super) double_sided: usize,
    /// Whether each wall is a separate item.
    pub(super) apart: bool,
    /// Whether walls are triangulated.
    pub(super) triangles: bool,
    /// Number of faces that are openings; the first ones.
    pub(super) openings: usize,
    /// Whether pictures are mounted on the walls, with item ids below or above the walls'.
    pub(super) pictures: bool,
    /// Whether a non-occluder is inside.
    pub(super) glass: bool,
}

impl Solid {
    /// Returns the intersection of random tangent half-spaces of a sphere, and a box.
    pub(super) fn by_chance(random: &mut Random) -> Solid {
        let mut planes = Vec::new();
        for axis in DVec3::AXES {
            planes.extend([(axis, 1.7), (-axis, 1.7)]);
        }
        for _ in 0..random.below(14) {
            let normal = DVec3::from(random.point(1.0).map(f64::from)).normalize_or(DVec3::X);
            planes.push((normal, 1.0));
        }
        Solid::within(&planes)
    }

    /// Returns a box.
    pub(super) fn cuboid(half: [f64; 3]) -> Solid {
        let sides = DVec3::AXES.into_iter().zip(half);
        Solid::within(
            &sides
                .flat_map(|(axis, at)| [(axis, at), (-axis, at)])
                .collect::<Vec<_>>(),
        )
    }

    /// Returns a corridor with this number of sides.
    pub(super) fn prism(sides: usize, length: f64) -> Solid {
        let mut planes = vec![(DVec3::Z, length), (-DVec3::Z, length)];
        for side in 0..sides {
            let turn = std::f64::consts::TAU * (side as f64 + 0.3) / sides as f64;
            planes.push((DVec3::new(turn.cos(), turn.sin(), 0.0), 1.0));
        }
        Solid::within(&planes)
    }

    /// Returns the polyhedron n · p ≤ d for all planes, no four of which meet in a point.
    fn within(planes: &[(DVec3, f64)]) -> Solid {
        let mut corners: Vec<(DVec3, [usize; 3])> = Vec::new();
        for a in 0..planes.len() {
            for b in 0..a {
                for c in 0..b {
                    let rows = [a, b, c].map(|plane| planes[plane].0);
                    let matrix = DMat3::from_cols_array_2d(&rows.map(Into::into)).transpose();
                    if matrix.determinant().abs() < 1e-6 {
                        continue;
                    }
                    let at = matrix.inverse() * DVec3::from([a, b, c].map(|plane| planes[plane].1));
                    if planes.iter().all(|(normal, d)| normal.dot(at) <= d + 1e-9) {
                        corners.push((at, [a, b, c]));
                    }
                }
            }
        }
        let mut faces = Vec::new();
        for (plane, (normal, _)) in planes.iter().enumerate() {
            let mut face: Vec<usize> = (0..corners.len())
                .filter(|&corner| corners[corner].1.contains(&plane))
                .collect();
            if face.len() < 3 {
                continue;
            }
            let middle = face.iter().map(|&at| corners[at].0).sum::<DVec3>() / face.len() as f64;
            let (right, up) = normal.any_orthonormal_pair();
            let angle = |at: usize| {
                let from = corners[at].0 - middle;
                -from.dot(up).atan2(from.dot(right))
            };
            face.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
            faces.push(face);
        }
        let corners = corners.into_iter().map(|(at, _)| at).collect();
        Solid { corners, faces }
    }

    /// Returns the solid translated, rotated and scaled at random.
    pub(super) fn placed(mut self, place: &DAffine3) -> Solid {
        for corner in &mut self.corners {
            *corner = place.transform_point3(*corner);
        }
        self
    }

    pub(super) fn corner(&self, at: usize) -> [f32; 3] {
        self.corners[at].as_vec3().into()
    }

    /// Returns a point inside; it approaches face `face` as `near` approaches 1.
    pub(super) fn point(&self, random: &mut Random, face: usize, near: f64) -> DVec3 {
        let mix = |all: &[DVec3], random: &mut Random| {
            let shares: Vec<f64> = all.iter().map(|_| f64::from(random.between(0.1, 1.0))).collect();
            let sum: DVec3 = all.iter().zip(&shares).map(|(&at, &share)| at * share).sum();
            sum / shares.iter().sum::<f64>()
        };
        let on_face: Vec<DVec3> = self.faces[face].iter().map(|&at| self.corners[at]).collect();
        mix(&on_face, random) * near + mix(&self.corners, random) * (1.0 - near)
    }

    pub(super) fn outline(&self, face: usize) -> ConvexPolygon {
        let corners: Vec<[f32; 3]> = self.faces[face].iter().map(|&at| self.corner(at)).collect();
        ConvexPolygon::new(&corners).expect("flat and convex")
    }

    /// Returns some corners of a face, moved towards its middle.
    fn picture(&self, face: usize) -> Vec<[f32; 3]> {
        let corners: Vec<DVec3> = self.faces[face].iter().map(|&at| self.corners[at]).collect();
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        corners
            .iter()
            .map(|&at| middle.lerp(at, 0.6).as_vec3().into())
            .collect()
    }

    pub(super) fn geometry(&self, random: &mut Random, dress: &Dress) -> Geometry {
        let mut builder = GeometryBuilder::new(materials());
        let place = Transform::IDENTITY;
        for face in 0..dress.openings {
            builder.opening("opening", self.outline(face));
        }
        let walls = dress.openings..self.faces.len();
        let mut pictures: Vec<usize> = walls
            .clone()
            .filter(|_| dress.pictures && random.once_in(2))
            .collect();
        let later = pictures.split_off(pictures.len() / 2);
        let hang = |face: usize, builder: &mut GeometryBuilder| {
            let mesh = builder.mesh(polygons(&[self.picture(face)], false, MaterialId(0)));
            builder.item("picture", mesh, place);
        };
        pictures.into_iter().for_each(|face| hang(face, &mut builder));
        let sides = |random: &mut Random| {
            let both = dress.double_sided > 0 && random.once_in(dress.double_sided);
            MaterialId(u32::from(both))
        };
        let corners = |face: usize| {
            self.faces[face]
                .iter()
                .map(|&at| self.corner(at))
                .collect::<Vec<_>>()
        };
        if dress.apart {
            for face in walls {
                let mesh = builder.mesh(polygons(&[corners(face)], dress.triangles, sides(random)));
                builder.item("wall", mesh, place);
            }
        } else {
            let all: Vec<_> = walls.map(corners).collect();
            let mesh = builder.mesh(polygons(&all, dress.triangles, sides(random)));
            builder.item("walls", mesh, place);
        }
        later.into_iter().for_each(|face| hang(face, &mut builder));
        if dress.glass {
            for (name, material) in [
                ("glass", MaterialId(2)),
                ("leaf", MaterialId(3)),
                ("ghost", MaterialId(1)),
            ] {
                let corners: [DVec3; 3] = std::array::from_fn(|_| self.point(random, 0, 0.0));
                let corners = corners.map(|at| at.as_vec3().into());
                let mesh = Mesh::triangles(&corners, &[0, 1, 2], material).expect("a triangle");
                let mesh = builder.mesh(mesh);
                let item = builder.item(name, mesh, place);
                if name == "ghost" {
                    builder.set_options(
                        item,
                        ItemOptions {
                            is_occluder: false,
                            ..ItemOptions::default()
                        },
                    );
                }
            }
        }
        builder.build().expect("a sound geometry")
    }
}

/// Single-sided, double-sided, glass, and alpha-tested.
pub(super) fn materials() -> [Material; 4] {
    let one = Material::opaque([0.5; 3]);
    let both = Material {
        double_sided: true,
        ..one
    };
    let of = |alpha| Material { alpha, ..both };
    [one, both, of(Alpha::Blend), of(Alpha::Mask)]
}

/// Builds one mesh from polygons, as they are or triangulated.
pub(super) fn polygons(outlines: &[Vec<[f32; 3]>], triangles: bool, material: MaterialId) -> Mesh {
    let (mut positions, mut corners, mut sides) = (Vec::new(), Vec::new(), Vec::new());
    for outline in outlines {
        let first = positions.len() as u32;
        positions.extend_from_slice(outline);
        let count = outline.len() as u32;
        if triangles {
            for last in 2..count {
                corners.extend([first, first + last - 1, first + last]);
                sides.push(3);
            }
        } else {
            corners.extend(first..first + count);
            sides.push(count);
        }
    }
    let part = Part {
        positions: Vertices::Packed(&positions),
        corners: Indices::U32(&corners),
        sides: Some(&sides),
        material,
        attributes: Attributes::default(),
    };
    Mesh::new(&[part]).expect("flat and convex")
}

/// Returns a random transform: up to `far` from the origin, scale 0.5 to 20.
pub(super) fn place(random: &mut Random, far: f32) -> DAffine3 {
    let axis = DVec3::from(random.point(1.0).map(f64::from)).normalize_or(DVec3::X);
    DAffine3::from_scale_rotation_translation(
        DVec3::splat(f64::from(random.between(0.5, 20.0))),
        DQuat::from_axis_angle(axis, f64::from(random.between(0.0, 6.0))),
        DVec3::from(random.point(far).map(f64::from)),
    )
}

/// Returns the transform that enters one opening from the front and leaves the other one, centre to centre.
pub(super) fn through(here: &ConvexPolygon, there: &ConvexPolygon) -> Transform {
    let frame = |outline: &ConvexPolygon, turn: f64| {
        let corners: Vec<DVec3> = outline
            .corners()
            .iter()
            .map(|corner| DVec3::from(corner.map(f64::from)))
            .collect();
        let normal = turn * DVec3::from(outline.normal().map(f64::from)).normalize();
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let right = (corners[1] - corners[0])
            .reject_from_normalized(normal)
            .normalize();
        DAffine3::from_mat3_translation(DMat3::from_cols(right, normal.cross(right), normal), middle)
    };
    let there_from_here = frame(there, -1.0) * frame(here, 1.0).inverse();
    let columns = there_from_here.to_cols_array_2d();
    Transform::from_columns(columns.map(|column| column.map(|value| value as f32)))
}

pub(super) const FIRST: OpeningId = OpeningId(0);
