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
    /// Each fragment in a colour of its own.
    Fragments,
}

impl Show {
    /// Every picture there is.
    pub const ALL: [Show; 5] = [
        Show::Image,
        Show::Overdraw,
        Show::Items,
        Show::Order,
        Show::Fragments,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Show::Image => "image",
            Show::Overdraw => "overdraw",
            Show::Items => "items",
            Show::Order => "order",
            Show::Fragments => "fragments",
        }
    }

    /// The picture of a name; `None` where there is none.
    pub fn by_name(name: &str) -> Option<Show> {
        Show::ALL.into_iter().find(|show| show.name() == name)
    }
}
