//! The drawing process with the software driver. The driver reads its number of threads from the environment once, so
//! each number needs a separate process. The processes work in turn, and are idle in between.

use crate::clock::timed;
use crate::gpu::Gpu;
use crate::lens::Lens;
use crate::place::SurveyedScene;
use crate::plan::Plan;
use crate::stock::Stock;
use anyhow::{Context, Result, bail};
use enfilade::{Method, Scene, Viewer};
use std::io::{BufRead, Write};

/// The items passed to the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DrawSet {
    /// Every item whose bounds intersect the frustum.
    Frustum,
    /// The visible items, computed anew for each picture.
    Visible,
}

impl DrawSet {
    pub(crate) const ALL: [DrawSet; 2] = [DrawSet::Frustum, DrawSet::Visible];

    /// Name in the commands between the processes.
    pub(crate) fn name(self) -> &'static str {
        match self {
            DrawSet::Frustum => "frustum",
            DrawSet::Visible => "seen",
        }
    }
}

/// State of a drawing process.
struct Server {
    place: SurveyedScene,
    scene: Scene,
    stock: Stock,
    gpu: Gpu,
    viewer: Viewer,
    plan: Plan,
}

/// Writes the driver's name, then executes commands from standard input until it ends:
///
/// * `draw frustum 3` draws the fourth view; the reply is `milliseconds (by each clock) triangles draws`;
/// * `picture` replies with the bytes of the last picture.
pub(crate) fn serve(
    place: SurveyedScene,
    seen_by: Method,
    commands: impl BufRead,
    mut answer: impl Write,
) -> Result<()> {
    let stock = Stock::new(place.geometry()?);
    let size = place.views[0].size();
    let mut server = Server {
        scene: place.seen_by(seen_by)?,
        gpu: Gpu::new(&stock, size)?,
        stock,
        place,
        viewer: Viewer::new(),
        plan: Plan::default(),
    };
    writeln!(answer, "{}", server.gpu.name)?;
    answer.flush()?;
    for line in commands.lines() {
        let line = line?;
        match line.split(' ').collect::<Vec<_>>()[..] {
            ["draw", draw_set, view] => {
                let draw_set = DrawSet::ALL.into_iter().find(|known| known.name() == draw_set);
                let draw_set = draw_set.context("unknown draw set")?;
                let view = view.parse()?;
                let (done, [wall, cpu]) = timed(|| server.draw(draw_set, view));
                done?;
                let [triangles, draws] = [server.plan.triangles(), server.plan.draws().count() as u64];
                writeln!(answer, "{wall} {cpu} {triangles} {draws}")?;
            }
            ["picture"] => answer.write_all(&server.gpu.picture()?)?,
            _ => bail!("unknown command `{line}`"),
        }
        answer.flush()?;
    }
    Ok(())
}

impl Server {
    /// Draws a view, from culling to the finished picture.
    fn draw(&mut self, draw_set: DrawSet, view: usize) -> Result<()> {
        let view = self.place.views.get(view).context("view index out of range")?;
        let lens = Lens::new(view);
        match draw_set {
            DrawSet::Frustum => self.plan.frustum(&self.stock, &lens),
            DrawSet::Visible => {
                let set = self.viewer.look(&self.scene, view);
                self.plan.visible(&self.stock, &lens, set);
            }
        }
        self.gpu.draw(&self.plan, &lens)
    }
}
