//! Walks through a baked scene that is larger than memory, and prints what is absent and how long frames take.
//!
//! `cargo run --release -p enfilade_stream --example walk -- SCENE.enf VIEWS.jsonl MEGABYTES [FRAME_MS [TRUTH]]`: the views are
//! those that `enfilade look --path` reads, a frame each; a frame takes at least FRAME_MS, as in a game. With MEGABYTES 0
//! everything is in memory. With FRAME_MS 0 each frame waits for a page. TRUTH is a file of what exact looks at everything find
//! visible; it is written if MEGABYTES is 0, and else compared with.
#![allow(clippy::print_stdout, reason = "the answer")]

use enfilade::{Camera, ItemIndex, Method, Scene, SectorId, View, Viewer, VisibleSet};
use enfilade_import::{Pages, ReadOptions};
use enfilade_stream::{Pager, PagerOptions};
use std::collections::BTreeSet;
use std::error::Error;
use std::path::Path;
use std::time::{Duration, Instant};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let (file, views, megabytes, frame_ms, truth) = match args[..] {
        [file, views, megabytes] => (file, views, megabytes, "16", None),
        [file, views, megabytes, frame_ms] => (file, views, megabytes, frame_ms, None),
        [file, views, megabytes, frame_ms, truth] => (file, views, megabytes, frame_ms, Some(truth)),
        _ => return Err("usage: walk SCENE.enf VIEWS.jsonl MEGABYTES [FRAME_MS [TRUTH]]".into()),
    };
    let (file, frame_ms) = (Path::new(file), frame_ms.parse()?);
    let views = read_views(views)?;
    let mut options = PagerOptions::default();
    options.bytes = megabytes.parse::<u64>()? * 1_000_000;
    let start = Instant::now();
    let mut walk = Walk::default();
    if let (0, Some(truth)) = (options.bytes, truth) {
        let scene = whole(file, Method::HierarchicalZ)?;
        let mut viewer = Viewer::new();
        let seen = views.iter().map(|view| line(&items(viewer.look(&scene, view))));
        return Ok(std::fs::write(truth, seen.collect::<String>())?);
    }
    if options.bytes == 0 {
        walk.in_memory(&whole(file, METHOD)?, &views, frame_ms);
    } else {
        let (import, pages) = Pages::open(file, &unlimited())?;
        let mut scene = import.scene(METHOD, u64::MAX)?;
        let mut pager = Pager::new(import, pages, options);
        println!(
            "opened in {:.0} ms, {:.0} MB",
            start.elapsed().as_secs_f64() * 1e3,
            peak_megabytes()
        );
        let truth = truth.map_or(Ok(String::new()), std::fs::read_to_string)?;
        walk.paged(&mut scene, &mut pager, &views, frame_ms, &truth)?;
    }
    walk.print(views.len());
    Ok(())
}

const METHOD: Method = Method::Masked;

fn unlimited() -> ReadOptions {
    ReadOptions {
        limit_bytes: u64::MAX,
        ..ReadOptions::default()
    }
}

fn whole(file: &Path, method: Method) -> Result<Scene, Box<dyn Error>> {
    Ok(enfilade_import::read(file, &unlimited())?.scene(method, u64::MAX)?)
}

#[derive(Default)]
struct Walk {
    looks_ms: Vec<f64>,
    steps_ms: Vec<f64>,
    frames_absent: u32,
    absent: u64,
    visible: u64,
    loaded: u64,
    dropped: u64,
    most_bytes: u64,
    compared: u64,
    lost: u64,
    truly_absent: u64,
    frames_truly_absent: u32,
}

impl Walk {
    fn in_memory(&mut self, scene: &Scene, views: &[View], frame_ms: u64) {
        let mut viewer = Viewer::new();
        for view in views {
            let start = Instant::now();
            self.visible += viewer.look(scene, view).items().len() as u64;
            self.looks_ms.push(start.elapsed().as_secs_f64() * 1e3);
            rest(start, frame_ms);
        }
    }

