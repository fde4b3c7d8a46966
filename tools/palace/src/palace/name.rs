//! Names of the palace's rooms, for the code that builds it.

/// A room; the value is an index into [`ROOMS`](super::plan::ROOMS).
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
    /// Not in [`ROOMS`](super::plan::ROOMS): rebuilt for every moment.
    Fountain,
    /// The first of the convex cells, which are in [`CELLS`](super::cells::CELLS), not in
    /// [`ROOMS`](super::plan::ROOMS).
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
