//! Textures: finds the images and samplers that used materials reference, and decodes the images.
//!
//! A texture here is an image with a sampler; duplicates in the document are merged. The references are checked before
//! buffers are loaded; images are decoded afterwards, in parallel. An image that cannot be read becomes grey.
//! Source: glTF 2.0 Specification, section 3.8.

use super::accessor::StridedRange;
use super::address::fetch_all;
use super::buffers::{Buffers, Source};
use super::document::{self, Document, Image, Sampler, find, list, short};
use super::materials::Surface;
use crate::BrokenRule;
use crate::budget::Budget;
use crate::images::{self, Encoded};
use crate::warning::{WarningKind, Warnings};
use enfilade::{Filter, Minify, Texture, TextureId, Wrap};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

/// The textures of the used materials.
pub(super) struct TexturePlan<'d> {
    /// By [`TextureId`]: the index of an image in `images`, and its sampler state.
    textures: Vec<(usize, Lookup)>,
    images: Vec<ImagePlan<'d>>,
}

/// Sampler state: wrap modes and filters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Lookup {
    wrap: [Wrap; 2],
    magnify: Filter,
    minify: Minify,
}

struct ImagePlan<'d> {
    name: String,
    /// Name of the image in messages.
    place: String,
    bytes: Bytes<'d>,
}

/// Location of an encoded image.
enum Bytes<'d> {
    View(StridedRange, u64),
    Address(Cow<'d, str>),
    Nowhere(&'static str),
}

impl<'d> TexturePlan<'d> {
    /// Assigns ids to the textures of used materials and stores them in the materials.
    pub(super) fn new(
        document: &Document<'d>,
        surfaces: &mut [Surface],
        used: &BTreeSet<u32>,
    ) -> Result<TexturePlan<'d>, BrokenRule> {
        let mut plan = TexturePlan {
            textures: Vec::new(),
            images: Vec::new(),
        };
        let names_one = |surface: &Surface| surface.texture.or(surface.emission_texture).is_some();
        if !used.iter().any(|&number| names_one(&surfaces[number as usize])) {
            return Ok(plan);
        }
        let mut lists = Lists {
            textures: list(document.textures, "textures")?,
            samplers: list(document.samplers, "samplers")?,
            images: list(document.images, "images")?,
            numbers: BTreeMap::new(),
            image_places: BTreeMap::new(),
            here: Vec::new(),
        };
        for &number in used {
            let surface = &mut surfaces[number as usize];
            let place = || format!("material {number}");
            if let Some(texture) = surface.texture {
                surface.material.texture = Some(plan.texture(document, &mut lists, texture, place)?);
            }
            if let Some(texture) = surface.emission_texture {
                let texture = plan.texture(document, &mut lists, texture, place)?;
                surface.material.emission_texture = Some(texture);
            }
        }
        Ok(plan)
    }

    /// Returns the id of a texture of the document.
    fn texture(
        &mut self,
        document: &Document,
        lists: &mut Lists<'d>,
        number: u32,
        user: impl FnOnce() -> String,
    ) -> Result<TextureId, BrokenRule> {
        if let Some(known) = lists.numbers.get(&number) {
            return Ok(*known);
        }
        let texture = find(&lists.textures, number, "texture", user)?;
        let place = || format!("texture {number}");
        let lookup = match texture.sampler {
            Some(sampler) => lookup(sampler, find(&lists.samplers, sampler, "sampler", place)?)?,
            None => Lookup::default(),
        };
        let image = match texture.source {
            Some(source) => match lists.image_places.get(&source) {
                Some(known) => *known,
                None => {
                    let image = find(&lists.images, source, "image", place)?;
                    self.images.push(ImagePlan::new(document, source, image)?);
                    lists.image_places.insert(source, self.images.len() - 1);
                    self.images.len() - 1
                }
            },
            None => {
                self.images.push(ImagePlan {
                    name: short(&texture.name),
                    place: place(),
                    bytes: Bytes::Nowhere("it has no image, or one of an unsupported format"),
                });
                self.images.len() - 1
            }
        };
        // An image has few different samplers, so a linear search is fast.
        lists.here.resize_with(self.images.len(), Vec::new);
        let known = lists.here[image].iter().find(|(known, _)| *known == lookup);
        let here = known.map_or(TextureId(self.textures.len() as u32), |(_, here)| *here);
        if here.0 as usize == self.textures.len() {
            self.textures.push((image, lookup));
            lists.here[image].push((lookup, here));
        }
        lists.numbers.insert(number, here);
        Ok(here)
    }

    /// Returns the buffers that hold images.
    pub(super) fn sources(&self) -> impl Iterator<Item = Source> {
        self.images.iter().filter_map(|image| match &image.bytes {
            Bytes::View(stretch, _) => Some(stretch.source),
            _ => None,
        })
    }

    /// Reads and decodes the images.
    pub(super) fn load(
        self,
        buffers: &Buffers,
        folder: Option<&Path>,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Vec<Arc<Texture>> {
        let mut encoded = Vec::with_capacity(self.images.len());
        for ImagePlan { name, place, bytes } in self.images {
            let bytes = match bytes {
                Bytes::View(stretch, length) => {
                    let (bytes, _) = stretch.bytes(buffers);
                    Ok(Cow::Borrowed(&bytes[..length as usize]))
                }
                Bytes::Address(uri) => fetch_all(&uri, &place, folder, budget)
                    .map(Cow::Owned)
                    .map_err(|why| why.to_string()),
                Bytes::Nowhere(why) => Err(format!("{place}: {why}")),
            };
            encoded.push(Encoded { bytes, name, place });
        }
        let mut images: Vec<Option<Texture>> = images::decode_all(encoded, budget, warnings)
            .into_iter()
            .map(Some)
            .collect();
        let mut uses = vec![0_usize; images.len()];
        self.textures.iter().for_each(|(image, _)| uses[*image] += 1);
        let mut textures = Vec::with_capacity(self.textures.len());
        for (image, lookup) in self.textures {
            uses[image] -= 1;
            let texels = if uses[image] == 0 {
                images[image].take()
            } else {
                copied(images[image].as_ref(), budget, warnings)
            };
            let mut texture = texels.unwrap_or_else(|| images::grey("texture"));
            (texture.wrap, texture.magnify, texture.minify) = (lookup.wrap, lookup.magnify, lookup.minify);
            textures.push(Arc::new(texture));
        }
        textures
    }
}

/// The parsed lists of the document, and the ids assigned so far.
struct Lists<'d> {
    textures: Vec<document::Texture<'d>>,
    samplers: Vec<Sampler>,
    images: Vec<Image<'d>>,
    /// Ids by texture index of the document.
    numbers: BTreeMap<u32, TextureId>,
    /// Indices in `images` of the plan, by image index of the document.
    image_places: BTreeMap<u32, usize>,
    /// The textures of each image, by its index in `images` of the plan.
    here: Vec<Vec<(Lookup, TextureId)>>,
}

