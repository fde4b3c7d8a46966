//! Which way is up in a scene, and how long a unit is: as given, as the format says, or as the floors tell.

use crate::args::UprightArgs;
use crate::text::short;
use enfilade::{Scene, SurveyOptions};
use enfilade_bake::Up;
use enfilade_import::{detect_scene_unit, detect_scene_up};
use glam::DVec3;

/// The up vector and the unit of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Upright {
    /// Of length 1.
    pub(crate) up: [f32; 3],
    pub(crate) up_from: Source,
    /// Metres per scene unit; `None` where the survey estimates them.
    pub(crate) metres_per_unit: Option<f64>,
}

/// Where an up vector or a unit comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// The format says it.
    Format,
    /// Nothing does: assumed.
    Nothing,
    /// The floors and rooms of an OBJ file.
    Floors,
    /// An option.
    Option,
}

impl Source {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Source::Format => "format",
            Source::Nothing => "nothing",
            Source::Floors => "floors",
            Source::Option => "option",
        }
    }
}

impl Default for Upright {
    fn default() -> Upright {
        Upright {
            up: [0.0, 1.0, 0.0],
            up_from: Source::Format,
            metres_per_unit: None,
        }
    }
}

impl Upright {
    /// Finds both from the floors of a scene whose format does not tell them; y and the survey's estimate where that is not
    /// clear.
    pub(crate) fn of_floors(scene: &Scene) -> Upright {
        let mut upright = Upright {
            up_from: Source::Nothing,
            ..Upright::default()
        };
        let up = detect_scene_up(scene);
        if let Some(up) = up {
            upright.up = vector(up);
            upright.up_from = Source::Floors;
        }
        let unit = detect_scene_unit(scene, up.unwrap_or(Up::Y));
        if let Some(unit) = unit.filter(|&unit| unit != 1.0) {
            upright.metres_per_unit = Some(unit);
        }
        upright
    }

    /// Replaces what options give.
    pub(crate) fn set(&mut self, args: &UprightArgs) {
        if let Some(up) = args.up {
            self.up = up;
            self.up_from = Source::Option;
        }
        if let Some(unit) = args.unit {
            self.metres_per_unit = Some(unit);
        }
    }

    /// Returns the up vector in f64.
    pub(crate) fn up_f64(&self) -> DVec3 {
        DVec3::from(self.up.map(f64::from))
    }

    pub(crate) fn survey_options(&self) -> SurveyOptions {
        let mut options = SurveyOptions::default();
        options.up = self.up;
        options.metre = self.metres_per_unit.map(f64::recip);
        options
    }
}

/// Returns an up vector in words: `z`, `-y` or `0.1, 1, 0`.
pub(crate) fn up_for_people(up: [f32; 3]) -> String {
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        match up[axis] {
            1.0 => return name.to_owned(),
            -1.0 => return format!("-{name}"),
            _ => {}
        }
    }
    up.map(|part| short(part.into())).join(", ")
}

/// Returns the axis that the floors of a scene face, if that is clearly not y: a hint for a format in which y is up.
pub(crate) fn doubtful_up(scene: &Scene) -> Option<&'static str> {
    match detect_scene_up(scene)? {
        Up::X => Some("x"),
        Up::Y => None,
        Up::Z => Some("z"),
    }
}

fn vector(up: Up) -> [f32; 3] {
    match up {
        Up::X => [1.0, 0.0, 0.0],
        Up::Y => [0.0, 1.0, 0.0],
        Up::Z => [0.0, 0.0, 1.0],
    }
}
