//! Shadow volumes: the points that a face keeps a light from.

use super::Leg;
use super::strip::Bounds;
use crate::lamps::PassageLight;
use crate::mips::Mips;
use crate::stage::Stage;
use enfilade::{Alpha, Geometry, ItemIndex, Mesh};
use glam::{DAffine3, DMat3, DVec3};
use smallvec::SmallVec;

/// What makes shadow volumes of the faces on one leg.
pub(super) struct Caster<'a> {
    pub(super) light: &'a PassageLight,
    pub(super) leg: &'a Leg,
    pub(super) stage: &'a Stage,
}

impl<'a> Caster<'a> {
    /// Returns the shadow volumes of the faces of a cluster.
    pub(super) fn volumes(
        &self,
        geometry: &'a Geometry,
        item: ItemIndex,
        cluster: u32,
        around: &Bounds,
    ) -> Vec<Volume<'a>> {
        let mesh = geometry.mesh_of(item);
        let cluster = &mesh.clusters()[cluster as usize];
        let material = geometry.material(cluster);
        if material.alpha == Alpha::Blend {
            return Vec::new();
        }
        let [x, y, z, offset] = geometry.item(item).transform().columns_f64().map(DVec3::from);
        let leg_from_item = DAffine3 {
            matrix3: DMat3::from_cols(x, y, z),
            translation: offset,
        };
        let cutout = (material.alpha == Alpha::Mask)
            .then(|| self.stage.mips(geometry, material.texture))
            .flatten()
            .filter(|_| !mesh.texture().is_empty());
        let volumes = cluster.faces.clone().filter_map(|face| {
            let corners: SmallVec<[DVec3; 8]> = mesh
                .face(face)
                .iter()
                .map(|&corner| DVec3::from(mesh.positions()[corner as usize].map(f64::from)))
                .collect();
            let cutout = cutout.map(|texture| Cutout {
                texture,
                mesh,
                face,
                cutoff: material.cutoff,
                opacity: material.base_color[3],
                item_from_here: (self.leg.here_from_leg * leg_from_item).inverse(),
            });
            self.volume(&corners, leg_from_item, material.double_sided, cutout)
        });
        volumes.filter(|volume| volume.meets(around)).collect()
    }

    /// Returns the shadow volume of a face; `None` if it casts no shadow.
    pub(super) fn volume(
        &self,
        corners: &[DVec3],
        leg_from_item: DAffine3,
        double_sided: bool,
        cutout: Option<Cutout<'a>>,
    ) -> Option<Volume<'a>> {
        let mut outline: SmallVec<[DVec3; 8]> = corners
            .iter()
            .map(|&corner| leg_from_item.transform_point3(corner))
            .collect();
        for &(normal, distance) in &self.leg.planes {
            clip(&mut outline, normal, distance);
        }
        for corner in &mut outline {
            *corner = self.leg.here_from_leg.transform_point3(*corner);
        }
        let first = *outline.first()?;
        let mut normal: DVec3 = outline
            .windows(2)
            .map(|pair| (pair[0] - first).cross(pair[1] - first))
            .sum();
        let determinant = self.leg.here_from_leg.matrix3.determinant() * leg_from_item.matrix3.determinant();
        let mirrored = determinant < 0.0;
        let toward = self.light.toward(first);
        let facing = normal.dot(toward);
        let is_front = (facing > 0.0) != mirrored;
        let length = normal.length();
        // Edge-on faces, and what is not finite, cast none.
        let is_seen = facing.abs() > 1e-12 * length * toward.length();
        if !is_seen || !(is_front || double_sided) {
            return None;
        }
        if facing < 0.0 {
            outline.reverse();
            normal = -normal;
        }
        normal /= length;
        let mut planes: SmallVec<[(DVec3, f64); 5]> = SmallVec::new();
        planes.push((-normal, -normal.dot(first)));
        for (number, &start) in outline.iter().enumerate() {
            let end = outline[(number + 1) % outline.len()];
            // In one order for both faces that share the edge, so that no sample is between their volumes.
            let is_ordered = start.to_array() < end.to_array();
            let [low, high] = if is_ordered { [start, end] } else { [end, start] };
            let side = self.light.toward(low).cross(high - low);
            let distance = side.dot(low);
            planes.push(if is_ordered {
                (side, distance)
            } else {
                (-side, -distance)
            });
        }
        Some(Volume { planes, cutout })
    }
}

