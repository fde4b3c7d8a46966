//! Warnings: what a reader leaves out or repairs.

use crate::AuthoringError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// Something in a file that was not read, or that looks wrong. Displays as one line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Warning {
    /// Category of the warning.
    pub kind: WarningKind,
    /// Number of occurrences; 0 if they cannot be counted.
    pub count: usize,
    /// Names of the first few occurrences, if names help to find them.
    pub first: Vec<String>,
}

/// Category of a warning, worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[non_exhaustive]
pub enum WarningKind {
    /// The scene has no triangles.
    EmptyScene,
    /// The file has more scenes than the one that was read ([`ReadOptions::scene`](crate::ReadOptions::scene)).
    OtherScenes,
    /// A portal or mirror is invalid and was skipped because of
    /// [`ReadOptions::skip_bad_portals`](crate::ReadOptions::skip_bad_portals). Each has a separate warning, up to 20.
    SkippedPortal,
    /// Skipped portals after the first 20.
    MoreSkippedPortals,
    /// Authoring errors that do not matter because the file is read as [flat](crate::ReadOptions::flat).
    IgnoredMarks,
    /// The file is so far from the origin that 32-bit floats would move its items, so coordinates are relative to a position
    /// in it, which is named in the axes of the file.
    FarOrigin,
    /// Nodes with meshes outside every room, in a file with rooms, that no portal leads to.
    InNoRoom,
    /// Rooms without faces.
    EmptyRooms,
    /// Nodes named like portals or mirrors in a file without rooms.
    OpeningsWithoutRooms,
    /// Nodes with unknown keys in `extras.enfilade`.
    UnreadNotes,
    /// Extensions that the file uses, but that are not read.
    Extensions,
    /// Primitives whose compression or storage is not supported, in a file that is read as
    /// [lenient](crate::ReadOptions::lenient).
    LeftOut,
    /// Point primitives.
    Points,
    /// Line primitives.
    Lines,
    /// Objects of an OBJ file that are named like rooms, portals or mirrors.
    NoRoomsInObj,
    /// Unsupported statements of an OBJ file, by keyword.
    UnreadStatements,
    /// Material files that cannot be read.
    MaterialFiles,
    /// Materials that are used but not defined.
    UnknownMaterials,
    /// Unsupported statements of material files.
    MaterialLines,
    /// Self-intersecting polygons.
    RoughPolygons,
    /// Faces of a map that no leaf lists, so engines never draw them.
    UnmarkedFaces,
    /// Entities of a map whose model is in another game file.
    ModelFiles,
    /// Flares of a map.
    Flares,
    /// Lightmaps that exceed the lump, or are larger than any compiler makes them.
    Lightmaps,
    /// Normals, texture coordinates or colors of an OBJ file that are NaN or infinite.
    NotFinite,
    /// Primitives without positions.
    NoPositions,
    /// Triangle lists with a number of indices that is not a multiple of 3.
    CornersLeft,
    /// Nodes whose transform is singular: a scale of zero, or a matrix that cannot be inverted.
    Flattened,
    /// Nodes whose matrix shears, which glTF forbids.
    Sheared,
    /// Cameras with an invalid angle, near plane or transform.
    BadCameras,
    /// Lights with an invalid color, range, cone or transform.
    BadLights,
    /// Portals and mirrors with instances.
    InstancedOpenings,
    /// Meshes with morph targets, in a scene that an earlier version baked.
    MorphTargets,
    /// Nodes with a skin, in a scene that an earlier version baked.
    Skins,
    /// Skinned meshes with instances.
    InstancedSkins,
    /// Morph weights that are not as many as the targets.
    MorphWeights,
    /// Vertices of skinned meshes without valid joint weights.
    JointWeights,
    /// Animations.
    Animations,
    /// Portals and mirrors that animations move.
    AnimatedOpenings,
    /// What breaks a rule of the format, but has a plain meaning.
    Repaired,
    /// Images that cannot be read.
    BadImages,
    /// Textured faces without texture coordinates.
    NoTextureCoordinates,
    /// Primitives with normals that are NaN or infinite.
    BadNormals,
    /// Primitives with texture coordinates that are NaN or infinite.
    BadTextureCoordinates,
    /// Primitives with colors that are NaN or infinite.
    BadColors,
    /// Materials whose emissive texture uses other coordinates than the color texture.
    EmissionElsewhere,
    /// Textures that are not drawn: metallic-roughness, normal, occlusion and transmission.
    OtherMaps,
}

