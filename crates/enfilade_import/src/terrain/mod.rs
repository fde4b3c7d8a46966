//! Terrain: a file of heights, and a JSON file beside it that describes it; and meshes that are grids of heights.
//!
//! ```json
//! {
//!     "width": 403, "height": 344,
//!     "format": "u16 little endian",
//!     "cellMetresX": 74.4, "cellMetresZ": 92.67,
//!     "file": "heights.raw"
//! }
//! ```
//!
//! `width` heights from west to east, `height` rows of them, the northern first, each a number of 16 bits without sign, in
//! metres. `noData` is the number that stands for a hole, if one does. Without `file` the heights are in the only file beside it
//! that is called as it is, or begins so, and ends in `.raw`. `diagonal` says where the diagonal of each cell begins:
//! `north-east`, as where it is left out, or `north-west`. `method` says how it is to be seen, if it is there. Other keys are
//! comments.
//! Source: ours.
//! Cost: O(heights).
//! Hostile: what is said of the heights is held against their file before anything is set aside.

mod error;
mod files;
pub(crate) mod grid;

pub use error::TerrainError;
pub use grid::{GridError, GridPlace};

use crate::budget::Budget;
use crate::{BrokenRule, Import, ReadOptions, Room, read_regular_file};
use enfilade::{ContentBuilder, Diagonal, HeightField, Material, MaterialId, Method, Transform};
use serde::Deserialize;
use std::path::Path;
use std::sync::Arc;

/// What the JSON file says.
#[derive(Debug, Deserialize)]
struct Description {
    width: u32,
    height: u32,
    format: String,
    #[serde(rename = "cellMetresX")]
    cell_x: f64,
    #[serde(rename = "cellMetresZ")]
    cell_z: f64,
    #[serde(rename = "noData")]
    no_data: Option<u16>,
    file: Option<String>,
    method: Option<String>,
    #[serde(default)]
    diagonal: Corner,
}

/// Where the diagonal of each cell begins.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Corner {
    #[default]
    NorthEast,
    NorthWest,
}

impl From<Corner> for Diagonal {
    fn from(corner: Corner) -> Diagonal {
        match corner {
            Corner::NorthEast => Diagonal::NorthEast,
            Corner::NorthWest => Diagonal::NorthWest,
        }
    }
}

/// A description is no longer than this.
const LONGEST: usize = 1 << 16;

/// Are bytes JSON that describes terrain, and not glTF?
pub(crate) fn describes_terrain(bytes: &[u8]) -> bool {
    /// By what each of the two is told.
    #[derive(Deserialize)]
    struct Keys {
        asset: Option<serde::de::IgnoredAny>,
        width: Option<serde::de::IgnoredAny>,
        #[serde(rename = "cellMetresX")]
        cell_x: Option<serde::de::IgnoredAny>,
    }
    bytes.len() <= LONGEST
        && serde_json::from_slice::<Keys>(bytes)
            .is_ok_and(|keys| keys.asset.is_none() && (keys.width.is_some() || keys.cell_x.is_some()))
}

