//! Clips a convex polygon to another, edge by edge.
//!
//! Source: Sutherland, Hodgman. Reentrant polygon clipping. 1974.

use glam::Vec2;

/// Returns the part of `polygon` inside the convex `region`, with the same winding; fewer than three corners if the
/// intersection is empty.
pub(crate) fn clip(polygon: &[Vec2], region: &[Vec2]) -> Vec<Vec2> {
    let turn: f32 = (1..region.len() - 1)
        .map(|i| (region[i] - region[0]).perp_dot(region[i + 1] - region[0]))
        .sum::<f32>()
        .signum();
    let mut left = polygon.to_vec();
    for i in 0..region.len() {
        let [from, to] = [region[i], region[(i + 1) % region.len()]];
        let inside = |at: Vec2| turn * (to - from).perp_dot(at - from);
        let mut kept = Vec::with_capacity(left.len() + 1);
        for (j, &at) in left.iter().enumerate() {
            let next = left[(j + 1) % left.len()];
            let [here, there] = [inside(at), inside(next)];
            if here >= 0.0 {
                kept.push(at);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                kept.push(at.lerp(next, here / (here - there)));
            }
        }
        kept.dedup_by(|a, b| a.distance_squared(*b) < 1e-8);
        left = kept;
    }
    if left.len() > 1 && left[0].distance_squared(left[left.len() - 1]) < 1e-8 {
        left.pop();
    }
    left
}
