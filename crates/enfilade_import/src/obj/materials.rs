//! Converts MTL materials, and loads their images.
//!
//! OBJ has no back-face culling, so every material is double-sided. `Kd` and `Ke` are linear, as in Blender. They
//! multiply the image, except where they are black, because a completely black image is never intended. Alpha maps give
//! alpha test, because they are used for leaves and fences; `d` and `Tr` give alpha blend.

use super::files::InnerPath;
use super::groups::Groups;
use super::mtl::{self, Entry, Map};
use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use crate::{NonOccluder, images};
use enfilade::{Alpha, Material, Texture, TextureId, Wrap};
use std::collections::hash_map::Entry::{Occupied, Vacant};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The materials of a file.
#[derive(Debug, Default)]
pub(super) struct Materials {
    /// One per name in [`Groups::materials`], followed by the default material.
    pub(super) materials: Vec<Material>,
    /// Why each hides nothing, if its alpha mode does not tell.
    pub(super) non_occluders: Vec<Option<NonOccluder>>,
    pub(super) textures: Vec<Arc<Texture>>,
    /// Texture coordinate transform of each material; `None` if it has no image.
    pub(super) placings: Vec<Option<Placing>>,
    /// The material files and the images that they reference.
    pub(super) files: Vec<PathBuf>,
}

/// Transform from the file's texture coordinates to those of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placing {
    scale: [f32; 2],
    offset: [f32; 2],
}

impl Placing {
    /// Transforms texture coordinates. V points up in OBJ and down in Enfilade. Overflow gives 0.
    pub(super) fn place(&self, at: [f32; 2]) -> [f32; 2] {
        let [u, v] = [0, 1].map(|axis| at[axis] * self.scale[axis] + self.offset[axis]);
        let place = [u, 1.0 - v];
        if place.iter().all(|value| value.is_finite()) {
            place
        } else {
            [0.0; 2]
        }
    }
}

/// Color of undefined materials: the same grey as unreadable images, in linear space.
const GREY: [f32; 3] = [0.215_860_5; 3];
/// Memory of a parsed MTL line, as a multiple of its length.
const TIMES_ITS_LENGTH: u64 = 40;

impl Materials {
    /// Reads the used materials. Without `with_images`, no image is read or referenced.
    pub(super) fn read(
        groups: &Groups,
        folder: Option<&Path>,
        with_images: bool,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Materials {
        let mut files = BTreeSet::new();
        let library = Library::load(&groups.libraries, folder, budget, warnings, &mut files);
        let mut reader = Reader {
            folder,
            with_images,
            found: Materials {
                files: files.into_iter().collect(),
                ..Materials::default()
            },
            known: HashMap::new(),
            budget,
            warnings,
        };
        for name in &groups.materials {
            match library.0.get(name) {
                Some((entry, here)) => reader.add(entry, here),
                None => {
                    reader
                        .warnings
                        .name(WarningKind::UnknownMaterials, || match &**name {
                            "" => "(no name)".to_owned(),
                            name => name.to_owned(),
                        });
                    let grey = Material {
                        alpha: Alpha::Mask,
                        cutoff: 0.0,
                        ..Material::opaque(GREY)
                    };
                    reader.push(grey, Some(NonOccluder::MaterialUnread), None);
                }
            }
        }
        reader.push(Material::opaque([1.0; 3]), None, None);
        reader.found
    }
}

/// Memory of the name of a file, beside its path, in bytes.
const BYTES_PER_FILE: u64 = 160;

/// All materials of all files, by name, each with its file.
struct Library(HashMap<String, (Entry, InnerPath)>);

impl Library {
    fn load(
        statements: &[String],
        folder: Option<&Path>,
        budget: &mut Budget,
        warnings: &mut Warnings,
        named: &mut BTreeSet<PathBuf>,
    ) -> Library {
        let mut library: HashMap<String, (Entry, InnerPath)> = HashMap::new();
        let mut read = HashSet::new();
        let top = InnerPath::default();
        for file in statements.iter().flat_map(|names| files(names, folder)) {
            let here = InnerPath::of(file, &top);
            if !read.insert(here.clone()) {
                continue;
            }
            let path = here.path(folder);
            let length = path.as_ref().map_or(0, |path| path.as_os_str().len() as u64);
            if budget
                .take(2 * length + BYTES_PER_FILE, || here.spoken())
                .is_err()
            {
                warnings.name(WarningKind::MaterialFiles, || {
                    format!("{file}: it would exceed the memory limit")
                });
                break;
            }
            named.extend(path);
            let bytes = here.read(folder, budget).and_then(|bytes| {
                budget
                    .take(TIMES_ITS_LENGTH * bytes.len() as u64, || here.spoken())
                    .map_err(|why| why.to_string())?;
                Ok(bytes)
            });
            match bytes {
                Ok(bytes) => {
                    for entry in mtl::parse(&bytes, &here.spoken(), warnings) {
                        let maps = [&entry.diffuse_map, &entry.emission_map, &entry.coverage_map];
                        let images = maps
                            .into_iter()
                            .flatten()
                            .map(|map| InnerPath::of(&map.file, &here));
                        named.extend(images.filter_map(|image| image.path(folder)));
                        // If several materials share a name, the first is drawn; it hides only if all are opaque.
                        match library.entry(entry.name.clone()) {
                            Occupied(mut known) if known.get().0.hides() && !entry.hides() => {
                                warnings.name(WarningKind::MaterialLines, || {
                                    format!("{} is defined twice: the first is drawn", entry.name)
                                });
                                known.get_mut().0.doubt(NonOccluder::MaterialUnread);
                            }
                            Occupied(_) => {}
                            Vacant(free) => {
                                free.insert((entry, here.clone()));
                            }
                        }
                    }
                }
                Err(why) => warnings.name(WarningKind::MaterialFiles, || format!("{file}: {why}")),
            }
        }
        Library(library)
    }
}

/// Returns the files of an `mtllib` line: a single name that may contain spaces, or several.
fn files<'s>(names: &'s str, folder: Option<&Path>) -> Vec<&'s str> {
    let names = names.trim_matches('"');
    if InnerPath::of(names, &InnerPath::default()).exists(folder) {
        return vec![names];
    }
    // Split after every `.mtl` that is followed by a space.
    let mut files = Vec::new();
    let mut start = 0;
    for (at, ending) in names.to_ascii_lowercase().match_indices(".mtl ") {
        let end = at + ending.len() - 1;
        files.push(names[start..end].trim());
        start = end;
    }
    files.push(names[start..].trim());
    files
}

