//! A scene from a file, and where it is looked at from.

use anyhow::{Context, Result};
use enfilade::{Geometry, Method, Scene, View, survey};
use enfilade_import::{ReadOptions, read};
use std::path::Path;

/// A scene of one sector, and views in its open space.
pub(crate) struct Place {
    pub(crate) scene: Scene,
    pub(crate) views: Vec<View>,
}

impl Place {
    /// Reads a file as one room, and surveys it as `enfilade look FILE --flat --survey N` does.
    ///
    /// Doors and mirrors are what their meshes are then: both sides have the very same triangles to draw.
    pub(crate) fn open(file: &Path, views: usize, size: [u32; 2]) -> Result<Place> {
        let options = ReadOptions {
            flat: true,
            ..ReadOptions::default()
        };
        let scene = read(file, &options)?.scene(Method::ZBuffer, Method::DEFAULT_LIMIT)?;
        let views: Vec<View> = survey(&scene, views)
            .iter()
            .map(|at| View::new(at.eye, at.toward, size))
            .collect();
        anyhow::ensure!(
            !views.is_empty(),
            "{} has no open space to look at",
            file.display()
        );
        Ok(Place { scene, views })
    }

    /// What its one sector is made of.
    pub(crate) fn geometry(&self) -> Result<&Geometry> {
        let only = self.scene.sectors().next().context("a scene of no sector")?;
        let geometry = self.scene.geometry(only).context("a sector without a geometry")?;
        Ok(geometry)
    }

    /// The same, as a method sees it.
    pub(crate) fn seen_by(&self, method: Method) -> Result<Scene> {
        Ok(self.scene.with_method(method, Method::DEFAULT_LIMIT)?)
    }
}