impl WarningKind {
    fn text(self) -> &'static str {
        match self {
            WarningKind::EmptyScene => "the scene is empty: it has no triangle",
            WarningKind::OtherScenes => "only one scene is read, others are not",
            WarningKind::SkippedPortal => "a portal is skipped and becomes a plain hole",
            WarningKind::MoreSkippedPortals => "more portals are skipped and become plain holes",
            WarningKind::IgnoredMarks => {
                "errors in marked rooms and portals are ignored, since everything is read as one room"
            }
            WarningKind::FarOrigin => {
                "too far from the origin for 32-bit floats: coordinates are relative to this position in the axes of the file"
            }
            WarningKind::InNoRoom => {
                "nodes outside every room and not reachable through a portal; visible only from inside that space"
            }
            WarningKind::EmptyRooms => "rooms have nothing in them",
            WarningKind::OpeningsWithoutRooms => {
                "nodes are named like portals or mirrors, but no node is a room (NAME-room): drawn as ordinary meshes"
            }
            WarningKind::UnreadNotes => "extras.enfilade has unknown keys, which are ignored",
            WarningKind::Extensions => "extensions are not read",
            WarningKind::Repaired => "what breaks a rule of the format, but has a plain meaning, is read",
            WarningKind::LeftOut => "primitives whose compression or storage is not supported are left out",
            WarningKind::Points => "points are not drawn",
            WarningKind::Lines => "lines are not drawn",
            WarningKind::NoRoomsInObj => {
                "objects are named like rooms, portals or mirrors, but OBJ has no hierarchy to mark rooms: everything is one room"
            }
            WarningKind::UnreadStatements => "unknown statements are ignored",
            WarningKind::MaterialFiles => "material files cannot be read",
            WarningKind::UnknownMaterials => "undefined materials are grey, and hide nothing",
            WarningKind::MaterialLines => "unknown statements in material files are ignored",
            WarningKind::RoughPolygons => "self-intersecting polygons are triangulated approximately",
            WarningKind::UnmarkedFaces => "faces that no leaf of the map lists are not drawn",
            WarningKind::ModelFiles => "models in other files of the game are not drawn",
            WarningKind::Flares => "flares are not drawn",
            WarningKind::Lightmaps => {
                "lightmaps that are not in the file, or too large, are ignored: lamps light those faces"
            }
            WarningKind::NotFinite => {
                "normals, texture coordinates or colors that are not finite are ignored"
            }
            WarningKind::NoPositions => "primitives without positions are not drawn",
            WarningKind::CornersLeft => {
                "triangle lists with a corner count that is not a multiple of 3: the last corners are ignored"
            }
            WarningKind::Flattened => "node transforms flatten their mesh, which may be invisible",
            WarningKind::Sheared => "node matrices shear, which glTF forbids; they are taken as they are",
            WarningKind::BadCameras => "cameras with an invalid angle, near plane or transform are ignored",
            WarningKind::BadLights => "lights with an invalid color, range, cone or transform are ignored",
            WarningKind::InstancedOpenings => {
                "instances of portals and mirrors are ignored: each is placed once, at its node"
            }
            WarningKind::MorphTargets => {
                "morph targets were not read when the scene was baked: shapes are those before any morph; bake it again"
            }
            WarningKind::Skins => {
                "skins were not read when the scene was baked: meshes have no pose; bake it again"
            }
            WarningKind::InstancedSkins => {
                "instances of skinned meshes are ignored: each mesh is drawn once, where its joints are"
            }
            WarningKind::MorphWeights => {
                "weights that are not as many as the morph targets of a mesh: missing ones are 0, others are ignored"
            }
            WarningKind::JointWeights => {
                "vertices of skinned meshes without valid joint weights follow their first joint; meshes without joints follow their node"
            }
            WarningKind::AnimatedOpenings => {
                "portals and mirrors that animations move stay where the file has them: replace their openings as they move"
            }
            WarningKind::Animations => "animations are not read yet: everything stands still",
            WarningKind::BadImages => "images that cannot be read are grey",
            WarningKind::NoTextureCoordinates => {
                "textured faces without texture coordinates have the color of the texture's corner"
            }
            WarningKind::BadNormals => "normals that are not finite are ignored: flat shading",
            WarningKind::BadTextureCoordinates => "texture coordinates that are not finite are 0",
            WarningKind::BadColors => "colors that are not finite are white",
            WarningKind::EmissionElsewhere => {
                "emissive textures with other coordinates than the color texture are ignored: the material emits nothing"
            }
            WarningKind::OtherMaps => {
                "metallic-roughness, normal, occlusion and transmission textures are not drawn"
            }
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.kind.text())?;
        match (self.count, self.first.len()) {
            (0, _) => Ok(()),
            (count, 0) => write!(f, " ({count})"),
            (count, named) if count == named => write!(f, " ({})", self.first.join(", ")),
            (count, named) => write!(f, " ({} and {} more)", self.first.join(", "), count - named),
        }
    }
}

