//! The buffers of looks of many views.

use super::*;
use crate::geometry::{GeometryBuilder, Material};
use crate::ids::MaterialId;
use crate::mesh::Mesh;
use crate::method::Method;
use crate::view::options::ViewerOptions;

#[test]
fn there_are_as_many_buffers_as_threads_however_many_views() {
    let mut room = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    let cube = room.mesh(Mesh::cuboid([-1.0; 3], [1.0; 3], MaterialId(0)).expect("a cube"));
    room.item("cube", cube, crate::Transform::IDENTITY);
    let scene = Scene::single(room.build().expect("a room"), Method::Masked).expect("a scene");
    let view = View::new([0.0, 0.0, 9.0], [0.0; 3], [64, 36]).expect("a valid view");
    let views = vec![view; 50];
    for (parallel, count) in [(false, 1), (true, 3)] {
        let mut viewers = Viewers::with_options(ViewerOptions {
            parallel,
            ..ViewerOptions::default()
        });
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(3)
            .build()
            .expect("a pool");
        let sets = pool.install(|| viewers.look_many(&scene, &views).len());
        assert_eq!((sets, viewers.stats().count()), (50, 50));
        assert!(
            (1..=count).contains(&viewers.threads.len()),
            "{}",
            viewers.threads.len()
        );
        assert!(viewers.visible().iter().all(|set| set.items().len() == 1));
        viewers.look_many(&scene, &views[..2]);
        assert_eq!(viewers.visible().len(), 2);
    }
}
