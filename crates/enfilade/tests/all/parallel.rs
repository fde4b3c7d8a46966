//! Parallel views of what is no scene: the masked depth buffer by itself.

use enfilade::{
    Aabb, Camera, GeometryBuilder, Material, MaterialId, Mesh, Method, OccluderMesh, OcclusionBuffer, Scene,
    Transform, Viewer,
};
use enfilade_scenes::{Random, parallel_view};

/// Side lengths of the field of boxes, in units.
const FIELD: f32 = 20.0;

#[test]
fn a_buffer_without_a_scene_shows_all_that_a_depth_buffer_shows_in_parallel() {
    let mut random = Random::new(31);
    let (mut seen, mut hidden) = (0, 0);
    for _ in 0..60 {
        let boxes: Vec<Aabb> = (0..80)
            .map(|_| {
                let [at, size] = [random.point(0.5 * FIELD), random.point(1.5)];
                Aabb::of([at, std::array::from_fn(|axis| at[axis] + size[axis] + 2.0)])
            })
            .collect();
        let camera = Camera::new(random.point(FIELD), random.point(2.0));
        let view = parallel_view(&camera, [96, 64], &mut random);
        let mut geometry = GeometryBuilder::new([Material::opaque([0.5; 3])]);
        let mut buffer = OcclusionBuffer::new();
        buffer.begin(&view);
        for bounds in &boxes {
            let mesh = Mesh::cuboid(bounds.min, bounds.max, MaterialId(0)).expect("a box");
            let fans = (0..mesh.face_count()).map(|face| mesh.face(face));
            let indices: Vec<u32> = fans
                .flat_map(|face| (2..face.len()).flat_map(|last| [face[0], face[last - 1], face[last]]))
                .collect();
            let occluder = OccluderMesh::triangles(mesh.positions(), &indices).expect("a box");
            buffer.draw(&occluder, &Transform::IDENTITY);
            let mesh = geometry.mesh(mesh);
            geometry.item("box", mesh, Transform::IDENTITY);
        }
        let scene = Scene::single(geometry.build().expect("sound"), Method::ZBuffer).expect("boxes");
        let mut visible = [0_u64; 2];
        buffer.test_boxes(&boxes, &mut visible);
        let mut viewer = Viewer::new();
        for item in viewer.look(&scene, &view).items() {
            let number = item.item.index.0 as usize;
            assert!(
                visible[number / 64] >> (number % 64) & 1 == 1,
                "box {number} in {view:?}"
            );
            seen += 1;
        }
        hidden += boxes.len() as u32 - visible.iter().map(|word| word.count_ones()).sum::<u32>();
    }
    assert!(
        seen > 200 && hidden > 1000,
        "{seen} boxes are seen, {hidden} hidden"
    );
}