/// Reads terrain of which a JSON file called `name` says what its heights are, which lie in `folder`.
pub(crate) fn import(
    bytes: &[u8],
    folder: Option<&Path>,
    name: &str,
    _options: &ReadOptions,
    mut budget: Budget,
) -> Result<Import, BrokenRule> {
    let description: Description =
        serde_json::from_slice(bytes).map_err(|why| TerrainError::Description(why.to_string()))?;
    let is_big_endian = description.is_big_endian()?;
    let method = description.method()?;
    let folder = folder.ok_or(TerrainError::NoFolder)?;
    let path = files::heights_of(&description.file, folder, name)?;
    let samples = u64::from(description.width) * u64::from(description.height);
    let in_file = |why| TerrainError::File {
        file: path.display().to_string(),
        why: Box::new(why),
    };
    let has = std::fs::metadata(&path)
        .map_err(|why| in_file(BrokenRule::Unreadable(why)))?
        .len();
    let needs = samples.saturating_mul(2);
    if has != needs {
        return Err(TerrainError::Length {
            file: path.display().to_string(),
            size: [description.width, description.height],
            needs,
            has,
        }
        .into());
    }
    budget.take(samples.saturating_mul(BYTES_OF_SAMPLE), || {
        format!("terrain of {samples} heights")
    })?;
    let raw = read_regular_file(&path, None, &|| "its heights".to_owned(), &mut budget).map_err(in_file)?;
    let heights = description.heights(&raw, is_big_endian)?;
    let field = HeightField::new(
        [description.width, description.height],
        [description.cell_x, description.cell_z],
        heights,
    )
    .map_err(TerrainError::Field)?
    .cut_along(description.diagonal.into());

    let ground = Material {
        double_sided: true,
        ..Material::opaque(GROUND)
    };
    let mut content = ContentBuilder::new([ground]);
    content
        .terrain("block", field, MaterialId(0), Transform::IDENTITY)
        .map_err(BrokenRule::Content)?;
    let content = Arc::new(content.build().map_err(BrokenRule::Content)?);
    Ok(Import {
        rooms: vec![Room {
            name: name.to_owned(),
            content,
            method,
        }],
        portals: Vec::new(),
        cameras: Vec::new(),
        lights: Vec::new(),
        map: None,
        warnings: Vec::new(),
    })
}

/// A copy of a description that says by which method the terrain is to be seen.
pub(crate) fn with_method(bytes: &[u8], method: Method) -> Result<Vec<u8>, BrokenRule> {
    let mut json: serde_json::Value =
        serde_json::from_slice(bytes).map_err(|why| TerrainError::Description(why.to_string()))?;
    json["method"] = method.name().into();
    Ok(format!("{json:#}\n").into_bytes())
}

/// Dry grass.
const GROUND: [f32; 3] = [0.32, 0.36, 0.17];

/// What a height takes: as a number, as a corner of two to four blocks with its normal, as two triangles.
const BYTES_OF_SAMPLE: u64 = 4 + 30 + 2 * 40;

impl Description {
    /// Which byte of a height comes first; heights that are no numbers of 16 bits without sign are not read.
    fn is_big_endian(&self) -> Result<bool, TerrainError> {
        let words: Vec<String> = self
            .format
            .split(|c: char| !c.is_alphanumeric())
            .map(str::to_lowercase)
            .collect();
        let has = |word: &str| words.iter().any(|one| one == word);
        let is_short = has("u16") || has("uint16") || has("u16le") || has("u16be");
        let little = has("little") || has("u16le");
        let big = has("big") || has("u16be");
        if !is_short || little == big {
            return Err(TerrainError::Format(self.format.clone()));
        }
        Ok(big)
    }

    fn method(&self) -> Result<Option<Method>, TerrainError> {
        let Some(name) = &self.method else {
            return Ok(None);
        };
        let known = Method::by_name(name).ok_or_else(|| TerrainError::UnknownMethod {
            method: name.clone(),
            methods: Method::ALL.map(|method| method.name()).join(", "),
        })?;
        Ok(Some(known))
    }

    /// The numbers of a file that has all of them.
    fn heights(&self, raw: &[u8], is_big_endian: bool) -> Result<Vec<f32>, TerrainError> {
        let mut heights = Vec::with_capacity(raw.len() / 2);
        for &two in raw.as_chunks::<2>().0 {
            let number = if is_big_endian {
                u16::from_be_bytes(two)
            } else {
                u16::from_le_bytes(two)
            };
            if Some(number) == self.no_data {
                let at = heights.len() as u32;
                return Err(TerrainError::NoData {
                    number,
                    column: at % self.width,
                    row: at / self.width,
                });
            }
            heights.push(f32::from(number));
        }
        Ok(heights)
    }
}
