//! Reads glTF 2.0 in stages, each of which validates the input of the next.
//!
//! The container, document, extensions, nodes and a plan of every mesh are validated first, and memory is reserved by
//! an estimate; only then are buffers loaded and meshes built, in parallel. Elements that no item uses are not
//! validated.
//! Source: The Khronos Group, glTF 2.0 Specification, 2.0.1.
//! Cost: O(bytes of the file + triangles + nodes), except for `Mesh::new`, which sorts.

mod accessor;
pub(crate) mod address;
mod affected;
mod attributes;
mod below;
mod buffers;
mod camera;
mod compressed;
mod container;
mod deform;
mod document;
mod extensions;
mod hints;
mod ids;
mod instances;
mod lights;
pub(crate) mod link;
mod materials;
mod mesh;
mod meshopt;
mod names;
mod nodes;
mod pin;
mod plan;
mod poses;
mod terrain;
mod textures;
mod topology;

pub(crate) use container::{beginning, begins_like_gltf};
pub(crate) use hints::marks_opening_or_room;
pub(crate) use pin::with_methods;

use crate::budget::Budget;
use crate::faults::Faults;
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, FileScene, Import, NonOccluders, ReadOptions};
use accessor::Row;
use affected::Affected;
use buffers::Buffers;
use container::Container;
use document::Document;
use enfilade::{GeometryError, Material, Mesh, Texture, Transform};
use instances::{InstancePlan, Instances};
use materials::Surface;
use mesh::MeshPlan;
use names::Names;
use nodes::SceneNode;
use plan::Plan;
use poses::{PosedMesh, Poses, SkinPlan, Skins};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use terrain::{TerrainPlan, Terrains};
use textures::TexturePlan;

/// Reads the bytes of a `.glb` or `.gltf` file called `name`; its buffers and images are looked for in `folder`.
pub(crate) fn import(
    bytes: &[u8],
    folder: Option<&Path>,
    name: &str,
    options: &ReadOptions,
    budget: Budget,
) -> Result<Import, BrokenRule> {
    let mut faults = Faults::new(options);
    let import = import_with(bytes, folder, name, options, budget, &mut faults);
    // Authoring errors were found before the error that ended the reading, so they are reported first.
    faults.into_result()?;
    import
}

