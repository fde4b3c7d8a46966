//! Projection of a view, reimplemented from its documentation, so that the reference shares no arithmetic with the
//! engine.

use enfilade::View;

/// The projection of a view.
#[derive(Clone, Copy)]
pub(super) struct Lens {
    pub(super) size: [u32; 2],
    /// Near-plane distance; geometry in front of it is neither visible nor an occluder.
    pub(super) near: f64,
    eye: [f64; 3],
    right: [f64; 3],
    up: [f64; 3],
    ahead: [f64; 3],
    /// Focal length, in pixels: the size of one unit at a distance of one unit.
    focal: f64,
}

impl Lens {
    /// Creates the projection of a view. Its samples must be at pixel centres, and its up vector not parallel to the
    /// view direction.
    pub(super) fn new(view: &View) -> Lens {
        let [eye, toward, up] = [view.eye(), view.toward(), view.up()];
        let ahead = unit(minus(toward, eye));
        let right = unit(cross(ahead, up));
        Lens {
            size: view.size(),
            near: f64::from(view.z_near()),
            eye,
            right,
            up: cross(right, ahead),
            ahead,
            // The documentation of `View` says that the tangent is rounded to f32.
            focal: 0.5 * f64::from(view.size()[1]) / f64::from((0.5 * f64::from(view.fov_y())).tan() as f32),
        }
    }

    /// Returns (X, Y, W) of a point: its pixel is (X / W, Y / W), y down, and W its distance along the view direction.
    pub(super) fn corner(&self, point: [f32; 3]) -> [f64; 3] {
        let from_eye = minus(point.map(f64::from), self.eye);
        let w = dot(from_eye, self.ahead);
        let [x, y] = self.middle();
        [
            self.focal * dot(from_eye, self.right) + x * w,
            y * w - self.focal * dot(from_eye, self.up),
            w,
        ]
    }

    /// Returns the point at a pixel, at distance `w` along the view direction.
    pub(super) fn point(&self, pixel: [f64; 2], w: f64) -> [f32; 3] {
        let [x, y] = self.middle();
        let [x, y] = [(pixel[0] - x) * w / self.focal, (y - pixel[1]) * w / self.focal];
        [0, 1, 2].map(|axis| {
            (self.eye[axis] + self.right[axis] * x + self.up[axis] * y + self.ahead[axis] * w) as f32
        })
    }

    /// Returns the pixel position of the view direction, in coordinates whose samples are at pixel centres.
    fn middle(&self) -> [f64; 2] {
        [0, 1].map(|axis| 0.5 * f64::from(self.size[axis]) - View::GENERIC_OFFSET[axis])
    }
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|value| value / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_where_it_was_put() {
        let view = View::new([1.0, 2.0, 3.0], [4.0, 1.0, -7.0], [640, 480]).expect("a valid view");
        let lens = Lens::new(&view);
        let [x, y, w] = lens.corner(lens.point([100.0, 50.0], 8.0));
        assert!((x / w - 100.0).abs() < 1e-4 && (y / w - 50.0).abs() < 1e-4 && (w - 8.0).abs() < 1e-5);
        let [x, y, w] = lens.corner(view.toward().map(|value| value as f32));
        let [dx, dy] = View::GENERIC_OFFSET;
        assert!((x / w + dx - 320.0).abs() < 1e-9 && (y / w + dy - 240.0).abs() < 1e-9 && w > 0.0);
    }
}
