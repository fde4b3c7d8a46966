//! All geometry of a scene in one vertex and one index buffer.
//!
//! Unique items are stored in scene space, sorted along a space-filling curve, so that neighbours drawn together are
//! one draw call; meshes with several items are stored once and drawn as instances.

use crate::weld::{Shade, Vertex, Weld};
use enfilade::{Aabb, Alpha, Geometry, Item, ItemIndex, Mesh};
use glam::{DMat3, DVec3};
use std::ops::Range;

/// Class of faces that share a pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Class {
    pub(crate) glass: bool,
    pub(crate) double_sided: bool,
}

impl Class {
    pub(crate) const ALL: [Class; 4] = [
        Class {
            glass: false,
            double_sided: false,
        },
        Class {
            glass: false,
            double_sided: true,
        },
        Class {
            glass: true,
            double_sided: false,
        },
        Class {
            glass: true,
            double_sided: true,
        },
    ];

    pub(crate) fn number(self) -> usize {
        usize::from(self.glass) * 2 + usize::from(self.double_sided)
    }
}

/// Faces of one class, consecutive in the index buffer.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) class: Class,
    pub(crate) indices: Range<u32>,
}

/// A unique item, or the mesh of several instances.
#[derive(Debug, Default)]
pub(crate) struct Shape {
    /// The whole mesh: one piece for each class.
    pub(crate) whole: Vec<Piece>,
    /// One piece for each cluster of the mesh.
    pub(crate) clusters: Vec<Piece>,
}

/// Shape and transform of an item.
#[derive(Clone, Copy)]
pub(crate) struct ItemDraw {
    /// Index of its shape.
    pub(crate) shape: usize,
    /// Transform of the instance; `None` if its vertices are in scene space.
    pub(crate) at: Option<(DMat3, DVec3)>,
    pub(crate) bounds: Aabb,
}

/// Buffers and their contents.
pub(crate) struct Stock {
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) indices: Vec<u32>,
    pub(crate) shapes: Vec<Shape>,
    /// By [`ItemIndex`].
    pub(crate) items: Vec<ItemDraw>,
}

impl Stock {
    pub(crate) fn new(geometry: &Geometry) -> Stock {
        let mut copies = vec![0; geometry.meshes().len()];
        for item in geometry.items() {
            copies[item.mesh.0 as usize] += 1;
        }
        let mut shared = vec![None; geometry.meshes().len()];
        let mut builder = Builder::default();
        let mut items = vec![None; geometry.items().len()];
        for id in by_place(geometry) {
            let item = geometry.item(id);
            let (matrix, translation) = place(item);
            // Mirrored instances have reversed winding, so each is a separate shape.
            let instanced = copies[item.mesh.0 as usize] > 1 && !item.transform().mirrors();
            let shape = if instanced {
                let known = &mut shared[item.mesh.0 as usize];
                *known.get_or_insert_with(|| builder.add(geometry, id, DMat3::IDENTITY, DVec3::ZERO))
            } else {
                builder.add(geometry, id, matrix, translation)
            };
            items[id.0 as usize] = Some(ItemDraw {
                shape,
                at: instanced.then_some((matrix, translation)),
                bounds: item.bounds,
            });
        }
        builder.finish(items.into_iter().flatten().collect())
    }
}

/// Returns the linear part and the translation of an item's transform.
fn place(item: &Item) -> (DMat3, DVec3) {
    let [x, y, z, translation] = item
        .sector_from_item
        .map(|column| DVec3::from(column.map(f64::from)));
    (DMat3::from_cols(x, y, z), translation)
}

