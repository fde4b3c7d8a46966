//! Lists of the items and openings in each cell, found from their faces: conservative, never too few cells.

use crate::geom::{ConvexPolygon, Run, Runs};
use crate::geometry::{BakedCells, CellSide, Geometry, Leaf, MovedItem, Opening, Room};
use crate::ids::ItemIndex;
use glam::DVec3;

/// Maximum number of faces for which an item's cells are found face by face; above it, by the AABBs of its clusters.
const MANY_FACES: u32 = 512;

/// Maximum number of cells of an item; one in more cells counts as being everywhere.
const MAX_CELLS: usize = 1024;

/// Maximum number of planes tested for an item: per face, and a constant added to that. An item that exceeds it counts
/// as being everywhere.
const MAX_PLANES: [u64; 2] = [64, 1 << 18];

/// Items by cell and cells by item. The cell after the last one lists the items that are everywhere or in no cell;
/// those are always visited.
pub(super) struct ItemCells {
    lists: Runs,
    /// By cell: its items.
    items: Vec<Run>,
    /// By item: its cells.
    cells: Vec<Run>,
    /// Kept because it has one entry per cell, while an edit affects few cells.
    search: CellSearch,
}

/// Search for the cells that an object is in.
#[derive(Default)]
struct CellSearch {
    room: Room,
    found: Vec<u32>,
    /// By cell: the number of the last search that found it.
    last: Vec<u32>,
    thing: u32,
}

impl ItemCells {
    /// Finds the cells of all items of a geometry; `None` if the lists exceed `limit_bytes`.
    pub(super) fn new(cells: &BakedCells, geometry: &Geometry, limit_bytes: u64) -> Option<ItemCells> {
        let mut item_cells = ItemCells {
            lists: Runs::default(),
            items: vec![Run::EMPTY; cells.cell_count() + 1],
            cells: vec![Run::EMPTY; geometry.items().len()],
            search: CellSearch::default(),
        };
        for item in (0..geometry.items().len() as u32).map(ItemIndex) {
            item_cells.search.of_item(cells, geometry, item);
            item_cells.put(item);
            if item_cells.bytes() > limit_bytes {
                return None;
            }
        }
        Some(item_cells)
    }

    /// Updates items that have moved, been added or removed; appends the cells that have lost or gained one to
    /// `touched`.
    pub(super) fn follow(
        &mut self,
        cells: &BakedCells,
        geometry: &Geometry,
        moved: &[MovedItem],
        touched: &mut Vec<u32>,
    ) {
        self.cells.resize(geometry.items().len(), Run::EMPTY);
        for &MovedItem { item, .. } in moved {
            self.search.of_item(cells, geometry, item);
            let run = &mut self.cells[item.0 as usize];
            let before = self.lists.get(*run);
            if before == self.search.found {
                continue;
            }
            let before = before.to_vec();
            self.lists.clear(run);
            for &cell in &before {
                self.lists.remove(&mut self.items[cell as usize], item.0);
            }
            self.put(item);
            touched.extend(before.iter().chain(&self.search.found));
        }
    }

    /// Adds an item to the lists of the cells that were found.
    fn put(&mut self, item: ItemIndex) {
        self.cells[item.0 as usize] = self.lists.put(&self.search.found);
        for &cell in &self.search.found {
            self.lists.push(&mut self.items[cell as usize], item.0);
        }
    }

    /// Returns the items in a cell.
    pub(super) fn in_cell(&self, cell: u32) -> &[u32] {
        self.lists.get(self.items[cell as usize])
    }

    /// Returns the items that are always visited.
    pub(super) fn everywhere(&self) -> &[u32] {
        self.in_cell(self.items.len() as u32 - 1)
    }

    pub(super) fn bytes(&self) -> u64 {
        let by_cell = size_of_val(&*self.items) + size_of_val(&*self.search.last);
        (self.lists.bytes() + by_cell + size_of_val(&*self.cells)) as u64
    }
}

/// Returns the cells of each opening; empty for one that counts as being everywhere.
pub(super) fn cells_of_openings(cells: &BakedCells, geometry: &Geometry) -> Vec<Vec<u32>> {
    let mut search = CellSearch::default();
    let of = |opening: &Opening| search.of_outline(cells, &opening.outline);
    geometry.openings().iter().map(of).collect()
}

impl CellSearch {
    fn begin(&mut self, cells: &BakedCells) {
        self.last.resize(cells.cell_count(), 0);
        self.thing += 1;
        self.found.clear();
        self.room.planes = 0;
    }

    /// Finds the cells of an item: none if it has no extent, and only the one after the last if it counts as being
    /// everywhere.
    fn of_item(&mut self, cells: &BakedCells, geometry: &Geometry, item: ItemIndex) {
        self.begin(cells);
        let mesh = geometry.mesh_of(item);
        if mesh.bounds().is_empty() {
            return;
        }
        let placed = geometry.item(item);
        let sector_from_item = placed.transform();
        let there = |corner: [f32; 3]| DVec3::from(sector_from_item.point_f64(corner));
        let top = cells.around(&placed.bounds);
        let most_planes = MAX_PLANES[0] * u64::from(mesh.face_count()) + MAX_PLANES[1];
        let is_known = if !matches!(top, CellSide::Node(_)) {
            // The whole item is in one leaf.
            self.room.hull([DVec3::ZERO]);
            self.take(cells, top)
        } else if mesh.face_count() > MANY_FACES || mesh.face_count() == 0 {
            mesh.clusters().iter().all(|cluster| {
                self.room.hull(cluster.bounds.corners().map(there));
                self.take(cells, top) && self.room.planes <= most_planes
            })
        } else {
            (0..mesh.face_count()).all(|face| {
                let corners = mesh.face(face);
                // As triangles: the corners of a larger face may deviate from its plane.
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

    /// Adds the cells that the shape in `room` touches; `false` if they are too many or cannot be determined.
    fn take(&mut self, cells: &BakedCells, top: CellSide) -> bool {
        let CellSearch {
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
