//! Writes a scene as glTF, with its sectors, portals and lights marked as the reader expects them.

use crate::document::{Document, number, numbers};
use crate::meshes::{Grid, Streams};
use crate::textures;
use anyhow::{Context, Result, ensure};
use enfilade::{Camera, Geometry, ItemIndex, Light, LightShape, Mesh, Method, Portal, Scene, Transform};
use enfilade_scenes::BuiltIn;
use glam::{DAffine3, DMat3, DVec3};
use serde_json::{Value, json};
use std::collections::{HashMap, HashSet};
use std::f32::consts::PI;
use std::sync::Arc;

/// How the meshes of a file are written.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Encoding {
    Compressed,
    /// Twelve times larger, for readers without the extensions.
    Plain,
}

/// Returns the bytes of a GLB with a scene and its cameras.
pub(crate) fn glb(built: &BuiltIn, encoding: Encoding) -> Result<Vec<u8>> {
    let scene = &built.scene;
    let mut nodes: Vec<Value> = Vec::new();
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); scene.sector_count()];
    for id in scene.sectors() {
        let method = scene.method(id).context("a sector is custom")?;
        nodes.push(json!({
            "name": scene.sector_name(id),
            "extras": {"enfilade": {"kind": "room", "method": method.name()}}}));
    }
    let mut document = Document::default();
    let mut streams = Streams::default();
    let mut names = HashSet::new();
    // The first user decides how a mesh is written: what bounds a room comes before what uses the same mesh elsewhere.
    let mut known: HashMap<*const Mesh, usize> = HashMap::new();
    let mut items = 0;
    for id in scene.sectors() {
        let geometry = geometry(scene, id)?;
        if id.0 == 0 {
            textures::write(&mut document, geometry)?;
        }
        let is_cell = scene.method(id) == Some(Method::Cell);
        let count = geometry.items().len() as u32;
        let mut item = 0;
        while item < count {
            let name = geometry.name(ItemIndex(item));
            let transform = geometry.item(ItemIndex(item)).transform();
            let mut node;
            if let Some(terrain) = terrain_of(name) {
                let blocks = (item..count)
                    .take_while(|&item| terrain_of(geometry.name(ItemIndex(item))) == Some(terrain));
                let meshes: Vec<Arc<Mesh>> = blocks.map(|block| mesh(geometry, ItemIndex(block))).collect();
                item += meshes.len() as u32;
                let mesh = streams.mesh(&meshes, Grid::Exact, geometry.materials(), geometry.textures());
                node = json!({"name": terrain, "mesh": document.push("meshes", mesh),
                    "extras": {"enfilade": {"kind": "terrain"}}});
            } else {
                ensure!(names.insert(name.to_owned()), "two items are called {name}");
                let mesh = mesh(geometry, ItemIndex(item));
                item += 1;
                let bounds_room = is_cell || name.contains(": shell ");
                let grid = if bounds_room { Grid::Shell } else { Grid::Rounded };
                let number = *known.entry(Arc::as_ptr(&mesh)).or_insert_with(|| {
                    let mesh = streams.mesh(&[mesh], grid, geometry.materials(), geometry.textures());
                    document.push("meshes", mesh)
                });
                node = json!({"name": name, "mesh": number});
            }
            place(&mut node, &transform);
            children[id.0 as usize].push(nodes.len());
            nodes.push(node);
            items += 1;
        }
    }
    println!("{} meshes, {items} nodes with items", known.len());
    portals(scene, &mut nodes, &mut children, &mut document, &mut streams)?;
    let mut sources = Vec::new();
    for light in scene.lights() {
        let mut node = json!({"extensions": {"KHR_lights_punctual": {"light": sources.len()}}});
        sources.push(lamp(light, &mut node));
        children[light.sector.0 as usize].push(nodes.len());
        nodes.push(node);
    }
    let roots = 0..scene.sector_count();
    let mut roots: Vec<usize> = roots.collect();
    for camera in &built.cameras {
        roots.push(nodes.len());
        nodes.push(lens(camera, &mut document));
    }
    for (room, children) in children.into_iter().enumerate() {
        nodes[room]["children"] = json!(children);
    }
    let required: &[&str] = match encoding {
        Encoding::Compressed => &["EXT_meshopt_compression", "KHR_mesh_quantization"],
        Encoding::Plain => &[],
    };
    match encoding {
        Encoding::Compressed => streams.write(&mut document)?,
        Encoding::Plain => streams.write_plain(&mut document),
    }
    let used = [
        required,
        &["KHR_lights_punctual", "KHR_materials_emissive_strength"],
    ]
    .concat();
    let mut rest = json!({
        "asset": {"version": "2.0", "generator": "Enfilade, tools/palace"},
        "extensionsUsed": used,
        "extensions": {"KHR_lights_punctual": {"lights": sources}},
        "scene": 0,
        "scenes": [{"nodes": roots}],
        "nodes": nodes});
    if !required.is_empty() {
        rest["extensionsRequired"] = json!(required);
    }
    Ok(document.glb(rest))
}

