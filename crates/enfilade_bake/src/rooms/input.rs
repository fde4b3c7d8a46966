//! Input of room detection: items with meshes, and which of them separate rooms.

use super::RoomsError;
use glam::{DAffine3, DVec3};

/// The triangles of a building, as items.
#[derive(Clone, Debug, Default)]
pub struct RoomsInput<'a> {
    /// Meshes, shared by items.
    pub meshes: Vec<RoomMesh<'a>>,
    /// Items; rooms and doors refer to them by index.
    pub items: Vec<RoomItem<'a>>,
}

/// Triangles in object space. Their winding does not matter.
#[derive(Clone, Debug)]
pub struct RoomMesh<'a> {
    /// Positions; triangles with one that is not finite are ignored.
    pub positions: &'a [[f32; 3]],
    /// Triangles that block sight: three indices into `positions` each.
    pub opaque: Vec<[u32; 3]>,
    /// Triangles that bound rooms but do not block sight, such as panes of glass.
    pub see_through: Vec<[u32; 3]>,
}

/// A mesh with a transform.
#[derive(Clone, Debug)]
pub struct RoomItem<'a> {
    /// Name, for doors that are recognized by it and for reports.
    pub name: &'a str,
    /// Index of the mesh.
    pub mesh: usize,
    /// Object-to-world transform: three columns of the linear part, then the translation.
    pub world_from_item: [[f64; 3]; 4],
    /// Whether the item is the leaf of a door or gate, if it is 1 to 10 m high: it separates rooms but can be opened.
    pub movable: bool,
}

/// How an item takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// Walls, slabs, panes, large furniture: separates rooms.
    Structure,
    /// The leaf of a door: separates rooms, but never blocks sight.
    Leaf,
    /// Small objects: block sight, but do not separate rooms.
    Clutter,
}

/// The vertical axis of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// +X.
    X,
    /// +Y, as in glTF.
    Y,
    /// +Z, as in Blender, Unreal and IFC.
    Z,
}

impl Up {
    /// Returns the axis of the scene that is the axis `metric` once y is up.
    pub(super) fn scene_axis(self, metric: u8) -> u8 {
        let turns = match self {
            Up::X => 2,
            Up::Y => 0,
            Up::Z => 1,
        };
        (metric + turns) % 3
    }
}

/// Maps scene coordinates to metres with y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Metric {
    pub(super) up: Up,
    pub(super) metres_per_unit: f64,
}

impl Metric {
    /// Returns a point of the scene in metres. Axes are permuted cyclically, which keeps the handedness.
    pub(super) fn metres(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let turned = match self.up {
            Up::X => [z, x, y],
            Up::Y => [x, y, z],
            Up::Z => [y, z, x],
        };
        turned.map(|value| value * self.metres_per_unit)
    }

    /// Returns a point in metres in the coordinates of the scene.
    pub(super) fn scene(&self, at: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = at.map(|value| value / self.metres_per_unit);
        match self.up {
            Up::X => [y, z, x],
            Up::Y => [x, y, z],
            Up::Z => [z, x, y],
        }
    }
}

/// An axis-aligned box in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) min: [f64; 3],
    pub(super) max: [f64; 3],
}

impl Bounds {
    pub(super) const EMPTY: Bounds = Bounds {
        min: [f64::INFINITY; 3],
        max: [f64::NEG_INFINITY; 3],
    };

    pub(super) fn add(&mut self, point: impl Into<[f64; 3]>) {
        let point = point.into();
        self.min = [0, 1, 2].map(|axis| self.min[axis].min(point[axis]));
        self.max = [0, 1, 2].map(|axis| self.max[axis].max(point[axis]));
    }

    pub(super) fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.min[axis] > self.max[axis])
    }

    pub(super) fn size(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.max[axis] - self.min[axis])
    }

    /// Returns `true` if the point is at most `margin` outside the box.
    pub(super) fn is_near(&self, point: [f64; 3], margin: f64) -> bool {
        (0..3).all(|axis| self.min[axis] - margin <= point[axis] && point[axis] <= self.max[axis] + margin)
    }
}

