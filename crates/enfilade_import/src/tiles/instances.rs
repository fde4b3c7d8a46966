//! Computes the transforms of the instances of a tile.

use super::features::{FeatureTable, Numbers, Rows, Width};
use super::{TileError, scene_from_tile};
use crate::BrokenRule;
use crate::budget::Budget;
use enfilade::Transform;
use glam::{DMat3, DVec3};

/// Where the model of a tile is.
pub(super) struct Instances {
    /// Scene-from-model transforms.
    pub(super) transforms: Vec<Transform>,
    /// Whether the model is of an `.i3dm`, so that names tell its instances apart.
    pub(super) is_instanced: bool,
    /// Position that was subtracted, in the axes of the tile.
    pub(super) left_out: Option<[f64; 3]>,
}

/// Distance from the origin beyond which 32-bit floats would move items by more than a millimetre, in metres.
const FAR: f64 = 16_384.0;

/// Equatorial and polar radius of the Earth, in metres (WGS 84).
const EARTH: [f64; 2] = [6_378_137.0, 6_356_752.314_245];

impl Instances {
    /// Returns the place of a model that is there once.
    pub(super) fn single(center: [f64; 3]) -> Instances {
        let origin = far_origin(DVec3::from(center));
        let place = DVec3::from(center) - origin.unwrap_or_default();
        Instances {
            transforms: vec![placed(place, DMat3::IDENTITY)],
            is_instanced: false,
            left_out: origin.map(Into::into),
        }
    }

    /// Reads the instances of an `.i3dm`.
    pub(super) fn read(features: &FeatureTable, budget: &mut Budget) -> Result<Instances, BrokenRule> {
        let count = features.instance_count()?;
        let center = DVec3::from(features.center()?.unwrap_or_default());
        let positions = Positions::of(features, count)?;
        let turns = Turns::of(features, count)?;
        let scales = Scales::of(features, count)?;
        // Checked before, so a count without numbers reserves nothing.
        budget.take(count * size_of::<Transform>() as u64, || {
            "its instances".to_owned()
        })?;
        let first = if count == 0 { DVec3::ZERO } else { positions.at(0)? };
        let origin = if far_origin(center).is_some() {
            far_origin(center)
        } else {
            far_origin(center + first)
        };
        let instance = |number| {
            let position = center + positions.at(number)?;
            let turn = turns.at(number, position)?;
            let scale = scales.at(number)?;
            let place = position - origin.unwrap_or_default();
            Ok(placed(place, turn * DMat3::from_diagonal(scale)))
        };
        Ok(Instances {
            transforms: (0..count).map(instance).collect::<Result<_, TileError>>()?,
            is_instanced: true,
            left_out: origin.map(Into::into),
        })
    }

    /// Returns `true` if the model is anywhere but once at its origin.
    pub(super) fn is_moved(&self) -> bool {
        self.is_instanced || self.transforms != [Transform::IDENTITY]
    }
}

/// Returns the position itself if it is far from the origin.
fn far_origin(position: DVec3) -> Option<DVec3> {
    (position.abs().max_element() > FAR).then_some(position)
}

/// Returns the scene-from-model transform of an instance, whose transform is in the axes of the tile.
fn placed(place: DVec3, linear: DMat3) -> Transform {
    let [x, y, z] = linear.to_cols_array_2d();
    let instance = Transform::from_columns_f64([x, y, z, place.into()]);
    let tile_from_model =
        Transform::from_columns([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.0; 3]]);
    scene_from_tile() * instance * tile_from_model
}

/// The positions of instances.
enum Positions<'t> {
    Plain(Rows<'t, 3>),
    Quantized {
        rows: Rows<'t, 3>,
        offset: DVec3,
        scale: DVec3,
    },
}

impl<'t> Positions<'t> {
    fn of(features: &'t FeatureTable, count: u64) -> Result<Positions<'t>, TileError> {
        let properties = features.properties();
        if let Some(positions) = &properties.position {
            let rows = features.rows("POSITION", positions, count, Width::F32)?;
            return Ok(Positions::Plain(rows));
        }
        const NAME: &str = "POSITION_QUANTIZED";
        let quantized = properties.position_quantized.as_ref();
        let quantized = quantized.ok_or(TileError::Missing("POSITION"))?;
        let volume = |numbers: &'t Option<Numbers>, lacks| {
            let numbers = numbers.as_ref().ok_or(TileError::Half { has: NAME, lacks })?;
            let row = features.rows::<3>(lacks, numbers, 1, Width::F32)?.row(0)?;
            Ok(DVec3::from(row))
        };
        Ok(Positions::Quantized {
            rows: features.rows(NAME, quantized, count, Width::U16)?,
            offset: volume(&properties.quantized_volume_offset, "QUANTIZED_VOLUME_OFFSET")?,
            scale: volume(&properties.quantized_volume_scale, "QUANTIZED_VOLUME_SCALE")?,
        })
    }

    fn at(&self, number: u64) -> Result<DVec3, TileError> {
        match self {
            Positions::Plain(rows) => rows.row(number).map(DVec3::from),
            Positions::Quantized { rows, offset, scale } => {
                let steps = DVec3::from(rows.row(number)?);
                Ok(offset + steps / f64::from(u16::MAX) * scale)
            }
        }
    }
}