/// Clips a convex outline to n · p ≥ d.
fn clip(outline: &mut SmallVec<[DVec3; 8]>, normal: DVec3, distance: f64) {
    if outline.iter().all(|corner| normal.dot(*corner) >= distance) {
        return;
    }
    let whole = std::mem::take(outline);
    for (number, &here) in whole.iter().enumerate() {
        let there = whole[(number + 1) % whole.len()];
        let [at_here, at_there] = [here, there].map(|corner| normal.dot(corner) - distance);
        if at_here >= 0.0 {
            outline.push(here);
        }
        if (at_here < 0.0) != (at_there < 0.0) {
            outline.push(here + (there - here) * (at_here / (at_here - at_there)));
        }
    }
}

/// The points that a face keeps a light from: n · p ≥ d for all planes. The first is that of the face.
pub(super) struct Volume<'a> {
    pub(super) planes: SmallVec<[(DVec3, f64); 5]>,
    pub(super) cutout: Option<Cutout<'a>>,
}

/// The alpha test of a face.
pub(super) struct Cutout<'a> {
    texture: &'a Mips,
    mesh: &'a Mesh,
    face: u32,
    cutoff: f32,
    opacity: f32,
    item_from_here: DAffine3,
}

/// How much of a box is inside a volume.
pub(super) enum Part {
    None,
    Some,
    All,
}

impl Volume<'_> {
    pub(super) fn meets(&self, bounds: &Bounds) -> bool {
        !matches!(self.part(bounds, 0.0), Part::None)
    }

    pub(super) fn part(&self, bounds: &Bounds, behind: f64) -> Part {
        let mut part = Part::All;
        for (number, &(normal, distance)) in self.planes.iter().enumerate() {
            let slack = if number == 0 { behind } else { 0.0 };
            let at = normal.dot(bounds.middle()) - distance - slack;
            let reach = normal.abs().dot(bounds.half());
            if at + reach < 0.0 {
                return Part::None;
            }
            if at < reach {
                part = Part::Some;
            }
        }
        if self.cutout.is_some() { Part::Some } else { part }
    }

    /// Returns where light on its way to a point inside goes through the face.
    pub(super) fn entry(&self, point: DVec3, light: &PassageLight) -> DVec3 {
        let (normal, distance) = self.planes[0];
        let toward = light.toward(point);
        point + toward * ((distance - normal.dot(point)) / normal.dot(toward))
    }
}

impl Cutout<'_> {
    /// Whether the face passes the alpha test where light goes through it.
    pub(super) fn is_opaque_at(&self, at: DVec3) -> bool {
        let at = self.item_from_here.transform_point3(at);
        let corners = self.mesh.face(self.face);
        let position = |i: usize| DVec3::from(self.mesh.positions()[corners[i] as usize].map(f64::from));
        let uv = |i: usize| self.mesh.texture()[corners[i] as usize].map(f64::from);
        let first = position(0);
        let mut best = (f64::NEG_INFINITY, [0.0; 2]);
        for last in 2..corners.len() {
            let [a, b] = [position(last - 1) - first, position(last) - first];
            let normal = a.cross(b);
            let square = normal.length_squared();
            let off = at - first;
            let [v, w] = [
                off.cross(b).dot(normal) / square,
                a.cross(off).dot(normal) / square,
            ];
            let inside = v.min(w).min(1.0 - v - w);
            if inside > best.0 {
                let [o, a, b] = [uv(0), uv(last - 1), uv(last)];
                best = (
                    inside,
                    [0, 1].map(|axis| o[axis] + v * (a[axis] - o[axis]) + w * (b[axis] - o[axis])),
                );
            }
        }
        let texel = self.texture.at(best.1.map(|value| value as f32), 0.0);
        texel.w * self.opacity >= self.cutoff
    }
}