/// Reads the bytes, and collects authoring errors in `faults`.
fn import_with(
    bytes: &[u8],
    folder: Option<&Path>,
    name: &str,
    options: &ReadOptions,
    mut budget: Budget,
    faults: &mut Faults,
) -> Result<Import, BrokenRule> {
    let mut warnings = Warnings::default();
    let container = Container::split(bytes)?;
    if container.has_zero_length {
        warnings.name(WarningKind::Repaired, || {
            "the header gives a length of 0".to_owned()
        });
    }
    let json = document::repaired(container.json, &mut budget, &mut warnings)?;
    let mut document = Document::parse(&json, &mut budget)?;
    let default_scene = document.scene;
    if let Some(scene) = &options.scene {
        document.choose_scene(scene)?;
    }
    let document = document;
    extensions::check(&document, options.lenient, &mut warnings)?;
    let affected = Affected::by_unread(&document, &json);
    warn_of_the_unread(&document, &mut warnings);
    let plan = Plan::new(&document, options.flat, affected, faults, &mut warnings)?;
    let shown = plan.shown();
    budget.take(shown.len() as u64 * BYTES_PER_NODE, || "the nodes".to_owned())?;
    budget.take(plan.room_count() as u64 * BYTES_PER_ROOM, || {
        "the rooms".to_owned()
    })?;
    let mut surfaces = materials::read(&document, &plan, options.textures)?;

    let poses = Poses::new(&document, shown.iter().map(|placed| placed.node), &mut warnings)?;
    let used = poses.used();
    let skins = SkinPlan::new(&document, &used, &mut budget)?;
    let plans = plan_meshes(&document, &surfaces, &used, options, &mut budget, &mut warnings)?;
    budget.take(mesh::bytes_to_build(&plans), || {
        "the building of meshes".to_owned()
    })?;
    let terrains = TerrainPlan::new(
        &document,
        &plan,
        (&poses, &plans),
        &mut budget,
        faults,
        &mut warnings,
    )?;
    let instances = InstancePlan::new(&document, &plan, &poses, &mut budget, &mut warnings)?;
    let ids = ids::read(&document, shown, &mut budget)?;
    let used_materials = plans.iter().flat_map(MeshPlan::materials).collect();
    let textures = TexturePlan::new(&document, &mut surfaces, &used_materials)?;
    warn_of_surfaces(&surfaces, &used_materials, &mut warnings);

    let of_nodes = || instances.rows().chain(skins.rows());
    let rows = || plans.iter().flat_map(MeshPlan::rows).chain(of_nodes());
    let sources = rows().flat_map(Row::sources).chain(textures.sources());
    let buffers = Buffers::load(&document, sources, container.binary, folder, &mut budget)?;
    let mut checked = BTreeSet::new();
    for row in rows() {
        if row
            .sparse_accessor()
            .is_some_and(|accessor| checked.insert(accessor))
        {
            row.check_sparse(&buffers)?;
        }
    }
    let instances = instances.read(&document, &buffers)?;
    let textures = textures.load(&buffers, folder, &mut budget, &mut warnings);
    let skins = skins.read(&buffers)?;
    let built = build(&plans, &buffers, &skins, &mut warnings)?;
    let non_occluders = surfaces.iter().map(|surface| surface.non_occluder).collect();
    let materials: Vec<Material> = surfaces.into_iter().map(|surface| surface.material).collect();
    let meshes = Meshes { poses, used, built };
    let assets = Assets {
        terrains: terrains.read(&document, &meshes, faults, &mut warnings),
        meshes,
        materials: materials.into(),
        non_occluders: NonOccluders::of_materials(non_occluders),
        textures: textures.into(),
        instances,
        ids,
    };
    let files = match folder {
        Some(folder) => files(&document, folder, &mut budget)?,
        None => Vec::new(),
    };
    let names = Names::of(&document, |node, _| plan.names_meshes(node));
    let (rooms, portals) = plan
        .rooms(name, &assets, &names, faults, &mut budget, &mut warnings)
        .map_err(|why| name_the_node(why, &document, plan.shown(), &names))?;
    let cameras = camera::read(&document, &plan, &rooms, &mut warnings)?;
    let (cameras, orthographic_heights) = cameras.into_iter().unzip();
    let lights = lights::read(&document, &plan, &rooms, &mut warnings)?;
    let triangles = rooms
        .iter()
        .map(|room| room.geometry.triangle_count())
        .sum::<u64>();
    warnings.state(WarningKind::EmptyScene, triangles == 0);
    Ok(Import {
        rooms,
        portals,
        cameras,
        orthographic_heights,
        lights,
        scenes: scenes(&document, default_scene, &mut budget)?,
        map: None,
        warnings: warnings.into_list(),
        files,
    })
}

/// Returns the separate files that buffers and images reference.
fn files(document: &Document, folder: &Path, budget: &mut Budget) -> Result<Vec<PathBuf>, BrokenRule> {
    let images = images(document);
    let buffers = document.buffers.iter().map(|buffer| &buffer.uri);
    let named = buffers.chain(images.iter().map(|image| &image.uri));
    let files = named.filter_map(|uri| address::file(uri, folder));
    // Whoever saves something compares it with each of these paths.
    let affordable = files.map(|file| {
        let bytes = 2 * (file.as_os_str().len() + 2 * size_of::<PathBuf>()) as u64;
        budget.take(bytes, || "the names of its files".to_owned())?;
        Ok(file)
    });
    affordable.collect()
}

/// Returns the names of the scenes; `default` is the index of the one that the file names.
fn scenes(
    document: &Document,
    default: Option<u32>,
    budget: &mut Budget,
) -> Result<Vec<FileScene>, BrokenRule> {
    let read = document.scene_number();
    let scenes = (0..).zip(&document.scenes).map(|(number, scene)| {
        let bytes = 2 * size_of::<FileScene>() + scene.name.len();
        budget.take(bytes as u64, || "the names of its scenes".to_owned())?;
        Ok(FileScene {
            name: scene.name.to_string(),
            is_default: default == Some(number),
            is_read: read == Some(number),
        })
    });
    scenes.collect()
}

/// Checks the used meshes and reserves their memory.
fn plan_meshes(
    document: &Document,
    surfaces: &[Surface],
    used: &[PosedMesh],
    options: &ReadOptions,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Vec<MeshPlan>, BrokenRule> {
    let mut plans: Vec<MeshPlan> = Vec::with_capacity(used.len());
    for &posed in used {
        // Of several poses of a mesh only the first is warned of.
        let mut repeated = Warnings::default();
        let is_first = plans
            .last()
            .is_none_or(|before| before.posed().mesh != posed.mesh);
        let warnings = if is_first { &mut *warnings } else { &mut repeated };
        let plan = MeshPlan::new(document, surfaces, posed, options.lenient, budget, warnings);
        plans.push(plan?);
    }
    Ok(plans)
}

/// Returns the images of the document; none if the list is invalid, since then none is read.
fn images<'a>(document: &Document<'a>) -> Vec<document::Image<'a>> {
    document::list(document.images, "images").unwrap_or_default()
}