/// The rotations of instances.
enum Turns<'t> {
    None,
    /// Up and right.
    Directions([Rows<'t, 3>; 2]),
    /// The same, each as a point of an octahedron.
    Octahedron([Rows<'t, 2>; 2]),
    EastNorthUp,
}

impl<'t> Turns<'t> {
    fn of(features: &'t FeatureTable, count: u64) -> Result<Turns<'t>, TileError> {
        let properties = features.properties();
        let directions = both(
            ("NORMAL_UP", &properties.normal_up),
            ("NORMAL_RIGHT", &properties.normal_right),
        )?;
        if let Some([up, right]) = directions {
            return Ok(Turns::Directions([
                features.rows("NORMAL_UP", up, count, Width::F32)?,
                features.rows("NORMAL_RIGHT", right, count, Width::F32)?,
            ]));
        }
        let octahedron = both(
            ("NORMAL_UP_OCT32P", &properties.normal_up_oct),
            ("NORMAL_RIGHT_OCT32P", &properties.normal_right_oct),
        )?;
        if let Some([up, right]) = octahedron {
            return Ok(Turns::Octahedron([
                features.rows("NORMAL_UP_OCT32P", up, count, Width::U16)?,
                features.rows("NORMAL_RIGHT_OCT32P", right, count, Width::U16)?,
            ]));
        }
        Ok(match properties.east_north_up {
            Some(true) => Turns::EastNorthUp,
            _ => Turns::None,
        })
    }

    fn at(&self, number: u64, position: DVec3) -> Result<DMat3, TileError> {
        let turn = match self {
            Turns::None => Some(DMat3::IDENTITY),
            Turns::Directions([up, right]) => {
                turned(DVec3::from(up.row(number)?), DVec3::from(right.row(number)?))
            }
            Turns::Octahedron([up, right]) => turned(unfolded(up.row(number)?), unfolded(right.row(number)?)),
            Turns::EastNorthUp => Some(east_north_up(position)),
        };
        turn.ok_or(TileError::NoRotation(number))
    }
}

type Property<'t> = (&'static str, &'t Option<Numbers>);

/// Returns two properties that only make sense together, if both are there.
fn both<'t>(a: Property<'t>, b: Property<'t>) -> Result<Option<[&'t Numbers; 2]>, TileError> {
    let half = |has: Property, lacks: Property| {
        Err(TileError::Half {
            has: has.0,
            lacks: lacks.0,
        })
    };
    match (a.1, b.1) {
        (Some(first), Some(second)) => Ok(Some([first, second])),
        (None, None) => Ok(None),
        (Some(_), None) => half(a, b),
        (None, Some(_)) => half(b, a),
    }
}

/// Returns the rotation that turns x to `right` and y to `up`; `None` if they are parallel or zero.
fn turned(up: DVec3, right: DVec3) -> Option<DMat3> {
    let right = right.try_normalize()?;
    let forward = right.cross(up.try_normalize()?);
    // The cross product of nearly parallel directions is rounding.
    let forward = (forward.length() > 1e-3).then_some(forward)?.normalize();
    Some(DMat3::from_cols(right, forward.cross(right), forward))
}

/// Returns the direction that a point of an unfolded octahedron stands for.
///
/// Source: Cigolle, Donow, Evangelakos, Mara, McGuire, Meyer. A Survey of Efficient Representations for Independent Unit
/// Vectors. JCGT 2014.
fn unfolded(point: [f64; 2]) -> DVec3 {
    let [x, y] = point.map(|part| part / f64::from(u16::MAX) * 2.0 - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    if z >= 0.0 {
        return DVec3::new(x, y, z);
    }
    DVec3::new((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y), z)
}

/// Returns the rotation that turns x to the east, y to the north and z up, on the ellipsoid of the Earth.
fn east_north_up(position: DVec3) -> DMat3 {
    let [equator, pole] = EARTH.map(|radius| radius * radius);
    let up = position / DVec3::new(equator, equator, pole);
    let up = up.try_normalize().unwrap_or(DVec3::Z);
    // At a pole every direction is south or north.
    let east = DVec3::new(-position.y, position.x, 0.0)
        .try_normalize()
        .unwrap_or(DVec3::Y);
    DMat3::from_cols(east, up.cross(east), up)
}

/// The scales of instances.
struct Scales<'t> {
    uniform: Option<Rows<'t, 1>>,
    along_axes: Option<Rows<'t, 3>>,
}

impl<'t> Scales<'t> {
    fn of(features: &'t FeatureTable, count: u64) -> Result<Scales<'t>, TileError> {
        let properties = features.properties();
        let uniform = properties.scale.as_ref();
        let along_axes = properties.scale_non_uniform.as_ref();
        Ok(Scales {
            uniform: uniform
                .map(|scales| features.rows("SCALE", scales, count, Width::F32))
                .transpose()?,
            along_axes: along_axes
                .map(|scales| features.rows("SCALE_NON_UNIFORM", scales, count, Width::F32))
                .transpose()?,
        })
    }

    /// Returns the product of both scales.
    fn at(&self, number: u64) -> Result<DVec3, TileError> {
        let uniform = self.uniform.as_ref().map(|rows| rows.row(number)).transpose()?;
        let along_axes = self
            .along_axes
            .as_ref()
            .map(|rows| rows.row(number))
            .transpose()?;
        let [uniform] = uniform.unwrap_or([1.0]);
        Ok(uniform * along_axes.map_or(DVec3::ONE, DVec3::from))
    }
}
