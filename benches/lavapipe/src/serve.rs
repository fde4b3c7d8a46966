//! The process that draws with the software driver. The driver asks the environment once how many threads to start, so
//! each number of threads needs a process of its own; they are asked in turn, and idle in between.

use crate::clock::timed;
use crate::gpu::Gpu;
use crate::lens::Lens;
use crate::place::Place;
use crate::plan::Plan;
use crate::stock::Stock;
use anyhow::{Context, Result, bail};
use enfilade::{Method, Scene, Viewer};
use std::io::{BufRead, Write};

/// What is handed to the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// Every item whose box meets the frustum.
    Frustum,
    /// What a look of ours finds, looked for anew each time.
    Collector,
}

impl What {
    pub(crate) const ALL: [What; 2] = [What::Frustum, What::Collector];

    /// What it is called between the processes.
    pub(crate) fn name(self) -> &'static str {
        match self {
            What::Frustum => "frustum",
            What::Collector => "seen",
        }
    }
}

/// Everything that one drawing process holds.
struct Server {
    place: Place,
    scene: Scene,
    stock: Stock,
    gpu: Gpu,
    viewer: Viewer,
    plan: Plan,
}

/// Says its driver's name, then answers lines, until there are no more:
///
/// * `draw frustum 3` draws the fourth view, and answers `milliseconds (by each clock) triangles draws`;
/// * `picture` answers the bytes of what was drawn last.
pub(crate) fn serve(
    place: Place,
    seen_by: Method,
    asked: impl BufRead,
    mut answer: impl Write,
) -> Result<()> {
    let stock = Stock::new(place.geometry()?);
    let size = place.views[0].size;
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
    for line in asked.lines() {
        let line = line?;
        match line.split(' ').collect::<Vec<_>>()[..] {
            ["draw", what, view] => {
                let what = What::ALL.into_iter().find(|known| known.name() == what);
                let what = what.context("what is to be drawn?")?;
                let view = view.parse()?;
                let (done, [wall, cpu]) = timed(|| server.draw(what, view));
                done?;
                let [triangles, draws] = [server.plan.triangles(), server.plan.draws().count() as u64];
                writeln!(answer, "{wall} {cpu} {triangles} {draws}")?;
            }
            ["picture"] => answer.write_all(&server.gpu.picture()?)?,
            _ => bail!("what does `{line}` mean?"),
        }
        answer.flush()?;
    }
    Ok(())
}

impl Server {
    /// From the view to the finished picture.
    fn draw(&mut self, what: What, view: usize) -> Result<()> {
        let view = self.place.views.get(view).context("there are fewer views")?;
        let lens = Lens::new(view);
        match what {
            What::Frustum => self.plan.frustum(&self.stock, &lens),
            What::Collector => {
                let set = self.viewer.look(&self.scene, view);
                self.plan.seen(&self.stock, &lens, set);
            }
        }
        self.gpu.draw(&self.plan, &lens)
    }
}