/// Builds meshes in parallel.
fn build(
    plans: &[MeshPlan],
    buffers: &Buffers,
    skins: &Skins,
    warnings: &mut Warnings,
) -> Result<Vec<PlacedMesh>, BrokenRule> {
    let mut meshes = Vec::with_capacity(plans.len());
    for batch in mesh::batches(plans) {
        let built: Vec<_> = batch.par_iter().map(|plan| plan.build(buffers, skins)).collect();
        // In order, so that of several broken meshes the first is named, whichever thread finishes first.
        for built in built {
            let built = built?;
            for (kind, place) in built.oddities {
                warnings.name(kind, || place);
            }
            meshes.push(PlacedMesh {
                mesh: Arc::new(built.mesh),
                world: built.origin.map(Transform::translation),
            });
        }
    }
    Ok(meshes)
}

/// Everything that rooms are built from.
struct Assets {
    meshes: Meshes,
    materials: Arc<[Material]>,
    /// Why materials hide nothing; without items.
    non_occluders: NonOccluders,
    textures: Arc<[Arc<Texture>]>,
    instances: Instances,
    terrains: Terrains,
    /// Ids of nodes in other programs, by node.
    ids: BTreeMap<u32, String>,
}

/// The meshes that nodes of the scene use.
struct Meshes {
    /// The mesh of each node.
    poses: Poses,
    /// Meshes and their poses, increasing.
    used: Vec<PosedMesh>,
    built: Vec<PlacedMesh>,
}

/// A mesh in a pose.
struct PlacedMesh {
    mesh: Arc<Mesh>,
    /// Its transform if it is skinned; otherwise it has that of its node.
    world: Option<Transform>,
}

impl Meshes {
    /// Returns a used mesh in its pose.
    fn get(&self, posed: PosedMesh) -> &PlacedMesh {
        &self.built[self.used.partition_point(|&before| before < posed)]
    }

    /// Returns the mesh of a node in its pose.
    fn of(&self, node: u32) -> Option<PosedMesh> {
        self.poses.of(node)
    }
}

/// Approximate memory of a node while it becomes an item, in bytes.
const BYTES_PER_NODE: u64 = 400;
/// Approximate memory of a room, which is built twice, in bytes.
const BYTES_PER_ROOM: u64 = 800;

/// Adds warnings for top-level elements of the document that are not read.
fn warn_of_the_unread(document: &Document, warnings: &mut Warnings) {
    warnings.count(WarningKind::OtherScenes, document.scenes.len().saturating_sub(1));
    warnings.count(WarningKind::Animations, document.animations.len());
    let images = images(document);
    let buffers = document.buffers.iter().map(|buffer| &buffer.uri).enumerate();
    let images = images.iter().map(|image| &image.uri).enumerate();
    let named = buffers
        .map(|uri| ("buffer", uri))
        .chain(images.map(|uri| ("image", uri)));
    for (kind, (number, _)) in named.filter(|(_, (_, uri))| address::has_backslash(uri)) {
        warnings.name(WarningKind::Repaired, || {
            format!("{kind} {number} has \\ for / in its uri")
        });
    }
}

/// Adds warnings for properties of used materials that are not drawn.
fn warn_of_surfaces(surfaces: &[Surface], used: &BTreeSet<u32>, warnings: &mut Warnings) {
    for &number in used {
        let surface = &surfaces[number as usize];
        warnings.count(WarningKind::OtherMaps, surface.other_maps);
        if surface.lost_emission {
            warnings.name(WarningKind::EmissionElsewhere, || format!("material {number}"));
        }
    }
}

/// Replaces the item in a geometry error by its node.
fn name_the_node(why: BrokenRule, document: &Document, placed: &[SceneNode], names: &Names) -> BrokenRule {
    let (name, rule): (_, fn(String) -> BrokenRule) = match &why {
        BrokenRule::Geometry(GeometryError::NotFinite(item)) => (&item.name, BrokenRule::NodeNotFinite),
        BrokenRule::Geometry(GeometryError::TooFar(item)) => (&item.name, BrokenRule::NodeTooFar),
        _ => return why,
    };
    let is_meant =
        |placed: &&SceneNode| names.name(placed.node, &document.nodes[placed.node as usize]) == *name;
    match placed.iter().find(is_meant) {
        Some(placed) => rule(document.node_name(placed.node)),
        None => why,
    }
}
