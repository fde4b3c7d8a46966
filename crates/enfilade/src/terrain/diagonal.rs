//! The diagonal along which the cells of a height field are split into triangles.

/// Named for its northern end; north is −z, east +x.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Diagonal {
    /// From the north-east corner to the south-west corner.
    #[default]
    NorthEast,
    /// From the north-west corner to the south-east corner.
    NorthWest,
}

impl Diagonal {
    /// Returns the two triangles of a cell, counter-clockwise seen from above, from the indices of its corners.
    pub(crate) fn triangles(
        self,
        [north_west, north_east, south_west, south_east]: [u32; 4],
    ) -> [[u32; 3]; 2] {
        match self {
            Diagonal::NorthEast => [
                [north_west, south_west, north_east],
                [north_east, south_west, south_east],
            ],
            Diagonal::NorthWest => [
                [north_west, south_west, south_east],
                [north_west, south_east, north_east],
            ],
        }
    }
}
