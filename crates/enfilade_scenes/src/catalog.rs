//! The list of all scenes.

use crate::{Camera, laws, palace, thesis};
use enfilade::Scene;

/// A scene, and places to look at it from; the first is the default.
#[derive(Clone)]
pub struct BuiltIn {
    /// The scene. Every sector is seen by the method that its author chose.
    pub scene: Scene,
    /// At least one; names are unique.
    pub cameras: Vec<Camera>,
}

/// A scene by its name.
#[derive(Clone, Copy, Debug)]
pub struct Named {
    /// What one types after `@`.
    pub name: &'static str,
    /// What there is to see, in a line.
    pub about: &'static str,
    /// What it contains that not every method can handle.
    pub groups: &'static [Group],
    build: fn() -> BuiltIn,
}

/// What a scene contains: laws name their exceptions by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Group {
    /// Openings that lead into other sectors.
    Doors,
    /// Mirrors.
    Mirrors,
    /// Portals that lead to a place where no opening stands, so that there is no way back.
    Teleports,
    /// Scenes within the scene.
    Nested,
    /// Faces that overlap in a cycle, so that no order paints them.
    Cycles,
    /// Faces that go through each other.
    Intersections,
    /// Faces of different items in one plane.
    Coplanar,
    /// Glass or cut-outs.
    Glass,
    /// Faces seen from behind.
    OneSided,
    /// Faces or items without area, or nearly so.
    Slivers,
    /// Coordinates far above or below a metre.
    Extreme,
    /// Eyes within a millimetre of a face or an opening, or inside a thing.
    Close,
    /// Thousands of items, or meshes of thousands of faces.
    Large,
    /// Cells that were computed ahead: its walls are not to be moved.
    Baked,
}

impl Named {
    /// Builds the scene.
    pub fn build(&self) -> BuiltIn {
        (self.build)()
    }

    /// Does the scene contain this?
    pub fn is(&self, group: Group) -> bool {
        self.groups.contains(&group)
    }
}

/// All scenes: the default, those of the laws, and the figures of the thesis.
pub const SCENES: [Named; 42] = [
    Named {
        name: "enfilade",
        about: "a palace: twelve rooms in line, a gallery, a court, cabinets, a garden, a doll's house, a fountain that can move",
        groups: &[
            Group::Doors,
            Group::Mirrors,
            Group::Teleports,
            Group::Nested,
            Group::Glass,
            Group::Intersections,
            Group::Large,
        ],
        build: || palace::palace(palace::SEED),
    },
    law(
        "two-rooms",
        "a door, and what is in line with it",
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
        "openings that turn, shrink and enlarge what is seen, some with no way back",
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
        "a doorway that stands free and leads one way",
        &[Group::Doors],
        laws::free_doorway,
    ),
    law(
        "crossing",
        "sheets that cross, boxes that overlap in a cycle",
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
        "panes and leaves before and behind things",
        &[Group::Glass, Group::Doors, Group::Intersections],
        laws::glass,
    ),
    law(
        "bottles",
        "glass upon glass: crossing, nested, through a statue, in a mirror",
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
        "faces without area, slivers, things scaled flat",
        &[Group::Slivers, Group::Coplanar, Group::Intersections],
        laws::degenerate,
    ),
    law(
        "crowd",
        "three thousand things behind walls, pebbles of a pixel",
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
        "two faces with one edge, and a beam before one and behind the other",
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
        "eyes in doorways, in boxes, on walls",
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
        "a handful of things at random",
        &[Group::Doors, Group::Glass, Group::OneSided, Group::Intersections],
        || crate::random_scene(2),
    ),
    law(
        "house",
        "six rooms and an annex that know what can be seen from them",
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
        "four faces: minimal z paints the base over them, mean z does not",
        &[],
        thesis::tetrahedron,
    ),
    law(
        "parallel-triangles",
        "three triangles, one before the other: both painters are right",
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
        "two triangles through each other: no order paints them",
        &[Group::Intersections],
        thesis::crossing_triangles,
    ),
    law(
        "cycle",
        "three bars, each before the next: no order paints them",
        &[Group::Cycles],
        thesis::cycle,
    ),
    law(
        "overlap",
        "a sail before a long wall: minimal z is wrong, and mean z too once the eye has moved",
        &[],
        thesis::overlap,
    ),
    law(
        "triangle-through-cube",
        "a triangle through a cube: painters are wrong, trees must cut",
        &[Group::Intersections],
        thesis::triangle_through_cube,
    ),
    law(
        "wrong-winding",
        "the tetrahedron with corners in no order: wrong for trees that trust it",
        &[],
        thesis::wrong_winding,
    ),
    law(
        "cylinders-8",
        "8 rectangles, a lid and a bottom: both painters are right",
        &[],
        || thesis::cylinder(8),
    ),
    law(
        "cylinders-16",
        "16 rectangles, a lid and a bottom: both painters are right",
        &[],
        || thesis::cylinder(16),
    ),
    law(
        "cylinders-32",
        "32 rectangles, a lid and a bottom: both painters are right",
        &[],
        || thesis::cylinder(32),
    ),
    law(
        "cones-8",
        "8 triangles and a base: both painters are right where the base is seen",
        &[],
        || thesis::cone(8),
    ),
    law(
        "cones-16",
        "16 triangles and a base: both painters are right where the base is seen",
        &[],
        || thesis::cone(16),
    ),
    law(
        "cones-32",
        "32 triangles and a base: both painters are right where the base is seen",
        &[],
        || thesis::cone(32),
    ),
    law(
        "four-cylinders",
        "four tubes of sixty rectangles: what painters and trees are timed on",
        &[],
        thesis::four_cylinders,
    ),
];

/// The names of all scenes, as in [`SCENES`].
pub const NAMES: [&str; SCENES.len()] = {
    let mut names = [""; SCENES.len()];
    let mut place = 0;
    while place < names.len() {
        names[place] = SCENES[place].name;
        place += 1;
    }
    names
};

const fn law(
    name: &'static str,
    about: &'static str,
    groups: &'static [Group],
    build: fn() -> BuiltIn,
) -> Named {
    Named {
        name,
        about,
        groups,
        build,
    }
}

/// Builds the scene that is called `name`; `None` if none is.
pub fn built_in(name: &str) -> Option<BuiltIn> {
    SCENES.iter().find(|named| named.name == name).map(Named::build)
}

/// The small scenes that the laws run on: all but the palace.
pub fn law_scenes() -> impl Iterator<Item = &'static Named> {
    const LAWS: &[Named] = SCENES.split_at(1).1;
    LAWS.iter()
}

/// The figures of the thesis, on which the painters are compared: from the tetrahedron on.
pub fn figures() -> impl Iterator<Item = &'static Named> {
    SCENES.iter().skip_while(|named| named.name != "tetrahedron")
}