/// Returns a copy of an image for another sampler; grey if the budget does not allow it.
fn copied(image: Option<&Texture>, budget: &mut Budget, warnings: &mut Warnings) -> Option<Texture> {
    let image = image?;
    if budget.take(image.bytes(), String::new).is_ok() {
        return Some(image.clone());
    }
    warnings.name(WarningKind::BadImages, || {
        format!(
            "{}: a copy for another sampler needs more memory than is allowed",
            image.name
        )
    });
    Some(images::grey(&image.name))
}

impl<'d> ImagePlan<'d> {
    fn new(document: &Document, number: u32, image: &Image<'d>) -> Result<ImagePlan<'d>, BrokenRule> {
        let place = match &*image.name {
            "" => format!("image {number}"),
            name => format!("image {number} {:?}", short(name)),
        };
        let bytes = match image.buffer_view {
            Some(view) => {
                let (stretch, length) = StridedRange::whole_view(document, view, || place.clone())?;
                Bytes::View(stretch, length)
            }
            None if image.uri.is_empty() => Bytes::Nowhere("it has neither a uri nor a bufferView"),
            None => Bytes::Address(image.uri.clone()),
        };
        let is_file = !image.uri.is_empty() && !image.uri.starts_with("data:");
        let name = match &*image.name {
            "" if is_file => short(&image.uri),
            "" => format!("image#{number}"),
            name => short(name),
        };
        Ok(ImagePlan { name, place, bytes })
    }
}

/// Converts a sampler. Source: glTF 2.0 Specification, section 5.26.
fn lookup(number: u32, sampler: &Sampler) -> Result<Lookup, BrokenRule> {
    let bad = |what, value| BrokenRule::BadSampler {
        place: format!("sampler {number}"),
        what,
        value,
    };
    let wrap = |what, value: Option<u32>| match value {
        None | Some(10_497) => Ok(Wrap::Repeat),
        Some(33_648) => Ok(Wrap::Mirror),
        Some(33_071) => Ok(Wrap::Clamp),
        Some(value) => Err(bad(what, value)),
    };
    let between = |texels, levels| Ok(Minify { texels, levels });
    Ok(Lookup {
        wrap: [wrap("wrapS", sampler.wrap_s)?, wrap("wrapT", sampler.wrap_t)?],
        magnify: match sampler.mag_filter {
            Some(9728) => Ok(Filter::Nearest),
            None | Some(9729) => Ok(Filter::Linear),
            Some(value) => Err(bad("magFilter", value)),
        }?,
        minify: match sampler.min_filter {
            None => Ok(Minify::default()),
            Some(9728) => between(Filter::Nearest, None),
            Some(9729) => between(Filter::Linear, None),
            Some(9984) => between(Filter::Nearest, Some(Filter::Nearest)),
            Some(9985) => between(Filter::Linear, Some(Filter::Nearest)),
            Some(9986) => between(Filter::Nearest, Some(Filter::Linear)),
            Some(9987) => between(Filter::Linear, Some(Filter::Linear)),
            Some(value) => Err(bad("minFilter", value)),
        }?,
    })
}
