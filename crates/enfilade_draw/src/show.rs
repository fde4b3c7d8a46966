//! The kinds of pictures.

/// A kind of picture: the lit scene, or a diagnostic picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Show {
    /// The lit scene.
    Image,
    /// Overdraw: the number of faces tested at each sample, from black (none) through blue, green and yellow to white
    /// (16).
    Overdraw,
    /// Item ids: one colour per item.
    Items,
    /// Emission order of the samples' owners, from blue (first) to red (last).
    Order,
    /// Sectors: one colour per sector.
    Sectors,
    /// Final state of each passage's occlusion buffer, with all occluders in it; nearer is brighter. Geometry visible
    /// through an opening is painted on top, because its passage has a buffer of its own. Requires methods with a
    /// [`CoverShape`](enfilade::CoverShape):
    ///
    /// * spans: one colour per face, darker at the start of each span;
    /// * pyramid: Hi-Z cells, as large as possible without losing much depth against their tiles, shaded by their
    ///   farthest sample; coloured where one face owns a whole tile, grey where owners are per sample;
    /// * tiles: the reference layer of each sub-tile in blue, samples of its coverage mask in orange;
    /// * tree: one colour per occluder, clipped to the leaves it occludes.
    ///
    /// White samples have no occluder.
    Cover,
}

impl Show {
    /// All kinds of pictures.
    pub const ALL: [Show; 6] = [
        Show::Image,
        Show::Overdraw,
        Show::Items,
        Show::Order,
        Show::Sectors,
        Show::Cover,
    ];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Show::Image => "image",
            Show::Overdraw => "overdraw",
            Show::Items => "items",
            Show::Order => "order",
            Show::Sectors => "sectors",
            Show::Cover => "cover",
        }
    }

    /// Returns the kind of picture with a name, or `None`.
    pub fn by_name(name: &str) -> Option<Show> {
        Show::ALL.into_iter().find(|show| show.name() == name)
    }
}