fn geometry(scene: &Scene, id: enfilade::SectorId) -> Result<&Arc<Geometry>> {
    scene.geometry(id).context("a sector has no geometry")
}

fn mesh(geometry: &Geometry, item: ItemIndex) -> Arc<Mesh> {
    Arc::clone(&geometry.meshes()[geometry.item(item).mesh.0 as usize])
}

/// Returns the name of the terrain that an item is a block of: `NAME` of `NAME ROW COLUMN`, if that is a ground.
pub(crate) fn terrain_of(name: &str) -> Option<&str> {
    let mut words = name.rsplitn(3, ' ');
    let are_numbers = [words.next()?, words.next()?]
        .iter()
        .all(|word| word.parse::<u32>().is_ok());
    words
        .next()
        .filter(|name| are_numbers && name.ends_with(": ground"))
}

/// Sets the transform of a node.
fn place(node: &mut Value, transform: &Transform) {
    let [x, y, z, at] = transform.columns();
    if [x, y, z] != [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        let columns = [(x, 0.0), (y, 0.0), (z, 0.0), (at, 1.0)];
        let columns: Vec<f32> = columns
            .iter()
            .flat_map(|([x, y, z], w)| [*x, *y, *z, *w])
            .collect();
        node["matrix"] = numbers(&columns);
    } else if at != [0.0; 3] {
        node["translation"] = numbers(&at);
    }
}

/// Returns a frame at a position, its z axis along `back`, upright.
fn frame(at: DVec3, back: DVec3) -> DAffine3 {
    let z = back.normalize();
    let up = if z.y.abs() > 0.99 { DVec3::Z } else { DVec3::Y };
    let x = up.cross(z).normalize();
    DAffine3::from_mat3_translation(DMat3::from_cols(x, z.cross(x), z), at)
}

fn transform(frame: DAffine3) -> Transform {
    Transform::from_columns(
        frame
            .to_cols_array_2d()
            .map(|column| column.map(|value| value as f32)),
    )
}

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

