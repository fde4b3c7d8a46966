//! The tables.

use crate::clock::Clock;
use crate::measure::{Drawn, Taken, Who};
use crate::serve::What;
use enfilade::Method;

/// What was found out about a scene.
pub(crate) struct Report {
    /// The file's name without its ending.
    pub(crate) name: String,
    pub(crate) items: usize,
    pub(crate) triangles: u64,
    pub(crate) drawn: Vec<Drawn>,
    pub(crate) taken: Vec<Taken>,
}

impl Report {
    /// The fastest of ours, and on how many cores it is.
    fn best(&self, clock: Clock) -> Option<(Method, usize, f64)> {
        let ours = self.taken.iter().filter_map(|taken| match taken.who {
            Who::Ours(method) => Some((method, taken.cores, taken.median(clock))),
            Who::Driver(_) => None,
        });
        ours.min_by(|a, b| a.2.total_cmp(&b.2))
    }

    fn drawn(&self, what: What) -> Option<&Drawn> {
        self.drawn.iter().find(|drawn| drawn.what == what)
    }

    /// Prints the scene's own table: one row for each side.
    pub(crate) fn print(&self, seen_by: Method) {
        println!(
            "\n{}: {} items, {} triangles",
            self.name, self.items, self.triangles
        );
        for drawn in &self.drawn {
            let [mean, most] = drawn.differing.map(|part| 100.0 * part);
            println!(
                "    {}: {} triangles in {} draws (medians); {mean:.3} % of the pixels differ from ours, {most:.3} % at most",
                chosen(drawn.what, seen_by),
                drawn.triangles,
                drawn.draws
            );
        }
        println!(
            "    {:44}{:>6}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}",
            "drawn by", "cores", "ms", "least", "most", "of ours", "CPU ms", "of ours"
        );
        for taken in &self.taken {
            let who = match taken.who {
                Who::Ours(method) => format!("ours, {method}"),
                Who::Driver(what) => format!("lavapipe, {}", chosen(what, seen_by)),
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

    /// Milliseconds, and how many times the best of ours they are.
    fn beside_best(&self, taken: &Taken, clock: Clock) -> (f64, f64) {
        let ms = taken.median(clock);
        (ms, ms / self.best(clock).map_or(f64::NAN, |(.., best)| best))
    }
}

fn chosen(what: What, seen_by: Method) -> String {
    match what {
        What::Frustum => "what is in the frustum".to_owned(),
        What::Collector => format!("what {seen_by} sees, looking included"),
    }
}

/// Prints one row for each scene, as Markdown.
pub(crate) fn print_summary(reports: &[Report], cores: &[usize], clock: Clock) {
    let columns = What::ALL
        .iter()
        .flat_map(|&what| cores.iter().map(move |&cores| (what, cores)));
    let columns: Vec<(What, usize)> = columns.collect();
    let unit = if clock == Clock::Wall { "ms" } else { "CPU ms" };
    print!("\n| scene | triangles | in the frustum | seen | ours, best, cores | {unit} |");
    for (what, cores) in &columns {
        let title = if *what == What::Frustum {
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
            What::ALL.map(|what| report.drawn(what).map_or(f64::NAN, |drawn| drawn.triangles));
        print!(
            "| {} | {} | {frustum:.0} | {seen:.0} | {method}, {cores} | {best:.1} |",
            report.name, report.triangles
        );
        for (what, cores) in &columns {
            let mut taken = report.taken.iter();
            let taken = taken.find(|taken| taken.who == Who::Driver(*what) && taken.cores == *cores);
            let (ms, of_ours) = taken.map_or((f64::NAN, f64::NAN), |taken| report.beside_best(taken, clock));
            print!(" {ms:.1} ({of_ours:.2}x) |");
        }
        let differing = report
            .drawn(What::Frustum)
            .map_or(f64::NAN, |drawn| drawn.differing[0]);
        println!(" {:.3} % |", 100.0 * differing);
    }
}
