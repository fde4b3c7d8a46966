//! The draw calls of one picture: culled on the CPU and merged where neighbours allow.

use crate::lens::Lens;
use crate::stock::{Class, ItemDraw, Piece, Stock};
use bytemuck::{Pod, Zeroable};
use enfilade::VisibleSet;
use glam::{DMat3, DVec3};
use std::ops::Range;

/// Transform of an instance relative to the eye: three rows of four.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Instance([[f32; 4]; 3]);

/// A draw call.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Draw {
    pub(crate) class: Class,
    pub(crate) indices: Range<u32>,
    pub(crate) instances: Range<u32>,
}

/// The draw calls of a picture. Reused between pictures to avoid allocation.
#[derive(Default)]
pub(crate) struct Plan {
    /// The first belongs to all shapes without instances.
    pub(crate) instances: Vec<Instance>,
    /// DrawStats before the sky.
    pub(crate) opaque: Vec<Draw>,
    /// DrawStats after the sky, far to near, with the squared distance of the item.
    pub(crate) glass: Vec<(f64, Draw)>,
    /// Instances of each shape.
    copies: Vec<Vec<Instance>>,
}

impl Plan {
    /// Adds every item whose bounds intersect the frustum.
    pub(crate) fn frustum(&mut self, stock: &Stock, lens: &Lens) {
        self.start(stock, lens);
        for placed in &stock.items {
            if lens.may_show(&placed.bounds) {
                self.add_whole(stock, lens, placed);
            }
        }
        self.finish(stock);
    }

    /// Adds the visible items; of large items the visible clusters.
    pub(crate) fn visible(&mut self, stock: &Stock, lens: &Lens, set: &VisibleSet) {
        self.start(stock, lens);
        for item in set.items() {
            let placed = &stock.items[item.item.index.0 as usize];
            let clusters = set.clusters(item);
            if clusters.is_empty() || placed.at.is_some() {
                self.add_whole(stock, lens, placed);
            } else {
                let all = &stock.shapes[placed.shape].clusters;
                for &cluster in clusters {
                    self.add(lens, placed, &all[cluster as usize]);
                }
            }
        }
        self.finish(stock);
    }

    /// Returns the number of triangles in all draw calls.
    pub(crate) fn triangles(&self) -> u64 {
        let of = |draw: &Draw| (draw.indices.len() / 3 * draw.instances.len()) as u64;
        self.draws().map(of).sum()
    }

    /// Returns all draw calls, in order.
    pub(crate) fn draws(&self) -> impl Iterator<Item = &Draw> {
        self.opaque.iter().chain(self.glass.iter().map(|(_, draw)| draw))
    }

    fn start(&mut self, stock: &Stock, lens: &Lens) {
        self.opaque.clear();
        self.glass.clear();
        self.copies.resize_with(stock.shapes.len(), Vec::new);
        self.instances.clear();
        self.instances
            .push(Instance(lens.relative(&DMat3::IDENTITY, DVec3::ZERO)));
    }

    fn add_whole(&mut self, stock: &Stock, lens: &Lens, placed: &ItemDraw) {
        let shape = &stock.shapes[placed.shape];
        for piece in &shape.whole {
            self.add(lens, placed, piece);
        }
        if let Some((matrix, translation)) = &placed.at
            && shape.whole.iter().any(|piece| !piece.class.glass)
        {
            self.copies[placed.shape].push(Instance(lens.relative(matrix, *translation)));
        }
    }

    /// Adds a draw call; opaque instances are collected to be drawn together.
    fn add(&mut self, lens: &Lens, placed: &ItemDraw, piece: &Piece) {
        let mut draw = Draw {
            class: piece.class,
            indices: piece.indices.clone(),
            instances: 0..1,
        };
        if piece.class.glass {
            if let Some((matrix, translation)) = &placed.at {
                let instance = self.instances.len() as u32;
                self.instances.push(Instance(lens.relative(matrix, *translation)));
                draw.instances = instance..instance + 1;
            }
            let center = DVec3::from(placed.bounds.center().map(f64::from));
            self.glass.push((center.distance_squared(lens.eye), draw));
        } else if placed.at.is_none() {
            self.opaque.push(draw);
        }
    }