/// Maximum number of names in a warning.
const FEW: usize = 6;

/// Maximum number of skipped portals with a separate warning.
const MAX_SKIPPED: usize = 20;

/// Collects warnings: one per kind, except for skipped portals.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    of_kind: BTreeMap<WarningKind, Warning>,
    skipped: Vec<Warning>,
}

impl Warnings {
    /// Adds `count` occurrences without names; adds no warning if `count` is 0.
    pub(crate) fn count(&mut self, kind: WarningKind, count: usize) {
        if count > 0 {
            self.of(kind).count += count;
        }
    }

    /// Adds one occurrence, with its name while there are few.
    pub(crate) fn name(&mut self, kind: WarningKind, name: impl FnOnce() -> String) {
        let warning = self.of(kind);
        warning.count += 1;
        if warning.first.len() < FEW {
            warning.first.push(name());
        }
    }

    /// Adds a warning without a count if `is_so`.
    pub(crate) fn state(&mut self, kind: WarningKind, is_so: bool) {
        if is_so {
            self.of(kind);
        }
    }

    /// Adds a warning for a skipped portal, with the reason.
    pub(crate) fn skipped_portal(&mut self, why: &AuthoringError) {
        if self.skipped.len() == MAX_SKIPPED {
            return self.count(WarningKind::MoreSkippedPortals, 1);
        }
        self.skipped.push(Warning {
            kind: WarningKind::SkippedPortal,
            count: 1,
            first: vec![why.to_string()],
        });
    }

    /// Merges the warnings of a later part of the file.
    pub(crate) fn absorb(&mut self, later: Warnings) {
        self.skipped.extend(later.skipped);
        for (kind, more) in later.of_kind {
            let warning = self.of(kind);
            warning.count += more.count;
            let room = FEW.saturating_sub(warning.first.len());
            warning.first.extend(more.first.into_iter().take(room));
        }
    }

    pub(crate) fn into_list(self) -> Vec<Warning> {
        let mut list: Vec<Warning> = self.skipped;
        list.extend(self.of_kind.into_values());
        list.sort_by_key(|warning| warning.kind);
        list
    }

    fn of(&mut self, kind: WarningKind) -> &mut Warning {
        self.of_kind.entry(kind).or_insert(Warning {
            kind,
            count: 0,
            first: Vec::new(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_names_few_and_counts_all() {
        let mut warnings = Warnings::default();
        warnings.count(WarningKind::OtherMaps, 21);
        warnings.count(WarningKind::Animations, 0);
        (0..9).for_each(|n| warnings.name(WarningKind::Points, || format!("p{n}")));
        warnings.state(WarningKind::EmptyScene, true);
        let texts: Vec<String> = warnings.into_list().iter().map(Warning::to_string).collect();
        assert_eq!(texts[0], "the scene is empty: it has no triangle");
        assert_eq!(
            texts[1],
            "points are not drawn (p0, p1, p2, p3, p4, p5 and 3 more)"
        );
        assert_eq!(
            texts[2],
            "metallic-roughness, normal, occlusion and transmission textures are not drawn (21)"
        );
    }

    #[test]
    fn warnings_of_parts_of_a_file_become_one() {
        let part = |first: usize| {
            let mut warnings = Warnings::default();
            (first..first + 4).for_each(|n| warnings.name(WarningKind::Lines, || format!("line {n}")));
            warnings.count(WarningKind::NotFinite, 2);
            warnings
        };
        let mut warnings = part(1);
        warnings.absorb(part(11));
        warnings.absorb(part(21));
        let texts: Vec<String> = warnings.into_list().iter().map(Warning::to_string).collect();
        assert_eq!(
            texts,
            [
                "lines are not drawn (line 1, line 2, line 3, line 4, line 11, line 12 and 6 more)",
                "normals, texture coordinates or colors that are not finite are ignored (6)"
            ]
        );
    }
}
