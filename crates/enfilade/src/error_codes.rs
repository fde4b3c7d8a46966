//! Stable codes of all errors, in one table.

use crate::OccluderMeshError;
use crate::choose::SkipReason;
use crate::geom::PolygonError;
use crate::geometry::{BakedCellsError, GeometryError};
use crate::mesh::MeshError;
use crate::scene::{EditError, SceneError};
use crate::simd::SimdLevelError;
#[cfg(feature = "terrain")]
use crate::terrain::HeightFieldError;
use crate::unsuited::Unsuited;
use crate::view::ViewError;

/// Implements `code()` for each error enum, and lists the codes in the table of [`ERROR_CODES`].
macro_rules! error_codes {
    ($($(#[$cfg:meta])* $error:ident { $($variant:ident => $code:literal,)+ })+) => {
        $($(#[$cfg])* impl $error {
            /// Returns the stable code of this error, for logs, translations and tests: see
            /// [`ERROR_CODES`](crate::ERROR_CODES).
            pub fn code(&self) -> &'static str {
                match self {
                    $($error::$variant { .. } => $code,)+
                }
            }
        })+

        /// The codes of all errors, returned by their `code()`. A code stays the same when the variant or its message
        /// changes, and is never reused.
        ///
        /// An error that wraps another has a code of its own: that of `SceneError::Unsuited { why, .. }` is
        /// `scene/unsuited`, and that of `why.reason` says what the method lacks.
        ///
        /// | code | error |
        /// |---|---|
        $($(#[doc = concat!("| `", $code, "` | `", stringify!($error), "::", stringify!($variant), "` |")])+)+
        pub const ERROR_CODES: &[&str] = &[$($($code,)+)+];
    };
}

error_codes! {
    MeshError {
        EmptyCuboid => "mesh/empty-cuboid",
        NotFinite => "mesh/not-finite",
        TooFar => "mesh/too-far",
        IndexOutOfRange => "mesh/index-out-of-range",
        ShortStride => "mesh/short-stride",
        AttributeCount => "mesh/attribute-count",
        AttributeNotFinite => "mesh/attribute-not-finite",
        CornersLeft => "mesh/corners-left",
        BadFace => "mesh/bad-face",
    }
    OccluderMeshError {
        IndicesLeft => "occluder-mesh/indices-left",
        IndexOutOfRange => "occluder-mesh/index-out-of-range",
        NotFinite => "occluder-mesh/not-finite",
    }
    PolygonError {
        TooFewCorners => "polygon/too-few-corners",
        NotFinite => "polygon/not-finite",
        TooFar => "polygon/too-far",
        NoArea => "polygon/no-area",
        NotFlat => "polygon/not-flat",
        NotConvex => "polygon/not-convex",
    }
    GeometryError {
        NoSuchMesh => "geometry/no-such-mesh",
        NoSuchMaterial => "geometry/no-such-material",
        NoSuchTexture => "geometry/no-such-texture",
        NotFinite => "geometry/not-finite",
        TooFar => "geometry/too-far",
        TooManyFaces => "geometry/too-many-faces",
        TooManyOpenings => "geometry/too-many-openings",
        NotABlock => "geometry/not-a-block",
    }
    BakedCellsError {
        BadPlane => "baked-cells/bad-plane",
        Tolerance => "baked-cells/tolerance",
        NoSuchNode => "baked-cells/no-such-node",
        NoSuchCell => "baked-cells/no-such-cell",
        NoTree => "baked-cells/no-tree",
        NoSuchRow => "baked-cells/no-such-row",
        NoSuchCellInRow => "baked-cells/no-such-cell-in-row",
        TooManyCells => "baked-cells/too-many-cells",
        TooManyRuns => "baked-cells/too-many-runs",
        BadRuns => "baked-cells/bad-runs",
    }
    #[cfg(feature = "terrain")]
    HeightFieldError {
        Size => "height-field/size",
        Cell => "height-field/cell",
        Line => "height-field/line",
        Count => "height-field/count",
        Bytes => "height-field/bytes",
        Faces => "height-field/faces",
        Hole => "height-field/hole",
        TooFar => "height-field/too-far",
        AttributeStride => "height-field/attribute-stride",
        AttributeCount => "height-field/attribute-count",
        AttributeNotFinite => "height-field/attribute-not-finite",
    }
    SceneError {
        NoSuchSector => "scene/no-such-sector",
        NoSuchOpening => "scene/no-such-opening",
        NoSuchExit => "scene/no-such-exit",
        NoOpening => "scene/no-opening",
        RemovedSector => "scene/removed-sector",
        RemovedPortal => "scene/removed-portal",
        DoorFacesOneWay => "scene/door-faces-one-way",
        CustomSector => "scene/custom-sector",
        Openings => "scene/openings",
        BadLight => "scene/bad-light",
        TwoExits => "scene/two-exits",
        TwoPortals => "scene/two-portals",
        NotSimilar => "scene/not-similar",
        TooFar => "scene/too-far",
        BadBounds => "scene/bad-bounds",
        Unsuited => "scene/unsuited",
    }
    EditError {
        NoSuchSector => "edit/no-such-sector",
        RemovedSector => "edit/removed-sector",
        CustomSector => "edit/custom-sector",
        NoSuchItem => "edit/no-such-item",
        NotFinite => "edit/not-finite",
        TooFar => "edit/too-far",
        NoFaces => "edit/no-faces",
        NoSuchMaterial => "edit/no-such-material",
        TooManyFaces => "edit/too-many-faces",
        NoSuchOpening => "edit/no-such-opening",
        TooManyOpenings => "edit/too-many-openings",
    }
    Unsuited {
        TooLarge => "unsuited/too-large",
        NotBaked => "unsuited/not-baked",
        NotConvex => "unsuited/not-convex",
        NoTerrain => "unsuited/no-terrain",
        TerrainEdited => "unsuited/terrain-edited",
    }
    SkipReason {
        Unsuited => "skip/unsuited",
        Contract => "skip/contract",
        BuildsTooLong => "skip/builds-too-long",
        Moves => "skip/moves",
        NotSeen => "skip/not-seen",
    }
    ViewError {
        NotFinite => "view/not-finite",
        TooFar => "view/too-far",
        NoDirection => "view/no-direction",
        Size => "view/size",
        FieldOfView => "view/field-of-view",
        Sample => "view/sample",
        Near => "view/near",
        Height => "view/height",
        Origin => "view/origin",
        Orientation => "view/orientation",
        Tangents => "view/tangents",
        NotAffine => "view/not-affine",
        Transposed => "view/transposed",
        Singular => "view/singular",
        Parallel => "view/parallel",
        Oblique => "view/oblique",
        ClipDepth => "view/clip-depth",
    }
    SimdLevelError {
        Unknown => "simd-level/unknown",
        NotHere => "simd-level/not-here",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_is_an_area_and_a_rule_in_kebab_case_and_unique() {
        let is_kebab = |part: &str| {
            let words = || part.split('-');
            words().all(|word| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase()))
        };
        for code in ERROR_CODES {
            let (area, rule) = code.split_once('/').unwrap_or_default();
            assert!(is_kebab(area) && is_kebab(rule), "{code}");
        }
        let mut sorted = ERROR_CODES.to_vec();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), ERROR_CODES.len());
        assert!(ERROR_CODES.contains(&ViewError::NoDirection.code()));
    }
}
