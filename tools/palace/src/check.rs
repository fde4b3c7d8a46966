//! Compares the file with the generated scene.

use crate::export::terrain_of;
use anyhow::{Context, Result, ensure};
use enfilade::laws::Reference;
use enfilade::{Camera, Limits, Method, Scene, View, Viewer, survey};
use enfilade_import::{ReadOptions, read};
use enfilade_scenes::BuiltIn;
use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

const SIZE: [u32; 2] = [1280, 720];
/// Size of the views that are compared with the reference.
const SMALL: [u32; 2] = [320, 180];

/// Compares contents, then visible sets from the cameras and from `views` views of the survey.
pub(crate) fn check(palace: &BuiltIn, file: &str, views: usize) -> Result<()> {
    let start = Instant::now();
    let import = read(Path::new(file), &ReadOptions::default())?;
    for warning in &import.warnings {
        println!("{warning}");
    }
    println!("read in {:.2?}", start.elapsed());
    let scene = import.scene(Method::HierarchicalZ, Method::DEFAULT_LIMIT)?;
    println!("built in {:.2?}", start.elapsed());
    contents(&palace.scene, &scene)?;
    ensure!(import.cameras.len() == palace.cameras.len(), "cameras");
    let mut looked: Vec<View> = palace
        .cameras
        .iter()
        .map(|camera| camera.view(SIZE).expect("a valid view"))
        .collect();
    for (ours, view) in import.cameras.iter().zip(&looked) {
        ensure!(
            ours.eye == view.eye() && ours.fov_y == view.fov_y(),
            "camera {}",
            ours.name
        );
    }
    for found in survey(&scene, views).views {
        let camera = Camera {
            sector: Some(found.sector),
            ..Camera::new(found.eye, found.toward)
        };
        let view = camera.view(SIZE).expect("a valid view");
        looked.push(view);
    }
    let [generated, read] =
        [&palace.scene, &scene].map(|scene| scene.with_method(Method::HierarchicalZ, u64::MAX));
    let (generated, read) = (generated?, read?);
    let mut viewers = [Viewer::new(), Viewer::new()];
    let (mut lost, mut new, mut both, mut missed) = (0, 0, 0, 0);
    for view in &looked {
        let sets =
            [(&generated, 0), (&read, 1)].map(|(scene, number)| seen(&mut viewers[number], scene, view));
        both += sets[0].intersection(&sets[1]).count();
        lost += sets[0].difference(&sets[1]).count();
        new += sets[1].difference(&sets[0]).count();
        let camera = Camera {
            sector: view.sector,
            fov_y: view.fov_y(),
            ..Camera::new(view.eye(), view.toward())
        };
        let small = camera.view(SMALL)?;
        let truth = Reference::new(&read).see(&read, &small, &Limits::default());
        viewers[1].look(&read, &small);
        missed += truth.check(viewers[1].visible(), None).missed.len();
    }
    println!(
        "{} views: {both} visible in both, {lost} lost, {new} new, {missed} missed",
        looked.len()
    );
    ensure!(missed == 0, "the set of the file lacks what the reference sees");
    ensure!(
        50 * (lost + new) <= both,
        "more than 2 % of the visible items differ"
    );
    Ok(())
}

fn seen(viewer: &mut Viewer, scene: &Scene, view: &View) -> BTreeSet<(u32, String)> {
    viewer.look(scene, view);
    let mut seen = BTreeSet::new();
    for found in viewer.visible().items() {
        let sector = viewer.visible().passages()[found.passage.0 as usize].sector;
        let geometry = scene.geometry(sector).expect("all sectors have geometry");
        seen.insert((sector.0, geometry.name(found.item.index).to_owned()));
    }
    seen
}

/// Compares what both scenes contain.
fn contents(generated: &Scene, read: &Scene) -> Result<()> {
    ensure!(generated.sector_count() == read.sector_count(), "sectors");
    println!(
        "{} sectors, {} items, {} triangles, {} portals, {} lights",
        read.sector_count(),
        read.item_count(),
        read.triangle_count(),
        read.portals().len(),
        read.lights().len()
    );
    for id in generated.sectors() {
        let name = generated.sector_name(id);
        ensure!(
            name == read.sector_name(id),
            "sector {name} is {}",
            read.sector_name(id)
        );
        ensure!(generated.method(id) == read.method(id), "{name}: methods");
        if generated.is_open_above(id) != read.is_open_above(id) {
            println!("{name}: open above: {}", read.is_open_above(id));
        }
        let [a, b] = [generated, read].map(|scene| scene.geometry(id).context("geometry"));
        let (a, b) = (a?, b?);
        ensure!(a.items().len() == b.items().len(), "{name}: items");
        for (item, one) in (0..).map(enfilade::ItemIndex).zip(a.items()) {
            let called = a.name(item);
            ensure!(
                called == b.name(item),
                "{name}: item {called} is {}",
                b.name(item)
            );
            ensure!(
                one.transform() == b.item(item).transform(),
                "{called}: transforms"
            );
            let triangles = |geometry: &enfilade::Geometry| geometry.mesh_of(item).triangle_count();
            let [before, after] = [triangles(a), triangles(b)];
            ensure!(before == after, "{called}: {before} triangles became {after}");
            // Of the mesh: the bounds of an item depend on how many positions its mesh has.
            let [one, other] = [a, b].map(|geometry| geometry.mesh_of(item).bounds());
            let off = (one
                .min
                .iter()
                .chain(&one.max)
                .zip(other.min.iter().chain(&other.max)))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f32::max);
            ensure!(off < 1e-3, "{called}: bounds differ by {off}");
            ensure!(
                off == 0.0 || terrain_of(called).is_none(),
                "{called}: the terrain moved"
            );
        }
        let openings = |geometry: &enfilade::Geometry| -> BTreeSet<String> {
            let own = format!("{name}: ");
            let names = geometry.openings().iter().map(|opening| &*opening.name);
            names
                .map(|name| name.strip_prefix(&own).unwrap_or(name).to_owned())
                .collect()
        };
        ensure!(a.openings().len() == b.openings().len(), "{name}: openings");
        // A door is one node, so its two openings get one name.
        for lost in openings(a).difference(&openings(b)) {
            println!("{name}: opening {lost} is called otherwise");
        }
        ensure!(
            a.materials().len() + 1 == b.materials().len(),
            "{name}: materials"
        );
    }
    ensure!(generated.portals().len() == read.portals().len(), "portals");
    for portal in generated.portals() {
        let name = &generated.sector(portal.from).openings()[usize::from(portal.opening.0)].name;
        let same = read.portals().iter().any(|other| {
            let columns = [portal, other].map(|portal| portal.there_from_here.columns());
            let off = (columns[0].as_flattened().iter().zip(columns[1].as_flattened()))
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f32::max);
            other.from == portal.from && other.to == portal.to && off < 1e-3 && {
                let [a, b] = [(generated, portal), (read, other)].map(|(scene, portal)| {
                    let opening = &scene.sector(portal.from).openings()[usize::from(portal.opening.0)];
                    opening.outline.bounds().center()
                });
                a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3)
            }
        });
        ensure!(same, "portal {name} of {}", generated.sector_name(portal.from));
    }
    ensure!(generated.lights().len() == read.lights().len(), "lights");
    for (a, b) in generated.lights().iter().zip(read.lights()) {
        let off = a
            .color
            .iter()
            .zip(&b.color)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f32::max);
        ensure!(
            a.sector == b.sector && a.range == b.range && off < 1e-4,
            "{a:?} became {b:?}"
        );
    }
    Ok(())
}
