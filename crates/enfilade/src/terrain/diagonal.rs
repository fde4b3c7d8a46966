//! Along which diagonal the cells of a height field are two triangles.

/// By the northern corner that a diagonal begins in; north is −z, east +x.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Diagonal {
    /// From the corner north-east to the one south-west.
    #[default]
    NorthEast,
    /// From the corner north-west to the one south-east.
    NorthWest,
}

impl Diagonal {
    /// The two triangles of a cell by its corners north-west, north-east, south-west and south-east, counter-clockwise seen
    /// from above.
    pub(super) fn triangles(
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
