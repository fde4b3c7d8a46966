//! Reads terrain: a raw heightmap with a JSON description; and recognises meshes that are height grids.
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
//! The file holds `height` rows of `width` heights in metres, the northernmost row first, each from west to east.
//! `format` is the sample type: `u16 little endian` or `u16 big endian` (unsigned integers), `f32 little endian` or
//! `f32 big endian`. `noData`, if present, is the value of a missing sample. `file` names the heightmap; without it,
//! the only `.raw` file in the same folder with the same stem, or a stem that begins with it, is used. `diagonal` is
//! the corner where the diagonal of each cell begins: `north-east` (the default) or `north-west`. `method`, if present,
//! is the visibility method. Other keys are ignored.
//!
//! Heights that would take more memory as meshes than the limit stay in their file, which is mapped into memory.
//! Source: ours.
//! Cost: O(heights), also in memory unless they stay in their file.
//! Hostile input: the sizes are checked against the length of the file before anything is allocated.

mod error;
mod files;
pub(crate) mod grid;

pub use error::TerrainError;
pub use grid::{GridError, GridPlace};

use crate::budget::Budget;
use crate::map::Map;
use crate::{BrokenRule, Import, ReadOptions, Room, read_regular_file};
use enfilade::{
    Diagonal, Geometry, GeometryBuilder, HeightBytes, HeightField, HeightFieldError, HeightFormat, Heights,
    LargeTerrain, Material, MaterialId, Method, Transform,
};
use serde::Deserialize;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::Arc;

/// The JSON description.
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
    no_data: Option<f32>,
    file: Option<String>,
    method: Option<String>,
    #[serde(default)]
    diagonal: Corner,
}

/// The corner where the diagonal of each cell begins.
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

/// Maximum length of a description, in bytes.
const LONGEST: usize = 1 << 16;

