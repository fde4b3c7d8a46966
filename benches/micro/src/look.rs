//! The row that looks at a scene with the method `masked`: traversal, tests and rasterization of what is found.

use super::screen::Screen;
use super::truth::ErrorCounts;
use super::{Row, Workload};
use anyhow::Result;
use enfilade::{Scene, View, Viewer, ViewerOptions};
use std::hint::black_box;
use std::rc::Rc;
use std::time::Instant;

pub(super) const NAME: &str = "look-1280";
const SIZE: [u32; 2] = [1280, 720];
/// Number of views.
const VIEWS: usize = 24;

struct Looks {
    scene: Rc<Scene>,
    views: Vec<View>,
    viewer: Viewer,
}

/// Returns the row. The method of the scene's sectors must be `masked`.
///
/// # Errors
/// Fails if a view of the survey is not valid.
pub(super) fn row(scene: &Rc<Scene>) -> Result<Row> {
    let survey = enfilade::survey(scene, VIEWS).views;
    let views = survey.iter().map(|at| View::new(at.eye, at.toward, SIZE));
    let views: Vec<View> = views.collect::<Result<_, _>>()?;
    let options = ViewerOptions {
        parallel: false,
        ..ViewerOptions::default()
    };
    let count = views.len() as u64;
    let looks = Looks {
        scene: Rc::clone(scene),
        views,
        viewer: Viewer::with_options(options),
    };
    let mut row = Row::new(NAME, Box::new(looks));
    row.views = Some(count);
    Ok(row)
}

impl Workload for Looks {
    fn count(&self) -> u64 {
        self.views.len() as u64
    }

    fn run(&mut self, _screen: &mut Screen) -> f64 {
        let start = Instant::now();
        for view in &self.views {
            black_box(self.viewer.look(&self.scene, view).items().len());
        }
        start.elapsed().as_secs_f64()
    }

    /// Nothing: the laws and `cargo xtask verify` check what a look returns.
    fn check(&mut self, _screen: &mut Screen) -> ErrorCounts {
        ErrorCounts::default()
    }
}
