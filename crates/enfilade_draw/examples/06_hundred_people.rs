//! A hundred statues walk through a palace whose doors open before them, seen by two cameras. Writes `people.png`, an
//! animated PNG.

use enfilade::*;
use enfilade_draw::{Clip, RgbImage, Settings, Stage};
use enfilade_scenes::built_in;
use enfilade_walk::Capsule;
use glam::{Vec3, vec3};
use image::imageops::replace;
use std::sync::Arc;

const SIZE: [u32; 2] = [320, 240];
const FRAMES: u32 = 48;
const UP_TO_MIDDLE: Vec3 = vec3(0.0, 0.95, 0.0);

struct Person {
    place: Location,
    goal: Vec3,
    /// The person is an item of each sector that it touches.
    items: Vec<(SectorId, ItemId)>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let palace = built_in("enfilade").ok_or("the palace is built in")?;
    let mut scene = palace.scene;
    let mut doors: Vec<(PortalId, SectorId, Vec3)> = Vec::new();
    for (id, portal) in (0..).map(PortalId).zip(scene.portals()) {
        let opening = &scene.sector(portal.from).openings()[usize::from(portal.opening.0)];
        if opening.name.ends_with("door") || opening.name.ends_with("arch") {
            doors.push((id, portal.from, opening.outline.bounds().center().into()));
        }
    }
    // Obstacles: the palace without people, so that nobody blocks themselves.
    let mut walls = scene.clone();
    let start = |number: usize| {
        let (_, sector, goal) = doors[number * 7 % doors.len()];
        let middle = Vec3::from(scene.bounds(sector).center()) * vec3(1.0, 0.0, 1.0);
        let at = goal.with_y(0.0).lerp(middle, 0.2 + 0.006 * number as f32) + UP_TO_MIDDLE;
        let (position, items) = (at.into(), Vec::new());
        let place = Location { sector, position };
        Person { place, goal, items }
    };
    let mut people: Vec<Person> = (0..100).map(start).collect();
    let mut kinds: Vec<Arc<Mesh>> = Vec::new();
    for geometry in scene.sectors().filter_map(|id| scene.geometry(id)) {
        for (id, item) in (0..).map(ItemIndex).zip(geometry.items()) {
            let mesh = &geometry.meshes()[item.mesh.0 as usize];
            if geometry.name(id).contains(": statue") && !kinds.iter().any(|kind| Arc::ptr_eq(kind, mesh)) {
                kinds.push(Arc::clone(mesh));
            }
        }
    }
    // Cameras in the rotunda and in the red salon.
    let stage = Stage::new(&scene);
    let mut viewers =
        [palace.cameras[4].view(SIZE)?, palace.cameras[2].view(SIZE)?].map(|view| (view, Viewer::new()));
    let file = std::fs::File::create("people.png")?;
    let mut clip = Clip::new(file, [2 * SIZE[0], SIZE[1]], FRAMES, 12)?;
    for frame in 0..FRAMES {
        for (number, person) in people.iter_mut().enumerate() {
            let from = person.place;
            let way = (person.goal - Vec3::from(from.position)).with_y(0.0);
            let step = 0.12 * way.normalize_or_zero() - 0.02 * Vec3::Y;
            person.place = Capsule::new(0.25, 1.9).slide(&walls, from, step.into()).location;
            let here = Vec3::from(person.place.position);
            if person.place.sector != from.sector || here.distance(from.position.into()) < 0.03 {
                // Walk on to another door of the current room.
                let ways = doors.iter().filter(|door| door.1 == person.place.sector);
                let way = ways.cycle().nth(number + frame as usize);
                person.goal = way.map_or(here, |&(.., door)| door + 0.3 * (door - here).normalize());
            }
        }
        for &(id, _, door) in &doors {
            let near = |person: &Person| door.with_y(0.95).distance(person.place.position.into()) < 2.0;
            let open = people.iter().any(near);
            scene.set_open(id, open);
            walls.set_open(id, open);
        }
        let mut edit = scene.edit();
        for (number, somebody) in people.iter_mut().enumerate() {
            let before = std::mem::take(&mut somebody.items);
            for presence in walls.body_sectors(somebody.place, 0.4) {
                let Location { sector, position } = presence.location;
                let (way, feet) = (
                    somebody.goal - Vec3::from(position),
                    Vec3::from(position) - UP_TO_MIDDLE,
                );
                let turn = Transform::rotation([0.0, 1.0, 0.0], f64::from(way.x.atan2(way.z)));
                let there = Transform::translation(feet.into()) * turn;
                let item = match before.iter().find(|item| item.0 == sector) {
                    Some(&(_, item)) => edit.set_transform(sector, item, there).map(|()| item)?,
                    None => edit
                        .add(sector, "person", kinds[number % kinds.len()].clone(), there)?
                        .index
                        .into(),
                };
                somebody.items.push((sector, item));
            }
            for &(sector, item) in before.iter().filter(|gone| !somebody.items.contains(gone)) {
                edit.remove(sector, item)?;
            }
        }
        edit.finish()?;
        let mut picture = RgbImage::new(2 * SIZE[0], SIZE[1]);
        for (left, (view, viewer)) in (0..).step_by(SIZE[0] as usize).zip(&mut viewers) {
            let half = stage.draw(viewer, &scene, view, &Settings::default());
            replace(&mut picture, &half.image, left, 0);
        }
        clip.add(&picture)?;
    }
    Ok(clip.finish()?)
}
