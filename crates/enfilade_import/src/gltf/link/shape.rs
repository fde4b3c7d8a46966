//! Openings and exits that are given by coordinates instead of nodes.

use super::LinkError;
use glam::{DMat3, DQuat, DVec3};

/// An opening or exit, in the space of a part.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A rectangle that is entered, or left, along `ahead`.
    Rectangle {
        /// Its centre.
        center: [f64; 3],
        /// Its direction, of any length except 0.
        ahead: [f64; 3],
        /// Approximate direction of its height. Default: +y, or −z if `ahead` is vertical.
        up: Option<[f64; 3]>,
        /// Width and height, above 0; `None` for an exit without an opening.
        size: Option<[f64; 2]>,
    },
    /// A flat convex polygon, counter-clockwise when seen from the side that is entered. Its centre is the mean of its
    /// corners.
    Outline(Vec<[f64; 3]>),
}

/// A shape in a local frame whose −z is its direction.
pub(super) struct ShapeFrame {
    pub(super) place: [f64; 3],
    pub(super) rotation: [f64; 4],
    /// Corners in that frame; empty for an exit without an opening.
    pub(super) corners: Vec<[f32; 3]>,
}

impl Shape {
    pub(super) fn turned(&self) -> Result<ShapeFrame, LinkError> {
        match self {
            Shape::Rectangle {
                center,
                ahead,
                up,
                size,
            } => {
                let center = DVec3::from(*center);
                let turn = turn(DVec3::from(*ahead), up.map(DVec3::from))?;
                let corners = match size {
                    None => Vec::new(),
                    Some([width, height])
                        if *width > 0.0 && *height > 0.0 && (width * height).is_finite() =>
                    {
                        let [x, y] = [width / 2.0, height / 2.0].map(|half| half as f32);
                        vec![[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]]
                    }
                    Some(_) => return Err(LinkError::BadShape("its size must be two numbers above 0")),
                };
                placed(center, turn, corners)
            }
            Shape::Outline(corners) => {
                if corners.len() < 3 {
                    return Err(LinkError::BadShape("an outline needs at least 3 corners"));
                }
                let corners: Vec<DVec3> = corners.iter().map(|&corner| DVec3::from(corner)).collect();
                let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
                let normal: DVec3 = (0..corners.len())
                    .map(|i| (corners[i] - middle).cross(corners[(i + 1) % corners.len()] - middle))
                    .sum();
                let turn = turn(-normal, None)
                    .map_err(|_| LinkError::BadShape("its outline has no area, or is not finite"))?;
                let back = turn.transpose();
                let local = corners
                    .iter()
                    .map(|corner| (back * (*corner - middle)).as_vec3().into());
                placed(middle, turn, local.collect())
            }
        }
    }
}

/// Checks that the numbers are finite and builds the frame.
fn placed(place: DVec3, turn: DMat3, corners: Vec<[f32; 3]>) -> Result<ShapeFrame, LinkError> {
    if !(place.is_finite() && turn.is_finite()) {
        return Err(LinkError::BadShape("its numbers must be finite"));
    }
    Ok(ShapeFrame {
        place: place.into(),
        rotation: DQuat::from_mat3(&turn).normalize().into(),
        corners,
    })
}

/// Returns the rotation whose −z is `ahead`.
fn turn(ahead: DVec3, up: Option<DVec3>) -> Result<DMat3, LinkError> {
    let back = ahead
        .try_normalize()
        .map(|ahead| -ahead)
        .ok_or(LinkError::BadShape("`ahead` must not be 0"))?;
    let ups = [up.unwrap_or(DVec3::Y), DVec3::NEG_Z, DVec3::X];
    let square = |up: DVec3| {
        (up - back * up.dot(back)).try_normalize().filter(|_| {
            // A direction nearly parallel to `ahead` does not define a rotation.
            up.normalize_or_zero().cross(back).length() > 1e-4
        })
    };
    let up = ups
        .into_iter()
        .find_map(square)
        .ok_or(LinkError::BadShape("`up` must not be 0"))?;
    Ok(DMat3::from_cols(up.cross(back), up, back))
}
