//! How items take part in looks.

/// How an item takes part in looks: as an occluder, drawn or not, in which layers, and how far away.
///
/// Set with [`GeometryBuilder::set_options`](crate::GeometryBuilder::set_options) or
/// [`Edit::set_options`](crate::Edit::set_options).
///
/// An *occluder proxy*, a simpler mesh that hides in the place of an item, is an item of its own with the same transform:
/// set `is_occluder` to `false` for the item that is drawn, and `is_drawn` to `false` for the proxy. The proxy must lie
/// within the surface of what is drawn, or it hides what can be seen.
///
/// ```
/// # use enfilade::*;
/// # let mut builder = GeometryBuilder::new([Material::opaque([0.5; 3])]);
/// # let [statue, inside] = [0.5, 0.4].map(|r| builder.mesh(Mesh::cuboid([-r; 3], [r; 3], MaterialId(0)).unwrap()));
/// # let there = Transform::IDENTITY;
/// let drawn = builder.item("statue", statue, there);
/// builder.set_options(drawn, ItemOptions { is_occluder: false, ..ItemOptions::default() });
/// let proxy = builder.item("statue, proxy", inside, there);
/// builder.set_options(proxy, ItemOptions { is_drawn: false, ..ItemOptions::default() });
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ItemOptions {
    /// Whether opaque faces of the item are occluders. Default `true`.
    ///
    /// If not, they are treated as alpha-tested: culled like any other, but hiding nothing. For items whose mesh only
    /// approximates what is drawn. A skinned or animated object needs a [`Mesh::bounds_only`](crate::Mesh::bounds_only)
    /// around every pose instead: with the eye inside a mesh that merely encloses it, the object could be culled.
    pub is_occluder: bool,
    /// Whether the item is drawn, so that visible sets list it. Default `true`. An occluder that is not drawn still
    /// hides what is behind it.
    pub is_drawn: bool,
    /// Whether visible sets list the item for every passage into its sector, even if it is hidden or out of view.
    /// Default `false`. Layers still apply, distance and size do not.
    pub never_cull: bool,
    /// The layers that the item is in, one bit each. Default: all. A look ignores an item that has no layer in common
    /// with [`ViewerOptions::layers`](crate::ViewerOptions::layers): it is neither visible nor an occluder.
    #[doc(alias = "layer mask")]
    #[doc(alias = "visibility mask")]
    pub layers: u32,
    /// Distance from the eye to the item's AABB, in units of the sector, beyond which a look ignores the item. Default:
    /// infinite. This hides what can be seen; [`Stats::items_ignored`](crate::Stats::items_ignored) counts it.
    #[doc(alias = "draw distance")]
    pub max_distance: f32,
    /// Diameter on the screen, in pixels, below which a look ignores the item: that of the sphere around its AABB, at
    /// the distance of its centre. Default 0. This hides what can be seen;
    /// [`Stats::items_ignored`](crate::Stats::items_ignored) counts it.
    #[doc(alias = "small feature culling")]
    #[doc(alias = "contribution culling")]
    pub min_size_px: f32,
}

impl ItemOptions {
    /// Whether a look may ignore the item for its distance or size.
    pub(crate) fn has_limits(&self) -> bool {
        !self.never_cull && (self.max_distance < f32::INFINITY || self.min_size_px > 0.0)
    }
}

impl Default for ItemOptions {
    fn default() -> ItemOptions {
        ItemOptions {
            is_occluder: true,
            is_drawn: true,
            never_cull: false,
            layers: u32::MAX,
            max_distance: f32::INFINITY,
            min_size_px: 0.0,
        }
    }
}
