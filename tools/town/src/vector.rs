//! Vectors and rigid transforms in f64.

use std::ops::{Add, Mul, Neg, Sub};

/// A position or a direction: x, y (up), z in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Vector {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
}

pub(crate) const fn v(x: f64, y: f64, z: f64) -> Vector {
    Vector { x, y, z }
}

impl Vector {
    pub(crate) const ZERO: Vector = v(0.0, 0.0, 0.0);
    pub(crate) const X: Vector = v(1.0, 0.0, 0.0);
    pub(crate) const Y: Vector = v(0.0, 1.0, 0.0);
    pub(crate) const Z: Vector = v(0.0, 0.0, 1.0);

    pub(crate) fn dot(self, other: Vector) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    pub(crate) fn cross(self, other: Vector) -> Vector {
        v(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    pub(crate) fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Returns the vector scaled to length 1; up if it has no length.
    pub(crate) fn unit(self) -> Vector {
        let length = self.length();
        if length > 1e-12 {
            self * (1.0 / length)
        } else {
            Vector::Y
        }
    }

    pub(crate) fn lerp(self, to: Vector, share: f64) -> Vector {
        self + (to - self) * share
    }
}

impl Add for Vector {
    type Output = Vector;

    fn add(self, other: Vector) -> Vector {
        v(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl Sub for Vector {
    type Output = Vector;

    fn sub(self, other: Vector) -> Vector {
        v(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Mul<f64> for Vector {
    type Output = Vector;

    fn mul(self, factor: f64) -> Vector {
        v(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl Neg for Vector {
    type Output = Vector;

    fn neg(self) -> Vector {
        self * -1.0
    }
}

/// A right-handed rigid transform: an origin and three unit axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub(crate) origin: Vector,
    pub(crate) x: Vector,
    pub(crate) y: Vector,
    pub(crate) z: Vector,
}

impl Frame {
    pub(crate) const TILE: Frame = Frame {
        origin: Vector::ZERO,
        x: Vector::X,
        y: Vector::Y,
        z: Vector::Z,
    };

    /// Returns an upright frame whose z axis points along (`sin yaw`, 0, `cos yaw`).
    pub(crate) fn upright(origin: Vector, yaw: f64) -> Frame {
        let (sine, cosine) = yaw.sin_cos();
        Frame {
            origin,
            x: v(cosine, 0.0, -sine),
            y: Vector::Y,
            z: v(sine, 0.0, cosine),
        }
    }

    pub(crate) fn point(&self, at: Vector) -> Vector {
        self.origin + self.direction(at)
    }

    pub(crate) fn direction(&self, along: Vector) -> Vector {
        self.x * along.x + self.y * along.y + self.z * along.z
    }

    /// Returns a frame that is given relative to this one.
    pub(crate) fn then(&self, inner: Frame) -> Frame {
        Frame {
            origin: self.point(inner.origin),
            x: self.direction(inner.x),
            y: self.direction(inner.y),
            z: self.direction(inner.z),
        }
    }

    /// Returns the frame moved along its own axes.
    pub(crate) fn moved(&self, by: Vector) -> Frame {
        Frame {
            origin: self.point(by),
            ..*self
        }
    }

    /// Returns the frame moved along its own axes, then turned about its y axis.
    pub(crate) fn turned(&self, by: Vector, yaw: f64) -> Frame {
        self.then(Frame::upright(by, yaw))
    }
}

/// A rectangle on the ground of a tile, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
}

impl Rect {
    pub(crate) fn new(x0: f64, z0: f64, x1: f64, z1: f64) -> Rect {
        Rect {
            low: [x0, z0],
            high: [x1, z1],
        }
    }

    pub(crate) fn size(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.high[axis] - self.low[axis])
    }

    pub(crate) fn center(&self) -> [f64; 2] {
        [0, 1].map(|axis| (self.low[axis] + self.high[axis]) / 2.0)
    }

    pub(crate) fn grown(&self, by: f64) -> Rect {
        Rect {
            low: self.low.map(|at| at - by),
            high: self.high.map(|at| at + by),
        }
    }

    /// Returns the common part; `None` if it is narrower than a millimetre.
    pub(crate) fn within(&self, other: &Rect) -> Option<Rect> {
        let common = Rect {
            low: [0, 1].map(|axis| self.low[axis].max(other.low[axis])),
            high: [0, 1].map(|axis| self.high[axis].min(other.high[axis])),
        };
        (common.size().iter().all(|&side| side > 1e-3)).then_some(common)
    }

    /// Returns the four parts between this rectangle and an `inner` one.
    pub(crate) fn around(&self, inner: &Rect) -> [Rect; 4] {
        let ([x0, z0], [x1, z1]) = (self.low, self.high);
        let ([a0, b0], [a1, b1]) = (inner.low, inner.high);
        [
            Rect::new(x0, z0, x1, b0),
            Rect::new(a1, b0, x1, b1),
            Rect::new(x0, b1, x1, z1),
            Rect::new(x0, b0, a0, b1),
        ]
    }

    /// Returns the frame of a side and its length. Seen from outside, the origin is the left end, x points right and z
    /// toward the viewer. Sides are −z, +x, +z, −x.
    pub(crate) fn side(&self, side: usize) -> (Frame, f64) {
        let ([x0, z0], [x1, z1]) = (self.low, self.high);
        let (origin, x, z, axis) = match side {
            0 => (v(x1, 0.0, z0), -Vector::X, -Vector::Z, 0),
            1 => (v(x1, 0.0, z1), -Vector::Z, Vector::X, 1),
            2 => (v(x0, 0.0, z1), Vector::X, Vector::Z, 0),
            _ => (v(x0, 0.0, z0), Vector::Z, -Vector::X, 1),
        };
        let frame = Frame {
            origin,
            x,
            y: Vector::Y,
            z,
        };
        (frame, self.size()[axis])
    }
}