/// Returns `true` if the bytes are JSON that describes terrain, and not glTF.
pub(crate) fn describes_terrain(bytes: &[u8]) -> bool {
    /// The keys that distinguish the two: `asset` is required in glTF, the others in a description.
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

/// Reads the terrain described by a JSON file called `name`; its heightmap is looked for in `folder`.
pub(crate) fn import(
    bytes: &[u8],
    folder: Option<&Path>,
    name: &OsStr,
    _options: &ReadOptions,
    mut budget: Budget,
) -> Result<Import, BrokenRule> {
    let description: Description =
        serde_json::from_slice(bytes).map_err(|why| TerrainError::Description(why.to_string()))?;
    let format = description.format()?;
    let method = description.method()?;
    let folder = folder.ok_or(TerrainError::NoFolder)?;
    let path = files::heights_of(&description.file, folder, name)?;
    let samples = u64::from(description.width) * u64::from(description.height);
    let in_file = |why| TerrainError::File {
        file: path.display().to_string(),
        why: Box::new(why),
    };
    let about = std::fs::metadata(&path).map_err(|why| in_file(BrokenRule::Unreadable(why)))?;
    if !about.is_file() {
        return Err(in_file(BrokenRule::NotAFile).into());
    }
    let (needs, has) = (samples.saturating_mul(format.bytes()), about.len());
    if has != needs {
        return Err(TerrainError::Length {
            file: path.display().to_string(),
            size: [description.width, description.height],
            needs,
            has,
        }
        .into());
    }
    let place = || format!("terrain of {samples} heights");
    let as_meshes = samples.saturating_mul(BYTES_OF_SAMPLE);
    let name = name.to_string_lossy();
    let room = if budget.has(needs.saturating_add(as_meshes)) {
        budget.take(as_meshes, place)?;
        let raw =
            read_regular_file(&path, None, &|| "its heights".to_owned(), &mut budget).map_err(in_file)?;
        Room::new(&name, description.meshes(&raw, format)?)
    } else {
        budget.take(samples / CELLS_OF_BLOCK * BYTES_OF_BLOCK, place)?;
        let mapped = usize::try_from(needs).map_err(|_| std::io::ErrorKind::OutOfMemory.into());
        let mapped = mapped.and_then(|bytes| crate::map::map(&path, bytes));
        let mapped = mapped.map_err(|why| in_file(BrokenRule::Unreadable(why)))?;
        let nothing = GeometryBuilder::new([] as [Material; 0]).build();
        Room {
            large: Some(Arc::new(description.large(mapped, format)?)),
            ..Room::new(&name, nothing.map_err(BrokenRule::Geometry)?)
        }
    };
    Ok(Import {
        files: vec![path],
        ..Import::of_rooms(vec![Room { method, ..room }])
    })
}

/// Returns a copy of a description with `method` set.
pub(crate) fn with_method(bytes: &[u8], method: Method) -> Result<Vec<u8>, BrokenRule> {
    let mut json: serde_json::Value =
        serde_json::from_slice(bytes).map_err(|why| TerrainError::Description(why.to_string()))?;
    json["method"] = method.name().into();
    Ok(format!("{json:#}\n").into_bytes())
}

/// Terrain color: dry grass.
const GROUND: [f32; 3] = [0.32, 0.36, 0.17];

/// Memory per height: a number, a vertex with normal in up to four blocks, and two triangles.
const BYTES_OF_SAMPLE: u64 = 4 + 30 + 2 * 40;

/// Cells per block of [`LargeTerrain`], and the bytes that it stores per block, including its quadtree of blocks.
const CELLS_OF_BLOCK: u64 = 32 * 32;
const BYTES_OF_BLOCK: u64 = 11;

impl Description {
    /// Returns the sample type: unsigned 16-bit integers and 32-bit floats are supported.
    fn format(&self) -> Result<HeightFormat, TerrainError> {
        let words: Vec<String> = self
            .format
            .split(|c: char| !c.is_alphanumeric())
            .map(str::to_lowercase)
            .collect();
        let has = |names: &[&str]| words.iter().any(|word| names.contains(&word.as_str()));
        let is_short = has(&["u16", "uint16", "u16le", "u16be"]);
        let is_float = has(&["f32", "float32", "f32le", "f32be"]);
        let little = has(&["little", "u16le", "f32le"]);
        let big = has(&["big", "u16be", "f32be"]);
        match [is_short, is_float, little, big] {
            [true, false, true, false] => Ok(HeightFormat::U16Le),
            [true, false, false, true] => Ok(HeightFormat::U16Be),
            [false, true, true, false] => Ok(HeightFormat::F32Le),
            [false, true, false, true] => Ok(HeightFormat::F32Be),
            _ => Err(TerrainError::Format(self.format.clone())),
        }
    }

    /// Returns the visibility method, if the description names one.
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

    /// Views bytes as the heights of this description.
    fn stored<B: AsRef<[u8]> + Send + Sync>(
        &self,
        bytes: B,
        format: HeightFormat,
        hole: Option<f32>,
    ) -> Result<HeightBytes<B>, TerrainError> {
        HeightBytes::new(bytes, [self.width, self.height], format, hole).map_err(TerrainError::Field)
    }

    /// Builds the terrain as block meshes.
    fn meshes(&self, raw: &[u8], format: HeightFormat) -> Result<Geometry, BrokenRule> {
        let stored = self.stored(raw, format, self.no_data)?;
        let mut heights = vec![0.0; self.width as usize * self.height as usize];
        for (row, heights) in (0..).zip(heights.chunks_exact_mut(self.width.max(1) as usize)) {
            stored.read(0, row, heights);
        }
        let size = [self.width, self.height];
        let field = HeightField::new(size, [self.cell_x, self.cell_z], heights);
        let field = field.map_err(|why| self.refusal(why, raw, format))?;
        let ground = Material {
            double_sided: true,
            ..Material::opaque(GROUND)
        };
        let mut geometry = GeometryBuilder::new([ground]);
        let field = field.cut_along(self.diagonal.into());
        geometry
            .terrain("block", field, MaterialId(0), Transform::IDENTITY)
            .map_err(BrokenRule::Geometry)?;
        geometry.build().map_err(BrokenRule::Geometry)
    }

    /// Builds the terrain from heights that stay in their file.
    fn large(&self, mapped: Map, format: HeightFormat) -> Result<LargeTerrain, TerrainError> {
        let stored = self.stored(mapped.clone(), format, self.no_data)?;
        let terrain = LargeTerrain::new(stored, [self.cell_x, self.cell_z], GROUND);
        let terrain = terrain.map_err(|why| self.refusal(why, mapped, format))?;
        Ok(terrain.cut_along(self.diagonal.into()))
    }

    /// Converts an error of the height field; a hole may be a declared `noData` value.
    fn refusal<B: AsRef<[u8]> + Send + Sync>(
        &self,
        why: HeightFieldError,
        bytes: B,
        format: HeightFormat,
    ) -> TerrainError {
        if let HeightFieldError::Hole { column, row, .. } = why
            && let Ok(stored) = self.stored(bytes, format, None)
        {
            let mut number = [0.0];
            stored.read(column, row, &mut number);
            if Some(number[0]) == self.no_data {
                let [number] = number;
                return TerrainError::NoData { number, column, row };
            }
        }
        TerrainError::Field(why)
    }
}
