//! The occlusion buffer without a scene: draw a few houses as occluders, test a thousand people against them.
//!
//! Run with `cargo run --example 01_bare_buffer -p enfilade`.
#![expect(clippy::print_stdout, reason = "examples print")]

use enfilade::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Occluders are plain arrays: positions, and three indices per triangle, counter-clockwise seen from outside.
    let corners = Aabb {
        min: [-5.0, 0.0, -5.0],
        max: [5.0, 9.0, 5.0],
    }
    .corners();
    let house = OccluderMesh::triangles(
        &corners,
        &[
            0, 4, 6, 0, 6, 2, // left
            1, 3, 7, 1, 7, 5, // right
            0, 2, 3, 0, 3, 1, // back
            4, 5, 7, 4, 7, 6, // front
            2, 6, 7, 2, 7, 3, // roof
        ],
    )?;
    let houses: Vec<Transform> = (0..40)
        .map(|n| Transform::translation([(n % 8) as f32 * 14.0 - 49.0, 0.0, (n / 8) as f32 * -14.0 - 20.0]))
        .collect();
    let people: Vec<Aabb> = (0..1000)
        .map(|n| [(n % 40) as f32 * 2.9 - 57.0, 0.0, (n / 40) as f32 * -3.3 - 11.0])
        .map(|[x, y, z]| Aabb {
            min: [x - 0.3, y, z - 0.3],
            max: [x + 0.3, y + 1.8, z + 0.3],
        })
        .collect();

    // Keep one buffer per camera: it allocates nothing once it has grown.
    let mut buffer = OcclusionBuffer::new();
    let mut visible = vec![0_u64; people.len().div_ceil(64)];
    for step in 0..4 {
        let eye = [step as f32 * 7.0, 1.7, 0.0];
        buffer.begin(&View::new(eye, [0.0, 1.7, -60.0], [160, 90]));
        buffer.draw_all(houses.iter().map(|&at| (&house, at)));
        buffer.test_boxes(&people, &mut visible);
        let seen: u32 = visible.iter().map(|word| word.count_ones()).sum();
        println!(
            "from x = {}: {seen} of {} people may be visible",
            eye[0],
            people.len()
        );
    }

    // The depths of the last view: the darker, the nearer.
    for row in buffer.depth().chunks(160).step_by(6) {
        let shade = |&depth: &f32| b" .:-=+*#%@"[((depth * 150.0) as usize).min(9)] as char;
        println!("{}", row.iter().step_by(2).map(shade).collect::<String>());
    }
    Ok(())
}
