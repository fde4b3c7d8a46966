//! Which picture is wanted.

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Show {
    /// The scene, lit.
    Image,
    /// How many faces were tested at each sample: dark for none, through blue, green and yellow to white for 16.
    Overdraw,
    /// Each item in a colour of its own.
    Items,
    /// When each sample's owner was handed out: blue first, red last.
    Order,
    /// Each sector in a colour of its own.
    Sectors,
    /// What each passage's cover knows when all that hides is in it, nearer lighter; what is seen through an opening is
    /// painted over it, for that has a cover of its own. Only of methods with a [`CoverShape`](enfilade::CoverShape):
    ///
    /// * spans: faces in colours of their own, dark where a span begins;
    /// * pyramid: the largest cells that say nearly as much as the tiles below, as near as their farthest sample; in
    ///   colour where one face owns a whole tile, grey where samples are told apart;
    /// * tiles: the reference of each sub-tile in blue, the samples of its mask in orange;
    /// * tree: occluders in colours of their own, cut to the leaves that they hide.
    ///
    /// White is where nothing hides.
    Cover,
}

impl Show {
    /// Every picture there is.
    pub const ALL: [Show; 6] = [
        Show::Image,
        Show::Overdraw,
        Show::Items,
        Show::Order,
        Show::Sectors,
        Show::Cover,
    ];

    /// Its name on the command line.
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

    /// The picture of a name; `None` where there is none.
    pub fn by_name(name: &str) -> Option<Show> {
        Show::ALL.into_iter().find(|show| show.name() == name)
    }
}
