//! Why items and materials are no occluders.

use enfilade::{Alpha, Geometry, ItemIndex, MaterialId};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::Arc;

/// Why a surface or an item hides nothing: what is not sure of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum NonOccluder {
    /// Its author says so: `extras.enfilade.occluder` of a node, or the [options](enfilade::ItemOptions) of an item.
    Author,
    /// A skin deforms it, or it is below a joint of one.
    Skinned,
    /// Morph targets deform it.
    Morphed,
    /// An animation moves it, shows it or changes its material.
    Animated,
    /// A renderer may draw a coarser level of detail instead.
    LevelOfDetail,
    /// The material of one of its variants is not opaque.
    MaterialVariant,
    /// Alpha test: it may have holes.
    AlphaTested,
    /// Alpha blend.
    Blended,
    /// Light passes through it: transmission, volume, filter colors, illumination models of glass.
    Transmissive,
    /// Its material is missing, or what it says about opacity cannot be read.
    MaterialUnread,
    /// An extension that is not read may change its shape, or whether it is drawn.
    ExtensionUnread,
    /// Water, slime, lava or a teleporter, which engines draw as translucent as the player likes.
    Liquid,
    /// A color of its texture is transparent: names that begin with `{`.
    AlphaKey,
    /// The map, or a shader script, says that it is translucent.
    Translucent,
    /// The map, or a shader script, says that it is not solid or not drawn: decals, effects, curtains.
    NotSolid,
    /// A shader script draws it from behind as well, as fences and foliage are: `cull none` or `cull back`.
    DoubleSidedShader,
    /// Sky, where engines may draw what is behind it.
    Sky,
    /// A brush entity that may move, vanish or be left out: doors, lifts, breakable walls, brushes of other skill levels.
    MovingBrush,
    /// A brush entity with `alpha`, `renderamt`, `rendermode` or `renderfx`.
    TranslucentBrush,
}

impl NonOccluder {
    /// All reasons, in declaration order.
    pub const ALL: [NonOccluder; 19] = [
        NonOccluder::Author,
        NonOccluder::Skinned,
        NonOccluder::Morphed,
        NonOccluder::Animated,
        NonOccluder::LevelOfDetail,
        NonOccluder::MaterialVariant,
        NonOccluder::AlphaTested,
        NonOccluder::Blended,
        NonOccluder::Transmissive,
        NonOccluder::MaterialUnread,
        NonOccluder::ExtensionUnread,
        NonOccluder::Liquid,
        NonOccluder::AlphaKey,
        NonOccluder::Translucent,
        NonOccluder::NotSolid,
        NonOccluder::DoubleSidedShader,
        NonOccluder::Sky,
        NonOccluder::MovingBrush,
        NonOccluder::TranslucentBrush,
    ];

    /// Returns the name, as in JSON: `alpha-tested`.
    pub fn name(self) -> &'static str {
        match self {
            NonOccluder::Author => "author",
            NonOccluder::Skinned => "skinned",
            NonOccluder::Morphed => "morphed",
            NonOccluder::Animated => "animated",
            NonOccluder::LevelOfDetail => "level-of-detail",
            NonOccluder::MaterialVariant => "material-variant",
            NonOccluder::AlphaTested => "alpha-tested",
            NonOccluder::Blended => "blended",
            NonOccluder::Transmissive => "transmissive",
            NonOccluder::MaterialUnread => "material-unread",
            NonOccluder::ExtensionUnread => "extension-unread",
            NonOccluder::Liquid => "liquid",
            NonOccluder::AlphaKey => "alpha-key",
            NonOccluder::Translucent => "translucent",
            NonOccluder::NotSolid => "not-solid",
            NonOccluder::DoubleSidedShader => "double-sided-shader",
            NonOccluder::Sky => "sky",
            NonOccluder::MovingBrush => "moving-brush",
            NonOccluder::TranslucentBrush => "translucent-brush",
        }
    }

    /// Returns `true` if an author can know better: where the item is, and in which shape.
    pub(crate) fn is_of_pose(self) -> bool {
        matches!(
            self,
            NonOccluder::Skinned | NonOccluder::Morphed | NonOccluder::Animated
        )
    }

    /// Returns the reason of a material of which only the alpha mode is known; `None` if it is opaque.
    fn of_alpha(alpha: Alpha) -> Option<NonOccluder> {
        match alpha {
            Alpha::Opaque => None,
            Alpha::Mask => Some(NonOccluder::AlphaTested),
            Alpha::Blend => Some(NonOccluder::Blended),
        }
    }
}

