//! The list of all built-in scenes.

use crate::{laws, palace, thesis};
use enfilade::{Camera, Scene};

/// A scene with its cameras; the first camera is the default.
#[derive(Clone)]
pub struct BuiltIn {
    /// The scene. Each sector uses the method that the scene's author chose.
    pub scene: Scene,
    /// At least one camera; names are unique.
    pub cameras: Vec<Camera>,
}

/// An entry of [`SCENES`]: builds a scene by name.
#[derive(Clone, Copy, Debug)]
pub struct CatalogEntry {
    /// Name of the scene, as typed after `@` on the command line.
    pub name: &'static str,
    /// One-line description.
    pub about: &'static str,
    /// Features that not every method supports.
    pub groups: &'static [Group],
    build: fn() -> BuiltIn,
}

/// A feature of a scene. Conformance tests exclude methods by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Group {
    /// Openings into other sectors.
    Doors,
    /// Mirrors.
    Mirrors,
    /// One-way portals whose destination has no opening back.
    Teleports,
    /// Nested scenes.
    Nested,
    /// Cyclically overlapping faces, which no painting order draws correctly.
    Cycles,
    /// Intersecting faces.
    Intersections,
    /// Coplanar faces of different items.
    Coplanar,
    /// Alpha-blended or alpha-tested faces.
    Glass,
    /// One-sided faces seen from behind.
    OneSided,
    /// Faces or items with no or nearly no area.
    Slivers,
    /// Coordinates much larger or smaller than a metre.
    Extreme,
    /// Cameras within a millimetre of a face or an opening, or inside an item.
    Close,
    /// Thousands of items, or meshes of thousands of faces.
    Large,
    /// Baked cells (PVS): the sector's walls must not be moved.
    Baked,
}

impl CatalogEntry {
    /// Builds the scene.
    pub fn build(&self) -> BuiltIn {
        (self.build)()
    }

    /// Returns `true` if the scene has a feature.
    pub fn is(&self, group: Group) -> bool {
        self.groups.contains(&group)
    }
}

