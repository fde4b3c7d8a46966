//! Reads the feature table of a tile: its center, and the properties of its instances.

use super::TileError;
use crate::BrokenRule;
use crate::budget::Budget;
use serde::Deserialize;

/// The feature table.
pub(super) struct FeatureTable<'a> {
    properties: Properties,
    bytes: &'a [u8],
}

/// The properties that are read. Others, such as `BATCH_ID`, do not move anything.
#[derive(Default, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE", default)]
pub(super) struct Properties {
    pub(super) instances_length: Option<Numbers>,
    rtc_center: Option<Numbers>,
    pub(super) east_north_up: Option<bool>,
    pub(super) position: Option<Numbers>,
    pub(super) position_quantized: Option<Numbers>,
    pub(super) quantized_volume_offset: Option<Numbers>,
    pub(super) quantized_volume_scale: Option<Numbers>,
    pub(super) normal_up: Option<Numbers>,
    pub(super) normal_right: Option<Numbers>,
    #[serde(rename = "NORMAL_UP_OCT32P")]
    pub(super) normal_up_oct: Option<Numbers>,
    #[serde(rename = "NORMAL_RIGHT_OCT32P")]
    pub(super) normal_right_oct: Option<Numbers>,
    pub(super) scale: Option<Numbers>,
    pub(super) scale_non_uniform: Option<Numbers>,
}

/// Numbers in the JSON, or in the binary part.
#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum Numbers {
    One(f64),
    List(Vec<f64>),
    Binary {
        #[serde(rename = "byteOffset")]
        offset: u64,
    },
}

/// Memory per byte of JSON: a number of a list takes two bytes, and up to 104 while the list grows.
const TIMES_ITS_LENGTH: u64 = 32;

/// Type of the numbers in the binary part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    F32,
    U16,
    U32,
}

impl<'a> FeatureTable<'a> {
    pub(super) fn read(
        json: &[u8],
        bytes: &'a [u8],
        budget: &mut Budget,
    ) -> Result<FeatureTable<'a>, BrokenRule> {
        budget.take(json.len() as u64 * TIMES_ITS_LENGTH, || {
            "its feature table".to_owned()
        })?;
        // Writers pad it with spaces, some with zeros.
        let end = json
            .iter()
            .rposition(|&byte| byte != 0)
            .map_or(0, |last| last + 1);
        let json = json[..end].trim_ascii();
        let properties = match json {
            [] => Properties::default(),
            _ => serde_json::from_slice(json).map_err(|why| TileError::Features(why.to_string()))?,
        };
        Ok(FeatureTable { properties, bytes })
    }

    pub(super) fn properties(&self) -> &Properties {
        &self.properties
    }

    /// Returns the position of the model's origin in the tile, if it has one of its own.
    pub(super) fn center(&self) -> Result<Option<[f64; 3]>, TileError> {
        let center = self.properties.rtc_center.as_ref();
        center
            .map(|center| self.rows::<3>("RTC_CENTER", center, 1, Width::F32)?.row(0))
            .transpose()
    }

    /// Returns the number of instances.
    pub(super) fn instance_count(&self) -> Result<u64, TileError> {
        const NAME: &str = "INSTANCES_LENGTH";
        let count = self.properties.instances_length.as_ref();
        let count = count.ok_or(TileError::Missing(NAME))?;
        let [count] = self.rows::<1>(NAME, count, 1, Width::U32)?.row(0)?;
        if count.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&count) {
            Ok(count as u64)
        } else {
            Err(TileError::Features(format!(
                "{NAME} is {count}, and no number of instances"
            )))
        }
    }

    /// Returns rows of `N` numbers, one per instance; checks that all are there.
    pub(super) fn rows<'t, const N: usize>(
        &'t self,
        what: &'static str,
        numbers: &'t Numbers,
        instances: u64,
        width: Width,
    ) -> Result<Rows<'t, N>, TileError> {
        let needs = u128::from(instances) * N as u128;
        let list = |list: &'t [f64]| {
            if list.len() as u128 == needs {
                Ok(Rows::List(list))
            } else {
                Err(TileError::ListLength {
                    what,
                    needs,
                    has: list.len() as u64,
                })
            }
        };
        match numbers {
            Numbers::One(number) => list(std::slice::from_ref(number)),
            Numbers::List(numbers) => list(numbers),
            Numbers::Binary { offset } => {
                let there = usize::try_from(*offset).ok().and_then(|at| self.bytes.get(at..));
                let there = there.unwrap_or_default();
                let needs = needs * width.bytes() as u128;
                if needs > there.len() as u128 {
                    return Err(TileError::TooShort {
                        what,
                        instances,
                        needs,
                        has: there.len() as u64,
                    });
                }
                Ok(Rows::Bytes(there, width))
            }
        }
    }
}

impl Width {
    fn bytes(self) -> usize {
        match self {
            Width::U16 => 2,
            Width::F32 | Width::U32 => 4,
        }
    }

    fn number(self, bytes: &[u8]) -> f64 {
        match (self, bytes) {
            (Width::U16, &[a, b, ..]) => u16::from_le_bytes([a, b]).into(),
            (Width::F32, &[a, b, c, d, ..]) => f32::from_le_bytes([a, b, c, d]).into(),
            (Width::U32, &[a, b, c, d, ..]) => u32::from_le_bytes([a, b, c, d]).into(),
            _ => f64::NAN,
        }
    }
}

/// Rows of `N` numbers.
pub(super) enum Rows<'t, const N: usize> {
    List(&'t [f64]),
    Bytes(&'t [u8], Width),
}

impl<const N: usize> Rows<'_, N> {
    /// Returns a row; it must be finite.
    pub(super) fn row(&self, number: u64) -> Result<[f64; N], TileError> {
        let first = number as usize * N;
        let row: [f64; N] = std::array::from_fn(|nth| match self {
            Rows::List(list) => list[first + nth],
            Rows::Bytes(bytes, width) => width.number(&bytes[(first + nth) * width.bytes()..]),
        });
        if row.iter().all(|part| part.is_finite()) {
            Ok(row)
        } else {
            Err(TileError::NotFinite(number))
        }
    }
}