/// Returns the items along a Morton curve, which keeps neighbours together.
fn by_place(geometry: &Geometry) -> Vec<ItemIndex> {
    let bounds = geometry.bounds();
    let code = |item: &Item| {
        let center = item.bounds.center();
        let steps: [u32; 3] = std::array::from_fn(|axis| {
            let size = (bounds.max[axis] - bounds.min[axis]).max(f32::MIN_POSITIVE);
            (1023.0 * (center[axis] - bounds.min[axis]) / size) as u32
        });
        (0..10).rev().fold(0_u32, |code, bit| {
            steps.iter().fold(code, |code, step| code << 1 | step >> bit & 1)
        })
    };
    let mut order: Vec<ItemIndex> = (0..geometry.items().len() as u32).map(ItemIndex).collect();
    order.sort_by_key(|&id| (code(geometry.item(id)), id));
    order
}

/// Index buffers of each class, to be concatenated, and pieces with offsets within them.
#[derive(Default)]
struct Builder {
    weld: Weld,
    indices: [Vec<u32>; Class::ALL.len()],
    shapes: Vec<Shape>,
}

impl Builder {
    /// Adds an item's mesh, transformed; returns the index of the shape.
    fn add(&mut self, geometry: &Geometry, id: ItemIndex, matrix: DMat3, translation: DVec3) -> usize {
        let mesh = geometry.mesh_of(id);
        let mirrored = matrix.determinant() < 0.0;
        let moved: Vec<DVec3> = mesh
            .positions()
            .iter()
            .map(|position| matrix * DVec3::from(position.map(f64::from)) + translation)
            .collect();
        let mut shape = Shape::default();
        self.weld.start();
        let starts: [u32; 4] = std::array::from_fn(|class| self.indices[class].len() as u32);
        for cluster in mesh.clusters() {
            let material = geometry.material_of(id, cluster);
            let class = Class {
                glass: material.alpha == Alpha::Blend,
                double_sided: material.double_sided,
            };
            let start = self.indices[class.number()].len() as u32;
            for face in cluster.faces.clone() {
                // Alpha-tested materials have no texture here, so they are opaque, as in Enfilade's pictures.
                let [r, g, b, a] = material.base_color;
                let color = [r, g, b, if class.glass { a } else { 1.0 }];
                self.face(class, mesh, face, &moved, mirrored, color);
            }
            let end = self.indices[class.number()].len() as u32;
            shape.clusters.push(Piece {
                class,
                indices: start..end,
            });
        }
        for class in Class::ALL {
            let indices = starts[class.number()]..self.indices[class.number()].len() as u32;
            if !indices.is_empty() {
                shape.whole.push(Piece { class, indices });
            }
        }
        self.shapes.push(shape);
        self.shapes.len() - 1
    }

    /// Adds the triangles of a face; none if it has no area.
    fn face(
        &mut self,
        class: Class,
        mesh: &Mesh,
        face: u32,
        moved: &[DVec3],
        mirrored: bool,
        color: [f32; 4],
    ) {
        let corners = mesh.face(face);
        let at = |corner: u32| moved[corner as usize];
        let fan = || corners[1..].windows(2).map(|last| [corners[0], last[0], last[1]]);
        let sum: DVec3 = fan().map(|[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a))).sum();
        let Some(normal) = sum.try_normalize() else {
            return;
        };
        let shade = Shade::new(if mirrored { -normal } else { normal }, color);
        for [a, b, c] in fan() {
            let at_corners = if mirrored { [a, c, b] } else { [a, b, c] };
            let positions = at_corners.map(|corner| at(corner).as_vec3().into());
            self.indices[class.number()].extend(self.weld.triangle(at_corners, positions, shade));
        }
    }

    fn finish(self, items: Vec<ItemDraw>) -> Stock {
        let mut starts = [0; Class::ALL.len()];
        for class in 1..starts.len() {
            starts[class] = starts[class - 1] + self.indices[class - 1].len() as u32;
        }
        let mut shapes = self.shapes;
        for piece in shapes
            .iter_mut()
            .flat_map(|shape| shape.whole.iter_mut().chain(&mut shape.clusters))
        {
            let start = starts[piece.class.number()];
            piece.indices = piece.indices.start + start..piece.indices.end + start;
        }
        Stock {
            vertices: self.weld.finish(),
            indices: self.indices.concat(),
            shapes,
            items,
        }
    }
}
