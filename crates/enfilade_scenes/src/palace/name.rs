//! What the rooms of the palace are called among those who build it.

/// Names of rooms, as places in [`ROOMS`](super::plan::ROOMS).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Name {
    Vestibule,
    GuardRoom,
    RedSalon,
    GreenSalon,
    Rotunda,
    BlueSalon,
    MirrorRoom,
    MusicRoom,
    Library,
    PictureRoom,
    Antechamber,
    ThroneRoom,
    Gallery,
    Court,
    PorcelainCabinet,
    Chapel,
    WinterGarden,
    Study,
    Treasury,
    SecretPassage,
    Terrace,
    Garden,
    /// Not in the plan's list: it is made anew for every moment.
    Fountain,
    /// The gallery of convex cells, from here on; not in that list either, but in [`CELLS`](super::cells::CELLS).
    PaintedLobby,
    FirstThreshold,
    MorningBay,
    SecondThreshold,
    Tribune,
    ThirdThreshold,
    EveningBay,
    FourthThreshold,
    Belvedere,
}

impl Name {
    /// The rooms, in the order of the plan.
    pub(crate) const ALL: [Name; 22] = [
        Name::Vestibule,
        Name::GuardRoom,
        Name::RedSalon,
        Name::GreenSalon,
        Name::Rotunda,
        Name::BlueSalon,
        Name::MirrorRoom,
        Name::MusicRoom,
        Name::Library,
        Name::PictureRoom,
        Name::Antechamber,
        Name::ThroneRoom,
        Name::Gallery,
        Name::Court,
        Name::PorcelainCabinet,
        Name::Chapel,
        Name::WinterGarden,
        Name::Study,
        Name::Treasury,
        Name::SecretPassage,
        Name::Terrace,
        Name::Garden,
    ];
}