/// Adds a node for each door, mirror and teleport.
fn portals(
    scene: &Scene,
    nodes: &mut Vec<Value>,
    children: &mut [Vec<usize>],
    document: &mut Document,
    streams: &mut Streams,
) -> Result<()> {
    let all = scene.portals();
    let opening = |portal: &Portal| &scene.sector(portal.from).openings()[usize::from(portal.opening.0)];
    let centre = |portal: &Portal| wide(opening(portal).outline.bounds().center());
    let mut written = vec![false; all.len()];
    for (index, portal) in all.iter().enumerate() {
        if std::mem::replace(&mut written[index], true) {
            continue;
        }
        let outline = &opening(portal).outline;
        let normal = wide(outline.normal());
        let to = scene.sector_name(portal.to);
        let mut node = json!({"name": opening(portal).name});
        let corners: Vec<[f32; 3]>;
        let reflection = Transform::reflection(outline.corners()[0], outline.normal());
        if portal.there_from_here == Transform::IDENTITY {
            let back = all.iter().position(|back| {
                back.from == portal.to
                    && back.to == portal.from
                    && back.there_from_here == Transform::IDENTITY
                    && centre(back).distance(centre(portal)) < 1e-3
            });
            written[back.with_context(|| format!("{node} has no way back"))?] = true;
            node["extras"] = json!({"enfilade": {"kind": "portal", "to": to}});
            corners = outline.corners().to_vec();
        } else if portal.from == portal.to && portal.there_from_here == reflection {
            // Several rooms have a mirror 1, but names of a file are unique.
            node["name"] = json!(format!(
                "{}: {}",
                scene.sector_name(portal.from),
                opening(portal).name
            ));
            node["extras"] = json!({"enfilade": {"kind": "mirror"}});
            corners = outline.corners().to_vec();
        } else {
            let here = frame(centre(portal), normal);
            let columns = portal.there_from_here.columns().map(wide);
            let scale = columns[0].length();
            let there_from_here = DAffine3::from_cols(columns[0], columns[1], columns[2], columns[3]);
            let mut there = there_from_here * here;
            there.matrix3 *= 1.0 / scale;
            let exit = format!("{}: exit", opening(portal).name);
            let exit = format!("{}, {exit}", scene.sector_name(portal.from));
            node["extras"] = json!({"enfilade": {"kind": "portal", "to": to, "exit": exit}});
            if (scale - 1.0).abs() > 1e-6 {
                node["extras"]["enfilade"]["scale"] = number(scale as f32);
            }
            place(&mut node, &transform(here));
            let local = here.inverse();
            corners = (outline.corners().iter())
                .map(|&corner| local.transform_point3(wide(corner)).as_vec3().to_array())
                .collect();
            let mut out = json!({"name": exit});
            place(&mut out, &transform(there));
            children[portal.to.0 as usize].push(nodes.len());
            nodes.push(out);
        }
        node["mesh"] = json!(document.push("meshes", streams.polygon(&corners)));
        children[portal.from.0 as usize].push(nodes.len());
        nodes.push(node);
    }
    Ok(())
}

/// Places the node of a light; returns the light.
fn lamp(light: &Light, node: &mut Value) -> Value {
    let direction = light.direction().map_or(DVec3::NEG_Z, wide);
    place(node, &transform(frame(wide(light.position), -direction)));
    if light.direction().is_none() {
        place(node, &Transform::translation(light.position));
        node.as_object_mut().map(|node| node.remove("matrix"));
    }
    let strength = light.color.into_iter().fold(0.0, f32::max);
    let mut source = json!({
        "color": numbers(&light.color.map(|part| part / strength)),
        "intensity": number(strength * PI)});
    if light.range.is_finite() {
        source["range"] = number(light.range);
    }
    match light.shape {
        LightShape::Point => source["type"] = json!("point"),
        LightShape::Sun { .. } => source["type"] = json!("directional"),
        LightShape::Spot { inner, outer, .. } => {
            source["type"] = json!("spot");
            source["spot"] = json!({"innerConeAngle": number(inner), "outerConeAngle": number(outer)});
        }
    }
    source
}

fn lens(camera: &Camera, document: &mut Document) -> Value {
    let near = camera.view([1, 1]).expect("a valid camera").z_near();
    let number = document.push(
        "cameras",
        json!({"type": "perspective", "perspective": {"yfov": number(camera.fov_y), "znear": number(near)}}),
    );
    let mut node = json!({"name": camera.name, "camera": number});
    let [eye, toward] = [camera.eye, camera.toward].map(DVec3::from);
    place(&mut node, &transform(frame(eye, eye - toward)));
    node
}