impl RoomsInput<'_> {
    /// Returns an error for the first index out of range.
    pub(super) fn check(&self) -> Result<(), RoomsError> {
        for (number, mesh) in self.meshes.iter().enumerate() {
            let corners = mesh.opaque.iter().chain(&mesh.see_through).flatten();
            if let Some(&index) = corners
                .into_iter()
                .find(|&&index| index as usize >= mesh.positions.len())
            {
                return Err(RoomsError::NoSuchPosition {
                    mesh: number,
                    index,
                    positions: mesh.positions.len(),
                });
            }
        }
        for (number, item) in self.items.iter().enumerate() {
            if item.mesh >= self.meshes.len() {
                return Err(RoomsError::NoSuchMesh {
                    item: number,
                    mesh: item.mesh,
                    meshes: self.meshes.len(),
                });
            }
        }
        Ok(())
    }

    /// Calls `each` with the corners of each triangle of an item in metres, and whether it is see-through. Triangles
    /// without area, or with a corner that is not finite, are left out.
    pub(super) fn for_each_triangle(
        &self,
        item: usize,
        metric: &Metric,
        mut each: impl FnMut(&[[f64; 3]; 3], bool),
    ) {
        let item = &self.items[item];
        let mesh = &self.meshes[item.mesh];
        let world_from_item = DAffine3::from_cols_array_2d(&item.world_from_item);
        let place = |index: u32| -> [f64; 3] {
            let at = DVec3::from(mesh.positions[index as usize].map(f64::from));
            metric.metres(world_from_item.transform_point3(at).into())
        };
        for (triangles, is_see_through) in [(&mesh.opaque, false), (&mesh.see_through, true)] {
            for triangle in triangles {
                let corners = triangle.map(place);
                let [a, b, c] = corners.map(DVec3::from);
                let doubled = (b - a).cross(c - a).length_squared();
                if doubled > 0.0 && doubled < f64::INFINITY {
                    each(&corners, is_see_through);
                }
            }
        }
    }

    /// Returns the box of each item, in metres.
    pub(super) fn bounds(&self, metric: &Metric) -> Vec<Bounds> {
        let of = |item| {
            let mut bounds = Bounds::EMPTY;
            self.for_each_triangle(item, metric, |corners, _| {
                corners.iter().for_each(|&at| bounds.add(at))
            });
            bounds
        };
        (0..self.items.len()).map(of).collect()
    }
}

/// Returns `true` if a name is that of a door or gate in English, French, German, Italian or Spanish, but not of furniture
/// with doors.
pub fn is_door_name(name: &str) -> bool {
    const WORDS: [&str; 7] = ["gate", "tor", "porte", "porta", "portone", "puerta", "portail"];
    const ENDINGS: [&str; 2] = ["tür", "tuer"];
    const OTHERS: [&str; 11] = [
        "indoor", "outdoor", "cabinet", "furni", "closet", "wardrobe", "cupboard", "fridge", "oven",
        "drawer", "shower",
    ];
    let name = name.to_lowercase();
    if OTHERS.iter().any(|other| name.contains(other)) {
        return false;
    }
    // Whole words, so that a motor or a portal is none.
    let is_door = |word: &str| {
        WORDS.contains(&word.trim_end_matches('s')) || ENDINGS.iter().any(|ending| word.ends_with(ending))
    };
    name.contains("door") || name.split(|letter: char| !letter.is_alphabetic()).any(is_door)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doors_are_known_by_name() {
        for door in [
            "Door_01",
            "IfcDoor:M_Single",
            "Innentuer-1",
            "garden gates",
            "Porte.002",
            "sliding-door",
            "Tür",
        ] {
            assert!(is_door_name(door), "{door}");
        }
        for other in [
            "motor",
            "Hall-portal",
            "OutdoorChair",
            "Tall Cabinet-Single Door",
            "navigator",
            "",
        ] {
            assert!(!is_door_name(other), "{other}");
        }
    }

    #[test]
    fn metres_and_scene_units_are_inverse() {
        for up in [Up::X, Up::Y, Up::Z] {
            let metric = Metric {
                up,
                metres_per_unit: 0.25,
            };
            assert_eq!(metric.scene(metric.metres([1.0, 2.0, 3.0])), [1.0, 2.0, 3.0]);
            let turned = metric.metres([1.0, 2.0, 3.0]);
            for axis in 0..3 {
                let from = [1.0, 2.0, 3.0][up.scene_axis(axis) as usize];
                assert_eq!(turned[axis as usize], 0.25 * from);
            }
        }
        let metric = Metric {
            up: Up::Z,
            metres_per_unit: 1.0,
        };
        assert_eq!(metric.metres([1.0, 2.0, 3.0])[1], 3.0);
    }
}
