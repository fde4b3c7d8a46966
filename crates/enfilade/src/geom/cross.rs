//! Cross products of edges, accurate to the last bits even if the edges are nearly parallel.
//!
//! Differences and products carry their rounding errors along (double-double arithmetic), so that a needle triangle
//! gets its true normal.
//! Source: Dekker. A Floating-Point Technique for Extending the Available Precision. 1971; Knuth's two-sum.
//! Cost: about 150 floating-point operations.
//! Error: a few 2⁻⁵³ of the result, plus 2⁻¹⁰⁴ of the product of the lengths.

use glam::DVec3;

/// An edge vector: its f64 value and the rounding error of that value.
pub(crate) type Edge = (DVec3, DVec3);

/// Returns the exact edge vector from `from` to `to`.
#[cfg(any(test, feature = "classic"))]
pub(crate) fn edge(from: DVec3, to: DVec3) -> Edge {
    let rounded = to - from;
    let back = rounded - to;
    (rounded, (to - (rounded - back)) - (from + back))
}

/// Returns the cross product of two edges.
pub(crate) fn cross(a: Edge, b: Edge) -> DVec3 {
    let ((a, a_rest), (b, b_rest)) = (a, b);
    let main = DVec3::new(
        minor(a.y, b.z, a.z, b.y),
        minor(a.z, b.x, a.x, b.z),
        minor(a.x, b.y, a.y, b.x),
    );
    main + (a.cross(b_rest) + a_rest.cross(b))
}

/// Returns a·b − c·d.
fn minor(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let ((ab, ab_rest), (cd, cd_rest)) = (product(a, b), product(c, d));
    (ab - cd) + (ab_rest - cd_rest)
}

/// Returns the product and its rounding error. (A fused multiply-add would take two steps, but is not available
/// everywhere.)
fn product(a: f64, b: f64) -> (f64, f64) {
    let rounded = a * b;
    let ((a, a_low), (b, b_low)) = (halves(a), halves(b));
    (
        rounded,
        ((a * b - rounded) + a * b_low + a_low * b) + a_low * b_low,
    )
}

/// Splits a value into its upper 26 bits and the rest.
fn halves(value: f64) -> (f64, f64) {
    let shifted = ((1_u64 << 27) + 1) as f64 * value;
    let upper = shifted - (shifted - value);
    (upper, value - upper)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_needle_has_the_normal_it_really_has() {
        // Far from the origin, one metre long, 2⁻³⁰ wide; plain arithmetic would be off by degrees.
        let first = DVec3::new(1e6, -2e6, 3e6);
        let along = DVec3::new(0.5, 0.25, 0.75);
        let aside = along + DVec3::new(0.0, 2_f64.powi(-30), 0.0);
        let normal = cross(edge(first, first + along), edge(first, first + aside));
        assert_eq!(normal, DVec3::new(-0.75, 0.0, 0.5) * 2_f64.powi(-30));
    }

    #[test]
    fn nothing_is_lost_in_a_difference_or_a_product() {
        let (rounded, rest) = edge(DVec3::splat(1e-9), DVec3::splat(1.0));
        assert_eq!(rounded.x, 1.0 - 1e-9);
        assert!(rest.x != 0.0 && rest.x.abs() < 2_f64.powi(-53));
        let third = 1.0 / 3.0;
        let (rounded, rest) = product(third, third);
        assert!(rounded == third * third && rest != 0.0);
        assert_eq!(minor(third, third, third, third), 0.0);
    }
}
