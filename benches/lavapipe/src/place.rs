//! A scene from a file with surveyed views.

use anyhow::{Context, Result};
use enfilade::{Geometry, Method, Scene, View, survey};
use enfilade_import::{ReadOptions, read};
use std::path::Path;

/// A scene of one sector, and views in its open space.
pub(crate) struct SurveyedScene {
    pub(crate) scene: Scene,
    pub(crate) views: Vec<View>,
}

impl SurveyedScene {
    /// Reads a file as one sector, and surveys it as `enfilade look FILE --flat --survey N` does.
    ///
    /// Doors and mirrors are ordinary meshes then: both renderers draw the same triangles.
    pub(crate) fn open(file: &Path, views: usize, size: [u32; 2]) -> Result<SurveyedScene> {
        let options = ReadOptions {
            flat: true,
            ..ReadOptions::default()
        };
        let scene = read(file, &options)?.scene(Method::ZBuffer, Method::DEFAULT_LIMIT)?;
        let views: Vec<View> = survey(&scene, views)
            .views
            .iter()
            .map(|at| View::new(at.eye, at.toward, size).expect("a valid view"))
            .collect();
        anyhow::ensure!(
            !views.is_empty(),
            "{} has no open space for cameras",
            file.display()
        );
        Ok(SurveyedScene { scene, views })
    }

    /// Returns the geometry of the only sector.
    pub(crate) fn geometry(&self) -> Result<&Geometry> {
        let only = self.scene.sectors().next().context("the scene has no sector")?;
        let geometry = self.scene.geometry(only).context("the sector has no geometry")?;
        Ok(geometry)
    }

    /// Returns the scene with another method.
    pub(crate) fn seen_by(&self, method: Method) -> Result<Scene> {
        Ok(self.scene.with_method(method, Method::DEFAULT_LIMIT)?)
    }
}
