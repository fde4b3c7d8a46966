//! What a reader leaves out, said in few words.

use crate::AuthoringError;
use std::collections::BTreeMap;
use std::fmt;

/// Something that a file has and that was not read, or that is odd. Its text is one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// What it is.
    pub kind: WarningKind,
    /// How many of them there are; 0 for what cannot be counted.
    pub count: usize,
    /// The first few of them by name, where names help to find them.
    pub first: Vec<String>,
}

/// What a warning is about, worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum WarningKind {
    /// Nothing can be seen.
    EmptyScene,
    /// The file has more scenes than the one that was read.
    OtherScenes,
    /// A portal or mirror that makes no sense and is left out, since
    /// [`ReadOptions::skip_bad_portals`](crate::ReadOptions::skip_bad_portals) says so: each has a warning of its own, up to 20.
    SkippedPortal,
    /// More of them.
    MoreSkippedPortals,
    /// Errors in what an author marked that do not matter where the file is read as [flat](crate::ReadOptions::flat).
    IgnoredMarks,
    /// Nodes with meshes that stand in no room, in a file that has rooms, and that no portal leads to.
    InNoRoom,
    /// Rooms without a face.
    EmptyRooms,
    /// Nodes called like portals or mirrors in a file without rooms.
    OpeningsWithoutRooms,
    /// Nodes with something in `extras.enfilade` that is not read.
    UnreadNotes,
    /// Extensions that the file uses.
    Extensions,
    /// Primitives that are points.
    Points,
    /// Primitives that are lines.
    Lines,
    /// Objects of an OBJ file that are called like rooms, portals or mirrors.
    NoRoomsInObj,
    /// Lines of an OBJ file that are not read, by what they begin with.
    UnreadStatements,
    /// Files of materials that cannot be had.
    MaterialFiles,
    /// Materials that no file defines.
    UnknownMaterials,
    /// Lines of files of materials that are not read.
    MaterialLines,
    /// Polygons that cross themselves.
    RoughPolygons,
    /// Faces of a map that engines never draw, for no leaf lists them.
    UnmarkedFaces,
    /// Things of a map whose shape is in a file of the game.
    ModelFiles,
    /// Lights of a map that dazzle.
    Flares,
    /// Lightmaps that a map says are beyond its end, or larger than any compiler makes them.
    Lightmaps,
    /// Normals, texture coordinates and colors that are NaN or infinite.
    NotFinite,
    /// Primitives without positions.
    NoPositions,
    /// Triangle lists whose last corners make no triangle.
    CornersLeft,
    /// Nodes that make their mesh flat: a scale of zero, or a matrix that cannot be undone.
    Flattened,
    /// Nodes whose matrix shears, which glTF forbids.
    Sheared,
    /// Cameras whose angle, near distance or place makes no picture.
    BadCameras,
    /// Lights whose color, range, cone or place makes no light.
    BadLights,
    /// Portals and mirrors that are to be there many times.
    InstancedOpenings,
    /// Meshes that change their shape.
    MorphTargets,
    /// Nodes whose mesh follows a skeleton.
    Skins,
    /// Movements.
    Animations,
    /// Images that cannot be had.
    BadImages,
    /// Faces with a texture, but without places in it.
    NoTextureCoordinates,
    /// Primitives with normals that are NaN or infinite.
    BadNormals,
    /// Primitives with texture coordinates that are NaN or infinite.
    BadTextureCoordinates,
    /// Primitives with colors that are NaN or infinite.
    BadColors,
    /// Materials whose texture of the light they send out lies otherwise than that of their color.
    EmissionElsewhere,
    /// Maps of materials for what is not drawn.
    OtherMaps,
}

impl WarningKind {
    fn text(self) -> &'static str {
        match self {
            WarningKind::EmptyScene => "the scene is empty: it has no triangle",
            WarningKind::OtherScenes => "only the default scene is read, others are not",
            WarningKind::SkippedPortal => "a portal is skipped and becomes a plain hole",
            WarningKind::MoreSkippedPortals => "more portals are skipped and become plain holes",
            WarningKind::IgnoredMarks => {
                "errors in marked rooms and portals are ignored, since everything is read as one room"
            }
            WarningKind::InNoRoom => {
                "nodes outside every room and not reachable through a portal; visible only from inside that space"
            }
            WarningKind::EmptyRooms => "rooms have nothing in them",
            WarningKind::OpeningsWithoutRooms => {
                "nodes are named like portals or mirrors, but no node is a room (NAME-room): drawn as ordinary meshes"
            }
            WarningKind::UnreadNotes => "extras.enfilade has unknown keys, which are ignored",
            WarningKind::Extensions => "unknown extensions are ignored",
            WarningKind::Points => "points are not drawn",
            WarningKind::Lines => "lines are not drawn",
            WarningKind::NoRoomsInObj => {
                "objects are named like rooms, portals or mirrors, but OBJ has no hierarchy to mark rooms: everything is one room"
            }
            WarningKind::UnreadStatements => "unknown statements are ignored",
            WarningKind::MaterialFiles => "material files cannot be read",
            WarningKind::UnknownMaterials => "undefined materials are grey",
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
            WarningKind::MorphTargets => "morph targets are not read yet: shapes are those before any morph",
            WarningKind::Skins => "skins are not read yet: meshes are in their rest pose",
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

/// Names in a warning, at most.
const FEW: usize = 6;

/// Portals that are skipped with a warning of their own, at most.
const MAX_SKIPPED: usize = 20;

/// Gathers warnings, one of each kind but for skipped portals.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    of_kind: BTreeMap<WarningKind, Warning>,
    skipped: Vec<Warning>,
}

impl Warnings {
    /// Notes `count` things that need no names; notes nothing where there are none.
    pub(crate) fn count(&mut self, kind: WarningKind, count: usize) {
        if count > 0 {
            self.of(kind).count += count;
        }
    }

    /// Notes one thing, which is named while there are few.
    pub(crate) fn name(&mut self, kind: WarningKind, name: impl FnOnce() -> String) {
        let warning = self.of(kind);
        warning.count += 1;
        if warning.first.len() < FEW {
            warning.first.push(name());
        }
    }

    /// Notes what is so or not.
    pub(crate) fn state(&mut self, kind: WarningKind, is_so: bool) {
        if is_so {
            self.of(kind);
        }
    }

    /// Notes a portal that is left out, and why.
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

    /// Takes over the warnings of a later part of the file.
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
        warnings.count(WarningKind::Skins, 0);
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