    fn finish(&mut self, stock: &Stock) {
        self.opaque.sort_unstable_by_key(|draw| draw.indices.start);
        join(&mut self.opaque);
        for (shape, copies) in stock.shapes.iter().zip(&mut self.copies) {
            if copies.is_empty() {
                continue;
            }
            let start = self.instances.len() as u32;
            let instances = start..start + copies.len() as u32;
            self.instances.append(copies);
            for piece in shape.whole.iter().filter(|piece| !piece.class.glass) {
                self.opaque.push(Draw {
                    class: piece.class,
                    indices: piece.indices.clone(),
                    instances: instances.clone(),
                });
            }
        }
        self.glass.sort_by(|a, b| b.0.total_cmp(&a.0));
    }
}

/// Merges consecutive draw calls with adjacent indices.
fn join(draws: &mut Vec<Draw>) {
    draws.dedup_by(|next, last| {
        let follows = last.class == next.class && last.indices.end == next.indices.start;
        if follows {
            last.indices.end = next.indices.end;
        }
        follows
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade::{
        Alpha, GeometryBuilder, ItemIndex, Material, MaterialId, Mesh, Method, SceneBuilder, Transform, View,
        Viewer,
    };
    use std::sync::Arc;

    const STONE: MaterialId = MaterialId(0);
    const GLASS: MaterialId = MaterialId(1);

    fn square(material: MaterialId) -> Mesh {
        let corners = [
            [-1.0, -1.0, 0.0],
            [1.0, -1.0, 0.0],
            [1.0, 1.0, 0.0],
            [-1.0, 1.0, 0.0],
        ];
        Mesh::triangles(&corners, &[0, 1, 2, 0, 2, 3], material).expect("a valid square")
    }

    #[test]
    fn what_is_behind_the_eye_is_left_out_copies_are_one_draw_and_glass_comes_far_to_near() {
        let pane = Material {
            alpha: Alpha::Blend,
            ..Material::opaque([0.9; 3])
        };
        let mut builder = GeometryBuilder::new([Material::opaque([0.5; 3]), pane]);
        let [wall, copied, glass] = [STONE, STONE, GLASS].map(|material| builder.mesh(square(material)));
        let at = |z| Transform::translation([0.0, 0.0, z]);
        builder.item("wall", wall, at(-9.0));
        builder.item("a copy", copied, at(-5.0));
        builder.item("another", copied, at(-6.0));
        builder.item("a copy behind", copied, at(5.0));
        builder.item("near pane", glass, at(-2.0));
        builder.item("far pane", glass, at(-3.0));
        let geometry = Arc::new(builder.build().expect("valid geometry"));
        let stock = Stock::new(&geometry);
        let view = View::new([0.0; 3], [0.0, 0.0, -1.0], [64, 64]);
        let lens = Lens::new(&view);

        let mut plan = Plan::default();
        plan.frustum(&stock, &lens);
        assert_eq!(plan.triangles(), 2 * 5);
        assert_eq!(
            plan.opaque
                .iter()
                .map(|draw| draw.instances.len())
                .collect::<Vec<_>>(),
            [1, 2]
        );
        assert_eq!(
            plan.glass.iter().map(|(away, _)| *away).collect::<Vec<_>>(),
            [9.0, 4.0]
        );

        let mut scene = SceneBuilder::new();
        scene.add("yard", geometry, Method::ZBuffer);
        let scene = scene.build().expect("a valid scene");
        let mut viewer = Viewer::new();
        let set = viewer.look(&scene, &view);
        plan.visible(&stock, &lens, set);
        let seen: Vec<ItemIndex> = set.items().iter().map(|item| item.item.index).collect();
        assert_eq!(
            seen,
            [1, 4, 5].map(ItemIndex),
            "the first copy hides the other and the wall"
        );
        assert_eq!(plan.triangles(), 2 * 3);
    }
}
