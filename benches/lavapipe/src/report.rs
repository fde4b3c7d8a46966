//! Result tables.

use crate::clock::Clock;
use crate::measure::{DrawStats, Renderer, Timing};
use crate::serve::DrawSet;
use enfilade::Method;

/// Results of one scene.
pub(crate) struct Report {
    /// File name without extension.
    pub(crate) name: String,
    pub(crate) items: usize,
    pub(crate) triangles: u64,
    pub(crate) drawn: Vec<DrawStats>,
    pub(crate) taken: Vec<Timing>,
}

impl Report {
    /// Returns the fastest of Enfilade's methods, with its number of cores and its time.
    fn best(&self, clock: Clock) -> Option<(Method, usize, f64)> {
        let ours = self.taken.iter().filter_map(|taken| match taken.who {
            Renderer::Enfilade(method) => Some((method, taken.cores, taken.median(clock))),
            Renderer::Driver(_) => None,
        });
        ours.min_by(|a, b| a.2.total_cmp(&b.2))
    }

    fn drawn(&self, draw_set: DrawSet) -> Option<&DrawStats> {
        self.drawn.iter().find(|drawn| drawn.draw_set == draw_set)
    }

    /// Prints the table of the scene: one row for each renderer.
    pub(crate) fn print(&self, seen_by: Method) {
        println!(
            "\n{}: {} items, {} triangles",
            self.name, self.items, self.triangles
        );
        for drawn in &self.drawn {
            let [mean, most] = drawn.differing.map(|part| 100.0 * part);
            println!(
                "    {}: {} triangles in {} draws (medians); {mean:.3} % of the pixels differ from Enfilade's, {most:.3} % at most",
                chosen(drawn.draw_set, seen_by),
                drawn.triangles,
                drawn.draws
            );
        }
        println!(
            "    {:44}{:>6}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}",
            "renderer", "cores", "ms", "min", "max", "ratio", "CPU ms", "ratio"
        );
        for taken in &self.taken {
            let who = match taken.who {
                Renderer::Enfilade(method) => format!("Enfilade, {method}"),
                Renderer::Driver(draw_set) => format!("lavapipe, {}", chosen(draw_set, seen_by)),
            };
            let [least, most] =
                [f64::min, f64::max].map(|pick| taken.by(Clock::Wall).into_iter().fold(f64::NAN, pick));
            let [(wall, of_wall), (cpu, of_cpu)] = Clock::ALL.map(|clock| self.beside_best(taken, clock));
            println!(
                "    {who:44}{:6}{wall:10.2}{least:10.2}{most:10.2}{of_wall:9.2}x{cpu:10.2}{of_cpu:9.2}x",
                taken.cores
            );
        }
    }

    /// Returns the milliseconds, and their ratio to the fastest of Enfilade's methods.
    fn beside_best(&self, taken: &Timing, clock: Clock) -> (f64, f64) {
        let ms = taken.median(clock);
        (ms, ms / self.best(clock).map_or(f64::NAN, |(.., best)| best))
    }
}

fn chosen(draw_set: DrawSet, seen_by: Method) -> String {
    match draw_set {
        DrawSet::Frustum => "items in the frustum".to_owned(),
        DrawSet::Visible => format!("visible items by {seen_by}, look included"),
    }
}

/// Prints one row for each scene, as Markdown.
pub(crate) fn print_summary(reports: &[Report], cores: &[usize], clock: Clock) {
    let columns = DrawSet::ALL
        .iter()
        .flat_map(|&draw_set| cores.iter().map(move |&cores| (draw_set, cores)));
    let columns: Vec<(DrawSet, usize)> = columns.collect();
    let unit = if clock == Clock::Wall { "ms" } else { "CPU ms" };
    print!("\n| scene | triangles | in the frustum | seen | ours, best, cores | {unit} |");
    for (draw_set, cores) in &columns {
        let title = if *draw_set == DrawSet::Frustum {
            "lavapipe"
        } else {
            "look + lavapipe"
        };
        print!(" {title}, {cores} core{} |", if *cores == 1 { "" } else { "s" });
    }
    println!(
        " pixels that differ |\n|---|--:|--:|--:|---|--:|{}--:|",
        "--:|".repeat(columns.len())
    );
    for report in reports {
        let Some((method, cores, best)) = report.best(clock) else {
            continue;
        };
        let [frustum, seen] =
            DrawSet::ALL.map(|draw_set| report.drawn(draw_set).map_or(f64::NAN, |drawn| drawn.triangles));
        print!(
            "| {} | {} | {frustum:.0} | {seen:.0} | {method}, {cores} | {best:.1} |",
            report.name, report.triangles
        );
        for (draw_set, cores) in &columns {
            let mut taken = report.taken.iter();
            let taken = taken.find(|taken| taken.who == Renderer::Driver(*draw_set) && taken.cores == *cores);
            let (ms, of_ours) = taken.map_or((f64::NAN, f64::NAN), |taken| report.beside_best(taken, clock));
            print!(" {ms:.1} ({of_ours:.2}x) |");
        }
        let differing = report
            .drawn(DrawSet::Frustum)
            .map_or(f64::NAN, |drawn| drawn.differing[0]);
        println!(" {:.3} % |", 100.0 * differing);
    }
}