    fn paged(
        &mut self,
        scene: &mut Scene,
        pager: &mut Pager,
        views: &[View],
        frame_ms: u64,
        truth: &str,
    ) -> Result<(), Box<dyn Error>> {
        let mut viewer = Viewer::new();
        let mut truth = truth.lines();
        for view in views {
            let start = Instant::now();
            let seen = viewer.look(scene, view);
            self.looks_ms.push(start.elapsed().as_secs_f64() * 1e3);
            if let Some(line) = truth.next() {
                let exact = line.split_whitespace().map(|item| Ok(ItemIndex(item.parse()?)));
                let exact = exact.collect::<Result<BTreeSet<_>, Box<dyn Error>>>()?;
                let seen = items(seen);
                let is_absent = |&&item: &&ItemIndex| pager.is_absent(SectorId(0), item.into());
                let absent = exact.intersection(&seen).filter(is_absent).count() as u64;
                self.compared += exact.len() as u64;
                self.lost += exact.difference(&seen).count() as u64;
                self.truly_absent += absent;
                self.frames_truly_absent += u32::from(absent > 0);
            }
            let after_look = Instant::now();
            let stats = pager.step(scene, &[seen])?;
            self.steps_ms.push(after_look.elapsed().as_secs_f64() * 1e3);
            self.visible += seen.items().len() as u64;
            self.frames_absent += u32::from(stats.absent > 0);
            self.absent += u64::from(stats.absent);
            self.loaded += u64::from(stats.loaded);
            self.dropped += u64::from(stats.dropped);
            self.most_bytes = self.most_bytes.max(stats.bytes);
            for (page, why) in stats.failed {
                println!("page {page} cannot be read: {why}");
            }
            if frame_ms == 0 {
                pager.wait(Duration::from_secs(1));
            } else {
                rest(start, frame_ms);
            }
        }
        Ok(())
    }

    fn print(&mut self, frames: usize) {
        let [looks, steps] = [&mut self.looks_ms, &mut self.steps_ms].map(|times| {
            times.sort_by(f64::total_cmp);
            let at = |part: f64| {
                times
                    .get((times.len() as f64 * part) as usize)
                    .copied()
                    .unwrap_or(0.0)
            };
            format!("median {:.2} ms, p99 {:.2} ms", at(0.5), at(0.99))
        });
        let frames = frames as f64;
        println!("look: {looks}; {:.1} items visible", self.visible as f64 / frames);
        println!(
            "step: {steps}; {} pages loaded, {} dropped",
            self.loaded, self.dropped
        );
        println!(
            "absent: something in {} of {frames} frames ({:.1} %), {:.1} items on average",
            self.frames_absent,
            100.0 * f64::from(self.frames_absent) / frames,
            self.absent as f64 / frames
        );
        println!(
            "pages: {:.0} MB at most; process: {:.0} MB at most",
            self.most_bytes as f64 / 1e6,
            peak_megabytes()
        );
        if self.compared > 0 {
            println!(
                "compared: {} of {} items that exact looks see are neither seen nor absent; {:.1} are absent on average, \
                 something in {} frames ({:.1} %)",
                self.lost,
                self.compared,
                self.truly_absent as f64 / frames,
                self.frames_truly_absent,
                100.0 * f64::from(self.frames_truly_absent) / frames,
            );
        }
    }
}

fn items(set: &VisibleSet) -> BTreeSet<ItemIndex> {
    set.items().iter().map(|visible| visible.item.index).collect()
}

/// A line of what is visible in a view.
fn line(items: &BTreeSet<ItemIndex>) -> String {
    let numbers: Vec<String> = items.iter().map(|item| item.0.to_string()).collect();
    numbers.join(" ") + "\n"
}

fn rest(start: Instant, frame_ms: u64) {
    if let Some(left) = Duration::from_millis(frame_ms).checked_sub(start.elapsed()) {
        std::thread::sleep(left);
    }
}

/// Returns the greatest memory of this process so far, in megabytes; 0 where the system does not tell.
fn peak_megabytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = peak.and_then(|peak| peak.trim().strip_suffix("kB")?.trim().parse::<f64>().ok());
    kilobytes.unwrap_or(0.0) * 1024.0 / 1e6
}

/// Reads the numbers of JSON lines of `{"eye":[..],"toward":[..]}`.
fn read_views(file: &str) -> Result<Vec<View>, Box<dyn Error>> {
    let text = std::fs::read_to_string(file)?;
    let view = |line: &str| -> Result<View, Box<dyn Error>> {
        let numbers: Vec<f64> = line
            .split(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)))
            .filter_map(|word| word.parse().ok())
            .collect();
        let [a, b, c, d, e, f] = numbers[..] else {
            return Err(format!("{file}: `{line}`").into());
        };
        let camera = Camera {
            sector: Some(SectorId(0)),
            ..Camera::new([a, b, c], [d, e, f])
        };
        Ok(camera.view([1280, 720])?)
    };
    text.lines()
        .filter(|line| !line.trim().is_empty())
        .map(view)
        .collect()
}