/// All scenes: the palace (the default), the scenes of the conformance suite, and the figures of the thesis.
pub const SCENES: [CatalogEntry; 42] = [
    CatalogEntry {
        name: "enfilade",
        about: "a palace: twelve rooms in line, a gallery, a court, cabinets, a garden, a doll's house, a fountain",
        groups: &[
            Group::Doors,
            Group::Mirrors,
            Group::Teleports,
            Group::Nested,
            Group::Glass,
            Group::Intersections,
            Group::Large,
        ],
        build: palace::palace,
    },
    law(
        "two-rooms",
        "a door, and items in line with it",
        &[Group::Doors],
        laws::two_rooms,
    ),
    law(
        "pillar",
        "a pillar before a door",
        &[Group::Doors, Group::Intersections],
        laws::pillar,
    ),
    law(
        "mirror",
        "a mirror, and something behind its glass",
        &[Group::Mirrors, Group::OneSided],
        laws::mirror,
    ),
    law(
        "mirrors",
        "two mirrors face to face",
        &[Group::Mirrors],
        laws::mirrors,
    ),
    law(
        "teleport",
        "portals that rotate and scale, some of them one-way",
        &[Group::Doors, Group::Teleports],
        laws::teleport,
    ),
    law(
        "nested",
        "a scene in a scene in a scene, and a second way out",
        &[Group::Nested],
        laws::nested,
    ),
    law(
        "impossible",
        "a hut larger inside than outside, a corridor that joins itself, five rooms around a pillar of four",
        &[Group::Doors, Group::Teleports],
        laws::impossible,
    ),
    law(
        "free-doorway",
        "a free-standing one-way doorway",
        &[Group::Doors],
        laws::free_doorway,
    ),
    law(
        "crossing",
        "intersecting sheets, boxes that overlap cyclically",
        &[Group::Cycles, Group::Intersections],
        laws::crossing,
    ),
    law(
        "coplanar",
        "pictures pasted on a wall, a flat box on the floor",
        &[Group::Coplanar],
        laws::coplanar,
    ),
    law(
        "glass",
        "panes and leaves before and behind other items",
        &[Group::Glass, Group::Doors, Group::Intersections],
        laws::glass,
    ),
    law(
        "bottles",
        "stacked glass layers: crossing, nested, through a statue, in a mirror",
        &[Group::Glass, Group::Doors, Group::Mirrors, Group::Intersections],
        laws::bottles,
    ),
    law(
        "one-sided",
        "faces seen from behind, mirrored and inside out",
        &[Group::OneSided],
        laws::one_sided,
    ),
    law(
        "slits",
        "a slit, needle holes, a door ajar",
        &[Group::Doors, Group::Slivers],
        laws::slits,
    ),
    law(
        "huge",
        "rooms the size of countries, far from the origin",
        &[Group::Doors, Group::Extreme],
        laws::huge,
    ),
    law(
        "far-away",
        "rooms a million units from the origin",
        &[Group::Doors, Group::Extreme],
        laws::far_away,
    ),
    law(
        "tiny",
        "rooms half a millimetre wide",
        &[Group::Doors, Group::Extreme],
        laws::tiny,
    ),
    law(
        "degenerate",
        "faces without area, slivers, items scaled flat",
        &[Group::Slivers, Group::Coplanar, Group::Intersections],
        laws::degenerate,
    ),
    law(
        "crowd",
        "three thousand items behind walls, pebbles the size of a pixel",
        &[Group::Large, Group::Intersections],
        laws::crowd,
    ),
    law(
        "polygons",
        "faces with four to eleven corners",
        &[Group::Intersections],
        laws::polygons,
    ),
    law(
        "wings",
        "two faces that share an edge, and a beam before one and behind the other",
        &[],
        laws::wings,
    ),
    law(
        "seams",
        "boards through a floor along its seams",
        &[Group::Intersections],
        laws::seams,
    ),
    law(
        "eye-in-things",
        "cameras in doorways, in boxes, on walls",
        &[Group::Doors, Group::Close],
        laws::eye_in_things,
    ),
    law(
        "big-mesh",
        "hills made of one mesh",
        &[Group::Large, Group::Intersections],
        laws::big_mesh,
    ),
    law(
        "random",
        "a few random items",
        &[Group::Doors, Group::Glass, Group::OneSided, Group::Intersections],
        || crate::random_scene(2),
    ),
    law(
        "house",
        "six rooms and an annex with baked PVS cells",
        &[
            Group::Baked,
            Group::Doors,
            Group::Mirrors,
            Group::Teleports,
            Group::Glass,
        ],
        laws::house,
    ),
    law(
        "tetrahedron",
        "four faces: wrong by minimal z, right by mean z",
        &[],
        thesis::tetrahedron,
    ),
    law(
        "parallel-triangles",
        "three triangles, one before the other: both painters' sorts are right",
        &[],
        thesis::parallel_triangles,
    ),
    law(
        "parallel-rectangles",
        "three rectangles, one before the other: every method is right",
        &[],
        thesis::parallel_rectangles,
    ),
    law(
        "crossing-triangles",
        "two intersecting triangles: no painting order is right",
        &[Group::Intersections],
        thesis::crossing_triangles,
    ),
    law(
        "cycle",
        "three bars that overlap cyclically: no painting order is right",
        &[Group::Cycles],
        thesis::cycle,
    ),
    law(
        "overlap",
        "a sail before a long wall: minimal z is wrong, and from one camera mean z too",
        &[],
        thesis::overlap,
    ),
    law(
        "triangle-through-cube",
        "a triangle through a cube: painters' sorts are wrong, BSP trees must split",
        &[Group::Intersections],
        thesis::triangle_through_cube,
    ),
    law(
        "wrong-winding",
        "the tetrahedron with inconsistent winding: wrong for BSP trees that rely on it",
        &[],
        thesis::wrong_winding,
    ),
    law(
        "cylinders-8",
        "8 rectangles, a lid and a bottom: both painters' sorts are right",
        &[],
        || thesis::cylinder(8),
    ),
    law(
        "cylinders-16",
        "16 rectangles, a lid and a bottom: both painters' sorts are right",
        &[],
        || thesis::cylinder(16),
    ),
    law(
        "cylinders-32",
        "32 rectangles, a lid and a bottom: both painters' sorts are right",
        &[],
        || thesis::cylinder(32),
    ),
    law(
        "cones-8",
        "8 triangles and a base: both painters' sorts are right where the base is visible",
        &[],
        || thesis::cone(8),
    ),
    law(
        "cones-16",
        "16 triangles and a base: both painters' sorts are right where the base is visible",
        &[],
        || thesis::cone(16),
    ),
    law(
        "cones-32",
        "32 triangles and a base: both painters' sorts are right where the base is visible",
        &[],
        || thesis::cone(32),
    ),
    law(
        "four-cylinders",
        "four tubes of sixty rectangles, for timing painters' sorts and BSP trees",
        &[],
        thesis::four_cylinders,
    ),
];

/// Names of all scenes, in the order of [`SCENES`].
pub const NAMES: [&str; SCENES.len()] = {
    let mut names = [""; SCENES.len()];
    let mut index = 0;
    while index < names.len() {
        names[index] = SCENES[index].name;
        index += 1;
    }
    names
};

const fn law(
    name: &'static str,
    about: &'static str,
    groups: &'static [Group],
    build: fn() -> BuiltIn,
) -> CatalogEntry {
    CatalogEntry {
        name,
        about,
        groups,
        build,
    }
}

/// Builds the scene with a name; returns `None` if there is none.
pub fn built_in(name: &str) -> Option<BuiltIn> {
    SCENES
        .iter()
        .find(|named| named.name == name)
        .map(CatalogEntry::build)
}

/// Returns the small scenes of the conformance suite: all but the palace.
pub fn law_scenes() -> impl Iterator<Item = &'static CatalogEntry> {
    const LAWS: &[CatalogEntry] = SCENES.split_at(1).1;
    LAWS.iter()
}

/// Returns the figures of the thesis, which compare painter's algorithms.
pub fn figures() -> impl Iterator<Item = &'static CatalogEntry> {
    SCENES.iter().skip_while(|named| named.name != "tetrahedron")
}