struct Reader<'r> {
    folder: Option<&'r Path>,
    with_images: bool,
    found: Materials,
    /// Images already read, by file and whether they are clamped.
    known: HashMap<(InnerPath, bool), TextureId>,
    budget: &'r mut Budget,
    warnings: &'r mut Warnings,
}

impl Reader<'_> {
    fn push(&mut self, material: Material, non_occluder: Option<NonOccluder>, placing: Option<Placing>) {
        self.found.materials.push(Material {
            double_sided: true,
            ..material
        });
        self.found.non_occluders.push(non_occluder);
        self.found.placings.push(placing);
    }

    fn add(&mut self, entry: &Entry, here: &InnerPath) {
        let coverage = self.coverage(entry);
        let base = entry.diffuse.unwrap_or([1.0; 3]);
        let maps = [&entry.diffuse_map, &entry.emission_map].map(Option::as_ref);
        let [diffuse, emission] = maps.map(|map| map.filter(|_| self.with_images));
        let [r, g, b] = lit(base, maps[0].is_some()).map(|value| value.min(1.0));
        let placing = |map: &Map| Placing {
            scale: map.scale,
            offset: map.offset,
        };
        if let (Some(diffuse), Some(emission)) = (diffuse, emission)
            && placing(diffuse) != placing(emission)
        {
            self.warnings.name(WarningKind::MaterialLines, || {
                format!("{}: map_Ke has other options than map_Kd", entry.name)
            });
        }
        let material = Material {
            base_color: [r, g, b, coverage],
            texture: diffuse.map(|map| self.texture(map, here)),
            emission: lit(entry.emission.unwrap_or_default(), emission.is_some()),
            emission_texture: emission.map(|map| self.texture(map, here)),
            alpha: self.alpha(entry, coverage, here),
            ..Material::opaque([r, g, b])
        };
        self.push(
            material,
            entry.why_no_occluder(),
            diffuse.or(emission).map(placing),
        );
    }

    /// Returns the opacity of a material.
    fn coverage(&mut self, entry: &Entry) -> f32 {
        let by_transparency = entry.transparency.map(|through| 1.0 - through);
        if let (Some(d), Some(other)) = (entry.coverage, by_transparency)
            && (d - other).abs() > 0.01
        {
            // Some programs write `Tr` with the meaning of `d`, so `d` wins.
            self.warnings.name(WarningKind::MaterialLines, || {
                format!("{}: Tr contradicts d, which is used", entry.name)
            });
        }
        entry.opacity()
    }

    /// Returns the alpha mode. It must not depend on whether images are read, because it decides whether faces occlude.
    fn alpha(&mut self, entry: &Entry, coverage: f32, here: &InnerPath) -> Alpha {
        let image = |map: &Map| InnerPath::of(&map.file, here);
        if let Some(map) = &entry.coverage_map
            && entry.diffuse_map.as_ref().map(image) != Some(image(map))
        {
            self.warnings.name(WarningKind::MaterialLines, || {
                format!("{}: map_d is ignored: its image differs from map_Kd", entry.name)
            });
        }
        match entry.why_no_occluder() {
            _ if coverage < 1.0 => Alpha::Blend,
            None => Alpha::Opaque,
            Some(_) => Alpha::Mask,
        }
    }

    /// Loads an image, or returns its id if it is already loaded.
    fn texture(&mut self, map: &Map, here: &InnerPath) -> TextureId {
        let file = InnerPath::of(&map.file, here);
        let next = TextureId(self.found.textures.len() as u32);
        let id = *self.known.entry((file.clone(), map.clamp)).or_insert(next);
        if id == next {
            let name = file.spoken();
            let mut texture = match file.read(self.folder, self.budget) {
                Ok(bytes) => images::decode(&bytes, &name, &name, self.budget, self.warnings),
                Err(why) => {
                    self.warnings
                        .name(WarningKind::BadImages, || format!("{name}: {why}"));
                    images::grey(&name)
                }
            };
            if map.clamp {
                texture.wrap = [Wrap::Clamp; 2];
            }
            self.found.textures.push(Arc::new(texture));
        }
        id
    }
}

/// Returns the color that multiplies an image: white instead of black.
fn lit(color: [f32; 3], has_image: bool) -> [f32; 3] {
    if has_image && color == [0.0; 3] {
        [1.0; 3]
    } else {
        color
    }
}
