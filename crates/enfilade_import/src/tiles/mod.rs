//! Reads tiles of 3D Tiles 1.0: Batched 3D Models (`.b3dm`) and Instanced 3D Models (`.i3dm`).
//!
//! `header` finds the tables and the model, `features` reads the feature table, `instances` computes transforms, and `place`
//! puts the model at them. Batch tables hold properties, which are not read.
//! Tiles have z up and their models y up. The scene keeps the y up of the model: x stays x, the tile's z becomes y, and its y
//! becomes −z.
//! Source: Open Geospatial Consortium, 3D Tiles Specification 1.0, 18-053r2; for the two older headers of `.b3dm`, the
//! behaviour of CesiumJS.
//! Cost: that of the model, and O(instances · items).
//! Hostile input: every length is checked against the file, and memory is reserved for instances before they are read.

mod error;
mod features;
mod header;
mod instances;
mod place;

pub use error::TileError;

use crate::budget::Budget;
use crate::gltf::address::fetch_all;
use crate::warning::{WarningKind, Warnings};
use crate::{BrokenRule, Import, ReadOptions, gltf};
use enfilade::Transform;
use features::FeatureTable;
use header::{Header, Model};
use instances::Instances;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

impl From<TileError> for BrokenRule {
    fn from(why: TileError) -> BrokenRule {
        BrokenRule::Tile(Box::new(why))
    }
}

/// Returns `true` if the bytes begin like a tile.
pub(crate) fn begins_like_tile(bytes: &[u8]) -> bool {
    bytes.starts_with(header::BATCHED) || bytes.starts_with(header::INSTANCED)
}

/// Reads the bytes of a tile called `name`; buffers, images and a separate model are looked for in `folder`.
pub(crate) fn import(
    bytes: &[u8],
    folder: Option<&Path>,
    name: &str,
    options: &ReadOptions,
    mut budget: Budget,
) -> Result<Import, BrokenRule> {
    let header = Header::read(bytes)?;
    let features = FeatureTable::read(header.features, header.feature_bytes, &mut budget)?;
    let mut warnings = Warnings::default();
    let transforms = match header.model {
        Model::Single(_) => {
            let center = features.center()?.unwrap_or_default();
            Instances::single(center)
        }
        Model::Embedded(_) | Model::Separate(_) => Instances::read(&features, &mut budget)?,
    };
    if let Some(origin) = transforms.left_out {
        let place = origin.map(|part| part.to_string()).join(", ");
        warnings.name(WarningKind::FarOrigin, || place);
    }
    let model = match header.model {
        Model::Single(model) | Model::Embedded(model) => FetchedModel::embedded(model, folder),
        Model::Separate(uri) => FetchedModel::fetch(uri, folder, &mut budget)?,
    };
    // A room is a place of its own, but a model may be at many.
    let options = ReadOptions {
        flat: true,
        ..options.clone()
    };
    let folder = model.folder.as_deref();
    let mut import = gltf::import(&model.bytes, folder, name, &options, budget.clone())?;
    import.files.extend(model.path);
    if transforms.is_moved() {
        place::place(&mut import, &transforms, &mut budget)?;
    }
    import.warnings.extend(warnings.into_list());
    import.warnings.sort_by_key(|warning| warning.kind);
    Ok(import)
}

/// The bytes of a model, and the folder of its files.
struct FetchedModel<'b> {
    bytes: Cow<'b, [u8]>,
    folder: Option<Cow<'b, Path>>,
    path: Option<PathBuf>,
}

impl<'b> FetchedModel<'b> {
    fn embedded(bytes: &'b [u8], folder: Option<&'b Path>) -> FetchedModel<'b> {
        FetchedModel {
            bytes: Cow::Borrowed(bytes),
            folder: folder.map(Cow::Borrowed),
            path: None,
        }
    }

    /// Reads a model in a file of its own, inside the folder of the tile.
    fn fetch(
        uri: &[u8],
        folder: Option<&'b Path>,
        budget: &mut Budget,
    ) -> Result<FetchedModel<'b>, BrokenRule> {
        let uri = String::from_utf8_lossy(uri);
        // Writers pad it with spaces or zeros.
        let uri = uri.trim_end_matches(['\0', ' ']);
        let bytes = fetch_all(uri, "its model", folder, budget)?;
        let path = folder.and_then(|folder| gltf::address::file(uri, folder));
        let beside = path.as_deref().and_then(Path::parent);
        Ok(FetchedModel {
            bytes: Cow::Owned(bytes),
            folder: beside.map(|folder| Cow::Owned(folder.to_owned())),
            path,
        })
    }
}

/// Returns the transform of the scene from the axes of a tile: a quarter turn about x.
fn scene_from_tile() -> Transform {
    Transform::from_columns([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.0; 3]])
}
