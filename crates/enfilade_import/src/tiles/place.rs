//! Puts a model at the places of its instances.

use super::instances::Instances;
use crate::budget::{BYTES_PER_MESH, Budget};
use crate::{BrokenRule, Import, Room, SourceNodes};
use enfilade::{Camera, GeometryBuilder, ItemIndex, Light, LightShape, SectorId, Transform};
use std::sync::Arc;

/// Memory of an item, in bytes, without its name.
const BYTES_PER_ITEM: u64 = 400;

/// Replaces the room of a model by one with its items, lights and cameras at each instance. Items of an `.i3dm` are called
/// `NAME[7]`; they share their meshes.
pub(super) fn place(
    import: &mut Import,
    instances: &Instances,
    budget: &mut Budget,
) -> Result<(), BrokenRule> {
    for room in &mut import.rooms {
        place_items(room, instances, budget)?;
    }
    let places = || instances.transforms.iter().zip(0_u64..);
    let lights = std::mem::take(&mut import.lights);
    let cameras = std::mem::take(&mut import.cameras);
    let heights = std::mem::take(&mut import.orthographic_heights);
    let count = instances.transforms.len() as u64;
    let bytes = size_of::<Light>() * lights.len() + 2 * size_of::<Camera>() * cameras.len();
    budget.take(count * bytes as u64, || "the lights of its instances".to_owned())?;
    for (transform, number) in places() {
        import
            .lights
            .extend(lights.iter().map(|light| placed_light(light, transform)));
        for (camera, height) in cameras.iter().zip(&heights) {
            let name = instances.name(&camera.name, number);
            import.cameras.push(placed_camera(camera, transform, name));
            import.orthographic_heights.push(*height);
        }
    }
    Ok(())
}

fn place_items(room: &mut Room, instances: &Instances, budget: &mut Budget) -> Result<(), BrokenRule> {
    let model = Arc::clone(&room.geometry);
    let items = model.items().len() as u32;
    let names: u64 = (0..items)
        .map(|item| model.name(ItemIndex(item)).len() as u64 + 12)
        .sum();
    let of_model = u64::from(items) * BYTES_PER_ITEM + names;
    let of_instances = of_model.saturating_mul(instances.transforms.len() as u64);
    // The meshes are shared, but the model's own lists remain until the new ones are built.
    let of_meshes = model.bytes() + model.meshes().len() as u64 * BYTES_PER_MESH;
    budget.take(of_instances.saturating_add(of_meshes), || {
        "the items of its instances".to_owned()
    })?;
    let mut geometry = GeometryBuilder::new(model.materials());
    geometry.textures(model.textures());
    let meshes: Vec<_> = model
        .meshes()
        .iter()
        .map(|mesh| geometry.mesh(Arc::clone(mesh)))
        .collect();
    let mut nodes = SourceNodes::default();
    let mut non_occluders = room.non_occluders.without_items();
    for item in (0..items).map(ItemIndex) {
        let source = model.item(item);
        let why = room.non_occluders.of_whole_item(&model, item);
        for (transform, number) in instances.transforms.iter().zip(0_u64..) {
            let name = instances.name(model.name(item), number);
            let mesh = meshes[source.mesh.0 as usize];
            let placed = geometry.item(&name, mesh, *transform * source.transform());
            geometry.set_options(placed, source.options);
            nodes.add_copy(placed.index, &room.nodes, item);
            if let Some(why) = why {
                non_occluders.add(placed.index, why);
            }
        }
    }
    room.geometry = Arc::new(geometry.build().map_err(BrokenRule::Geometry)?);
    room.nodes = nodes;
    room.non_occluders = non_occluders;
    Ok(())
}

impl Instances {
    fn name(&self, name: &str, number: u64) -> String {
        if self.is_instanced {
            format!("{name}[{number}]")
        } else {
            name.to_owned()
        }
    }
}

fn placed_light(light: &Light, scene_from_model: &Transform) -> Light {
    let turned = |direction| scene_from_model.direction(direction);
    let shape = match light.shape {
        LightShape::Point => LightShape::Point,
        LightShape::Spot {
            direction,
            inner,
            outer,
        } => LightShape::Spot {
            direction: turned(direction),
            inner,
            outer,
        },
        LightShape::Sun { direction } => LightShape::Sun {
            direction: turned(direction),
        },
    };
    Light {
        position: scene_from_model.point(light.position),
        shape,
        ..*light
    }
}

fn placed_camera(camera: &Camera, scene_from_model: &Transform, name: String) -> Camera {
    let point = |at: [f64; 3]| (*scene_from_model * translation(at)).columns_f64()[3];
    let [from, to] = [[0.0; 3], camera.up].map(point);
    Camera {
        name,
        sector: Some(SectorId(0)),
        eye: point(camera.eye),
        toward: point(camera.toward),
        up: [0, 1, 2].map(|axis| to[axis] - from[axis]),
        ..camera.clone()
    }
}

fn translation(at: [f64; 3]) -> Transform {
    Transform::from_columns_f64([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], at])
}
