//! Which cells items and openings stand in: found out from their faces, never too few.

use crate::geom::{ConvexPolygon, Run, Runs};
use crate::geometry::{BakedCells, CellSide, Geometry, ItemId, Leaf, MovedItem, Opening, Room};
use glam::DVec3;

/// Of items with more faces, the boxes of clusters are sorted instead.
const MANY_FACES: u32 = 512;

/// An item in more cells than this is taken for one that is everywhere.
const MAX_CELLS: usize = 1024;

/// Planes that an item may be held against, for each of its faces and besides: what takes longer is everywhere.
const MAX_PLANES: [u64; 2] = [64, 1 << 18];

/// Which items stand in which cells, both ways. The cell after the last is that of items which are everywhere, or in none:
/// those are always looked at.
pub(super) struct Stands {
    lists: Runs,
    /// By cell: the items in it.
    items: Vec<Run>,
    /// By item: the cells that it stands in.
    cells: Vec<Run>,
    /// Kept, for it has a number for each cell: an edit touches a few.
    finding: Finding,
}

/// Where it is found out which cells something stands in.
#[derive(Default)]
struct Finding {
    room: Room,
    found: Vec<u32>,
    /// By cell: the thing that was last found in it.
    last: Vec<u32>,
    thing: u32,
}

impl Stands {
    /// Finds out where all items of a geometry stand; `None` where that takes more than `limit_bytes`.
    pub(super) fn new(cells: &BakedCells, geometry: &Geometry, limit_bytes: u64) -> Option<Stands> {
        let mut stands = Stands {
            lists: Runs::default(),
            items: vec![Run::EMPTY; cells.cell_count() + 1],
            cells: vec![Run::EMPTY; geometry.items().len()],
            finding: Finding::default(),
        };
        for item in (0..geometry.items().len() as u32).map(ItemId) {
            stands.finding.of_item(cells, geometry, item);
            stands.put(item);
            if stands.bytes() > limit_bytes {
                return None;
            }
        }
        Some(stands)
    }

    /// Follows items that have moved, come or gone, and writes down the cells that have lost or gained one.
    pub(super) fn follow(
        &mut self,
        cells: &BakedCells,
        geometry: &Geometry,
        moved: &[MovedItem],
        touched: &mut Vec<u32>,
    ) {
        self.cells.resize(geometry.items().len(), Run::EMPTY);
        for &MovedItem { item, .. } in moved {
            self.finding.of_item(cells, geometry, item);
            let run = &mut self.cells[item.0 as usize];
            let before = self.lists.get(*run);
            if before == self.finding.found {
                continue;
            }
            let before = before.to_vec();
            self.lists.clear(run);
            for &cell in &before {
                self.lists.remove(&mut self.items[cell as usize], item.0);
            }
            self.put(item);
            touched.extend(before.iter().chain(&self.finding.found));
        }
    }

    /// Has an item stand in the cells that were found.
    fn put(&mut self, item: ItemId) {
        self.cells[item.0 as usize] = self.lists.put(&self.finding.found);
        for &cell in &self.finding.found {
            self.lists.push(&mut self.items[cell as usize], item.0);
        }
    }

    /// The items in a cell.
    pub(super) fn in_cell(&self, cell: u32) -> &[u32] {
        self.lists.get(self.items[cell as usize])
    }

    /// The items that are always looked at.
    pub(super) fn everywhere(&self) -> &[u32] {
        self.in_cell(self.items.len() as u32 - 1)
    }

    pub(super) fn bytes(&self) -> u64 {
        let by_cell = size_of_val(&*self.items) + size_of_val(&*self.finding.last);
        (self.lists.bytes() + by_cell + size_of_val(&*self.cells)) as u64
    }
}

/// The cells that each opening stands in; none where it is everywhere.
pub(super) fn cells_of_openings(cells: &BakedCells, geometry: &Geometry) -> Vec<Vec<u32>> {
    let mut finding = Finding::default();
    let of = |opening: &Opening| finding.of_outline(cells, &opening.outline);
    geometry.openings().iter().map(of).collect()
}

impl Finding {
    fn begin(&mut self, cells: &BakedCells) {
        self.last.resize(cells.cell_count(), 0);
        self.thing += 1;
        self.found.clear();
        self.room.planes = 0;
    }

    /// The cells of an item into `found`: none for one without faces, and the one after the last for one that is everywhere.
    fn of_item(&mut self, cells: &BakedCells, geometry: &Geometry, item: ItemId) {
        self.begin(cells);
        let mesh = geometry.mesh_of(item);
        if mesh.face_count() == 0 {
            return;
        }
        let placed = geometry.item(item);
        let sector_from_item = placed.transform();
        let there = |corner: [f32; 3]| DVec3::from(sector_from_item.point_f64(corner));
        let top = cells.around(&placed.bounds);
        let most_planes = MAX_PLANES[0] * u64::from(mesh.face_count()) + MAX_PLANES[1];
        let is_known = if !matches!(top, CellSide::Node(_)) {
            // All of it is in one leaf.
            self.room.hull([DVec3::ZERO]);
            self.take(cells, top)
        } else if mesh.face_count() > MANY_FACES {
            mesh.clusters().iter().all(|cluster| {
                self.room.hull(cluster.bounds.corners().map(there));
                self.take(cells, top) && self.room.planes <= most_planes
            })
        } else {
            (0..mesh.face_count()).all(|face| {
                let corners = mesh.face(face);
                // As triangles: a face of more corners may be a little off its plane.
                corners[1..].windows(2).all(|pair| {
                    let triangle = [corners[0], pair[0], pair[1]];
                    let corner = |index: u32| there(mesh.positions()[index as usize]);
                    self.room.outline(triangle.map(corner));
                    self.take(cells, top) && self.room.planes <= most_planes
                })
            })
        };
        if !is_known || self.found.is_empty() {
            self.found.clear();
            self.found.push(cells.cell_count() as u32);
        }
        self.found.sort_unstable();
    }

    fn of_outline(&mut self, cells: &BakedCells, outline: &ConvexPolygon) -> Vec<u32> {
        self.begin(cells);
        let there = |corner: [f32; 3]| DVec3::from(corner.map(f64::from));
        let corners = outline.corners();
        let is_known = corners[1..].windows(2).all(|pair| {
            self.room.outline([corners[0], pair[0], pair[1]].map(there));
            self.take(cells, cells.tree().root)
        });
        if is_known { self.found.clone() } else { Vec::new() }
    }

    /// Adds the cells of what the room has taken; `false` where they are too many, or cannot be told.
    fn take(&mut self, cells: &BakedCells, top: CellSide) -> bool {
        let Finding {
            room,
            found,
            last,
            thing,
        } = self;
        cells.touched(top, room, |leaf| {
            if let Leaf::Cell(cell) = leaf
                && std::mem::replace(&mut last[cell.0 as usize], *thing) != *thing
            {
                found.push(cell.0);
            }
            found.len() <= MAX_CELLS
        })
    }
}