impl fmt::Display for NonOccluder {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Why items and materials of a room hide nothing, as far as their [options](enfilade::ItemOptions) and alpha modes do not tell.
///
/// Takes 5 bytes per item that is no occluder, and a byte per material of a file that has any.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NonOccluders {
    items: BTreeMap<ItemIndex, NonOccluder>,
    /// By material; what follows has no other reason than its alpha mode. Rooms of a file share it.
    materials: Arc<[Option<NonOccluder>]>,
}

impl NonOccluders {
    pub(crate) fn of_materials(materials: Arc<[Option<NonOccluder>]>) -> NonOccluders {
        NonOccluders {
            items: BTreeMap::new(),
            materials,
        }
    }

    /// Returns the reasons of the materials alone.
    pub(crate) fn without_items(&self) -> NonOccluders {
        NonOccluders::of_materials(Arc::clone(&self.materials))
    }

    /// Records why an item is no occluder.
    pub(crate) fn add(&mut self, item: ItemIndex, why: NonOccluder) {
        self.items.insert(item, why);
    }

    /// Returns the recorded items.
    pub(crate) fn items(&self) -> &BTreeMap<ItemIndex, NonOccluder> {
        &self.items
    }

    /// Returns the recorded reason of a material.
    pub(crate) fn recorded(&self, material: MaterialId) -> Option<NonOccluder> {
        self.materials.get(material.0 as usize).copied().flatten()
    }

    /// Returns why faces of a material hide nothing; `None` if they hide what is behind them, unless their item does not.
    ///
    /// # Panics
    /// If the geometry, which must be that of the room, has no such material.
    pub fn of_material(&self, geometry: &Geometry, material: MaterialId) -> Option<NonOccluder> {
        let by_alpha = NonOccluder::of_alpha(geometry.materials()[material.0 as usize].alpha)?;
        Some(self.recorded(material).unwrap_or(by_alpha))
    }

    /// Returns why an item, or some of its faces, hide nothing; empty if all hide what is behind them.
    ///
    /// One reason for a whole item; otherwise those of its materials, while faces of other materials hide.
    ///
    /// # Panics
    /// If the geometry, which must be that of the room, has no such item.
    pub fn of_item(&self, geometry: &Geometry, item: ItemIndex) -> BTreeSet<NonOccluder> {
        self.of_whole_item(geometry, item).map_or_else(
            || {
                let clusters = geometry.mesh_of(item).clusters().iter();
                clusters
                    .filter(|cluster| !cluster.faces.is_empty())
                    .filter_map(|cluster| self.of_material(geometry, cluster.material))
                    .collect()
            },
            |why| BTreeSet::from([why]),
        )
    }

    /// Returns why no face of an item hides anything, whatever its material; `None` if that is up to its materials.
    ///
    /// # Panics
    /// If the geometry, which must be that of the room, has no such item.
    pub fn of_whole_item(&self, geometry: &Geometry, item: ItemIndex) -> Option<NonOccluder> {
        let is_occluder = geometry.item(item).options.is_occluder;
        let recorded = self.items.get(&item).copied();
        (!is_occluder).then(|| recorded.unwrap_or(NonOccluder::Author))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_that_are_stored() {
        for reason in NonOccluder::ALL {
            let stored = serde_json::to_string(&reason).expect("it can be stored");
            assert_eq!(stored, format!("\"{}\"", reason.name()));
        }
        assert!(NonOccluder::ALL.is_sorted());
    }
}
