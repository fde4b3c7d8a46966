//! Unique names of items.

use enfilade::{ItemIndex, Scene, SectorId};
use std::collections::HashMap;

/// Unique names of items: `NAME`; `SECTOR/NAME` if that repeats in the scene; `SECTOR/NAME#3` if it repeats in the
/// sector; `SECTOR/item#3` without a name.
pub(crate) struct Names<'a> {
    scene: &'a Scene,
    in_scene: HashMap<&'a str, u32>,
    in_sector: HashMap<(SectorId, &'a str), u32>,
}

impl<'a> Names<'a> {
    /// Counts the names of a scene.
    pub(crate) fn new(scene: &'a Scene) -> Names<'a> {
        let mut names = Names {
            scene,
            in_scene: HashMap::new(),
            in_sector: HashMap::new(),
        };
        for sector in scene.sectors() {
            let Some(geometry) = scene.geometry(sector) else {
                continue;
            };
            for item in (0..geometry.items().len() as u32).map(ItemIndex) {
                let name = geometry.name(item);
                *names.in_scene.entry(name).or_default() += 1;
                *names.in_sector.entry((sector, name)).or_default() += 1;
            }
        }
        names
    }

    /// Returns the unique name of an item.
    pub(crate) fn of(&self, (sector, item): (SectorId, ItemIndex)) -> String {
        let Some(geometry) = self.scene.geometry(sector) else {
            return self.in_custom_sector(sector, item);
        };
        let name = geometry.name(item);
        let times = |times: Option<&u32>| times.copied().unwrap_or(0);
        if !name.is_empty() && times(self.in_scene.get(name)) == 1 {
            return name.to_owned();
        }
        let home = self.scene.sector_name(sector);
        match (name, times(self.in_sector.get(&(sector, name)))) {
            ("", _) => format!("{home}/item#{}", item.0),
            (name, 1) => format!("{home}/{name}"),
            (name, _) => format!("{home}/{name}#{}", item.0),
        }
    }

    /// Returns the name of an item in a custom sector. It is not checked for uniqueness: there may be millions of
    /// items.
    fn in_custom_sector(&self, sector: SectorId, item: ItemIndex) -> String {
        let home = self.scene.sector_name(sector);
        let name = self.scene.sector(sector).item_name(item);
        match (name.as_str(), self.scene.sector_count()) {
            ("", _) => format!("{home}/item#{}", item.0),
            (_, 1) => name,
            _ => format!("{home}/{name}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade::{GeometryBuilder, Material, MaterialId, Mesh, Method, SceneBuilder, Transform};

    #[test]
    fn every_item_has_a_name_of_its_own() {
        let mut scene = SceneBuilder::new();
        for (room, items) in [
            ("hall", &["lamp", "chair", "chair", ""][..]),
            ("attic", &["chair", "trunk"]),
        ] {
            let mut geometry = GeometryBuilder::new([Material::opaque([1.0; 3])]);
            let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            let mesh =
                geometry.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("a triangle"));
            items.iter().for_each(|item| {
                geometry.item(item, mesh, Transform::IDENTITY);
            });
            scene.add(room, geometry.build().expect("sound"), Method::ZBuffer);
        }
        let scene = scene.build().expect("sound");
        let names = Names::new(&scene);
        let of = |sector, item| names.of((SectorId(sector), ItemIndex(item)));
        assert_eq!(
            [of(0, 0), of(0, 1), of(0, 2), of(0, 3)],
            ["lamp", "hall/chair#1", "hall/chair#2", "hall/item#3"]
        );
        assert_eq!([of(1, 0), of(1, 1)], ["attic/chair", "trunk"]);
    }
}
