//! The uses of accessors, and the element formats that each allows.

use super::elements::{Component, Kind};
use crate::BrokenRule;
use crate::gltf::document::{Accessor, short};

/// The use of an accessor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::gltf) enum AccessorUse {
    Positions,
    Normals,
    TextureCoordinates,
    Colors,
    Indices,
    /// Changes of colors by a morph target.
    ColorDeltas,
    /// Indices of joints.
    Joints,
    /// Weights of joints.
    JointWeights,
    InverseBindMatrices,
    /// Translations of instances.
    Translations,
    /// Rotations of instances.
    Rotations,
    /// Scales of instances.
    Scales,
}

impl AccessorUse {
    /// Returns the element format of an accessor, if this use allows it. Formats that only `KHR_mesh_quantization`
    /// allows are accepted even if the file does not declare that extension, because their meaning is unambiguous.
    pub(super) fn kind(
        self,
        accessor: &Accessor,
        place: impl FnOnce() -> String,
    ) -> Result<Kind, BrokenRule> {
        let component = Component::of(accessor.component_type);
        let parts = match &*accessor.shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => 0,
        };
        match component {
            Some(component) if self.takes(component, parts, accessor.normalized) => Ok(Kind {
                component,
                parts,
                normalized: (accessor.normalized || self.is_normalized())
                    && self != AccessorUse::Joints
                    && !matches!(component, Component::U32 | Component::F32),
            }),
            _ => Err(self.wrong_type(place(), accessor)),
        }
    }

    /// Whether integers are normalized even if the accessor does not say so. Colors would be up to 65,535 times too
    /// bright otherwise, and of weights only the ratios matter.
    fn is_normalized(self) -> bool {
        matches!(
            self,
            AccessorUse::Colors | AccessorUse::ColorDeltas | AccessorUse::JointWeights
        )
    }

    fn takes(self, component: Component, parts: u8, normalized: bool) -> bool {
        use Component::{F32, I8, I16, U8, U16, U32};
        match self {
            AccessorUse::Positions => parts == 3 && component != U32,
            AccessorUse::Normals => parts == 3 && matches!(component, F32 | I8 | I16),
            AccessorUse::TextureCoordinates => parts == 2 && component != U32,
            AccessorUse::Colors => (parts == 3 || parts == 4) && matches!(component, F32 | U8 | U16),
            AccessorUse::ColorDeltas => (parts == 3 || parts == 4) && component != U32,
            AccessorUse::Joints => parts == 4 && matches!(component, U8 | U16 | U32),
            AccessorUse::JointWeights => parts == 4 && matches!(component, F32 | U8 | U16),
            AccessorUse::InverseBindMatrices => parts == 16 && component == F32,
            AccessorUse::Indices => parts == 1 && matches!(component, U8 | U16 | U32),
            AccessorUse::Translations | AccessorUse::Scales => parts == 3 && component == F32,
            AccessorUse::Rotations => {
                parts == 4 && (component == F32 || normalized && matches!(component, I8 | I16))
            }
        }
    }

    fn wrong_type(self, place: String, accessor: &Accessor) -> BrokenRule {
        let component = match accessor.component_type {
            5120 => "BYTE".to_owned(),
            5121 => "UNSIGNED_BYTE".to_owned(),
            5122 => "SHORT".to_owned(),
            5123 => "UNSIGNED_SHORT".to_owned(),
            5125 => "UNSIGNED_INT".to_owned(),
            5126 => "FLOAT".to_owned(),
            other => format!("component type {other}"),
        };
        BrokenRule::WrongType {
            place,
            found: format!("{} of {component}", short(&accessor.shape)),
            wanted: match self {
                AccessorUse::Positions => "positions as VEC3 of FLOAT, or of bytes or shorts",
                AccessorUse::Normals => "normals as VEC3 of FLOAT, BYTE or SHORT",
                AccessorUse::TextureCoordinates => {
                    "texture coordinates as VEC2 of FLOAT, or of bytes or shorts"
                }
                AccessorUse::Colors => "colors as VEC3 or VEC4 of FLOAT, UNSIGNED_BYTE or UNSIGNED_SHORT",
                AccessorUse::ColorDeltas => {
                    "changes of colors as VEC3 or VEC4 of FLOAT, or of bytes or shorts"
                }
                AccessorUse::Joints => "joints as VEC4 of UNSIGNED_BYTE or UNSIGNED_SHORT",
                AccessorUse::JointWeights => {
                    "joint weights as VEC4 of FLOAT, UNSIGNED_BYTE or UNSIGNED_SHORT"
                }
                AccessorUse::InverseBindMatrices => "inverse bind matrices as MAT4 of FLOAT",
                AccessorUse::Indices => "indices as SCALAR of UNSIGNED_BYTE, UNSIGNED_SHORT or UNSIGNED_INT",
                AccessorUse::Translations => "translations of instances as VEC3 of FLOAT",
                AccessorUse::Rotations => {
                    "rotations of instances as VEC4 of FLOAT, or of normalized BYTE or SHORT"
                }
                AccessorUse::Scales => "scales of instances as VEC3 of FLOAT",
            },
            remedy: "export it again",
        }
    }
}
