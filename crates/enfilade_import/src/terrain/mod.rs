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
//! `width` heights from west to east, `height` rows of them, the northern first, in metres. `format` says how each is stored: `u16
//! little endian` and `u16 big endian` are numbers of 16 bits without sign, `f32 little endian` and `f32 big endian` those of 32
//! bits with a fraction. `noData` is the number that stands for a hole, if one does. Without `file` the heights are in the only file beside it
//! that is called as it is, or begins so, and ends in `.raw`. `diagonal` says where the diagonal of each cell begins:
//! `north-east`, as where it is left out, or `north-west`. `method` says how it is to be seen, if it is there. Other keys are
//! comments.
//!
//! Where the heights would take more as meshes than reading may, they stay in their file, which is mapped into memory.
//! Source: ours.
//! Cost: O(heights); memory, too, unless they stay in their file.
//! Hostile: what is said of the heights is held against their file before anything is set aside.

mod error;
mod files;
pub(crate) mod grid;
mod map;

pub use error::TerrainError;
pub use grid::{GridError, GridPlace};

use crate::budget::Budget;
use crate::{BrokenRule, Import, ReadOptions, Room, SourceNodes, read_regular_file};
use enfilade::{
    Diagonal, Geometry, GeometryBuilder, HeightBytes, HeightField, HeightFieldError, HeightFormat, Heights,
    LargeTerrain, Material, MaterialId, Method, Transform,
};
use serde::Deserialize;
use std::ffi::OsStr;
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
    no_data: Option<f32>,
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
    let name = name.to_string_lossy().into_owned();
    let room = if budget.has(needs.saturating_add(as_meshes)) {
        budget.take(as_meshes, place)?;
        let raw =
            read_regular_file(&path, None, &|| "its heights".to_owned(), &mut budget).map_err(in_file)?;
        Room {
            name,
            geometry: Arc::new(description.meshes(&raw, format)?),
            nodes: SourceNodes::default(),
            method,
            open_above: false,
            large: None,
        }
    } else {
        budget.take(samples / CELLS_OF_BLOCK * BYTES_OF_BLOCK, place)?;
        let mapped = usize::try_from(needs).map_err(|_| std::io::ErrorKind::OutOfMemory.into());
        let mapped = mapped.and_then(|bytes| map::map(&path, bytes));
        let mapped = mapped.map_err(|why| in_file(BrokenRule::Unreadable(why)))?;
        let nothing = GeometryBuilder::new([] as [Material; 0]).build();
        Room {
            name,
            geometry: Arc::new(nothing.map_err(BrokenRule::Geometry)?),
            nodes: SourceNodes::default(),
            method,
            open_above: false,
            large: Some(Arc::new(description.large(mapped, format)?)),
        }
    };
    Ok(Import {
        rooms: vec![room],
        portals: Vec::new(),
        cameras: Vec::new(),
        lights: Vec::new(),
        map: None,
        warnings: Vec::new(),
        files: vec![path],
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

/// Cells of a block of [`LargeTerrain`], and the bytes that it keeps of one, with those of the squares of blocks.
const CELLS_OF_BLOCK: u64 = 32 * 32;
const BYTES_OF_BLOCK: u64 = 11;

impl Description {
    /// How a height is stored: numbers of 16 bits without sign and of 32 bits with a fraction are read.
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

    /// The heights in bytes that have all of them.
    fn stored<B: AsRef<[u8]> + Send + Sync>(
        &self,
        bytes: B,
        format: HeightFormat,
        hole: Option<f32>,
    ) -> Result<HeightBytes<B>, TerrainError> {
        HeightBytes::new(bytes, [self.width, self.height], format, hole).map_err(TerrainError::Field)
    }

    /// Blocks as meshes.
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

    /// Heights that stay in their file.
    fn large(&self, mapped: map::Map, format: HeightFormat) -> Result<LargeTerrain, TerrainError> {
        let stored = self.stored(mapped.clone(), format, self.no_data)?;
        let terrain = LargeTerrain::new(stored, [self.cell_x, self.cell_z], GROUND);
        let terrain = terrain.map_err(|why| self.refusal(why, mapped, format))?;
        Ok(terrain.cut_along(self.diagonal.into()))
    }

    /// Why heights make no field: a hole may be one that was announced.
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
