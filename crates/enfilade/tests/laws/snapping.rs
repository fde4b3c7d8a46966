//! Renderers that snap vertices to a grid of sub-pixels, as GPUs do.

use crate::subject::subjects;
use enfilade::{Alpha, Geometry, ItemIndex, Method, Scene, Transform, View, Viewer};
use glam::{DMat4, DVec3, DVec4};
use std::collections::BTreeSet;

const SIZE: [u32; 2] = [96, 54];

/// A corner on the screen, in steps of the grid, and its reversed depth.
type Snapped = ([i64; 2], f64);

/// Returns the opaque items that a rasterizer shows which snaps vertices to `steps` positions per pixel and samples pixel
/// centres.
fn drawn_snapped(geometry: &Geometry, view: &View, steps: i64) -> BTreeSet<ItemIndex> {
    let [width, height] = view.size().map(|side| side as usize);
    let mut nearest = vec![(0.0, None); width * height];
    for (number, item) in geometry.items().iter().enumerate() {
        let id = ItemIndex(number as u32);
        let mesh = geometry.mesh_of(id);
        let clip_from_item =
            matrix(view.clip_from_eye()) * affine(&view.eye_from_sector()) * affine(&item.transform());
        for cluster in mesh.clusters() {
            let material = geometry.material(cluster);
            if material.alpha != Alpha::Opaque {
                continue;
            }
            for face in cluster.faces.clone() {
                let corners: Vec<DVec4> = mesh
                    .face(face)
                    .iter()
                    .map(|&corner| mesh.positions()[corner as usize].map(f64::from))
                    .map(|corner| clip_from_item * DVec3::from(corner).extend(1.0))
                    .collect();
                for last in 2..corners.len() {
                    let triangle = [corners[0], corners[last - 1], corners[last]];
                    let front = item.transform().mirrors();
                    for [a, b, c] in before_near(&triangle, f64::from(view.z_near()), [width, height], steps)
                    {
                        let area = cross(a.0, b.0, c.0);
                        // y is down, so front faces are clockwise in numbers.
                        let is_front = (area < 0) != front;
                        if area == 0 || !(is_front || material.double_sided) {
                            continue;
                        }
                        let [a, b, c] = if area > 0 { [a, b, c] } else { [a, c, b] };
                        fill([a, b, c], steps, [width, height], |at, rev_depth| {
                            if rev_depth > nearest[at].0 {
                                nearest[at] = (rev_depth, Some(id));
                            }
                        });
                    }
                }
            }
        }
    }
    nearest.into_iter().filter_map(|(_, item)| item).collect()
}

/// Clips a triangle at the near plane and snaps it; returns its triangles.
fn before_near(triangle: &[DVec4; 3], near: f64, size: [usize; 2], steps: i64) -> Vec<[Snapped; 3]> {
    let mut kept = Vec::new();
    for at in 0..3 {
        let [here, there] = [triangle[at], triangle[(at + 1) % 3]];
        if here.w >= near {
            kept.push(here);
        }
        if (here.w >= near) != (there.w >= near) {
            kept.push(here + (there - here) * ((near - here.w) / (there.w - here.w)));
        }
    }
    let snap = |corner: &DVec4| {
        let x = 0.5 * size[0] as f64 * (1.0 + corner.x / corner.w);
        let y = 0.5 * size[1] as f64 * (1.0 - corner.y / corner.w);
        let grid = |value: f64| (value * steps as f64).round() as i64;
        ([grid(x), grid(y)], 1.0 / corner.w)
    };
    let snapped: Vec<Snapped> = kept.iter().map(snap).collect();
    (2..snapped.len())
        .map(|last| [snapped[0], snapped[last - 1], snapped[last]])
        .collect()
}

/// Twice the signed area of a triangle.
fn cross(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i128 {
    let [bx, by, cx, cy] = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]].map(i128::from);
    bx * cy - by * cx
}

/// Calls `paint` with the samples of a triangle of positive area, by integer edge functions; left and top edges own.
fn fill(triangle: [Snapped; 3], steps: i64, size: [usize; 2], mut paint: impl FnMut(usize, f64)) {
    let [a, b, c] = triangle;
    let area = cross(a.0, b.0, c.0) as f64;
    let reach = |axis: usize| {
        let places = [a.0[axis], b.0[axis], c.0[axis]];
        let [low, high] =
            [places.iter().min(), places.iter().max()].map(|place| place.expect("three") / steps);
        low.clamp(0, size[axis] as i64) as usize..(high + 1).clamp(0, size[axis] as i64) as usize
    };
    for y in reach(1) {
        for x in reach(0) {
            let sample = [x, y].map(|place| place as i64 * steps + steps / 2);
            let mut weights = [0.0; 3];
            let edges = [(b, c), (c, a), (a, b)];
            let is_inside = edges.iter().zip(&mut weights).all(|((from, to), weight)| {
                let edge = cross(from.0, to.0, sample);
                *weight = edge as f64 / area;
                let [dx, dy] = [to.0[0] - from.0[0], to.0[1] - from.0[1]];
                edge > 0 || edge == 0 && (dy < 0 || dy == 0 && dx > 0)
            });
            if is_inside {
                paint(
                    y * size[0] + x,
                    weights[0] * a.1 + weights[1] * b.1 + weights[2] * c.1,
                );
            }
        }
    }
}

fn matrix(columns: [[f64; 4]; 4]) -> DMat4 {
    DMat4::from_cols_array_2d(&columns)
}

fn affine(transform: &Transform) -> DMat4 {
    let [x, y, z, at] = transform.columns_f64().map(DVec3::from);
    DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), at.extend(1.0))
}

/// Returns the items that a renderer with `steps` sub-pixels shows and a look with a margin does not list, and the number of
/// those that it shows.
fn missed(scene: &Scene, view: &View, margin_px: f32, shown: &BTreeSet<ItemIndex>) -> usize {
    let mut viewer = Viewer::new();
    viewer.options.margin_px = margin_px;
    let listed: BTreeSet<ItemIndex> = viewer
        .look(scene, view)
        .items()
        .iter()
        .map(|item| item.item.index)
        .collect();
    shown.difference(&listed).count()
}

#[test]
fn with_a_margin_nothing_is_missed_that_a_renderer_shows_which_snaps_its_vertices() {
    let (mut shown, mut without) = (0, 0);
    for steps in [16, 256] {
        for subject in subjects().iter().filter(|subject| subject.name != "enfilade") {
            for camera in subject.built.cameras.iter().take(4) {
                let mut view = camera.view(SIZE).expect("a valid view");
                let Some(sector) = subject.built.scene.sector_of(&view) else {
                    continue;
                };
                view.sector = Some(sector);
                let geometry = subject
                    .built
                    .scene
                    .geometry(sector)
                    .expect("a sector with geometry");
                let items = drawn_snapped(geometry, &view, steps);
                shown += items.len();
                for (method, scene) in &subject.seen {
                    let scene = scene.without_portals();
                    let misses = missed(&scene, &view, 1.0 / steps as f32, &items);
                    let place = format!("{method} on @{} from `{}`", subject.name, camera.name);
                    assert_eq!(misses, 0, "{place}, {steps} steps per pixel");
                    if *method == Method::ZBuffer {
                        without += missed(&scene, &view, 0.0, &items);
                    }
                }
            }
        }
    }
    assert!(shown > 2000, "only {shown} items were shown");
    assert!(
        without > 3,
        "only {without} items show up by snapping: the test cannot fail"
    );
}
