//! The other side as seen from here: a process that draws on demand.

use crate::clock::Times;
use crate::ours::Picture;
use crate::serve::What;
use anyhow::{Context, Result};
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The driver's own switch for the threads that paint. With 0 its one thread for commands paints, too.
const DRIVER_THREADS: &str = "LP_NUM_THREADS";

/// A process that draws, and the pipes to it.
pub(crate) struct Peer {
    /// Cores that it may use.
    pub(crate) cores: usize,
    /// The driver, as it calls itself.
    pub(crate) driver: String,
    process: Child,
    /// Taken when it is to end.
    ask: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

/// What a picture cost.
#[derive(Clone, Copy, Default)]
pub(crate) struct Cost {
    pub(crate) times: Times,
    pub(crate) triangles: u64,
    pub(crate) draws: u64,
}

impl Peer {
    /// Starts this program once more, to draw with so many cores of `all`.
    pub(crate) fn start(arguments: &[OsString], cores: usize, all: usize) -> Result<Peer> {
        let mut command = Command::new(std::env::current_exe()?);
        command
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        if cores == 1 {
            command.env(DRIVER_THREADS, "0");
        } else {
            anyhow::ensure!(cores == all, "the driver takes one core or all");
            command.env_remove(DRIVER_THREADS);
        }
        // Without it the driver complains; there is no window that it would be needed for.
        if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
            command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
        }
        let mut process = command.spawn()?;
        let ask = process.stdin.take();
        let mut answers = BufReader::new(process.stdout.take().context("a pipe")?);
        let mut driver = String::new();
        answers.read_line(&mut driver)?;
        anyhow::ensure!(
            !driver.is_empty(),
            "nothing can be drawn with the software driver: see above"
        );
        Ok(Peer {
            cores,
            driver: driver.trim().to_owned(),
            process,
            ask,
            answers,
        })
    }

    /// Draws a view.
    pub(crate) fn draw(&mut self, what: What, view: usize) -> Result<Cost> {
        self.say(&format!("draw {} {view}", what.name()))?;
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        let mut numbers = line.split_whitespace();
        let mut next = || numbers.next().context("the drawing process has stopped");
        Ok(Cost {
            times: [next()?.parse()?, next()?.parse()?],
            triangles: next()?.parse()?,
            draws: next()?.parse()?,
        })
    }

    /// What was drawn last.
    pub(crate) fn picture(&mut self, size: [u32; 2]) -> Result<Picture> {
        self.say("picture")?;
        let mut bytes = vec![0; 3 * size[0] as usize * size[1] as usize];
        self.answers.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    fn say(&mut self, line: &str) -> Result<()> {
        let ask = self.ask.as_mut().context("it was told to end")?;
        writeln!(ask, "{line}")?;
        Ok(ask.flush()?)
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // It ends when nobody can ask any more.
        self.ask = None;
        // If it ended badly it has said so itself.
        let _ = self.process.wait();
    }
}
