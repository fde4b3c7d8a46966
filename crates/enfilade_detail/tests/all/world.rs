//! A hall for items with levels, and balls as such items.

use enfilade::{
    Aabb, GeometryBuilder, Material, MaterialId, Mesh, Method, Scene, SceneBuilder, SectorId, Transform,
    View, Viewer, VisibleSet,
};
use enfilade_detail::{DetailSource, Details, RefineStats};
use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

pub(crate) const HALL: SectorId = SectorId(0);

/// A ball of radius ½ around the origin, tessellated along parallels and meridians; its finest level counts as exact.
pub(crate) struct Ball {
    builds: AtomicU32,
}

impl Ball {
    pub(crate) const FINEST: u32 = 4;

    pub(crate) fn new() -> Arc<Ball> {
        Arc::new(Ball {
            builds: AtomicU32::new(0),
        })
    }

    /// Number of levels built so far.
    pub(crate) fn builds(&self) -> u32 {
        self.builds.load(Ordering::Relaxed)
    }

    fn parallels(level: u32) -> u32 {
        4 << level
    }
}

impl DetailSource for Ball {
    fn bounds(&self) -> Aabb {
        Aabb {
            min: [-0.5; 3],
            max: [0.5; 3],
        }
    }

    fn material(&self) -> MaterialId {
        MaterialId(0)
    }

    fn levels(&self) -> u32 {
        Ball::FINEST + 1
    }

    fn error(&self, level: u32) -> f32 {
        if level == Ball::FINEST {
            return 0.0;
        }
        // No vertex of a triangle is farther from the triangle's middle than a step along a meridian, so both levels
        // are between the ball and one smaller by this.
        0.5 * (1.0 - (std::f32::consts::PI / Ball::parallels(level) as f32).cos())
    }

    fn build(&self, level: u32) -> Result<Arc<Mesh>, Box<dyn Error + Send + Sync>> {
        self.builds.fetch_add(1, Ordering::Relaxed);
        let n = Ball::parallels(level);
        let step = std::f32::consts::PI / n as f32;
        let mut positions = Vec::new();
        for row in 0..=n {
            for column in 0..2 * n {
                let [across, along] = [row as f32 * step, column as f32 * step];
                let radius = 0.5 * across.sin();
                positions.push([radius * along.cos(), 0.5 * across.cos(), -radius * along.sin()]);
            }
        }
        let mut corners = Vec::new();
        for row in 0..n {
            for column in 0..2 * n {
                let next = (column + 1) % (2 * n);
                let [a, b] = [row * 2 * n + column, row * 2 * n + next];
                corners.extend([a, a + 2 * n, b + 2 * n, a, b + 2 * n, b]);
            }
        }
        Ok(Arc::new(Mesh::triangles(&positions, &corners, MaterialId(0))?))
    }
}

pub(crate) fn materials() -> [Material; 1] {
    [Material::opaque([0.5; 3])]
}

/// A square of side 2 around the origin, facing +z.
pub(crate) fn square() -> Arc<Mesh> {
    let corners = [
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
    ];
    Arc::new(Mesh::triangles(&corners, &[0, 1, 2, 0, 2, 3], MaterialId(0)).expect("a square"))
}

/// A wall across the whole view, facing +z.
pub(crate) fn wall_at(z: f32) -> Arc<Mesh> {
    let corners = [
        [-50.0, -50.0, z],
        [50.0, -50.0, z],
        [50.0, 50.0, z],
        [-50.0, 50.0, z],
    ];
    Arc::new(Mesh::triangles(&corners, &[0, 1, 2, 0, 2, 3], MaterialId(0)).expect("a wall"))
}

pub(crate) fn empty(method: Method) -> Scene {
    let mut scene = SceneBuilder::new();
    let geometry = GeometryBuilder::new(materials())
        .build()
        .expect("nothing is wrong with nothing");
    scene.add("hall", geometry, method);
    scene.build().expect("a hall")
}

/// A hall with a screen on the right.
pub(crate) fn hall(method: Method) -> Scene {
    let mut scene = empty(method);
    let mut edit = scene.edit();
    let place = at([3.0, 0.0, -4.0]) * Transform::scaling([3.0; 3]);
    edit.add(HALL, "screen", square(), place).expect("it fits");
    edit.finish().expect("little");
    scene
}

pub(crate) fn at(place: [f32; 3]) -> Transform {
    Transform::translation(place)
}

/// A view from the origin along −z.
pub(crate) fn straight() -> View {
    View::new([0.0; 3], [0.0, 0.0, -5.0], [96, 72])
}

/// Looks and refines until nothing is built and no item waits, then looks again.
pub(crate) fn settle(
    details: &mut Details,
    scene: &mut Scene,
    viewer: &mut Viewer,
    view: &View,
) -> RefineStats {
    for _ in 0..20 {
        let set = viewer.look(scene, view);
        let refined = details.refine(scene, &[set]).expect("it fits");
        if refined.changed == 0 && refined.waiting == 0 {
            viewer.look(scene, view);
            return refined;
        }
    }
    panic!("something always changes");
}

pub(crate) fn names(scene: &Scene, set: &VisibleSet) -> Vec<String> {
    let mut names: Vec<String> = set
        .items()
        .iter()
        .map(|item| {
            let geometry = scene.geometry(set.passage(item.passage).sector).expect("ours");
            geometry.name(item.item.index).to_owned()
        })
        .collect();
    names.sort();
    names
}
